"""The record of a log, its displayed name, and the interface of the store of records."""

from __future__ import annotations

import unicodedata
from collections.abc import Awaitable, Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import msgspec

from mapper.core.errors import MapperError
from mapper.io.logs.summary import LogSummary, MapSummary, TimeSummary
from mapper.sensors.scan import Topic
from server.jobs.record import Failure

Source = Literal["upload", "folder", "sample"]
State = Literal["queued", "reading", "ready", "failed"]
MAX_NAME = 120  #: characters of a name on the page


@dataclass(frozen=True, slots=True)
class TrajectoryAnswer:
    """A trajectory of a log: its own (``source`` is "log"), or one that the visitor has added.

    ``created_s`` is when it was added, seconds since 1970; ``has_graph`` says whether its pose graph is stored.
    """

    name: str
    description: str
    length_m: float
    source: Literal["log", "tum", "slam", "localized"] = "log"
    created_s: float | None = None
    has_graph: bool = False


@dataclass(frozen=True, slots=True)
class LogAnswer:
    """A log in the HTTP interface. Facts are null until the log has been read.

    ``reading_s`` are seconds since its reading began, null while it is not being read; ``tags`` are the visitor's own.
    ``costmaps`` is their number in a recording without scans, ``clouds`` the number of 3D scans in a file without
    planar ones (an octree counts as one) and ``points`` the number of their points, or of leaves of the octree.
    ``topics`` are the streams of messages in the file, its sensors first.
    """

    id: str
    name: str
    source: Source
    state: State
    bytes: int
    progress: float
    reading_s: float | None
    error: Failure | None
    has_picture: bool
    tags: tuple[str, ...]
    scans: int | None
    costmaps: int
    clouds: int
    points: int
    map: MapSummary | None
    beams: int | None
    duration_s: float | None
    format: str | None
    time: TimeSummary | None
    mount: tuple[float, float, float] | None
    upside_down: bool
    trajectories: tuple[TrajectoryAnswer, ...]
    topics: tuple[Topic, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Record:
    """One log. ``owner`` is the visitor who uploaded it, empty for the logs that all visitors see.

    ``sha256`` names the stored bytes (uploads only); ``progress`` increases from 0 to 1 while the log is read;
    ``summary`` is None before that; ``attempts`` is the number of readings that started and did not finish;
    ``has_picture`` says whether there is a picture of its map. The sample is ``ready`` from the start, because it is
    created on first use.
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
    reading_s: float | None = None  #: seconds since its reading began, None while it is not being read
    error: Failure | None = None
    attempts: int = 0
    summary: LogSummary | None = field(default=None, repr=False)
    has_picture: bool = False
    tags: tuple[str, ...] = ()  #: those of the requesting visitor
    added: tuple[TrajectoryAnswer, ...] = field(default=(), repr=False)  #: trajectories added by the requesting visitor

    @property
    def packed_bytes(self) -> int:
        """Bytes on the disk of the data read from it, which may be a thousand times the upload."""
        if self.summary is None:
            return 0
        map_ = self.summary.map
        scans = 4 * self.summary.scans * self.summary.beams
        return scans + 16 * self.summary.points + (0 if map_ is None else map_.rows * map_.cols)

    def public(self) -> LogAnswer:
        """Return the answer of the HTTP interface, without owner, digest and path."""
        summary = self.summary
        own = summary.trajectories if summary else ()
        return LogAnswer(
            id=self.id,
            name=self.name,
            source=self.source,
            state=self.state,
            bytes=self.bytes,
            progress=round(self.progress, 3),
            reading_s=None if self.reading_s is None else round(self.reading_s, 1),
            error=self.error,
            has_picture=self.has_picture,
            tags=self.tags,
            scans=summary.scans if summary else None,
            costmaps=summary.costmaps if summary else 0,
            clouds=summary.clouds if summary else 0,
            points=summary.points if summary else 0,
            map=summary.map if summary else None,
            beams=summary.beams if summary else None,
            duration_s=summary.duration_s if summary else None,
            format=summary.format if summary else None,
            time=summary.time if summary else None,
            mount=summary.mount if summary else None,
            upside_down=summary.upside_down if summary else False,
            trajectories=(
                *(TrajectoryAnswer(trajectory.name, trajectory.description, trajectory.length_m) for trajectory in own),
                *self.added,
            ),
            topics=summary.topics if summary else (),
            notes=summary.notes if summary else (),
        )


class Records(Protocol):
    """A store of the records of logs. Calls are carried out in order.

    All methods raise :class:`server.storage.StorageError`.
    """

    def load(self) -> Awaitable[Sequence[Record]]:
        """Return every record, oldest first."""

    def put(self, record: Record) -> Awaitable[None]:
        """Store ``record``, replacing any older one with its id, completely or not at all."""

    def mark_used(self, record: Record) -> Awaitable[None]:
        """Store the time at which a log was used, and nothing else of its record."""

    def get(self, record_ids: Collection[str]) -> Awaitable[Sequence[Record]]:
        """Return the existing records with these ids."""

    def change(self, record: Record) -> Awaitable[None]:
        """Run :meth:`writing` in a transaction, because a reading may end while its log is being deleted."""

    def writing(self, record: Record) -> Callable[[Any], None]:
        """Return a function that writes a record in a transaction, unless it is that of a deleted upload."""

    def is_stored(self, sha256: str) -> Awaitable[bool]:
        """Return whether any record has these bytes."""

    def delete(self, record_id: str) -> Awaitable[None]:
        """Delete a record. A missing one is no error."""


def summary_from_json(data: object) -> LogSummary | None:
    """Return the summary from which ``asdict`` made ``data``; None if fields are missing, as it can be recomputed."""
    try:
        return msgspec.convert(data, LogSummary)
    except msgspec.ValidationError:
        return None


def display_name(name: str) -> str:
    """Return ``name`` for display: its last path component, on one line, at most :data:`MAX_NAME` characters.

    Control, format and surrogate characters are removed (a right-to-left override can make ``gnp.exe`` look like
    ``exe.png``); an empty result becomes "log". It is never used as a path.
    """
    last = name.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1]
    printable = "".join(" " if c.isspace() else c for c in last if c.isspace() or unicodedata.category(c)[0] != "C")
    clean = " ".join(printable.split()).strip(". ")
    if len(clean) > MAX_NAME:
        clean = clean[: MAX_NAME - 1].rstrip() + "…"
    return clean or "log"


class LogNotFoundError(MapperError):
    """There is no such log for this visitor: it never existed, was deleted, or belongs to another visitor."""


class LogReadOnlyError(MapperError):
    """The visitor is not allowed to delete the log."""
