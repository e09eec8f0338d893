"""Occupancy grid mapping as the books print it: plain Python, one step after another.

Thrun, Burgard & Fox, Probabilistic Robotics (2005): table 4.2 (the binary Bayes filter in log-odds), table 9.1
(occupancy grid mapping), table 9.2 (the inverse range sensor model); Bresenham, Algorithm for computer control of a
digital plotter, IBM Systems Journal 4 (1965); Amanatides & Woo, A fast voxel traversal algorithm for ray tracing,
Eurographics (1987). This is the readable statement of what :mod:`mapper.kernels` compute
fast; the two agree to the last bit. ``sensor_pose`` is always ``T_map_laser``, metres and radians.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.geometry import transform_points
from mapper.grid import OccupancyGrid
from mapper.kernels.lattice import cell_of
from mapper.parameters import MappingConfig
from mapper.scan import LaserScan, beam_fields

Cell = tuple[int, int]
Point = tuple[float, float]


def bresenham(start: Cell, end: Cell) -> list[Cell]:
    """Return the cells (row, col) of the line from ``start`` to ``end``, both included, in this order.

    One step along the longer axis for each cell; ∇ says whether to step along the shorter one as well. Works in all
    eight octants by stepping with the signs of the differences and by swapping the axes of a steep line.
    """
    (row, col), (d_row, d_col) = start, (end[0] - start[0], end[1] - start[1])
    step_row, step_col = (1 if d_row >= 0 else -1), (1 if d_col >= 0 else -1)
    steep = abs(d_row) > abs(d_col)
    a, b = (abs(d_row), abs(d_col)) if steep else (abs(d_col), abs(d_row))

    cells = [(row, col)]
    nabla = 2 * b - a
    for _ in range(a):
        diagonal = nabla >= 0
        if steep or diagonal:
            row += step_row
        if not steep or diagonal:
            col += step_col
        nabla += 2 * b - 2 * a if diagonal else 2 * b
        cells.append((row, col))
    return cells


def amanatides_woo(start: Point, end: Point) -> list[Cell]:
    """Return every cell (row, col) that the segment from ``start`` to ``end`` crosses, in this order.

    The points are lattice coordinates (column, row), in cells. t counts along the segment from 0 to 1; the next border
    is that of the column or of the row, whichever has the smaller t, and through an exact corner the row's comes first.
    """
    (u, v), (d_u, d_v) = start, (end[0] - start[0], end[1] - start[1])
    (col, row), (end_col, end_row) = (int(cell_of(u)), int(cell_of(v))), (int(cell_of(end[0])), int(cell_of(end[1])))
    step_row, step_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)

    cells = [(row, col)]
    while (row, col) != (end_row, end_col):
        border_row, border_col = (row + 1 if step_row > 0 else row), (col + 1 if step_col > 0 else col)
        t_row = (border_row - v) / d_v if row != end_row else inf
        t_col = (border_col - u) / d_u if col != end_col else inf
        if t_col < t_row:
            col += step_col
        else:
            row += step_row
        cells.append((row, col))
    return cells


def bayes_filter(log_odds: np.float32, evidence: np.float32, config: MappingConfig) -> np.float32:
    """Return ℓ + log p(x|z) / p(¬x|z) − ℓ₀, clamped: table 4.2. ``evidence`` is the last two terms together."""
    low, high = config.clamp_limits
    return min(max(log_odds + evidence, np.float32(low)), np.float32(high))


def update(grid: OccupancyGrid, cell: Cell, evidence: float, config: MappingConfig) -> int:
    """Put one piece of evidence into one cell; outside the grid there is nothing to update. Return how many were."""
    if not grid.geometry.contains(cell):
        return 0
    grid.log_odds[cell] = bayes_filter(grid.log_odds[cell], np.float32(evidence), config)
    grid.observed[cell] = True
    return 1


def occupancy_grid_mapping(grid: OccupancyGrid, scan: LaserScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Update ``grid`` with one scan; return the number of cell updates."""
    if config.update == "per_scan":
        return update_per_scan(grid, scan, sensor_pose, config)
    return update_per_beam(grid, scan, sensor_pose, config)


# --- Each beam adds its evidence -------------------------------------------------------------------------------------


