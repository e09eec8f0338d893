"""A beam's field as a sector of cells: where the rows of the grid enter and leave it.

Ends of rows are found by division and square root; where that falls close to a cell's centre, the exact test of
:func:`mapper.textbook.inverse_range_sensor_model` decides. Bitmaps hold one bit for each cell, 32 columns to a word. An
edge is a unit vector (u along columns, v along rows); a sector lies to the left of its right edge, the edge included,
and to the right of its left edge. (u, v) is the sensor in lattice coordinates.
"""

from __future__ import annotations

from math import ceil, floor, sqrt

import numpy as np

from mapper.kernels.compiled import jit
from mapper.kernels.types import Int64Array, UInt32Array

TOGGLES, HITS, USED = range(3)  #: the bitmaps, each (rows, ⌈cols / 32⌉), of which USED fills a part
_FAR = 1 << 40  # beyond every column
_CLOSE = 1e-3  # of a cell: nearer than this to a centre, the exact test decides
_HAIR = 1e-6  # of a cell, far above what rounding does to a place in the grid
MARGIN = 1.001  # cells: nearer to a sector's arc than this, the edge's toggles are computed


@jit
def _close(ahead: float) -> bool:
    """Return whether a place is so close to a cell's centre that rounding may decide; the next one is ``ahead``."""
    return ahead < _CLOSE or ahead > 1.0 - _CLOSE


@jit
def _crossing(edge_u: float, edge_v: float, slope: float, d_v: float, u: float, radius: float) -> int:
    """Return the first column that lies beyond an edge's line on a row, going right; ``slope`` is edge_u / edge_v."""
    at = slope * d_v
    if abs(at) > radius + 4.0:  # far outside the arc, where only the side counts
        return floor(u + (radius + 4.0 if at > 0.0 else -radius - 4.0))
    at += u - 0.5
    column = floor(at) + 1
    if _close(column - at):
        column -= 1
        while (edge_u * d_v - edge_v * (column + 0.5 - u) < 0.0) != (edge_v > 0.0):
            column += 1
    return column


