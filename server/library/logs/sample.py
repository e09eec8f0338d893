"""The built-in sample log: a simulated run, created on first use."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import replace
from pathlib import Path

import structlog

from mapper import simulation
from mapper.io.logs.summary import summarise
from mapper.sensors.scan import ScanLog
from server.imports import imported
from server.library.logs.cache import LogCache
from server.library.logs.records import Record

SAMPLE_ID = "sample-office"
SAMPLE_NAME = "A simulated office (sample)"

_log = structlog.get_logger(__name__)


class Sample:
    """The sample and its record. The log is kept in ``cache`` like the others, and its map is drawn into ``picture``.

    Used from the event loop.
    """

    def __init__(self, cache: LogCache, picture: Path) -> None:
        self._cache = cache
        self._picture = picture
        self.record = Record(SAMPLE_ID, "", SAMPLE_NAME, "sample", "ready", 0)
        self._job: asyncio.Task[ScanLog] | None = None

    def begin(self) -> None:
        """Start creating the sample, unless its summary is known or it is being created."""
        if self.record.summary is None and self._job is None:
            self._job = asyncio.create_task(self._make())
            self._job.add_done_callback(_note_failure)

    async def load(self) -> ScanLog:
        """Return the sample. It is created again if the cache has dropped it."""
        log = self._cache.get(SAMPLE_ID)
        if log is not None:
            return log
        if self._job is None:
            self._job = asyncio.create_task(self._make())
        return await asyncio.shield(self._job)

    async def _make(self) -> ScanLog:
        await imported("mapper.simulation.sample", "server.library.packs.picture")
        from server.library.packs.picture import write_picture  # noqa: PLC0415 - Pillow and the replay of logs

        try:
            log = replace(await asyncio.to_thread(simulation.sample_log), name=SAMPLE_NAME)
        finally:
            self._job = None
        self._cache.put(SAMPLE_ID, log)
        with contextlib.suppress(OSError):  # a full disk
            await asyncio.to_thread(write_picture, log, self._picture)
        self.record = replace(self.record, summary=summarise(log), bytes=int(log.ranges.nbytes))
        return log

    async def close(self) -> None:
        """Cancel the running work."""
        if self._job is not None:
            self._job.cancel()
            await asyncio.gather(self._job, return_exceptions=True)


def _note_failure(job: asyncio.Task[ScanLog]) -> None:
    """Log why the sample was not created. The next request for the logs starts it again."""
    if job.cancelled() or (error := job.exception()) is None:
        return
    if isinstance(error, MemoryError | OSError):  # no memory, or no disk space
        _log.warning("sample not made", reason=str(error))
    else:
        _log.error("sample not made", exc_info=error)
