"""SMRF and its additional steps in plain NumPy, step by step; the kernels must return the same.

Source: Pingel, Clarke & McBride, An improved simple morphological filter for the terrain classification of airborne
LIDAR data, ISPRS Journal of Photogrammetry and Remote Sensing 77, 2013. Empty cells are filled here by Laplace's
equation instead of the authors' spring metaphor; as in the paper, the discs grow by one cell at a time.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray
from mapper.terrain.parameters import (
    BLOCK,
    LEAST_INTO,
    PLANE_POINTS,
    PLANE_REACH,
    PLANE_SHARE,
    RISE_SHARE,
    STEEPEST,
    SWEEPS,
    GroundConfig,
)

Heights = NDArray[np.float32]


def lowest(points: NDArray[np.float64], corner: NDArray[np.float64], cell: float, shape: tuple[int, int]) -> Heights:
    """Return the height of the lowest point of each cell (rows, cols), metres above the corner; NaN if there is none.

    ``points`` (n, 3) in metres; ``corner`` (3,) is the lowest corner of cell (0, 0).
    """
    heights = np.full(shape, np.nan, dtype=np.float32)
    for x, y, z in points - corner:
        row, col = int(y / cell), int(x / cell)
        heights[row, col] = np.fmin(heights[row, col], np.float32(z))
    return heights


def filled(heights: Heights) -> Heights:
    """Return ``heights`` (rows, cols) with each NaN replaced by about the mean of its four neighbours.

    Laplace's equation from coarse to fine: the half-sized grid of the means of known cells is filled first and
    initialises the unknown cells, which are then smoothed by Jacobi sweeps. At least one cell must be known.
    """
    unknown = np.isnan(heights)
    if not unknown.any():
        return heights.copy()
    rows, cols = heights.shape
    coarse = np.full((-(-rows // 2), -(-cols // 2)), np.nan, dtype=np.float32)
    for row, col in np.ndindex(coarse.shape):
        block = heights[2 * row : 2 * row + 2, 2 * col : 2 * col + 2].ravel()
        known = block[~np.isnan(block)]
        if len(known):
            total = np.float32(0.0)
            for value in known:
                total += value
            coarse[row, col] = total / np.float32(len(known))
    above = np.repeat(np.repeat(filled(coarse), 2, axis=0), 2, axis=1)[:rows, :cols]
    now = np.where(unknown, above, heights)
    for _ in range(SWEEPS):
        around = np.pad(now, 1, mode="edge")
        mean = ((around[:-2, 1:-1] + around[2:, 1:-1]) + (around[1:-1, :-2] + around[1:-1, 2:])) * np.float32(0.25)
        now = np.where(unknown, mean, now)
    return now


def eroded(heights: Heights, radius: int) -> Heights:
    """Return the minimum height within ``radius`` cells of each cell; cells outside the grid are ignored."""
    rows, cols = heights.shape
    out = np.full_like(heights, np.inf)
    around = np.pad(heights, radius, constant_values=np.float32(np.inf))
    for down in range(-radius, radius + 1):
        half = math.isqrt(radius * radius - down * down)
        for right in range(-half, half + 1):
            first = radius + down, radius + right
            out = np.minimum(out, around[first[0] : first[0] + rows, first[1] : first[1] + cols])
    return out


def opened(heights: Heights, radius: int) -> Heights:
    """Return the morphological opening by a disc, which removes narrower bumps."""
    return -eroded(-eroded(heights, radius), radius)


def objects(
    heights: Heights, radius: int, slope: float, cell: float, around: Heights | None = None, share: float = 0.0
) -> BoolArray:
    """Return the cells (rows, cols) of objects: those that an opening lowers by more than ``slope`` · r · ``cell``.

    The disc grows from r = 1 to ``radius`` cells, and each opening is applied to the one before. A crest with flanks of
    slope s is lowered by s · ``cell`` more by each disc, so ``share`` · s · ``cell`` is added to the threshold, where s
    is the slope ``around`` (rows, cols).
    """
    is_object = np.zeros(heights.shape, dtype=np.bool_)
    before = heights
    for r in range(1, radius + 1):
        after = opened(before, r)
        more = np.float32(share * cell) * (np.zeros_like(heights) if around is None else around)
        is_object |= before - after > np.float32(slope * r * cell) + more
        before = after
    return is_object


def gradient(surface: Heights, cell: float) -> Heights:
    """Return the slope of a surface (rows, cols), rise over run: central differences, one-sided at the border."""
    rows, cols = surface.shape
    size = np.float32(cell)
    up, down = np.minimum(np.arange(rows) + 1, rows - 1), np.maximum(np.arange(rows) - 1, 0)
    right, left = np.minimum(np.arange(cols) + 1, cols - 1), np.maximum(np.arange(cols) - 1, 0)
    dy = (surface[up] - surface[down]) / np.maximum(size * (up - down).astype(np.float32), size)[:, None]
    dx = (surface[:, right] - surface[:, left]) / np.maximum(size * (right - left).astype(np.float32), size)
    return np.asarray(np.sqrt(dx * dx + dy * dy), dtype=np.float32)


def between_cells(surface: Heights, x: float, y: float) -> float:
    """Return the bilinear value of a surface at (``x``, ``y``) in cells, extended by its border values."""
    rows, cols = surface.shape
    u, v = min(max(x - 0.5, 0.0), cols - 1.0), min(max(y - 0.5, 0.0), rows - 1.0)
    col, row = min(int(u), max(cols - 2, 0)), min(int(v), max(rows - 2, 0))
    s, t = u - col, v - row
    right, up = min(col + 1, cols - 1), min(row + 1, rows - 1)
    low = (1.0 - s) * float(surface[row, col]) + s * float(surface[row, right])
    high = (1.0 - s) * float(surface[up, col]) + s * float(surface[up, right])
    return float((1.0 - t) * low + t * high)


def near_surface(
    points: NDArray[np.float64],
    corner: NDArray[np.float64],
    surface: Heights,
    cell: float,
    height: float,
    scaling: float,
) -> BoolArray:
    """Return which points (n,) are within ``height`` + ``scaling`` · slope of a surface, above or below it; metres."""
    steep = gradient(surface, cell)
    ground = np.zeros(len(points), dtype=np.bool_)
    for i, (x, y, z) in enumerate(points - corner):
        u, v = x / cell, y / cell
        away = abs(z - between_cells(surface, u, v))
        ground[i] = away <= height + scaling * between_cells(steep, u, v)
    return ground


def lowest_of_blocks(heights: Heights, left_out: BoolArray) -> Heights:
    """Return the minimum height of each block of 4 × 4 cells, without those left out; empty blocks are filled."""
    rows, cols = heights.shape
    lowest = np.full((-(-rows // BLOCK), -(-cols // BLOCK)), np.nan, dtype=np.float32)
    for row, col in np.ndindex(rows, cols):
        if not left_out[row, col]:
            lowest[row // BLOCK, col // BLOCK] = np.fmin(lowest[row // BLOCK, col // BLOCK], heights[row, col])
    return heights[::BLOCK, ::BLOCK].copy() if np.isnan(lowest).all() else filled(lowest)


def border_line(lowest: Heights, reach: int, steepest: float) -> list[tuple[np.float32, np.float32]]:
    """Return the height of the ground in each block of row 0 and its rise from there to the block before it.

    The rise is the median of the slopes between any two blocks of the first ``reach`` + 1 rows, including ``reach``
    columns to both sides (Theil 1950, Sen 1968). It is not negative: falling ground is continued level.
    """
    rows, cols = lowest.shape
    inside = range(min(reach + 1, rows))
    line = []
    for col in range(cols):
        near = [min(max(k, 0), cols - 1) for k in range(col - reach, col + reach + 1)]
        rises = [
            (lowest[i, k] - lowest[j, k]) / np.float32(j - i)
            for k in near
            for i, j in itertools.combinations(inside, 2)
        ]
        rise = np.float32(np.clip(np.median(rises), 0.0, steepest)) if rises else np.float32(0.0)
        line.append((min(lowest[i, col] + rise * np.float32(i) for i in inside), rise))
    return line


def continued(heights: Heights, lowest: Heights, block: int, width: int, reach: int, steepest: float) -> Heights:
    """Return ``heights`` (rows, cols) padded by ``width`` cells at each border, rising like the ground inside.

    ``lowest`` are the minimum heights of blocks of ``block`` × ``block`` cells. Heights and rises are interpolated
    between their centres.
    """
    out = np.pad(heights, width)
    for turn in range(4):
        line = np.array(border_line(np.rot90(lowest, turn), reach, steepest))
        turned = np.rot90(out, turn)
        for col in range(turned.shape[1] - 2 * width):
            place = min(max((col + 0.5) / block - 0.5, 0.0), len(line) - 1.0)
            left = min(int(place), max(len(line) - 2, 0))
            right = min(left + 1, len(line) - 1)
            height, rise = (1.0 - (place - left)) * line[left] + (place - left) * line[right]
            for away in range(1, width + 1):
                turned[width - away, width + col] = height + rise * (away + block - 1) / block
    for turn in range(4):
        corner = np.rot90(out, turn)
        for row, col in np.ndindex(width, width):
            corner[row, col] = max(corner[row, width], corner[width, col])
    return out


def slope_around(lowest: Heights, reach: int, slope: float, cell: float, steepest: float) -> Heights:
    """Return the slope of the ground around each block (rows, cols) of 4 × 4 cells, from the minimum of each block.

    Openings of these minimum heights remove the objects; the slopes of the rest are averaged within ``reach`` blocks.
    """
    beyond = continued(lowest, lowest, 1, reach, reach, steepest)
    taken = objects(beyond, reach, slope, BLOCK * cell)[reach:-reach, reach:-reach]
    surface = lowest if taken.all() else filled(np.where(taken, np.float32(np.nan), lowest))
    steep = np.minimum(gradient(surface, BLOCK * cell), np.float32(STEEPEST)).astype(np.float64)
    mean = np.empty_like(lowest)
    for row, col in np.ndindex(lowest.shape):
        near = steep[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1]
        mean[row, col] = sum(near.ravel().tolist()) / near.size
    return mean


def smaller_rise(before: float, after: float) -> float:
    """Return the smaller of two rises, 0 if their signs differ, so that slopes end at steps and crests have no
    slope.
    """
    return 0.0 if before * after <= 0.0 else min(before, after, key=abs)


def heights_of_centres(
    points: NDArray[np.float64], corner: NDArray[np.float64], whole: Heights, cell: float
) -> Heights:
    """Return the heights (rows, cols) of the cells' lowest points, moved along the slope to the centres.

    ``whole`` are the filled heights of the lowest points themselves. The slope is the smaller one of the two sides.
    """
    rows, cols = whole.shape
    places: dict[tuple[int, int], tuple[float, float, float]] = {}
    for i, (x, y, _) in enumerate(points - corner):
        at = int(y / cell), int(x / cell)
        if at not in places or points[i, 2] < places[at][2]:
            places[at] = x / cell - (at[1] + 0.5), y / cell - (at[0] + 0.5), points[i, 2]
    moved = np.full_like(whole, np.nan)
    for (row, col), (x, y, _) in places.items():
        z = float(whole[row, col])
        down, up = float(whole[max(row - 2, 0), col]), float(whole[min(row + 2, rows - 1), col])
        left, right = float(whole[row, max(col - 2, 0)]), float(whole[row, min(col + 2, cols - 1)])
        moved[row, col] = z - 0.5 * (smaller_rise(z - left, right - z) * x + smaller_rise(z - down, up - z) * y)
    return filled(moved)


def goes_on(heights: list[np.float32], cell: float, height: float) -> bool:
    """Return whether a surface is smooth over four cells in a line: the rises before, between and after two agree."""
    first, rise, last = (b - a for a, b in itertools.pairwise(heights))
    return all(
        abs(other) <= np.float32(STEEPEST * cell)
        and abs(rise - other) <= np.float32(height) + np.float32(RISE_SHARE) * abs(other)
        for other in (first, last)
    )


def given_back(
    heights: Heights, taken: BoolArray, cell: float, height: float, front: int
) -> tuple[BoolArray, BoolArray]:
    """Return which ``taken`` cells (rows, cols) are ground after all, and which of the others are in doubt.

    Connected taken cells with a continuous surface form a segment. Some of its sides continue into the ground, some are
    drops, some rise to their neighbours. Crests and edges of terraces have many of the first kind compared with the
    second. Spurs have the first kind on one side only, where the sum of their directions is at least ``front`` cells
    long.
    """
    rows, cols = heights.shape
    sides = ((0, 1), (1, 0), (0, -1), (-1, 0))

    def is_smooth(row: int, col: int, down: int, right: int) -> bool:
        line = [(row + k * down, col + k * right) for k in (-1, 0, 1, 2)]
        if not all(0 <= y < rows and 0 <= x < cols for y, x in line):
            return False
        return goes_on([heights[place] for place in line], cell, height)

    def neighbours(row: int, col: int) -> list[tuple[int, int, int, int]]:
        around = [(row + down, col + right, down, right) for down, right in sides]
        return [(y, x, down, right) for y, x, down, right in around if 0 <= y < rows and 0 <= x < cols]

    returned, contested = np.zeros_like(taken), np.zeros_like(taken)
    segments = np.zeros(heights.shape, dtype=np.int64)  # 0: none yet
    for number, (first, left) in enumerate(np.argwhere(taken).tolist(), start=1):
        if segments[first, left]:
            continue
        segments[first, left], cells = number, [(first, left)]
        for row, col in cells:
            for y, x, down, right in neighbours(row, col):
                if taken[y, x] and not segments[y, x] and is_smooth(row, col, down, right):
                    segments[y, x] = number
                    cells.append((y, x))
        drops = 0
        directions: list[tuple[int, int]] = []
        for row, col in cells:
            for y, x, down, right in neighbours(row, col):
                if segments[y, x] == number:
                    continue
                if not taken[y, x] and is_smooth(row, col, down, right):
                    directions.append((down, right))
                elif heights[row, col] > heights[y, x]:
                    drops += 1
        into = len(directions)
        is_spur = into > 0 and math.hypot(*np.sum(directions, axis=0)) >= front
        is_ground = is_spur or (into > 0 and into >= LEAST_INTO * (into + drops))
        for place in cells:
            returned[place], contested[place] = is_ground, into > 0 and not is_ground
    return returned, contested


def continues(point: NDArray[np.float64], others: NDArray[np.float64], height: float, share: float) -> bool:
    """Return whether a ``point`` (3,) is within ``height`` + ``share`` · slope of the plane of ``others`` (m, 3)."""
    if len(others) < PLANE_POINTS:
        return False
    local = others - point
    centred = local - local.mean(axis=0)
    across = centred[:, :2].T @ centred[:, :2]
    if np.linalg.det(across) <= 1e-9 * across[0, 0] * across[1, 1]:
        return False
    away = local[:, :2].mean(axis=0)
    if 1.0 / len(others) + away @ np.linalg.solve(across, away) > 1.0:  # the leverage of the point
        return False
    rises = np.linalg.solve(across, centred[:, :2].T @ centred[:, 2])
    slope = float(np.hypot(*rises))
    limit = height + share * slope
    residual = float(((centred[:, 2] - centred[:, :2] @ rises) ** 2).sum())
    is_on = abs(float(local[:, 2].mean() - away @ rises)) <= limit
    return slope <= STEEPEST and is_on and residual <= limit**2 * (len(others) - 3)


def continuing(points: NDArray[np.float64], ground: BoolArray, cell: float, height: float, share: float) -> BoolArray:
    """Return which points (n,) that are not ground are on the plane of the lowest ground points on one side of them.

    ``points`` (n, 3) are in metres from the corner of the cells. Each side is a box of cells.
    """
    lowest: dict[tuple[int, int], int] = {}
    for i in np.flatnonzero(ground).tolist():
        place = int(points[i, 1] / cell), int(points[i, 0] / cell)
        if place not in lowest or points[i, 2] < points[lowest[place], 2]:
            lowest[place] = i
    half, out = PLANE_REACH // 2, np.zeros(len(points), dtype=np.bool_)
    spans = range(-PLANE_REACH, 1), range(-half, half + 1), range(PLANE_REACH + 1)
    for i in np.flatnonzero(~ground).tolist():
        row, col = int(points[i, 1] / cell), int(points[i, 0] / cell)
        boxes = [
            [(row + a, col + b) for a in up for b in right]
            for up in spans
            for right in spans
            if (up, right) != (spans[1], spans[1])
        ]
        beside = [[lowest[place] for place in box if place in lowest] for box in boxes]
        out[i] = any(continues(points[i], points[some], height, share) for some in beside)
    return out


def ground_points(
    points: NDArray[np.float64], corner: NDArray[np.float64], shape: tuple[int, int], radius: int, config: GroundConfig
) -> tuple[BoolArray, Heights, BoolArray]:
    """Return which points (n,) are ground, the surface (rows, cols), and which points are unsure.

    The surface is in metres above the corner. Each pass after the first computes it from the lowest ground points of
    the pass before, so that parts removed from a bank or terrace are restored where they continue the surface.
    """
    cell, height = config.cell, config.height
    least = lowest(points, corner, cell, shape)
    whole = filled(least)
    low = objects(-whole, 1, config.low_slope, cell)
    blocks, reach, steepest = lowest_of_blocks(whole, low), max(1, radius // BLOCK), STEEPEST * BLOCK * cell
    around = slope_around(blocks, reach, config.slope, cell, steepest).repeat(BLOCK, axis=0).repeat(BLOCK, axis=1)
    around = np.pad(around[: shape[0], : shape[1]], radius, mode="edge")
    beyond = continued(whole, blocks, BLOCK, radius, reach, steepest)
    high = objects(beyond, radius, config.slope, cell, around, config.local_slope)[radius:-radius, radius:-radius]
    centred = heights_of_centres(points, corner, whole, cell)
    returned, contested = given_back(centred, high, cell, height, radius)
    taken = (high & ~returned) | low | np.isnan(least)
    surface = filled(whole if taken.all() else np.where(taken, np.float32(np.nan), least))
    ground = near_surface(points, corner, surface, cell, height, config.scaling)
    for _ in range(round(config.passes) - 1):
        if not ground.any():
            break
        surface = filled(lowest(points[ground], corner, cell, shape))
        ground = near_surface(points, corner, surface, cell, height, config.scaling)
    local = points - corner
    places = (local[:, 1] / cell).astype(int), (local[:, 0] / cell).astype(int)
    strict, lenient = (
        near_surface(points, corner, surface, cell, factor * height, factor * config.scaling) for factor in (0.5, 2.0)
    )
    unsure = (returned | contested)[places] | (lenient & ~strict)
    wide = max(cell, math.sqrt(shape[0] * cell * shape[1] * cell / len(points)))
    for _ in range(round(config.extensions)):
        new = continuing(local, ground, wide, height, PLANE_SHARE * cell)
        ground, unsure = ground | new, unsure | new
    return ground, surface, unsure
