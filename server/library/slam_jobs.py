"""The jobs that correct the poses of logs with SLAM: one at a time, owners in rotation, each kept until it is done.

What a job has made is one more trajectory of the log, with its pose graph. A job that the end of the service interrupts
is begun again at the next start. All methods run on the event loop; SLAM runs in a worker process.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import secrets
import shutil
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import structlog

from mapper.core.errors import LimitError, MapperError
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from server.library.database import Database
from server.library.following import followed
from server.library.log_pack import write_pack
from server.library.records import Failure, Record
from server.library.slam_job import (
    GRAPH,
    NAME,
    TUM,
    PartialPoses,
    SlamJob,
    read_progress,
)
from server.library.slam_record import SlamRecord, load_slam_records, put_slam_record
from server.library.storage import StorageError, private_folder
from server.library.trajectories import NewTrajectory, Trajectories
from server.library.workers import Worker
from server.work.fair_lock import FairLock

MOST_OF_OWNER = 3  #: unfinished jobs of one visitor
MOST = 50  #: of all visitors
MOST_ATTEMPTS = 2  #: runs of one job that the end of the service may interrupt

_log = structlog.get_logger(__name__)


class Logs(Protocol):
    """What the jobs need of the library."""

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log."""

    async def load(self, owner: str, log_id: str, topic: str | None = None, cut: PlanarCut | None = None) -> ScanLog:
        """Return a log."""

    @property
    def trajectories(self) -> Trajectories:
        """The trajectories that are added to logs."""


@dataclass(frozen=True, slots=True)
class SlamLimits:
    """Limits of one job: seconds of elapsed and of processor time, bytes of address space."""

    timeout_s: float = 3600.0
    cpu_s: float = 7200.0
    memory_bytes: int = 6 << 30


Listener = Callable[[PartialPoses | None], None]
"""Called with the poses so far, and with None once the job has ended."""


@dataclass(slots=True, eq=False)
class _Running:
    """A job while it is queued or runs. ``poses`` are the newest that it has reported."""

    task: asyncio.Task[None]
    listeners: list[Listener]
    queued_at: float
    began: float | None = None
    poses: PartialPoses | None = None


