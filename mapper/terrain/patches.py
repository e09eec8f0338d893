"""Patches of terrain on a grid: moments, planes, classes, points, and costs for a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float64Array, Int64Array, UInt8Array
from mapper.core.errors import ConfigError, LimitError
from mapper.costmap import FREE, INSCRIBED, LETHAL, NO_INFORMATION, GivenLayer
from mapper.grid.occupancy_grid import GridGeometry, OccupancyGrid
from mapper.terrain.ground import finite_points
from mapper.terrain.kernels import patches as kernels
from mapper.terrain.parameters import PatchConfig

MAX_PATCHES = 1 << 20  #: 80 MB of moments, and as much for the summed-area table
CERTAIN = 5.0  #: log-odds of a class in a map
UNKNOWN, SAFE, UNSAFE = 0, 1, 2  #: the classes of patches


@dataclass(frozen=True, slots=True)
class Patches:
    """Moments (rows, cols, 10) float64 of square patches of ``size`` metres, each about the centre of its patch.

    The entries are n, x, y, z, xx, xy, yy, xz, yz, zz: those of P, the sum of v vᵀ with v = [1 x y z]. ``corner`` (3,)
    is the lowest corner of patch (0, 0); heights are above it.
    """

    moments: Float64Array
    size: float
    corner: Float64Array

    @classmethod
    def of(cls, points: NDArray[np.floating[Any]], size: float) -> Patches:
        """Return the patches that contain the finite ``points`` (n, 3), metres with z up.

        Raises :class:`ConfigError` if none is finite, :class:`LimitError` for more than 2²⁰ patches.
        """
        _, used = finite_points(points)
        corner = used.min(axis=0)
        extent = (used.max(axis=0) - corner)[:2]
        sides = np.floor(extent * (1.0 / size)) + 1.0
        if sides.prod() > MAX_PATCHES:
            raise LimitError(
                "terrain.too_wide",
                f"A cloud of {extent[0]:g} × {extent[1]:g} m has more than {MAX_PATCHES} patches of {size:g} m; "
                "choose larger patches, or leave out points that are far from the others.",
            )
        return cls(np.zeros((int(sides[1]), int(sides[0]), 10)), size, corner).with_points(used)

    def with_points(self, points: NDArray[np.floating[Any]]) -> Patches:
        """Return the patches with points (n, 3) added, all finite; those outside the grid are ignored."""
        moments = self.moments.copy()
        kernels.add_points(np.ascontiguousarray(points, dtype=np.float64), self.corner, self.size, moments)
        return Patches(moments, self.size, self.corner)

    def emptied(self) -> Patches:
        """Return the same patches without points."""
        return Patches(np.zeros_like(self.moments), self.size, self.corner)

    def parents(self) -> Patches:
        """Return the next level of the quadtree: patches of twice the size, the sums of their children."""
        rows, cols, _ = self.moments.shape
        moments = np.zeros((-(-rows // 2), -(-cols // 2), 10))
        kernels.halve(self.moments, self.size, moments)
        return Patches(moments, 2.0 * self.size, self.corner)

    def summed_areas(self) -> Float64Array:
        """Return the summed-area table (rows + 1, cols + 1, 10), from which :meth:`planes` fits windows of any size."""
        rows, cols, _ = self.moments.shape
        table = np.empty((rows + 1, cols + 1, 10))
        kernels.sum_areas(self.moments, self.size, table)
        return table

    def planes(self, reach: int = 0, min_points: int = 3, table: Float64Array | None = None) -> Float64Array:
        """Return the planes (rows, cols, 6) of the windows of 2 · ``reach`` + 1 patches per side around each patch.

        They are a, b, c of z = a + b·x + c·y about the patch's centre, the mean height, the roughness (m) and the slope
        (radians); NaN for fewer than ``min_points`` points or collinear points. ``table`` is that of
        :meth:`summed_areas`, to be reused for several windows of one cloud. Raises :class:`ConfigError` for a negative
        reach.
        """
        if reach < 0 or min_points < 3:
            raise ConfigError(
                "terrain.window", "A window must reach at least 0 patches, and a plane needs at least 3 points."
            )
        out = np.empty((*self.moments.shape[:2], 6))
        areas = self.summed_areas() if table is None else table
        kernels.fit_windows(areas, self.size, min(reach, max(out.shape[:2])), min_points, out)
        return out

    def steps(self, planes: Float64Array) -> Float64Array:
        """Return the maximum gap (rows, cols), m, between each plane and its neighbours; NaN without a plane."""
        out = np.empty(planes.shape[:2])
        kernels.steps_between(planes, self.size, out)
        return out

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the grid of patches in the map's frame."""
        rows, cols, _ = self.moments.shape
        return GridGeometry(self.size, rows, cols, (float(self.corner[0]), float(self.corner[1]), 0.0))


