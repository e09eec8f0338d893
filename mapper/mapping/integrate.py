"""Integrate one scan, a whole log, or the logs of several sensors into a grid.

The update is ``ℓ ← clamp(ℓ + inverse_sensor_model − ℓ₀)``, Thrun, Burgard & Fox, Probabilistic Robotics, tables 9.1 and
9.2; :mod:`mapper.mapping.textbook` is the same in plain Python. Additions and clamps are done in float32, in the order
of the log: scan by scan, and within a scan from the first beam to the last.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TypeAlias, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import check_poses, compose_one
from mapper.grid import CellBox, GridGeometry, OccupancyGrid
from mapper.mapping import cell_statistics
from mapper.mapping.custom_model import add_with_model
from mapper.mapping.joint_scans import PlannedBatch, SensorOrder, planned_parts, turns_of
from mapper.mapping.kernels.one_scan import BEYOND, add_scan
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import ScanBatch, directions, scan_batch_of_scan, scan_batches_of_log
from mapper.mapping.sensor_model import InverseSensorModel
from mapper.mapping.update import WORTH_SHARING, update_grid, update_in_turns
from mapper.mapping.update_plan import UpdatePlan, check_beam_length, plan_update
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import LaserScan, RangeScan, ScanLog

#: The number of cell updates, the box (row0, row1, col0, col1), and the written cells, row · cols + col, possibly
#: repeated; None if there are too many.
Touched = tuple[int, NDArray[np.int64], NDArray[np.uint32] | None]
MOST_WRITTEN = 8192  #: maximum number of cells listed; a scan writes about 1,000 that are not at the clamp


def is_simple(scan: RangeScan, plan: UpdatePlan) -> TypeGuard[LaserScan]:
    """Return whether :func:`update_with_scan` accepts the scan: thin, evenly spaced beams traced as Bresenham lines."""
    strategy = plan.strategy
    return (
        isinstance(scan, LaserScan)
        and len(scan.ranges) < WORTH_SHARING
        and strategy.statistics == "none"
        and not (strategy.smooth or plan.draws_cones or plan.per_scan or plan.exact_rays or plan.no_return_is_hit)
    )


def update_with_scan(
    grid: OccupancyGrid, scan: LaserScan, sensor_pose: list[float], plan: UpdatePlan
) -> Touched | None:
    """Integrate a scan that satisfies :func:`is_simple`, taken at ``sensor_pose`` (3,), ``T_map_laser``.

    The mount correction is applied here. The result equals that of :func:`mapper.mapping.update.update_grid`, bit for
    bit. Returns None, with the grid unchanged, if the grid has to grow first. Raises the same errors.
    """
    geometry = grid.geometry
    check_beam_length(plan.beam_length, geometry.resolution)
    cell_statistics.begin(grid, plan.strategy)
    x, y, theta = compose_one(sensor_pose, plan.mount)
    sign = -1.0 if plan.upside_down else 1.0
    beams = _even_directions(sign, scan.angle_min, scan.angle_increment, len(scan.ranges))
    box = np.array([geometry.rows, 0, geometry.cols, 0], dtype=np.int64)
    written = np.empty(MOST_WRITTEN, dtype=np.uint32)
    count, n = add_scan(
        grid.log_odds, grid.observed, scan.ranges, (x, y, float(np.cos(theta)), float(np.sin(theta))), beams,
        geometry.frame, plan.reading_filter, plan.log_odds_update, plan.only_hits, grid.log_odds_prior, box, written,
    )  # fmt: skip
    return None if count == BEYOND else (count, box, written[:n] if n <= MOST_WRITTEN else None)


@lru_cache(maxsize=32)
def _even_directions(sign: float, angle_min: float, angle_increment: float, n_beams: int) -> NDArray[np.float64]:
    """Return the cosine and sine (n_beams, 2) of the bearings. The array is shared and must not be modified."""
    angles = angle_min + angle_increment * np.arange(n_beams)
    return directions((-angles if sign < 0.0 else angles).tobytes())


Bounds: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]  #: minimum and maximum x, y (2,), metres
BoundsFunction: TypeAlias = Callable[[ScanLog, MappingConfig, str | None], Bounds]

CHUNK_READINGS = 1 << 20  #: readings between two calls of ``progress``
PART_S = 0.02  #: processor time of the calling thread for one part of a log


@dataclass(frozen=True, slots=True)
class Change:
    """The effect of an update. The touched cells are in ``box`` (None: none).

    ``geometry_changed`` means that the origin of rows and columns or the resolution has changed, so every cell must be
    read again. ``cells_updated`` counts the additions.
    """

    box: CellBox | None
    geometry_changed: bool
    cells_updated: int
    #: The cells of ``box`` that changed, ``row · cols + col``, possibly repeated; None: not listed.
    cells: NDArray[np.uint32] | None = field(default=None, compare=False)


def _add(grid: OccupancyGrid, batch: ScanBatch, plan: UpdatePlan) -> Change:
    return _change(*update_grid(grid, batch, plan))


def _add_parts(grid: OccupancyGrid, parts: Sequence[PlannedBatch]) -> Change:
    if len(parts) == 1:
        return _add(grid, parts[0].batch, parts[0].plan)
    return _change(*update_in_turns(grid, parts[0].plan, [turns_of(parts, grid.geometry)]))


def _change(count: int, box: NDArray[np.int64], cells: NDArray[np.uint32] | None = None) -> Change:
    touched = CellBox(*box.tolist()) if box[1] > box[0] else None
    return Change(touched, geometry_changed=False, cells_updated=count, cells=cells)


def bounds_of_log(log: ScanLog, config: MappingConfig, trajectory: str | None = None) -> Bounds:
    """Return the minimum and maximum x, y (2,), metres, of everything that ``log`` observes with ``config``."""
    if isinstance(log, JointLog):
        return bounds_of_logs(log.parts, config, trajectory)
    plan = plan_update(config, log.range_min, log.range_max)
    batches = scan_batches_of_log(log, plan, trajectory, 0, log.n_scans)
    bounds = [batch.bounds(plan.reading_filter, fields=plan.sees_fields) for batch in batches]
    return np.min([low for low, _ in bounds], axis=0), np.max([high for _, high in bounds], axis=0)


def bounds_of_logs(logs: Sequence[ScanLog], config: MappingConfig, trajectory: str | None = None) -> Bounds:
    """Return the minimum and maximum x, y (2,), metres, of everything that the logs observe with ``config``."""
    bounds = [bounds_of_log(log, config, trajectory) for log in logs if log.n_scans]
    return np.min([low for low, _ in bounds], axis=0), np.max([high for _, high in bounds], axis=0)


def geometry_for(
    log: ScanLog,
    config: MappingConfig,
    trajectory: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    bounds_of: BoundsFunction = bounds_of_log,
) -> GridGeometry:
    """Return a geometry that contains everything that ``log`` observes with ``config``, at ``config.resolution``.

    It is axis-aligned, consists of whole tiles, and is the same for all parts of a log with equal extent. Raises
    :class:`mapper.core.errors.LimitError` if that is more cells than ``limits`` allow, and
    :class:`mapper.core.errors.ConfigError` for a trajectory that the log lacks or a log without scans.
    """
    if log.n_scans == 0:
        raise ConfigError("log.no_scans", "A log without scans covers no area.")
    low, high = bounds_of(log, config, trajectory)
    # One more cell on each side, so that an endpoint on the border is not rounded out of the grid.
    return GridGeometry.covering(low - config.resolution, high + config.resolution, config.resolution, limits)


def grid_for(
    log: ScanLog,
    config: MappingConfig,
    trajectory: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    prior: OccupancyGrid | None = None,
    bounds_of: BoundsFunction = bounds_of_log,
) -> OccupancyGrid:
    """Return an empty grid that contains everything that ``log`` observes with ``config``.

    ``bounds_of`` computes the bounds like :func:`bounds_of_log`; a caller can pass a caching version. With ``prior``, a
    map in the same frame, mapping starts from that map, on its lattice (origin and yaw), extended to the bounds of the
    log. Raises the errors of :func:`geometry_for`, and :class:`mapper.core.errors.ConfigError` if the resolution of
    ``prior`` differs from ``config.resolution``.
    """
    if prior is None:
        return OccupancyGrid(geometry_for(log, config, trajectory, limits, bounds_of), config.log_odds_prior)
    check_resolution(prior, config)
    if log.n_scans == 0:
        raise ConfigError("log.no_scans", "A log without scans covers no area.")
    grid = prior.as_prior(config.log_odds_prior)
    grid.grow_to_include(*bounds_of(log, config, trajectory))
    return grid


def check_resolution(prior: OccupancyGrid, config: MappingConfig) -> None:
    """Raise :class:`mapper.core.errors.ConfigError` unless ``prior`` has the resolution ``config.resolution``."""
    resolution = prior.geometry.resolution
    if abs(resolution - config.resolution) > 1e-6 * resolution:
        raise ConfigError(
            "grid.resolution",
            f"The prior map has cells of {resolution:g} m and the map to be made of {config.resolution:g} m; "
            "they must be the same.",
        )


def integrate_scan(
    grid: OccupancyGrid,
    scan: RangeScan,
    sensor_pose: ArrayLike,
    config: MappingConfig,
    model: InverseSensorModel | None = None,
) -> Change:
    """Integrate one scan. The grid first grows if the scan reaches beyond its border; existing cells do not move.

    ``sensor_pose`` (3,) is ``T_map_laser`` as reported by the robot; ``config.mount`` is composed onto it here.
    ``model`` replaces the sensor model that ``config.model`` names; traversal, range limits, treatment of no return and
    clamp remain those of ``config``. Raises :class:`mapper.core.errors.ConfigError` for a pose that is not finite or
    too far away, or a model that does not return finite increments of the right shape, and
    :class:`mapper.core.errors.LimitError` if the grid would grow too large. The grid is then unchanged.
    """
    pose = np.asarray(sensor_pose, dtype=np.float64)
    if not _is_within(sensor_pose, grid.geometry.limits.max_pose):
        check_poses(pose, (3,), grid.geometry.limits)
    plan = plan_update(config, scan.range_min, scan.range_max)
    if model is None and is_simple(scan, plan):
        touched = update_with_scan(grid, scan, pose.tolist(), plan)
        if touched is not None:
            return _change(*touched)
    batch = scan_batch_of_scan(scan, pose, plan)
    if model is not None:
        count, box, grown = add_with_model(grid, batch, plan, model)
        return Change(CellBox(*box) if count else None, grown, count)
    grown = grid.grow_to_include(*batch.bounds(plan.reading_filter, fields=plan.sees_fields))
    change = _add(grid, batch, plan)
    return Change(change.box, grown, change.cells_updated)


def _is_within(pose: ArrayLike, most: float) -> bool:
    """Return whether a pose is a tuple of three finite numbers, the first two within ±``most``, as of a live robot."""
    if not (isinstance(pose, tuple) and len(pose) == 3):
        return False
    x, y, yaw = pose
    return abs(x) <= most and abs(y) <= most and math.isfinite(yaw)


def integrate_scans(
    grid: OccupancyGrid, log: ScanLog, config: MappingConfig, trajectory: str | None, start: int, stop: int
) -> Change:
    """Integrate the scans [start, stop) of a log. The grid does not grow; cells outside it are clipped."""
    return _integration(grid, log, config, trajectory)(start, stop)


def integrate_order(
    grid: OccupancyGrid, order: SensorOrder, config: MappingConfig, trajectory: str | None, start: int, stop: int
) -> Change:
    """Integrate the scans [start, stop) of several sensors like :func:`integrate_scans`."""
    return _all(_add_parts(grid, parts) for parts in planned_parts(order, config, trajectory, start, stop))


def _integration(
    grid: OccupancyGrid, log: ScanLog, config: MappingConfig, trajectory: str | None
) -> Callable[[int, int], Change]:
    """Return a function that integrates the scans [start, stop) of a log. One sensor's update is planned only once."""
    if isinstance(log, JointLog):
        return partial(integrate_order, grid, SensorOrder.of(log), config, trajectory)
    plan = plan_update(config, log.range_min, log.range_max)

    def integrate(start: int, stop: int) -> Change:
        return _all(_add(grid, batch, plan) for batch in scan_batches_of_log(log, plan, trajectory, start, stop))

    return integrate


