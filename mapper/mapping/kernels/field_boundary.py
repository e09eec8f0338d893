"""The border of a scan's field as arcs and edges, and where it crosses the rows of the grid.

The field of a beam is a sector: from the sensor to an arc, between two edges. All sectors of a scan make one region,
whose border runs along the first arc, along the edge to the next one, and so on round. Where the border crosses a row,
the row enters or leaves the region; between two pieces it has the same corner, so no crossing is lost or
counted twice.

Rows and columns are found here by rounding, which is right as long as a corner keeps clear of every row's middle and a
crossing of every cell's centre. Where either comes nearer than a HAIR, the exact test of
:mod:`mapper.mapping.kernels.sectors` must do that scan.

An edge is a unit vector (u along columns, v along rows), (u, v) is the sensor in lattice coordinates. A piece crosses
the rows between those of its ends, [low, high): a row counts where its middle is at or above an end. Pieces are first
listed and then traversed, a few rows at a time whether the piece has them or not; surplus rows are overwritten by the
next piece. So no loop has a length that is hard to predict, and the compiler can vectorise.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array, UInt32Array
from mapper.core.jit import jit
from mapper.mapping.kernels.bitmask_fill import _packed

HAIR = 1e-7  # of a cell, far above what rounding does to a place in the grid
_SHALLOW = 1e-8  # of a radius' square: where half a chord's is less than that, its root is not sure to a hair
STRIDE = 4  # rows traversed at once

#: How a scan's sectors follow one another: for each (n,) int64 the one before it, counter-clockwise, and (n,) bool
#: whether its right edge is the left edge of that one.
Ring = tuple[Int64Array, BoolArray]
#: A scan's sectors: edges (4, n) float64, right u, v and left u, v, along the lattice; sides (n,) float64
#: (:func:`_side`); radii (n,) of the arcs, cells, 0 for an ignored beam; corners (2, n) int64, the rows of their
#: right and left ends.
Sectors = tuple[Float64Array, Float64Array, Float64Array, Int64Array]
#: Pieces of a border: rows (2, pieces) int64 [first, stop), and shapes (2, pieces) float64: of an edge the column at
#: which it crosses its first row and how far it goes for each row; of an arc its radius' square and its side.
Pieces = tuple[Int64Array, Float64Array]
#: Where a border crosses rows: the rows (crossings,) int64 and the columns (crossings,) float64, less half a cell.
Crossings = tuple[Int64Array, Float64Array]


@jit
def _room_for_pieces(n: int) -> Pieces:
    # One more, for what is listed last and does not count.
    return np.empty((2, n + 1), dtype=np.int64), np.empty((2, n + 1))


@jit
def _room_for_crossings(n: int) -> Crossings:
    return np.empty(n + STRIDE, dtype=np.int64), np.empty(n + STRIDE)


@jit
def _ring_of(fields: Float64Array) -> Ring:
    """Return how the sectors (n, 4) of a scan follow one another."""
    n = len(fields)
    clockwise = n > 1 and fields[0, 0] == fields[1, 2] and fields[0, 1] == fields[1, 3]
    before, shared = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.bool_)
    for k in range(n):
        last = (k + 1) % n if clockwise else (k + n - 1) % n
        before[k] = last
        shared[k] = fields[last, 2] == fields[k, 0] and fields[last, 3] == fields[k, 1]
    return before, shared


@jit
def _turned(u: float, v: float, turn_u: float, turn_v: float) -> tuple[float, float]:
    """Return a vector of the sensor's frame along the lattice, in which its heading is (turn_u, turn_v)."""
    return turn_u * u - turn_v * v, turn_v * u + turn_u * v


@jit
def _row_at(v: float) -> tuple[float, bool]:
    """Return the first row whose middle is at or above a place, and whether the place is too near to a middle."""
    row = np.ceil(v - 0.5)
    ahead = row - (v - 0.5)
    return row, (ahead < HAIR) | (ahead > 1.0 - HAIR)


@jit
def _side(right_u: float, left_u: float) -> float:
    """Return on which side of the sensor, +1 or −1 along columns, an arc between two edges lies; 0 where it turns."""
    side = 1.0 if right_u + left_u > 0.0 else -1.0
    return side if right_u * left_u >= 0.0 else 0.0


@jit
def _place_sectors(fields: Float64Array, turn_u: float, turn_v: float, v: float, sectors: Sectors) -> bool:
    """Turn the edges (4, n) of a scan's sectors and find the rows of their corners; return whether all are sure."""
    edges, sides, radii, corners = sectors
    unsure = False
    for i in range(len(radii)):
        k = np.uint64(i)
        right_u, right_v = _turned(fields[0, k], fields[1, k], turn_u, turn_v)
        left_u, left_v = _turned(fields[2, k], fields[3, k], turn_u, turn_v)
        edges[0, k], edges[1, k], edges[2, k], edges[3, k] = right_u, right_v, left_u, left_v
        sides[k] = _side(right_u, left_u)
        sees = (right_u != left_u) | (right_v != left_v)
        radius = radii[k] if sees else 0.0
        radii[k] = radius
        right_row, right_unsure = _row_at(v + radius * right_v)
        left_row, left_unsure = _row_at(v + radius * left_v)
        corners[0, k], corners[1, k] = int(right_row), int(left_row)
        unsure |= right_unsure | left_unsure
    return not unsure


@jit
def _list_edge(
    pieces: Pieces, n: int, edge_u: float, edge_v: float, row: int, end_row: int, u: float, v: float, low: int,
    high: int,
) -> int:  # fmt: skip
    """List the part of an edge's line between two rows that lies in the rows [low, high); return the new length."""
    rows, shapes = pieces
    at = np.uint64(n)
    first, stop = max(min(row, end_row), low), min(max(row, end_row), high)
    slope = edge_u / (edge_v if edge_v != 0.0 else 1.0)  # an edge along a row crosses none
    rows[0, at], rows[1, at] = first, stop
    shapes[0, at], shapes[1, at] = u + slope * (first + 0.5 - v) - 0.5, slope
    return n + (stop > first)


