"""Jobs that visitors start on logs and that add trajectories to them: SLAM, localization, merging.

A :class:`LogJobKind` defines the differences; the rest is the same for all: a queue, a folder and a process for each
job, and its reports. All methods run on the event loop; computations run in a worker process.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import numpy as np

from mapper.core.atomic_file import atomic_write
from mapper.core.parameter import Parameter
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from server.jobs.leases import Leases
from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.queue import JobQueue, Running
from server.jobs.record import JobKind, JobRecord, JobRows, JobStatus
from server.jobs.workers import Worker
from server.library.annotations.trajectories import NewTrajectory, Trajectories
from server.library.logs.records import Record
from server.library.packs.arrays import UNREADABLE
from server.library.packs.log import write_pack
from server.storage import StorageError, private_folder

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Parameters = dict[str, bool | int | float | str]
"""Values of parameters by name, those that differ from the defaults."""


@dataclass(frozen=True, slots=True)
class ParameterTable:
    """The rows of a table of parameters."""

    table: tuple[Parameter, ...]


class Logs(Protocol):
    """Interface of the library that the jobs use."""

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log."""

    async def load(self, owner: str, log_id: str, topic: str | None = None, cut: PlanarCut | None = None) -> ScanLog:
        """Return a log."""

    async def put(self, owner: str, name: str, chunks: AsyncIterator[bytes]) -> Record:
        """Store a log."""

    @property
    def trajectories(self) -> Trajectories:
        """The added trajectories of logs."""


@dataclass(frozen=True, slots=True)
class PoseRequest:
    """New poses of a log to compute from those of ``trajectory`` (None: the method's own choice).

    ``topic`` names the log's sensor, ``cut`` has the options for cutting scans out of clouds and depth images (None:
    the defaults), ``mapping`` are parameters of the map for which the poses are computed (None: the defaults); the job
    uses its mount and its time offset.
    """

    topic: str | None = None
    trajectory: str | None = None
    cut: dict[str, float] | None = None
    mapping: Parameters | None = None

    def check(self) -> None:
        """Raise :class:`mapper.core.errors.ConfigError` for an invalid cut or parameter."""
        PlanarCut.of(self.cut or {})
        MappingConfig().with_values(self.mapping or {})


class Report(Protocol):
    """Progress of a running job."""

    @property
    def fraction(self) -> float:
        """Completed share, from 0 to 1."""

    @property
    def stage(self) -> str:
        """Current stage."""


PROGRESS = ".progress"  #: ending of the report's file, after the job's ``out``

Q = TypeVar("Q")
D = TypeVar("D", bound="DataclassInstance")
P = TypeVar("P", bound=Report)
R = TypeVar("R")
S_co = TypeVar("S_co", covariant=True)
S = TypeVar("S")
T = TypeVar("T")


def write_report(out: str, report: DataclassInstance) -> None:
    """Write the report of a running job, a dataclass of numbers, texts and arrays. Raises :class:`OSError`."""
    arrays: dict[str, Any] = {row.name: np.asarray(getattr(report, row.name)) for row in fields(report)}
    with atomic_write(Path(out + PROGRESS)) as file:
        np.savez(file, **arrays)


def read_report(out: Path, kind: type[D]) -> D | None:
    """Return the last report of a running job, a dataclass ``kind``; None before the first report."""
    try:
        with np.load(out.with_name(out.name + PROGRESS), allow_pickle=False) as arrays:
            values = {row.name: arrays[row.name] for row in fields(kind)}
    except UNREADABLE:
        return None
    return kind(**{name: value if value.ndim else value.item() for name, value in values.items()})


@dataclass(slots=True)
class Run(Generic[Q, P]):
    """A running job: its request, a folder for its files that worker processes see, and the library."""

    owner: str
    log_id: str
    request: Q
    folder: Path
    logs: Logs
    worker: Worker
    code: str  #: of the error if the process was killed
    running: Running[P]
    limits: JobLimits = field(default_factory=JobLimits)

    @property
    def out(self) -> Path:
        """The path of the job's files without their endings."""
        return self.folder / "out"

    async def load(
        self, log_id: str, topic: str | None, cut: dict[str, float] | None, trajectory: str | None = None
    ) -> ScanLog:
        """Return a log that has a ``trajectory``. Raises like the library, and if the log does not have it."""
        log = await self.logs.load(self.owner, log_id, topic, PlanarCut.of(cut or {}))
        if trajectory is not None:
            log.trajectory(trajectory)
        return log

    async def packed(self, log: ScanLog, name: str) -> str:
        """Write a log for the worker process, and return the path. Raises :class:`StorageError`."""
        path = self.folder / name
        await asyncio.to_thread(packed, log, path)
        return str(path)

    async def follow(self, job: BoundedJob[T], newest: Callable[[Path], P | None]) -> T:
        """Do a job in the worker process, and report its progress.

        ``newest`` returns its last report, from the files at a path.
        """

        async def look() -> None:
            progress, last = await asyncio.to_thread(newest, self.out), self.running.newest
            if progress is not None and (
                last is None or (progress.fraction, progress.stage) != (last.fraction, last.stage)
            ):
                self.running.tell(progress, progress.fraction)

        return await outcome_of(self.worker, job, self.code, look)

    async def made(self, ending: str) -> bytes:
        """Return the file with an ending that the process has written."""
        return await asyncio.to_thread(self.out.with_name(self.out.name + ending).read_bytes)

    async def add(self, log_id: str, log: ScanLog, new: NewTrajectory) -> None:
        """Add a trajectory to a log."""
        await self.logs.trajectories.put(self.owner, self.logs.get(self.owner, log_id), log, new)

    def own_name(self, log: ScanLog, name: str, other: str) -> str:
        """Return the name of a trajectory to add: ``name``, or ``other`` if the log itself has one of that name."""
        added = {trajectory.name for trajectory in self.logs.trajectories.of(self.owner, self.log_id)}
        return other if name in log.trajectories and name not in added else name


