"""Import of the storage format of older versions: a JSON file for each record, and blobs named by the logs' ids."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import structlog

from server.library.blobs import BLOBS, Blobs
from server.library.records import Failure, Record, Records, summary_from_json

_log = structlog.get_logger(__name__)


async def import_legacy_records(root: Path, records: Records, blobs: Blobs) -> None:
    """Move the records and blobs in ``root`` to the present stores. If interrupted, it continues at the next start.

    Files that are not records, and records without a blob, are left alone. Raises ``StorageError``.
    """
    count = 0
    for path, record in list(_records(root / "records")):
        blob = root / BLOBS / record.id
        if record.source == "upload":
            if blob.is_file():
                await blobs.move_in(blob, record.sha256)
            elif record.sha256 not in await blobs.names():
                continue
        await records.put(record)
        path.unlink()
        count += 1
    if count:
        _log.info("records of an older version were taken over", records=count)
    with contextlib.suppress(OSError):  # not there, or not empty
        (root / "records").rmdir()


def _records(folder: Path) -> Iterator[tuple[Path, Record]]:
    for path in sorted(folder.glob("*.json")):
        try:
            record = _record(json.loads(path.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError, KeyError):
            continue
        if record.id == path.stem:
            yield path, record


def _record(data: dict[str, Any]) -> Record:
    values = {f.name: data[f.name] for f in fields(Record) if f.name in data}
    if values.get("error") is not None:
        values["error"] = Failure(**values["error"])
    values["summary"] = summary_from_json(values.get("summary"))
    return Record(**values)
