"""Reads data from recordings in a process with limits: one at a time, with progress, cached in memory."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from server.jobs.process import BoundedJob
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.reading_jobs import unreadable
from server.library.processing.recording_worker import RecordingWorker

T = TypeVar("T")

IDLE_S = 20.0  #: a job that no request asks for during this time ends
MOST_KEPT = 4  #: number of results cached in memory


@dataclass(slots=True)
class _Running(Generic[T]):
    task: asyncio.Task[T | None]
    timer: asyncio.TimerHandle
    visitor: str  #: the one who started it


class Lookups(Generic[T]):
    """Results of jobs on the recordings of a catalogue, by key. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, memory_bytes: int) -> None:
        self._worker = RecordingWorker(catalogue, memory_bytes)
        self._running: dict[str, _Running[T]] = {}
        self._at_work = ""  #: the key being processed
        self._kept: dict[str, T] = {}

    async def look_up(
        self,
        key: str,
        record: Record,
        visitor: str,
        address: str,
        job: Callable[[str], BoundedJob[T | None]],
        stored: Callable[[], Awaitable[T | None]] | None = None,
    ) -> T | float:
        """Return the result for a key; if it is unknown, start computing it, and return the completed share.

        ``job`` creates the job from the recording's path. ``stored`` returns an earlier result, or None; a job that
        stores its result returns None too. The job ends when no request asks for it. Raises its error, once, and
        :class:`ReadError` if the stored result cannot be read here.
        """
        running = self._running.get(key)
        if running is None:
            value = self._kept.get(key)
            if value is None and stored is not None:
                value = await stored()
            if value is None:
                return self._begin(key, record, visitor, address, job)
            self._keep(key, value)
            return value
        if running.task.done():
            del self._running[key]
            running.timer.cancel()
            if running.task.cancelled():
                return await self.look_up(key, record, visitor, address, job, stored)
            result = running.task.result()
            if result is None and stored is not None:
                result = await stored()
            if result is None:  # not begun again: it would be stored in the same way
                raise unreadable()
            self._keep(key, result)
            return result
        running.timer.cancel()
        running.timer = self._timer(running.task)
        return self._worker.progress if self._at_work == key else 0.0

    def cancel(self, key: str, visitor: str) -> None:
        """End the running job that ``visitor`` started; the next request starts it again.

        Another visitor's job continues until no request asks for it.
        """
        running = self._running.get(key)
        if running is not None and running.visitor == visitor:
            del self._running[key]
            running.timer.cancel()
            running.task.cancel()

    def _begin(
        self, key: str, record: Record, visitor: str, address: str, job: Callable[[str], BoundedJob[T | None]]
    ) -> float:
        if key not in self._running:
            task = asyncio.create_task(self._look_up(key, record, visitor, address, job))
            task.add_done_callback(lambda done: done.cancelled() or done.exception())
            self._running[key] = _Running(task, self._timer(task), visitor)
        return 0.0

    def _timer(self, task: asyncio.Task[T | None]) -> asyncio.TimerHandle:
        return asyncio.get_running_loop().call_later(IDLE_S, task.cancel)

    def _keep(self, key: str, value: T) -> None:
        self._kept.pop(key, None)
        while len(self._kept) >= MOST_KEPT:
            del self._kept[next(iter(self._kept))]
        self._kept[key] = value

    async def _look_up(
        self, key: str, record: Record, visitor: str, address: str, job: Callable[[str], BoundedJob[T | None]]
    ) -> T | None:
        def begun(source: str) -> BoundedJob[T | None]:
            self._at_work = key
            return job(source)

        try:
            return await self._worker.done(record, visitor, address, begun)
        finally:
            if self._at_work == key:
                self._at_work = ""

    async def close(self) -> None:
        """End running jobs, and the process."""
        for running in self._running.values():
            running.timer.cancel()
            running.task.cancel()
        await asyncio.gather(*(lookup.task for lookup in self._running.values()), return_exceptions=True)
        await self._worker.close()
