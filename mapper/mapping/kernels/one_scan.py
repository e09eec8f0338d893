"""Per-beam update with Bresenham's lines for one scan of a live robot, in one call."""

from __future__ import annotations

from math import floor

import numpy as np
from numpy import uint32, uint64

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array, UInt32Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels.bresenham import (
    _BITS,
    _HALF,
    LINE_FIELDS,
    _clip,
    _crossing,
    _hits_of,
    _line_of,
    _reading,
    _slope,
    plan_lines,
    reach,
)
from mapper.mapping.kernels.hits_first import _add_hits, _put_back
from mapper.mapping.kernels.negative_zero import _without_minus_zero
from mapper.mapping.kernels.types import LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

BEYOND = -1  #: the scan reaches beyond the grid, which must grow first


@jit
def _add_steps(
    log_odds: Float32Array, observed: BoolArray, start: int, along: int, across: int, slope: int, begin: int, end: int,
    left_out: int, increment: np.float32, low: np.float32, high: np.float32, clamped: np.float32,
    written: UInt32Array, n: int,
) -> int:  # fmt: skip
    """Add ``increment`` to the steps [begin, end) of a line except ``left_out``, in cells that are not ``clamped``.

    The cells are appended to ``written``, which has ``n`` entries; return the new number. If there is no more room, the
    last entry is overwritten.
    """
    last = len(written) - 1
    position = _HALF + begin * slope
    for i in range(begin, end):
        cell = uint64(start + i * along + (position >> _BITS) * across)
        position += slope
        value = log_odds[cell]
        if value != clamped and i != left_out:
            log_odds[cell] = min(max(value + increment, low), high)
            observed[cell] = True
            written[min(n, last)] = uint32(cell)
            n += 1
    return n


@jit
def _clamped(increment: np.float32, low: np.float32, high: np.float32, log_odds_prior: float) -> np.float32:
    """Return the log-odds at which ``increment`` changes nothing in observed cells; NaN if there are none.

    A cell that was never observed holds the prior.
    """
    limit = low if increment <= np.float32(0.0) else high
    return limit if limit != np.float32(log_odds_prior) else np.float32(np.nan)