@jit
def _inside(column: int, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> bool:
    d_u = column + 0.5 - u
    s = sqrt(d_u * d_u + d_v * d_v) * resolution
    return s < limit or (inclusive and s == limit)


@jit
def _half_chord(d_v: float, radius: float) -> float:
    """Return half the length of the chord that a circle cuts from a row, in cells; −1 where it cuts none."""
    square = radius * radius - d_v * d_v
    return sqrt(max(square, 0.0)) if square > -1e-6 * radius * radius else -1.0


@jit
def _arc_first(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the first column of a row whose centre lies within ``limit`` metres; ``half`` is half the chord."""
    at = u - half - 0.5
    column = floor(at) + 1
    if _close(column - at):
        column -= 2
        while column <= u + half + 1.0 and not _inside(column, d_v, u, limit, resolution, inclusive):
            column += 1
    return column


@jit
def _arc_stop(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the column after the last one of a row whose centre lies within ``limit`` metres."""
    at = u + half - 0.5
    column = floor(at) + 1
    if _close(column - at):
        column += 2
        while column >= u - half - 1.0 and not _inside(column - 1, d_v, u, limit, resolution, inclusive):
            column -= 1
    return column


@jit
def _toggle(bits: UInt32Array, row: int, column: int, cols: int) -> None:
    """Flip the bit of a column; before the first column all flips meet on it, beyond the last none matters.

    USED has one bit for each word of a row, set where the word was written or a hit ends just before it.
    """
    column = max(column, 0)
    if column < cols:
        bits[TOGGLES, row, column >> 5] ^= np.uint32(1 << (column & 31))
        bits[USED, row, column >> 10] |= np.uint32(1 << ((column >> 5) & 31))


@jit
def _mark(bits: UInt32Array, row: int, first: int, stop: int, cols: int) -> int:
    """Set the bits of the columns [first, stop); return how many of them there are."""
    first, stop = max(first, 0), min(stop, cols)
    for column in range(first, stop):
        bits[HITS, row, column >> 5] |= np.uint32(1 << (column & 31))
        bits[USED, row, column >> 10] |= np.uint32(1 << ((column >> 5) & 31))
    if first < stop < cols:
        bits[USED, row, stop >> 10] |= np.uint32(1 << ((stop >> 5) & 31))
    return max(stop - first, 0)


@jit
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


@jit
def _nonzero(value: float) -> float:
    """Return a value to divide by: 1 where it is 0, in which case the quotient is not used."""
    return value if value != 0.0 else 1.0


@jit
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


@jit
def _outline(
    bits: UInt32Array, here: Int64Array, cols: int, u: float, v: float, right_u: float, right_v: float,
    left_u: float, left_v: float, limit: float, right_inner: float, left_inner: float, resolution: float,
) -> int:  # fmt: skip
    """Toggle where rows enter and leave the sector of cells with s < ``limit`` metres; return how many toggles.

    Up to ``right_inner`` and ``left_inner`` cells along an edge the neighbour toggles the same, so neither does.
    """
    radius = limit / resolution
    # Only where both edges go up, or both down, can a whole row lie within what is skipped.
    level = right_v * left_v <= 0.0
    inner = 0.0 if level else min(right_inner, left_inner)
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, inner, radius, bits.shape[1])
    # Going up, the right edge bounds a row on its right; going down, on its left.
    up = right_v + left_v > 0.0
    first_u, first_v, first_inner = (left_u, left_v, left_inner) if up else (right_u, right_v, right_inner)
    stop_u, stop_v, stop_inner = (right_u, right_v, right_inner) if up else (left_u, left_v, left_inner)
    first_slope, stop_slope = first_u / _nonzero(first_v), stop_u / _nonzero(stop_v)
    first_skip, stop_skip = abs(first_v) * first_inner, abs(stop_v) * stop_inner
    first_whole, stop_whole = abs(first_v) * (radius - MARGIN), abs(stop_v) * (radius - MARGIN)
    count = 0
    least, most = cols, 0
    for r in range(first_row, stop_row):
        d_v = r + 0.5 - v
        height = d_v if up else -d_v
        if level:
            first, stop = _bounds(right_u, right_v, left_u, left_v, d_v, u, radius)
            half = _half_chord(d_v, radius)
            first = max(first, _arc_first(half, d_v, u, limit, resolution, False))
            stop = min(stop, _arc_stop(half, d_v, u, limit, resolution, False))
            if half < 0.0 or first >= stop:
                continue
            skip_right = right_v * d_v > 0.0 and abs(d_v) < abs(right_v) * right_inner
            skip_left = left_v * d_v > 0.0 and abs(d_v) < abs(left_v) * left_inner
            skip_first, skip_stop = (skip_left, skip_right) if d_v > 0.0 else (skip_right, skip_left)
        else:
            skip_first, skip_stop = height < first_skip, height < stop_skip
            if height <= 0.0 or (skip_first and skip_stop):
                continue
            first, stop = -_FAR, _FAR
            if height >= first_whole or height >= stop_whole:
                half = _half_chord(d_v, radius)
                if half < 0.0:
                    continue
                if height >= first_whole:
                    first = _arc_first(half, d_v, u, limit, resolution, False)
                if height >= stop_whole:
                    stop = _arc_stop(half, d_v, u, limit, resolution, False)
            if not skip_first:
                first = max(first, _crossing(first_u, first_v, first_slope, d_v, u, radius))
            if not skip_stop:
                stop = min(stop, _crossing(stop_u, stop_v, stop_slope, d_v, u, radius))
            if first >= stop:
                continue
        if not skip_first:
            _toggle(bits, r, first, cols)
            least, most = min(least, first), max(most, first)
            count += 1
        if not skip_stop:
            _toggle(bits, r, stop, cols)
            least, most = min(least, stop), max(most, stop)
            count += 1
    if count:
        here[0], here[1] = min(here[0], first_row), max(here[1], stop_row)
        here[2], here[3] = min(here[2], least), max(here[3], most)
    return count


@jit
def _ring(
    bits: UInt32Array, here: Int64Array, cols: int, u: float, v: float, right_u: float, right_v: float, left_u: float,
    left_v: float, nearest: float, farthest: float, resolution: float,
) -> int:  # fmt: skip
    """Mark the sector's cells with ``nearest`` ≤ s ≤ ``farthest`` metres; return a bound on their number."""
    rows = bits.shape[1]
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
            marked = _mark(bits, r, first, min(stop, near), cols) + _mark(bits, r, max(first, far), stop, cols)
        else:
            marked = _mark(bits, r, first, stop, cols)
        if marked:
            here[0], here[1] = min(here[0], r), max(here[1], r + 1)
            here[2], here[3] = min(here[2], first), max(here[3], stop)
            count += 2 * marked
    return count
