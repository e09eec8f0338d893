"""The per-scan update: each cell of the perceptual field once, by the beam whose field it lies in.

Numba twin of :func:`mapper.textbook.update_per_scan`, in two passes. :func:`plan_runs` turns scans into runs of cells
along rows; :func:`draw_runs` adds the evidence to a band of the grid's rows, so that threads never meet.

What a scan frees is a star-shaped region, one sector for each beam. Its rows are found from their ends: a toggle, one
bit in a bitmap, stands wherever a row enters or leaves a sector, and a running exclusive or along the row fills it.
Where two neighbours both reach beyond a place on the edge between them their toggles cancel and are not even computed,
so the work goes with the region's outline and not with its area. Ends are found by division and square root; where that
falls close to a cell's centre, the exact test of the textbook decides.
"""

from __future__ import annotations

from math import ceil, floor, sqrt

import numpy as np
from numba import njit
from numpy import uint64

from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.types import (
    BoolArray,
    Float32Array,
    Float64Array,
    Frame,
    Int64Array,
    Rule,
    Sight,
    UInt32Array,
)

_to_lattice = njit(to_lattice, nogil=True, cache=True)
_cell_of = njit(cell_of, nogil=True, cache=True)

ROW, COL, STOP, KIND = range(4)  #: a run: its row, its first column, the column after its last, miss or hit
MISS, HIT = 0, 1
RUN_FIELDS = 4

_WORD = 0xFFFFFFFF
_FAR = 1 << 40  # beyond every column
_CLOSE = 1e-3  # of a cell: nearer than this to a centre, the exact test decides
_HAIR = 1e-6  # of a cell, far above what rounding does to a place in the grid
_MARGIN = 1.001  # cells: nearer to a sector's arc than this, the edge's toggles are computed


@njit(nogil=True, cache=True)
def _crossing(edge_u: float, edge_v: float, slope: float, d_v: float, u: float, radius: float) -> int:
    """Return the first column that lies beyond an edge's line on a row, going right; ``slope`` is edge_u / edge_v."""
    at = slope * d_v
    if abs(at) > radius + 4.0:  # far outside the arc, where only the side counts
        return floor(u + (radius + 4.0 if at > 0.0 else -radius - 4.0))
    at += u - 0.5
    column = floor(at) + 1
    if abs(at - floor(at + 0.5)) < _CLOSE:
        column -= 1
        while (edge_u * d_v - edge_v * (column + 0.5 - u) < 0.0) != (edge_v > 0.0):
            column += 1
    return column


