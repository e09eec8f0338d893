"""Limits of kernels on this machine: the same cells read, changed and written from a list, which was made before.

What is left of a kernel's time is what it takes to find the cells, and the first touches of memory that is new.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mapper.core.array_types import UInt8Array
from mapper.core.parallel import bands, cores, in_parallel
from mapper.costmap.kernels.inflation import TILE_COLS, TILE_ROWS, mark_blocks, near_blocks
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_scans
from mapper.mapping.kernels.bresenham import AT, COL, END_COL, END_ROW, FAR, HIT_COL, HIT_ROW, NEAR, ROW
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import scan_batches_of_log
from mapper.mapping.update import plan_beams
from mapper.mapping.update_plan import UpdatePlan, plan_update
from mapper.sensors.scan import ScanLog

PART = 50  #: scans whose cells are in memory at once: those of the hall take 40 MB
HIT = np.uint32(1 << 31)  #: of an entry of a list: the cell is hit, not passed
ROUNDS = 20
Entries = NDArray[np.uint32]


@njit(nogil=True, cache=True)
def update_listed(log_odds, entries, miss, hit, low, high):
    """Add to the cells that ``entries`` (n,) uint32 name, and clamp, in this order."""
    for k in range(len(entries)):
        entry = entries[k]
        cell = np.uint64(entry & np.uint32(0x7FFFFFFF))
        increment = hit if entry >> np.uint32(31) else miss
        log_odds[cell] = min(max(log_odds[cell] + increment, low), high)


@njit(nogil=True, cache=True)
def _list_lines(lines, rows, cols, out):
    """Write the cells of planned lines (9, n) that are in the grid, in the order of the beams; return how many.

    With an empty ``out`` they are only counted. Bresenham's cell after i steps: see
    :mod:`mapper.mapping.kernels.bresenham`.
    """
    count = 0
    for j in range(lines.shape[1]):
        row, col = int(lines[ROW, j]), int(lines[COL, j])
        d_row, d_col = int(lines[END_ROW, j]) - row, int(lines[END_COL, j]) - col
        major, minor = max(abs(d_row), abs(d_col)), min(abs(d_row), abs(d_col))
        steep = abs(d_row) > abs(d_col)
        s_row, s_col = (1 if d_row >= 0 else -1), (1 if d_col >= 0 else -1)
        for i in range(min(lines[FAR, j], major + 1) + 1):
            is_last = i == min(lines[FAR, j], major + 1)
            if is_last:
                r, c = int(lines[HIT_ROW, j]), int(lines[HIT_COL, j])
            else:
                n = (2 * i * minor + major) // max(2 * major, 1)
                r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
            if 0 <= r < rows and 0 <= c < cols and (is_last or i != lines[AT, j]):
                if len(out):
                    out[count] = np.uint32(r * cols + c) | (HIT if is_last or i >= lines[NEAR, j] else np.uint32(0))
                count += 1
    return count


def _of_beams(log: ScanLog, plan: UpdatePlan, geometry: GridGeometry) -> Iterator[tuple[Entries, float]]:
    """Yield the entries of some scans at a time, and the milliseconds that it takes to plan their beams."""
    for first in range(0, log.n_scans, PART):
        for batch in scan_batches_of_log(log, plan, None, first, min(first + PART, log.n_scans)):
            scans = batch.scans_on(geometry)
            lines = plan_beams(scans, geometry, plan, cores()).planned
            entries = np.empty(_list_lines(lines, *geometry.shape, np.empty(0, dtype=np.uint32)), dtype=np.uint32)
            _list_lines(lines, *geometry.shape, entries)
            yield entries, _best_ms(partial(plan_beams, scans, geometry, plan, cores()))


def _of_scans(log: ScanLog, config: MappingConfig, geometry: GridGeometry) -> Iterator[tuple[Entries, float]]:
    """As :func:`_of_beams`, of the update per scan, each cell of a scan once; how long planning takes is not known."""
    grid = OccupancyGrid(geometry, config.log_odds_prior)
    found: list[Entries] = []
    for scan in range(log.n_scans):
        box = integrate_scans(grid, log, config, None, scan, scan + 1).box
        if box is not None:
            part = np.s_[box.row0 : box.row1, box.col0 : box.col1]
            rows, cols = np.nonzero(grid.observed[part])
            cells = ((rows + box.row0) * geometry.cols + cols + box.col0).astype(np.uint32)
            is_hit = grid.log_odds[part][rows, cols] > config.log_odds_prior
            found.append(cells | (is_hit * HIT).astype(np.uint32))
            grid.log_odds[part], grid.observed[part] = config.log_odds_prior, False
        if len(found) == PART or (found and scan == log.n_scans - 1):
            yield np.concatenate(found), np.nan
            found = []


def _best_ms(work: Callable[[], Any]) -> float:
    best = np.inf
    for _ in range(ROUNDS):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return float(1e3 * best)


def _in_bands(entries: Entries, geometry: GridGeometry) -> list[Entries]:
    """Return the entries of each band of rows, one for each core, in their order, as the kernels share the work."""
    rows = (entries & ~HIT) // np.uint32(geometry.cols)
    work = np.bincount(rows, minlength=geometry.rows).astype(np.float64)
    return [entries[(rows >= low) & (rows < high)] for low, high in bands(work, cores())]


def mapping_limit(log: ScanLog, config: MappingConfig) -> tuple[float, float, int]:
    """Return the limit of mapping a log, ms: the same additions and clamps in the order of the beams, from a list.

    After it: the milliseconds in which the beams are planned, NaN for the update per scan; and the number of entries.
    """
    plan = plan_update(config, log.range_min, log.range_max)
    geometry = geometry_for(log, config)
    log_odds = OccupancyGrid(geometry, config.log_odds_prior).log_odds.reshape(-1)
    parts = _of_scans(log, config, geometry) if plan.per_scan else _of_beams(log, plan, geometry)
    limit, planning, count = 0.0, 0.0, 0
    for entries, planned in parts:
        work = [partial(update_listed, log_odds, own, *plan.log_odds_update) for own in _in_bands(entries, geometry)]
        in_parallel(work)  # the kernel is compiled, and the cells have been touched
        limit += _best_ms(partial(in_parallel, work))
        planning, count = planning + planned, count + len(entries)
    return limit, planning, count


@njit(nogil=True, cache=True)
def _inflation_passes(costs, blocks, table, radius, columns, distances, out):
    """Read and write each cell of inflation's passes once: down the columns, up again, along the rows, and to costs."""
    rows, cols = costs.shape
    out[:] = costs
    for row in range(0, rows, TILE_ROWS):
        for col in range(0, cols, TILE_COLS):
            top, left = max(row - radius, 0), max(col - radius, 0)
            bottom, right = min(row + TILE_ROWS + radius, rows), min(col + TILE_COLS + radius, cols)
            if not near_blocks(blocks, top, bottom, left, right):
                continue
            for r in range(top, bottom):
                source, line = costs[r, left:right], columns[r - top, : right - left]
                for k in range(line.shape[0]):
                    line[k] = source[k]
            for r in range(bottom - 2, top - 1, -1):
                line, below = columns[r - top, : right - left], columns[r - top + 1, : right - left]
                for k in range(line.shape[0]):
                    line[k] = min(line[k], below[k])
            last = min(col + TILE_COLS, cols)
            for r in range(row, min(row + TILE_ROWS, rows)):
                line, far = columns[r - top, col - left : last - left], distances[: last - col]
                for k in range(far.shape[0]):
                    far[k] = line[k]
                old, new = costs[r, col:last], out[r, col:last]
                for k in range(far.shape[0]):
                    new[k] = max(old[k], table[far[k]])


