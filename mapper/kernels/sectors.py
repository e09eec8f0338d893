"""A beam's field as a sector of cells: where the rows of the grid enter and leave it.

Ends of rows are found by division and square root; where that falls close to a cell's centre, the exact test of
:func:`mapper.textbook.inverse_range_sensor_model` decides. An edge is a unit vector (u along columns, v along rows); a
sector lies to the left of its right edge, the edge included, and to the right of its left edge. (u, v) is the sensor in
lattice coordinates. What is found is written to a sheet: see :mod:`mapper.kernels.field`.
"""

from __future__ import annotations

from math import ceil, floor, inf, sqrt

from mapper.kernels.compiled import jit
from mapper.kernels.types import Int64Array

#: A sheet (3, rows, cols) int64 covers a part of the grid. TOGGLES and HITS have one bit for each of some scans; USED
#: has, at the start of each row, one bit, 32 to a word, for each block of BLOCK cells in which those are not all 0.
TOGGLES, HITS, USED = range(3)
#: The row and column of the grid at which a sheet begins.
Place = tuple[int, int]

BLOCK_BITS = 4
BLOCK = 1 << BLOCK_BITS  #: cells
_FAR = 1 << 40  # beyond every column
_CLOSE = 1e-3  # of a cell: nearer than this to a centre, the exact test decides
_HAIR = 1e-6  # of a cell, far above what rounding does to a place in the grid


@jit
def _close(ahead: float) -> bool:
    """Return whether a place is so close to a cell's centre that rounding may decide; the next one is ``ahead``."""
    return ahead < _CLOSE or ahead > 1.0 - _CLOSE


@jit
def _margin(edge_u: float, edge_v: float, length: float) -> float:
    """Return how near to the end of an edge of ``length`` cells the arc may bound a row beside it.

    Where a row crosses the edge at d, the next centres are at most a cell to the side. They are nearer to the sensor
    than √((d + |u|)² + v²) ≤ d + |u| + v² / 2(d + |u|), and than d + 1.
    """
    return abs(edge_u) + 0.05 * edge_v * edge_v + 1e-3 if length > 12.0 else 1.001


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
def _toggle(sheet: Int64Array, place: Place, bit: int, row: int, column: int) -> None:
    """Flip a scan's bit of a column; before the sheet's first column all flips meet on it, beyond the last none counts.

    The row must be one of the sheet's.
    """
    r, c = row - place[0], max(column - place[1], 0)
    if c < sheet.shape[2]:
        sheet[TOGGLES, r, c] ^= bit
        sheet[USED, r, c >> (BLOCK_BITS + 5)] |= 1 << ((c >> BLOCK_BITS) & 31)


@jit
def _mark(sheet: Int64Array, place: Place, bit: int, row: int, column: int) -> None:
    """Note that a scan hits a cell."""
    r, c = row - place[0], column - place[1]
    if 0 <= r < sheet.shape[1] and 0 <= c < sheet.shape[2]:
        sheet[HITS, r, c] |= bit
        sheet[USED, r, c >> (BLOCK_BITS + 5)] |= 1 << ((c >> BLOCK_BITS) & 31)


@jit
def _sector_rows(
    v: float, right_v: float, left_v: float, right_u: float, left_u: float, near: float, far: float
) -> tuple[int, int]:
    """Return the rows [first, stop) in which a sector has cells at ``near`` … ``far`` cells, a hair too many."""
    low = min(right_v, left_v)
    high = max(right_v, left_v)
    low, high = min(low * near, low * far), max(high * near, high * far)
    if right_u * left_u <= 0.0:  # it holds the v axis, where the arc bulges out
        low, high = (low, far) if right_v + left_v > 0.0 else (-far, high)
    return ceil(v + low - 0.5 - _HAIR), floor(v + high - 0.5 + _HAIR) + 1


@jit
def _rows_beyond(v: float, edge_v: float, length: float) -> int:
    """Return the first row whose centre line an edge crosses at ``length`` cells or more, counted as the edge runs."""
    if edge_v > 0.0:
        return max(ceil(v + edge_v * length - 0.5), floor(v - 0.5) + 1)
    return min(floor(v + edge_v * length - 0.5), ceil(v - 0.5) - 1)


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
def _along_edge(
    sheet: Int64Array, place: Place, bit: int, u: float, v: float, edge_u: float, edge_v: float, first: int, stop: int
) -> None:
    """Toggle the rows [first, stop) where they cross an edge."""
    slope = edge_u / edge_v
    for r in range(max(first, place[0]), min(stop, place[0] + sheet.shape[1])):
        _toggle(sheet, place, bit, r, _crossing(edge_u, edge_v, slope, r + 0.5 - v, u, inf))


