"""What recordings hold: not found out again and again where it is stored as another version does it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from mapper.core.errors import ReadError
from mapper.io.contents.model import Contents
from server.jobs.process import JobLimits
from server.library.packs import contents as packs
from server.library.processing.inspections import Inspections, InspectJob

NOTHING = Contents(topics=())


class Catalogue:
    """One recording, whose contents are beside it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @asynccontextmanager
    async def source(self, record: Any) -> AsyncIterator[Path]:
        yield self.folder / record.name

    def contents(self, log_id: str) -> Path:
        return self.folder / f"{log_id}.npz"


async def known(inspections: Inspections) -> Contents:
    """Return the contents of the recording once they are known; ask twice at most after they were found out."""
    record: Any = SimpleNamespace(id="run", name="run.mcap")
    for _ in range(20):
        found = await inspections.contents(record, "visitor")
        if isinstance(found, Contents):
            return found
        await asyncio.sleep(0)
    raise AssertionError("The contents are being found out again and again.")


@pytest.mark.parametrize("ahead", [0, 1])
def test_processes_of_a_later_version_than_the_service_are_named(
    ahead: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = packs.VERSION

    async def inspect(_: Any, job: InspectJob) -> None:
        packs.VERSION = here + ahead
        try:
            packs.write_contents(NOTHING, Path(job.target))
        finally:
            packs.VERSION = here

    monkeypatch.setattr("server.library.processing.recording_worker.outcome_of", inspect)

    async def ask() -> Contents:
        inspections = Inspections(Catalogue(tmp_path), JobLimits(60.0, 60.0, 1 << 30))  # type: ignore[arg-type] # a stand-in
        try:
            return await known(inspections)
        finally:
            await inspections.close()

    if ahead == 0:
        assert asyncio.run(ask()) == NOTHING
        return
    with pytest.raises(ReadError) as refused:
        asyncio.run(ask())
    assert refused.value.code == "log.other_version"
    assert "restart the service" in refused.value.message
