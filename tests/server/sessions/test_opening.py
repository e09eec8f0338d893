"""The opening of a log shows what it waits for, and ends when nobody waits for it."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from mapper.sensors.scan import ScanLog
from server.library.library import Library
from server.library.logs.sample import SAMPLE_ID
from server.sessions import SessionRegistry
from server.sources.log_kind import LOG, NewLog
from tests.server.service import eventually, settings_for


async def test_opening_a_log_shows_what_it_waits_for(
    registry: SessionRegistry, office_log: ScanLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = Library(settings_for(tmp_path))
    await library.start()
    read = asyncio.Event()
    states: list[tuple[str, float | None]] = [("Waiting until other logs are read", None), ("Reading the log", 0.4)]

    async def load(*_: Any) -> ScanLog:
        await read.wait()
        return office_log

    monkeypatch.setattr(library, "load", load)
    monkeypatch.setattr(library, "opening", lambda log_id: states[0])
    wanted = NewLog.model_validate({"kind": "log", "log": SAMPLE_ID, "name": "mine"})
    creating = asyncio.ensure_future(registry.create(LOG, wanted, "me", library))
    await eventually(lambda: not registry.under_way.is_empty)
    making = registry.under_way.get("me", "mine")
    assert making is not None
    await eventually(lambda: making.progress() == states[0])
    del states[0]
    assert making.progress() == ("Reading the log", 0.4)
    read.set()
    session = await creating
    assert making.progress() == ("Preparing the map", None)
    assert not making.is_wanted
    assert registry.under_way.get("me", "mine") is None
    assert session.model.progress == (0, office_log.n_scans)

    read.clear()
    creating = asyncio.ensure_future(registry.create(LOG, wanted, "me", library))
    await eventually(lambda: not registry.under_way.is_empty)
    creating.cancel()
    with pytest.raises(asyncio.CancelledError):
        await creating
    assert registry.under_way.is_empty
    await library.close()


async def test_the_library_says_what_a_log_waits_for(tmp_path: Path) -> None:
    """A log that is read tells its share; the record tells since when."""
    library = Library(settings_for(tmp_path))
    await library.start()
    assert library.opening(SAMPLE_ID) == ("Loading the log", None)
    held = library._readers.small.turn("somebody")  # another log is being read
    async with held:
        record = await library.put("me", "run.log", _pieces(b"FLASER 1 1.0 0 0 0 0 0 0 0 h 0\n" * 50), None)
        assert record is not None
        assert library.opening(record.id) == ("Waiting until other logs are read", None)
        assert library.get("me", record.id).reading_s is None
    await eventually(lambda: library.get("me", record.id).state in ("reading", "ready"))
    if library.get("me", record.id).state == "reading":
        what, share = library.opening(record.id)
        assert what == "Reading the log"
        assert share is not None
        assert 0.0 <= share <= 1.0
    await eventually(lambda: library.get("me", record.id).state == "ready")
    assert library.get("me", record.id).reading_s is None
    await library.close()


async def _pieces(data: bytes) -> Any:
    yield data
