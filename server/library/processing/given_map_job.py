"""The job of a worker process that makes the map to localize a log in: from map files, or from another log's scans."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mapper.core.errors import LimitError, ReadError
from server.jobs import process
from server.library.packs.given_map import GivenMap
from server.library.packs.map_files import read_map
from server.library.processing.slam_job import log_in

DOING = "Making this map"  #: in errors
RESOLUTIONS = (0.05, 0.1, 0.2, 0.5)  #: metres a cell: the first that the limits allow
MOST_CELLS = 1 << 26


@dataclass(frozen=True, slots=True)
class GivenMapJob:
    """Make the map ``title`` in the file ``out``.

    ``source`` is the pack of a log, mapped along its ``trajectory``; or, where that is None, the map files: a tar
    archive of a yaml and its image, or a map of CMU's course.
    """

    source: str
    out: str
    title: str
    trajectory: str | None
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[GivenMapJob], GivenMap]:
        """The function that does it."""
        return do_given_map_job

    def time_error(self) -> LimitError:
        """Return the error for a job that takes too long."""
        return process.time_error(self.timeout_s, DOING, "map")


def do_given_map_job(job: GivenMapJob) -> GivenMap:
    """Do the job. Raises :class:`mapper.core.errors.MapperError` for a file that is no map, and for limits."""
    return process.bounded(job.timeout_s, job.cpu_s, lambda: _made(job), DOING, "map")


def _made(job: GivenMapJob) -> GivenMap:
    given = (
        read_map(Path(job.source), job.title, Path(job.out).parent)
        if job.trajectory is None
        else _of_log(job, job.trajectory)
    )
    if given.values.size > MOST_CELLS:
        raise LimitError("map.cells", f"The map has {given.values.size:,} cells; at most {MOST_CELLS:,} are used here.")
    if not (given.values >= 0).any():
        raise ReadError("map.empty", "The map has no known cells: nothing can be localized in it.")
    given.write(Path(job.out))
    process.note_progress(1.0)
    return given


def _of_log(job: GivenMapJob, trajectory: str) -> GivenMap:
    from mapper.io.maps import occupancy_values  # noqa: PLC0415 - only this process maps
    from mapper.mapping.integrate import grid_for, integrate_log  # noqa: PLC0415
    from mapper.mapping.parameters import BY_NAME, MappingConfig  # noqa: PLC0415
    from mapper.mapping.sensor_defaults import sensor_defaults  # noqa: PLC0415

    log = log_in(job.source)
    row = BY_NAME["range_max"]
    reach = min(max(min(log.range_max, row.initial), row.low), row.high)
    config = MappingConfig().with_values(sensor_defaults(log.beam_width, {"range_max": reach}))
    for resolution in RESOLUTIONS:
        config = config.with_values({"resolution": resolution})
        try:
            grid = grid_for(log, config, trajectory)
        except LimitError:
            if resolution == RESOLUTIONS[-1]:
                raise
            continue
        if grid.log_odds.size <= MOST_CELLS:
            break
    integrate_log(grid, log, config, trajectory)
    return GivenMap(job.title, grid.geometry, occupancy_values(grid))
