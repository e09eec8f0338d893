"""The per-beam update: Bresenham's line from the sensor's cell to the reading's, for whole batches of scans.

Numba twin of :func:`mapper.textbook.update_per_beam`, in two passes. :func:`plan_lines` says for each beam which line
it is and which of its cells are passed and which are hit. :func:`draw_lines` adds the evidence, in the order of the
beams, to a band of the grid's rows: threads that draw one band each never meet and give together, bit for bit, what
one gives.

A line's cells are not stepped through with an error term but computed: after i steps along the major axis Bresenham's
1965 rule has made ``(2·i·minor + major) // (2·major)`` steps along the minor one, so a line can be entered anywhere.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy import uint64

from mapper.kernels.compiled import jit
from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.types import BoolArray, Float32Array, Float64Array, Frame, Int64Array, Rule, Sight

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

#: A planned line: start cell, last cell, the number of its first cells that are passed (``near``), the number of its
#: first cells that are passed or hit (``far``; 0: none, the beam says nothing), the step at which it visits the
#: endpoint's cell (−1: never), that cell (−1, −1: none is hit).
ROW, COL, END_ROW, END_COL, NEAR, FAR, AT, HIT_ROW, HIT_COL = range(9)
LINE_FIELDS = 9

# Steps along the minor axis in fixed point: with 40 bits of fraction the rounding error of the slope, multiplied by the
# number of steps, stays below half of 1 / major, the least that tells two of Bresenham's decisions apart.
_BITS = 40
MAX_STEPS = 1 << 19  #: the longest line, in cells, for which that holds


@jit
def _reaches(u: float, v: float, row: int, col: int, end_row: int, end_col: int, limit: float, resolution: float,
             inclusive: bool) -> int:  # fmt: skip
    """Return how many cells at the start of a line have their centre nearer to (u, v) than ``limit`` metres.

    Along a line that starts in the cell of (u, v) the distance never falls: from a guess the border is walked to.
    """
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major, minor = (d_row, d_col) if steep else (d_col, d_row)
    twice = max(2 * major, 1)
    guess = limit / resolution * major / max(sqrt(float(major * major + minor * minor)), 1.0)
    i = int(min(max(guess, 0.0), float(major)))
    falling = False
    while 0 <= i <= major:
        n = (2 * i * minor + major) // twice
        d_v = row + s_row * (i if steep else n) + 0.5 - v
        d_u = col + s_col * (n if steep else i) + 0.5 - u
        s = sqrt(d_u * d_u + d_v * d_v) * resolution
        if s < limit or (inclusive and s == limit):
            if falling:
                return i + 1
            i += 1
        elif i == 0:
            return 0
        else:
            falling = True
            i -= 1
            # A step back that is near enough ends the walk; one forward that is not does so at the next turn.
    return i


@jit
def _step_at(row: int, col: int, end_row: int, end_col: int, at_row: int, at_col: int) -> int:
    """Return the step at which a line visits a cell, or −1."""
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major, minor = (d_row, d_col) if steep else (d_col, d_row)
    i = s_row * (at_row - row) if steep else s_col * (at_col - col)
    n = s_col * (at_col - col) if steep else s_row * (at_row - row)
    if 0 <= i <= major and (2 * i * minor + major) // max(2 * major, 1) == n:
        return i
    return -1


@jit
def plan_lines(ranges: Float32Array, sensors: Float64Array, beams: Float64Array, frame: Frame, sight: Sight,
               lines: Int64Array, work: Float64Array) -> None:  # fmt: skip
    """Write the line of each beam, scan after scan.

    ``ranges`` (n_scans, n_beams) float32, metres; ``sensors`` (n_scans, 4) float64: x, y, cos θ, sin θ of
    ``T_map_laser``; ``beams`` (n_beams, 2) float64: cosine and sine of each bearing; ``frame`` and ``sight``: see
    :mod:`mapper.kernels.types`. ``lines`` (n_scans · n_beams, 9) int64 is written; to ``work`` (rows + 1,) float64
    the differences, from row to row, of the number of cells to draw are added.
    """
    range_min, range_max, window, growth, no_return_free = sight
    resolution = frame[4]
    rows = len(work) - 1
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        row, col = int(_cell_of(v)), int(_cell_of(u))
        for k in range(ranges.shape[1]):
            line = lines[t * ranges.shape[1] + k]
            line[FAR], line[HIT_ROW], line[HIT_COL] = 0, -1, -1
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
            end_row, end_col = hit_row, hit_col
            steps = max(abs(hit_row - row), abs(hit_col - col))
            near, far, at = steps, steps, steps
            if no_return:
                near, far, at, hit_row, hit_col = steps + 1, steps + 1, -1, -1, -1
            elif window > 0.0:
                half = 0.5 * (window + growth * z)
                px, py = (z + half) * beams[k, 0], (z + half) * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
                end_row, end_col = int(_cell_of(ev)), int(_cell_of(eu))
                near = _reaches(u, v, row, col, end_row, end_col, z - half, resolution, False)
                far = _reaches(u, v, row, col, end_row, end_col, z + half, resolution, True)
                at = _step_at(row, col, end_row, end_col, hit_row, hit_col)
            line[ROW], line[COL], line[END_ROW], line[END_COL] = row, col, end_row, end_col
            line[NEAR], line[FAR], line[AT], line[HIT_ROW], line[HIT_COL] = near, far, at, hit_row, hit_col
            low, high = max(min(row, end_row), 0), min(max(row, end_row), rows - 1)
            if low <= high:
                cells = (steps + 1.0) / (abs(end_row - row) + 1.0)
                work[low] += cells
                work[high + 1] -= cells


@jit
def _clip(start: int, step: int, low: int, high: int, major: int, minor: int, along_major: bool, first: int,
          stop: int) -> tuple[int, int]:  # fmt: skip
    """Narrow the steps [first, stop) of a line to those whose coordinate on one axis lies in [low, high)."""
    # The coordinate is start + step · n, so n must lie in [least, most].
    least, most = (low - start, high - 1 - start) if step > 0 else (start - high + 1, start - low)
    if along_major:
        return max(first, least), min(stop, most + 1)
    if minor == 0:
        return (first, stop) if least <= 0 <= most else (first, first)
    # n = (2·i·minor + major) // (2·major)  ≥ least   ⇔   i ≥ ⌈(2·least − 1)·major / (2·minor)⌉
    first = max(first, -((-(2 * least - 1) * major) // (2 * minor)))
    stop = min(stop, -((-(2 * most + 1) * major) // (2 * minor)))
    return first, stop


@jit
def _add(log_odds: Float32Array, observed: BoolArray, first: int, stop: int, base: int, along: int, across: int,
         slope: int, increment: np.float32, low: np.float32, high: np.float32) -> int:  # fmt: skip
    """Add ``increment`` at the steps [first, stop) of a line in the flat arrays; return how many those are."""
    position = (1 << (_BITS - 1)) + first * slope
    for i in range(first, stop):
        cell = uint64(base + i * along + (position >> _BITS) * across)
        position += slope
        log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
        observed[cell] = True
    return max(stop - first, 0)


@jit
def draw_lines(log_odds: Float32Array, observed: BoolArray, cols: int, lines: Int64Array, rule: Rule, row_low: int,
               row_high: int, box: Int64Array) -> int:  # fmt: skip
    """Add what ``lines`` (n, 9) say to the rows [row_low, row_high) of the grid; return the number of cell updates.

    ``log_odds`` float32 and ``observed`` bool are the grid's cells row after row, ``cols`` in each; ``box`` (4,) int64
    (row0, row1, col0, col1), half-open, is widened to hold what was touched; ``rule``: :mod:`mapper.kernels.types`.
    """
    miss, hit, low, high = rule
    # Kept in registers: two threads that wrote their boxes side by side would fight for one cache line.
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    for j in range(lines.shape[0]):
        line = lines[j]
        if line[FAR] == 0 and line[HIT_ROW] == -1 and line[HIT_COL] == -1:
            continue
        row, col, end_row, end_col = line[ROW], line[COL], line[END_ROW], line[END_COL]
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        first, stop = 0, min(line[FAR], major + 1)
        low_row, high_row = min(row, end_row), max(row, end_row)
        if high_row < row_low or low_row >= row_high:
            stop = 0
        elif low_row < row_low or high_row >= row_high or min(col, end_col) < 0 or max(col, end_col) >= cols:
            first, stop = _clip(row, s_row, row_low, row_high, major, minor, steep, first, stop)
            first, stop = _clip(col, s_col, 0, cols, major, minor, not steep, first, stop)
        if first < stop:
            base = row * cols + col
            along, across = (s_row * cols, s_col) if steep else (s_col, s_row * cols)
            slope = -((-minor << _BITS) // major) if major > 0 else 0
            near, at = line[NEAR], line[AT]
            if at < first or at >= stop:  # the endpoint's cell, which comes last, is left out
                at = stop
            count += _add(log_odds, observed, first, min(near, at, stop), base, along, across, slope, miss, low, high)
            if at < stop or near < stop:
                begin = max(first, min(at + 1, stop))
                count += _add(log_odds, observed, begin, min(near, stop), base, along, across, slope, miss, low, high)
                begin = max(first, near)
                count += _add(log_odds, observed, begin, min(at, stop), base, along, across, slope, hit, low, high)
                begin = max(first, near, at + 1)
                count += _add(log_odds, observed, begin, stop, base, along, across, slope, hit, low, high)
            for i in (first, stop - 1):
                n = (2 * i * minor + major) // max(2 * major, 1)
                r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
                top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
        r, c = line[HIT_ROW], line[HIT_COL]
        if row_low <= r < row_high and 0 <= c < cols:
            cell = r * cols + c
            log_odds[cell] = min(max(log_odds[cell] + hit, low), high)
            observed[cell] = True
            top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
            count += 1
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count


@jit
def reach(ranges: Float32Array, sensors: Float64Array, beams: Float64Array, sight: Sight, bounds: Float64Array) -> None:
    """Widen ``bounds`` (4,) float64 (x_min, y_min, x_max, y_max), metres, to hold the sensors and what they see.

    The other arguments are those of :func:`plan_lines`.
    """
    range_min, range_max, window, growth, no_return_free = sight
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
                z += 0.5 * (window + growth * z)
            px, py = z * beams[k, 0], z * beams[k, 1]
            end_x, end_y = x + cos * px - sin * py, y + sin * px + cos * py
            bounds[0], bounds[1] = min(bounds[0], end_x), min(bounds[1], end_y)
            bounds[2], bounds[3] = max(bounds[2], end_x), max(bounds[3], end_y)