@jit
def _list_arc(pieces: Pieces, n: int, radius: float, side: float, row: int, end_row: int, low: int, high: int) -> int:
    """List the part of an arc between two rows that lies in the rows [low, high); return the new length."""
    rows, shapes = pieces
    at = np.uint64(n)
    first, stop = max(min(row, end_row), low), min(max(row, end_row), high)
    rows[0, at], rows[1, at] = first, stop
    shapes[0, at], shapes[1, at] = radius * radius, side
    return n + (stop > first)


@jit
def _list_edges(
    sectors: Sectors, ring: Ring, home: int, u: float, v: float, low: int, high: int, pieces: Pieces
) -> int:  # fmt: skip
    """List the edges between a scan's arcs, as far as they lie in the rows [low, high); return how many pieces."""
    edges, _, _, corners = sectors
    before, shared = ring
    n = 0
    for k in range(len(before)):
        last = before[k]
        row, end_row = corners[1, last], corners[0, k]
        if not shared[k]:  # to the sensor and back to the arc
            n = _list_edge(pieces, n, edges[2, last], edges[3, last], row, home, u, v, low, high)
            row = home
        n = _list_edge(pieces, n, edges[0, k], edges[1, k], row, end_row, u, v, low, high)
    return n


@jit
def _list_arcs(sectors: Sectors, v: float, low: int, high: int, pieces: Pieces) -> tuple[int, bool]:
    """List a scan's arcs, as far as they lie in the rows [low, high); return how many pieces, and whether sure."""
    edges, sides, radii, corners = sectors
    n, unsure = 0, False
    for k in range(len(sides)):
        side, radius = sides[k], radii[k]
        row, end_row = corners[0, k], corners[1, k]
        if side == 0.0:  # counter-clockwise: over the top, or through the bottom
            side = 1.0 if edges[0, k] > 0.0 else -1.0
            turning, near = _row_at(v + side * radius)
            unsure |= near
            n = _list_arc(pieces, n, radius, side, row, int(turning), low, high)
            row, side = int(turning), -side
        n = _list_arc(pieces, n, radius, side, row, end_row, low, high)
    return n, not unsure


@jit
def _crossed(pieces: Pieces, n: int, work: Float64Array) -> int:
    """Return how many rows the first ``n`` pieces cross together.

    To ``work`` (grid rows + 1,), a difference along the rows, 1 is added for each crossing.
    """
    rows, _ = pieces
    total = 0
    for p in range(n):
        first, stop = rows[0, p], rows[1, p]
        total += stop - first
        work[first] += 1.0
        work[stop] -= 1.0
    return total


@jit
def _traverse_edges(pieces: Pieces, n: int, crossings: Crossings, done: int) -> int:
    """Note where ``n`` edges cross rows, after the ``done`` first crossings; return how many there are then.

    There must be room for STRIDE more.
    """
    rows, shapes = pieces
    at_rows, at_columns = crossings
    for p in range(n):
        first, stop, column, slope = rows[0, p], rows[1, p], shapes[0, p], shapes[1, p]
        end = done + stop - first
        while done < end:
            for lane in range(STRIDE):
                at_rows[np.uint64(done + lane)] = first + lane
                at_columns[np.uint64(done + lane)] = column + slope * lane
            done += STRIDE
            first += STRIDE
            column += STRIDE * slope
        done = end
    return done


@jit
def _traverse_arcs(
    pieces: Pieces, n: int, u: float, v: float, crossings: Crossings, done: int
) -> tuple[int, bool]:  # fmt: skip
    """Note where ``n`` arcs cross rows, as :func:`_traverse_edges`; return also whether the roots are sure."""
    rows, shapes = pieces
    at_rows, at_columns = crossings
    start, unsure = done, False
    for p in range(n):
        first, stop, square, side = rows[0, p], rows[1, p], shapes[0, p], shapes[1, p]
        d_v = first + 0.5 - v
        farthest = max(abs(d_v), abs(stop - 0.5 - v))
        unsure |= square - farthest * farthest <= _SHALLOW * square
        end = done + stop - first
        while done < end:
            for lane in range(STRIDE):
                at_rows[np.uint64(done + lane)] = first + lane
                at_columns[np.uint64(done + lane)] = side * (square - (d_v + lane) * (d_v + lane))
            done += STRIDE
            first += STRIDE
            d_v += STRIDE
        done = end
    for i in range(start, done):  # all roots at once; a square has the sign of its side
        j = np.uint64(i)
        half = sqrt(abs(at_columns[j]))
        at_columns[j] = u + (half if at_columns[j] > 0.0 else -half) - 0.5
    return done, not unsure


@jit
def _note_crossings(
    crossings: Crossings, n: int, low: int, left: int, width: int, toggles: UInt32Array, done: int
) -> bool:  # fmt: skip
    """Note for ``n`` crossings which columns their rows enter or leave at, and return whether all are sure.

    They are counted from row ``low`` and column ``left``. A column before ``left`` counts as that one, as the row is
    inside from there, and one beyond ``width`` as that.
    """
    at_rows, at_columns = crossings
    unsure = False
    for i in range(n):
        j = np.uint64(i)
        column = np.ceil(at_columns[j])
        ahead = column - at_columns[j]
        unsure |= (ahead < HAIR) | (ahead > 1.0 - HAIR)
        toggles[np.uint64(done + i)] = _packed(at_rows[j] - low, min(max(int(column) - left, 0), width))
    return not unsure
