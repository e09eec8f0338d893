"""The logs of the library as a fleet: each is read, examined and mapped once, and the result stored.

Several workers do the jobs. A result belongs to the log, not to the requester, so all visitors see the same one for a
log of the shared folder. Logs that wait when the service ends continue at the next start. They are mapped by processes
of this machine or on a Dask cluster; while that is unavailable they wait. All methods run on the event loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, fields
from typing import Literal, get_args

from mapper.core.errors import LimitError
from server.jobs.leases import Leases
from server.jobs.process import JobLimits
from server.jobs.queue import JobQueue, Key, Running
from server.jobs.record import Failure, JobKind, JobRecord, JobRows
from server.jobs.workers import Worker
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import LogNotFoundError, Record
from server.library.processing.fleet.cluster import Cluster, ClusterState
from server.library.processing.fleet.cluster_worker import ClusterWorker
from server.library.processing.fleet.fleet_job import (
    LIMITS,
    ClusterLostError,
    FleetJob,
    LogOptions,
    MapFacts,
    fleet_facts,
)

MOST = 20_000  #: maximum number of waiting logs, of all visitors
LOOK_S = 0.5  #: interval of checking the size of the cluster


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetFacts(MapFacts):
    """The facts, the elapsed time in ``seconds``, and the number of ``runs``."""

    seconds: float
    runs: int


@dataclass(frozen=True, slots=True)
class FleetRequest:
    """How a log is read and mapped, see :class:`LogOptions`."""

    topic: str | None = None
    tf: str | None = None
    trajectory: str | None = None
    mapping: dict[str, bool | float] = field(default_factory=dict)

    @property
    def options(self) -> LogOptions:
        """The options of the job."""
        return LogOptions(self.topic, self.tf, self.trajectory, self.mapping)


Job = JobRecord[FleetRequest, FleetFacts]
Queue = JobQueue[FleetRequest, float, FleetFacts]


FleetLogState = Literal["none", "queued", "running", "done", "failed"]


@dataclass(frozen=True, slots=True)
class FleetLog:
    """A log of the fleet; ``fraction`` is the completed share of its job, ``facts`` are the results.

    ``options`` are those that differ from the defaults, in words. ``has_picture`` says whether there is a picture of
    its map, which the reading of a log draws before the fleet does.
    """

    id: str
    name: str
    state: FleetLogState
    has_picture: bool
    fraction: float
    error: Failure | None
    facts: FleetFacts | None
    options: str


@dataclass(frozen=True, slots=True)
class FleetState:
    """The numbers of logs by state, and those that have changed since a revision.

    ``whole`` says that all are returned: for revision 0, and if a log was removed since. ``cluster`` is None if
    processes of this machine do the work; its address is not disclosed.
    """

    revision: int
    whole: bool
    workers: int
    cluster: ClusterState | None
    counts: dict[FleetLogState, int]
    logs: list[FleetLog]


class FleetJobs:
    """The jobs, ``places`` at once, each on its own worker, which ``worker`` creates.

    With a ``cluster``, which is closed with them, they run there, as many at once as its workers have threads.
    """

    def __init__(
        self,
        rows: JobRows,
        leases: Leases,
        catalogue: Catalogue,
        worker: Callable[[], Worker],
        places: int,
        cluster: Cluster | None = None,
        limits: JobLimits = LIMITS,
    ) -> None:
        self.places = places if cluster is None else 0
        self._cluster = cluster
        self._following: asyncio.Task[None] | None = None
        self._catalogue, self._make_worker = catalogue, worker
        self._limits = limits
        self._idle: list[Worker] = []
        self._revision = 0
        self._whole = 0  #: the last revision at which a log was removed
        self._changed_at: dict[Key, int] = {}
        kind = JobKind("fleet", "Mapping", "log", FleetRequest, FleetFacts, self.places)
        self._queue: Queue = JobQueue(rows, leases, kind, self._mapped, self._changed)
        self.follow = self._queue.follow
        self.forget_log = self._queue.forget_log

    async def start(self) -> None:
        """Restart what an earlier run of the service did not finish. Raises :class:`StorageError`."""
        await self._queue.start()
        if self._cluster is not None:
            self._following = asyncio.create_task(self._follow_size(self._cluster), name="size of the cluster")

    async def _follow_size(self, cluster: Cluster) -> None:
        """Run as many jobs at once as the cluster's workers have threads."""
        while True:
            if cluster.state.threads != self.places:
                self.places = cluster.state.threads
                self._queue.resize(self.places)
            await asyncio.sleep(LOOK_S)

    async def close(self) -> None:
        """End the running jobs, which the next start of the service restarts, and their processes."""
        if self._following is not None:
            self._following.cancel()
        await self._queue.close()
        if self._cluster is not None:
            await asyncio.to_thread(self._cluster.close)
        for worker in self._idle:
            await asyncio.to_thread(worker.close)

    def _changed(self, key: Key) -> None:
        self._revision += 1
        if key in self._queue.records:
            self._changed_at[key] = self._revision
        else:
            self._changed_at.pop(key, None)
            self._whole = self._revision

    # -- requests -------------------------------------------------------------------------------------------------

    async def begin(self, logs: Sequence[Record], *, again: bool = False, request: FleetRequest | None = None) -> int:
        """Queue the logs that have no result and are not under way; ``again``: also those that failed.

        With a ``request``, logs whose result or error is from another request are queued too. Returns their number.
        Raises :class:`LimitError` for too many, and :class:`StorageError`.
        """
        known = self._queue.records
        jobs: list[Job] = []
        for log in logs:
            record = known.get((log.owner, log.id))
            is_other = record is not None and request not in (None, record.request) and not record.is_unfinished
            if record is None or record.state == "cancelled" or is_other or (again and record.state == "failed"):
                how = request or FleetRequest()
                jobs.append(
                    JobRecord(log_id=log.id, owner=log.owner, request=how, state="queued", created_s=time.time())
                )
        if len(self._queue.running) + len(jobs) > MOST:
            raise LimitError("fleet.too_many", f"At most {MOST:,} logs wait to be mapped at once.")
        await self._queue.begin(jobs)
        return len(jobs)

    async def stop(self, logs: Sequence[Record]) -> None:
        """End the queued or running jobs of these logs. Results are kept."""
        await self._queue.stop_all([(log.owner, log.id) for log in logs])

    def state(self, logs: Sequence[Record], since: int = 0, pictured: AbstractSet[str] | None = None) -> FleetState:
        """Return the numbers of these logs by state, and those that have changed since a revision.

        ``pictured`` are the ids of the logs with pictures, see :meth:`Catalogue.pictured`; by default looked up.
        """
        if pictured is None:
            pictured = self._catalogue.pictured()
        whole = since <= self._whole or since > self._revision
        counts = dict.fromkeys(get_args(FleetLogState), 0)
        shown = []
        for log in logs:
            key = (log.owner, log.id)
            record = self._queue.records.get(key)
            state: FleetLogState = "none" if record is None or record.state == "cancelled" else record.state
            counts[state] += 1
            if whole or state == "running" or self._changed_at.get(key, 0) > since:
                fraction = round(self._queue.fraction(key), 3) if state == "running" else 0.0
                error, facts = (None, None) if record is None else (record.error, record.result)
                by = "" if record is None else record.request.options.in_words
                shown.append(FleetLog(log.id, log.name, state, log.id in pictured, fraction, error, facts, by))
        cluster = None if self._cluster is None else self._cluster.state
        return FleetState(self._revision, whole, self.places, cluster, counts, shown)

    # -- job ------------------------------------------------------------------------------------------------------

    async def _mapped(self, record: Job, running: Running[float]) -> FleetFacts:
        """Have a worker do the job; return the facts."""
        log = self._catalogue.get(record.log_id) or Record(record.log_id, record.owner, "", "folder", "queued", 0)
        worker = self._idle.pop() if self._idle else self._new_worker()
        began = time.monotonic()

        async def look() -> None:
            if worker.progress != running.fraction:
                running.tell(worker.progress, worker.progress)

        try:
            if log.source == "folder" and log.id not in self._catalogue.folder_logs:
                raise LogNotFoundError("log.not_found", "This log is not in the folder any more.")
            async with self._catalogue.source(log) as source:
                picture = str(self._catalogue.picture(log.id))
                options = record.request.options
                job = FleetJob(str(source), None, picture, self._limits, background=True, options=options)
                facts, runs = await self._facts(worker, job, look)
        finally:
            self._idle.append(worker)
            if len(self._queue.running) == 1:  # the last one; waiting processes use memory
                for idle in self._idle:
                    idle.end()
        await self._catalogue.publish(log.id)
        seconds = round(time.monotonic() - began, 3)
        values = {field.name: getattr(facts, field.name) for field in fields(facts)}
        return FleetFacts(**values, seconds=seconds, runs=runs)

    def _new_worker(self) -> Worker:
        return self._make_worker() if self._cluster is None else ClusterWorker(self._cluster)

    async def _facts(self, worker: Worker, job: FleetJob, look: Callable[[], Awaitable[None]]) -> tuple[MapFacts, int]:
        """Return the facts and the number of runs. While the cluster is unavailable the job waits."""
        while True:
            if self._cluster is None or self._cluster.state.threads:
                with contextlib.suppress(ClusterLostError):
                    return await fleet_facts(worker, job, look)
            await asyncio.sleep(LOOK_S)
