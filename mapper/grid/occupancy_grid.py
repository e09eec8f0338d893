"""Occupancy grid: the geometry of its cells and the log-odds of each.

:class:`GridGeometry` is the only code of the project that converts between world coordinates and cells, and between
rows and image rows. A cell is ``floor((p − origin) / resolution)`` along the grid's own axes. Source:
nav_msgs/OccupancyGrid and MapMetaData (row 0 at the smallest y, origin = pose of the lower-left corner of cell (0, 0));
Thrun, Burgard & Fox, Probabilistic Robotics, section 9.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import transform_points
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice

TILE: Final = 64  #: cells along the side of a tile; growth keeps tile borders in place

FREE, UNKNOWN, OCCUPIED = 0, -1, 100  #: the three states, numbered as in nav_msgs/OccupancyGrid
OCCUPIED_THRESHOLD, FREE_THRESHOLD = (
    0.65,
    0.25,
)  #: p_occ above / below which a cell is occupied / free (map_server)


@lru_cache(maxsize=256)
def _direction(yaw: float) -> tuple[float, float]:
    return float(np.cos(yaw)), float(np.sin(yaw))


@dataclass(frozen=True, slots=True)
class GridGeometry:
    """A lattice of ``rows`` × ``cols`` square cells of ``resolution`` metres.

    ``origin`` is the pose (x, y, yaw) of the lower-left corner of cell (0, 0) in the map frame: metres, radians.
    Raises :class:`ConfigError` for a resolution that is not a positive finite number, sides below one cell or an
    origin that is not finite, and :class:`LimitError` for more cells than the limits allow.
    """

    resolution: float
    rows: int
    cols: int
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limits: Limits = field(default=DEFAULT_LIMITS, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.resolution) and self.resolution > 0.0):
            raise ConfigError(
                "grid.resolution",
                f"The resolution must be a positive number of metres, not {self.resolution!r}.",
            )
        if self.rows < 1 or self.cols < 1:
            raise ConfigError(
                "grid.size", f"A grid must be at least one cell wide and one cell high, not {self.size_text}."
            )
        if np.shape(self.origin) != (3,) or not np.all(np.isfinite(self.origin)):
            raise ConfigError("grid.origin", f"The origin must be three finite numbers, not {self.origin!r}.")
        if max(self.rows, self.cols) > self.limits.max_side or self.rows * self.cols > self.limits.max_cells:
            raise LimitError(
                "grid.too_large",
                f"A grid of {self.size_text} cells at {self.resolution:g} m is larger than the limit of "
                f"{self.limits.max_cells} cells and {self.limits.max_side} a side; choose a coarser resolution.",
            )

    @property
    def size_text(self) -> str:
        """Width × height in cells, as in map servers and image headers, for messages."""
        return f"{self.cols} × {self.rows}"

    @property
    def span_text(self) -> str:
        """Minimum and maximum x and y of the cells' centres in the map frame, metres, for messages."""
        corners = self.cell_to_world([[r, c] for r in (0, self.rows - 1) for c in (0, self.cols - 1)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        return f"goes from ({low[0]:g}, {low[1]:g}) to ({high[0]:g}, {high[1]:g}) m"

    @property
    def shape(self) -> tuple[int, int]:
        """``(rows, cols)``."""
        return (self.rows, self.cols)

    @classmethod
    def covering(
        cls, min_xy: ArrayLike, max_xy: ArrayLike, resolution: float, limits: Limits = DEFAULT_LIMITS
    ) -> GridGeometry:
        """Return an axis-aligned grid that contains the box ``min_xy`` … ``max_xy`` (2,), metres.

        Its origin is a multiple of a tile's side and its size is whole tiles, so the cells of two such grids of one
        resolution coincide wherever they overlap.
        """
        low, high = np.asarray(min_xy, dtype=np.float64), np.asarray(max_xy, dtype=np.float64)
        if low.shape != (2,) or high.shape != (2,) or not (np.isfinite(low).all() and np.isfinite(high).all()):
            raise ConfigError("grid.bounds", f"The bounds must be finite points, not {low!r} … {high!r}.")
        if not (np.isfinite(resolution) and resolution > 0.0):
            raise ConfigError(
                "grid.resolution", f"The resolution must be a positive number of metres, not {resolution!r}."
            )
        side = TILE * resolution
        first = np.floor(low / side)
        last = np.floor(high / side)
        counts = (last - first + 1.0) * TILE
        if not np.all(counts <= limits.max_side):
            raise LimitError(
                "grid.too_large",
                f"The box {low.tolist()} … {high.tolist()} at {resolution:g} m a cell is more than "
                f"{limits.max_side} cells a side; choose a coarser resolution.",
            )
        cols, rows = (int(n) for n in counts)
        return cls(resolution, rows, cols, (float(first[0] * side), float(first[1] * side), 0.0), limits)

    def to_lattice(self, points_xy: ArrayLike) -> NDArray[np.float64]:
        """Convert map points (..., 2) in metres to lattice coordinates (..., 2): (column, row), in cells, not floored.

        The centre of cell (row, col) has lattice coordinates (col + 0.5, row + 0.5).
        """
        p = np.asarray(points_xy, dtype=np.float64)
        out = np.empty(p.shape)
        out[..., 0], out[..., 1] = to_lattice(p[..., 0], p[..., 1], self.frame)
        return out

    @property
    def frame(self) -> Frame:
        """The lattice's pose in the map, in the form used by :func:`mapper.grid.kernels.lattice.to_lattice`."""
        x, y, yaw = self.origin
        return Frame(x, y, *_direction(yaw), self.resolution)

    def world_to_cell(self, points_xy: ArrayLike) -> NDArray[np.int64]:
        """Return the cells (..., 2), (row, col), that contain map points (..., 2); they may be outside the grid.

        Raises :class:`ConfigError` if a point is not finite.
        """
        lattice = self.to_lattice(points_xy)
        if not np.isfinite(lattice).all():
            raise ConfigError("grid.point", "A point that is not finite lies in no cell.")
        return np.asarray(cell_of(lattice[..., ::-1]), dtype=np.int64)

    def cell_to_world(self, cells_rc: ArrayLike) -> NDArray[np.float64]:
        """Return the centres (..., 2) in map metres of cells (..., 2), given as (row, col)."""
        rc = np.asarray(cells_rc, dtype=np.float64)
        return transform_points(self.origin, (rc[..., ::-1] + 0.5) * self.resolution)

    def contains(self, cells_rc: ArrayLike) -> NDArray[np.bool_]:
        """Return which of the cells (..., 2), given as (row, col), are in the grid."""
        rc = np.asarray(cells_rc)
        return np.asarray((rc[..., 0] >= 0) & (rc[..., 0] < self.rows) & (rc[..., 1] >= 0) & (rc[..., 1] < self.cols))

    def band(self, rows: slice) -> GridGeometry:
        """Return the geometry of the rows ``rows`` only, over all columns."""
        corner = self.cell_to_world((rows.start - 0.5, -0.5))
        return replace(self, rows=rows.stop - rows.start, origin=(float(corner[0]), float(corner[1]), self.origin[2]))

    @staticmethod
    def to_image(cells: NDArray[np.generic]) -> NDArray[np.generic]:
        """Flip (rows, cols, ...) between grid order (row 0 at the smallest y) and image order (top row first)."""
        return cells[::-1]

    def grown_to_include(self, min_xy: ArrayLike, max_xy: ArrayLike) -> tuple[GridGeometry, int, int]:
        """Return a geometry that also contains the box, and the number of rows and columns added before cell (0, 0).

        Existing cells do not move in the world. Growth is by whole tiles, at least a quarter of the current side in
        each direction that grows, so that an exploring robot causes few reallocations of the map.
        """
        (x0, y0), (x1, y1) = (np.asarray(corner, dtype=np.float64).tolist() for corner in (min_xy, max_xy))
        # Plain numbers, not arrays, because live robots call this for each scan.
        frame = self.frame
        lattice = [to_lattice(x, y, frame) for x in (x0, x1) for y in (y0, y1)]
        if not all(math.isfinite(value) for point in lattice for value in point):
            raise ConfigError("grid.point", "A point that is not finite lies in no cell.")
        columns, rows = zip(*lattice, strict=True)
        low, high = [math.floor(min(rows)), math.floor(min(columns))], [math.floor(max(rows)), math.floor(max(columns))]
        before, after = [0, 0], [0, 0]
        for axis, side in enumerate(self.shape):
            step = max(TILE, (side // 4 // TILE) * TILE)
            if low[axis] < 0:
                before[axis] = step * -(low[axis] // step)
            if high[axis] >= side:
                after[axis] = step * -(-(high[axis] - side + 1) // step)
        if not any(before) and not any(after):
            return self, 0, 0
        corner = transform_points(self.origin, np.array([-before[1], -before[0]]) * self.resolution)
        grown = replace(
            self,
            rows=self.rows + before[0] + after[0],
            cols=self.cols + before[1] + after[1],
            origin=(float(corner[0]), float(corner[1]), self.origin[2]),
        )
        return grown, before[0], before[1]


class OccupancyGrid:
    """Log-odds of "occupied" for each cell, and whether any beam has touched it.

    ``log_odds`` (rows, cols) float32 starts at the prior ℓ₀ (Probabilistic Robotics, table 4.2). ``observed`` (rows,
    cols) bool starts false, and distinguishes a cell that evidence returned to ℓ₀ from one never observed. ℓ₀ is the
    number ``log_odds_prior`` or, with ``prior_map`` (rows, cols) float32, each cell's value in it, NaN where it has
    none. Mapping continues from these values, and the cells of the prior map count as observed. ``cell_statistics`` (2,
    rows, cols) float32 is kept for models that are not a sum of log-odds: evidence for occupied and evidence for empty.
    ``log_odds`` is then computed from it, and cells added by growth start at ``statistics_prior``. Raises
    :class:`ConfigError` for a prior that is not finite.
    """

    __slots__ = (
        "cell_statistics",
        "geometry",
        "log_odds",
        "log_odds_prior",
        "observed",
        "prior_map",
        "statistics_prior",
    )

    def __init__(
        self, geometry: GridGeometry, log_odds_prior: float = 0.0, prior_map: NDArray[np.float32] | None = None
    ) -> None:
        if not np.isfinite(log_odds_prior):
            raise ConfigError("grid.prior", f"The prior must be a finite log-odds, not {log_odds_prior!r}.")
        if prior_map is not None and (prior_map.shape != geometry.shape or np.isinf(prior_map).any()):
            raise ConfigError(
                "grid.prior", f"A prior map must be {geometry.shape} finite log-odds, not {prior_map.shape}."
            )
        self.geometry = geometry
        self.log_odds_prior = float(log_odds_prior)
        self.prior_map = prior_map
        self.cell_statistics: NDArray[np.float32] | None = None
        self.statistics_prior = (0.0, 0.0)
        self.observed: NDArray[np.bool_] = (
            np.zeros(geometry.shape, dtype=np.bool_) if prior_map is None else ~np.isnan(prior_map)
        )
        self.log_odds: NDArray[np.float32] = self.prior()

    def __repr__(self) -> str:
        """Return size (width × height), resolution, origin and known cells in one line."""
        geometry = self.geometry
        origin = ", ".join(f"{value:g}" for value in geometry.origin)
        return (
            f"<OccupancyGrid {geometry.cols} × {geometry.rows} cells of {geometry.resolution:g} m, "
            f"origin ({origin}), {np.count_nonzero(self.observed)} known>"
        )

    def _repr_png_(self) -> bytes:
        """Return the PNG that notebooks show, at most 1024 pixels a side."""
        from mapper.grid.preview import preview_png  # noqa: PLC0415 - Pillow is loaded only for pictures

        return preview_png(self.log_odds, self.observed)

    def prior(self, part: tuple[slice, slice] = np.s_[:, :]) -> NDArray[np.float32]:
        """Return ℓ₀ of every cell (rows, cols), or of some rows and columns, as a new array."""
        rows, cols = (len(range(side)[cut]) for side, cut in zip(self.geometry.shape, part, strict=True))
        number = np.full((rows, cols), self.log_odds_prior, dtype=np.float32)
        if self.prior_map is None:
            return number
        known = self.prior_map[part]
        return np.where(np.isnan(known), number, known)

    def as_prior(self, log_odds_prior: float | None = None) -> OccupancyGrid:
        """Return a grid that starts from this one: its observed cells become the prior map."""
        known = np.where(self.observed, self.log_odds, np.float32(np.nan))
        number = self.log_odds_prior if log_odds_prior is None else log_odds_prior
        return OccupancyGrid(self.geometry, number, known)

    def emptied(self) -> OccupancyGrid:
        """Return a grid of the same geometry and prior without any scan."""
        return OccupancyGrid(self.geometry, self.log_odds_prior, self.prior_map)

    def with_statistic(self, index: int) -> OccupancyGrid:
        """Return a grid whose ``log_odds`` is one of the cell statistics; both share it and ``observed``."""
        if self.cell_statistics is None:
            raise ConfigError("grid.cell_statistics", "The grid has no cell statistics.")
        shared = object.__new__(OccupancyGrid)
        shared.geometry, shared.log_odds_prior, shared.prior_map = self.geometry, self.log_odds_prior, None
        shared.log_odds, shared.observed, shared.cell_statistics = self.cell_statistics[index], self.observed, None
        shared.statistics_prior = self.statistics_prior
        return shared

    def band(self, rows: slice) -> OccupancyGrid:
        """Return the rows ``rows`` as a grid that shares their log-odds and observed flags."""
        shared = object.__new__(OccupancyGrid)
        shared.geometry, shared.log_odds_prior, shared.prior_map = self.geometry.band(rows), self.log_odds_prior, None
        shared.log_odds, shared.observed, shared.cell_statistics = self.log_odds[rows], self.observed[rows], None
        shared.statistics_prior = self.statistics_prior
        return shared

    @property
    def p_occ(self) -> NDArray[np.float64]:
        """Probability that each cell is occupied (rows, cols): 1 − 1 / (1 + exp ℓ), Probabilistic Robotics (4.14)."""
        return probability(self.log_odds)

    def grow_to_include(self, min_xy: ArrayLike, max_xy: ArrayLike) -> bool:
        """Grow the grid to contain the box in map metres; return whether the geometry changed.

        Nothing moves in the world: old cells keep their values, new ones have the prior.
        """
        grown, row, col = self.geometry.grown_to_include(min_xy, max_xy)
        if grown is self.geometry:
            return False
        rows, cols = self.geometry.shape
        old = np.s_[..., row : row + rows, col : col + cols]
        log_odds = np.full(grown.shape, self.log_odds_prior, dtype=np.float32)
        observed = np.zeros(grown.shape, dtype=np.bool_)
        log_odds[old], observed[old] = self.log_odds, self.observed
        if self.prior_map is not None:
            prior_map = np.full(grown.shape, np.nan, dtype=np.float32)
            prior_map[old] = self.prior_map
            self.prior_map = prior_map
        if self.cell_statistics is not None:
            cell_statistics = np.empty((2, *grown.shape), dtype=np.float32)
            cell_statistics[0], cell_statistics[1] = self.statistics_prior
            cell_statistics[old] = self.cell_statistics
            self.cell_statistics = cell_statistics
        self.geometry, self.log_odds, self.observed = grown, log_odds, observed
        return True

    def classify(
        self, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
    ) -> NDArray[np.int8]:
        """Return the three-way state (rows, cols): 100 occupied, 0 free, −1 unknown.

        Occupied if p_occ > ``occupied_threshold``, free if p_occ < ``free_threshold``, unknown in between and if never
        observed. Source: map_server's trinary mode.
        """
        check_thresholds(occupied_threshold, free_threshold)
        state = np.full(self.geometry.shape, UNKNOWN, dtype=np.int8)
        # Compared in log-odds, as stored, which avoids an exponential for every cell.
        state[self.observed & (self.log_odds > log_odds(occupied_threshold))] = OCCUPIED
        state[self.observed & (self.log_odds < log_odds(free_threshold))] = FREE
        return state


def check_thresholds(occupied_threshold: float, free_threshold: float) -> None:
    """Raise :class:`ConfigError` unless 0 ≤ ``free_threshold`` ≤ ``occupied_threshold`` ≤ 1."""
    if not 0.0 <= free_threshold <= occupied_threshold <= 1.0:
        raise ConfigError(
            "grid.thresholds",
            f"Thresholds must satisfy 0 ≤ free ≤ occupied ≤ 1, not free {free_threshold!r} "
            f"and occupied {occupied_threshold!r}.",
        )


def probability(log_odds_value: ArrayLike) -> NDArray[np.float64]:
    """Return p for log-odds ℓ: p = 1 − 1 / (1 + exp ℓ). Any shape. Source: Probabilistic Robotics (4.14)."""
    value = np.asarray(log_odds_value, dtype=np.float64)
    # Both branches of the logistic, so that neither exponential overflows.
    small = np.exp(-np.abs(value))
    return np.asarray(np.where(value >= 0.0, 1.0 / (1.0 + small), small / (1.0 + small)), dtype=np.float64)


def log_odds(p: ArrayLike) -> NDArray[np.float64]:
    """Return ℓ = log(p / (1 − p)) for p in [0, 1]; 0 and 1 give ∓inf. Source: Probabilistic Robotics (4.13)."""
    value = np.asarray(p, dtype=np.float64)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(value) - np.log1p(-value), dtype=np.float64)
