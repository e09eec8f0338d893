"""Finds out what recordings hold, each once and in a process with limits, and keeps it beside the log's pack.

It has a process of its own: to look into a log does not wait for the reading of another one.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mapper.core.errors import MapperError
from mapper.io.contents.model import Contents
from server.jobs import process
from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob
from server.jobs.workers import PoolWorker
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.packs.contents import StaleContentsError, read_contents, write_contents
from server.library.processing.reading_jobs import unstored, without_paths
from server.work.fair_lock import FairLock

IDLE_S = 20.0  #: an inspection without a request for this time ends
MOST_KEPT = 4  #: contents that are kept in memory


@dataclass(frozen=True, slots=True)
class InspectJob(BoundedJob):
    """Find out what the recording ``source`` holds, and write it to ``target``."""

    source: str
    target: str
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[InspectJob], None]:
        """The function that does it."""
        return inspect_job


def inspect_job(job: InspectJob) -> None:
    """Do the job. Raises :class:`ReadError` or :class:`LimitError`, which cross to the server with their codes."""
    job.bounded(lambda: _inspect(job))


def _inspect(job: InspectJob) -> None:
    from mapper.io.contents.inspection import inspect  # noqa: PLC0415 - only the process that reads needs the readers

    contents = inspect(Path(job.source), progress=process.note_progress)
    try:
        write_contents(contents, Path(job.target))
    except OSError:
        raise unstored() from None


@dataclass(slots=True)
class _Running:
    task: asyncio.Task[None]
    timer: asyncio.TimerHandle
    visitor: str  #: who began it


class Inspections:
    """The contents of the catalogue's logs. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, *, timeout_s: float, cpu_s: float, memory_bytes: int) -> None:
        self._catalogue = catalogue
        self._timeout_s = timeout_s
        self._cpu_s = cpu_s
        self._memory_bytes = memory_bytes
        self._worker = PoolWorker(memory_bytes)
        self._turns = FairLock()
        self._running: dict[str, _Running] = {}
        self._inspected = ""  #: the log whose turn it is
        self._kept: dict[str, Contents] = {}

    async def contents(self, record: Record, visitor: str, *, address: str = "") -> Contents | float:
        """Return what a log's recording holds; where that is not known yet begin to find out, and return how far it is.

        The inspection ends when no request waits for it. Raises what it raised, once.
        """
        running = self._running.get(record.id)
        if running is None:
            kept = self._kept.get(record.id)
            if kept is None:
                try:
                    kept = await asyncio.to_thread(read_contents, self._catalogue.contents(record.id))
                except StaleContentsError:
                    return self._begin(record, visitor, address)
                self._keep(record.id, kept)
            return kept
        if running.task.done():
            del self._running[record.id]
            running.timer.cancel()
            if not running.task.cancelled():
                running.task.result()
            return await self.contents(record, visitor, address=address)
        running.timer.cancel()
        running.timer = self._timer(running.task)
        return self._worker.progress if self._inspected == record.id else 0.0

    def cancel(self, log_id: str, visitor: str) -> None:
        """End the inspection of a log that ``visitor`` began, if it is under way; the next request begins it again.

        Another visitor's goes on: it ends when no request waits for it.
        """
        running = self._running.get(log_id)
        if running is not None and running.visitor == visitor:
            del self._running[log_id]
            running.timer.cancel()
            running.task.cancel()

    def _begin(self, record: Record, visitor: str, address: str) -> float:
        if record.id not in self._running:
            task = asyncio.create_task(self._inspect(record, visitor, address))
            task.add_done_callback(lambda done: done.cancelled() or done.exception())
            self._running[record.id] = _Running(task, self._timer(task), visitor)
        return 0.0

    def _timer(self, task: asyncio.Task[None]) -> asyncio.TimerHandle:
        return asyncio.get_running_loop().call_later(IDLE_S, task.cancel)

    def _keep(self, log_id: str, contents: Contents) -> None:
        while len(self._kept) >= MOST_KEPT:
            del self._kept[next(iter(self._kept))]
        self._kept[log_id] = contents

    async def _inspect(self, record: Record, visitor: str, address: str) -> None:
        async with self._turns.of(visitor, address), self._catalogue.source(record) as source:
            self._inspected = record.id
            job = InspectJob(
                str(source), str(self._catalogue.contents(record.id)), self._timeout_s, self._cpu_s, self._memory_bytes
            )
            try:
                await outcome_of(self._worker, job)
            except MapperError as error:
                raise without_paths(error, source, record.name) from None
            finally:
                self._inspected = ""

    async def close(self) -> None:
        """End what runs, and the process."""
        for running in self._running.values():
            running.timer.cancel()
            running.task.cancel()
        await asyncio.gather(*(one.task for one in self._running.values()), return_exceptions=True)
        await asyncio.to_thread(self._worker.close)
