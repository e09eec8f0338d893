"""Jobs that give logs another trajectory: one at a time, owners in rotation, each kept until it is done.

A :class:`JobKind` says what is done: SLAM, or localization in a map. A job that the end of the service interrupts is
begun again at the next start. All methods run on the event loop; what is computed runs in a worker process.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import structlog

from mapper.core.errors import LimitError, MapperError
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from server.library.database import Database
from server.library.following import followed
from server.library.job import WorkerJob
from server.library.job_record import load_job_records, put_job_record
from server.library.leases import Lease, Leases, Once
from server.library.log_pack import write_pack
from server.library.pose_job_kind import JobKind, JobLimits, Logs, Progress
from server.library.pose_job_record import PoseJobRecord
from server.library.records import Failure
from server.library.storage import StorageError, private_folder
from server.library.workers import Worker
from server.work.fair_lock import FairLock

MOST_OF_OWNER = 3  #: unfinished jobs of one visitor
MOST = 50  #: of all visitors
MOST_ATTEMPTS = 2  #: runs of one job that the end of the service may interrupt

_log = structlog.get_logger(__name__)


P = TypeVar("P", bound=Progress)
T = TypeVar("T")
Listener = Callable[[P | None], None]
"""Called with the newest report, and with None once the job has ended."""


@dataclass(slots=True, eq=False)
class _Running(Generic[P]):
    """A job while it is queued or runs. ``newest`` is what it has reported last."""

    task: asyncio.Task[None]
    listeners: list[Listener[P]]
    queued_at: float
    began: float | None = None
    newest: P | None = None


class PoseJobs(Generic[P, T]):
    """All jobs of one kind; ``folder`` is one for their files that worker processes see."""

    def __init__(
        self,
        database: Database,
        leases: Leases,
        logs: Logs,
        worker: Callable[[], Worker],
        folder: Path,
        kind: JobKind[P, T],
        limits: JobLimits | None = None,
    ) -> None:
        self._database = database
        self._leases = leases
        self._logs = logs
        self._make_worker = worker
        self._worker: Worker | None = None
        self._folder = folder
        self._kind = kind
        self._limits = limits or JobLimits()
        self._records: dict[tuple[str, str], PoseJobRecord] = {}  #: by owner and log
        self._running: dict[tuple[str, str], _Running[P]] = {}
        self._turns = FairLock()
        self._closing = False

    async def start(self) -> None:
        """Load the records, and begin again what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        for record in await self._load():
            self._records[record.owner, record.log_id] = record
            if record.is_unfinished and self._leases.is_shared:
                self._queue(record, adopted=True)  # another service may be at it
            elif record.is_unfinished and record.attempts < MOST_ATTEMPTS:
                self._queue(replace(record, state="queued"))
            elif record.is_unfinished:
                self._save(self._interrupted(record))

    def _name(self, key: tuple[str, str]) -> str:
        return f"{self._kind.name} {key[1]} {key[0]}"

    def _load(self) -> asyncio.Future[Sequence[PoseJobRecord]]:
        table = self._kind.table
        return self._database.run(lambda connection: load_job_records(connection, table, PoseJobRecord))

    def _interrupted(self, record: PoseJobRecord) -> PoseJobRecord:
        message = f"The service ended {record.attempts} times during this job; it is not begun again by itself."
        return replace(record, state="failed", error=Failure(f"{self._kind.name}.interrupted", message))

    async def follow(self, _: object = None) -> None:
        """Take over what other services have changed. Raises :class:`StorageError`."""
        found = {(one.owner, one.log_id): one for one in await self._load()}
        for key in [key for key in self._records if key not in found]:
            await self._stop(key)
        self._records = found
        for key, record in found.items():
            if record.is_unfinished and key not in self._running:
                self._queue(record, adopted=True)
            elif not record.is_unfinished:
                await self._stop(key)

    async def _stop(self, key: tuple[str, str]) -> None:
        running = self._running.get(key)
        if running is not None:
            running.task.cancel()
            await asyncio.wait([running.task])

    async def close(self) -> None:
        """End the running job, which the next start begins again."""
        self._closing = True
        for running in [*self._running.values()]:
            running.task.cancel()
        await asyncio.gather(*(one.task for one in self._running.values()), return_exceptions=True)
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)

    # -- asked for ------------------------------------------------------------------------------------------------

    async def begin(
        self,
        owner: str,
        log_id: str,
        topic: str | None = None,
        trajectory: str | None = None,
        parameters: dict[str, Any] | None = None,
        cut: dict[str, float] | None = None,
    ) -> dict[str, Any]:
        """Queue a job on a log, and return its state; one that is queued or running goes on.

        ``cut`` says how its scans are cut out of clouds and depth images, None as by default.

        Raises :class:`LimitError` for one job too many, :class:`mapper.core.errors.ConfigError` for a parameter that
        is refused and for a cut that is none, and as the library for a log that the owner may not open.
        """
        kind = self._kind
        checked = await asyncio.to_thread(kind.checked, parameters or {})
        PlanarCut.of(cut or {})
        log_record = self._logs.get(owner, log_id)
        key = (owner, log_id)
        if key not in self._running:
            if sum(one == owner for one, _ in self._running) >= MOST_OF_OWNER:
                message = (
                    f"You have {MOST_OF_OWNER} {kind.title} jobs under way, the most there can be: wait, or cancel one."
                )
                raise LimitError(f"{kind.name}.too_many", message)
            if len(self._running) >= MOST:
                raise LimitError(f"{kind.name}.busy", f"Too many {kind.title} jobs are under way; try again later.")
            record = PoseJobRecord(
                log_id=log_id, owner=owner, topic=topic, trajectory=trajectory, state="queued", created_s=time.time(),
                parameters=checked, cut=cut,
            )  # fmt: skip
            self._queue(record)
            try:
                await self._database.run(lambda connection: put_job_record(connection, kind.table, log_record, record))
            except StorageError:
                await self.cancel(owner, log_id)
                raise
        return self.state(owner, log_id)

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest job; its state is "none" where there was none."""
        self._logs.get(owner, log_id)
        record = self._records.get((owner, log_id)) or PoseJobRecord(log_id=log_id, owner=owner)
        running = self._running.get((owner, log_id))
        newest = None if running is None else running.newest
        began = None if running is None else running.began
        elsewhere = self._leases.elsewhere.get(self._name((owner, log_id)), 0.0)
        waiting = [one for one in self._running.values() if one.began is None]
        return record.public() | {
            "fraction": round(elsewhere if newest is None else newest.fraction, 4),
            "elapsed_s": None if began is None else round(time.monotonic() - began, 1),
            "ahead": sum(one.queued_at < running.queued_at for one in waiting) if running and began is None else 0,
            **self._kind.shown(newest),
        }

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a job, if it is queued or running; return its state."""
        self.state(owner, log_id)
        await self._stop((owner, log_id))
        return self.state(owner, log_id)

    def listen(self, owner: str, log_id: str, listener: Listener[P]) -> Callable[[], None]:
        """Tell ``listener`` of a job that is queued or runs, and return a function that ends that.

        Where there is none it is told the end at once.
        """
        running = self._running.get((owner, log_id))
        if running is None:
            listener(None)
            return lambda: None
        running.listeners.append(listener)
        if running.newest is not None:
            listener(running.newest)
        return lambda: running.listeners.remove(listener) if listener in running.listeners else None

    async def forget_log(self, log_id: str) -> None:
        """Stop the jobs of a log that was deleted, and forget them."""
        for key in [key for key in self._records if key[1] == log_id]:
            del self._records[key]
            await self._stop(key)

    # -- the job --------------------------------------------------------------------------------------------------

    def _queue(self, record: PoseJobRecord, *, adopted: bool = False) -> None:
        key = (record.owner, record.log_id)
        self._records[key] = record
        task = asyncio.create_task(self._run(record, adopted=adopted), name=self._kind.name)
        self._running[key] = _Running(task, [], time.monotonic())

    async def _run(self, record: PoseJobRecord, *, adopted: bool) -> None:
        key, kind = (record.owner, record.log_id), self._kind

        def is_open() -> bool:
            known = self._records.get(key)
            return known is not None and known.is_unfinished

        async def is_due() -> bool:
            self._records |= {(one.owner, one.log_id): one for one in await self._load() if one.log_id == key[1]}
            return is_open()

        def fraction() -> float:
            running = self._running.get(key)
            return 0.0 if running is None or running.newest is None else running.newest.fraction

        once = Once(self._name(key), lambda: self._turns.of(record.owner), is_open, is_due, fraction)
        try:
            await self._leases.done_once(once, lambda lease: self._run_here(self._records[key], lease), adopted=adopted)
        except asyncio.CancelledError:
            if not self._closing and is_open():  # else it is begun again at the next start
                self._save(replace(self._records[key], state="cancelled", attempts=0))
            raise
        except StorageError as error:  # the database of several services is away
            _log.warning("job not done now", kind=kind.name, log=key[1], code=error.code)
        finally:
            for listener in [*self._running.pop(key).listeners]:
                listener(None)

    async def _run_here(self, record: PoseJobRecord, lease: Lease) -> None:
        key, kind = (record.owner, record.log_id), self._kind
        if self._leases.is_shared and record.attempts >= MOST_ATTEMPTS:
            await self._finish(self._interrupted(record), lease)
            return
        running = self._running[key]
        running.began = time.monotonic()
        record = replace(record, state="running", attempts=record.attempts + 1)
        self._save(record)
        try:
            result = await self._made(record, running)
            done = replace(record, state="done", result=result, attempts=0)
            _log.info("job done", kind=kind.name, log=record.log_id, seconds=round(time.monotonic() - running.began, 1))
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message), attempts=0)
            _log.info("job refused", kind=kind.name, log=record.log_id, code=error.code, message=error.message)
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this job alone
            failure = Failure(f"{kind.name}.failed", f"{kind.title} failed on this log.")
            done = replace(record, state="failed", error=failure, attempts=0)
            _log.exception("job failed", kind=kind.name)
        if key in self._records:  # not deleted meanwhile
            await self._finish(done, lease)

    async def _finish(self, record: PoseJobRecord, lease: Lease) -> None:
        """Store what came of a job, and end its lease; as :meth:`_save`. Raises :class:`LeaseLostError`."""
        if not self._leases.is_shared:
            self._save(record)
            return
        log = self._logs.get(record.owner, record.log_id)
        with contextlib.suppress(StorageError):
            await lease.finish(lambda connection: put_job_record(connection, self._kind.table, log, record))
        self._records[record.owner, record.log_id] = record

    async def _made(self, record: PoseJobRecord, running: _Running[P]) -> dict[str, Any]:
        """Do the job in the worker process, add the trajectory, and return what is shown of the result."""
        owner, log_id, kind = record.owner, record.log_id, self._kind
        log = await self._logs.load(owner, log_id, record.topic, PlanarCut.of(record.cut or {}))
        kind.check(log)
        if record.trajectory is not None:
            log.trajectory(record.trajectory)
        added = {one.name for one in self._logs.trajectories.of(owner, log_id)}
        own_names = [one for one in log.trajectories if one not in added]
        folder = self._folder / secrets.token_hex(10)
        await asyncio.to_thread(private_folder, folder)
        try:
            pack, out = folder / "log.npz", folder / kind.name
            await asyncio.to_thread(packed, log, pack)
            job = await kind.job(record, pack, out, self._limits)
            outcome = await self._followed(job, out, running)
            new, shown = await kind.finished(record, outcome, out, own_names)
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
        await self._logs.trajectories.put(owner, self._logs.get(owner, log_id), log, new)
        return {"trajectory": new.name, **shown}

    async def _followed(self, job: WorkerJob[T], out: Path, running: _Running[P]) -> T:
        """Wait for the job in its process, and tell the listeners how far it is."""
        worker = self._worker = self._worker or self._make_worker()

        async def look() -> None:
            newest = await asyncio.to_thread(self._kind.read_progress, out)
            if newest is not None and (running.newest is None or newest.fraction != running.newest.fraction):
                running.newest = newest
                for listener in [*running.listeners]:
                    listener(newest)

        return await followed(worker, job, look, f"{self._kind.name}.died")

    def _save(self, record: PoseJobRecord) -> None:
        """Store a changed record; if it cannot be written, it is valid until the next start."""
        self._records[record.owner, record.log_id] = record
        with contextlib.suppress(MapperError):  # the log is gone
            log = self._logs.get(record.owner, record.log_id)
            written = self._database.run(lambda connection: put_job_record(connection, self._kind.table, log, record))
            written.add_done_callback(lambda one: None if one.cancelled() else one.exception() and None)


def emptied(folder: Path) -> None:
    """Make a private folder with nothing in it. Raises :class:`StorageError`."""
    shutil.rmtree(folder, ignore_errors=True)
    private_folder(folder)


def packed(log: ScanLog, path: Path) -> None:
    """Write a log for a worker process. Raises :class:`StorageError`."""
    try:
        write_pack(RobotLog({one.topic: one for one in sensors_of(log)}), path)
    except OSError:
        raise StorageError(
            "log.storage", "The log could not be stored for this job; the server's disk may be full."
        ) from None