class LogJobKind(Protocol[Q, P, R, S_co]):
    """What differs between kinds of jobs."""

    jobs: JobKind[Q, R]

    def checked(self, log_id: str, request: Q) -> Q:
        """Return a request as stored (worker thread). Raises :class:`mapper.core.errors.ConfigError`."""

    def others(self, request: Q) -> tuple[str, ...]:
        """Return the logs that a job uses besides its own."""

    def status(self, record: JobRecord[Q, R], status: JobStatus, newest: P | None) -> S_co:
        """Return the answer of the HTTP interface about a job; ``newest`` is its last report."""

    async def run(self, run: Run[Q, P]) -> R:
        """Do a job, and return its result."""


class LogJobs(Generic[Q, P, R, S]):
    """All jobs of one kind; ``folder`` is for their files, and is seen by worker processes."""

    def __init__(
        self,
        rows: JobRows,
        leases: Leases,
        logs: Logs,
        worker: Callable[[], Worker],
        folder: Path,
        kind: LogJobKind[Q, P, R, S],
    ) -> None:
        self._logs, self._kind, self._folder = logs, kind, folder
        self._make_worker = worker
        self._worker: Worker | None = None
        self._queue: JobQueue[Q, P, R] = JobQueue(rows, leases, kind.jobs, self._run)
        self.follow = self._queue.follow

    async def start(self) -> None:
        """Load the records, and restart what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        await self._queue.start()

    async def close(self) -> None:
        """End the running job, which the next start of the service restarts, and the process."""
        await self._queue.close()
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)

    async def begin(self, owner: str, log_id: str, request: Q | None = None) -> S:
        """Queue a job on a log, and return its state; see :meth:`JobQueue.ask`.

        Raises :class:`mapper.core.errors.ConfigError` for an invalid request, :class:`LimitError` for too many jobs,
        and like the library for logs that the owner may not open.
        """
        kind = self._kind
        checked = await asyncio.to_thread(kind.checked, log_id, request or kind.jobs.request())
        for other_id in (log_id, *kind.others(checked)):
            self._logs.get(owner, other_id)
        await self._queue.ask(owner, log_id, checked)
        return self.state(owner, log_id)

    def state(self, owner: str, log_id: str) -> S:
        """Return the answer of the HTTP interface about the newest job; its state is "none" if there was none."""
        self._logs.get(owner, log_id)
        key = (owner, log_id)
        running = self._queue.running.get(key)
        newest = None if running is None else running.newest
        return self._kind.status(self._queue.record(key), self._queue.status(key), newest)

    def is_under_way(self, owner: str, log_id: str) -> bool:
        """Return whether a job on a log is queued or running."""
        return self._queue.record((owner, log_id)).is_unfinished

    def result(self, owner: str, log_id: str) -> R | None:
        """Return the result of the newest job on a log, None if it is not done."""
        return self._queue.record((owner, log_id)).result

    async def cancel(self, owner: str, log_id: str) -> S:
        """Stop a job, if it is queued or running; return its state."""
        self._logs.get(owner, log_id)
        await self._queue.stop((owner, log_id))
        return self.state(owner, log_id)

    def listen(self, owner: str, log_id: str, listener: Callable[[P | None], None]) -> Callable[[], None]:
        """Call ``listener`` with the reports of a queued or running job, and return a function that ends that.

        If there is no such job, the end is reported at once.
        """
        return self._queue.listen((owner, log_id), listener)

    async def forget_log(self, log_id: str) -> None:
        """Stop the jobs that use a deleted log, and remove those on it."""
        await self._queue.forget_log(log_id)
        for key, record in [*self._queue.records.items()]:
            if log_id in self._kind.others(record.request):
                await self._queue.stop(key)

    async def _run(self, record: JobRecord[Q, R], running: Running[P]) -> R:
        worker = self._worker = self._worker or self._make_worker()
        folder, code = self._folder / secrets.token_hex(10), f"{self._kind.jobs.name}.died"
        await asyncio.to_thread(private_folder, folder)
        try:
            run = Run(record.owner, record.log_id, record.request, folder, self._logs, worker, code, running)
            return await self._kind.run(run)
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)


AnyLogJobs = LogJobs[Any, Any, Any, Any]


def emptied(folder: Path) -> None:
    """Create an empty private folder. Raises :class:`StorageError`."""
    shutil.rmtree(folder, ignore_errors=True)
    private_folder(folder)


def packed(log: ScanLog, path: Path) -> None:
    """Write a log for a worker process. Raises :class:`StorageError`."""
    try:
        write_pack(RobotLog({sensor.topic: sensor for sensor in sensors_of(log)}), path)
    except OSError:
        raise StorageError(
            "log.storage", "The log could not be stored for this job; the server’s disk may be full."
        ) from None
