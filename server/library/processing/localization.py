"""Localization as a kind of job on logs. Its result is one more trajectory of the log, in the frame of a map.

The worker process writes files: while it runs, its progress with the poses and the particles so far, and at the end the
trajectory and the filter states.
"""

from __future__ import annotations

import asyncio
import shutil
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper import localization
from mapper.core.errors import ConfigError
from mapper.core.parameter import changed_values
from mapper.io import export
from mapper.mapping.parameters import MappingConfig, as_mapped
from mapper.sensors.scan import Trajectory
from server.jobs import process
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.record import JobKind, JobRecord, JobStatus, shared
from server.library.annotations.trajectories import NewTrajectory
from server.library.packs.filter_states import FilterStates, filter_states_bytes, thinned
from server.library.packs.log import log_in
from server.library.packs.reference_map import read_reference_map
from server.library.processing.log_jobs import Parameters, ParameterTable, PoseRequest, Run, read_report, write_report
from server.library.processing.reference_maps import ReferenceMaps

if TYPE_CHECKING:
    from mapper.localization import MonteCarloLocalizer

EVERY_S = 0.4  #: seconds between two reports
MOST_SHOWN = 2000  #: particles in a report
KEPT_OF_SCAN = 250  #: particles of a scan stored in the file

#: Endings of the files, after the job's ``out``.
TUM, FILTER_STATES = ".tum", ".course"