@dataclass(frozen=True, slots=True)
class Terrain:
    """``score`` (rows, cols) of each patch, unsafe above 1 and NaN if unknown, and its components.

    ``classes`` (rows, cols) uint8 are UNKNOWN, SAFE and UNSAFE.
    """

    patches: Patches
    config: PatchConfig
    planes: Float64Array
    steps: Float64Array
    score: Float64Array
    classes: UInt8Array

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the grid of patches in the map's frame."""
        return self.patches.geometry

    def costs(self) -> UInt8Array:
        """Return costs (rows, cols): 252 times the score, 254 for unsafe patches, 255 for unknown ones."""
        scaled = np.nan_to_num(self.score, nan=0.0, posinf=1.0).clip(0.0, 1.0) * (INSCRIBED - 1)
        costs = np.where(self.classes == SAFE, scaled.astype(np.uint8), np.uint8(FREE))
        costs[self.classes == UNSAFE] = LETHAL
        costs[self.classes == UNKNOWN] = NO_INFORMATION
        return costs

    def counts(self) -> dict[str, int]:
        """Return the number of patches of each class."""
        n = np.bincount(self.classes.ravel(), minlength=3)
        return {"safe": int(n[SAFE]), "unsafe": int(n[UNSAFE]), "unknown": int(n[UNKNOWN])}

    def grid(self) -> OccupancyGrid:
        """Return the classes as a map: safe patches are free, unsafe ones occupied."""
        grid = OccupancyGrid(self.patches.geometry)
        grid.observed[:] = self.classes != UNKNOWN
        grid.log_odds[:] = np.array([0.0, -CERTAIN, CERTAIN], dtype=np.float32)[self.classes]
        return grid

    def why(self, row: int, col: int) -> str:
        """Return one sentence on why a patch has its class."""
        name = ("unknown", "safe", "unsafe")[int(self.classes[row, col])]
        if np.isnan(self.score[row, col]):
            n = int(self.patches.moments[row, col, 0])
            return f"Terrain: {name}; {n} ground points here give no plane."
        slope, roughness = np.degrees(self.planes[row, col, 5]), self.planes[row, col, 4]
        return (
            f"Terrain: {name}; slope {slope:.1f}°, roughness {roughness:.3f} m, step {self.steps[row, col]:.3f} m, "
            f"score {self.score[row, col]:.2f}."
        )

    def layer(self, name: str = "terrain") -> GivenLayer:
        """Return a layer of a costmap with these costs, on the geometry of the patches."""
        layer = GivenLayer(self.patches.geometry, name, self.why)
        layer.set(self.costs())
        return layer


def assess(
    patches: Patches, config: PatchConfig | None = None, *, occupied: Patches | None = None, reach: int = 0
) -> Terrain:
    """Classify ``patches`` of ground points by the config's rule for slope, roughness and step.

    ``occupied`` are the same patches with all points: a patch with points but no ground is unsafe. The plane of a patch
    is that of the window of ``reach`` patches around it, see :meth:`Patches.planes`. Raises :class:`ConfigError` for
    patches of another grid and for a negative reach.
    """
    config = config or PatchConfig()
    if occupied is not None and occupied.moments.shape != patches.moments.shape:
        raise ConfigError("terrain.shape", "The patches with all points must be those of the ground’s grid.")
    planes = patches.planes(reach, round(config.min_points))
    steps = patches.steps(planes)
    terms = (
        config.slope_weight * (planes[..., 5] / np.radians(config.max_slope)),
        config.roughness_weight * (planes[..., 4] / config.max_roughness),
        config.step_weight * (steps / config.max_step),
    )
    score = np.maximum.reduce(terms) if config.rule == "thresholds" else terms[0] + terms[1] + terms[2]
    classes = np.where(np.isnan(score), UNKNOWN, np.where(score > 1.0, UNSAFE, SAFE)).astype(np.uint8)
    if occupied is not None:
        classes[(patches.moments[..., 0] == 0.0) & (occupied.moments[..., 0] > 0.0)] = UNSAFE
    return Terrain(patches, config, planes, steps, score, classes)