def _all(changes: Iterable[Change]) -> Change:
    """Return the union of several changes."""
    box, count = None, 0
    for change in changes:
        count += change.cells_updated
        box = change.box if box is None else box if change.box is None else box | change.box
    return Change(box, geometry_changed=False, cells_updated=count)


def integrate_parts(
    grid: OccupancyGrid, log: ScanLog, config: MappingConfig, trajectory: str | None, start: int, stop: int
) -> Iterator[tuple[int, Change]]:
    """Integrate the scans [start, stop) of a log in parts of about :data:`PART_S`.

    After each part, yield the number of scans of the log that are in the map and the change made by the part. The map
    equals that of :func:`integrate_scans`, bit for bit.
    """
    integrate = _integration(grid, log, config, trajectory)
    count = 1  # start with one: a scan of sonar cones touches a million cells
    while start < stop:
        last = min(start + count, stop)
        began = time.thread_time()
        change = integrate(start, last)
        count = scans_at_once(last - start, time.thread_time() - began)
        start = last
        yield start, change


def scans_at_once(scans: int, seconds: float) -> int:
    """Return the number of scans that take about :data:`PART_S`, given that the last ``scans`` took ``seconds``."""
    return max(1, min(4 * scans, int(scans * PART_S / max(seconds, 1e-6))))


