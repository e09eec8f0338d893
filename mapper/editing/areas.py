"""Cells of a map covered by a stroke or a polygon, in bands of rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry

BAND_CELLS = 1 << 18  #: maximum number of cells computed between two calls of ``check``, except for longer rows
_COUNT = np.int16  #: a line has at most 20,000 segments, see :data:`mapper.editing.operations.MAX_POINTS`

#: A box of cells, and for each band of its rows the first row and a mask of the covered cells (rows, cols).
Covered: TypeAlias = "tuple[CellBox, Iterator[tuple[int, BoolArray]]]"


def row_bands(rows: int, cols: int, multiple: int = 1) -> Iterator[tuple[int, int]]:
    """Yield the start and end rows of bands, each a ``multiple`` of rows with about :data:`BAND_CELLS`."""
    step = max(1, BAND_CELLS // (cols * multiple)) * multiple
    for row0 in range(0, rows, step):
        yield row0, min(row0 + step, rows)


def _box_around(geometry: GridGeometry, lattice: Float64Array, reach: float) -> CellBox | None:
    """Return the cells whose centres can be within ``reach`` cells of the points' bounding box; None outside the map.

    ``lattice`` (n, 2) are lattice coordinates.
    """
    low, high = np.floor(lattice.min(axis=0) - reach - 1.0), np.ceil(lattice.max(axis=0) + reach + 1.0)
    col0, row0 = (int(v) for v in np.maximum(low, 0))
    col1, row1 = (int(v) for v in np.minimum(high, (geometry.cols, geometry.rows)))
    return CellBox(row0, row1, col0, col1) if row0 < row1 and col0 < col1 else None


def _near_segment(v: Float64Array, a: Float64Array, b: Float64Array, reach: float) -> tuple[Float64Array, Float64Array]:
    """Return the first and the last u (n,) of the points (u, v) within ``reach`` of the segment from a to b.

    The first is greater than the last if a line v has no such point.
    """
    first, last = np.full(v.shape, math.inf), np.full(v.shape, -math.inf)
    for u_end, v_end in (a, b):  # the discs at both ends
        half = np.sqrt(np.maximum(reach * reach - (v - v_end) ** 2, 0.0))
        on = np.abs(v - v_end) <= reach
        first[on], last[on] = np.minimum(first, u_end - half)[on], np.maximum(last, u_end + half)[on]
    length = float(np.hypot(*(b - a)))
    if length > 0.0:  # the rectangle between them, by its four sides
        side = reach / length * np.array([a[1] - b[1], b[0] - a[0]])
        corners = [a + side, b + side, b - side, a - side]
        for (p_u, p_v), (q_u, q_v) in zip(corners, [*corners[1:], corners[0]], strict=True):
            if p_v != q_v:
                on = (min(p_v, q_v) <= v) & (v <= max(p_v, q_v))
                u = p_u + (v - p_v) / (q_v - p_v) * (q_u - p_u)
                first[on], last[on] = np.minimum(first, u)[on], np.maximum(last, u)[on]
    return first, last


def stroke_cells(
    geometry: GridGeometry, points: Float64Array, width: float, check: Callable[[], None]
) -> Covered | None:
    """Return the cells within half a ``width`` (m) of the line through ``points`` (n, 2), or containing its points.

    None if the map has none near them. ``check`` is called before each segment and each band. The area near a segment
    is convex, so it covers one run of cells in each row, whose ends are counted.
    """
    lattice = geometry.to_lattice(points)
    reach = width / 2.0 / geometry.resolution
    box = _box_around(geometry, lattice, reach)
    if box is None:
        return None
    rows, cols = box.row1 - box.row0, box.col1 - box.col0
    ends = np.zeros((rows, cols + 1), dtype=_COUNT)
    place = lattice - (box.col0, box.row0)
    for a, b in zip(place, [*place[1:], place[-1]], strict=True):
        check()
        row0 = max(math.floor(min(a[1], b[1]) - reach - 0.5), 0)
        row1 = min(math.ceil(max(a[1], b[1]) + reach + 0.5), rows)
        if row0 >= row1:
            continue
        at = np.arange(row0, row1)
        first, last = _near_segment(at + 0.5, a, b, reach)
        on = first <= last
        begin = np.clip(np.ceil(first[on] - 0.5), 0, cols).astype(np.int64)
        end = np.clip(np.floor(last[on] - 0.5) + 1.0, 0, cols).astype(np.int64)
        runs = begin < end
        ends[at[on][runs], begin[runs]] += 1
        ends[at[on][runs], end[runs]] -= 1
    cells = np.floor(place).astype(np.int64)
    cells = cells[((cells >= 0) & (cells < (cols, rows))).all(axis=1)]

    def bands() -> Iterator[tuple[int, BoolArray]]:
        for row0, row1 in row_bands(rows, cols):
            check()
            near = np.cumsum(ends[row0:row1, :cols], axis=1, dtype=_COUNT) > 0
            here = cells[(cells[:, 1] >= row0) & (cells[:, 1] < row1)]
            near[here[:, 1] - row0, here[:, 0]] = True
            yield row0, near

    return box, bands()


def polygon_cells(geometry: GridGeometry, polygon: Float64Array, check: Callable[[], None]) -> Covered | None:
    """Return the cells with centres in a ``polygon`` (n, 2), by the even-odd rule.

    None if the map has none near it. ``check`` is called before each side and each band. Each side is crossed by one
    line of centres per row, where the cells before the crossing change sides.
    """
    lattice = geometry.to_lattice(polygon)
    box = _box_around(geometry, lattice, 0.0)
    if box is None:
        return None
    rows, cols = box.row1 - box.row0, box.col1 - box.col0
    crossings = np.zeros((rows, cols + 1), dtype=_COUNT)
    place = lattice - (box.col0, box.row0)
    for (a_u, a_v), (b_u, b_v) in zip(place, np.roll(place, -1, axis=0), strict=True):
        check()
        row0, row1 = max(math.ceil(min(a_v, b_v) - 0.5), 0), min(math.ceil(max(a_v, b_v) - 0.5), rows)
        if row0 < row1:
            at = np.arange(row0, row1)
            u = a_u + (at + 0.5 - a_v) / (b_v - a_v) * (b_u - a_u)
            crossings[at, np.clip(np.ceil(u - 0.5), 0, cols).astype(np.int64)] += 1

    def bands() -> Iterator[tuple[int, BoolArray]]:
        for row0, row1 in row_bands(rows, cols):
            check()
            # Crossings at or after the cell before.
            after = np.cumsum(crossings[row0:row1, ::-1], axis=1, dtype=_COUNT)[:, ::-1]
            yield row0, after[:, 1:] % 2 == 1

    return box, bands()
