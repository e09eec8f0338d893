"""Ground points of a cloud by SMRF, the simple morphological filter, with steps that check the removed cells.

Sources: Pingel, Clarke & McBride, An improved simple morphological filter for the terrain classification of airborne
LIDAR data, ISPRS Journal of Photogrammetry and Remote Sensing 77, 2013. Segments classified by their sides: Sithole &
Vosselman, Filtering of airborne laser scanner data based on segmented point clouds, 2005. Points that continue the
ground: Axelsson, DEM generation from laser scanner data using adaptive TIN models, 2000, here with planes in place of
triangles.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float32Array, Float64Array
from mapper.core.errors import ConfigError, LimitError
from mapper.terrain.kernels import extension
from mapper.terrain.kernels import ground as kernels
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

MAX_CELLS = 1 << 22  #: of the filter's grid: 16 MB for each of its float32 arrays
MAX_WORK = 1 << 34  #: cells of the grid times rows of all discs, to which the time is proportional


@dataclass(frozen=True, slots=True)
class Ground:
    """``is_ground`` (n,) for each point in the cloud's order, False for points that are not finite.

    ``is_unsure`` (n,) marks points that may be misclassified: the steps of the filter disagree, or the distance from
    the surface is near the limit. ``surface`` (rows, cols) float32 are the heights of the ground at the centres of
    cells of ``cell`` metres, above ``corner`` (3,), the lowest corner of the cloud and the corner of cell (0, 0).
    ``left_out`` counts points that are not finite.
    """

    is_ground: BoolArray
    is_unsure: BoolArray
    surface: Float32Array
    corner: Float64Array
    cell: float
    left_out: int


def find_ground(
    points: NDArray[np.floating[Any]],
    config: GroundConfig | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Ground:
    """Classify which of the ``points`` (n, 3), metres with z up, are ground.

    ``progress`` is called with the fraction of the work done, 0 to 1, after each disc, and may raise to cancel the
    work. Raises :class:`ConfigError` for another shape and for a cloud without finite points, :class:`LimitError` for
    one that is too wide for the cells.
    """
    config = config or GroundConfig()
    finite, used = finite_points(points)
    corner = used.min(axis=0)
    extent = (used.max(axis=0) - corner)[:2]
    cells = np.floor(extent / config.cell) + 1.0
    if cells.prod() > MAX_CELLS:
        raise LimitError(
            "terrain.too_wide",
            f"A cloud of {extent[0]:g} × {extent[1]:g} m has more than {MAX_CELLS} cells of {config.cell:g} m; "
            "choose larger cells, or leave out points that are far from the others.",
        )
    shape = int(cells[1]), int(cells[0])
    radius = min(math.ceil(config.window / config.cell), max(shape))
    if (shape[0] + 2 * radius) * (shape[1] + 2 * radius) * radius * radius > MAX_WORK:
        raise LimitError(
            "terrain.window",
            f"Discs of up to {radius} cells on {shape[1]} × {shape[0]} cells are more than the limit; "
            "choose larger cells or a smaller window.",
        )
    ground, surface, unsure = _filter(used, corner, shape, radius, config, progress or _no_progress)
    is_ground, is_unsure = np.zeros(len(points), dtype=np.bool_), np.zeros(len(points), dtype=np.bool_)
    is_ground[finite], is_unsure[finite] = ground, unsure
    return Ground(is_ground, is_unsure, surface, corner, config.cell, int(len(points) - len(used)))


def finite_points(points: NDArray[np.floating[Any]]) -> tuple[BoolArray, Float64Array]:
    """Return which points (n,) are finite, and these as (m, 3) float64.

    Raises :class:`ConfigError` for another shape than (n, 3) and if none is finite.
    """
    if points.ndim != 2 or points.shape[1] != 3:
        raise ConfigError("terrain.shape", f"Points must have shape (n, 3), not {points.shape}.")
    finite = np.asarray(np.isfinite(points).all(axis=1))
    if not finite.any():
        raise ConfigError("terrain.empty", "The cloud has no finite points, so it has no terrain.")
    used = points if finite.all() else points[finite]
    return finite, np.ascontiguousarray(used, dtype=np.float64)


def agreement(is_ground: BoolArray, truth: BoolArray) -> dict[str, float]:
    """Return the agreement of two classifications (n,), in percent: Cohen's kappa, total error, type I and type II
    errors.

    Type I is ground classified as object, relative to all ground; type II is object classified as ground, relative to
    all objects. Source: Sithole & Vosselman, Experimental comparison of filter algorithms for bare-Earth extraction,
    2004.
    """
    n = len(truth)
    both, neither = int((is_ground & truth).sum()), int((~is_ground & ~truth).sum())
    first, second = int((~is_ground & truth).sum()), int((is_ground & ~truth).sum())
    right = (both + neither) / n
    chance = ((both + first) * (both + second) + (neither + second) * (neither + first)) / (n * n)
    return {
        "kappa": 100.0 * (right - chance) / (1.0 - chance) if chance < 1.0 else 100.0,
        "total_error": 100.0 * (first + second) / n,
        "type_1": 100.0 * first / max(both + first, 1),
        "type_2": 100.0 * second / max(neither + second, 1),
    }


def filled(heights: Float32Array) -> Float32Array:
    """Return ``heights`` (rows, cols), at least one of which is known, with NaN filled by Laplace's equation."""
    if not np.isnan(heights).any():
        return heights.copy()
    rows, cols = heights.shape
    half = np.empty((-(-rows // 2), -(-cols // 2)), dtype=np.float32)
    kernels.halve(heights, half)
    out, other = np.empty_like(heights), np.empty_like(heights)
    kernels.smooth_unknown(heights, filled(half), SWEEPS, other, out)
    return out


def _no_progress(_: float) -> None:
    pass


def objects(
    heights: Float32Array,
    radius: int,
    slope: float,
    cell: float,
    around: Float32Array | None = None,
    share: float = 0.0,
    margin: int = 0,
    progress: Callable[[float], None] = _no_progress,
) -> BoolArray:
    """Return the cells (rows, cols) that openings by discs of 1 … ``radius`` cells lower by more than the slope allows.

    The threshold of each disc is ``share`` · ``cell`` higher where the slope ``around`` is 1. ``heights`` and
    ``around`` are padded by ``margin`` cells at each border, into which discs extend.
    """
    is_object: BoolArray = np.zeros(heights.shape, dtype=np.bool_)
    more = np.zeros_like(heights) if around is None else around
    runs = np.empty((2, *heights.shape), dtype=np.float32)
    before, eroded, after = heights.copy(), np.empty_like(heights), np.empty_like(heights)
    for r in range(1, radius + 1):
        kernels.erode(before, r, 1.0, runs, eroded)
        kernels.erode(eroded, r, -1.0, runs, after)
        kernels.mark_lowered(before, after, slope * r * cell, more, share * cell, is_object)
        before, after = after, before
        progress(r / radius)
    return is_object[margin : is_object.shape[0] - margin, margin : is_object.shape[1] - margin].copy()


def lowest_of_blocks(heights: Float32Array, left_out: BoolArray) -> Float32Array:
    """Return the minimum height of each block, ignoring ``left_out`` (rows, cols) cells; empty blocks are filled."""
    rows, cols = heights.shape
    lowest = np.empty((-(-rows // BLOCK), -(-cols // BLOCK)), dtype=np.float32)
    kernels.lowest_of_blocks(heights, left_out, BLOCK, lowest)
    return heights[::BLOCK, ::BLOCK].copy() if np.isnan(lowest).all() else filled(lowest)


def border_lines(lowest: Float32Array, reach: int, steepest: float) -> list[tuple[Float32Array, Float32Array]]:
    """Return the continuation of the ground beyond each of four borders: heights of the outermost blocks and outward
    rises.

    The rise between blocks is the median of those between each two of the ``reach`` + 1 ``lowest`` heights from the
    border inwards, of all within ``reach`` blocks along it (Theil 1950, Sen 1968), limited to 0 … ``steepest`` metres.
    The height is that of the lowest line with this rise, so that buildings at the border are not continued. Border k is
    before row 0 of the grid rotated k times by :func:`numpy.rot90`.
    """
    return [_border_line(np.rot90(lowest, turn), reach, steepest) for turn in range(4)]


def _border_line(lowest: Float32Array, reach: int, steepest: float) -> tuple[Float32Array, Float32Array]:
    depth = min(reach, lowest.shape[0] - 1)
    if depth == 0:
        return lowest[0], np.zeros_like(lowest[0])
    pairs = [(lowest[i] - lowest[j]) / np.float32(j - i) for j in range(depth + 1) for i in range(j)]
    along = np.pad(np.array(pairs), ((0, 0), (reach, reach)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(along, 2 * reach + 1, axis=1)
    rise = np.clip(np.median(windows, axis=(0, 2)), np.float32(0.0), np.float32(steepest))
    return (lowest[: depth + 1] + rise * np.arange(depth + 1, dtype=np.float32)[:, None]).min(axis=0), rise


def continued(
    heights: Float32Array, lines: list[tuple[Float32Array, Float32Array]], block: int, width: int
) -> Float32Array:
    """Return ``heights`` (rows, cols) padded by ``width`` cells at each border, over which the ground is continued.

    Otherwise discs clipped at the border would lower the upper border of a slope like an object. ``lines`` are those of
    :func:`border_lines` for blocks of ``block`` × ``block`` cells.
    """
    rows, cols = heights.shape
    out = np.empty((rows + 2 * width, cols + 2 * width), dtype=np.float32)
    out[width : width + rows, width : width + cols] = heights
    for turn, (base, rise) in enumerate(lines):
        beyond = np.rot90(out, turn)
        inside = slice(width, beyond.shape[1] - width)
        places = (np.arange(beyond.shape[1] - 2 * width) + 0.5) / block - 0.5
        first, per_block = (np.interp(places, np.arange(len(base)), values) for values in (base, rise))
        # The lowest cell of a block on a slope is the one farthest from an upper border.
        beyond[:width, inside] = first + per_block / block * (np.arange(width, 0, -1)[:, None] + (block - 1.0))
    for turn in range(4):
        corner = np.rot90(out, turn)
        corner[:width, :width] = np.maximum(corner[:width, width, None], corner[width, :width])
    return out


def slope_around(
    lowest: Float32Array, lines: list[tuple[Float32Array, Float32Array]], reach: int, slope: float, side: float
) -> Float32Array:
    """Return the mean slope of the ground within ``reach`` blocks of each block (rows, cols).

    It is that of the ``lowest`` heights of blocks of ``side`` metres after discs of up to ``reach`` blocks have removed
    the objects. ``lines`` are the continuation beyond the borders.
    """
    taken = objects(continued(lowest, lines, 1, reach), reach, slope, side, margin=reach)
    surface = lowest if taken.all() else filled(np.where(taken, np.float32(np.nan), lowest))
    steep, mean = np.empty_like(lowest), np.empty_like(lowest)
    kernels.slope_of_surface(surface, side, steep)
    kernels.mean_around(steep, reach, STEEPEST, mean)
    return mean


def heights_of_centres(points: Float64Array, heights: Float32Array, corner: Float64Array, cell: float) -> Float32Array:
    """Return ``heights`` (rows, cols) of the cells' lowest points, moved along the slope to the cells' centres.

    On a slope of 45° a point in a cell of 1 m is up to half a metre higher or lower than the centre.
    """
    lowest, moved = np.empty(heights.shape, dtype=np.int32), np.empty_like(heights)
    extension.lowest_ground(points, np.ones(len(points), dtype=np.bool_), corner, cell, lowest)
    kernels.move_to_centres(points, lowest, heights, corner, cell, moved)
    return filled(moved)


def given_back(
    heights: Float32Array, taken: BoolArray, cell: float, height: float, front: int
) -> tuple[BoolArray, BoolArray]:
    """Return which ``taken`` cells (rows, cols) are ground after all, and which others are in doubt.

    Connected taken cells with a continuous surface form a segment. It is ground if the number of its sides that
    continue into the ground is not small compared with those that are drops: crests and edges of terraces, as opposed
    to roofs and bridges. It is also ground if it continues into the ground over a front of ``front`` cells, the length
    of the vector sum of the directions of these sides: spurs with drops on all other sides. (At the two ends of a
    bridge the directions are opposite.) In doubt are the other segments that continue into the ground somewhere.
    """
    parents = np.empty(heights.size, dtype=np.int32)
    sides = np.empty((heights.size, 4), dtype=np.int32)
    returned, contested = np.empty_like(taken), np.empty_like(taken)
    limits = STEEPEST * cell, height, RISE_SHARE
    kernels.join_cells(heights, taken, *limits, parents)
    kernels.count_sides(heights, taken, *limits, parents, sides)
    kernels.judge(taken, parents, sides, LEAST_INTO, front, returned, contested)
    return returned, contested


def extended(
    points: Float64Array,
    ground: BoolArray,
    corner: Float64Array,
    shape: tuple[int, int],
    cell: float,
    height: float,
    share: float,
    times: int,
) -> BoolArray:
    """Return which points (n,) are ground after adding those on the plane of the adjacent ground.

    Points may be off the plane by ``height`` + ``share`` · slope, metres, and are added ``times`` times. Cells (rows,
    cols) of ``cell`` metres contain at least one point on average.
    """
    ground, new = ground.copy(), np.empty(len(points), dtype=np.bool_)
    lowest, near = np.empty(shape, dtype=np.int32), np.ones(shape, dtype=np.bool_)
    sums = np.zeros((shape[0] + 1, shape[1] + 1), dtype=np.int64)
    limits = PLANE_REACH, PLANE_POINTS, STEEPEST, height, share
    for _ in range(times):
        extension.lowest_ground(points, ground, corner, cell, lowest)
        np.cumsum(np.cumsum(lowest >= 0, axis=0, dtype=np.int64), axis=1, out=sums[1:, 1:])
        extension.extend(points, ground, corner, cell, lowest, sums, near, *limits, new)
        if not new.any():
            break
        ground |= new
        extension.mark_near(points, new, corner, cell, PLANE_REACH, near)
    return ground


def _filter(
    points: Float64Array,
    corner: Float64Array,
    shape: tuple[int, int],
    radius: int,
    config: GroundConfig,
    progress: Callable[[float], None],
) -> tuple[BoolArray, Float32Array, BoolArray]:
    cell, passes = config.cell, round(config.passes)
    ground, unsure = np.ones(len(points), dtype=np.bool_), np.empty(len(points), dtype=np.bool_)
    least, steep = np.empty(shape, dtype=np.float32), np.empty(shape, dtype=np.float32)
    kernels.lowest_of_cells(points, ground, corner, cell, least)
    whole = filled(least)
    progress(0.1)
    low = objects(-whole, 1, config.low_slope, cell)
    lowest, reach = lowest_of_blocks(whole, low), max(1, radius // BLOCK)
    lines = border_lines(lowest, reach, STEEPEST * BLOCK * cell)
    around = slope_around(lowest, lines, reach, config.slope, BLOCK * cell)
    around = around.repeat(BLOCK, axis=0).repeat(BLOCK, axis=1)[: shape[0], : shape[1]]
    high = objects(
        continued(whole, lines, BLOCK, radius),
        radius,
        config.slope,
        cell,
        np.pad(around, radius, mode="edge"),
        config.local_slope,
        radius,
        lambda share: progress(0.1 + 0.5 * share),
    )
    centred = heights_of_centres(points, whole, corner, cell)
    returned, contested = given_back(centred, high, cell, config.height, radius)
    doubtful = returned | contested
    known = np.where((high & ~returned) | low, np.float32(np.nan), least)
    surface = filled(whole if np.isnan(known).all() else known)
    for i in range(passes):
        if i > 0:
            if not ground.any():
                break
            kernels.lowest_of_cells(points, ground, corner, cell, least)
            surface = filled(least)
        kernels.slope_of_surface(surface, cell, steep)
        kernels.classify(points, corner, surface, steep, doubtful, cell, config.height, config.scaling, ground, unsure)
        progress(0.7 + 0.2 * (i + 1) / passes)
    extents = shape[1] * cell, shape[0] * cell
    wide = max(cell, math.sqrt(extents[0] * extents[1] / len(points)))
    wide_shape = math.ceil(extents[1] / wide), math.ceil(extents[0] / wide)
    limits = config.height, PLANE_SHARE * cell
    whole_ground = extended(points, ground, corner, wide_shape, wide, *limits, round(config.extensions))
    progress(1.0)
    return whole_ground, surface, unsure | (whole_ground & ~ground)