def integrate_log(
    grid: OccupancyGrid,
    log: ScanLog,
    config: MappingConfig,
    trajectory: str | None = None,
    start: int = 0,
    stop: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Integrate the scans [start, stop) of ``log`` into ``grid``; return the number of cell updates.

    The grid does not grow, and cells outside it are clipped; use :func:`geometry_for` for a grid that holds the whole
    log. ``progress(done, total)``, in scans, is called from time to time. Raises
    :class:`mapper.core.errors.ConfigError` for scans that the log does not have.
    """
    stop = log.n_scans if stop is None else stop
    if not 0 <= start <= stop <= log.n_scans:
        raise ConfigError("log.scans", f"The log has no scans {start} to {stop}; it has {log.n_scans}.")
    integrate = _integration(grid, log, config, trajectory)
    if progress is None:
        return integrate(start, stop).cells_updated
    count = 0
    step = max(1, CHUNK_READINGS // max(1, log.n_beams))
    for first in range(start, stop, step):
        last = min(first + step, stop)
        count += integrate(first, last).cells_updated
        progress(last - start, stop - start)
    return count


def integrate_logs(
    grid: OccupancyGrid,
    logs: Sequence[ScanLog],
    config: MappingConfig,
    trajectory: str | None = None,
    count: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Integrate the first ``count`` scans (None: all) of the logs into ``grid``; return the number of cell updates.

    The logs are those of the sensors of one recording. Each has its own mount and a trajectory of the given name, all
    in one frame. ``progress(done, total)``, in scans, is called from time to time. Cells outside the grid are clipped.
    Raises :class:`ConfigError` for a trajectory that a log lacks, or for more scans than there are.
    """
    if len(logs) == 1:
        return integrate_log(grid, logs[0], config, trajectory, 0, count, progress)
    have = sum(log.n_scans for log in logs)
    total = have if count is None else count
    if not 0 <= total <= have:
        raise ConfigError("log.scans", f"The logs have no scans 0 to {total}; they have {have}.")
    order = SensorOrder.of_logs(logs)
    step = max(1, CHUNK_READINGS // max(1, *(log.n_beams for log in logs)))
    updated = 0
    for first in range(0, total, step):
        last = min(first + step, total)
        updated += integrate_order(grid, order, config, trajectory, first, last).cells_updated
        if progress is not None:
            progress(last, total)
    return updated
