"""Terrain of points: patches, their classes, the ground filter beside the truth, and the costs that follow."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.parameter import Parameter, check_names
from mapper.costmap import CostmapConfig, Footprint, InflationConfig, InflationLayer, LayeredCostmap
from mapper.grid import OccupancyGrid
from mapper.simulation.sensors_3d import Scan3D
from mapper.simulation.worlds import World
from mapper.terrain import (
    GROUND_PARAMETERS,
    PATCH_PARAMETERS,
    GroundConfig,
    PatchConfig,
    Patches,
    Terrain,
    agreement,
    assess,
    find_ground,
)
from server.sessions.models.lab_navigation_parameters import HEXAGON

MOST_POINTS = 150_000  #: of the scans that are assessed
MOST_PATCHES = 250_000
TRUE_WITHIN = 0.05  #: metres: a point so near to the floor or a ramp is ground
SHOWN = ("costs", "costmap", "slope", "roughness", "step")
#: In a room cells, discs and patches are smaller than outdoors.
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
        "Costs of the classes, the costmap with inflation, or one property of the patches, from light to dark.",
        choices=SHOWN,
    ),
    *(_label(row) for row in PATCH_PARAMETERS),
    Parameter(
        "level", "Level of the quadtree", "terrain_patches", "number", 0.0,
        "Each level joins four patches: their moments are added.", low=0.0, high=4.0, step=1.0,
    ),
    Parameter(
        "reach", "Window", "terrain_patches", "number", 0.0,
        "How many patches the window of a plane reaches on each side, by one summed-area table.",
        low=0.0, high=8.0, step=1.0,
    ),
    Parameter(
        "filter", "Ground filter", "terrain_ground", "flag", True,
        "Whether objects are taken out by SMRF before planes are fitted.",
    ),
    *(_label(row) for row in GROUND_PARAMETERS),
)  # fmt: skip
_ROWS = {row.name: row for row in TABLE}
_GROUND = frozenset(row.name for row in GROUND_PARAMETERS)
_PATCH = frozenset(row.name for row in PATCH_PARAMETERS)


@dataclass(frozen=True, slots=True)
class TerrainParameters:
    """The present values. Raises :class:`ConfigError` for what the table refuses."""

    values: Mapping[str, Any] = field(default_factory=lambda: {row.name: row.initial for row in TABLE})

    @classmethod
    def outdoors(cls, points: int, area: float) -> TerrainParameters:
        """Return first values for a cloud of so many points over so many square metres: those of the library.

        A patch is so large that it has ten points or so.
        """
        library = {row.name: row.initial for row in (*GROUND_PARAMETERS, *PATCH_PARAMETERS)}
        patch = round(min(max(math.sqrt(10.0 * area / max(points, 1)), 0.1), 20.0), 1)
        return cls().with_values(library | {"patch": patch})

    def with_values(self, values: Mapping[str, Any]) -> TerrainParameters:
        """Return the parameters with other values; the rest stays."""
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
    """The terrain of some points: how many, how many are ground, and how that agrees with the truth in percent."""

    terrain: Terrain
    points: int
    ground: int
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
        }[name]
        return values.astype(np.float32), most

    def grid(self) -> OccupancyGrid:
        """Return the classes as a map: safe is free, unsafe occupied."""
        return self.terrain.grid()


def points_of(scans: Sequence[Scan3D]) -> Float64Array:
    """Return at most :data:`MOST_POINTS` of the points (n, 3) that scans measured, the newest among them, metres."""
    left, found = MOST_POINTS, []
    for scan in reversed(scans):
        points = scan.ends()[0][np.isfinite(scan.ranges)]
        found.append(points[:left])
        left -= len(found[-1])
        if left <= 0:
            break
    return np.concatenate(found) if found else np.empty((0, 3))


def true_ground(world: World, points: Float64Array) -> BoolArray:
    """Return which points (n, 3) lie on the floor of a world or on one of its ramps."""
    on_ground = np.abs(points[:, 2]) <= TRUE_WITHIN
    for block in world.blocks:
        a, b, c = block.top
        if b == c == 0.0:
            continue
        low, high = block.outline.min(axis=0), block.outline.max(axis=0)
        inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
        on_ground |= inside & (np.abs(points[:, 2] - a - points[:, :2] @ (b, c)) <= TRUE_WITHIN)
    return np.asarray(on_ground)


def assessed(
    points: Float64Array,
    bounds: tuple[float, float, float, float],
    parameters: TerrainParameters,
    truth: BoolArray | None = None,
    progress: Callable[[float], None] | None = None,
) -> Assessed | None:
    """Return the terrain of points (n, 3) within ``bounds``, x0, y0, x1, y1, None where there are too few.

    ``truth`` (n,) are the points that are ground, None where that is not known; ``progress`` is as in
    :func:`mapper.terrain.find_ground`. Raises :class:`mapper.core.errors.MapperError` for parameters that do not fit
    the points.
    """
    if len(points) < 3:
        return None
    config, values = parameters.patches, parameters.values
    is_ground = (
        find_ground(points, parameters.ground, progress=progress).is_ground
        if values["filter"]
        else np.ones(len(points), np.bool_)
    )
    right = {} if truth is None else agreement(is_ground, truth)
    x0, y0, x1, y1 = bounds
    rows, cols = (max(int(np.ceil(side / config.patch)), 1) for side in (y1 - y0, x1 - x0))  # of a wall one, too
    shape = (rows, cols, 10)
    if shape[0] * shape[1] > MOST_PATCHES:
        raise LimitError(
            "terrain.patches",
            f"{x1 - x0:.0f} × {y1 - y0:.0f} m have more than {MOST_PATCHES:,} patches of {config.patch:g} m; "
            "take greater ones.",
        )
    empty = Patches(np.zeros(shape), config.patch, np.array([x0, y0, 0.0]))
    every, ground = empty.with_points(points), empty.with_points(points[is_ground])
    for _ in range(round(values["level"])):
        every, ground = every.parents(), ground.parents()
    terrain = assess(ground, config, occupied=every, reach=round(values["reach"]))
    costmap = _costmap_of(terrain)
    n_ground = int(is_ground.sum())
    return Assessed(terrain, len(points), n_ground, right.get("kappa"), right.get("total_error"), costmap)


def _costmap_of(terrain: Terrain) -> LayeredCostmap:
    """Return the costmap whose one layer is the terrain, with inflation around what is unsafe."""
    geometry, footprint = terrain.patches.geometry, Footprint(HEXAGON)
    general = CostmapConfig(track_unknown_space=True)
    inflation = InflationLayer(geometry, InflationConfig(), footprint.inscribed_radius)
    costmap = LayeredCostmap(geometry, general, footprint, [terrain.layer()], inflation)
    costmap.update(0.0, (0.0, 0.0, 0.0))
    return costmap


def patch_at(found: Assessed, x: float, y: float) -> dict[str, Any]:
    """Return the fields of a message on the patch at (x, y): P row by row, its plane and why it has its class.

    Raises :class:`ConfigError` for a place outside.
    """
    patches, terrain = found.terrain.patches, found.terrain
    row, col = (int(k) for k in patches.geometry.world_to_cell((x, y)))
    if not (0 <= row < terrain.classes.shape[0] and 0 <= col < terrain.classes.shape[1]):
        raise ConfigError("terrain.outside", f"The place ({x:g}, {y:g}) lies outside of the patches.")
    n, sx, sy, sz, xx, xy, yy, xz, yz, zz = (float(v) for v in patches.moments[row, col])
    moments = [n, sx, sy, sz, sx, xx, xy, xz, sy, xy, yy, yz, sz, xz, yz, zz]
    return {
        "x": round(x, 4),
        "y": round(y, 4),
        "moments": [round(v, 6) for v in moments],
        "why": terrain.why(row, col),
        "state": ("unknown", "safe", "unsafe")[int(terrain.classes[row, col])],
    }
