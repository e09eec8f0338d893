"""The steps of SMRF, and the segments that are restored; :mod:`mapper.terrain.textbook_ground` is the same in NumPy.

Grids are (rows, cols) float32 in metres above the lowest corner. Points are (n, 3) float64 in metres, all within the
grid. A segment is a smooth set of cells removed by the discs; those that continue smoothly into the ground are
restored.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float64Array
from mapper.core.jit import jit

Heights = NDArray[np.float32]


@jit
def lowest_of_cells(points: Float64Array, used: BoolArray, corner: Float64Array, cell: float, out: Heights) -> None:
    """Write the height of the lowest used point of each cell into ``out``, NaN if there is none."""
    out[:] = np.nan
    for i in range(len(points)):
        if used[i]:
            row, col = int((points[i, 1] - corner[1]) / cell), int((points[i, 0] - corner[0]) / cell)
            z = np.float32(points[i, 2] - corner[2])
            if not out[row, col] <= z:
                out[row, col] = z


@jit
def _smaller_rise(before: float, after: float) -> float:
    """Return the smaller of two rises, 0 if their signs differ, so that slopes end at steps and crests have no
    slope.
    """
    if before * after <= 0.0:
        return 0.0
    return before if abs(before) < abs(after) else after


@jit
def move_to_centres(
    points: Float64Array, lowest: NDArray[np.int32], heights: Heights, corner: Float64Array, cell: float, out: Heights
) -> None:
    """Write the heights of the cells' ``lowest`` points moved to the cells' centres; NaN if a cell has none.

    ``heights`` are those of the filled cells. The slope is the smaller one of the two sides, over two cells.
    """
    rows, cols = heights.shape
    for row in range(rows):
        for col in range(cols):
            i = lowest[row, col]
            if i < 0:
                out[row, col] = np.nan
                continue
            z = float(heights[row, col])
            up, down = float(heights[min(row + 2, rows - 1), col]), float(heights[max(row - 2, 0), col])
            right, left = float(heights[row, min(col + 2, cols - 1)]), float(heights[row, max(col - 2, 0)])
            x = (points[i, 0] - corner[0]) / cell - (col + 0.5)
            y = (points[i, 1] - corner[1]) / cell - (row + 0.5)
            out[row, col] = z - 0.5 * (_smaller_rise(z - left, right - z) * x + _smaller_rise(z - down, up - z) * y)


@jit
def halve(heights: Heights, out: Heights) -> None:
    """Write the mean of the known cells of each 2 × 2 block into ``out`` (⌈rows / 2⌉, ⌈cols / 2⌉), NaN if there is
    none.
    """
    rows, cols = heights.shape
    for row in range(out.shape[0]):
        for col in range(out.shape[1]):
            total, n = np.float32(0.0), 0
            for y in range(2 * row, min(2 * row + 2, rows)):
                for x in range(2 * col, min(2 * col + 2, cols)):
                    if not math.isnan(heights[y, x]):
                        total += heights[y, x]
                        n += 1
            out[row, col] = total / np.float32(n) if n > 0 else np.float32(np.nan)


@jit
def smooth_unknown(heights: Heights, coarse: Heights, sweeps: int, other: Heights, out: Heights) -> None:
    """Fill the NaN of ``heights`` from the filled ``coarse`` and smooth the filled cells; ``other`` is scratch memory.

    Known cells are rewritten in each sweep, so that a row is processed without branches and vectorised.
    """
    rows, cols = heights.shape
    for row in range(rows):
        for col in range(cols):
            z = heights[row, col]
            out[row, col] = coarse[row // 2, col // 2] if math.isnan(z) else z
    for sweep in range(sweeps):
        before, after = (out, other) if sweep % 2 == 0 else (other, out)
        for row in range(rows):
            up, down, here = before[max(row - 1, 0)], before[min(row + 1, rows - 1)], before[row]
            known, written = heights[row], after[row]
            for side in range(2):
                col = 0 if side == 0 else cols - 1
                left, right = here[max(col - 1, 0)], here[min(col + 1, cols - 1)]
                mean = ((up[col] + down[col]) + (left + right)) * np.float32(0.25)
                written[col] = mean if math.isnan(known[col]) else known[col]
            for col in range(1, cols - 1):
                mean = ((up[col] + down[col]) + (here[col - 1] + here[col + 1])) * np.float32(0.25)
                z = known[col]
                written[col] = z if z == z else mean  # noqa: PLR0124 - NaN; the test that compilers vectorise
    if sweeps % 2 == 1:
        out[:] = other


@jit
def _widen(shorter: Heights, by: int, out: Heights) -> None:
    """Write the minima of runs that are ``by`` cells longer at each end than those of ``shorter``.

    Three of these cover one, as long as ``by`` is at most their length.
    """
    rows, cols = shorter.shape
    for row in range(rows):
        before, after = shorter[row], out[row]
        for col in range(min(by, cols)):
            after[col] = min(before[0], before[col], before[min(col + by, cols - 1)])
        for col in range(max(cols - by, 0), cols):
            after[col] = min(before[max(col - by, 0)], before[col], before[cols - 1])
        inside = max(cols - 2 * by, 0)
        left, middle, right, written = before[:inside], before[by:], before[2 * by :], after[by:]
        for k in range(inside):
            a, b, c = left[k], middle[k], right[k]
            a = min(b, a)
            written[k] = min(c, a)


@jit
def erode(heights: Heights, radius: int, sign: float, runs: Heights, out: Heights) -> None:
    """Write the minimum of ``sign`` · height within a disc of ``radius`` cells, times ``sign``, into ``out``.

    ``sign`` 1 erodes, −1 dilates. A disc is one run of cells per row, from the shortest in the first and last row to
    the longest. Beyond the grid the border row is repeated, which has no effect because the disc has a longer run in
    it. ``runs`` (2, rows, cols) is scratch memory.
    """
    rows, cols = heights.shape
    factor = np.float32(sign)
    for row in range(rows):
        for col in range(cols):
            runs[0, row, col] = factor * heights[row, col]
            out[row, col] = np.inf
    half, now = 0, 0
    for away in range(radius, -1, -1):
        needed = int(math.sqrt(radius * radius - away * away))
        while half < needed:
            by = min(2 * half + 1, needed - half)
            _widen(runs[now], by, runs[1 - now])
            half, now = half + by, 1 - now
        for row in range(rows):
            above, below, written = runs[now, max(row - away, 0)], runs[now, min(row + away, rows - 1)], out[row]
            for col in range(cols):
                a, b, c = above[col], written[col], below[col]
                a = min(b, a)
                written[col] = min(c, a)
    for row in range(rows):
        for col in range(cols):
            out[row, col] = factor * out[row, col]


@jit
def mark_lowered(
    before: Heights, after: Heights, threshold: float, around: Heights, factor: float, out: BoolArray
) -> None:
    """Set ``out`` where a cell was lowered by more than ``threshold`` + ``factor`` · ``around``, the local slope."""
    least, more = np.float32(threshold), np.float32(factor)
    for row in range(before.shape[0]):
        for col in range(before.shape[1]):
            out[row, col] |= before[row, col] - after[row, col] > least + more * around[row, col]


@jit
def lowest_of_blocks(heights: Heights, left_out: BoolArray, side: int, out: Heights) -> None:
    """Write the minimum of each block of ``side`` × ``side`` cells into ``out`` (⌈rows / side⌉, ⌈cols / side⌉).

    Cells that are ``left_out`` (rows, cols) are ignored; NaN if a block has no others.
    """
    out[:] = np.nan
    for row in range(heights.shape[0]):
        for col in range(heights.shape[1]):
            y, x = row // side, col // side
            if not left_out[row, col] and not out[y, x] <= heights[row, col]:
                out[y, x] = heights[row, col]


@jit
def mean_around(values: Heights, reach: int, most: float, out: Heights) -> None:
    """Write the mean of the values, each limited to ``most``, within ``reach`` cells along rows and columns."""
    rows, cols = values.shape
    greatest = np.float32(most)
    for row in range(rows):
        first, last = max(row - reach, 0), min(row + reach, rows - 1)
        for col in range(cols):
            left, right = max(col - reach, 0), min(col + reach, cols - 1)
            total = 0.0
            for y in range(first, last + 1):
                for x in range(left, right + 1):
                    total += min(values[y, x], greatest)
            out[row, col] = total / ((last - first + 1) * (right - left + 1))


@jit
def slope_of_surface(surface: Heights, cell: float, out: Heights) -> None:
    """Write the slope of the surface, rise over run."""
    rows, cols = surface.shape
    size = np.float32(cell)
    for row in range(rows):
        up, down = min(row + 1, rows - 1), max(row - 1, 0)
        high = max(size * np.float32(up - down), size)
        for col in range(cols):
            right, left = min(col + 1, cols - 1), max(col - 1, 0)
            dy = (surface[up, col] - surface[down, col]) / high
            dx = (surface[row, right] - surface[row, left]) / max(size * np.float32(right - left), size)
            out[row, col] = np.sqrt(dx * dx + dy * dy)


@jit
def classify(
    points: Float64Array,
    corner: Float64Array,
    surface: Heights,
    steep: Heights,
    doubtful: BoolArray,
    cell: float,
    height: float,
    scaling: float,
    out: BoolArray,
    unsure: BoolArray,
) -> None:
    """Write which points are within ``height`` + ``scaling`` · slope of the surface, above or below it.

    ``unsure`` are those for which half or twice the limit would decide otherwise, and those in ``doubtful`` (rows,
    cols) cells.
    """
    rows, cols = surface.shape
    for i in range(len(points)):
        u = min(max((points[i, 0] - corner[0]) / cell - 0.5, 0.0), cols - 1.0)
        v = min(max((points[i, 1] - corner[1]) / cell - 0.5, 0.0), rows - 1.0)
        col, row = min(int(u), max(cols - 2, 0)), min(int(v), max(rows - 2, 0))
        s, t = u - col, v - row
        right, up = min(col + 1, cols - 1), min(row + 1, rows - 1)
        low = (1.0 - s) * surface[row, col] + s * surface[row, right]
        high = (1.0 - s) * surface[up, col] + s * surface[up, right]
        away = abs((points[i, 2] - corner[2]) - ((1.0 - t) * low + t * high))
        low = (1.0 - s) * steep[row, col] + s * steep[row, right]
        high = (1.0 - s) * steep[up, col] + s * steep[up, right]
        limit = height + scaling * ((1.0 - t) * low + t * high)
        out[i] = away <= limit
        own = doubtful[int((points[i, 1] - corner[1]) / cell), int((points[i, 0] - corner[0]) / cell)]
        unsure[i] = own or 0.5 * limit < away <= 2.0 * limit


@jit
def _root_of(parents: NDArray[np.int32], cell: int) -> int:
    """Return the first cell of a segment, with path compression."""
    while parents[cell] != cell:
        parents[cell] = parents[parents[cell]]
        cell = int(parents[cell])
    return cell


@jit
def _goes_on(
    heights: Heights, row: int, col: int, down: int, right: int, most: float, height: float, share: float
) -> bool:
    """Return whether the surface continues from a cell to the next: the rises before, between and after the two agree.

    ``most`` is the maximum rise between cells, metres; rises may differ by ``height`` + ``share`` · rise.
    """
    rows, cols = heights.shape
    before, left = row - down, col - right
    after, far = row + 2 * down, col + 2 * right
    if before < 0 or left < 0 or before >= rows or left >= cols:
        return False
    if after < 0 or far < 0 or after >= rows or far >= cols:
        return False
    first = heights[row, col] - heights[before, left]
    rise = heights[row + down, col + right] - heights[row, col]
    last = heights[after, far] - heights[row + down, col + right]
    steepest, base, factor = np.float32(most), np.float32(height), np.float32(share)
    return bool(
        abs(first) <= steepest
        and abs(last) <= steepest
        and abs(rise - first) <= base + factor * abs(first)
        and abs(rise - last) <= base + factor * abs(last)
    )


@jit
def join_cells(
    heights: Heights, taken: BoolArray, most: float, height: float, share: float, parents: NDArray[np.int32]
) -> None:
    """Join taken cells (rows, cols) into segments over which the surface is continuous; ``parents`` (rows · cols,)."""
    rows, cols = heights.shape
    for i in range(rows * cols):
        parents[i] = i
    for row in range(rows):
        for col in range(cols):
            if not taken[row, col]:
                continue
            for side in range(2):
                down, right = (0, 1) if side == 0 else (1, 0)
                y, x = row + down, col + right
                if y >= rows or x >= cols or not taken[y, x]:
                    continue
                if _goes_on(heights, row, col, down, right, most, height, share):
                    a, b = _root_of(parents, row * cols + col), _root_of(parents, y * cols + x)
                    parents[max(a, b)] = min(a, b)


@jit
def count_sides(
    heights: Heights,
    taken: BoolArray,
    most: float,
    height: float,
    share: float,
    parents: NDArray[np.int32],
    sides: NDArray[np.int32],
) -> None:
    """Write for each segment into ``sides`` (rows · cols, 4): sides into the ground, drops, and sums of directions.

    The directions, in rows and columns, are those of the sides into the ground.
    """
    rows, cols = heights.shape
    sides[:] = 0
    for row in range(rows):
        for col in range(cols):
            if not taken[row, col]:
                continue
            segment = _root_of(parents, row * cols + col)
            for side in range(4):
                down = 1 if side == 0 else (-1 if side == 1 else 0)
                right = 1 if side == 2 else (-1 if side == 3 else 0)
                y, x = row + down, col + right
                if y < 0 or x < 0 or y >= rows or x >= cols:
                    continue
                if taken[y, x] and _root_of(parents, y * cols + x) == segment:
                    continue
                if not taken[y, x] and _goes_on(heights, row, col, down, right, most, height, share):
                    sides[segment, 0] += np.int32(1)
                    sides[segment, 2] += np.int32(down)
                    sides[segment, 3] += np.int32(right)
                elif heights[row, col] > heights[y, x]:
                    sides[segment, 1] += np.int32(1)


@jit
def judge(
    taken: BoolArray,
    parents: NDArray[np.int32],
    sides: NDArray[np.int32],
    least_into: float,
    front: int,
    returned: BoolArray,
    contested: BoolArray,
) -> None:
    """Write which taken cells are restored, and which are not although some of their sides continue into the ground."""
    rows, cols = taken.shape
    for row in range(rows):
        for col in range(cols):
            returned[row, col] = contested[row, col] = False
            if taken[row, col]:
                segment = _root_of(parents, row * cols + col)
                into, drops = np.int64(sides[segment, 0]), np.int64(sides[segment, 1])
                down, right = np.int64(sides[segment, 2]), np.int64(sides[segment, 3])
                is_front = down * down + right * right >= front * front
                returned[row, col] = into > 0 and (is_front or into >= least_into * (into + drops))
                contested[row, col] = into > 0 and not returned[row, col]
