"""Helpers of tests of a library: its files, and a log's record after reading."""

from __future__ import annotations

from server.library.library import Library
from server.library.logs.records import Record
from server.settings import Settings
from tests.server.service import eventually


def files(settings: Settings) -> list[str]:
    """Every file below the data folder, by path, without the database."""
    found = sorted(str(p.relative_to(settings.data_dir)) for p in settings.data_dir.rglob("*") if p.is_file())
    return [name for name in found if not name.startswith("library/library.db")]


async def settled(library: Library, owner: str, log_id: str) -> Record:
    """The record once its job has ended."""
    await eventually(lambda: library.get(owner, log_id).state not in ("queued", "reading"))
    return library.get(owner, log_id)
