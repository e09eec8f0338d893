"""Put one scan, or a whole log, into a grid.

The update is ``ℓ ← clamp(ℓ + inverse_sensor_model − ℓ₀)``, Thrun, Burgard & Fox, Probabilistic Robotics, tables 9.1 and
9.2; :mod:`mapper.textbook` says the same in plain Python. Additions and clamps are done in float32, in the order of
the log: scans one after another, and beams of a scan from the first to the last.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.errors import ConfigError
from mapper.geometry import compose
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.kernels.field import add_fields
from mapper.kernels.rays import add_rays, reach
from mapper.kernels.types import Sight
from mapper.limits import DEFAULT_LIMITS, Limits
from mapper.parameters import MappingConfig
from mapper.scan import LaserScan, ScanLog, beam_fields, check_poses

_CHUNK_READINGS = 1 << 20  # between two calls of ``progress``


@dataclass(frozen=True, slots=True)
class CellBox:
    """The cells [row0, row1) × [col0, col1)."""

    row0: int
    row1: int
    col0: int
    col1: int


@dataclass(frozen=True, slots=True)
class Change:
    """What an update did: the cells it touched lie in ``box`` (None: it touched none).

    ``geometry_changed`` says that rows and columns are counted from another origin than before or that the
    resolution is another: every cell must be read anew. ``cells_updated`` counts the additions made.
    """

    box: CellBox | None
    geometry_changed: bool
    cells_updated: int


@dataclass(frozen=True, slots=True)
class _Sweep:
    """Scans as the kernels take them."""

    ranges: NDArray[np.float32]  # (n_scans, n_beams)
    sensor_poses: NDArray[np.float64]  # (n_scans, 3), T_map_laser
    angles: NDArray[np.float64]  # (n_beams,)
    fields: NDArray[np.float64]  # (n_beams, 4)
    range_min: float
    range_max: float

    @property
    def sensors(self) -> NDArray[np.float64]:
        """(n_scans, 4): x, y, cos θ, sin θ."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2])
        return np.column_stack([self.sensor_poses[:, :2], np.cos(theta), np.sin(theta)])

    @property
    def beams(self) -> NDArray[np.float64]:
        """(n_beams, 2): cosine and sine of the bearings."""
        return np.column_stack([np.cos(self.angles), np.sin(self.angles)])

    def headings(self, geometry: GridGeometry) -> NDArray[np.float64]:
        """(n_scans, 2): cosine and sine of the sensor's heading along the lattice."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2] - geometry.origin[2])
        return np.column_stack([np.cos(theta), np.sin(theta)])

    def sight(self, config: MappingConfig) -> Sight:
        """Which readings count and how, as the kernels take it."""
        return (self.range_min, self.range_max, config.window, config.no_return == "free")

    def bounds(self, config: MappingConfig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The least and greatest x, y (2,) of the sensors and of all that they see."""
        out = np.array([np.inf, np.inf, -np.inf, -np.inf])
        directions = [self.beams]
        if config.update == "per_scan" and len(self.fields):
            # A field ends in an arc. It lies within the corners of the polygon around it: right, middle and left.
            right, left = self.fields[:, :2], self.fields[:, 2:]
            cos_half = np.minimum(np.sum(right * self.beams, axis=1), np.sum(left * self.beams, axis=1))
            stretch = 1.0 / np.cos(0.5 * np.arccos(np.clip(cos_half, 0.0, 1.0)))[:, np.newaxis]
            directions = [right * stretch, self.beams * stretch, left * stretch]
        for direction in directions:
            reach(self.ranges, self.sensors, np.ascontiguousarray(direction), self.sight(config), out)
        return out[:2], out[2:]

    def add_to(self, grid: OccupancyGrid, config: MappingConfig) -> Change:
        """Add all scans; what falls outside the grid is clipped."""
        geometry, model = grid.geometry, config.beam_model()
        low, high = (np.float32(limit) for limit in config.clamp_limits)
        rule = (np.float32(model.log_odds_miss), np.float32(model.log_odds_hit), low, high)
        frame, sight = geometry.frame, self.sight(config)
        box = np.array([geometry.rows, 0, geometry.cols, 0], dtype=np.int64)
        target, scans = (grid.log_odds, grid.observed, box), (self.ranges, self.sensors, self.beams)
        if config.update == "per_scan":
            paint = np.zeros(geometry.shape, dtype=np.uint8)
            count = int(add_fields(*target, paint, *scans, self.fields, self.headings(geometry), frame, sight, rule))
        else:
            count = int(add_rays(*target, *scans, frame, sight, rule))
        touched = CellBox(*(int(n) for n in box)) if box[1] > box[0] else None
        return Change(touched, geometry_changed=False, cells_updated=count)


