"""SMRF in plain NumPy, step by step; the kernels must return the same.

Source: Pingel, Clarke & McBride, An improved simple morphological filter for the terrain classification of airborne
LIDAR data, ISPRS Journal of Photogrammetry and Remote Sensing 77, 2013. Empty cells are filled here by Laplace's
equation, where the authors use a spring metaphor; the discs grow by one cell at a time as theirs do.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray
from mapper.terrain.parameters import SWEEPS

Heights = NDArray[np.float32]


def lowest(points: NDArray[np.float64], corner: NDArray[np.float64], cell: float, shape: tuple[int, int]) -> Heights:
    """Return the height of the lowest point of each cell (rows, cols), metres above the corner; NaN where none is.

    ``points`` (n, 3) in metres; ``corner`` (3,) is the lowest corner of cell (0, 0).
    """
    heights = np.full(shape, np.nan, dtype=np.float32)
    for x, y, z in points - corner:
        row, col = int(y / cell), int(x / cell)
        heights[row, col] = np.fmin(heights[row, col], np.float32(z))
    return heights


def filled(heights: Heights) -> Heights:
    """Return ``heights`` (rows, cols) with each NaN replaced by about the mean of its four neighbours.

    Laplace's equation from coarse to fine: the half-sized grid of the means of known cells is filled first, gives its
    values to the unknown cells, and those are then smoothed by Jacobi sweeps. At least one cell is known.
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
    """Return the least height within ``radius`` cells of each cell; cells outside the grid are left out."""
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
    """Return the morphological opening by a disc: bumps that are narrower than it are cut off."""
    return -eroded(-eroded(heights, radius), radius)


def objects(heights: Heights, radius: int, slope: float, cell: float) -> BoolArray:
    """Return the cells (rows, cols) of objects: those that an opening lowers by more than ``slope`` · r · ``cell``.

    The disc grows from r = 1 to ``radius`` cells, and each opening is made of the one before.
    """
    found = np.zeros(heights.shape, dtype=np.bool_)
    before = heights
    for r in range(1, radius + 1):
        after = opened(before, r)
        found |= before - after > np.float32(slope * r * cell)
        before = after
    return found


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
    """Return the bilinear value of a surface at (``x``, ``y``) in cells; the border goes on as it is."""
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


def ground_points(
    points: NDArray[np.float64],
    corner: NDArray[np.float64],
    shape: tuple[int, int],
    cell: float,
    slope: float,
    radius: int,
    height: float,
    scaling: float,
    low_slope: float,
    passes: int,
) -> tuple[BoolArray, Heights]:
    """Return which points (n,) are ground, and the surface (rows, cols) of the ground in metres above the corner.

    Each pass after the first makes the surface of the lowest ground points of the pass before: what the discs cut off
    a bank or a terrace comes back where it continues the surface.
    """
    least = lowest(points, corner, cell, shape)
    whole = filled(least)
    taken = objects(-whole, 1, low_slope, cell) | objects(whole, radius, slope, cell) | np.isnan(least)
    known = np.where(taken, np.float32(np.nan), least)
    surface = filled(whole if np.isnan(known).all() else known)
    ground = near_surface(points, corner, surface, cell, height, scaling)
    for _ in range(passes - 1):
        if not ground.any():
            break
        surface = filled(lowest(points[ground], corner, cell, shape))
        ground = near_surface(points, corner, surface, cell, height, scaling)
    return ground, surface