@jit
def _outline(
    sheet: Int64Array, place: Place, bit: int, u: float, v: float, right_u: float, right_v: float, left_u: float,
    left_v: float, limit: float, right_inner: float, left_inner: float, resolution: float,
) -> None:  # fmt: skip
    """Toggle where rows enter and leave the sector of cells with s < ``limit`` metres.

    Up to ``right_inner`` and ``left_inner`` cells along an edge the neighbour toggles the same, so neither does. From
    there to where the arc comes near only the edges bound the rows; the last few rows are bounded by edges and arc.
    """
    if right_v * left_v <= 0.0:
        _outline_level(
            sheet, place, bit, u, v, right_u, right_v, left_u, left_v, limit, right_inner, left_inner, resolution
        )
        return
    radius = limit / resolution
    low, high = place[0], place[0] + sheet.shape[1]
    # Going up, the right edge bounds a row on its right; going down, on its left.
    up = right_v > 0.0
    first_u, first_v, first_inner = (left_u, left_v, left_inner) if up else (right_u, right_v, right_inner)
    stop_u, stop_v, stop_inner = (right_u, right_v, right_inner) if up else (left_u, left_v, left_inner)
    first_begin, stop_begin = _rows_beyond(v, first_v, first_inner), _rows_beyond(v, stop_v, stop_inner)
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, min(first_inner, stop_inner), radius)
    first_whole = abs(first_v) * (radius - _margin(first_u, first_v, radius))
    stop_whole = abs(stop_v) * (radius - _margin(stop_u, stop_v, radius))
    arc = _rows_beyond(v, 1.0 if up else -1.0, max(min(first_whole, stop_whole), 0.0))
    if up:
        if first_begin < arc:
            _along_edge(sheet, place, bit, u, v, first_u, first_v, first_begin, arc)
        if stop_begin < arc:
            _along_edge(sheet, place, bit, u, v, stop_u, stop_v, stop_begin, arc)
        first_row = max(arc, min(first_begin, stop_begin))
    else:
        if first_begin > arc:
            _along_edge(sheet, place, bit, u, v, first_u, first_v, arc + 1, first_begin + 1)
        if stop_begin > arc:
            _along_edge(sheet, place, bit, u, v, stop_u, stop_v, arc + 1, stop_begin + 1)
        stop_row = min(arc, max(first_begin, stop_begin)) + 1
    first_slope, stop_slope = first_u / first_v, stop_u / stop_v
    for r in range(max(first_row, low), min(stop_row, high)):
        d_v = r + 0.5 - v
        height = abs(d_v)
        skip_first, skip_stop = (r < first_begin, r < stop_begin) if up else (r > first_begin, r > stop_begin)
        half = _half_chord(d_v, radius)
        if half < 0.0:
            continue
        first, stop = -_FAR, _FAR
        if height >= first_whole:
            first = _arc_first(half, d_v, u, limit, resolution, False)
        if height >= stop_whole:
            stop = _arc_stop(half, d_v, u, limit, resolution, False)
        if not skip_first:
            first = max(first, _crossing(first_u, first_v, first_slope, d_v, u, radius))
        if not skip_stop:
            stop = min(stop, _crossing(stop_u, stop_v, stop_slope, d_v, u, radius))
        if first < stop:
            if not skip_first:
                _toggle(sheet, place, bit, r, first)
            if not skip_stop:
                _toggle(sheet, place, bit, r, stop)


@jit
def _outline_level(
    sheet: Int64Array, place: Place, bit: int, u: float, v: float, right_u: float, right_v: float, left_u: float,
    left_v: float, limit: float, right_inner: float, left_inner: float, resolution: float,
) -> None:  # fmt: skip
    """As :func:`_outline`, for a sector whose edges do not both go up or both down."""
    radius = limit / resolution
    right_begin, left_begin = _rows_beyond(v, right_v, right_inner), _rows_beyond(v, left_v, left_inner)
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, 0.0, radius)
    for r in range(max(first_row, place[0]), min(stop_row, place[0] + sheet.shape[1])):
        d_v = r + 0.5 - v
        first, stop = _bounds(right_u, right_v, left_u, left_v, d_v, u, radius)
        half = _half_chord(d_v, radius)
        first = max(first, _arc_first(half, d_v, u, limit, resolution, False))
        stop = min(stop, _arc_stop(half, d_v, u, limit, resolution, False))
        if half < 0.0 or first >= stop:
            continue
        skip_right = right_v * d_v > 0.0 and (r < right_begin if right_v > 0.0 else r > right_begin)
        skip_left = left_v * d_v > 0.0 and (r < left_begin if left_v > 0.0 else r > left_begin)
        skip_first, skip_stop = (skip_left, skip_right) if d_v > 0.0 else (skip_right, skip_left)
        if not skip_first:
            _toggle(sheet, place, bit, r, first)
        if not skip_stop:
            _toggle(sheet, place, bit, r, stop)


@jit
def _ring(
    sheet: Int64Array, place: Place, bit: int, u: float, v: float, right_u: float, right_v: float, left_u: float,
    left_v: float, nearest: float, farthest: float, resolution: float,
) -> None:  # fmt: skip
    """Mark the sector's cells with ``nearest`` ≤ s ≤ ``farthest`` metres."""
    radius = farthest / resolution
    inner = max(nearest / resolution, 0.0) if right_v * left_v > 0.0 else 0.0
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, inner, radius)
    for r in range(max(first_row, place[0]), min(stop_row, place[0] + sheet.shape[1])):
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
        for column in range(max(first, place[1]), min(stop, place[1] + sheet.shape[2])):
            if not near <= column < far:
                _mark(sheet, place, bit, r, column)
