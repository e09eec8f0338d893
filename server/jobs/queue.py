"""A queue of jobs on logs that serves owners in rotation. Each job is stored until it is done.

The result of a job depends on its owner. A job interrupted by the end of the service is restarted at the next start,
and one of a killed service by another service on the same database. All methods run on the event loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import structlog

from mapper.core.errors import LimitError, MapperError
from server.jobs.leases import Lease, Leases, Once
from server.jobs.record import Failure, JobKind, JobRecord, JobRows, JobStatus
from server.storage import StorageError
from server.work.fair_lock import FairLock

MOST_ATTEMPTS = 2  #: runs of one job that the end of the service may interrupt
WRITTEN_AT_ONCE = 100  #: records in one transaction, so that other writers need not wait for thousands

_log = structlog.get_logger(__name__)

Q = TypeVar("Q")
P = TypeVar("P")
R = TypeVar("R")
Key = tuple[str, str]
"""Owner and log."""


@dataclass(slots=True, eq=False)
class Running(Generic[P]):
    """A queued or running job. ``newest`` is its last report, ``fraction`` the completed share.

    The listeners are called with the newest report, and with None once it has ended.
    """

    task: asyncio.Task[None]
    queued_at: float
    listeners: list[Callable[[P | None], None]] = field(default_factory=list)
    began: float | None = None
    newest: P | None = None
    fraction: float = 0.0

    def tell(self, newest: P, fraction: float) -> None:
        """Store a report, and pass it on."""
        self.newest, self.fraction = newest, fraction
        for listener in [*self.listeners]:
            listener(newest)


class JobQueue(Generic[Q, P, R]):
    """The jobs of one kind. ``work`` does a job and returns its result.

    ``changed`` is called for every new state of a job, and for removed jobs.
    """

    def __init__(
        self,
        rows: JobRows,
        leases: Leases,
        kind: JobKind[Q, R],
        work: Callable[[JobRecord[Q, R], Running[P]], Awaitable[R]],
        changed: Callable[[Key], None] = lambda _: None,
    ) -> None:
        self._rows, self._leases = rows, leases
        self._kind, self._work, self._changed = kind, work, changed
        self._turns = FairLock(kind.places)
        self._closing = False
        self.records: dict[Key, JobRecord[Q, R]] = {}
        self.running: dict[Key, Running[P]] = {}

    async def start(self) -> None:
        """Load the records, and restart what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        for record in await self._rows.load(self._kind):
            self._take(record)
            if record.is_unfinished and self._leases.is_shared:
                self._queue(record, adopted=True)  # another service may be doing it
            elif record.is_unfinished and record.attempts < MOST_ATTEMPTS:
                self._queue(replace(record, state="queued"))
            elif record.is_unfinished:
                self._save(self._interrupted(record))

    async def follow(self, log_ids: Collection[str] | None = None) -> None:
        """Load the changes of other services for some logs, None: for all. Raises :class:`StorageError`."""
        rows = {(job.owner, job.log_id): job for job in await self._rows.load(self._kind, log_ids)}
        known = [key for key in self.records if log_ids is None or key[1] in log_ids]
        for key in [key for key in known if key not in rows]:
            await self.forget(key)
        for key, record in rows.items():
            if self.records.get(key) != record:
                self._take(record)
            if record.is_unfinished and key not in self.running:
                self._queue(record, adopted=True)
            elif not record.is_unfinished:
                await self.stop(key)

    async def close(self) -> None:
        """End the running jobs, which the next start of the service restarts."""
        self._closing = True
        for running in [*self.running.values()]:
            running.task.cancel()
        await asyncio.gather(*(job.task for job in self.running.values()), return_exceptions=True)

    async def ask(self, owner: str, log_id: str, request: Q) -> None:
        """Queue a job on a log; if the kind ``joins`` and one is already queued or running, keep that one instead.

        Raises :class:`LimitError` for too many jobs, and :class:`StorageError`.
        """
        kind = self._kind
        if kind.joins and (owner, log_id) in self.running:
            return
        if sum(owner_ == owner for owner_, _ in self.running) >= kind.most_of_owner:
            most = kind.most_of_owner
            message = (
                f"You have a {kind.noun} under way: wait, or cancel it."
                if most == 1
                else f"You have {most} {kind.noun}s under way, the maximum: wait, or cancel one."
            )
            raise LimitError(f"{kind.name}.too_many", message)
        if len(self.running) >= kind.most:
            raise LimitError(f"{kind.name}.busy", f"Too many {kind.noun}s are under way; try again later.")
        await self.begin(
            [JobRecord(log_id=log_id, owner=owner, request=request, state="queued", created_s=time.time())]
        )

    async def begin(self, records: Sequence[JobRecord[Q, R]]) -> None:
        """Queue jobs, and return once they are stored. Raises :class:`StorageError`; then some are not queued."""
        for first in range(0, len(records), WRITTEN_AT_ONCE):
            some = records[first : first + WRITTEN_AT_ONCE]
            for record in some:
                self._queue(record)
            try:
                await self._rows.put(self._kind, some)
            except StorageError:
                for record in some:
                    await self.stop((record.owner, record.log_id))
                raise

    async def stop(self, key: Key) -> None:
        """End a job, if it is queued or running."""
        running = self.running.get(key)
        if running is not None:
            running.task.cancel()
            await asyncio.wait([running.task])

    async def stop_all(self, keys: Collection[Key]) -> None:
        """End the queued or running ones of many jobs."""
        tasks = [self.running[key].task for key in keys if key in self.running]
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)

    def resize(self, places: int) -> None:
        """Set the number of concurrent jobs to ``places``; running ones continue."""
        self._turns.resize(places)

    async def forget(self, key: Key) -> None:
        """End a job and remove it. Its row is deleted with its log."""
        if self.records.pop(key, None) is not None:
            self._changed(key)
        await self.stop(key)

    async def forget_log(self, log_id: str) -> None:
        """Remove the jobs of a deleted log."""
        for key in [key for key in self.records if key[1] == log_id]:
            await self.forget(key)

    def listen(self, key: Key, listener: Callable[[P | None], None]) -> Callable[[], None]:
        """Call ``listener`` with the reports of a queued or running job, and return a function that ends that.

        If there is no such job, the end is reported at once.
        """
        running = self.running.get(key)
        if running is None:
            listener(None)
            return lambda: None
        running.listeners.append(listener)
        if running.newest is not None:
            listener(running.newest)
        return lambda: running.listeners.remove(listener) if listener in running.listeners else None

    def record(self, key: Key) -> JobRecord[Q, R]:
        """Return the newest job of an owner on a log; its state is "none" if there was none."""
        return self.records.get(key) or JobRecord(log_id=key[1], owner=key[0], request=self._kind.request())

    def status(self, key: Key) -> JobStatus:
        """Return the state and progress of the newest job of an owner on a log."""
        record, running = self.record(key), self.running.get(key)
        began = None if running is None else running.began
        elsewhere = self._leases.elsewhere.get(self._name(key), 0.0)
        waiting = [job for job in self.running.values() if job.began is None]
        return JobStatus(
            state=record.state,
            created_s=record.created_s,
            error=record.error,
            fraction=round(elsewhere if running is None or began is None else running.fraction, 4),
            elapsed_s=None if began is None else round(time.monotonic() - began, 1),
            ahead=sum(job.queued_at < running.queued_at for job in waiting) if running and began is None else 0,
        )

    def fraction(self, key: Key) -> float:
        """Return the completed share of a job, done here or by another service."""
        running = self.running.get(key)
        return self._leases.elsewhere.get(self._name(key), 0.0) if running is None else running.fraction

    # -- job ------------------------------------------------------------------------------------------------------

    def _name(self, key: Key) -> str:
        return f"{self._kind.name} {key[1]} {key[0]}"

    def _take(self, record: JobRecord[Q, R]) -> None:
        key = (record.owner, record.log_id)
        self.records[key] = record
        self._changed(key)

    def _interrupted(self, record: JobRecord[Q, R]) -> JobRecord[Q, R]:
        message = f"The service ended {record.attempts} times during this job; it is not begun again by itself."
        return replace(record, state="failed", error=Failure(f"{self._kind.name}.interrupted", message))

    def _queue(self, record: JobRecord[Q, R], *, adopted: bool = False) -> None:
        self._take(record)
        task = asyncio.create_task(self._run(record, adopted=adopted), name=self._kind.name)
        self.running[record.owner, record.log_id] = Running(task, time.monotonic())

    async def _run(self, record: JobRecord[Q, R], *, adopted: bool) -> None:
        key, kind = (record.owner, record.log_id), self._kind

        def is_open() -> bool:
            known = self.records.get(key)
            return known is not None and known.is_unfinished

        async def is_due() -> bool:
            for row in await self._rows.load(kind, [key[1]]):
                self._take(row)
            return is_open()

        once = Once(
            self._name(key), lambda: self._turns.of(record.owner), is_open, is_due, lambda: self.running[key].fraction
        )
        try:
            await self._leases.done_once(once, lambda lease: self._run_here(self.records[key], lease), adopted=adopted)
        except asyncio.CancelledError:
            if not self._closing and is_open():  # otherwise the next start of the service restarts it
                self._save(replace(self.records[key], state="cancelled", attempts=0))
            raise
        except StorageError as error:  # the database of several services is unavailable
            _log.warning("job not done now", kind=kind.name, log=key[1], code=error.code)
        finally:
            for listener in [*self.running.pop(key).listeners]:
                listener(None)

    async def _run_here(self, record: JobRecord[Q, R], lease: Lease) -> None:
        key, kind = (record.owner, record.log_id), self._kind
        if self._leases.is_shared and record.attempts >= MOST_ATTEMPTS:
            await self._finish(self._interrupted(record), lease)
            return
        running = self.running[key]
        running.began = time.monotonic()
        record = replace(record, state="running", attempts=record.attempts + 1)
        self._save(record)
        try:
            result = await self._work(record, running)
            done = replace(record, state="done", result=result, attempts=0)
            _log.info("job done", kind=kind.name, log=record.log_id, seconds=round(time.monotonic() - running.began, 1))
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message), attempts=0)
            _log.info("job refused", kind=kind.name, log=record.log_id, code=error.code, message=error.message)
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this job alone
            failure = Failure(f"{kind.name}.failed", f"{kind.title} failed on this log.")
            done = replace(record, state="failed", error=failure, attempts=0)
            _log.exception("job failed", kind=kind.name)
        if key in self.records:  # not deleted in the meantime
            await self._finish(done, lease)

    async def _finish(self, record: JobRecord[Q, R], lease: Lease) -> None:
        """Store the result of a job, and release its lease; see :meth:`_save`. Raises :class:`LeaseLostError`."""
        if not self._leases.is_shared:
            self._save(record)
            return
        writing = self._rows.writing(self._kind, record)
        with contextlib.suppress(StorageError):
            await lease.finish(writing)
        self._take(record)

    def _save(self, record: JobRecord[Q, R]) -> None:
        """Store a changed record. If it cannot be written, it is valid until the next start."""
        self._take(record)
        with contextlib.suppress(MapperError):  # the log was deleted
            self._rows.put(self._kind, [record]).add_done_callback(
                lambda task: None if task.cancelled() else task.exception() and None
            )