@jit
def add_scan(
    log_odds: Float32Array,
    observed: BoolArray,
    ranges: Float32Array,
    sensor: tuple[float, float, float, float],
    beams: Float64Array,
    frame: Frame,
    reading_filter: ReadingFilter,
    log_odds_update: LogOddsUpdate,
    only_hits: bool,
    log_odds_prior: float,
    box: Int64Array,
    written: UInt32Array,
) -> tuple[int, int]:
    """Add one scan to ``log_odds`` and ``observed`` (rows, cols); return the number of cell updates.

    Also returned is the number of entries of ``written`` (n,) uint32, n > 0: the cells whose log-odds were written,
    ``row · cols + col``, possibly repeated; if it is greater than n, not all are listed. If the scan reaches beyond the
    grid, :data:`BEYOND` is returned and nothing is written.

    ``ranges`` (n_beams,) metres, ``sensor`` (x, y, cos θ, sin θ) of ``T_map_laser``, ``beams`` (n_beams, 2) cosine and
    sine of the bearings. With ``only_hits``, misses are ignored in the cells that the scan hits. Cells that are not
    ``observed`` hold ``log_odds_prior``; a cell at the clamp is only read. ``box`` (4,) int64 (row0, row1, col0, col1),
    half-open, is extended to the touched cells. The result has the same bits as :func:`plan_lines` and
    :func:`draw_lines` of :mod:`mapper.mapping.kernels.bresenham`; the textbook version is the same.
    """
    rows, cols = log_odds.shape
    n_beams = ranges.shape[0]
    sensors = np.empty((1, 4))
    sensors[0, 0], sensors[0, 1], sensors[0, 2], sensors[0, 3] = sensor
    bounds = np.array([np.inf, np.inf, -np.inf, -np.inf])
    reach(ranges.reshape(1, n_beams), sensors, beams, reading_filter, bounds)
    for corner in range(4):
        u, v = _to_lattice(bounds[2 * (corner % 2)], bounds[1 + 2 * (corner // 2)], frame)
        if not (0 <= floor(v) < rows and 0 <= floor(u) < cols):
            return BEYOND, 0
    range_min, range_max, window, growth, no_return_free = reading_filter
    miss, hit, low, high = _without_minus_zero(log_odds_update)
    miss_clamped, hit_clamped = _clamped(miss, low, high, log_odds_prior), _clamped(hit, low, high, log_odds_prior)
    flat, flat_observed = log_odds.reshape(-1), observed.reshape(-1)
    u, v = _to_lattice(sensor[0], sensor[1], frame)
    row, col = int(_cell_of(v)), int(_cell_of(u))
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count, n = 0, 0
    hits = np.empty(0, dtype=np.int64)
    if only_hits:
        lines, rest = np.empty((LINE_FIELDS, n_beams), dtype=np.int32), np.empty((0, 4))
        scan = Scans(ranges.reshape(1, n_beams), sensors, beams, rest, rest, hits)
        plan_lines(scan, frame, reading_filter, 0, lines, np.zeros(rows + 1), np.zeros(4, dtype=np.int64))
        hits = _hits_of(lines, _crossing(lines, 0, rows), 0, rows, cols)
    held = _add_hits(flat, hits, log_odds_update)
    for hit_cell in hits:
        flat_observed[hit_cell] = True
        written[min(n, len(written) - 1)] = uint32(hit_cell)
        n += 1
    for k in range(n_beams):
        z, is_used, no_return = _reading(float(ranges[k]), range_min, range_max, no_return_free)
        if not is_used:
            continue
        beam = (beams[k, 0], beams[k, 1])
        end_row, end_col, hit_row, hit_col, near, stop, at = _line_of(
            sensor, u, v, row, col, beam, z, no_return, window, growth, frame
        )
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        slope = _slope(major, minor)
        first = 0
        stop = min(stop, major + 1)
        if min(row, end_row) < 0 or max(row, end_row) >= rows or min(col, end_col) < 0 or max(col, end_col) >= cols:
            # Rounding may move an end out of the grid.
            first, stop = _clip(row, s_row, 0, rows, major, minor, steep, first, stop)
            first, stop = _clip(col, s_col, 0, cols, major, minor, not steep, first, stop)
        if first < stop:
            start = row * cols + col
            along, across = (s_row * cols, s_col) if steep else (s_col, s_row * cols)
            middle = max(min(near, stop), first)
            n = _add_steps(flat, flat_observed, start, along, across, slope, first, middle, at, miss, low, high,
                           miss_clamped, written, n)  # fmt: skip
            n = _add_steps(flat, flat_observed, start, along, across, slope, middle, stop, at, hit, low, high,
                           hit_clamped, written, n)  # fmt: skip
            count += stop - first - (1 if first <= at < stop else 0)
            n0, n1 = (_HALF + first * slope) >> _BITS, (_HALF + (stop - 1) * slope) >> _BITS
            r0, r1 = row + s_row * (first if steep else n0), row + s_row * (stop - 1 if steep else n1)
            c0, c1 = col + s_col * (n0 if steep else first), col + s_col * (n1 if steep else stop - 1)
            top, bottom = min(top, r0, r1), max(bottom, r0 + 1, r1 + 1)
            left, right = min(left, c0, c1), max(right, c0 + 1, c1 + 1)
        if 0 <= hit_row < rows and 0 <= hit_col < cols:
            cell = uint64(hit_row * cols + hit_col)
            flat[cell] = min(max(flat[cell] + hit, low), high)
            flat_observed[cell] = True
            written[min(n, len(written) - 1)] = uint32(cell)
            n += 1
            top, bottom = min(top, hit_row), max(bottom, hit_row + 1)
            left, right = min(left, hit_col), max(right, hit_col + 1)
            count += 1
    _put_back(flat, hits, held)
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count, n