class SlamJobs:
    """All jobs; ``folder`` is one for their files that worker processes see."""

    def __init__(
        self,
        database: Database,
        logs: Logs,
        worker: Callable[[], Worker],
        folder: Path,
        limits: SlamLimits | None = None,
    ) -> None:
        self._database = database
        self._logs = logs
        self._make_worker = worker
        self._worker: Worker | None = None
        self._folder = folder
        self._limits = limits or SlamLimits()
        self._records: dict[tuple[str, str], SlamRecord] = {}  #: by owner and log
        self._running: dict[tuple[str, str], _Running] = {}
        self._turns = FairLock()
        self._closing = False

    async def start(self) -> None:
        """Load the records, and begin again what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        for record in await self._database.run(load_slam_records):
            self._records[record.owner, record.log_id] = record
            if not record.is_unfinished:
                continue
            if record.attempts < MOST_ATTEMPTS:
                self._queue(replace(record, state="queued"))
            else:
                message = f"The service ended {record.attempts} times during this job; it is not begun again by itself."
                self._save(replace(record, state="failed", error=Failure("slam.interrupted", message)))

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
        """Queue SLAM of a log, and return its state; one that is queued or running goes on.

        ``cut`` says how its scans are cut out of clouds and depth images, None as by default.

        Raises :class:`LimitError` for one job too many, :class:`mapper.core.errors.ConfigError` for a parameter that
        SLAM refuses and for a cut that is none, and as the library for a log that the owner may not open.
        """
        changed = await asyncio.to_thread(changed_parameters, parameters or {})
        PlanarCut.of(cut or {})
        log_record = self._logs.get(owner, log_id)
        key = (owner, log_id)
        if key not in self._running:
            if sum(one == owner for one, _ in self._running) >= MOST_OF_OWNER:
                message = f"You have {MOST_OF_OWNER} SLAM jobs under way, the most there can be: wait, or cancel one."
                raise LimitError("slam.too_many", message)
            if len(self._running) >= MOST:
                raise LimitError("slam.busy", "Too many SLAM jobs are under way; try again later.")
            record = SlamRecord(log_id, owner, topic, trajectory, "queued", time.time(), parameters=changed, cut=cut)
            self._queue(record)
            try:
                await self._database.run(lambda connection: put_slam_record(connection, log_record, record))
            except StorageError:
                await self.cancel(owner, log_id)
                raise
        return self.state(owner, log_id)

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest job; its state is "none" where there was none."""
        self._logs.get(owner, log_id)
        record = self._records.get((owner, log_id)) or SlamRecord(log_id, owner, None, None, "none", 0.0)
        running = self._running.get((owner, log_id))
        poses = None if running is None else running.poses
        began = None if running is None else running.began
        waiting = [one for one in self._running.values() if one.began is None]
        return record.public() | {
            "fraction": 0.0 if poses is None else round(poses.fraction, 4),
            "stage": None if poses is None else poses.stage,
            "scans": 0 if poses is None else len(poses.poses),
            "loops": 0 if poses is None else poses.n_loops,
            "elapsed_s": None if began is None else round(time.monotonic() - began, 1),
            "ahead": sum(one.queued_at < running.queued_at for one in waiting) if running and began is None else 0,
        }

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a job, if it is queued or running; return its state."""
        self.state(owner, log_id)
        running = self._running.get((owner, log_id))
        if running is not None:
            running.task.cancel()
            await asyncio.wait([running.task])
        return self.state(owner, log_id)

    def listen(self, owner: str, log_id: str, listener: Listener) -> Callable[[], None]:
        """Tell ``listener`` of a job that is queued or runs, and return a function that ends that.

        Where there is none it is told the end at once.
        """
        running = self._running.get((owner, log_id))
        if running is None:
            listener(None)
            return lambda: None
        running.listeners.append(listener)
        if running.poses is not None:
            listener(running.poses)
        return lambda: running.listeners.remove(listener) if listener in running.listeners else None

    async def forget_log(self, log_id: str) -> None:
        """Stop the jobs of a log that was deleted, and forget them."""
        for key in [key for key in self._records if key[1] == log_id]:
            del self._records[key]
            running = self._running.get(key)
            if running is not None:
                running.task.cancel()
                await asyncio.wait([running.task])

    # -- the job --------------------------------------------------------------------------------------------------

    def _queue(self, record: SlamRecord) -> None:
        key = (record.owner, record.log_id)
        self._records[key] = record
        task = asyncio.create_task(self._run(record), name="slam")
        self._running[key] = _Running(task, [], time.monotonic())

    async def _run(self, record: SlamRecord) -> None:
        key = (record.owner, record.log_id)
        done = record
        try:
            async with self._turns.of(record.owner):
                running = self._running[key]
                running.began = time.monotonic()
                done = record = replace(record, state="running", attempts=record.attempts + 1)
                self._save(record)
                result = await self._slam(record, running)
            done = replace(record, state="done", result=result, attempts=0)
            _log.info("slam done", log=record.log_id, seconds=round(time.monotonic() - running.began, 1))
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message), attempts=0)
            _log.info("slam refused", log=record.log_id, code=error.code, message=error.message)
        except asyncio.CancelledError:
            if not self._closing:  # else it is begun again at the next start
                done = replace(record, state="cancelled", attempts=0)
            raise
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this job alone
            done = replace(record, state="failed", error=Failure("slam.failed", "SLAM failed on this log."), attempts=0)
            _log.exception("slam failed")
        finally:
            listeners = self._running.pop(key).listeners
            if key in self._records and done is not record:  # not deleted meanwhile
                self._save(done)
            for listener in [*listeners]:
                listener(None)

    async def _slam(self, record: SlamRecord, running: _Running) -> dict[str, Any]:
        """Run SLAM in the worker process, add the trajectory, and return what is shown of the result."""
        owner, log_id = record.owner, record.log_id
        log = await self._logs.load(owner, log_id, record.topic, PlanarCut.of(record.cut or {}))
        if record.trajectory is not None:
            log.trajectory(record.trajectory)
        folder = self._folder / secrets.token_hex(10)
        await asyncio.to_thread(private_folder, folder)
        try:
            pack, out = folder / "log.npz", folder / "slam"
            await asyncio.to_thread(packed, log, pack)
            limits = self._limits
            job = SlamJob(
                str(pack), str(out), record.trajectory, record.parameters, limits.timeout_s, limits.cpu_s,
                limits.memory_bytes,
            )  # fmt: skip
            worker = self._worker = self._worker or self._make_worker()

            async def look() -> None:
                newest = await asyncio.to_thread(read_progress, out)
                if newest is not None and (running.poses is None or newest.fraction != running.poses.fraction):
                    running.poses = newest
                    for listener in [*running.listeners]:
                        listener(newest)

            outcome = await followed(worker, job, look, "slam.died")
            text, graph = await asyncio.to_thread(
                lambda: (out.with_name(out.name + TUM).read_bytes(), out.with_name(out.name + GRAPH).read_bytes())
            )
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
        added = {one.name for one in self._logs.trajectories.of(owner, log_id)}
        own = [one for one in log.trajectories if one not in added]
        name = NAME if NAME not in own else f"{NAME} (healed)"
        start = "the scans alone" if outcome.odometry is None else f"the poses of {outcome.odometry}"
        loops = "1 loop" if outcome.loops == 1 else f"{outcome.loops} loops"
        said = f"poses corrected by SLAM, from {start}, with {loops}"
        new = NewTrajectory(name, text, "slam", said, graph)
        await self._logs.trajectories.put(owner, self._logs.get(owner, log_id), log, new)
        return {
            "trajectory": name,
            "odometry": outcome.odometry,
            "loops": outcome.loops,
            "nodes": outcome.nodes,
            "cpu_s": round(outcome.cpu_s, 2),
            "sharpness": [round(value, 4) if math.isfinite(value) else None for value in outcome.sharpness],
            "notes": list(outcome.notes),
        }

    def _save(self, record: SlamRecord) -> None:
        """Store a changed record; if it cannot be written, it is valid until the next start."""
        self._records[record.owner, record.log_id] = record
        with contextlib.suppress(MapperError):  # the log is gone
            log = self._logs.get(record.owner, record.log_id)
            written = self._database.run(lambda connection: put_slam_record(connection, log, record))
            written.add_done_callback(lambda one: None if one.cancelled() else one.exception() and None)


def changed_parameters(values: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters of SLAM that differ from the first values (worker thread: it imports SLAM).

    Raises :class:`mapper.core.errors.ConfigError` for a name or a value that is refused.
    """
    from mapper.slam.config import SlamConfig  # noqa: PLC0415 - few visitors begin SLAM

    first = SlamConfig().as_dict()
    return {name: value for name, value in SlamConfig().with_values(values).as_dict().items() if value != first[name]}


def parameter_table() -> list[dict[str, Any]]:
    """Return the table of SLAM's parameters (worker thread: it imports SLAM)."""
    from mapper.slam.config import SLAM_PARAMETERS  # noqa: PLC0415 - few visitors begin SLAM

    return [asdict(row) for row in SLAM_PARAMETERS]


def emptied(folder: Path) -> None:
    """Make a private folder anew. Raises :class:`StorageError`."""
    shutil.rmtree(folder, ignore_errors=True)
    private_folder(folder)


def packed(log: ScanLog, path: Path) -> None:
    """Write a log for a worker process. Raises :class:`StorageError`."""
    try:
        write_pack(RobotLog({one.topic: one for one in sensors_of(log)}), path)
    except OSError:
        raise StorageError(
            "log.storage", "The log could not be stored for SLAM; the server's disk may be full."
        ) from None
