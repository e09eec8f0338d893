"""Columns of voxels as bits: the upper 16 of 32 bits are the marked voxels, the lower 16 the voxels that are not free.

Marked is (1, 1), unknown (0, 1), free (0, 0). Numba twins of :func:`mapper.costmap.textbook.mark_voxels` and
:func:`mapper.costmap.textbook.clear_voxels`. Source: nav2_voxel_grid, voxel_grid.hpp; nav2_costmap_2d, voxel_layer.cpp.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.costmap.kernels.marking import Marking, include, marks
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)
_include = jit(include)
_marks = jit(marks)

Columns = NDArray[np.unsignedinteger[Any]]  #: (rows, cols) uint32

_END = 1e-5  #: fraction of its length by which a clipped beam ends before the border


class Heights(NamedTuple):
    """Heights of the voxels of a column, and the thresholds that determine its cost."""

    origin_z: float  #: m, of the lowest voxel's lower face
    z_resolution: float  #: m
    z_voxels: int
    mark_threshold: int  #: a column with more marked voxels is lethal
    unknown_threshold: int  #: a column with more unknown bits, of 16, is unknown


@jit
def _count(bits: int) -> int:
    """Return the number of set bits among the lowest 16."""
    n = 0
    for k in range(16):
        n += (bits >> k) & 1
    return n


@jit
def mark_columns(
    points: Float64Array, sensor: Float64Array, frame: Frame, marking: Marking, heights: Heights, columns: Columns,
    costs: UInt8Array, box: Int64Array,
) -> None:  # fmt: skip
    """Mark the voxels of those ``points`` (n, 3) that mark; columns with enough marked voxels become lethal (254)."""
    rows, cols = costs.shape
    for i in range(points.shape[0]):
        if not _marks(points[i], sensor, marking):
            continue
        u, v = _to_lattice(points[i, 0], points[i, 1], frame)
        level = int((max(points[i, 2], heights.origin_z) - heights.origin_z) / heights.z_resolution)
        if 0.0 <= u < cols and 0.0 <= v < rows and level < heights.z_voxels:
            row, col = int(_cell_of(v)), int(_cell_of(u))
            bits = int(np.int64(columns[row, col])) | (0x10001 << level)
            columns[row, col] = np.uint32(bits)
            if _count(bits >> 16) > heights.mark_threshold:
                costs[row, col] = np.uint8(254)
                _include(box, row, col)


@jit
def _clear_voxel(row: int, col: int, level: int, heights: Heights, columns: Columns, costs: UInt8Array) -> None:
    """Clear a voxel and update the column's cost, unless it still has enough marked voxels."""
    bits = int(np.int64(columns[row, col])) & ~(0x10001 << level)
    columns[row, col] = np.uint32(bits)
    if _count(bits >> 16) <= heights.mark_threshold:
        unknown = _count((bits >> 16) ^ (bits & 0xFFFF))
        costs[row, col] = np.uint8(0 if unknown <= heights.unknown_threshold else 255)


@jit
def _clear_line(
    start: tuple[float, float, float], end: tuple[float, float, float], least: int, most: int, heights: Heights,
    columns: Columns, costs: UInt8Array, box: Int64Array,
) -> None:  # fmt: skip
    """Clear the voxels of a line between two points (v, u, level) by Bresenham's algorithm in three dimensions."""
    d_v, d_u, d_w = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = sqrt(d_v * d_v + d_u * d_u + d_w * d_w)
    if int(length) < least:
        return
    share, skipped = 1.0, 0.0
    if length > 0.0:
        share, skipped = min(1.0, most / length), least / length
    row, col = int(start[0] + d_v * skipped), int(start[1] + d_u * skipped)
    level = int(start[2] + d_w * skipped)
    n_row, n_col, n_level = int(end[0]) - row, int(end[1]) - col, int(end[2]) - level
    step_row, step_col = (1 if n_row > 0 else -1), (1 if n_col > 0 else -1)
    step_level = 1 if n_level > 0 else -1
    n_row, n_col, n_level = abs(n_row), abs(n_col), abs(n_level)
    major = max(n_row, n_col, n_level)
    error_row = error_col = error_level = major // 2
    by_col = n_col == major
    by_row = not by_col and n_row == major
    _include(box, row, col)
    for _ in range(min(int(share * major), major)):
        _clear_voxel(row, col, level, heights, columns, costs)
        error_row += n_row
        error_col += n_col
        error_level += n_level
        if by_row or error_row >= major:
            row += step_row
            error_row -= major
        if by_col or error_col >= major:
            col += step_col
            error_col -= major
        if (not by_row and not by_col) or error_level >= major:
            level += step_level
            error_level -= major
    _clear_voxel(row, col, level, heights, columns, costs)
    _include(box, row, col)


@jit
def clear_columns(
    points: Float64Array, sensor: Float64Array, frame: Frame, least: int, most: int, heights: Heights,
    columns: Columns, costs: UInt8Array, box: Int64Array,
) -> None:  # fmt: skip
    """Clear the voxels between the sensor (3,) and each of ``points`` (n, 3), up to two cells before the point.

    A beam is clipped at the border of the grid, its floor and its top. ``least`` and ``most`` are the clearing ranges
    in cells. Nothing is cleared if the sensor is outside the grid or its heights. ``box`` (row0, row1, col0, col1) is
    extended to the columns passed.
    """
    rows, cols = costs.shape
    top = float(heights.z_voxels)
    o_u, o_v = _to_lattice(sensor[0], sensor[1], frame)
    o_w = (sensor[2] - heights.origin_z) / heights.z_resolution
    if not (0.0 <= o_u < cols and 0.0 <= o_v < rows and 0.0 <= o_w < top):
        return
    for i in range(points.shape[0]):
        d_x, d_y, d_z = points[i, 0] - sensor[0], points[i, 1] - sensor[1], points[i, 2] - sensor[2]
        distance = sqrt(d_x * d_x + d_y * d_y + d_z * d_z)
        if distance == 0.0:
            continue
        before = max((distance - 2.0 * frame.resolution) / distance, 0.0)
        u, v = _to_lattice(sensor[0] + before * d_x, sensor[1] + before * d_y, frame)
        w = (sensor[2] + before * d_z - heights.origin_z) / heights.z_resolution
        share = 1.0
        if w > top:
            share = max(0.0, min(share, (top - 0.01 / heights.z_resolution - o_w) / (w - o_w)))
        elif w < 0.0:
            share = min(share, -o_w / (w - o_w))
        if u < 0.0:
            share = min(share, -o_u / (u - o_u))
        elif u > cols:
            share = min(share, (cols - o_u) / (u - o_u))
        if v < 0.0:
            share = min(share, -o_v / (v - o_v))
        elif v > rows:
            share = min(share, (rows - o_v) / (v - o_v))
        if share > 0.0 and (w > top or w < 0.0 or u < 0.0 or u > cols or v < 0.0 or v > rows):
            share -= _END
        u, v, w = o_u + share * (u - o_u), o_v + share * (v - o_v), o_w + share * (w - o_w)
        if 0.0 <= u < cols and 0.0 <= v < rows and 0.0 <= w < top:
            _clear_line((o_v, o_u, o_w), (v, u, w), least, most, heights, columns, costs, box)
