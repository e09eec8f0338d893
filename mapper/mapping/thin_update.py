"""The per-beam update on all cores, in two passes: beams are planned by scans, then drawn by bands of rows.

Each cell gets its additions from one thread, in the order of the log, so the result does not depend on the number of
threads, not even in its last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.parallel import bands, in_parallel, shares
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.kernels.amanatides_woo import RAY_FIELDS, draw_rays, plan_rays
from mapper.mapping.kernels.bresenham import LINE_FIELDS, draw_lines, plan_lines
from mapper.mapping.kernels.negative_zero import decode_observed, encode_unobserved
from mapper.mapping.kernels.smooth_ramp import draw_ramps
from mapper.mapping.kernels.types import Cells, LogOddsUpdate, Scans
from mapper.mapping.scan_batch import scan_ends
from mapper.mapping.update_plan import Turns, UpdatePlan, part_of

_ENCODE_ABOVE_UPDATES_PER_CELL = 2.0  # updates for each cell of the box: below this it is cheaper to note each one
#: One map counts the hits and one the misses: in each of them one of the two adds 1 and the other 0.
ONE_MISS, ONE_HIT = (
    LogOddsUpdate(np.float32(miss), np.float32(1.0 - miss), np.float32(-np.inf), np.float32(np.inf))
    for miss in (1.0, 0.0)
)
#: Draws the rows [row_low, row_high), widens a box (row0, row1, col0, col1); returns the number of cell updates.
Draw = Callable[[int, int, NDArray[np.int64]], int]
NO_ENDS = np.empty(0, dtype=np.int64)  #: of scans, where hits and misses count alike


@dataclass(frozen=True, slots=True)
class PlannedBeams:
    """Planned updates of beams.

    ``planned`` holds the lines (9, n) int32 or the rays (n, 8) float64, ``work`` (rows,) the number of cells in each
    row of the grid, ``box`` (4,) int64 (row0, row1, col0, col1), half-open, the cells of the grid that are reached.
    """

    planned: NDArray[Any]
    work: NDArray[np.float64]
    box: NDArray[np.int64]


def plan_beams(scans: Scans, geometry: GridGeometry, plan: UpdatePlan, threads: int) -> PlannedBeams:
    """Plan the beams of some scans, in the order of the log."""
    readings, n_beams = scans.ranges.size, scans.ranges.shape[1]
    work = np.zeros((threads, geometry.rows + 1))
    boxes = np.tile(np.array([geometry.rows, 0, geometry.cols, 0]), (threads, 1))
    kernel: Callable[..., None] = plan_rays if plan.exact_rays else plan_lines
    planned: NDArray[Any] = (
        np.empty((readings, RAY_FIELDS)) if plan.exact_rays else np.empty((LINE_FIELDS, readings), dtype=np.int32)
    )
    view = (geometry.frame, plan.reading_filter)
    parts = zip(shares(len(scans.ranges), threads), work, boxes, strict=True)
    in_parallel(
        [
            partial(kernel, part_of(scans, a, b), *view, a * n_beams, planned, own, own_box)
            for (a, b), own, own_box in parts
        ]
    )
    boxes += [-1, 1, -1, 1]  # an endpoint may be rounded out of the line through it
    return PlannedBeams(planned, np.cumsum(work.sum(axis=0))[:-1], _joined(boxes, geometry))


def draw_beam_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``; return the number of cell updates and widen ``box`` (4,) to hold what was touched."""
    count = 0
    for scans, plan in turns.pieces:
        beams = plan_beams(scans, grid.geometry, plan, threads)
        count += _draw_in_bands(grid, beams, _drawer(grid, beams, scans, plan, log_odds_update), threads, box)
    return count


def count_beams(grid: OccupancyGrid, turns: Turns, threads: int, box: NDArray[np.int64]) -> int:
    """Count the hits and the misses of each cell, as :func:`draw_beam_evidence` with :data:`ONE_HIT` and
    :data:`ONE_MISS`. The beams are planned once, and hits are counted without walking along the beams.
    """
    hits, misses = grid.with_statistic(0), grid.with_statistic(1)
    count = 0
    for scans, plan in turns.pieces:
        beams = plan_beams(scans, grid.geometry, plan, threads)
        if plan.exact_rays or plan.strategy.smooth:
            _draw_in_bands(hits, beams, _drawer(hits, beams, scans, plan, ONE_HIT), threads, box)
        else:
            draw_in_bands(_hit_drawer(hits, beams), beams.work, (0, len(beams.work)), threads, box)
        count += _draw_in_bands(misses, beams, _drawer(misses, beams, scans, plan, ONE_MISS), threads, box)
    return count


