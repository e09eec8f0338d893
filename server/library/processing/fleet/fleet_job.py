"""The job of a worker for one log of a fleet, in a process with limits."""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mapper import diagnosis
from mapper.core.errors import MapperError, ReadError
from mapper.io import logs, maps
from mapper.mapping.parameters import RECORDED, MappingConfig, as_mapped
from mapper.sensors.joint_log import with_trajectories
from mapper.sensors.scan import ScanLog
from server.jobs import process
from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.workers import Worker

READ, EXAMINED, MAPPED = 0.4, 0.7, 0.95  #: completed shares of the job after these stages
RUNS = 2  #: of a log whose process was killed, because the machine may be at fault
DIED = "fleet.died"  #: the error of a log whose process was killed
LOSSES = 4  #: lost cluster workers with one log, where the machines or the log may be at fault


class ClusterLostError(MapperError):
    """The cluster cannot do the job now. The log is not at fault."""


class WorkerLostError(MapperError):
    """The cluster worker that did the job is gone."""


LIMITS = JobLimits(timeout_s=1800.0, cpu_s=1800.0)  #: of one log


@dataclass(frozen=True, slots=True)
class FleetFinding:
    """A finding of the log doctor: its ``check``, in a ``sentence``; ``possible`` if there may be another cause."""

    check: str
    sentence: str
    possible: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFacts:
    """Facts about a mapped log. The map has cells of ``resolution`` metres; ``contrast`` is that of its walls.

    ``drift_m`` is that of ``MapFigures``: None if it could not be measured, and in results of versions without it.
    ``cpu_s`` is processor time.
    """

    scans: int
    beams: int
    trajectory: str
    rows: int
    cols: int
    resolution: float
    contrast: float | None
    drift_m: float | None = None
    findings: tuple[FleetFinding, ...]
    picture: bool
    cpu_s: float


@dataclass(frozen=True, slots=True)
class LogOptions:
    """How each log is read and mapped: the sensor, the topic of transforms, the poses.

    ``mapping`` are parameters that correct the mount and the clock.
    """

    topic: str | None = None
    tf: str | None = None
    trajectory: str | None = None
    mapping: Mapping[str, object] = field(default_factory=dict)

    @property
    def in_words(self) -> str:
        """The options that differ from the defaults; empty if none do."""
        config = MappingConfig().with_values(self.mapping)
        named = {"sensor": self.topic, "transforms": self.tf, "poses": self.trajectory}
        words = [f"{what} {name}" for what, name in named.items() if name is not None]
        if config.mount != (0.0, 0.0, 0.0):
            x, y, yaw = config.mount
            words.append(f"mount {x:g} m, {y:g} m, {math.degrees(yaw):.4g}°")
        words += ["turned over"] * config.mount_upside_down
        words += [f"time offset {config.time_offset:g} s"] * bool(config.time_offset)
        return ", ".join(words)

    def read(self, source: Path, progress: Callable[[float], None]) -> ScanLog:
        """Return a log with the requested trajectory as its first.

        Raises :class:`MapperError`, also for a log without the sensor, topic or trajectory requested here.
        """
        log = logs.open_log(source, topic=self.topic, tf=self.tf, progress=progress)
        if self.trajectory is not None:
            log = with_trajectories(log, {self.trajectory: log.trajectory(self.trajectory)})
        return as_mapped(log, MappingConfig().with_values(self.mapping))


@dataclass(frozen=True, slots=True)
class FleetJob(BoundedJob[MapFacts]):
    """Read ``source``, examine it, map it, and draw its map into ``picture``.

    The map is kept as ``map`` (.yaml, .pgm) where that is given. A job in the ``background`` has a lower priority.
    """

    DOING = "Reading, examining and mapping this log"
    CODE = "fleet"

    source: str
    map: str | None
    picture: str
    limits: JobLimits
    background: bool = False
    options: LogOptions = field(default_factory=LogOptions)

    def compute(self) -> MapFacts:
        """Return the facts about the log. Raises :class:`MapperError` for one that cannot be read or mapped."""
        from mapper.mapping.integrate import grid_for, integrate_log  # noqa: PLC0415
        from server.library.packs.picture import write_picture  # noqa: PLC0415

        if self.background:
            process.lower_priority()
        began = time.process_time()
        log = self.options.read(Path(self.source), lambda done: process.note_progress(READ * done))
        process.note_progress(READ)
        findings = diagnosis.examine(log)
        process.note_progress(EXAMINED)
        config = MappingConfig().with_values(RECORDED)
        grid = grid_for(log, config)
        integrate_log(grid, log, config)
        if self.map is not None:
            maps.save_map(grid, Path(self.map))
        process.note_progress(MAPPED)
        picture = write_picture(log, Path(self.picture))
        geometry, figures = grid.geometry, diagnosis.map_figures(log, None, config, grid)
        return MapFacts(
            scans=log.n_scans,
            beams=log.n_beams,
            trajectory=log.default_trajectory,
            rows=geometry.rows,
            cols=geometry.cols,
            resolution=geometry.resolution,
            contrast=round(figures.sharpness, 4) if math.isfinite(figures.sharpness) else None,
            drift_m=None if figures.drift_m is None else round(figures.drift_m, 3),
            findings=tuple(FleetFinding(finding.check, finding.sentence, finding.possible) for finding in findings),
            picture=picture,
            cpu_s=round(time.process_time() - began, 3),
        )


async def fleet_facts(
    worker: Worker, job: FleetJob, look: Callable[[], Awaitable[None]] | None = None
) -> tuple[MapFacts, int]:
    """Have ``worker`` do ``job``; return the facts, and the number of runs. See :func:`outcome_of`.

    A job whose worker is lost is restarted on another one. Raises :class:`ClusterLostError` if there is none.
    """
    run, lost = 1, 0
    while True:
        try:
            return await outcome_of(worker, job, DIED, look), run + lost
        except WorkerLostError:
            lost += 1
            if lost == LOSSES:
                message = f"{LOSSES} workers of the cluster ended during this job; the log may need too much memory."
                raise ReadError("fleet.worker_lost", message) from None
        except ReadError as error:
            if error.code != DIED or run == RUNS:
                raise
            run += 1
