"""The border of a scan's field as arcs and edges, and where it crosses the rows of the grid.

The field of a beam is a sector: from the sensor to an arc, between two edges. All sectors of a scan make one region,
whose border runs along the first arc, along the edge to the next one, and so on round. Where the border crosses a row,
the row enters or leaves the region; between two pieces it has the same corner, so none of its crossings is lost or
counted twice.

Rows and columns are found here by rounding, which is right as long as a corner keeps clear of every row's middle and a
crossing of every cell's centre. How near they came is returned, and where that is less than a HAIR the exact test of
:mod:`mapper.kernels.sectors` must do that scan.

An edge is a unit vector (u along columns, v along rows). A piece crosses the rows between those of its ends, [low,
high): a row counts where its middle lies at or above an end.
"""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np

from mapper.kernels.compiled import jit
from mapper.kernels.sheet import Place, _toggle
from mapper.kernels.types import BoolArray, Float64Array, Int8Array, Int32Array, Int64Array

HAIR = 1e-7  # of a cell, far above what rounding does to a place in the grid
_SHALLOW = 1e-8  # of a radius' square: where half a chord's is less than that, its root is not sure to a hair

#: The sensor in lattice coordinates and the rows [low, high) that are wanted.
Post = tuple[float, float, int, int]
#: How a scan's sectors follow one another: whether clockwise, and for each (n,) whether its right edge is the left one
#: of the sector before.
Ring = tuple[bool, BoolArray]


@jit
def _row_at(v: float) -> tuple[int, float]:
    """Return the first row whose middle lies at or above a place, and how near, in cells, the place is to a middle."""
    row = ceil(v - 0.5)
    ahead = row - (v - 0.5)
    return row, min(ahead, 1.0 - ahead)


@jit
def _rows_between(row: int, end_row: int, post: Post) -> tuple[int, int]:
    """Return the rows [first, stop) that a piece crosses from one end to the other, of those that are wanted."""
    return max(min(row, end_row), post[2]), min(max(row, end_row), post[3])


@jit
def _crosses(row: int, end_row: int, post: Post) -> bool:
    first, stop = _rows_between(row, end_row, post)
    return first < stop


@jit
def _along_arc(
    planes: Int64Array, used: Int64Array, place: Place, plane: int, post: Post, radius: float, side: float, row: int,
    end_row: int, clear: float,
) -> float:  # fmt: skip
    """Toggle where an arc crosses rows, on the side of the sensor that ``side`` (+1 or −1 along columns) says.

    Return how clear of all centres it stayed, in cells, at most ``clear``.
    """
    u, v, _, _ = post
    square = radius * radius
    first, stop = _rows_between(row, end_row, post)
    for r in range(first, stop):
        d_v = r + 0.5 - v
        rest = square - d_v * d_v
        at = u + side * sqrt(max(rest, 0.0)) - 0.5
        column = np.ceil(at)
        ahead = column - at
        near = min(ahead, 1.0 - ahead)
        clear = min(clear, near)
        clear = clear if rest > _SHALLOW * square else 0.0
        _toggle(planes, used, place, plane, r, int(column))
    return clear


@jit
def _along_edge(planes: Int64Array, used: Int64Array, place: Place, plane: int, post: Post, slope: float, row: int,
                end_row: int, clear: float) -> float:  # fmt: skip
    """Toggle where an edge crosses rows; otherwise as :func:`_along_arc`."""
    u, v, _, _ = post
    first, stop = _rows_between(row, end_row, post)
    at = u + slope * (first + 0.5 - v) - 0.5
    for r in range(first, stop):
        column = np.ceil(at)
        ahead = column - at
        near = min(ahead, 1.0 - ahead)
        clear = min(clear, near)
        _toggle(planes, used, place, plane, r, int(column))
        at += slope
    return clear


@jit
def _outline(
    planes: Int64Array, used: Int64Array, place: Place, plane: int, post: Post, fields: Float64Array, turn_u: float,
    turn_v: float, ring: Ring, radii: Float64Array, corners: Int32Array, sides: Int8Array,
) -> float:  # fmt: skip
    """Toggle where the border of a scan's field crosses rows; return how clear of all centres it stayed, in cells.

    ``fields`` (n, 4) are the sectors' edges in the sensor's frame, (turn_u, turn_v) is the sensor's heading. ``radii``
    (n,) are the arcs' in cells, 0 where a beam says nothing; ``corners`` (n, 2) int32 the rows (:func:`_row_at`) of
    their right and left ends; ``sides`` (n,) int8 the sides (:func:`_side`) on which they lie.
    """
    clockwise, shared = ring
    n = len(radii)
    home, clear = _row_at(post[1])
    last = 0 if clockwise else n - 1
    for j in range(n):
        # The edge between the sector before and this one: from the corner of one arc to that of the next.
        k = n - 1 - j if clockwise else j
        row, end_row = int(corners[last, 1]), int(corners[k, 0])
        if not shared[k]:
            if row != home:
                left_u, left_v = _turned(fields[last, 2], fields[last, 3], turn_u, turn_v)
                clear = _along_edge(planes, used, place, plane, post, left_u / left_v, row, home, clear)
            row = home
        if _crosses(row, end_row, post):
            right_u, right_v = _turned(fields[k, 0], fields[k, 1], turn_u, turn_v)
            clear = _along_edge(planes, used, place, plane, post, right_u / right_v, row, end_row, clear)
        row, end_row = int(corners[k, 0]), int(corners[k, 1])
        if sides[k] == 0:
            right_u, _ = _turned(fields[k, 0], fields[k, 1], turn_u, turn_v)
            side = 1.0 if right_u > 0.0 else -1.0  # counter-clockwise: over the top, or through the bottom
            turning, near = _row_at(post[1] + side * radii[k])
            clear = min(clear, near)
            clear = _along_arc(planes, used, place, plane, post, radii[k], side, row, turning, clear)
            clear = _along_arc(planes, used, place, plane, post, radii[k], -side, turning, end_row, clear)
        elif _crosses(row, end_row, post):
            clear = _along_arc(planes, used, place, plane, post, radii[k], float(sides[k]), row, end_row, clear)
        last = k
    return clear


@jit
def _side(right_u: float, left_u: float) -> int:
    """Return on which side of the sensor, +1 or −1 along columns, an arc between two edges lies; 0 where it turns."""
    if right_u * left_u < 0.0:
        return 0
    return 1 if right_u + left_u > 0.0 else -1


@jit
def _ring_of(fields: Float64Array) -> Ring:
    """Return how the sectors (n, 4) of a scan follow one another."""
    n = len(fields)
    clockwise = n > 1 and fields[0, 0] == fields[1, 2] and fields[0, 1] == fields[1, 3]
    shared = np.zeros(n, dtype=np.bool_)
    for k in range(n):
        last = (k + 1) % n if clockwise else (k + n - 1) % n
        shared[k] = fields[last, 2] == fields[k, 0] and fields[last, 3] == fields[k, 1]
    return clockwise, shared


@jit
def _turned(u: float, v: float, turn_u: float, turn_v: float) -> tuple[float, float]:
    """Return a vector of the sensor's frame along the lattice."""
    return turn_u * u - turn_v * v, turn_v * u + turn_u * v
