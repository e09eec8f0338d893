"""Extension of the ground by points on the plane of the ground on one side, such as edges of terraces and crests.

:func:`mapper.terrain.textbook_ground.continuing` is the same in plain NumPy.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.jit import jit


@jit
def lowest_ground(
    points: Float64Array, ground: BoolArray, corner: Float64Array, cell: float, out: NDArray[np.int32]
) -> None:
    """Write the index of the lowest ground point of each cell (rows, cols), −1 if there is none."""
    out[:] = -1
    for i in range(len(points)):
        if ground[i]:
            row, col = int((points[i, 1] - corner[1]) / cell), int((points[i, 0] - corner[0]) / cell)
            other = out[row, col]
            if other < 0 or points[i, 2] < points[other, 2]:
                out[row, col] = i


@jit
def mark_near(
    points: Float64Array, new: BoolArray, corner: Float64Array, cell: float, reach: int, out: BoolArray
) -> None:
    """Write which cells (rows, cols) are within ``reach`` cells of a new point's cell."""
    out[:] = False
    for i in range(len(points)):
        if new[i]:
            row, col = int((points[i, 1] - corner[1]) / cell), int((points[i, 0] - corner[0]) / cell)
            out[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1] = True


@jit
def _continues(
    points: Float64Array,
    i: int,
    lowest: NDArray[np.int32],
    sums: Int64Array,
    rows: tuple[int, int],
    cols: tuple[int, int],
    need: int,
    most: float,
    height: float,
    share: float,
) -> bool:
    """Return whether point ``i`` is on the plane of the lowest ground points in a box of cells.

    The plane is fitted by least squares to at least ``need`` points. Its slope must not exceed ``most``, its residual
    and the point's distance must be at most ``height`` + ``share`` · slope, and the point's leverage at most 1, so that
    the plane is known there as well as at one of the ground points.
    """
    first, last = max(rows[0], 0), min(rows[1], lowest.shape[0] - 1)
    left, right = max(cols[0], 0), min(cols[1], lowest.shape[1] - 1)
    n = sums[last + 1, right + 1] - sums[first, right + 1] - sums[last + 1, left] + sums[first, left]
    if n < need:
        return False
    sx = sy = sz = xx = xy = yy = xz = yz = zz = 0.0
    for row in range(first, last + 1):
        for col in range(left, right + 1):
            j = lowest[row, col]
            if j >= 0:
                x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
                sx += x
                sy += y
                sz += z
                xx += x * x
                xy += x * y
                yy += y * y
                xz += x * z
                yz += y * z
                zz += z * z
    mx, my, mz = sx / n, sy / n, sz / n
    xx, xy, yy = xx - mx * sx, xy - mx * sy, yy - my * sy
    xz, yz, zz = xz - mx * sz, yz - my * sz, zz - mz * sz
    det = xx * yy - xy * xy
    if det <= 1e-9 * xx * yy:
        return False
    if 1.0 / n + (mx * mx * yy - 2.0 * mx * my * xy + my * my * xx) / det > 1.0:
        return False
    a, b = (xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det
    slope = math.sqrt(a * a + b * b)
    limit = height + share * slope
    if slope > most or abs(mz - a * mx - b * my) > limit:
        return False
    return bool(zz - a * xz - b * yz <= limit * limit * (n - 3))


@jit
def _span(cell: int, side: int, reach: int) -> tuple[int, int]:
    """Return the first and last cell of a box along one axis: to one ``side``, −1 or 1, or half to both sides, 0."""
    if side == 0:
        return cell - reach // 2, cell + reach // 2
    return (cell - reach, cell) if side < 0 else (cell, cell + reach)


@jit
def extend(
    points: Float64Array,
    ground: BoolArray,
    corner: Float64Array,
    cell: float,
    lowest: NDArray[np.int32],
    sums: Int64Array,
    near: BoolArray,
    reach: int,
    need: int,
    most: float,
    height: float,
    share: float,
    out: BoolArray,
) -> None:
    """Write which points that are not ground, in cells that are ``near``, continue it from one of eight sides.

    The box of a side starts at the point's cell. Along each axis it extends ``reach`` cells to one side, or half of
    that to both. It always contains the ground point of the point's own cell, so a point whose height differs from it
    by more than any such plane allows is rejected at once. ``sums`` (rows + 1, cols + 1) is the number of cells with a
    ground point above and left of a corner.
    """
    limit = height + share * most
    furthest = math.sqrt(2.0) * cell * most + limit * (2.0 + reach)  # the box has about (1 + reach)² cells
    for i in range(len(points)):
        out[i] = False
        if ground[i]:
            continue
        row, col = int((points[i, 1] - corner[1]) / cell), int((points[i, 0] - corner[0]) / cell)
        own = lowest[row, col]
        if not near[row, col] or (own >= 0 and abs(points[i, 2] - points[own, 2]) > furthest):
            continue
        for side in range(9):
            if side == 4:
                continue  # the box centred on the point is not a side
            rows, cols = _span(row, side // 3 - 1, reach), _span(col, side % 3 - 1, reach)
            if _continues(points, i, lowest, sums, rows, cols, need, most, height, share):
                out[i] = True
                break