@njit(nogil=True, cache=True)
def _inside(column: int, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> bool:
    d_u = column + 0.5 - u
    s = sqrt(d_u * d_u + d_v * d_v) * resolution
    return s < limit or (inclusive and s == limit)


@njit(nogil=True, cache=True)
def _half_chord(d_v: float, radius: float) -> float:
    """Return half the length of the chord that a circle cuts from a row, in cells; −1 where it cuts none."""
    square = radius * radius - d_v * d_v
    return sqrt(max(square, 0.0)) if square > -1e-6 * radius * radius else -1.0


@njit(nogil=True, cache=True)
def _arc_first(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the first column of a row whose centre lies within ``limit`` metres; ``half`` is half the chord."""
    at = u - half - 0.5
    column = ceil(at)
    if abs(at - floor(at + 0.5)) < _CLOSE:
        column = floor(at + 0.5) - 1
        while column <= u + half + 1.0 and not _inside(column, d_v, u, limit, resolution, inclusive):
            column += 1
    return column


@njit(nogil=True, cache=True)
def _arc_stop(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the column after the last one of a row whose centre lies within ``limit`` metres."""
    at = u + half - 0.5
    column = floor(at) + 1
    if abs(at - floor(at + 0.5)) < _CLOSE:
        column = floor(at + 0.5) + 2
        while column >= u - half - 1.0 and not _inside(column - 1, d_v, u, limit, resolution, inclusive):
            column -= 1
    return column


@njit(nogil=True, cache=True)
def _toggle(bits: UInt32Array, row: int, column: int, cols: int) -> None:
    """Flip the bit of a column; before the first column all flips meet on it, beyond the last none matters."""
    column = max(column, 0)
    if column < cols:
        bits[row, column >> 5] ^= np.uint32(1 << (column & 31))


@njit(nogil=True, cache=True)
def _mark(bits: UInt32Array, row: int, first: int, stop: int, cols: int) -> int:
    """Set the bits of the columns [first, stop); return how many of them there are."""
    first, stop = max(first, 0), min(stop, cols)
    for column in range(first, stop):
        bits[row, column >> 5] |= np.uint32(1 << (column & 31))
    return max(stop - first, 0)


@njit(nogil=True, cache=True)
def _sector_rows(
    v: float, right_v: float, left_v: float, right_u: float, left_u: float, near: float, far: float, rows: int
) -> tuple[int, int]:
    """Return the rows [first, stop) in which a sector has cells at ``near`` … ``far`` cells, a hair too many."""
    low = min(right_v, left_v)
    high = max(right_v, left_v)
    low, high = min(low * near, low * far), max(high * near, high * far)
    if right_u * left_u <= 0.0:  # it holds the v axis, where the arc bulges out
        low, high = (low, far) if right_v + left_v > 0.0 else (-far, high)
    return max(ceil(v + low - 0.5 - _HAIR), 0), min(floor(v + high - 0.5 + _HAIR) + 1, rows)


@njit(nogil=True, cache=True)
def _nonzero(value: float) -> float:
    """Return a value to divide by: 1 where it is 0, in which case the quotient is not used."""
    return value if value != 0.0 else 1.0


@njit(nogil=True, cache=True)
def _bounds(
    right_u: float, right_v: float, left_u: float, left_v: float, d_v: float, u: float, radius: float
) -> tuple[int, int]:
    """Return the columns [first, stop) of a row that lie between a sector's edges, without regard to its arc."""
    first, stop = -_FAR, _FAR
    right_slope, left_slope = right_u / _nonzero(right_v), left_u / _nonzero(left_v)
    if right_v > 0.0:
        stop = min(stop, _crossing(right_u, right_v, right_slope, d_v, u, radius))
    elif right_v < 0.0:
        first = max(first, _crossing(right_u, right_v, right_slope, d_v, u, radius))
    elif right_u * d_v < 0.0:
        return 0, 0
    if left_v > 0.0:
        first = max(first, _crossing(left_u, left_v, left_slope, d_v, u, radius))
    elif left_v < 0.0:
        stop = min(stop, _crossing(left_u, left_v, left_slope, d_v, u, radius))
    elif left_u * d_v >= 0.0:
        return 0, 0
    return first, stop


@njit(nogil=True, cache=True)
def _outline(
    toggles: UInt32Array, here: Int64Array, cols: int, u: float, v: float, right_u: float, right_v: float,
    left_u: float, left_v: float, limit: float, right_inner: float, left_inner: float, resolution: float,
) -> int:  # fmt: skip
    """Toggle where rows enter and leave the sector of cells with s < ``limit`` metres; return how many toggles.

    Up to ``right_inner`` and ``left_inner`` cells along an edge the neighbour toggles the same, so neither does.
    """
    radius = limit / resolution
    right_skip, left_skip = abs(right_v) * right_inner, abs(left_v) * left_inner
    right_whole, left_whole = abs(right_v) * (radius - _MARGIN), abs(left_v) * (radius - _MARGIN)
    right_slope, left_slope = right_u / _nonzero(right_v), left_u / _nonzero(left_v)
    # Only where both edges go up, or both down, can a whole row lie within what is skipped.
    inner = min(right_inner, left_inner) if right_v * left_v > 0.0 else 0.0
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, inner, radius, toggles.shape[0])
    count = 0
    least, most = cols, 0
    for r in range(first_row, stop_row):
        d_v = r + 0.5 - v
        height = abs(d_v)
        right_crosses = right_v * d_v > 0.0
        left_crosses = left_v * d_v > 0.0
        if not right_crosses and not left_crosses and d_v != 0.0:
            continue
        skip_right = right_crosses and height < right_skip
        skip_left = left_crosses and height < left_skip
        if skip_right and skip_left:
            continue
        first, stop = -_FAR, _FAR
        half = -1.0
        # Going up, the right edge bounds the row on its right; going down, on its left.
        on_right = (right_crosses and height < right_whole) if d_v > 0.0 else (left_crosses and height < left_whole)
        on_left = (left_crosses and height < left_whole) if d_v > 0.0 else (right_crosses and height < right_whole)
        if not (on_left and on_right):
            half = _half_chord(d_v, radius)
            if half < 0.0:
                continue
            if not on_left:
                first = _arc_first(half, d_v, u, limit, resolution, False)
            if not on_right:
                stop = _arc_stop(half, d_v, u, limit, resolution, False)
        if right_crosses and not skip_right:
            at = _crossing(right_u, right_v, right_slope, d_v, u, radius)
            if d_v > 0.0:
                stop = min(stop, at)
            else:
                first = max(first, at)
        if left_crosses and not skip_left:
            at = _crossing(left_u, left_v, left_slope, d_v, u, radius)
            if d_v > 0.0:
                first = max(first, at)
            else:
                stop = min(stop, at)
        if d_v == 0.0:
            low, high = _bounds(right_u, right_v, left_u, left_v, d_v, u, radius)
            first, stop = max(first, low), min(stop, high)
        if first >= stop:
            continue
        # A side that is skipped is still as far away as the row's arc says, and no toggle goes there.
        if first > -_FAR:
            _toggle(toggles, r, first, cols)
            least, most = min(least, first), max(most, first)
            count += 1
        if stop < _FAR:
            _toggle(toggles, r, stop, cols)
            least, most = min(least, stop), max(most, stop)
            count += 1
    if count:
        here[0], here[1] = min(here[0], max(first_row, 0)), max(here[1], stop_row)
        here[2], here[3] = min(here[2], least), max(here[3], most)
    return count


@njit(nogil=True, cache=True)
def _ring(
    hits: UInt32Array, here: Int64Array, cols: int, u: float, v: float, right_u: float, right_v: float, left_u: float,
    left_v: float, nearest: float, farthest: float, resolution: float,
) -> int:  # fmt: skip
    """Mark the sector's cells with ``nearest`` ≤ s ≤ ``farthest`` metres; return a bound on their number."""
    rows = hits.shape[0]
    radius = farthest / resolution
    inner = max(nearest / resolution, 0.0) if right_v * left_v > 0.0 else 0.0
    count = 0
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, inner, radius, rows)
    for r in range(first_row, stop_row):
        d_v = r + 0.5 - v
        first, stop = _bounds(right_u, right_v, left_u, left_v, d_v, u, radius)
        half = _half_chord(d_v, radius)
        if half < 0.0:
            continue
        first = max(first, _arc_first(half, d_v, u, farthest, resolution, True))
        stop = min(stop, _arc_stop(half, d_v, u, farthest, resolution, True))
        if first >= stop:
            continue
        near, far = 0, 0
        half = _half_chord(d_v, nearest / resolution) if nearest > 0.0 else -1.0
        if half >= 0.0:
            near = _arc_first(half, d_v, u, nearest, resolution, False)
            far = _arc_stop(half, d_v, u, nearest, resolution, False)
        if near < far:
            marked = _mark(hits, r, first, min(stop, near), cols) + _mark(hits, r, max(first, far), stop, cols)
        else:
            marked = _mark(hits, r, first, stop, cols)
        if marked:
            here[0], here[1] = min(here[0], r), max(here[1], r + 1)
            here[2], here[3] = min(here[2], first), max(here[3], stop)
            count += 2 * marked
    return count