def update_per_beam(grid: OccupancyGrid, scan: LaserScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Follow every beam from the sensor's cell and update each cell on its way. Return the number of updates."""
    z_max = min(scan.range_max, config.range_max)
    updates = 0
    for z, bearing in zip(scan.ranges.astype(float), scan.angles, strict=True):
        evidence = evidence_of_beam(grid, sensor_pose, bearing, z, scan.range_min, z_max, config)
        updates += sum(update(grid, cell, increment, config) for cell, increment in evidence.items())
    return updates


def evidence_of_beam(
    grid: OccupancyGrid,
    sensor_pose: ArrayLike,
    bearing: float,
    z: float,
    z_min: float,
    z_max: float,
    config: MappingConfig,
) -> dict[Cell, float]:
    """Return what one beam says of each cell: a reading, no return, or (too near, NaN, −Inf) nothing at all."""
    if z_min <= z <= z_max:
        return evidence_along_beam(grid, sensor_pose, bearing, z, config)
    if z > z_max and config.no_return == "free":
        return evidence_of_no_return(grid, sensor_pose, bearing, z_max, config)
    return {}


def evidence_along_beam(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float, config: MappingConfig
) -> dict[Cell, float]:
    """Return what a reading ``z`` says of each cell on its beam.

    The beam runs on Bresenham's line from the sensor's cell to the cell at z + r/2, or crosses exactly the cells that
    Amanatides and Woo's traversal finds between the sensor and that point. A cell whose centre lies at
    distance s from the sensor is free for s < z − r/2 and occupied for |s − z| ≤ r/2; the cell that holds the
    endpoint is occupied in any case, and with r = 0 it alone is, all before it being free.
    """
    model, r = config.beam_model(), config.window
    endpoint = cell_at(grid, sensor_pose, bearing, z)

    if r == 0.0:
        evidence = dict.fromkeys(cells_along(grid, sensor_pose, bearing, z, config), model.log_odds_miss)
    else:
        evidence = {}
        for cell in cells_along(grid, sensor_pose, bearing, z + r / 2, config):
            s = distance(grid, sensor_pose, cell)
            if s < z - r / 2:
                evidence[cell] = model.log_odds_miss
            elif s <= z + r / 2:
                evidence[cell] = model.log_odds_hit
    evidence[endpoint] = model.log_odds_hit
    return evidence


def evidence_of_no_return(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z_max: float, config: MappingConfig
) -> dict[Cell, float]:
    """Return what a beam without return says: all cells up to the greatest range are free."""
    return dict.fromkeys(cells_along(grid, sensor_pose, bearing, z_max, config), config.beam_model().log_odds_miss)


def cells_along(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float, config: MappingConfig
) -> list[Cell]:
    """Return the cells that a beam crosses up to the distance ``z``, in order."""
    if config.traversal == "amanatides_woo":
        return amanatides_woo(point_at(grid, sensor_pose, bearing, 0.0), point_at(grid, sensor_pose, bearing, z))
    return bresenham(cell_at(grid, sensor_pose, bearing, 0.0), cell_at(grid, sensor_pose, bearing, z))


# --- Each cell of the perceptual field once (table 9.1) --------------------------------------------------------------


def update_per_scan(grid: OccupancyGrid, scan: LaserScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Update every cell in the scan's perceptual field once: table 9.1. Return the number of updates."""
    evidence = inverse_range_sensor_model(grid, scan, sensor_pose, config)
    in_field = ~np.isnan(evidence)
    for row, col in np.argwhere(in_field):
        update(grid, (row, col), evidence[row, col], config)
    return int(np.count_nonzero(in_field))


def inverse_range_sensor_model(
    grid: OccupancyGrid, scan: LaserScan, sensor_pose: ArrayLike, config: MappingConfig
) -> NDArray[np.float64]:
    """Return what a scan says of each cell (rows, cols), NaN outside the perceptual field: table 9.2.

    A cell whose centre lies at distance s belongs to the beam k that is nearest in bearing, at most half an increment
    away. It is free for s < z − r/2 and occupied for |s − z| ≤ r/2 and s ≤ z_max. The cells that hold the endpoints
    are occupied in any case: so a window narrower than a cell, r = 0 included, still marks where the beams ended.
    """
    model, r = config.beam_model(), config.window
    z_max = min(scan.range_max, config.range_max)
    evidence = np.full(grid.geometry.shape, np.nan)

    s, d_col, d_row = distances(grid, sensor_pose)
    heading = np.asarray(sensor_pose)[2] - grid.geometry.origin[2]
    fields = beam_fields(scan.angle_min, scan.angle_increment, len(scan.ranges))
    for z, field in zip(scan.ranges.astype(float), fields, strict=True):
        right, left = turned(heading, field[:2]), turned(heading, field[2:])
        nearest = (right[0] * d_row - right[1] * d_col >= 0) & (left[0] * d_row - left[1] * d_col < 0)
        if scan.range_min <= z <= z_max:
            evidence[nearest & (s < z - r / 2)] = model.log_odds_miss
            if r > 0.0:
                evidence[nearest & (z - r / 2 <= s) & (s <= min(z_max, z + r / 2))] = model.log_odds_hit
        elif z > z_max and config.no_return == "free":
            evidence[nearest & (s < z_max)] = model.log_odds_miss

    for z, bearing in zip(scan.ranges.astype(float), scan.angles, strict=True):
        if scan.range_min <= z <= z_max:
            endpoint = cell_at(grid, sensor_pose, bearing, z)
            if grid.geometry.contains(endpoint):
                evidence[endpoint] = model.log_odds_hit
    return evidence


# --- Why a cell is what it is ----------------------------------------------------------------------------------------


def provenance(
    grid: OccupancyGrid, scans: list[LaserScan], sensor_poses: ArrayLike, cell: Cell, config: MappingConfig
) -> list[tuple[int, int, float, np.float32]]:
    """Return scan, beam, evidence and the log-odds after it of every update that a per-beam map made to ``cell``."""
    touches = []
    log_odds = np.float32(config.log_odds_prior)
    for t, (scan, pose) in enumerate(zip(scans, np.asarray(sensor_poses), strict=True)):
        z_max = min(scan.range_max, config.range_max)
        for k, (z, bearing) in enumerate(zip(scan.ranges.astype(float), scan.angles, strict=True)):
            evidence = evidence_of_beam(grid, pose, bearing, z, scan.range_min, z_max, config)
            if cell in evidence:
                log_odds = bayes_filter(log_odds, np.float32(evidence[cell]), config)
                touches.append((t, k, evidence[cell], log_odds))
    return touches


# --- Where things are ------------------------------------------------------------------------------------------------


def cell_at(grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float) -> Cell:
    """Return the cell that holds the point at distance ``z`` along a bearing of the sensor."""
    in_laser = z * np.array([np.cos(bearing), np.sin(bearing)])
    row, col = grid.geometry.world_to_cell(transform_points(sensor_pose, in_laser))
    return int(row), int(col)


def point_at(grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float) -> Point:
    """Return the lattice coordinates (column, row), in cells, of the point at distance ``z`` along a bearing."""
    in_laser = z * np.array([np.cos(bearing), np.sin(bearing)])
    column, row = grid.geometry.to_lattice(transform_points(sensor_pose, in_laser))
    return float(column), float(row)


def distance(grid: OccupancyGrid, sensor_pose: ArrayLike, cell: Cell) -> float:
    """Return the distance s in metres from the sensor to a cell's centre."""
    col, row = grid.geometry.to_lattice(np.asarray(sensor_pose)[:2])
    d_col, d_row = cell[1] + 0.5 - col, cell[0] + 0.5 - row
    return sqrt(d_col * d_col + d_row * d_row) * grid.geometry.resolution


def distances(
    grid: OccupancyGrid, sensor_pose: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return :func:`distance` of every cell, and the offset of its centre from the sensor in columns and rows."""
    col, row = grid.geometry.to_lattice(np.asarray(sensor_pose)[:2])
    rows, cols = np.indices(grid.geometry.shape)
    d_col, d_row = cols + 0.5 - col, rows + 0.5 - row
    return np.sqrt(d_col * d_col + d_row * d_row) * grid.geometry.resolution, d_col, d_row


def turned(angle: float, direction: NDArray[np.float64]) -> tuple[float, float]:
    """Return a direction (2,) turned by an angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * direction[0] - sin * direction[1], sin * direction[0] + cos * direction[1]