@dataclass(frozen=True, slots=True)
class LocalizeOutcome:
    """Result of localization; ``first_converged`` is None if the filter never converged.

    ``sure`` is the number of scans at which other places in the map were ruled out, ``is_sure`` says whether that holds
    for the last scan, ``left_out`` is the number of scans with unknown poses, which maps omit.
    """

    map_title: str
    odometry: str
    first_converged: int | None
    converged: int
    is_converged: bool
    updates: int
    median_fit: float
    cpu_s: float
    sure: int = 0
    is_sure: bool = False
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class LocalizeJob(BoundedJob[LocalizeOutcome]):
    """Localize the log in ``pack`` with the odometry ``trajectory`` (None: the log's) in a map.

    The map is the file ``reference_map``; ``initial_pose`` is in it, None: anywhere. ``out`` is the path of its files
    without their endings, ``parameters`` those that differ from the defaults. ``mapping`` are parameters of the
    log's own map, whose mount and time offset are used.
    """

    BACKGROUND = True
    DOING = "Localizing this log"
    CODE = "localization"

    pack: str
    reference_map: str
    out: str
    trajectory: str | None
    initial_pose: tuple[float, float, float] | None
    parameters: Parameters
    mapping: Parameters
    limits: JobLimits

    def compute(self) -> LocalizeOutcome:
        """Return the result. Raises :class:`mapper.core.errors.MapperError` for an unsuitable log or map."""
        from mapper.io.maps.reading import grid_of_values  # noqa: PLC0415
        from mapper.localization.localize import LOCALIZED  # noqa: PLC0415

        log = log_in(self.pack)
        reference = read_reference_map(Path(self.reference_map))
        grid = grid_of_values(reference.geometry, reference.values)
        watch = _Watch(self.out, log.n_scans)
        localized = localization.localize_log(
            as_mapped(log, MappingConfig().with_values(self.mapping)),
            grid,
            localization.LocalizationConfig().with_values(self.parameters),
            trajectory=self.trajectory,
            initial_pose=self.initial_pose,
            watch=watch,
        )
        offsets, particles = thinned(watch.clouds)
        states = FilterStates(
            localized.covariance, localized.is_converged, localized.is_sure, localized.is_updated, localized.share,
            localized.fit, localized.entropy, localized.n_particles, offsets, particles, reference,
        )  # fmt: skip
        log = replace(log, trajectories={**log.trajectories, LOCALIZED: Trajectory(localized.poses, from_scans=True)})
        Path(self.out + FILTER_STATES).write_bytes(filter_states_bytes(states))
        Path(self.out + TUM).write_text(export.tum_text(log, LOCALIZED), encoding="ascii")
        process.note_progress(1.0)
        used = localized.fit[localized.is_updated]
        return LocalizeOutcome(
            reference.title, localized.odometry, localized.first_converged,
            int(localized.is_converged.sum()), bool(localized.is_converged[-1]),
            len(used), float(np.median(used)) if len(used) else 0.0, localized.cpu_seconds,
            int(localized.is_sure.sum()), bool(localized.is_sure[-1]), int((~localized.is_known).sum()),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class LocalizeProgress:
    """The poses (k, 3), ``T_map_base``, of the first k scans while the job runs, and the filter after the last of them.

    ``converged`` (k,) says after which of them it had converged. ``particles`` (m, 4) are x, y, yaw and weight, the
    greatest 1; ``covariance`` is (3, 3); the other fields are those of :class:`mapper.localization.Estimate`.
    """

    fraction: float
    is_converged: bool
    is_sure: bool
    share: float
    fit: float
    entropy: float
    n_particles: int
    n_updates: int
    covariance: NDArray[np.float64]
    poses: NDArray[np.float64]
    converged: NDArray[np.bool_]
    particles: NDArray[np.float32]

    @property
    def stage(self) -> str:
        """Current stage; there is only one."""
        return "localization"


@dataclass(slots=True)
class _Watch:
    """Stores a sample of the particles of each used scan, and reports every :data:`EVERY_S`."""

    out: str
    n_scans: int
    clouds: list[NDArray[np.float32]] = field(default_factory=list)
    poses: list[NDArray[np.float64]] = field(default_factory=list)
    converged: list[bool] = field(default_factory=list)
    written: float = 0.0

    def __call__(self, scan: int, robot: MonteCarloLocalizer) -> None:
        estimate = robot.estimate
        self.poses.append(estimate.pose)
        self.converged.append(estimate.is_converged)
        if estimate.is_updated:
            self.clouds.append(_sample(robot.particles, KEPT_OF_SCAN))
        now, fraction = time.monotonic(), (scan + 1) / self.n_scans
        process.note_progress(fraction)
        if now - self.written < EVERY_S:
            return
        self.written = now
        particles = _sample(np.column_stack([robot.particles, robot.weights / robot.weights.max()]), MOST_SHOWN)
        newest = LocalizeProgress(
            fraction, estimate.is_converged, estimate.is_sure, estimate.share, estimate.fit, estimate.entropy,
            estimate.n_particles, robot.n_updates, estimate.covariance, np.stack(self.poses), np.array(self.converged),
            particles,
        )  # fmt: skip
        write_report(self.out, newest)


def _sample(rows: NDArray[np.float64], most: int) -> NDArray[np.float32]:
    return rows[:: max(1, -(-len(rows) // most))].astype(np.float32)


# -- the kind of jobs -------------------------------------------------------------------------------------------------

NAME = "localized"  #: of the trajectory


@dataclass(frozen=True, slots=True)
class LocalizationParameters:
    """``values`` that differ from the defaults; ``initial_pose`` is in the map, x, y (m) and yaw, None: anywhere."""

    values: Parameters = field(default_factory=dict)
    initial_pose: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class LocalizationRequest(PoseRequest):
    """Localization of a log in the map chosen by its visitor."""

    parameters: LocalizationParameters = field(default_factory=LocalizationParameters)


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizationResult(LocalizeOutcome):
    """Result of localizing a log: ``trajectory`` is the name of the new one."""

    trajectory: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizationStatus(JobStatus):
    """State of the localization of a log: the number of scans with poses, and whether the filter has converged."""

    log: str
    topic: str | None
    odometry: str | None
    parameters: LocalizationParameters
    result: LocalizationResult | None
    scans: int
    is_converged: bool
    n_particles: int


class LocalizationKind:
    """Localization of logs in the maps chosen by their visitors: a :class:`LogJobKind`."""

    jobs = JobKind("localization", "Localization", "localization job", LocalizationRequest, LocalizationResult)

    def __init__(self, maps: ReferenceMaps) -> None:
        self._maps = maps

    def checked(self, log_id: str, request: LocalizationRequest) -> LocalizationRequest:  # noqa: ARG002 - what another kind needs
        """Return a request with the values that differ from the defaults."""
        request.check()
        parameters, first = request.parameters, localization.LocalizationConfig()
        values = changed_values(first.with_values(parameters.values), first)
        return replace(request, parameters=replace(parameters, values=values))

    def others(self, request: LocalizationRequest) -> tuple[str, ...]:  # noqa: ARG002 - what another kind needs
        """Return no log, because the map is a separate file."""
        return ()

    def status(
        self,
        record: JobRecord[LocalizationRequest, LocalizationResult],
        status: JobStatus,
        newest: LocalizeProgress | None,
    ) -> LocalizationStatus:
        """Return the state of a job."""
        return LocalizationStatus(
            **shared(status),
            log=record.log_id,
            topic=record.request.topic,
            odometry=record.request.trajectory,
            parameters=record.request.parameters,
            result=record.result,
            scans=0 if newest is None else len(newest.poses),
            is_converged=newest is not None and newest.is_converged,
            n_particles=0 if newest is None else newest.n_particles,
        )

    async def run(self, run: Run[LocalizationRequest, LocalizeProgress]) -> LocalizationResult:
        """Localize a log, and add the poses in the map to it with the filter states.

        Raises :class:`ConfigError` if no map was chosen.
        """
        request = run.request
        log = await run.load(run.log_id, request.topic, request.cut, request.trajectory)
        pack, map_file = await run.packed(log, "log.npz"), run.folder / "map.npz"
        try:
            await asyncio.to_thread(shutil.copyfile, await self._maps.newest(run.owner, run.log_id), map_file)
        except FileNotFoundError:
            raise ConfigError("localization.no_map", "Choose a map to localize the log in first.") from None
        pose, values = request.parameters.initial_pose, request.parameters.values
        job = LocalizeJob(
            pack, str(map_file), str(run.out), request.trajectory, pose, values, request.mapping or {}, run.limits
        )
        outcome = await run.follow(job, lambda out: read_report(out, LocalizeProgress))
        name = run.own_name(log, NAME, f"{NAME} in a map")
        first = outcome.first_converged
        when = "which never converged" if first is None else f"converged from scan {first + 1} on"
        if first is not None and not outcome.is_sure:
            when += ", not sure of the place at the end"
        start = "anywhere" if pose is None else "a given pose"
        description = f"localized in {outcome.map_title} by the poses of {outcome.odometry}, from {start}, {when}"
        text, states = await run.made(TUM), await run.made(FILTER_STATES)
        await run.add(run.log_id, log, NewTrajectory(name, text, "localized", description, filter_states=states))
        rounded = replace(outcome, cpu_s=round(outcome.cpu_s, 2), median_fit=round(outcome.median_fit, 4))
        return LocalizationResult(**asdict(rounded), trajectory=name)


def parameter_table() -> ParameterTable:
    """Return the table of localization's parameters (worker thread: it imports the filter)."""
    return ParameterTable(localization.PARAMETERS)
