"""Occupancy grid mapping as in the literature, step by step in plain Python.

Thrun, Burgard & Fox, Probabilistic Robotics (2005): table 4.2 (the binary Bayes filter in log-odds), table 9.1
(occupancy grid mapping), table 9.2 (the inverse range sensor model). Beam traversal is in
:mod:`mapper.mapping.textbook_traversal`. This is the readable version of :mod:`mapper.mapping.kernels`. The two agree
to the last bit, or to 1e-6 if exponentials, angles or powers are involved. ``sensor_pose`` is always ``T_map_laser``,
metres and radians.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.se2 import transform_points
from mapper.grid import OccupancyGrid, log_odds, probability
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.sensor_model import HitCounting, MoravecElfes
from mapper.mapping.textbook_traversal import Cell, Point, amanatides_woo, bresenham
from mapper.sensors.scan import RangeScan

NumberedEvidence: TypeAlias = list[tuple[int, dict[Cell, float]]]  #: the evidence of each beam, with the beam's index
View: TypeAlias = tuple[RangeScan, ArrayLike]  #: a scan and the pose ``T_map_laser`` (3,) from which it was measured


def bayes_filter(log_odds: np.float32, evidence: np.float32, config: MappingConfig) -> np.float32:
    """Return ℓ + log p(x|z) / p(¬x|z) − ℓ₀, clamped: table 4.2. ``evidence`` is the sum of the last two terms."""
    low, high = config.clamp_limits
    return min(max(log_odds + evidence, np.float32(low)), np.float32(high))


def update(grid: OccupancyGrid, cell: Cell, evidence: float, config: MappingConfig) -> int:
    """Add one piece of evidence to one cell, if it is in the grid. Return the number of updates, 0 or 1."""
    if not grid.geometry.contains(cell):
        return 0
    grid.log_odds[cell] = bayes_filter(grid.log_odds[cell], np.float32(evidence), config)
    grid.observed[cell] = True
    return 1


def occupancy_grid_mapping(grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Update ``grid`` with one scan; return the number of cell updates."""
    if config.model == "moravec_elfes":
        return update_moravec_elfes(grid, scan, sensor_pose, config)
    if config.model == "hit_counting":
        return count_hits_and_misses(grid, scan, sensor_pose, config)
    if config.update == "per_scan":
        return update_per_scan(grid, scan, sensor_pose, config)
    if config.only_hits:
        return update_hits_first(grid, [(scan, sensor_pose)], config)
    return update_per_beam(grid, scan, sensor_pose, config)


# --- Each beam adds its evidence -------------------------------------------------------------------------------------