def inflation_limit(costs: UInt8Array, radius: int) -> Callable[[], None]:
    """Return a function that takes the limit of inflation by ``radius`` cells: its passes without what they compute."""
    blocks = np.empty((-(-costs.shape[0] // 64), -(-costs.shape[1] // 64)), dtype=np.bool_)
    mark_blocks(costs, False, blocks)
    columns = np.empty((TILE_ROWS + 2 * radius, TILE_COLS + 2 * radius), dtype=np.uint8)
    table, distances = np.zeros(radius * radius + 256, dtype=np.uint8), np.empty(TILE_COLS, dtype=np.uint16)
    return partial(_inflation_passes, costs, blocks, table, radius, columns, distances, np.empty_like(costs))


def page_faults(work: Callable[[], Any]) -> tuple[int, float]:
    """Return how many pages ``work`` touches for the first time, and the milliseconds that so many take here."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    work()
    faults = resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
    pages = 1 << 14
    each = min(_first_touches_ms(pages) for _ in range(ROUNDS)) / pages
    return faults, faults * each


def _first_touches_ms(pages: int) -> float:
    fresh = np.empty(pages * resource.getpagesize(), dtype=np.uint8)  # so much is new memory of the system
    began = time.perf_counter()
    fresh[:: resource.getpagesize()] = 1
    return 1e3 * (time.perf_counter() - began)
