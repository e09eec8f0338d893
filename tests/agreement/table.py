"""The one table of kernels: each with its textbook twin and a generator of inputs for both.

A row's ``kernel`` and ``twin`` take one case and return the arrays and numbers that must be equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.core.se2 import transform_points
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, log_odds
from mapper.grid.kernels.quantise import quantise
from mapper.grid.merge import merged
from mapper.grid.metrics import entropy, information_gain
from mapper.mapping import textbook, traversal
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.kernels.amanatides_woo import draw_rays
from mapper.mapping.kernels.bresenham import draw_lines
from mapper.mapping.kernels.contributions import contributions_of_rays
from mapper.mapping.kernels.types import Cells, Evidence, LogOddsUpdate
from mapper.sensors.planar import textbook as planar_textbook
from mapper.sensors.planar.cloud import add_points, empty_scan
from mapper.sensors.planar.depth import cut_depth
from mapper.sensors.scan import RangeScan
from tests.agreement.asking import (
    beams_and_poses,
    provenance_by_kernel,
    provenance_by_textbook,
    provenance_of_counts_by_textbook,
    provenance_of_scans_by_textbook,
    provenance_of_sweeps_by_kernel,
    provenance_of_sweeps_by_textbook,
)
from tests.agreement.costmap import (
    costmap_cases,
    inflated_by_kernel,
    inflated_by_textbook,
    interpreted_by_table,
    interpreted_by_textbook,
    laid_by_kernel,
    laid_by_textbook,
    observed_by_kernel,
    observed_by_textbook,
)
from tests.agreement.inputs import (
    STEPS,
    CloudCase,
    DepthCase,
    LineCase,
    MappingCase,
    PictureCase,
    RayCase,
    StatesCase,
    TwoMaps,
    clouds,
    depths,
    lines,
    mapping_cases,
    pictures,
    rays,
    states,
    sweeping_cases,
    two_maps,
)
from tests.agreement.localization import (
    beams_by_kernel,
    beams_by_textbook,
    clusters_by_kernel,
    clusters_by_textbook,
    drawn_by_kernel,
    drawn_by_textbook,
    localization_cases,
    moved_by_kernel,
    moved_by_textbook,
    resampled_by_kernel,
    resampled_by_textbook,
    scored_by_kernel,
    scored_by_textbook,
)
from tests.agreement.matching import (
    equations_of_pairs_by_kernel,
    equations_of_pairs_by_textbook,
    field_equations_by_kernel,
    field_equations_by_textbook,
    fields_by_kernel,
    fields_by_textbook,
    match_cases,
    prepared_by_kernel,
    prepared_by_textbook,
    refined_both_ways_by_kernel,
    refined_both_ways_by_textbook,
    refined_by_kernel,
    refined_by_textbook,
    searched_by_kernel,
    searched_by_textbook,
    split_by_kernel,
    split_by_textbook,
    step_by_kernel,
    step_by_textbook,
    views_by_kernel,
    views_by_textbook,
)
from tests.agreement.planning import (
    path_by_kernel,
    path_by_textbook,
    planning_cases,
    searched_cells_by_kernel,
    searched_cells_by_textbook,
    spread_by_kernel,
    spread_by_textbook,
)
from tests.agreement.slam import (
    agreement_by_kernel,
    agreement_by_textbook,
    edges_by_kernel,
    edges_by_textbook,
    graph_cases,
    information_by_kernel,
    information_by_textbook,
    nearest_by_kernel,
    nearest_by_textbook,
    shrunk_by_kernel,
    shrunk_by_textbook,
    solved_by_kernel,
    solved_by_textbook,
    ways_by_kernel,
    ways_by_textbook,
)
from tests.agreement.volume import (
    asked_by_kernel,
    asked_by_textbook,
    cast_by_kernel,
    cast_by_textbook,
    inserted_by_kernel,
    inserted_by_textbook,
    tree_by_kernel,
    tree_by_textbook,
    volume_cases,
)


@dataclass(frozen=True)
class Row:
    name: str
    kernel: Callable[[Any], tuple[Any, ...]]
    twin: Callable[[Any], tuple[Any, ...]]
    inputs: st.SearchStrategy[Any]
    tolerance: float = 0.0  #: of floating-point numbers; cells and counts are always equal


def map_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = integrate_log(grid, case.log, case.config)
    return grid.log_odds, grid.observed, count


def map_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = 0
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        count += textbook.occupancy_grid_mapping(grid, scan, pose, case.config)
    return grid.log_odds, grid.observed, count


def statistics_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = integrate_log(grid, case.log, case.config)
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def statistics_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = 0
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        count += textbook.occupancy_grid_mapping(grid, scan, pose, case.config)
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def sweeps_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = sum(textbook.occupancy_grid_mapping(grid, *one, case.config) for one in beams_and_poses(case))
    return grid.log_odds, grid.observed, count


def swept_statistics_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = sum(textbook.occupancy_grid_mapping(grid, *one, case.config) for one in beams_and_poses(case))
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def line_by_kernel(case: LineCase) -> tuple[Any, ...]:
    drawn, observed = np.zeros(case.shape, dtype=np.float32), np.zeros(case.shape, dtype=np.bool_)
    (rows, cols), steps = case.shape, max(abs(case.end[0] - case.start[0]), abs(case.end[1] - case.start[1]))
    box = np.array([rows, 0, cols, 0])
    line = np.array([[*case.start, *case.end, steps + 1, steps + 1, -1, -1, -1]], dtype=np.int32).T.copy()
    one, nothing, low, high = (np.float32(n) for n in (1, 0, -100, 100))
    cells = Cells(drawn.reshape(-1), observed.reshape(-1), cols)
    draw_lines(cells, line, LogOddsUpdate(one, nothing, low, high), 0, rows, box, True)
    return drawn, observed, box if drawn.any() else None


def line_by_textbook(case: LineCase) -> tuple[Any, ...]:
    drawn = np.zeros(case.shape, dtype=np.float32)
    for row, col in traversal.bresenham(case.start, case.end):
        if 0 <= row < case.shape[0] and 0 <= col < case.shape[1]:
            drawn[row, col] += 1
    rows, cols = np.nonzero(drawn)
    return drawn, drawn > 0, np.array([rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]) if len(rows) else None


def ray_by_kernel(case: RayCase) -> tuple[Any, ...]:
    drawn, observed = np.zeros(case.shape, dtype=np.float32), np.zeros(case.shape, dtype=np.bool_)
    touched = np.zeros(case.shape, dtype=np.int64)
    rows, cols = case.shape
    ray = np.array([[*case.start, *case.end, *case.end, np.inf, 0.0]])
    one, nothing, low, high = (np.float32(n) for n in (1, 0, -100, 100))
    cells, box = Cells(drawn.reshape(-1), observed.reshape(-1), cols), np.array([rows, 0, cols, 0])
    update = LogOddsUpdate(one, nothing, low, high)
    draw_rays(cells, ray, 1.0, False, Evidence(1.0, 0.0), update, 0, rows, box, True)
    for row, col in np.ndindex(case.shape):
        touched[row, col] = contributions_of_rays(ray, 1.0, row, col, np.empty((1, 2), dtype=np.int64))
    return drawn, observed, touched, box if drawn.any() else None


def ray_by_textbook(case: RayCase) -> tuple[Any, ...]:
    drawn = np.zeros(case.shape, dtype=np.float32)
    for row, col in traversal.amanatides_woo(case.start, case.end):
        if 0 <= row < case.shape[0] and 0 <= col < case.shape[1]:
            drawn[row, col] += 1
    rows, cols = np.nonzero(drawn)
    box = np.array([rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]) if len(rows) else None
    return drawn, drawn > 0, (drawn > 0).astype(np.int64), box


def bounds_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    return (geometry_for(case.log, case.config),)


def bounds_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return bounds_of_scans(case, zip(case.scans(), case.sensor_poses(), strict=True))


def bounds_of_sweeps_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return bounds_of_scans(case, beams_and_poses(case))


def bounds_of_scans(case: MappingCase, scans: Iterable[tuple[RangeScan, np.ndarray]]) -> tuple[Any, ...]:
    z_max = min(case.log.range_max, case.config.range_max)
    seen = []
    for scan, pose in scans:
        seen.append(pose[:2])
        for z, bearing in zip(textbook.readings(scan, case.config), scan.angles, strict=True):
            if z > z_max:
                reach = z_max if case.config.no_return == "free" else 0.0
            else:
                reach = z + case.config.window / 2 if z >= scan.range_min else 0.0
            in_laser = reach * np.array([np.cos(bearing), np.sin(bearing)])
            seen.append(transform_points(pose, in_laser))
    side = case.config.resolution
    low, high = np.min(seen, axis=0) - side, np.max(seen, axis=0) + side
    return (case.geometry.covering(low, high, side),)


def cloud_by_core(case: CloudCase) -> tuple[Any, ...]:
    ranges = empty_scan(case.cut)
    half = len(case.points) // 2
    for points in (case.points[:half], case.points[half:]):
        add_points(points, case.placement, case.cut, ranges)
    return (ranges,)


def cloud_by_textbook(case: CloudCase) -> tuple[Any, ...]:
    return (planar_textbook.cut_cloud(case.points, case.placement, case.cut),)


def depth_by_core(case: DepthCase) -> tuple[Any, ...]:
    return (cut_depth(case.depth, case.camera, case.cut),)


def depth_by_textbook(case: DepthCase) -> tuple[Any, ...]:
    return (planar_textbook.cut_depth(case.depth, case.camera, case.cut),)


TILE = 8
BOUNDS = (float(log_odds(FREE_THRESHOLD)), float(log_odds(OCCUPIED_THRESHOLD)))


def tiles_of(picture: np.ndarray) -> tuple[int, int]:
    rows, cols = picture.shape
    return -(-rows // TILE), -(-cols // TILE)


def picture_by_kernel(case: PictureCase) -> tuple[Any, ...]:
    picture = np.full(case.log_odds.shape, -128, dtype=np.int8)
    changed = np.zeros(tiles_of(picture), dtype=np.bool_)
    count = quantise(case.log_odds, case.observed, case.low, case.high, *BOUNDS, *case.box, TILE, picture, changed)
    return picture, changed, count


def picture_by_textbook(case: PictureCase) -> tuple[Any, ...]:
    def state(log_odds: np.ndarray) -> np.ndarray:
        return (log_odds > BOUNDS[1]).astype(int) - (log_odds < BOUNDS[0])

    # The nearest of the values that stand for the same state, where there is one.
    steps = np.arange(-127, 128)
    stands_for = case.low + (steps + 127) / 254.0 * (case.high - case.low)
    log_odds = case.log_odds.astype(float)[..., None]
    away = np.abs(np.clip(log_odds, case.low, case.high) - stands_for)
    away = away + 1e3 * (state(log_odds) != state(stands_for))
    quantised = np.where(case.observed, steps[np.argmin(away, axis=-1)], -128)
    row0, row1, col0, col1 = (max(n, 0) for n in case.box)
    picture = np.full(case.log_odds.shape, -128, dtype=np.int8)
    picture[row0:row1, col0:col1] = quantised[row0:row1, col0:col1]
    changed = np.zeros(tiles_of(picture), dtype=np.bool_)
    for row, col in np.argwhere(picture != -128):
        changed[row // TILE, col // TILE] = True
    return picture, changed, np.count_nonzero(picture != -128)


def merged_by_core(case: TwoMaps) -> tuple[Any, ...]:
    whole = merged(case.a, case.b)
    known = np.zeros(whole.geometry.shape, np.float32) if whole.prior_map is None else whole.prior_map
    return whole.log_odds, whole.observed, known, whole.geometry.shape


def merged_by_textbook(case: TwoMaps) -> tuple[Any, ...]:
    """Cell by cell: the odds of both, divided by those of the prior."""
    evidence: dict[tuple[int, int], float] = {}
    prior: dict[tuple[int, int], float] = {}
    observed = set()
    for grid, (row, col) in ((case.a, (0, 0)), (case.b, case.offset)):
        for r, c in np.ndindex(grid.geometry.shape):
            cell = (row + r, col + c)
            known = np.nan if grid.prior_map is None else float(grid.prior_map[r, c])
            prior[cell] = 0.0 if grid.prior_map is None else known
            started = grid.log_odds_prior if np.isnan(known) else known
            evidence[cell] = evidence.get(cell, started) + float(grid.log_odds[r, c]) - started
            if grid.observed[r, c]:
                observed.add(cell)
    rows, cols = zip(*evidence, strict=True)
    top, left = min(rows), min(cols)
    shape = (max(rows) - top + 1, max(cols) - left + 1)
    nowhere = 0.0 if case.a.prior_map is None else np.nan
    values, before = np.full(shape, case.a.log_odds_prior), np.full(shape, nowhere)
    seen = np.zeros(shape, dtype=np.bool_)
    for (r, c), value in evidence.items():
        at = (r - top, c - left)
        values[at], before[at], seen[at] = value, prior[r, c], (r, c) in observed
    return values.astype(np.float32), seen, before.astype(np.float32), shape


def states_by_core(case: StatesCase) -> tuple[Any, ...]:
    bits = (entropy(case.grid.log_odds), information_gain(case.grid))
    return (case.grid.classify(case.occupied, case.free), *(values.astype(np.float32) for values in bits))


def states_by_textbook(case: StatesCase) -> tuple[Any, ...]:
    """By probabilities, as the definitions have it."""

    def bits(log_odds: float) -> float:
        odds = math.exp(-abs(log_odds))
        p, q = 1 / (1 + odds), odds / (1 + odds)
        return -p * math.log2(p) - (q * math.log2(q) if q > 0 else 0)

    prior = case.grid.prior()
    state = np.full(prior.shape, -1, dtype=np.int8)
    left, gained = np.empty(prior.shape, dtype=np.float32), np.zeros(prior.shape, dtype=np.float32)
    for cell in np.ndindex(prior.shape):
        left[cell] = bits(float(case.grid.log_odds[cell]))
        if case.grid.observed[cell]:
            gained[cell] = bits(float(prior[cell])) - bits(float(case.grid.log_odds[cell]))
            p = 1 / (1 + math.exp(-float(case.grid.log_odds[cell])))
            p = min(p, math.nextafter(1.0, 0.0))  # it is below 1 also where it is rounded to 1
            state[cell] = 100 if p > case.occupied else 0 if p < case.free else -1
    return state, left, gained


RAMP, CONE, COUNTING, CERTAINTIES = (("smooth_ramp",), ("sonar_cone",), ("hit_counting",), ("moravec_elfes",))
ROUNDING = 1e-6  # exponentials, angles and powers differ in their last bit from library to library

TABLE = (
    Row("bresenham", line_by_kernel, line_by_textbook, lines()),
    Row("exact traversal", ray_by_kernel, ray_by_textbook, rays()),
    Row("per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam")),
    Row("per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan")),
    Row("smooth ramp per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("smooth ramp per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", RAMP), ROUNDING),
    Row("sonar cone per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row("sonar cone per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", CONE), ROUNDING),
    Row(
        "hit counting per beam",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_beam", COUNTING),
        ROUNDING,
    ),
    Row(
        "hit counting per scan",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_scan", COUNTING),
        ROUNDING,
    ),
    Row(
        "Moravec and Elfes",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_beam", CERTAINTIES),
        ROUNDING,
    ),
    Row("provenance", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam")),
    Row("provenance of ramps", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("provenance of cones", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row(
        "provenance per scan",
        provenance_by_kernel,
        provenance_of_scans_by_textbook,
        mapping_cases("per_scan", (*STEPS, *RAMP, *CONE)),
        ROUNDING,
    ),
    Row(
        "provenance of hits and misses",
        provenance_by_kernel,
        provenance_of_counts_by_textbook,
        mapping_cases("per_beam", COUNTING),
        ROUNDING,
    ),
    Row("deskewed", map_by_kernel, sweeps_by_textbook, sweeping_cases()),
    Row("deskewed ramps", map_by_kernel, sweeps_by_textbook, sweeping_cases(RAMP), ROUNDING),
    Row("deskewed cones", map_by_kernel, sweeps_by_textbook, sweeping_cases(CONE), ROUNDING),
    Row("deskewed counting", statistics_by_kernel, swept_statistics_by_textbook, sweeping_cases(COUNTING), ROUNDING),
    Row(
        "provenance of deskewed beams",
        provenance_of_sweeps_by_kernel,
        provenance_of_sweeps_by_textbook,
        sweeping_cases(),
    ),
    Row("merging", merged_by_core, merged_by_textbook, two_maps(), ROUNDING),
    Row("states and information", states_by_core, states_by_textbook, states(), ROUNDING),
    Row("geometry of a log", bounds_by_kernel, bounds_by_textbook, mapping_cases("per_beam")),
    Row("geometry of a deskewed log", bounds_by_kernel, bounds_of_sweeps_by_textbook, sweeping_cases()),
    Row("quantise", picture_by_kernel, picture_by_textbook, pictures()),
    Row("scan out of a cloud", cloud_by_core, cloud_by_textbook, clouds()),
    Row("scan out of a depth image", depth_by_core, depth_by_textbook, depths()),
    Row("points and normals of scans", prepared_by_kernel, prepared_by_textbook, match_cases(), 1e-5),
    Row(
        "point-to-line and point-to-point",
        equations_of_pairs_by_kernel,
        equations_of_pairs_by_textbook,
        match_cases(),
        1e-6,
    ),
    Row("Gauss-Newton step", step_by_kernel, step_by_textbook, match_cases(), 1e-9),
    Row("refined pose", refined_by_kernel, refined_by_textbook, match_cases(), 1e-6),
    Row("pairs both ways", refined_both_ways_by_kernel, refined_both_ways_by_textbook, match_cases(), 1e-6),
    Row("agreement of views", views_by_kernel, views_by_textbook, match_cases(), 1e-6),
    Row("score field", fields_by_kernel, fields_by_textbook, match_cases()),
    Row("likelihood field", field_equations_by_kernel, field_equations_by_textbook, match_cases(), 1e-6),
    Row("split and merge", split_by_kernel, split_by_textbook, match_cases()),
    Row("correlative search", searched_by_kernel, searched_by_textbook, match_cases()),
    Row("edges of a pose graph", edges_by_kernel, edges_by_textbook, graph_cases(), 1e-9),
    Row("block Cholesky", solved_by_kernel, solved_by_textbook, graph_cases(), 1e-6),
    Row("ways in a pose graph", ways_by_kernel, ways_by_textbook, graph_cases(), 1e-12),
    Row("nearest node of each submap", nearest_by_kernel, nearest_by_textbook, graph_cases()),
    Row("information of a pair of scans", shrunk_by_kernel, shrunk_by_textbook, graph_cases(), 1e-9),
    Row("points that agree and contradict", agreement_by_kernel, agreement_by_textbook, match_cases()),
    Row("information of an aligned pose", information_by_kernel, information_by_textbook, graph_cases(), 1e-6),
    Row("odometry motion model", moved_by_kernel, moved_by_textbook, localization_cases(), 1e-5),
    Row("particles anywhere and around a pose", drawn_by_kernel, drawn_by_textbook, localization_cases(), 1e-5),
    Row("likelihood field of a map", scored_by_kernel, scored_by_textbook, localization_cases(), 2e-3),
    Row("beam range finder model", beams_by_kernel, beams_by_textbook, localization_cases(), 1e-6),
    Row("low-variance resampling", resampled_by_kernel, resampled_by_textbook, localization_cases()),
    Row("clusters of particles", clusters_by_kernel, clusters_by_textbook, localization_cases(), 1e-6),
    Row("costs of map values", interpreted_by_table, interpreted_by_textbook, costmap_cases()),
    Row("inflation", inflated_by_kernel, inflated_by_textbook, costmap_cases()),
    Row("marking and clearing", observed_by_kernel, observed_by_textbook, costmap_cases()),
    Row("layers laid over each other", laid_by_kernel, laid_by_textbook, costmap_cases()),
    Row("cost to come by Dijkstra", spread_by_kernel, spread_by_textbook, planning_cases()),
    Row("cost to come by A*", searched_cells_by_kernel, searched_cells_by_textbook, planning_cases()),
    Row("path back", path_by_kernel, path_by_textbook, planning_cases()),
    Row("volume", inserted_by_kernel, inserted_by_textbook, volume_cases()),
    Row("casts in a volume", cast_by_kernel, cast_by_textbook, volume_cases()),
    Row("octree", tree_by_kernel, tree_by_textbook, volume_cases()),
    Row("obstacles and columns of a volume", asked_by_kernel, asked_by_textbook, volume_cases(), tolerance=1e-9),
)