@njit(nogil=True, cache=True)
def _lowest_bit(word: int) -> int:
    """Return the place of the lowest bit set in a word of 32 that is not 0."""
    place = 0
    if not word & 0xFFFF:
        place, word = place + 16, word >> 16
    if not word & 0xFF:
        place, word = place + 8, word >> 8
    if not word & 0xF:
        place, word = place + 4, word >> 4
    if not word & 0x3:
        place, word = place + 2, word >> 2
    return place if word & 1 else place + 1


@njit(nogil=True, cache=True)
def _empty(toggles: UInt32Array, hits: UInt32Array, here: Int64Array, cols: int, runs: Int64Array, count: int) -> int:
    """Turn the two bitmaps into runs, hits taken out of the misses, and clear them; return the number of runs."""
    first_word, last_word = max(here[2], 0) >> 5, min(max(here[3], 0) >> 5, toggles.shape[1] - 1)
    for r in range(here[0], here[1]):
        miss_start, hit_start = -1, -1
        inside = 0  # all ones while the row's last word ended within the region
        for w in range(first_word, last_word + 1):
            if not toggles[r, w] and not hits[r, w] and hit_start < 0 and (miss_start < 0) == (inside == 0):
                continue
            value, hit = int(toggles[r, w]), int(hits[r, w])
            toggles[r, w], hits[r, w] = 0, 0
            value ^= value << 1
            value ^= value << 2
            value ^= value << 4
            value ^= value << 8
            value ^= value << 16
            value = (value ^ inside) & _WORD
            inside = _WORD if value >> 31 else 0
            value &= ~hit
            changes = (value ^ ((value << 1) | (1 if miss_start >= 0 else 0))) & _WORD
            while changes:
                column = (w << 5) + _lowest_bit(changes)
                changes &= changes - 1
                if miss_start < 0:
                    miss_start = column
                else:
                    runs[count, ROW], runs[count, COL], runs[count, STOP] = r, miss_start, column
                    runs[count, KIND] = MISS
                    count += 1
                    miss_start = -1
            changes = (hit ^ ((hit << 1) | (1 if hit_start >= 0 else 0))) & _WORD
            while changes:
                column = (w << 5) + _lowest_bit(changes)
                changes &= changes - 1
                if hit_start < 0:
                    hit_start = column
                else:
                    runs[count, ROW], runs[count, COL], runs[count, STOP] = r, hit_start, column
                    runs[count, KIND] = HIT
                    count += 1
                    hit_start = -1
        if miss_start >= 0:
            runs[count, ROW], runs[count, COL], runs[count, STOP], runs[count, KIND] = r, miss_start, cols, MISS
            count += 1
        if hit_start >= 0:
            runs[count, ROW], runs[count, COL], runs[count, STOP], runs[count, KIND] = r, hit_start, cols, HIT
            count += 1
    return count


