"""The job of a worker process that corrects the poses of a log with SLAM.

It writes files: how far it is and the poses so far while it runs, the trajectory and the pose graph in the end. The
server reads them, wherever the process runs.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.mapping.corrections import as_mapped
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.georeference import NO_OFFSET
from mapper.sensors.scan import ScanLog
from server.jobs import process
from server.library.packs.log import StalePackError, read_whole_pack

if TYPE_CHECKING:
    from mapper.diagnosis.figures import MapFigures
    from mapper.slam import SlamProgress

DOING = "SLAM of this log"  #: in errors
NAME = "SLAM"  #: of the trajectory, in the process
EVERY_S = 0.4  #: seconds between two reports, but for those of a loop that closed
NICENESS = 10  #: added to that of the service, so that sessions are computed first

#: Endings of the files, after the job's ``out``.
PROGRESS, TUM, GRAPH = ".progress", ".tum", ".graph"


@dataclass(frozen=True, slots=True)
class SlamJob:
    """Correct the poses of the log in ``pack``, beginning with those of ``trajectory`` (None: SLAM's own choice).

    ``out`` is the path of its files without their endings, ``parameters`` those that differ from the first values.
    ``mapping`` are parameters of the map that the poses are for: SLAM uses its mount and its time offset, and the
    figures of the result are those of that map.
    """

    pack: str
    out: str
    trajectory: str | None
    parameters: dict[str, Any]
    mapping: dict[str, Any]
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[SlamJob], SlamOutcome]:
        """The function that does it."""
        return do_slam_job

    def time_error(self) -> LimitError:
        """Return the error for a job that takes too long."""
        return process.time_error(self.timeout_s, DOING, "slam")


@dataclass(frozen=True, slots=True)
class SlamOutcome:
    """Result of SLAM of a log, with the figures of the map along the poses from ``before`` and ``after`` it."""

    odometry: str | None
    loops: int
    nodes: int
    cpu_s: float
    before: MapFigures
    after: MapFigures
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PartialPoses:
    """The poses (k, 3), ``T_map_base``, of the first k scans while SLAM runs; ``stage`` as SLAM names it."""

    fraction: float
    stage: str
    n_loops: int
    poses: NDArray[np.float64]


def do_slam_job(job: SlamJob) -> SlamOutcome:
    """Do the job. Raises :class:`mapper.core.errors.MapperError` for a log that SLAM cannot use, and limits."""
    lower_priority()
    return process.bounded(job.timeout_s, job.cpu_s, lambda: _slam(job), DOING, "slam")


def _slam(job: SlamJob) -> SlamOutcome:
    from mapper.diagnosis.figures import map_figures  # noqa: PLC0415 - only this process needs SciPy and SLAM
    from mapper.io.export import tum_text  # noqa: PLC0415
    from mapper.sensors.scan import Trajectory  # noqa: PLC0415
    from mapper.slam import SlamConfig, slam_log  # noqa: PLC0415
    from server.library.packs.graph import graph_bytes  # noqa: PLC0415

    log = log_in(job.pack)
    if not ((log.ranges >= log.range_min) & (log.ranges <= log.range_max)).any():
        raise ConfigError("slam.no_returns", "No scan of this log has a return: there is nothing to align.")
    config = SlamConfig().with_values(job.parameters)
    mapping = MappingConfig().with_values(job.mapping)
    result = slam_log(as_mapped(log, mapping), config, trajectory=job.trajectory, progress=_Reporter(job.out))
    offset = NO_OFFSET if result.odometry is None else log.trajectory(result.odometry).offset
    corrected = Trajectory(result.poses, from_scans=True, offset=offset)
    log = replace(log, trajectories={**log.trajectories, NAME: corrected})
    Path(job.out + GRAPH).write_bytes(graph_bytes(result.graph, result.candidates))
    Path(job.out + TUM).write_text(tum_text(log, NAME), encoding="ascii")
    before = log.default_trajectory if result.odometry is None else result.odometry
    along_odometry, along_slam = (map_figures(log, name, mapping) for name in (before, NAME))
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


def log_in(pack: str) -> ScanLog:
    """Return the log of a job, all sensors that it is to use as one. Raises :class:`ReadError` where it is gone."""
    try:
        return read_whole_pack(Path(pack))
    except StalePackError:
        raise ReadError("log.gone", "What was read of this log is no longer there.") from None


class _Reporter:
    """Writes how far SLAM is, at most every :data:`EVERY_S`, sooner where a loop has closed."""

    def __init__(self, out: str) -> None:
        self._path = Path(out + PROGRESS)
        self._written = 0.0
        self._loops = 0

    def __call__(self, progress: SlamProgress) -> bool:
        process.note_progress(progress.fraction)
        now = time.monotonic()
        has_closed = progress.n_loops != self._loops
        if now - self._written > (EVERY_S / 4.0 if has_closed else EVERY_S):
            self._written, self._loops = now, progress.n_loops
            about = np.array([progress.fraction, progress.n_loops], dtype=np.float64)
            with atomic_write(self._path) as file:
                np.savez(file, about=about, stage=np.array(progress.stage), poses=progress.poses)
        return True


def read_progress(out: Path) -> PartialPoses | None:
    """Return what a running job has reported last; None before the first report."""
    try:
        with np.load(out.with_name(out.name + PROGRESS), allow_pickle=False) as arrays:
            fraction, loops = arrays["about"].tolist()
            return PartialPoses(fraction, str(arrays["stage"]), int(loops), arrays["poses"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def lower_priority() -> None:
    """Let the sessions be computed first; a process of a pool does it once."""
    if sys.platform == "linux":
        wanted = os.getpriority(os.PRIO_PROCESS, os.getppid()) + NICENESS
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, max(wanted, os.getpriority(os.PRIO_PROCESS, 0)))
