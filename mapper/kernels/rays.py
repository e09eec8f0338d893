"""The per-beam update: Bresenham's line from the sensor's cell to the reading's, for whole batches of scans.

Numba twin of :func:`mapper.textbook.update_per_beam`. A line's cells are not stepped through with an error term but
computed: after i steps along the major axis Bresenham's 1965 rule has made ``(2·i·minor + major) // (2·major)`` steps
along the minor one, so a line can be entered anywhere, which is what clipping needs.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.types import BoolArray, Float32Array, Float64Array, Frame, Int64Array, Rule, Sight

_to_lattice = njit(to_lattice, nogil=True, cache=True)
_cell_of = njit(cell_of, nogil=True, cache=True)


@njit(nogil=True, cache=True)
def _clip(
    start: int, step: int, side: int, major: int, minor: int, along_major: bool, first: int, stop: int
) -> tuple[int, int]:
    """Narrow the steps [first, stop) of a line to those whose coordinate on one axis lies in [0, side)."""
    # The coordinate is start + step·n, so n must lie in [low, high].
    if step > 0:
        low, high = -start, side - 1 - start
    else:
        low, high = start - side + 1, start
    if along_major:
        return max(first, low), min(stop, high + 1)
    if minor == 0:
        return (first, stop) if low <= 0 <= high else (first, first)
    # n = (2·i·minor + major) // (2·major)  ≥ low   ⇔   i ≥ ⌈(2·low − 1)·major / (2·minor)⌉
    first = max(first, -((-(2 * low - 1) * major) // (2 * minor)))
    stop = min(stop, -((-(2 * high + 1) * major) // (2 * minor)))
    return first, stop


@njit(nogil=True, cache=True)
def _add_run(
    log_odds: Float32Array,
    observed: BoolArray,
    row: int,
    col: int,
    end_row: int,
    end_col: int,
    first: int,
    stop: int,
    increment: np.float32,
    low: np.float32,
    high: np.float32,
    box: Int64Array,
) -> int:
    """Add ``increment`` to the cells at steps [first, stop) of the line (row, col) → (end_row, end_col).

    Returns how many of them lie in the grid.
    """
    rows, cols = log_odds.shape
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major, minor = (d_row, d_col) if steep else (d_col, d_row)
    first, stop = max(first, 0), min(stop, major + 1)
    if not (0 <= row < rows and 0 <= end_row < rows and 0 <= col < cols and 0 <= end_col < cols):
        first, stop = _clip(row, s_row, rows, major, minor, steep, first, stop)
        first, stop = _clip(col, s_col, cols, major, minor, not steep, first, stop)
    if stop <= first:
        return 0
    twice = max(2 * major, 1)
    for i in range(first, stop):
        n = (2 * i * minor + major) // twice
        r = row + s_row * (i if steep else n)
        c = col + s_col * (n if steep else i)
        value = log_odds[r, c] + increment
        log_odds[r, c] = min(max(value, low), high)
        observed[r, c] = True
        if i == first or i == stop - 1:
            box[0], box[1] = min(box[0], r), max(box[1], r + 1)
            box[2], box[3] = min(box[2], c), max(box[3], c + 1)
    return int(stop - first)


@njit(nogil=True, cache=True)
def _steps_nearer(
    u: float, v: float, row: int, col: int, end_row: int, end_col: int, limit: float, resolution: float, inclusive: bool
) -> int:
    """Return how many cells at the start of a line have their centre nearer to (u, v) than ``limit`` metres.

    Along a line that starts in the cell of (u, v) the distance never falls, so the border is found by bisection.
    """
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major, minor = (d_row, d_col) if steep else (d_col, d_row)
    twice = max(2 * major, 1)
    low, high = 0, int(major + 1)
    while low < high:
        i = (low + high) // 2
        n = (2 * i * minor + major) // twice
        d_v = row + s_row * (i if steep else n) + 0.5 - v
        d_u = col + s_col * (n if steep else i) + 0.5 - u
        s = sqrt(d_u * d_u + d_v * d_v) * resolution
        if s < limit or (inclusive and s == limit):
            low = i + 1
        else:
            high = i
    return low


@njit(nogil=True, cache=True)
def _step_of(row: int, col: int, end_row: int, end_col: int, at_row: int, at_col: int) -> int:
    """Return the step at which a line visits a cell, or −1."""
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major, minor = (d_row, d_col) if steep else (d_col, d_row)
    i = s_row * (at_row - row) if steep else s_col * (at_col - col)
    n = s_col * (at_col - col) if steep else s_row * (at_row - row)
    if 0 <= i <= major and (2 * i * minor + major) // max(2 * major, 1) == n:
        return int(i)
    return -1


@njit(nogil=True, cache=True)
def add_rays(
    log_odds: Float32Array,
    observed: BoolArray,
    box: Int64Array,
    ranges: Float32Array,
    sensors: Float64Array,
    beams: Float64Array,
    frame: Frame,
    sight: Sight,
    rule: Rule,
) -> int:
    """Add every beam of every scan to the grid; return the number of cell updates.

    ``log_odds`` (rows, cols) float32 and ``observed`` (rows, cols) bool are written; ``box`` (4,) int64 (row0, row1,
    col0, col1), half-open, is widened to hold what was touched. ``ranges`` (n_scans, n_beams) float32, metres;
    ``sensors`` (n_scans, 4) float64: x, y, cos θ, sin θ of ``T_map_laser``; ``beams`` (n_beams, 2) float64: cosine and
    sine of each bearing. ``frame``, ``sight`` and ``rule``: see :mod:`mapper.kernels.types`.
    """
    range_min, range_max, window, no_return_free = sight
    miss, hit, low, high = rule
    resolution = frame[4]
    count = 0
    half = 0.5 * window
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        row, col = int(_cell_of(v)), int(_cell_of(u))
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            no_return = z > range_max
            if no_return:
                if not no_return_free:
                    continue
                z = range_max
            elif not z >= range_min:  # too near, NaN or −Inf
                continue
            px, py = z * beams[k, 0], z * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
            hit_row, hit_col = int(_cell_of(ev)), int(_cell_of(eu))
            steps = max(abs(hit_row - row), abs(hit_col - col))
            if no_return:
                count += _add_run(log_odds, observed, row, col, hit_row, hit_col, 0, steps + 1, miss, low, high, box)
                continue
            if window == 0.0:
                count += _add_run(log_odds, observed, row, col, hit_row, hit_col, 0, steps, miss, low, high, box)
                count += _add_run(log_odds, observed, hit_row, hit_col, hit_row, hit_col, 0, 1, hit, low, high, box)
                continue
            px, py = (z + half) * beams[k, 0], (z + half) * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
            end_row, end_col = int(_cell_of(ev)), int(_cell_of(eu))
            near = _steps_nearer(u, v, row, col, end_row, end_col, z - half, resolution, False)
            far = _steps_nearer(u, v, row, col, end_row, end_col, z + half, resolution, True)
            at = _step_of(row, col, end_row, end_col, hit_row, hit_col)
            split = near if at < 0 else min(at, near)
            count += _add_run(log_odds, observed, row, col, end_row, end_col, 0, split, miss, low, high, box)
            count += _add_run(log_odds, observed, row, col, end_row, end_col, split + 1, near, miss, low, high, box)
            split = far if at < near else min(at, far)
            count += _add_run(log_odds, observed, row, col, end_row, end_col, near, split, hit, low, high, box)
            count += _add_run(log_odds, observed, row, col, end_row, end_col, split + 1, far, hit, low, high, box)
            count += _add_run(log_odds, observed, hit_row, hit_col, hit_row, hit_col, 0, 1, hit, low, high, box)
    return count


@njit(nogil=True, cache=True)
def reach(ranges: Float32Array, sensors: Float64Array, beams: Float64Array, sight: Sight, bounds: Float64Array) -> None:
    """Widen ``bounds`` (4,) float64 (x_min, y_min, x_max, y_max), metres, to hold the sensors and what they see.

    The other arguments are those of :func:`add_rays`.
    """
    range_min, range_max, window, no_return_free = sight
    half = 0.5 * window
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        bounds[0], bounds[1] = min(bounds[0], x), min(bounds[1], y)
        bounds[2], bounds[3] = max(bounds[2], x), max(bounds[3], y)
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            if z > range_max:
                if not no_return_free:
                    continue
                z = range_max
            elif not z >= range_min:
                continue
            else:
                z += half
            px, py = z * beams[k, 0], z * beams[k, 1]
            end_x, end_y = x + cos * px - sin * py, y + sin * px + cos * py
            bounds[0], bounds[1] = min(bounds[0], end_x), min(bounds[1], end_y)
            bounds[2], bounds[3] = max(bounds[2], end_x), max(bounds[3], end_y)
