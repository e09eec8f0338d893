"""Consistency of the readings of a log with each other.

Every check that asks "would the map be better if …" asks this: of the cells in which beams ended, how often did a beam
end there, of all that reached the cell? Where poses, mount and times are right, walls are hit again and again and
hardly ever passed; every error smears them over cells that other beams passed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import WorkCancelledError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import with_trajectories
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog, Trajectory

if TYPE_CHECKING:
    from mapper.diagnosis.contradiction import Contradiction

RESOLUTION = 0.1  #: metres: fine enough for a wall, coarse enough to be fast and robust to the noise of a reading
LARGEST_SIDE = 1500  #: cells: a larger place is looked at with coarser ones
PHASES = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.75))  #: of a cell: offsets of the grids over which a mean is taken
MOST_READINGS = 60_000  #: looked at; a longer log is thinned evenly
OF_THE_MOUNT = ("mount_x", "mount_y", "mount_yaw", "mount_upside_down")  #: parameters that correct it


@dataclass(frozen=True)  # without slots: what is derived once is kept
class Examined:
    """A log thinned to what is enough to judge it by, with one of its trajectories; ``scans`` are its scan numbers.

    ``wanted`` is asked before each map that is made of it: False ends the examination. ``compared`` is called with what
    the drift check measured, whether it finds drift or not.
    """

    log: ScanLog
    trajectory: str
    scans: NDArray[np.int64]
    config: MappingConfig
    time_offset: float = 0.0  #: seconds, by which the stamps were shifted to find the poses
    wanted: Callable[[], bool] = lambda: True
    compared: Callable[[Contradiction], None] = lambda _: None

    @cached_property
    def agreement(self) -> float:
        """:func:`consistency` as the log states everything: what every check compares with, computed once."""
        return consistency(self)

    def check_wanted(self) -> None:
        """Raise :class:`WorkCancelledError` where ``wanted`` returns False."""
        if not self.wanted():
            raise WorkCancelledError("doctor.unwanted", "The examination was cancelled: its session has ended.")

    def shifted(self, x: float, y: float) -> Examined:
        """Return the same scans in a map that is moved by ``x`` and ``y`` metres."""
        one = self.log.trajectory()
        by = np.array([x, y, 0.0])
        timed = None if one.timed is None else replace(one.timed, poses=one.timed.poses + by)
        moved = replace(one, poses=one.poses + by, timed=timed)
        return replace(self, log=with_trajectories(self.log, {self.trajectory: moved}))

    def part(self, which: NDArray[np.int64]) -> Examined:
        """Return the scans of these indices (n,) of what is looked at."""
        return replace(self, log=self.log.take(which), scans=self.scans[which])

    def with_poses(self, poses: NDArray[np.float64]) -> Examined:
        """Return the same scans at other poses of the base (n, 3)."""
        return replace(self, log=with_trajectories(self.log, {self.trajectory: Trajectory(poses)}))


def examined(log: ScanLog, trajectory: str | None = None, most: int = MOST_READINGS) -> Examined:
    """Return what is looked at of a log: at most ``most`` readings, whole scans, evenly spread."""
    name = trajectory or log.default_trajectory
    used = max(1, min(log.n_scans, most // max(1, log.n_beams)))
    scans = np.unique(np.linspace(0, log.n_scans - 1, used).astype(np.int64))
    thinned = with_trajectories(log, {name: Trajectory(log.trajectory(name).poses)}).take(scans)
    span = float(np.ptp(thinned.trajectory().poses[:, :2], axis=0).max()) + 2.0 * min(log.range_max, 30.0)
    resolution = min(1.0, max(RESOLUTION, span / LARGEST_SIDE))
    config = MappingConfig(model="hit_counting", resolution=resolution, range_max=min(30.0, max(0.5, log.range_max)))
    return Examined(thinned, name, scans, config)


def examined_as_mapped(log: ScanLog, trajectory: str | None, config: MappingConfig) -> tuple[ScanLog, Examined]:
    """Return the log at the middle of its sweeps, and what is looked at of it with the mount and range of ``config``.

    Raises :class:`ConfigError` for a trajectory that the log lacks.
    """
    whole = at_middle_of_sweep(log, trajectory, config.time_offset)
    seen = examined(whole, trajectory)
    values: dict[str, object] = {name: getattr(config, name) for name in OF_THE_MOUNT}
    values["range_max"] = min(config.range_max, seen.config.range_max)
    return whole, replace(seen, config=seen.config.with_values(values))


def unthinned(log: ScanLog, seen: Examined) -> Examined:
    """Return all scans of ``log`` with the trajectory and the configuration of ``seen``."""
    whole = with_trajectories(log, {seen.trajectory: log.trajectory(seen.trajectory)})
    return replace(seen, log=whole, scans=np.arange(log.n_scans))


def counts(seen: Examined, config: MappingConfig | None = None) -> OccupancyGrid:
    """Return the grid of hits and visits of what was examined. Raises :class:`WorkCancelledError`."""
    seen.check_wanted()
    config = config or seen.config
    grid = OccupancyGrid(geometry_for(seen.log, config))
    integrate_scans(grid, seen.log, config, None, 0, seen.log.n_scans)
    return grid


def consistency(seen: Examined, **parameters: object) -> float:
    """Return the share of beams that ended in a cell, of all that reached it: 0 … 1, averaged over all endpoints.

    ``parameters`` replace values of the table, as the mount. The least noise splits a wall on a border between cells,
    so the mean is taken over grids with different offsets.
    """
    config = seen.config.with_values(parameters)
    return float(
        np.mean(
            [_agreement(counts(seen.shifted(config.resolution * x, config.resolution * y), config)) for x, y in PHASES]
        )
    )


def _agreement(grid: OccupancyGrid) -> float:
    if grid.cell_statistics is None:
        return 0.0
    hit = grid.cell_statistics[0] > 0.0  # few of the cells: the rest of the grid is not looked at again
    hits, misses = grid.cell_statistics[:, hit].astype(np.float64)
    if not len(hits):
        return 0.0
    # An endpoint alone says nothing of agreement, so each is judged by the others in its cell.
    others = hits - 1.0
    share = np.divide(others, others + misses, out=np.zeros_like(hits), where=others + misses > 0)
    return float((hits * share).sum() / hits.sum())
