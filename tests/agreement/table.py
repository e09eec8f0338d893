"""The one table of kernels: each with its textbook twin and a generator of inputs for both.

A row's ``kernel`` and ``twin`` take one case and return the arrays and numbers that must be equal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper import textbook, traversal
from mapper.geometry import transform_points
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, log_odds
from mapper.integrate import geometry_for, integrate_log
from mapper.kernels.lines import draw_lines
from mapper.kernels.quantise import quantise
from mapper.provenance import provenance
from tests.agreement.inputs import LineCase, MappingCase, PictureCase, lines, mapping_cases, pictures


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


def tallies_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = integrate_log(grid, case.log, case.config)
    return grid.tallies, grid.observed, count


def tallies_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = 0
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        count += textbook.occupancy_grid_mapping(grid, scan, pose, case.config)
    return grid.tallies, grid.observed, count


def line_by_kernel(case: LineCase) -> tuple[Any, ...]:
    drawn, observed = np.zeros(case.shape, dtype=np.float32), np.zeros(case.shape, dtype=np.bool_)
    (rows, cols), steps = case.shape, max(abs(case.end[0] - case.start[0]), abs(case.end[1] - case.start[1]))
    box = np.array([rows, 0, cols, 0])
    line = np.array([[*case.start, *case.end, steps + 1, steps + 1, -1, -1, -1]], dtype=np.int32).T.copy()
    one, nothing, low, high = (np.float32(n) for n in (1, 0, -100, 100))
    flat = drawn.reshape(-1), observed.reshape(-1)
    draw_lines(*flat, cols, line, (one, nothing, low, high), 0, rows, box, True)
    return drawn, observed, box if drawn.any() else None


def line_by_textbook(case: LineCase) -> tuple[Any, ...]:
    drawn = np.zeros(case.shape, dtype=np.float32)
    for row, col in traversal.bresenham(case.start, case.end):
        if 0 <= row < case.shape[0] and 0 <= col < case.shape[1]:
            drawn[row, col] += 1
    rows, cols = np.nonzero(drawn)
    return drawn, drawn > 0, np.array([rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]) if len(rows) else None


def bounds_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    return (geometry_for(case.log, case.config),)


def bounds_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    z_max = min(case.log.range_max, case.config.range_max)
    seen = []
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
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


def cells_to_ask(case: MappingCase) -> list[tuple[int, int]]:
    """The sensor's cells, the endpoints' and some between, as far as they lie in the grid."""
    asked = set()
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        for z, bearing in zip(scan.ranges.astype(float), scan.angles, strict=True):
            for part in (0.0, 0.5, 1.0):
                if np.isfinite(z):
                    asked.add(textbook.cell_at(case.grid(), pose, bearing, part * z))
    return [cell for cell in sorted(asked) if case.geometry.contains(cell)][:8]


def provenance_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    found = [provenance(case.geometry, case.log, case.config, cell) for cell in cells_to_ask(case)]
    names = [list(zip(p.scans.tolist(), p.beams.tolist(), strict=True)) for p in found]
    values = [np.stack([p.increments, p.log_odds]) for p in found]
    return (names, *values)


def provenance_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    scans, poses = case.scans(), case.sensor_poses()
    found = [textbook.provenance(case.grid(), scans, poses, cell, case.config) for cell in cells_to_ask(case)]
    names = [[(t, k) for t, k, _, _ in touches] for touches in found]
    values = [np.array([[e for *_, e, _ in touches], [v for *_, v in touches]], np.float32) for touches in found]
    return (names, *values)


RAMP, CONE, COUNTING, CERTAINTIES = (("smooth_ramp",), ("sonar_cone",), ("hit_counting",), ("moravec_elfes",))
ROUNDING = 1e-6  # exponentials, angles and powers differ in their last bit from library to library

TABLE = (
    Row("bresenham", line_by_kernel, line_by_textbook, lines()),
    Row("per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam")),
    Row("per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan")),
    Row("smooth ramp per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("smooth ramp per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", RAMP), ROUNDING),
    Row("sonar cone per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row("sonar cone per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", CONE), ROUNDING),
    Row("hits and misses per beam", tallies_by_kernel, tallies_by_textbook, mapping_cases("per_beam", COUNTING)),
    Row("hits and misses per scan", tallies_by_kernel, tallies_by_textbook, mapping_cases("per_scan", COUNTING)),
    Row("hit counting", map_by_kernel, map_by_textbook, mapping_cases("per_beam", COUNTING), ROUNDING),
    Row("Moravec and Elfes", tallies_by_kernel, tallies_by_textbook, mapping_cases("per_beam", CERTAINTIES), ROUNDING),
    Row("provenance", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam")),
    Row("provenance of ramps", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("provenance of cones", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row("geometry of a log", bounds_by_kernel, bounds_by_textbook, mapping_cases("per_beam")),
    Row("quantise", picture_by_kernel, picture_by_textbook, pictures()),
)
