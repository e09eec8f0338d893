"""Terrain of points: patches, their classes, the ground filter compared with the truth, and the resulting costs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float32Array, Float64Array
from mapper.core.errors import LimitError
from mapper.core.parameter import Parameter, check_names
from mapper.costmap import CostmapConfig, Footprint, InflationConfig, InflationLayer, LayeredCostmap
from mapper.grid import OccupancyGrid
from mapper.simulation.robot import HEXAGON
from mapper.terrain import (
    GROUND_PARAMETERS,
    PATCH_PARAMETERS,
    GroundConfig,
    PatchConfig,
    Patches,
    PointIndex,
    Terrain,
    agreement,
    assess,
    find_ground,
    fitted,
)

MOST_PATCHES = 250_000
FIRST_POINTS, FIRST_SHARE = 10, 0.75  #: initially, this share of the points is in patches with at least this many
SIDES = tuple(m * 10.0**e for e in range(-2, 4) for m in (1, 1.5, 2, 3, 4, 5, 7))  #: metres: initial sides of patches
FINEST = 0.2  #: metres: size of the area under a robot; for a small cloud, a twentieth of its longer side
LEAST_ACROSS = 10  #: initial number of patches along the longer side of a cloud
LARGEST_INDOORS = 0.3  #: metres: largest patch side of clouds whose cells and discs are those for rooms
SHOWN = ("costs", "costmap", "slope", "roughness", "step", "unsure")
MOST_UNSURE = 0.5  #: share of a patch's points at which it is shown darkest
#: In rooms, cells, discs and patches are smaller than outdoors.
_INDOORS = {
    "cell": 0.15, "window": 2.0, "height": 0.06, "scaling": 0.1, "slope": 0.3,
    "patch": 0.25, "min_points": 6.0, "max_step": 0.1, "max_roughness": 0.05,
}  # fmt: skip


def _label(row: Parameter) -> Parameter:
    label = row.label[:1].upper() + row.label[1:]
    return replace(row, label=label, group="terrain_" + row.group, initial=_INDOORS.get(row.name, row.initial))


TABLE: tuple[Parameter, ...] = (
    Parameter(
        "shown", "Over the map", "terrain_view", "choice", "costs",
        "Costs of the classes, the costmap with inflation, or one property of the patches, from light to dark; unsure: "
        "the share of points that the ground filter may have wrong.",
        choices=SHOWN,
    ),
    *(_label(row) for row in PATCH_PARAMETERS),
    Parameter(
        "level", "Level of the quadtree", "terrain_patches", "number", 0.0,
        "Each level joins four patches to one; their moments are added.", low=0.0, high=4.0, step=1.0,
    ),
    Parameter(
        "reach", "Window", "terrain_patches", "number", 0.0,
        "Planes are fitted to windows that reach this many patches to each side; 0: to each patch by itself.",
        low=0.0, high=8.0, step=1.0,
    ),
    Parameter(
        "filter", "Ground filter", "terrain_ground", "flag", True,
        "Whether SMRF removes the points of objects before planes are fitted.",
    ),
    *(_label(row) for row in GROUND_PARAMETERS),
)  # fmt: skip
_ROWS = {row.name: row for row in TABLE}
_GROUND = frozenset(row.name for row in GROUND_PARAMETERS)
_PATCH = frozenset(row.name for row in PATCH_PARAMETERS)


@dataclass(frozen=True, slots=True)
class TerrainParameters:
    """The current values. Raises :class:`ConfigError` if the table rejects them."""

    values: Mapping[str, Any] = field(default_factory=lambda: {row.name: row.initial for row in TABLE})

    @classmethod
    def for_cloud(cls, points: Float64Array) -> TerrainParameters:
        """Return initial values for a cloud (n, 3): patches by its density, the rest for indoors if these are small."""
        row = _ROWS["patch"]
        patch = min(max(first_patch(points[:, :2]), row.low), row.high)
        if patch <= LARGEST_INDOORS:
            return cls().with_values({"patch": patch})
        library = {row.name: row.initial for row in (*GROUND_PARAMETERS, *PATCH_PARAMETERS)}
        return cls().with_values(library | {"patch": patch})

    def with_values(self, values: Mapping[str, Any]) -> TerrainParameters:
        """Return the parameters with other values."""
        check_names(values, TABLE, "parameter of the terrain")
        return TerrainParameters({**self.values, **{name: _ROWS[name].check(value) for name, value in values.items()}})

    @property
    def ground(self) -> GroundConfig:
        """Parameters of the ground filter."""
        return GroundConfig(**{name: value for name, value in self.values.items() if name in _GROUND})

    @property
    def patches(self) -> PatchConfig:
        """Parameters of the patches."""
        return PatchConfig(**{name: value for name, value in self.values.items() if name in _PATCH})


@dataclass(frozen=True, slots=True)
class Assessed:
    """The terrain of some points: their number, that of ground points, and the agreement with the truth in percent.

    ``ground_points`` (m, 3) are the ground points, ``is_fitted`` (m,) marks those to which planes are fitted, ``index``
    finds those of a patch. ``unsure`` is the number of points that the ground filter is not sure of, ``unsure_shares``
    (rows, cols) their share of a patch's points, NaN if it has none. ``level`` and ``reach`` are those of the quadtree
    and of the window.
    """

    terrain: Terrain
    points: int
    ground_points: Float64Array
    is_fitted: BoolArray
    index: PointIndex
    unsure: int
    unsure_shares: Float32Array
    level: int
    reach: int
    kappa: float | None
    total_error: float | None
    costmap: LayeredCostmap

    def shown(self, name: str) -> tuple[Float32Array, float]:
        """Return values (rows, cols) of one of the properties, NaN where there is none, and the greatest to show."""
        config, planes = self.terrain.config, self.terrain.planes
        values, most = {
            "slope": (np.degrees(planes[..., 5]), 2.0 * config.max_slope),
            "roughness": (planes[..., 4], 2.0 * config.max_roughness),
            "step": (self.terrain.steps, 2.0 * config.max_step),
            "unsure": (self.unsure_shares, MOST_UNSURE),
        }[name]
        return values.astype(np.float32), most

    def grid(self) -> OccupancyGrid:
        """Return the classes as a map: safe is free, unsafe occupied."""
        return self.terrain.grid()


def first_patch(places: NDArray[np.floating[Any]]) -> float:
    """Return a patch side, metres, for points at ``places`` (n, 2), such that most points are in well-filled patches.

    It is the least of :data:`SIDES`, from :data:`FINEST` on, at which :data:`FIRST_SHARE` of the points are in patches
    with at least :data:`FIRST_POINTS` points and there are at most :data:`MOST_PATCHES` patches; or the last at which
    the longer side of the cloud has :data:`LEAST_ACROSS` patches. Density is measured where there are points, because
    much of their bounding rectangle may be empty.
    """
    if not len(places):
        return FINEST
    columns = np.array(places.T, order="C")  # contiguous columns are faster
    columns -= columns.min(axis=1, keepdims=True)
    x, y = columns
    extent = columns.max(axis=1)
    longest, best = float(extent.max()), None
    for side in SIDES:
        rows, cols = (int(n) for n in np.floor(extent[::-1] / side) + 1.0)
        if side < min(FINEST, longest / 20.0) or rows * cols > MOST_PATCHES:
            continue
        if best is not None and LEAST_ACROSS * side > longest:
            break
        best = side
        at = (y / side).astype(np.int32)  # there are few patches; truncation equals floor, because no place is negative
        at *= cols
        at += (x / side).astype(np.int32)
        counts = np.bincount(at, minlength=rows * cols)
        if counts[counts >= FIRST_POINTS].sum() >= FIRST_SHARE * len(places):
            break
    return SIDES[-1] if best is None else round(best, 3)


def assessed(
    points: Float64Array,
    bounds: tuple[float, float, float, float],
    parameters: TerrainParameters,
    truth: BoolArray | None = None,
    progress: Callable[[float], None] | None = None,
) -> Assessed | None:
    """Return the terrain of points (n, 3) within ``bounds``, x0, y0, x1, y1, None if there are too few.

    ``truth`` (n,) marks the ground points, None if unknown. ``progress`` is as in :func:`mapper.terrain.find_ground`.
    Raises :class:`mapper.core.errors.MapperError` for parameters that do not fit the points.
    """
    if len(points) < 3:
        return None
    config, values = parameters.patches, parameters.values
    is_ground, is_unsure = np.ones(len(points), np.bool_), np.zeros(len(points), np.bool_)
    if values["filter"]:
        surface = find_ground(points, parameters.ground, progress=progress)
        is_ground, is_unsure = surface.is_ground, surface.is_unsure
    right = {} if truth is None else agreement(is_ground, truth)
    x0, y0, x1, y1 = bounds
    rows, cols = (max(int(np.ceil(side / config.patch)), 1) for side in (y1 - y0, x1 - x0))  # at least 1
    shape = (rows, cols, 10)
    if shape[0] * shape[1] > MOST_PATCHES:
        raise LimitError(
            "terrain.patches",
            f"{x1 - x0:.0f} × {y1 - y0:.0f} m have more than {MOST_PATCHES:,} patches of {config.patch:g} m; "
            "choose larger ones.",
        )
    empty = Patches(np.zeros(shape), config.patch, np.array([x0, y0, 0.0]))
    level, reach = round(values["level"]), round(values["reach"])
    joined, ground_points = empty, points[is_ground]
    for _ in range(level):
        joined = joined.parents()
    is_fitted = fitted(ground_points, joined, config)
    every, ground = empty.with_points(points), empty.with_points(ground_points[is_fitted])
    doubtful = empty.with_points(points[is_unsure])
    for _ in range(level):
        every, ground, doubtful = every.parents(), ground.parents(), doubtful.parents()
    terrain = assess(ground, config, occupied=every, reach=reach)
    counts = every.moments[..., 0]
    shares = np.where(counts > 0.0, doubtful.moments[..., 0] / np.maximum(counts, 1.0), np.nan).astype(np.float32)
    return Assessed(
        terrain, len(points), ground_points, is_fitted, PointIndex(ground_points, terrain.patches),
        int(is_unsure.sum()), shares, level, reach,
        right.get("kappa"), right.get("total_error"), _costmap_of(terrain),
    )  # fmt: skip


def _costmap_of(terrain: Terrain) -> LayeredCostmap:
    """Return the costmap whose only layer is the terrain, with inflation around unsafe patches."""
    geometry, footprint = terrain.patches.geometry, Footprint(HEXAGON)
    general = CostmapConfig(track_unknown_space=True)
    inflation = InflationLayer(geometry, InflationConfig(), footprint.inscribed_radius)
    costmap = LayeredCostmap(geometry, general, footprint, [terrain.layer()], inflation)
    costmap.update(0.0, (0.0, 0.0, 0.0))
    return costmap
