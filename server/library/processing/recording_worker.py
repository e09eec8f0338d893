"""A process with limits for jobs on recordings that a visitor waits for, one at a time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import TypeVar

from mapper.core.errors import MapperError
from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob
from server.jobs.workers import PoolWorker
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.reading_jobs import without_paths
from server.work.fair_lock import FairLock

T = TypeVar("T")


class RecordingWorker:
    """Does jobs on the recordings of a catalogue, for waiting addresses and visitors in rotation.

    Used from the event loop only. The process of a job is ended when its caller is cancelled.
    """

    def __init__(self, catalogue: Catalogue, memory_bytes: int) -> None:
        self._catalogue = catalogue
        self._worker = PoolWorker(memory_bytes)
        self._turns = FairLock()

    @property
    def progress(self) -> float:
        """Completed share of the current job, 0 to 1."""
        return self._worker.progress

    def turn(self, visitor: str, address: str) -> AbstractAsyncContextManager[None]:
        """Return the turn in which the process does a visitor's job."""
        return self._turns.of(visitor, address)

    async def done(self, record: Record, visitor: str, address: str, job: Callable[[str], BoundedJob[T]]) -> T:
        """Wait for a turn, and return the result of :meth:`of_recording`."""
        async with self.turn(visitor, address):
            return await self.of_recording(record, job)

    async def of_recording(self, record: Record, job: Callable[[str], BoundedJob[T]]) -> T:
        """Return the result of the job that ``job`` creates from the recording's path, in a turn. Raises its errors."""
        async with self._catalogue.source(record) as source:
            try:
                return await self.of(job(str(source)))
            except MapperError as error:
                raise without_paths(error, source, record.name) from None

    async def of(self, job: BoundedJob[T]) -> T:
        """Return the result of a job, in a turn. Raises its errors."""
        return await outcome_of(self._worker, job)

    async def close(self) -> None:
        """End the process."""
        await asyncio.to_thread(self._worker.close)