def _drawer(
    grid: OccupancyGrid, beams: PlannedBeams, scans: Scans, plan: UpdatePlan, log_odds_update: LogOddsUpdate
) -> Callable[..., int]:
    """Return the function of (row_low, row_high, box, mark) that adds planned beams to rows of ``grid``."""
    cells, frame = _cells(grid), grid.geometry.frame
    smooth, evidence = plan.strategy.smooth, plan.evidence
    ends = scan_ends(scans.numbers) * scans.ranges.shape[1] if plan.only_hits else NO_ENDS
    if plan.exact_rays:
        return partial(draw_rays, cells, beams.planned, frame.resolution, smooth, evidence, log_odds_update, ends)
    if smooth:
        return partial(draw_ramps, cells, beams.planned, scans, frame, plan.reading_filter, evidence, log_odds_update)
    return partial(draw_lines, cells, beams.planned, log_odds_update, False, ends)


def _hit_drawer(grid: OccupancyGrid, beams: PlannedBeams) -> Draw:
    """Return the function that counts the hits of planned lines. They are few: each cell is marked as it is hit."""
    cells = _cells(grid)

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        return int(draw_lines(cells, beams.planned, ONE_HIT, True, NO_ENDS, row_low, row_high, box, True))

    return draw


def _cells(grid: OccupancyGrid) -> Cells:
    return Cells(grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols)


def _draw_in_bands(
    grid: OccupancyGrid, beams: PlannedBeams, draw: Callable[..., int], threads: int, box: NDArray[np.int64]
) -> int:
    band = partial(_draw_with_observed, grid, beams, draw)
    return draw_in_bands(band, beams.work, (0, len(beams.work)), threads, box)


def _joined(boxes: NDArray[np.int64], geometry: GridGeometry) -> NDArray[np.int64]:
    """Return the box (4,) that holds all boxes (n, 4), clipped to the grid."""
    (row, col), (row_stop, col_stop) = boxes[:, ::2].min(axis=0), boxes[:, 1::2].max(axis=0)
    return np.array([max(row, 0), min(row_stop, geometry.rows), max(col, 0), min(col_stop, geometry.cols)])


def _draw_with_observed(
    grid: OccupancyGrid,
    beams: PlannedBeams,
    draw: Callable[..., int],
    row_low: int,
    row_high: int,
    box: NDArray[np.int64],
) -> int:
    """Draw a band; mark the observed cells by the method that costs less for this number of updates."""
    touched = beams.box.copy()
    touched[:2] = touched[:2].clip(row_low, row_high)
    cells = int((touched[1] - touched[0]) * (touched[3] - touched[2]))
    if beams.work[row_low:row_high].sum() < _ENCODE_ABOVE_UPDATES_PER_CELL * cells or not encode_unobserved(
        grid.log_odds, grid.observed, touched
    ):
        return draw(row_low, row_high, box, True)
    count = draw(row_low, row_high, box, False)
    decode_observed(grid.log_odds, grid.observed, touched)
    return count


def draw_in_bands(
    draw: Draw, work: NDArray[np.float64], rows: tuple[int, int], threads: int, box: NDArray[np.int64]
) -> int:
    """Draw the rows [first, stop) of ``rows``, one band for each thread; return the number of cell updates.

    ``work`` (rows of the grid,) is the cost of each row, in any unit; ``box`` (4,) int64 (row0, row1, col0, col1),
    half-open, is widened to hold the cells that were touched.
    """
    first, stop = rows
    parts = [(first + low, first + high, box.copy()) for low, high in bands(work[first:stop], threads)]
    counts = in_parallel([partial(draw, *part) for part in parts])
    for _, _, own in parts:
        box[::2] = np.minimum(box[::2], own[::2])
        box[1::2] = np.maximum(box[1::2], own[1::2])
    return sum(int(count) for count in counts)