@njit(nogil=True, cache=True)
def plan_runs(
    ranges: Float32Array,
    sensors: Float64Array,
    beams: Float64Array,
    fields: Float64Array,
    headings: Float64Array,
    frame: Frame,
    sight: Sight,
    cols: int,
    toggles: UInt32Array,
    hits: UInt32Array,
    runs: Int64Array,
    counts: Int64Array,
) -> int:
    """Write the runs of as many scans as ``runs`` has room for; return the number of those scans.

    Arguments as those of :func:`mapper.kernels.lines.plan_lines`; besides, ``fields`` (n_beams, 4) float64 holds each
    beam's right and left edge (cosine, sine, cosine, sine), ``headings`` (n_scans, 2) the cosine and sine of the
    sensor's heading along the lattice. ``toggles`` and ``hits`` (rows, ⌈cols / 32⌉) uint32 are scratch, zero before and
    after. ``runs`` (n, 4) int64 and ``counts`` (n_scans,) int64, the number of runs of each scan, are written.
    """
    range_min, range_max, window, no_return_free = sight
    resolution, half = frame[4], 0.5 * window
    rows, n_beams = toggles.shape[0], ranges.shape[1]
    here = np.empty(4, dtype=np.int64)
    edges, limits = np.empty((n_beams, 4)), np.zeros(n_beams)
    # Sectors are taken counter-clockwise, so that each one's left edge is its successor's right.
    clockwise = n_beams > 1 and fields[0, 0] == fields[1, 2] and fields[0, 1] == fields[1, 3]
    written = 0
    for t in range(ranges.shape[0]):
        here[0], here[1], here[2], here[3] = rows, 0, cols, 0
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        for j in range(n_beams):
            k = n_beams - 1 - j if clockwise else j
            z = float(ranges[t, k])
            limits[j] = 0.0
            if range_min <= z <= range_max:
                limits[j] = max(z - half, 0.0)
            elif z > range_max and no_return_free:
                limits[j] = range_max
            edges[j, 0] = turn_u * fields[k, 0] - turn_v * fields[k, 1]
            edges[j, 1] = turn_v * fields[k, 0] + turn_u * fields[k, 1]
            edges[j, 2] = turn_u * fields[k, 2] - turn_v * fields[k, 3]
            edges[j, 3] = turn_v * fields[k, 2] + turn_u * fields[k, 3]
            if edges[j, 0] == edges[j, 2] and edges[j, 1] == edges[j, 3]:  # it sees nothing
                limits[j] = 0.0
        bound = 0
        left_inner = 0.0
        for j in range(n_beams):
            right_u, right_v, left_u, left_v = edges[j, 0], edges[j, 1], edges[j, 2], edges[j, 3]
            right_inner, left_inner = left_inner, 0.0
            if j + 1 < n_beams and edges[j + 1, 0] == left_u and edges[j + 1, 1] == left_v:
                left_inner = max(min(limits[j], limits[j + 1]) / resolution - _MARGIN, 0.0)
            if right_u == left_u and right_v == left_v:
                continue
            if limits[j] > 0.0:
                bound += _outline(toggles, here, cols, u, v, right_u, right_v, left_u, left_v, limits[j], right_inner,
                                  left_inner, resolution)  # fmt: skip
            z = float(ranges[t, n_beams - 1 - j if clockwise else j])
            if window > 0.0 and range_min <= z <= range_max:
                bound += _ring(hits, here, cols, u, v, right_u, right_v, left_u, left_v, z - half,
                               min(z + half, range_max), resolution)  # fmt: skip
        for k in range(n_beams):
            z = float(ranges[t, k])
            if range_min <= z <= range_max:
                px, py = z * beams[k, 0], z * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
                r, c = int(_cell_of(ev)), int(_cell_of(eu))
                if 0 <= r < rows and 0 <= c < cols:
                    _mark(hits, r, c, c + 1, cols)
                    here[0], here[1] = min(here[0], r), max(here[1], r + 1)
                    here[2], here[3] = min(here[2], c), max(here[3], c + 1)
                    bound += 2
        room = runs.shape[0] - written
        if bound + 2 * (here[1] - here[0]) > room:
            for r in range(here[0], here[1]):
                toggles[r], hits[r] = 0, 0
            return t
        before = written
        written = _empty(toggles, hits, here, cols, runs, written)
        counts[t] = written - before
    return len(ranges)


@njit(nogil=True, cache=True)
def draw_runs(log_odds: Float32Array, observed: BoolArray, cols: int, runs: Int64Array, rule: Rule, row_low: int,
              row_high: int, box: Int64Array) -> int:  # fmt: skip
    """Add what ``runs`` (n, 4) say to the rows [row_low, row_high) of the grid; return the number of cell updates.

    ``log_odds``, ``observed``, ``cols`` and ``box`` as in :func:`mapper.kernels.lines.draw_lines`.
    """
    miss, hit, low, high = rule
    # Kept in registers: two threads that wrote their boxes side by side would fight for one cache line.
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    for j in range(runs.shape[0]):
        r = runs[j, ROW]
        if not row_low <= r < row_high:
            continue
        first, stop = runs[j, COL], runs[j, STOP]
        increment = hit if runs[j, KIND] == HIT else miss
        for cell in range(uint64(r * cols + first), uint64(r * cols + stop)):
            log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
            observed[cell] = True
        top, bottom = min(top, r), max(bottom, r + 1)
        left, right = min(left, first), max(right, stop)
        count += stop - first
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count
