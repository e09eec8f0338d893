"""Jobs that give logs another trajectory: one at a time, owners in rotation, each kept until it is done.

A :class:`JobKind` says what is done: SLAM, or localization in a map. All methods run on the event loop; what is
computed runs in a worker process.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, TypeVar

from mapper.core.errors import LimitError
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from server.jobs.following import followed
from server.jobs.leases import Leases
from server.jobs.process import WorkerJob
from server.jobs.workers import Worker
from server.library.packs.log import write_pack
from server.library.processing.job_queue import JobQueue, QueueKind, Running
from server.library.processing.pose_job_kind import JobKind, JobLimits, Logs, Progress
from server.library.processing.pose_job_record import PoseJobRecord
from server.library.store.database import Database
from server.storage import StorageError, private_folder

MOST_OF_OWNER = 3  #: unfinished jobs of one visitor
MOST = 50  #: of all visitors

P = TypeVar("P", bound=Progress)
T = TypeVar("T")
Listener = Callable[[P | None], None]
"""Called with the newest report, and with None once the job has ended."""


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
        self._logs = logs
        self._make_worker = worker
        self._worker: Worker | None = None
        self._folder = folder
        self._kind = kind
        self._limits = limits or JobLimits()
        queue = QueueKind(kind.name, kind.title, kind.table, PoseJobRecord)
        self._queue: JobQueue[PoseJobRecord, P] = JobQueue(database, leases, logs.get, queue, self._made)
        self.follow = self._queue.follow
        self.forget_log = self._queue.forget_log

    async def start(self) -> None:
        """Load the records, and begin again what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        await self._queue.start()

    async def close(self) -> None:
        """End the running job, which the next start begins again."""
        await self._queue.close()
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
        mapping: dict[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Queue a job on a log, and return its state; one that is queued or running goes on.

        ``cut`` says how its scans are cut out of clouds and depth images, None as by default; ``mapping`` are
        parameters of the map that the poses are for, whose mount and time offset the job uses.

        Raises :class:`LimitError` for one job too many, :class:`mapper.core.errors.ConfigError` for a parameter that
        is refused and for an invalid cut, and as the library for a log that the owner may not open.
        """
        kind = self._kind
        checked = await asyncio.to_thread(kind.checked, parameters or {})
        PlanarCut.of(cut or {})
        MappingConfig().with_values(mapping or {})
        self._logs.get(owner, log_id)
        if (owner, log_id) not in self._queue.running:
            if sum(one == owner for one, _ in self._queue.running) >= MOST_OF_OWNER:
                message = (
                    f"You have {MOST_OF_OWNER} {kind.title} jobs under way, the most there can be: wait, or cancel one."
                )
                raise LimitError(f"{kind.name}.too_many", message)
            if len(self._queue.running) >= MOST:
                raise LimitError(f"{kind.name}.busy", f"Too many {kind.title} jobs are under way; try again later.")
            record = PoseJobRecord(
                log_id=log_id, owner=owner, topic=topic, trajectory=trajectory, state="queued", created_s=time.time(),
                parameters=checked, cut=cut, mapping=mapping,
            )  # fmt: skip
            await self._queue.begin([record])
        return self.state(owner, log_id)

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest job; its state is "none" where there was none."""
        self._logs.get(owner, log_id)
        key = (owner, log_id)
        record = self._queue.records.get(key) or PoseJobRecord(log_id=log_id, owner=owner)
        running = self._queue.running.get(key)
        newest = None if running is None else running.newest
        return record.public() | self._queue.under_way(key) | self._kind.shown(newest)

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a job, if it is queued or running; return its state."""
        self.state(owner, log_id)
        await self._queue.stop((owner, log_id))
        return self.state(owner, log_id)

    def listen(self, owner: str, log_id: str, listener: Listener[P]) -> Callable[[], None]:
        """Tell ``listener`` of a job that is queued or runs, and return a function that ends that.

        Where there is none it is told the end at once.
        """
        return self._queue.listen((owner, log_id), listener)

    # -- the job --------------------------------------------------------------------------------------------------

    async def _made(self, record: PoseJobRecord, running: Running[P]) -> dict[str, Any]:
        """Do the job in the worker process, add the trajectory, and return what is shown of the result."""
        owner, log_id, kind = record.owner, record.log_id, self._kind
        log = await self._logs.load(owner, log_id, record.topic, PlanarCut.of(record.cut or {}))
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

    async def _followed(self, job: WorkerJob[T], out: Path, running: Running[P]) -> T:
        """Wait for the job in its process, and tell the listeners how far it is."""
        worker = self._worker = self._worker or self._make_worker()

        async def look() -> None:
            newest = await asyncio.to_thread(self._kind.read_progress, out)
            if newest is not None and (running.newest is None or newest.fraction != running.newest.fraction):
                running.tell(newest, newest.fraction)

        return await followed(worker, job, look, f"{self._kind.name}.died")


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
