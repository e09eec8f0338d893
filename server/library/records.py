"""What is known of each log, and where that is kept: one small JSON file per log.

:class:`Records` is all that the library asks of a store, so that a database can take the place of the files.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, Protocol

from mapper.logs.summary import LogSummary, ReadingCounts, TimeSummary, TrajectorySummary
from server.library.packed import topic_from_json

Source = Literal["upload", "folder", "sample"]
State = Literal["queued", "reading", "ready", "failed"]


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a log could not be read: a stable code and one sentence."""

    code: str
    message: str


@dataclass(frozen=True, slots=True)
class Record:
    """One log. ``owner`` is the visitor who uploaded it, empty for the logs that everybody sees.

    ``sha256`` names the stored bytes (uploads only); ``progress`` goes from 0 to 1 while the log is read;
    ``summary`` is None until it was. The sample is ``ready`` before that: it is made when somebody asks for it.
    """

    id: str
    owner: str
    name: str
    source: Source
    state: State
    bytes: int
    sha256: str = ""
    created_s: float = 0.0
    used_s: float = 0.0  #: when it was last uploaded or opened, to the day
    progress: float = 0.0
    error: Failure | None = None
    summary: LogSummary | None = field(default=None, repr=False)

    @property
    def stored_bytes(self) -> int:
        """Bytes on the disk: what was uploaded, and its readings once read, which may be a thousand times that."""
        return self.bytes + (0 if self.summary is None else 4 * self.summary.scans * self.summary.beams)

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows: no owner, no digest, no path."""
        summary = self.summary
        return {
            "id": self.id,
            "name": self.name,
            "source": self.source,
            "state": self.state,
            "bytes": self.bytes,
            "progress": round(self.progress, 3),
            "error": None if self.error is None else asdict(self.error),
            "scans": summary.scans if summary else None,
            "beams": summary.beams if summary else None,
            "duration_s": summary.duration_s if summary else None,
            "format": summary.format if summary else None,
            "time": asdict(summary.time) if summary and summary.time else None,
            "mount": list(summary.mount) if summary else None,
            "upside_down": summary.upside_down if summary else False,
            "trajectories": [asdict(trajectory) for trajectory in summary.trajectories] if summary else [],
            "topics": [asdict(topic) for topic in summary.topics] if summary else [],
            "notes": list(summary.notes) if summary else [],
        }


class Records(Protocol):
    """A store of the records of logs."""

    def load(self) -> Iterable[Record]:
        """Return every record that can be read."""

    def put(self, record: Record) -> None:
        """Keep ``record`` in the place of any older one with its id, wholly or not at all."""

    def delete(self, record_id: str) -> None:
        """Forget a record; one that is not there is no error."""


class JsonRecords:
    """:class:`Records` as files ``{id}.json`` in a folder, each replaced atomically."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def load(self) -> list[Record]:
        """Return the records, oldest first; files that are no records are left alone and left out."""
        found = []
        for path in self._folder.glob("*.json"):
            try:
                record = _from_json(json.loads(path.read_text(encoding="utf-8")))
            except (OSError, ValueError, TypeError, KeyError):
                continue
            if record.id == path.stem:
                found.append(record)
        return sorted(found, key=lambda record: record.created_s)

    def put(self, record: Record) -> None:
        """Write the record beside its place and move it there."""
        path = self._folder / f"{record.id}.json"
        fresh = path.with_suffix(".new")
        fresh.write_text(json.dumps(asdict(record), ensure_ascii=False, indent=1), encoding="utf-8")
        fresh.replace(path)

    def delete(self, record_id: str) -> None:
        """Remove the record's file."""
        (self._folder / f"{record_id}.json").unlink(missing_ok=True)


def _from_json(data: dict[str, Any]) -> Record:
    """Return the record that ``asdict`` made ``data`` of; keys that a newer version added are dropped."""
    values = {f.name: data[f.name] for f in fields(Record) if f.name in data}
    if values.get("error") is not None:
        values["error"] = Failure(**values["error"])
    values["summary"] = _summary(values.get("summary"))
    return Record(**values)


def _summary(data: dict[str, Any] | None) -> LogSummary | None:
    """Return the summary that ``asdict`` made ``data`` of; None for one of another version: it can be made again."""
    try:
        values = dict(data or {})
        values["readings"] = ReadingCounts(**values["readings"])
        values["trajectories"] = tuple(TrajectorySummary(**one) for one in values["trajectories"])
        values["mount"] = tuple(values["mount"])
        values["notes"] = tuple(values["notes"])
        if values.get("time") is not None:
            values["time"] = TimeSummary(**values["time"])
        values["topics"] = tuple(topic_from_json(one) for one in values.get("topics", ()))
        return LogSummary(**values)
    except (TypeError, KeyError):
        return None
