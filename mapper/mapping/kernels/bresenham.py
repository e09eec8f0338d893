"""Per-beam update along Bresenham's line from the sensor's cell to the reading's, for batches of scans.

Numba twin of :func:`mapper.mapping.textbook.update_per_beam`, in two passes. :func:`plan_lines` computes the line of
each beam and which of its cells are passed and which are hit. :func:`draw_lines` adds the evidence, in the order of the
beams, to a band of the grid's rows. Threads that draw one band each write to different cells, and the result equals
that of one thread, bit for bit.

A line's cells are computed in closed form, without an error term: after i steps along the major axis, Bresenham's 1965
rule has made ``(2·i·minor + major) // (2·major)`` steps along the minor one, so drawing can start at any step of a
line.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy import uint64

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels.hits_first import _add_hits, _put_back
from mapper.mapping.kernels.negative_zero import _without_minus_zero
from mapper.mapping.kernels.types import Cells, LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

#: A planned line: start cell, last cell, the number of its first cells that are passed (``near``), the number of its
#: first cells that are passed or hit (``far``; 0: the beam is ignored), the step at which it visits the endpoint's cell
#: (−1: never), and that cell (−1, −1: none is hit).
ROW, COL, END_ROW, END_COL, NEAR, FAR, AT, HIT_ROW, HIT_COL = range(9)
LINE_FIELDS = 9

# Steps along the minor axis in fixed point. With 40 fraction bits the rounding error of the slope, multiplied by the
# number of steps, stays below half of 1 / major, the smallest difference between two of Bresenham's decisions.
_BITS = 40
_HALF = 1 << (_BITS - 1)
MAX_STEPS = 1 << 19  #: longest line, in cells, for which that holds
_FAR_OUT = 1 << 30  # cells: no line from beyond comes near a grid, and all others fit into int32


@jit
def _slope(major: int, minor: int) -> int:
    """Return the minor-axis steps per major-axis step, in fixed point, rounded up."""
    steps = uint64(max(major, 1))
    return int(((uint64(minor) << uint64(_BITS)) + steps - uint64(1)) // steps)


@jit
def _is_within(d_u: float, d_v: float, limit: float, resolution: float, inclusive: bool) -> bool:
    """Return whether √(d_u² + d_v²) · resolution < ``limit`` (≥ 0), or ≤ with ``inclusive``.

    The root is computed only if the squares are so close that rounding may decide.
    """
    square = d_u * d_u + d_v * d_v
    apart = square * (resolution * resolution) - limit * limit
    if abs(apart) > 1e-9 * limit * limit:
        return apart < 0.0
    s = sqrt(square) * resolution
    return s < limit or (inclusive and s == limit)


@jit
def _reaches(u: float, v: float, row: int, col: int, end_row: int, end_col: int, slope: int, length: float,
             limit: float, resolution: float, inclusive: bool) -> int:  # fmt: skip
    """Return the number of cells at the start of a line with centres nearer to (u, v) than ``limit`` metres.

    Along a line that starts in the cell of (u, v) the distance never decreases, so the search starts at an estimate and
    steps to the border. ``slope`` is that of :func:`_slope`, ``length`` the length of the line in cells, at least 1.
    """
    if limit < 0.0:
        return 0
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    steep = d_row > d_col
    major = d_row if steep else d_col
    guess = limit / resolution * major / length
    i = int(min(max(guess, 0.0), float(major)))
    falling = False
    while 0 <= i <= major:
        n = (_HALF + i * slope) >> _BITS
        d_v = row + s_row * (i if steep else n) + 0.5 - v
        d_u = col + s_col * (n if steep else i) + 0.5 - u
        if _is_within(d_u, d_v, limit, resolution, inclusive):
            if falling:
                return i + 1
            i += 1
        elif i == 0:
            return 0
        else:
            falling = True
            i -= 1
            # A backward step that is near enough ends the search; a forward one that is not ends it in the next
            # iteration.
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
def _reading(z: float, range_min: float, range_max: float, no_return_free: bool) -> tuple[float, bool, bool]:
    """Return the beam length of a reading (metres), whether it is used, and whether it is a no return."""
    no_return = z > range_max
    if no_return:
        return range_max, no_return_free, True
    return z, z >= range_min, False  # not used: too near, NaN or −Inf


@jit
def _line_of(
    sensor: tuple[float, float, float, float], u: float, v: float, row: int, col: int, beam: tuple[float, float],
    z: float, no_return: bool, window: float, growth: float, frame: Frame,
) -> tuple[int, int, int, int, int, int, int]:  # fmt: skip
    """Return the end (row, col) of a beam's line, the hit cell (row, col), and the steps NEAR, FAR and AT.

    ``sensor`` (x, y, cos θ, sin θ) of ``T_map_laser`` is at (u, v) of the lattice, in the cell (row, col); ``beam`` is
    the cosine and sine of the bearing; ``z`` is in metres. The hit of a beam without return is (−1, −1).
    """
    x, y, cos, sin = sensor
    px, py = z * beam[0], z * beam[1]
    eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
    hit_row, hit_col = int(_cell_of(ev)), int(_cell_of(eu))
    steps = max(abs(hit_row - row), abs(hit_col - col))
    if no_return:
        return hit_row, hit_col, -1, -1, steps + 1, steps + 1, -1
    if not window > 0.0:
        return hit_row, hit_col, hit_row, hit_col, steps, steps, steps
    half = 0.5 * (window + growth * z)
    px, py = (z + half) * beam[0], (z + half) * beam[1]
    eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
    end_row, end_col = int(_cell_of(ev)), int(_cell_of(eu))
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    slope = _slope(max(d_row, d_col), min(d_row, d_col))
    length = max(sqrt(float(d_row * d_row + d_col * d_col)), 1.0)
    near = _reaches(u, v, row, col, end_row, end_col, slope, length, z - half, frame.resolution, False)
    far = _reaches(u, v, row, col, end_row, end_col, slope, length, z + half, frame.resolution, True)
    at = _step_at(row, col, end_row, end_col, hit_row, hit_col)
    return end_row, end_col, hit_row, hit_col, near, far, at


@jit
def plan_lines(
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    first: int,
    lines: Int32Array,
    work: Float64Array,
    box: Int64Array,
) -> None:
    """Write the line of each beam, scan by scan.

    ``scans`` and ``reading_filter``: see :mod:`mapper.mapping.kernels.types`. The columns [first, first + n_scans ·
    n_beams) of ``lines`` (9, n) int32 are written. The row-to-row differences of the drawing cost are added to ``work``
    (rows + 1,) float64. ``box`` (4,) int64 (row0, row1, col0, col1), half-open, is extended to the lines, including
    their parts outside the grid.
    """
    ranges, sensors, beams = scans.ranges, scans.sensors, scans.beams
    range_min, range_max, window, growth, no_return_free = reading_filter
    rows = len(work) - 1
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, frame)
        row, col = int(_cell_of(v)), int(_cell_of(u))
        too_far = max(abs(row), abs(col)) > _FAR_OUT
        for k in range(ranges.shape[1]):
            j = first + t * ranges.shape[1] + k
            lines[FAR, j], lines[HIT_ROW, j], lines[HIT_COL, j] = 0, -1, -1
            lines[ROW, j], lines[END_ROW, j] = -1, -1
            z, is_used, no_return = _reading(float(ranges[t, k]), range_min, range_max, no_return_free)
            if not is_used or too_far:
                continue
            pose, beam = (x, y, cos, sin), (beams[k, 0], beams[k, 1])
            end_row, end_col, hit_row, hit_col, near, far, at = _line_of(
                pose, u, v, row, col, beam, z, no_return, window, growth, frame
            )
            lines[ROW, j], lines[COL, j], lines[END_ROW, j], lines[END_COL, j] = row, col, end_row, end_col
            lines[NEAR, j], lines[FAR, j], lines[AT, j] = near, far, at
            lines[HIT_ROW, j], lines[HIT_COL, j] = hit_row, hit_col
            low, high = max(min(row, end_row), 0), min(max(row, end_row), rows - 1)
            if low <= high:
                d_row, d_col = abs(end_row - row), abs(end_col - col)
                cells = (max(d_row, d_col) + 1.0) / (d_row + 1.0)
                work[low] += cells
                work[high + 1] -= cells
            top, bottom = min(top, row, end_row), max(bottom, row + 1, end_row + 1)
            left, right = min(left, col, end_col), max(right, col + 1, end_col + 1)
    box[0], box[1], box[2], box[3] = top, bottom, left, right


@jit
def _clip(start: int, step: int, low: int, high: int, major: int, minor: int, along_major: bool, first: int,
          stop: int) -> tuple[int, int]:  # fmt: skip
    """Narrow the steps [first, stop) of a line to those whose coordinate on one axis is in [low, high)."""
    # The coordinate is start + step · n, so n must be in [least, most].
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
def _part(part: int, first: int, stop: int, near: int, at: int) -> tuple[int, int]:
    """Return the steps of a part of a line: two parts are passed, before and after the endpoint's cell, and two are
    hit.
    """
    if part == 0:
        return first, min(near, at, stop)
    if part == 1:
        return max(first, min(at + 1, stop)), min(near, stop)
    if part == 2:
        return max(first, near), min(at, stop)
    return max(first, near, at + 1), stop


@jit
def _crossing(lines: Int32Array, row_low: int, row_high: int) -> Int64Array:
    """Return which lines have a cell in the rows [row_low, row_high), without unpredictable branches."""
    chosen = np.empty(lines.shape[1], dtype=np.int64)
    count = 0
    for j in range(lines.shape[1]):
        row, end_row, hit_row = lines[ROW, j], lines[END_ROW, j], lines[HIT_ROW, j]
        chosen[count] = j
        passes = (max(row, end_row) >= row_low) & (min(row, end_row) < row_high)
        hits = (hit_row >= row_low) & (hit_row < row_high)
        count += 1 if passes | hits else 0
    return chosen[:count]


@jit
def _hits_of(
    lines: Int32Array, chosen: Int64Array, row_low: int, row_high: int, cols: int
) -> Int64Array:  # fmt: skip
    """Return the cells (row · cols + col) in the rows [row_low, row_high) that the ``chosen`` lines hit, in order."""
    most = len(chosen)
    for j in chosen:
        most += max(int(lines[FAR, j]) - int(lines[NEAR, j]), 0)
    hit_cells = np.empty(most, dtype=np.int64)
    count = 0
    for j in chosen:
        row, col = int(lines[ROW, j]), int(lines[COL, j])
        end_row, end_col = int(lines[END_ROW, j]), int(lines[END_COL, j])
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        for i in range(int(lines[NEAR, j]), min(int(lines[FAR, j]), major + 1)):
            n = (2 * i * minor + major) // max(2 * major, 1)
            r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
            if i != lines[AT, j] and row_low <= r < row_high and 0 <= c < cols:
                hit_cells[count] = r * cols + c
                count += 1
        r, c = int(lines[HIT_ROW, j]), int(lines[HIT_COL, j])
        if row_low <= r < row_high and 0 <= c < cols:
            hit_cells[count] = r * cols + c
            count += 1
    return hit_cells[:count]


@jit
def _draw_chosen(
    cells: Cells, lines: Int32Array, chosen: Int64Array, log_odds_update: LogOddsUpdate, hits_only: bool,
    row_low: int, row_high: int, box: Int64Array, mark: bool,
) -> int:  # fmt: skip
    """Add the evidence of the ``chosen`` lines, as in :func:`draw_lines`."""
    log_odds, observed, cols = cells
    miss, hit, low, high = _without_minus_zero(log_odds_update)
    # Local copies, because the boxes of two threads may share a cache line (false sharing).
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    for number in range(len(chosen)):
        j = chosen[number]
        row, col = int(lines[ROW, j]), int(lines[COL, j])
        end_row, end_col = int(lines[END_ROW, j]), int(lines[END_COL, j])
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        first, stop = 0, min(int(lines[FAR, j]), major + 1)
        low_row, high_row = min(row, end_row), max(row, end_row)
        if low_row < row_low or high_row >= row_high or min(col, end_col) < 0 or max(col, end_col) >= cols:
            first, stop = _clip(row, s_row, row_low, row_high, major, minor, steep, first, stop)
            first, stop = _clip(col, s_col, 0, cols, major, minor, not steep, first, stop)
        if hits_only:  # passed cells are before the step NEAR
            first = max(first, int(lines[NEAR, j]))
        if first < stop:
            base = row * cols + col
            along, across = (s_row * cols, s_col) if steep else (s_col, s_row * cols)
            slope = ((minor << _BITS) + major - 1) // max(major, 1)  # rounded up
            near, at = int(lines[NEAR, j]), int(lines[AT, j])
            if at < first or at >= stop:  # the endpoint's cell is left out and drawn last
                at = stop
            # One loop for all parts, of which usually only the first is not empty, keeps short lines cheap.
            for part in range(1 if min(near, at) >= stop else 4):
                begin, end = _part(part, first, stop, near, at)
                increment = miss if part < 2 else hit
                position = _HALF + begin * slope
                for i in range(begin, end):
                    cell = uint64(base + i * along + (position >> _BITS) * across)
                    position += slope
                    log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
                    if mark:
                        observed[cell] = True
                count += max(end - begin, 0)
            n0, n1 = (_HALF + first * slope) >> _BITS, (_HALF + (stop - 1) * slope) >> _BITS
            r0, r1 = row + s_row * (first if steep else n0), row + s_row * (stop - 1 if steep else n1)
            c0, c1 = col + s_col * (n0 if steep else first), col + s_col * (n1 if steep else stop - 1)
            top, bottom = min(top, r0, r1), max(bottom, r0 + 1, r1 + 1)
            left, right = min(left, c0, c1), max(right, c0 + 1, c1 + 1)
        r, c = int(lines[HIT_ROW, j]), int(lines[HIT_COL, j])
        if row_low <= r < row_high and 0 <= c < cols:
            cell = uint64(r * cols + c)
            log_odds[cell] = min(max(log_odds[cell] + hit, low), high)
            if mark:
                observed[cell] = True
            top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
            count += 1
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count


@jit
def draw_lines(
    cells: Cells,
    lines: Int32Array,
    log_odds_update: LogOddsUpdate,
    hits_only: bool,
    scan_ends: Int64Array,
    row_low: int,
    row_high: int,
    box: Int64Array,
    mark: bool,
) -> int:
    """Add the evidence of ``lines`` (9, n) to the rows [row_low, row_high) of the grid; return the number of cell
    updates.

    With ``hits_only``, cells that beams pass are not changed, counted or marked. With ``scan_ends``, the line after the
    last one of each scan, only hits count in the cells that a scan hits, but updates by misses are counted there as
    well. If it is empty, both count.

    ``cells.observed`` is written only with ``mark`` (see :mod:`mapper.mapping.kernels.negative_zero`). ``box`` (4,)
    int64 (row0, row1, col0, col1), half-open, is extended to the touched cells. ``log_odds_update``: see
    :mod:`mapper.mapping.kernels.types`.
    """
    chosen = _crossing(lines, row_low, row_high)
    if len(scan_ends) == 0:
        return _draw_chosen(cells, lines, chosen, log_odds_update, hits_only, row_low, row_high, box, mark)
    own = box.copy()  # a copy, because the boxes of two threads may share a cache line (false sharing)
    first, count = 0, 0
    for end in scan_ends:
        stop = first
        while stop < len(chosen) and chosen[stop] < end:
            stop += 1
        if first < stop:
            part = chosen[first:stop]
            hits = _hits_of(lines, part, row_low, row_high, cells.cols)
            held = _add_hits(cells.log_odds, hits, log_odds_update)
            count += _draw_chosen(cells, lines, part, log_odds_update, hits_only, row_low, row_high, own, mark)
            _put_back(cells.log_odds, hits, held)
        first = stop
    box[:] = own
    return count


@jit
def reach(
    ranges: Float32Array,
    sensors: Float64Array,
    beams: Float64Array,
    reading_filter: ReadingFilter,
    bounds: Float64Array,
) -> None:
    """Extend ``bounds`` (4,) float64 (x_min, y_min, x_max, y_max), metres, to the sensors and what they observe.

    ``ranges``, ``sensors`` and ``beams`` are those of :class:`mapper.mapping.kernels.types.Scans`.
    """
    range_min, range_max, window, growth, no_return_free = reading_filter
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