def update_per_beam(grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Trace every beam from the sensor's cell and update each cell that it crosses. Return the number of updates."""
    z_max = min(scan.range_max, config.range_max)
    updates = 0
    for z, bearing in zip(readings(scan, config), scan.angles, strict=True):
        evidence = evidence_of_beam(grid, sensor_pose, bearing, z, scan.range_min, z_max, config)
        updates += sum(update(grid, cell, increment, config) for cell, increment in evidence.items())
    return updates


def readings(scan: RangeScan, config: MappingConfig) -> NDArray[np.float64]:
    """Return the scan's ranges. If no return counts as a hit (a mistake), those become z_max.

    Ranges are stored as float32, so z_max is rounded to the greatest float32 that does not exceed it.
    """
    ranges = scan.ranges.astype(np.float64)
    z_max = min(scan.range_max, config.range_max)
    if config.no_return == "hit":
        greatest = float(np.float32(z_max))
        if greatest > z_max:
            greatest = float(np.nextafter(np.float32(z_max), np.float32(0)))
        ranges[ranges > z_max] = greatest
    return ranges


def evidence_of_beam(
    grid: OccupancyGrid,
    sensor_pose: ArrayLike,
    bearing: float,
    z: float,
    z_min: float,
    z_max: float,
    config: MappingConfig,
) -> dict[Cell, float]:
    """Return the evidence of one beam for each cell: a reading, no return, or nothing (too near, NaN, −Inf)."""
    is_cone = config.model == "sonar_cone"
    if z_min <= z <= z_max:
        if is_cone:
            return evidence_in_cone(grid, sensor_pose, bearing, z, z_max, config)
        return evidence_along_beam(grid, sensor_pose, bearing, z, config)
    if z > z_max and config.no_return == "free":
        if is_cone:
            cells, r, _ = cells_in_cone(grid, sensor_pose, bearing, config.opening)
            free = r < z_max
            return dict.fromkeys(map(tuple, cells[free].tolist()), config.beam_model().log_odds_miss)
        return evidence_of_no_return(grid, sensor_pose, bearing, z_max, config)
    return {}


def evidence_in_cone(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float, z_max: float, config: MappingConfig
) -> dict[Cell, float]:
    """Return the evidence of a sonar reading ``z`` for each cell in its cone, up to z + w/2."""
    model = config.beam_model()
    cells, r, theta = cells_in_cone(grid, sensor_pose, bearing, config.opening)
    near = r <= min(z + model.half_window(z), z_max)
    increments = model.increment(r[near], z, within(theta[near], config.opening))
    return dict(zip(map(tuple, cells[near].tolist()), increments.tolist(), strict=True))


def cells_in_cone(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, opening: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the cells (n, 2) with centres in a cone, right edge included, and r and φ of each (n,)."""
    r, d_col, d_row = distances(grid, sensor_pose)
    heading = np.asarray(sensor_pose)[2] - grid.geometry.origin[2]
    right, left = (
        turned(heading, np.array([np.cos(edge), np.sin(edge)]))
        for edge in (bearing - opening / 2.0, bearing + opening / 2.0)
    )
    inside = (right[0] * d_row - right[1] * d_col >= 0) & (left[0] * d_row - left[1] * d_col < 0)
    axis = turned(heading, np.array([np.cos(bearing), np.sin(bearing)]))
    theta = np.arctan2(axis[0] * d_row - axis[1] * d_col, axis[0] * d_col + axis[1] * d_row)
    return np.argwhere(inside), r[inside], theta[inside]


def evidence_along_beam(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float, config: MappingConfig
) -> dict[Cell, float]:
    """Return the evidence of a reading ``z`` for each cell on its beam.

    The beam is Bresenham's line from the sensor's cell to the cell at z + w/2, or Amanatides and Woo's traversal from
    the sensor to that point. A cell whose centre is at distance r from the sensor is free for r < z − w/2 and occupied
    for |r − z| ≤ w/2 (for the smooth ramp: between the two); the cell that holds the endpoint is always occupied. With
    w = 0 it is the only occupied cell, and all cells before it are free.
    """
    model = config.beam_model()
    half = model.half_window(z)
    endpoint = cell_at(grid, sensor_pose, bearing, z)

    if half == 0.0:
        evidence = dict.fromkeys(cells_along(grid, sensor_pose, bearing, z, config), model.log_odds_miss)
    else:
        evidence = {}
        for cell in cells_along(grid, sensor_pose, bearing, z + half, config):
            r = distance(grid, sensor_pose, cell)
            if r <= z + half:
                evidence[cell] = float(model.increment(r, z)) if r >= z - half else model.log_odds_miss
    evidence[endpoint] = model.log_odds_hit
    return evidence


def evidence_of_no_return(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z_max: float, config: MappingConfig
) -> dict[Cell, float]:
    """Return the evidence of a beam without return: all cells up to the maximum range are free."""
    return dict.fromkeys(cells_along(grid, sensor_pose, bearing, z_max, config), config.beam_model().log_odds_miss)


def cells_along(
    grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float, config: MappingConfig
) -> list[Cell]:
    """Return the cells that a beam crosses up to distance ``z``, in order."""
    if config.traversal == "amanatides_woo":
        return amanatides_woo(point_at(grid, sensor_pose, bearing, 0.0), point_at(grid, sensor_pose, bearing, z))
    return bresenham(cell_at(grid, sensor_pose, bearing, 0.0), cell_at(grid, sensor_pose, bearing, z))


# --- In the cells that a scan hits, only the hits count --------------------------------------------------------------


def update_hits_first(grid: OccupancyGrid, views: Sequence[View], config: MappingConfig) -> int:
    """Update each cell that the beams of one scan cross, hits first. Return the number of updates.

    ``views`` holds the scan and its pose or, for a deskewed scan, each beam and its pose.
    """
    beams = hits_before_misses(evidence_of_beams(grid, views, config), config)
    return sum(update(grid, cell, increment, config) for _, evidence in beams for cell, increment in evidence.items())


def evidence_of_beams(grid: OccupancyGrid, views: Sequence[View], config: MappingConfig) -> NumberedEvidence:
    """Return the evidence of each beam of one scan for each cell."""
    evidence = []
    for scan, sensor_pose in views:
        z_max = min(scan.range_max, config.range_max)
        for z, bearing in zip(readings(scan, config), scan.angles, strict=True):
            evidence.append(evidence_of_beam(grid, sensor_pose, bearing, z, scan.range_min, z_max, config))
    return list(enumerate(evidence))


def hits_before_misses(beams: NumberedEvidence, config: MappingConfig) -> NumberedEvidence:
    """Return the hits of all beams of a scan, then their misses, with 0 for cells that the scan hits.

    A beam that meets a wall at a grazing angle passes cells in which neighbouring beams end, although the wall is
    there. Sources: OctoMap, whose ``computeUpdate`` removes the occupied cells of a scan from its free ones, and
    Cartographer, whose ``ProbabilityGridRangeDataInserter2D`` gives hits priority. Both update a cell once per scan;
    here the hits of all beams add up.
    """
    hit = config.beam_model().log_odds_hit
    hits = [(k, {cell: value for cell, value in evidence.items() if value == hit}) for k, evidence in beams]
    cells_hit = {cell for _, evidence in hits for cell in evidence}
    misses = [
        (k, {cell: 0.0 if cell in cells_hit else value for cell, value in evidence.items() if value != hit})
        for k, evidence in beams
    ]
    return hits + misses


# --- Each cell of the perceptual field once (table 9.1) --------------------------------------------------------------


def update_per_scan(grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Update every cell in the scan's perceptual field once: table 9.1. Return the number of updates."""
    evidence = inverse_range_sensor_model(grid, scan, sensor_pose, config)
    in_field = ~np.isnan(evidence)
    for row, col in np.argwhere(in_field):
        update(grid, (row, col), evidence[row, col], config)
    return int(np.count_nonzero(in_field))


def inverse_range_sensor_model(
    grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig
) -> NDArray[np.float64]:
    """Return the evidence of a scan for each cell (rows, cols), NaN outside the perceptual field: table 9.2.

    A cell whose centre is at distance r belongs to the beam k nearest in bearing, at most half an increment away (for a
    sonar cone, at most half its opening angle). It is free for r < z − w/2 and occupied for |r − z| ≤ w/2 and r ≤
    z_max. The cells that hold the endpoints of thin beams are always occupied, so a window narrower than a cell, even w
    = 0, still marks the endpoints.
    """
    model, is_cone = config.beam_model(), config.model == "sonar_cone"
    z_max = min(scan.range_max, config.range_max)
    evidence = np.full(grid.geometry.shape, np.nan)

    r, d_col, d_row = distances(grid, sensor_pose)
    heading = np.asarray(sensor_pose)[2] - grid.geometry.origin[2]
    fields = scan.fields(config.opening / 2.0) if is_cone else scan.fields()
    for z, bearing, field in zip(readings(scan, config), scan.angles, fields, strict=True):
        right, left = turned(heading, field[:2]), turned(heading, field[2:])
        nearest = (right[0] * d_row - right[1] * d_col >= 0) & (left[0] * d_row - left[1] * d_col < 0)
        if scan.range_min <= z <= z_max:
            half = model.half_window(z)
            axis = turned(heading, np.array([np.cos(bearing), np.sin(bearing)]))
            theta = np.arctan2(axis[0] * d_row - axis[1] * d_col, axis[0] * d_col + axis[1] * d_row)
            near = nearest & (r < z - half if half == 0.0 else r <= min(z_max, z + half))
            # The nearest beam was found above; the angle itself matters only in a cone.
            evidence[near] = model.increment(r[near], z, within(theta[near], config.opening) if is_cone else 0.0)
        elif z > z_max and config.no_return == "free":
            evidence[nearest & (r < z_max)] = model.log_odds_miss

    for z, bearing in zip(readings(scan, config), scan.angles, strict=True):
        if scan.range_min <= z <= z_max and not is_cone:
            endpoint = cell_at(grid, sensor_pose, bearing, z)
            if grid.geometry.contains(endpoint):
                evidence[endpoint] = model.log_odds_hit
    return evidence


# --- Models that count, or that keep two certainties -----------------------------------------------------------------


def count_hits_and_misses(grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Count for each cell how often beams end in it and how often they pass it. Return the number of updates.

    The cells are chosen as for fixed increments. ``grid.cell_statistics`` holds the hits n and the misses m, and
    ``grid.log_odds`` the log-odds of their posterior mean (n + w·p₀) / (n + m + w), clamped. p₀ is the cell's own
    prior.
    """
    model = cast("HitCounting", config.beam_model())
    hits, misses = statistics_of(grid, config)
    before = hits + misses
    counting = config.with_values(
        {"model": "fixed_increments", "clamp": False, "log_odds_hit": 1.0, "log_odds_miss": -1.0}
    )
    counted = OccupancyGrid(grid.geometry)
    if config.update == "per_scan":
        evidence = inverse_range_sensor_model(counted, scan, sensor_pose, counting)
        hits += evidence == 1.0
        misses += evidence == -1.0
    else:
        z_max = min(scan.range_max, config.range_max)
        for z, bearing in zip(readings(scan, config), scan.angles, strict=True):
            for cell, kind in evidence_of_beam(grid, sensor_pose, bearing, z, scan.range_min, z_max, counting).items():
                if grid.geometry.contains(cell):
                    (hits if kind > 0 else misses)[cell] += 1
    visited = hits + misses > before
    grid.observed |= visited
    w = model.prior_weight
    p = (hits.astype(np.float64) + w * probability(grid.prior())) / (hits.astype(np.float64) + misses + w)
    grid.log_odds[visited] = np.clip(log_odds(p[visited]), *config.clamp_limits).astype(np.float32)
    return int((hits + misses - before).sum())


def update_moravec_elfes(grid: OccupancyGrid, scan: RangeScan, sensor_pose: ArrayLike, config: MappingConfig) -> int:
    """Combine a scan's readings with the certainties of each cell, as in 1985. Return the number of updates.

    First the empty certainties, for all readings: Emp ← Emp + E − Emp·E. Then the occupied ones, reading by reading: O
    is cancelled where the cell is known to be empty, O ← O·(1 − Emp); normalised, so that the whole arc holds one
    obstacle, O ← O / ΣO; and added, Occ ← Occ + O − Occ·O. Finally ``grid.log_odds`` shows the greater of the two,
    clamped, in each cell in which one of them has changed.

    Source: Moravec & Elfes 1985.
    """
    model = cast("MoravecElfes", config.beam_model())
    occupied, empty = certainties = statistics_of(grid, config)
    known = certainties.copy()
    z_max = min(scan.range_max, config.range_max)
    cones = [
        (z, *cells_in_cone(grid, sensor_pose, bearing, config.opening))
        for z, bearing in zip(readings(scan, config), scan.angles, strict=True)
    ]
    no_arc = MoravecElfes(0.0, config.opening)
    updates = 0
    for z, cells, r, theta in cones:
        if scan.range_min <= z <= z_max:
            before, certainty = r < z - model.half_window(z), model.empty(r, z, within(theta, config.opening))
        elif z > z_max and config.no_return == "free":
            before, certainty = r < z_max, no_arc.empty(r, z_max, within(theta, config.opening))
        else:
            continue
        rows, cols = cells[before].T
        empty[rows, cols] += certainty[before] * (1 - empty[rows, cols].astype(np.float64))
        grid.observed[rows, cols] = True
        updates += len(rows)
    for z, cells, r, theta in cones:
        if not scan.range_min <= z <= z_max:
            continue
        arc = (r >= z - model.half_window(z)) & (r <= min(z + model.half_window(z), z_max))
        rows, cols = cells[arc].T
        certainty = model.occupied(r[arc], z, within(theta[arc], config.opening))
        certainty *= 1 - empty[rows, cols].astype(np.float64)
        if certainty.sum() <= 0.0:
            continue
        occupied[rows, cols] += certainty / certainty.sum() * (1 - occupied[rows, cols].astype(np.float64))
        grid.observed[rows, cols] = True
        updates += len(rows)
    with np.errstate(divide="ignore"):
        shown = np.clip(model.log_odds(empty, occupied), *config.clamp_limits).astype(np.float32)
    changed = (certainties != known).any(axis=0)
    grid.log_odds[changed] = shown[changed]
    return updates


def statistics_of(grid: OccupancyGrid, config: MappingConfig) -> NDArray[np.float32]:
    """Return the grid's two statistics (2, rows, cols): evidence for occupied and evidence for empty.

    Certainties start at v = 2p − 1 of the prior; counts start at 0.
    """
    if grid.cell_statistics is None:
        grid.cell_statistics = np.zeros((2, *grid.geometry.shape), dtype=np.float32)
        if config.model == "moravec_elfes":
            value = 2 * probability(grid.prior()) - 1
            grid.cell_statistics[0], grid.cell_statistics[1] = np.maximum(value, 0), np.maximum(-value, 0)
    return grid.cell_statistics


# --- Provenance of a cell ---------------------------------------------------------------------------------------------


def provenance(
    grid: OccupancyGrid, scans: Sequence[RangeScan], sensor_poses: ArrayLike, cell: Cell, config: MappingConfig
) -> list[tuple[int, int, float, np.float32]]:
    """Return scan, beam, evidence and resulting log-odds of every update of ``cell`` in a per-beam map."""
    return provenance_of_views(
        grid, [[view] for view in zip(scans, np.asarray(sensor_poses), strict=True)], cell, config
    )


def provenance_of_views(
    grid: OccupancyGrid, scans: Sequence[Sequence[View]], cell: Cell, config: MappingConfig
) -> list[tuple[int, int, float, np.float32]]:
    """Return :func:`provenance` of scans whose beams may have individual poses."""
    contributions = []
    value = grid.prior()[cell]
    for t, views in enumerate(scans):
        beams = evidence_of_beams(grid, views, config)
        for k, evidence in hits_before_misses(beams, config) if config.only_hits else beams:
            if cell in evidence:
                value = bayes_filter(value, np.float32(evidence[cell]), config)
                contributions.append((t, k, evidence[cell], value))
    return contributions


# --- Where things are ------------------------------------------------------------------------------------------------


def cell_at(grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float) -> Cell:
    """Return the cell that contains the point at distance ``z`` along a bearing of the sensor."""
    in_laser = z * np.array([np.cos(bearing), np.sin(bearing)])
    row, col = grid.geometry.world_to_cell(transform_points(sensor_pose, in_laser))
    return int(row), int(col)


def point_at(grid: OccupancyGrid, sensor_pose: ArrayLike, bearing: float, z: float) -> Point:
    """Return the lattice coordinates (column, row), in cells, of the point at distance ``z`` along a bearing."""
    in_laser = z * np.array([np.cos(bearing), np.sin(bearing)])
    column, row = grid.geometry.to_lattice(transform_points(sensor_pose, in_laser))
    return float(column), float(row)


def distance(grid: OccupancyGrid, sensor_pose: ArrayLike, cell: Cell) -> float:
    """Return the distance r in metres from the sensor to a cell's centre."""
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


def within(theta: NDArray[np.float64], opening: float) -> NDArray[np.float64]:
    """Clip angles of cells in a cone to ± half its opening, which rounding may exceed."""
    return np.clip(theta, -opening / 2.0, opening / 2.0)


def turned(angle: float, direction: NDArray[np.float64]) -> tuple[float, float]:
    """Rotate a direction (2,) by an angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * direction[0] - sin * direction[1], sin * direction[0] + cos * direction[1]