def _sweep_of_log(log: ScanLog, config: MappingConfig, trajectory: str | None, start: int, stop: int) -> _Sweep:
    turn = -1.0 if log.upside_down else 1.0
    return _Sweep(
        log.ranges[start:stop],
        compose(log.sensor_poses(trajectory)[start:stop], np.array(config.mount)),
        log.angles,
        beam_fields(turn * log.angle_min, turn * log.angle_increment, log.n_beams),
        log.range_min,
        min(log.range_max, config.range_max),
    )


def geometry_for(
    log: ScanLog, config: MappingConfig, trajectory: str | None = None, limits: Limits = DEFAULT_LIMITS
) -> GridGeometry:
    """Return the geometry that holds all that ``log`` sees with ``config``, at ``config.resolution`` metres a cell.

    It is axis-aligned, of whole tiles, and the same for every part of a log that reaches equally far. Raises
    :class:`mapper.errors.LimitError` where that is more cells than ``limits`` allow, and
    :class:`mapper.errors.ConfigError` for a trajectory that the log lacks or a log without scans.
    """
    if log.n_scans == 0:
        raise ConfigError("log.no_scans", "A log without scans covers no place.")
    low, high = _sweep_of_log(log, config, trajectory, 0, log.n_scans).bounds(config)
    # A cell to spare on each side: an endpoint on the border itself must not be rounded out of the grid.
    return GridGeometry.covering(low - config.resolution, high + config.resolution, config.resolution, limits)


def integrate_scan(grid: OccupancyGrid, scan: LaserScan, sensor_pose: ArrayLike, config: MappingConfig) -> Change:
    """Add one scan to the grid, which grows first where the robot sees beyond its border.

    ``sensor_pose`` (3,) is ``T_map_laser`` as the robot states it; ``config.mount`` is composed onto it here. Growth
    moves nothing that is there. Raises :class:`mapper.errors.ConfigError` for a pose that is not finite or too far
    out and :class:`mapper.errors.LimitError` for a grid that would grow too large; the grid is then unchanged.
    """
    pose = np.asarray(sensor_pose, dtype=np.float64)
    check_poses(pose, (3,), grid.geometry.limits)
    sweep = _Sweep(
        scan.ranges[np.newaxis],
        compose(pose, np.array(config.mount))[np.newaxis],
        scan.angles,
        beam_fields(scan.angle_min, scan.angle_increment, len(scan.ranges)),
        scan.range_min,
        min(scan.range_max, config.range_max),
    )
    grown = grid.grow_to_include(*sweep.bounds(config))
    change = sweep.add_to(grid, config)
    return Change(change.box, grown, change.cells_updated)


def integrate_scans(
    grid: OccupancyGrid, log: ScanLog, config: MappingConfig, trajectory: str | None, start: int, stop: int
) -> Change:
    """Add the scans [start, stop) of a log; the grid stays as large as it is and what falls outside is clipped."""
    return _sweep_of_log(log, config, trajectory, start, stop).add_to(grid, config)


def integrate_log(
    grid: OccupancyGrid,
    log: ScanLog,
    config: MappingConfig,
    trajectory: str | None = None,
    start: int = 0,
    stop: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Add the scans [start, stop) of ``log`` to ``grid``; return the number of cell updates.

    The grid stays as large as it is (:func:`geometry_for` makes one that holds all) and what falls outside is
    clipped. ``progress(done, total)`` is called now and then with scans. Raises
    :class:`mapper.errors.ConfigError` for scans that the log does not have.
    """
    stop = log.n_scans if stop is None else stop
    if not 0 <= start <= stop <= log.n_scans:
        raise ConfigError("log.scans", f"The log has no scans {start} to {stop}; it has {log.n_scans}.")
    if progress is None:
        return integrate_scans(grid, log, config, trajectory, start, stop).cells_updated
    count = 0
    step = max(1, _CHUNK_READINGS // max(1, log.n_beams))
    for first in range(start, stop, step):
        last = min(first + step, stop)
        count += integrate_scans(grid, log, config, trajectory, first, last).cells_updated
        progress(last - start, stop - start)
    return count
