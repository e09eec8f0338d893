"""A beam's field as an exact sector of cells: where the rows of the grid enter and leave it.

Ends of rows are found by division and square root. Close to a cell's centre the exact test of
:func:`mapper.mapping.textbook.inverse_range_sensor_model` decides. This module is for the few scans in which rounding
may decide; all others are handled by :mod:`mapper.mapping.kernels.field_boundary`. An edge is a unit vector (u along
columns, v along rows). A sector is to the left of its right edge, the edge included, and to the right of its left edge.
(u, v) is the sensor in lattice coordinates. The result is marked in a bitmask, see
:mod:`mapper.mapping.kernels.bitmask_fill`.
"""

from __future__ import annotations

from math import ceil, floor, sqrt

from mapper.core.array_types import Int64Array
from mapper.core.jit import jit
from mapper.mapping.kernels.bitmask_fill import FREE, Place, _mark, _toggle
from mapper.mapping.kernels.field_boundary import HAIR

_FAR = 1 << 40  # beyond every column
_CLOSE = 1e-3  # cells: nearer to a centre than this, the exact test decides


@jit
def _close(ahead: float) -> bool:
    """Return whether a position is so close to a cell's centre that rounding may decide; ``ahead`` is the distance to
    it.
    """
    return ahead < _CLOSE or ahead > 1.0 - _CLOSE


@jit
def _crossing(edge_u: float, edge_v: float, slope: float, d_v: float, u: float, radius: float) -> int:
    """Return the first column beyond an edge's line on a row, going right; ``slope`` is edge_u / edge_v."""
    at = slope * d_v
    if abs(at) > radius + 4.0:  # far outside the arc, where only the side matters
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
    """Return half the length of the chord that a circle cuts from a row, in cells; −1 if there is none."""
    square = radius * radius - d_v * d_v
    return sqrt(max(square, 0.0)) if square > -1e-6 * radius * radius else -1.0


@jit
def _arc_first(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the first column of a row whose centre is within ``limit`` metres; ``half`` is half the chord."""
    at = u - half - 0.5
    column = floor(at) + 1
    if _close(column - at):
        column -= 2
        while column <= u + half + 1.0 and not _inside(column, d_v, u, limit, resolution, inclusive):
            column += 1
    return column


@jit
def _arc_stop(half: float, d_v: float, u: float, limit: float, resolution: float, inclusive: bool) -> int:
    """Return the column after the last column of a row whose centre is within ``limit`` metres."""
    at = u + half - 0.5
    column = floor(at) + 1
    if _close(column - at):
        column += 2
        while column >= u - half - 1.0 and not _inside(column - 1, d_v, u, limit, resolution, inclusive):
            column -= 1
    return column


@jit
def _sector_rows(v: float, right_v: float, left_v: float, right_u: float, left_u: float, far: float) -> tuple[int, int]:
    """Return the rows [first, stop) in which a sector has cells up to ``far`` cells away, with a small margin."""
    low, high = min(right_v, left_v, 0.0) * far, max(right_v, left_v, 0.0) * far
    if right_u * left_u <= 0.0:  # the sector contains the v axis, along which the arc extends farthest
        low, high = (low, far) if right_v + left_v > 0.0 else (-far, high)
    return ceil(v + low - 0.5 - HAIR), floor(v + high - 0.5 + HAIR) + 1


@jit
def _nonzero(value: float) -> float:
    """Return a safe divisor: 1 if the value is 0, in which case the quotient is not used."""
    return value if value != 0.0 else 1.0


@jit
def _bounds(
    right_u: float, right_v: float, left_u: float, left_v: float, d_v: float, u: float, radius: float
) -> tuple[int, int]:
    """Return the columns [first, stop) of a row between a sector's edges, ignoring its arc."""
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
def _sector(
    planes: Int64Array, used: Int64Array, place: Place, u: float, v: float, right_u: float, right_v: float,
    left_u: float, left_v: float, limit: float, resolution: float,
) -> None:  # fmt: skip
    """Toggle the cells at which rows enter and leave the sector of cells with s < ``limit`` metres.

    If two neighbouring sectors both contain the shared edge, their toggles on it cancel.
    """
    radius = limit / resolution
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, radius)
    for r in range(max(first_row, place[0]), min(stop_row, place[0] + len(used))):
        d_v = r + 0.5 - v
        first, stop = _bounds(right_u, right_v, left_u, left_v, d_v, u, radius)
        half = _half_chord(d_v, radius)
        first = max(first, _arc_first(half, d_v, u, limit, resolution, False))
        stop = min(stop, _arc_stop(half, d_v, u, limit, resolution, False))
        if half >= 0.0 and first < stop:
            _toggle(planes, used, place, FREE, r, first)
            _toggle(planes, used, place, FREE, r, stop)


@jit
def _ring(
    planes: Int64Array, used: Int64Array, place: Place, u: float, v: float, right_u: float, right_v: float,
    left_u: float, left_v: float, nearest: float, farthest: float, resolution: float,
) -> None:  # fmt: skip
    """Mark the sector's cells with ``nearest`` ≤ s ≤ ``farthest`` metres."""
    radius = farthest / resolution
    first_row, stop_row = _sector_rows(v, right_v, left_v, right_u, left_u, radius)
    for r in range(max(first_row, place[0]), min(stop_row, place[0] + len(used))):
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
        for column in range(first, stop):
            if not near <= column < far:
                _mark(planes, used, place, r, column)