#: Number of three-point planes tried for each patch. With half of the points outliers, no plane passes through three
#: inliers for two of a million patches: (1 − 1/8)¹⁰⁰.
TRIALS = 100


def agreeing(points: NDArray[np.floating[Any]], patches: Patches, distance: float) -> BoolArray:
    """Return which of ``points`` (n, 3), m, are within ``distance``, m along z, of their patch's consensus plane.

    The patches are those of the grid of ``patches``; its moments are not used. Points outside the grid, and those of a
    patch in which no three points define a plane, are not included. Source: Fischler & Bolles, Random Sample Consensus,
    1981; the triples are those of :func:`mapper.terrain.textbook.triples_of`.
    """
    rows, cols, _ = patches.moments.shape
    local = np.asarray(points, dtype=np.float64) - patches.corner
    places = np.floor(local[:, :2] * (1.0 / patches.size))
    inside = ((places >= 0) & (places < (cols, rows))).all(axis=1)
    rows_inside = np.flatnonzero(inside)
    at = places[rows_inside].astype(np.int64)
    patch = at[:, 1] * cols + at[:, 0]
    order = np.argsort(patch, kind="stable")
    in_order = local[rows_inside[order]]
    # About the patch's centre, because planes of points far from 0 lose precision.
    in_order[:, :2] -= (at[order] + 0.5) * patches.size
    starts = np.concatenate([[0], np.cumsum(np.bincount(patch, minlength=rows * cols))]).astype(np.int64)
    agrees = np.empty(len(rows_inside), dtype=np.bool_)
    kernels.consensus(in_order, starts, TRIALS, distance, agrees)
    out = np.zeros(len(local), dtype=np.bool_)
    out[rows_inside[order]] = agrees
    return out


def fitted(points: NDArray[np.floating[Any]], patches: Patches, config: PatchConfig) -> BoolArray:
    """Return which of ``points`` (n, 3) are used for the planes of ``patches``: all, or those selected by RANSAC."""
    if config.fit == "ransac":
        return agreeing(points, patches, config.fit_distance)
    return np.ones(len(points), dtype=np.bool_)


class PointIndex:
    """Points (n, 3) sorted by patch on the first query; for 2 million points that takes a tenth of a second.

    Points outside the patches are ignored.
    """

    def __init__(self, points: NDArray[np.floating[Any]], patches: Patches) -> None:
        self._points, self._patches = points, patches
        self._order: Int64Array | None = None
        self._starts = np.zeros(1, dtype=np.int64)  # start of each patch in the order, row by row, and the end

    def window(self, row: int, col: int, reach: int = 0) -> Int64Array:
        """Return the indices (m,), ascending, of the points in the 2 · ``reach`` + 1 patches per side around a
        patch.
        """
        order = self._sorted()
        rows, cols, _ = self._patches.moments.shape
        left, right = max(col - reach, 0), min(col + reach + 1, cols)
        starts = self._starts
        sides = [
            order[starts[r * cols + left] : starts[r * cols + right]]
            for r in range(max(row - reach, 0), min(row + reach + 1, rows))
            if left < right
        ]
        return np.sort(np.concatenate(sides)) if sides else np.empty(0, dtype=np.int64)

    def _sorted(self) -> Int64Array:
        if self._order is None:
            patches = self._patches
            rows, cols, _ = patches.moments.shape
            places = np.floor((self._points[:, :2] - patches.corner[:2]) * (1.0 / patches.size))
            inside = np.flatnonzero(((places >= 0) & (places < (cols, rows))).all(axis=1))
            col, row = places[inside].astype(np.min_scalar_type(max(rows, cols))).T
            # NumPy sorts 16-bit integers in linear time.
            self._order = inside[np.lexsort((col, row))]
            counts = np.bincount(row.astype(np.int64) * cols + col, minlength=rows * cols)
            self._starts = np.concatenate([[0], np.cumsum(counts)])
        return self._order
