"""SLAM as a kind of job on logs. Its result is one more trajectory of the log, with its pose graph.

The worker process writes files: while it runs, its progress and the poses so far, and at the end the trajectory and the
pose graph. The server reads them, wherever the process runs.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper import diagnosis, slam
from mapper.core.errors import ConfigError
from mapper.core.parameter import changed_values
from mapper.io import export
from mapper.mapping.parameters import RECORDED, MappingConfig, as_mapped
from mapper.sensors.georeference import NO_OFFSET
from mapper.sensors.joint_log import is_measured
from mapper.sensors.scan import Trajectory
from mapper.slam.config import SLAM_PARAMETERS, SlamConfig
from server.jobs import process
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.record import JobKind, JobRecord, JobStatus, shared
from server.library.annotations.trajectories import NewTrajectory
from server.library.packs.log import log_in
from server.library.processing.log_jobs import Parameters, ParameterTable, PoseRequest, Run, read_report, write_report

if TYPE_CHECKING:
    from mapper.diagnosis.figures import MapFigures
    from mapper.slam import SlamProgress

NAME = "SLAM"  #: of the trajectory, in the process
EVERY_S = 0.4  #: seconds between two reports, except after a closed loop

#: Endings of the files, after the job's ``out``.
TUM, GRAPH = ".tum", ".graph"


@dataclass(frozen=True, slots=True)
class SlamOutcome:
    """Result of SLAM, with the figures of the maps along the poses ``before`` and ``after`` it."""

    odometry: str | None
    loops: int
    nodes: int
    cpu_s: float
    before: MapFigures
    after: MapFigures
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SlamJob(BoundedJob[SlamOutcome]):
    """Correct the poses of the log in ``pack``, beginning with those of ``trajectory`` (None: SLAM's own choice).

    ``out`` is the path of its files without their endings, ``parameters`` are those that differ from the defaults.
    ``mapping`` are parameters of the map for which the poses are computed: SLAM uses its mount and its time offset, and
    the result contains the figures of that map.
    """

    BACKGROUND = True
    DOING = "SLAM of this log"
    CODE = "slam"

    pack: str
    out: str
    trajectory: str | None
    parameters: Parameters
    mapping: Parameters
    limits: JobLimits

    def compute(self) -> SlamOutcome:
        """Return the result. Raises :class:`mapper.core.errors.MapperError` for a log unsuitable for SLAM."""
        from server.library.packs.graph import graph_bytes  # noqa: PLC0415

        log = log_in(self.pack)
        if not is_measured(log).any():
            raise ConfigError("slam.no_returns", "No scan of this log has a return: there is nothing to align.")
        config = SlamConfig().with_values(self.parameters)
        mapping = MappingConfig().with_values({**RECORDED, **self.mapping})
        result = slam.slam_log(
            as_mapped(log, mapping), config, trajectory=self.trajectory, progress=_Reporter(self.out)
        )
        offset = NO_OFFSET if result.odometry is None else log.trajectory(result.odometry).offset
        corrected = Trajectory(result.poses, from_scans=True, offset=offset)
        log = replace(log, trajectories={**log.trajectories, NAME: corrected})
        Path(self.out + GRAPH).write_bytes(graph_bytes(result.graph, result.candidates))
        Path(self.out + TUM).write_text(export.tum_text(log, NAME), encoding="ascii")
        before = log.default_trajectory if result.odometry is None else result.odometry
        along_odometry, along_slam = (diagnosis.map_figures(log, name, mapping) for name in (before, NAME))
        process.note_progress(1.0)
        nodes = len(result.graph.nodes)
        return SlamOutcome(
            result.odometry,
            result.graph.n_loops,
            nodes,
            result.cpu_seconds,
            along_odometry,
            along_slam,
            result.notes,
        )


@dataclass(frozen=True, slots=True)
class PartialPoses:
    """The poses (k, 3), ``T_map_base``, of the first k scans while SLAM runs; ``stage`` is named by SLAM."""

    fraction: float
    stage: str
    n_loops: int
    poses: NDArray[np.float64]


class _Reporter:
    """Writes SLAM's progress, at most every :data:`EVERY_S`, sooner after a closed loop."""

    def __init__(self, out: str) -> None:
        self._out = out
        self._written = 0.0
        self._loops = 0

    def __call__(self, progress: SlamProgress) -> bool:
        process.note_progress(progress.fraction)
        now = time.monotonic()
        has_closed = progress.n_loops != self._loops
        if now - self._written > (EVERY_S / 4.0 if has_closed else EVERY_S):
            self._written, self._loops = now, progress.n_loops
            newest = PartialPoses(progress.fraction, progress.stage, progress.n_loops, progress.poses)
            write_report(self._out, newest)
        return True


# -- the kind of jobs -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SlamRequest(PoseRequest):
    """SLAM of a log; ``parameters`` are those that differ from the defaults."""

    parameters: Parameters = field(default_factory=dict)


Two = tuple[float | None, float | None]


@dataclass(frozen=True, slots=True)
class SlamResult:
    """Result of SLAM for a log: ``trajectory`` is the name of the new one; figures of the map before and after."""

    trajectory: str
    odometry: str | None
    loops: int
    nodes: int
    cpu_s: float
    drift_m: Two
    contradicted: Two
    sharpness: Two
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SlamStatus(JobStatus):
    """State of SLAM for a log: the ``stage``, the number of scans with poses, and the number of closed loops."""

    log: str
    topic: str | None
    odometry: str | None
    parameters: Parameters
    result: SlamResult | None
    stage: str | None
    scans: int
    loops: int


class SlamKind:
    """SLAM of logs: a :class:`LogJobKind`."""

    jobs = JobKind("slam", "SLAM", "SLAM job", SlamRequest, SlamResult)

    def checked(self, log_id: str, request: SlamRequest) -> SlamRequest:  # noqa: ARG002 - what another kind needs
        """Return a request with the parameters that differ from the defaults."""
        request.check()
        first = SlamConfig()
        return replace(request, parameters=changed_values(first.with_values(request.parameters), first))

    def others(self, request: SlamRequest) -> tuple[str, ...]:  # noqa: ARG002 - what another kind needs
        """Return no log, because SLAM uses only one."""
        return ()

    def status(
        self, record: JobRecord[SlamRequest, SlamResult], status: JobStatus, newest: PartialPoses | None
    ) -> SlamStatus:
        """Return the state of a job."""
        return SlamStatus(
            **shared(status),
            log=record.log_id,
            topic=record.request.topic,
            odometry=record.request.trajectory,
            parameters=record.request.parameters,
            result=record.result,
            stage=None if newest is None else newest.stage,
            scans=0 if newest is None else len(newest.poses),
            loops=0 if newest is None else newest.n_loops,
        )

    async def run(self, run: Run[SlamRequest, PartialPoses]) -> SlamResult:
        """Correct the poses of a log, and add them to it with their graph."""
        request = run.request
        log = await run.load(run.log_id, request.topic, request.cut, request.trajectory)
        pack = await run.packed(log, "log.npz")
        job = SlamJob(pack, str(run.out), request.trajectory, request.parameters, request.mapping or {}, run.limits)
        outcome = await run.follow(job, lambda out: read_report(out, PartialPoses))
        start = "the scans alone" if outcome.odometry is None else f"the poses of {outcome.odometry}"
        loops = "1 loop" if outcome.loops == 1 else f"{outcome.loops} loops"
        name = run.own_name(log, NAME, f"{NAME} (healed)")
        description = f"poses corrected by SLAM, from {start}, with {loops}"
        text, graph = await run.made(TUM), await run.made(GRAPH)
        await run.add(run.log_id, log, NewTrajectory(name, text, "slam", description, graph))
        before, after = outcome.before, outcome.after
        return SlamResult(
            trajectory=name,
            odometry=outcome.odometry,
            loops=outcome.loops,
            nodes=outcome.nodes,
            cpu_s=round(outcome.cpu_s, 2),
            drift_m=(_rounded(before.drift_m), _rounded(after.drift_m)),
            contradicted=(_rounded(before.contradicted), _rounded(after.contradicted)),
            sharpness=(_rounded(before.sharpness), _rounded(after.sharpness)),
            notes=outcome.notes,
        )


def _rounded(value: float | None) -> float | None:
    return round(value, 4) if value is not None and math.isfinite(value) else None


def parameter_table() -> ParameterTable:
    """Return the table of SLAM's parameters (worker thread: it imports SLAM)."""
    return ParameterTable(SLAM_PARAMETERS)
