"""The job of a worker process that localizes a log in a map.

It writes files: how far it is with the poses and the particles so far while it runs, the trajectory and the course in
the end.
"""

from __future__ import annotations

import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import LimitError
from mapper.mapping.corrections import as_mapped
from mapper.mapping.parameters import MappingConfig
from server.jobs import process
from server.library.packs.course import Course, course_bytes, thinned
from server.library.packs.given_map import read_given_map
from server.library.processing.slam_job import log_in, lower_priority

if TYPE_CHECKING:
    from mapper.localization import MonteCarloLocalizer

DOING = "Localizing this log"  #: in errors
EVERY_S = 0.4  #: seconds between two reports
MOST_SHOWN = 2000  #: particles of a report
KEPT_OF_SCAN = 250  #: particles of a scan in the course

#: Endings of the files, after the job's ``out``.
PROGRESS, TUM, COURSE = ".progress", ".tum", ".course"

_NUMBERS = ("fraction", "is_converged", "share", "fit", "entropy", "n_particles", "n_updates")


@dataclass(frozen=True, slots=True)
class LocalizeJob:
    """Localize the log in ``pack`` by the odometry ``trajectory`` (None: the log's) in the map in the file ``given``.

    ``initial_pose`` is in the map, None: anywhere. ``out`` is the path of its files without their endings,
    ``parameters`` those that differ from the first values. ``mapping`` are parameters of the log's own map, whose mount
    and time offset are used.
    """

    pack: str
    given: str
    out: str
    trajectory: str | None
    initial_pose: tuple[float, float, float] | None
    parameters: dict[str, Any]
    mapping: dict[str, Any]
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[LocalizeJob], LocalizeOutcome]:
        """The function that does it."""
        return do_localize_job

    def time_error(self) -> LimitError:
        """Return the error for a job that takes too long."""
        return process.time_error(self.timeout_s, DOING, "localization")


@dataclass(frozen=True, slots=True)
class LocalizeOutcome:
    """Result of localization; ``first_converged`` is None where the filter never converged."""

    map_title: str
    odometry: str
    first_converged: int | None
    converged: int
    is_converged: bool
    updates: int
    median_fit: float
    cpu_s: float


@dataclass(frozen=True, slots=True, eq=False)
class LocalizeProgress:
    """The poses (k, 3), ``T_map_base``, of the first k scans while the job runs, and the filter after the last of them.

    ``particles`` (m, 4) are x, y, yaw and weight, the greatest 1; ``covariance`` (3, 3); the rest as
    :class:`mapper.localization.Estimate` has it.
    """

    fraction: float
    is_converged: bool
    share: float
    fit: float
    entropy: float
    n_particles: int
    n_updates: int
    covariance: NDArray[np.float64]
    poses: NDArray[np.float64]
    particles: NDArray[np.float32]


def do_localize_job(job: LocalizeJob) -> LocalizeOutcome:
    """Do the job. Raises :class:`mapper.core.errors.MapperError` for a log or a map that cannot be used, and limits."""
    lower_priority()
    return process.bounded(job.timeout_s, job.cpu_s, lambda: _localize(job), DOING, "localization")


def _localize(job: LocalizeJob) -> LocalizeOutcome:
    from mapper.io.export import tum_text  # noqa: PLC0415 - only this process needs the filter
    from mapper.io.maps.reading import grid_of_values  # noqa: PLC0415
    from mapper.localization import LocalizationConfig, localize_log  # noqa: PLC0415
    from mapper.localization.localize import LOCALIZED  # noqa: PLC0415
    from mapper.sensors.scan import Trajectory  # noqa: PLC0415

    log = log_in(job.pack)
    given = read_given_map(Path(job.given))
    grid = grid_of_values(given.geometry, given.values)
    watch = _Watch(job.out, log.n_scans)
    found = localize_log(
        as_mapped(log, MappingConfig().with_values(job.mapping)), grid,
        LocalizationConfig().with_values(job.parameters), trajectory=job.trajectory, initial_pose=job.initial_pose,
        watch=watch,
    )  # fmt: skip
    offsets, particles = thinned(watch.clouds)
    course = Course(
        found.covariance, found.is_converged, found.is_updated, found.share, found.fit, found.entropy,
        found.n_particles, offsets, particles, given,
    )  # fmt: skip
    log = replace(log, trajectories={**log.trajectories, LOCALIZED: Trajectory(found.poses, from_scans=True)})
    Path(job.out + COURSE).write_bytes(course_bytes(course))
    Path(job.out + TUM).write_text(tum_text(log, LOCALIZED), encoding="ascii")
    process.note_progress(1.0)
    used = found.fit[found.is_updated]
    return LocalizeOutcome(
        given.title, found.odometry, found.first_converged, int(found.is_converged.sum()), bool(found.is_converged[-1]),
        len(used), float(np.median(used)) if len(used) else 0.0, found.cpu_seconds,
    )  # fmt: skip


@dataclass(slots=True)
class _Watch:
    """Keeps a sample of the particles of each scan that is used, and reports every :data:`EVERY_S`."""

    out: str
    n_scans: int
    clouds: list[NDArray[np.float32]] = field(default_factory=list)
    poses: list[NDArray[np.float64]] = field(default_factory=list)
    written: float = 0.0

    def __call__(self, scan: int, robot: MonteCarloLocalizer) -> None:
        estimate = robot.estimate
        self.poses.append(estimate.pose)
        if estimate.is_updated:
            self.clouds.append(_sample(robot.particles, KEPT_OF_SCAN))
        now, fraction = time.monotonic(), (scan + 1) / self.n_scans
        process.note_progress(fraction)
        if now - self.written < EVERY_S:
            return
        self.written = now
        particles = _sample(np.column_stack([robot.particles, robot.weights / robot.weights.max()]), MOST_SHOWN)
        numbers = [
            fraction, estimate.is_converged, estimate.share, estimate.fit, estimate.entropy, estimate.n_particles,
            robot.n_updates,
        ]  # fmt: skip
        with atomic_write(Path(self.out + PROGRESS)) as file:
            np.savez(
                file, numbers=np.array(numbers, dtype=np.float64), covariance=estimate.covariance,
                poses=np.stack(self.poses), particles=particles,
            )  # fmt: skip


def _sample(rows: NDArray[np.float64], most: int) -> NDArray[np.float32]:
    return rows[:: max(1, -(-len(rows) // most))].astype(np.float32)


def read_progress(out: Path) -> LocalizeProgress | None:
    """Return what a running job has reported last; None before the first report."""
    try:
        with np.load(out.with_name(out.name + PROGRESS), allow_pickle=False) as arrays:
            numbers = dict(zip(_NUMBERS, arrays["numbers"].tolist(), strict=True))
            return LocalizeProgress(
                fraction=numbers["fraction"],
                is_converged=bool(numbers["is_converged"]),
                share=numbers["share"],
                fit=numbers["fit"],
                entropy=numbers["entropy"],
                n_particles=int(numbers["n_particles"]),
                n_updates=int(numbers["n_updates"]),
                covariance=arrays["covariance"],
                poses=arrays["poses"],
                particles=arrays["particles"],
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
