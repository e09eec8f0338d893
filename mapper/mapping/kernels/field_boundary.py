"""The border of a scan's field as arcs and edges, and its crossings with the rows of the grid.

The field of a beam is a sector: from the sensor to an arc, between two edges. The sectors of a scan form one region,
whose border runs along the first arc, then along the edge to the next arc, and so on. Where the border crosses a row,
the row enters or leaves the region. Adjacent pieces share the same corner, so no crossing is lost or counted twice.

Rows and columns are found by rounding, which is correct unless a corner is close to a row's middle or a crossing close
to a cell's centre. If either is nearer than a HAIR, the scan must be drawn by the exact test of
:mod:`mapper.mapping.kernels.sectors`.

An edge is a unit vector (u along columns, v along rows); (u, v) is the sensor in lattice coordinates. A piece crosses
the rows between those of its ends, [low, high); a row counts if its middle is at or above an end. Pieces are first
listed and then traversed a fixed number of rows at a time; surplus rows are overwritten by the next piece. So no loop
has an unpredictable length, and the compiler can vectorise.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array, UInt32Array
from mapper.core.jit import jit
from mapper.mapping.kernels.bitmask_fill import _packed

HAIR = 1e-7  # cells; far above the rounding error of a position in the grid
_SHALLOW = 1e-8  # of the squared radius: if half a chord squared is less, its root is uncertain by a hair
STRIDE = 4  # rows traversed at once

#: Neighbourhood of a scan's sectors: for each (n,) int64 the previous one, counter-clockwise, and (n,) bool whether its
#: right edge is the left edge of that one.
Ring = tuple[Int64Array, BoolArray]
#: Sectors of a scan: edges (4, n) float64, right u, v and left u, v, along the lattice; sides (n,) float64
#: (:func:`_side`); radii (n,) of the arcs, cells, 0 for an ignored beam; corners (2, n) int64, the rows of their right
#: and left ends.
Sectors = tuple[Float64Array, Float64Array, Float64Array, Int64Array]
#: Pieces of a border: rows (2, pieces) int64 [first, stop), and shapes (2, pieces) float64: for an edge the column at
#: which it crosses its first row and the columns per row; for an arc its squared radius and its side.
Pieces = tuple[Int64Array, Float64Array]
#: Crossings of a border with rows: the rows (crossings,) int64 and the columns (crossings,) float64, minus half a cell.
Crossings = tuple[Int64Array, Float64Array]


@jit
def _room_for_pieces(n: int) -> Pieces:
    # One more, for the last listed piece, which does not count.
    return np.empty((2, n + 1), dtype=np.int64), np.empty((2, n + 1))


@jit
def _room_for_crossings(n: int) -> Crossings:
    return np.empty(n + STRIDE, dtype=np.int64), np.empty(n + STRIDE)


@jit
def _ring_of(fields: Float64Array) -> Ring:
    """Return the neighbourhood of the sectors (n, 4) of a scan."""
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
    """Rotate a vector from the sensor's frame to the lattice, in which the heading is (turn_u, turn_v)."""
    return turn_u * u - turn_v * v, turn_v * u + turn_u * v


@jit
def _row_at(v: float) -> tuple[float, bool]:
    """Return the first row whose middle is at or above ``v``, and whether ``v`` is too near to a middle."""
    row = np.ceil(v - 0.5)
    ahead = row - (v - 0.5)
    return row, (ahead < HAIR) | (ahead > 1.0 - HAIR)


@jit
def _side(right_u: float, left_u: float) -> float:
    """Return the side of the sensor, +1 or −1 along columns, on which an arc between two edges lies; 0 if it spans
    both.
    """
    side = 1.0 if right_u + left_u > 0.0 else -1.0
    return side if right_u * left_u >= 0.0 else 0.0


@jit
def _place_sectors(fields: Float64Array, turn_u: float, turn_v: float, v: float, sectors: Sectors) -> bool:
    """Rotate the edges (4, n) of a scan's sectors and find the rows of their corners; return whether all are
    certain.
    """
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
    """List the part of an edge's line between two rows, within the rows [low, high); return the new length."""
    rows, shapes = pieces
    at = np.uint64(n)
    first, stop = max(min(row, end_row), low), min(max(row, end_row), high)
    slope = edge_u / (edge_v if edge_v != 0.0 else 1.0)  # an edge parallel to the rows crosses none
    rows[0, at], rows[1, at] = first, stop
    shapes[0, at], shapes[1, at] = u + slope * (first + 0.5 - v) - 0.5, slope
    return n + (stop > first)


@jit
def _list_arc(pieces: Pieces, n: int, radius: float, side: float, row: int, end_row: int, low: int, high: int) -> int:
    """List the part of an arc between two rows, within the rows [low, high); return the new length."""
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
    """List the edges between a scan's arcs, within the rows [low, high); return the number of pieces."""
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
    """List a scan's arcs, within the rows [low, high); return the number of pieces and whether all are certain."""
    edges, sides, radii, corners = sectors
    n, unsure = 0, False
    for k in range(len(sides)):
        side, radius = sides[k], radii[k]
        row, end_row = corners[0, k], corners[1, k]
        if side == 0.0:  # counter-clockwise: over the top or through the bottom
            side = 1.0 if edges[0, k] > 0.0 else -1.0
            turning, near = _row_at(v + side * radius)
            unsure |= near
            n = _list_arc(pieces, n, radius, side, row, int(turning), low, high)
            row, side = int(turning), -side
        n = _list_arc(pieces, n, radius, side, row, end_row, low, high)
    return n, not unsure


@jit
def _crossed(pieces: Pieces, n: int, work: Float64Array) -> int:
    """Return the total number of rows that the first ``n`` pieces cross.

    Each crossing adds 1 to ``work`` (grid rows + 1,), which holds differences along the rows.
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
    """Append the crossings of ``n`` edges with rows after the first ``done`` ones; return their new number.

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
    """Append the crossings of ``n`` arcs with rows, as in :func:`_traverse_edges`; also return whether the roots are
    certain.
    """
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
    """Write for ``n`` crossings the columns at which their rows enter or leave; return whether all are certain.

    They are relative to row ``low`` and column ``left``. Columns before ``left`` are clamped to it, because the row is
    inside from there on, and columns beyond ``width`` are clamped to ``width``.
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
