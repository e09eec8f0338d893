"""A costmap as a Nav2 parameter file describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from mapper.core.parameter import Parameter
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.parameters import (
    DECAY_PARAMETERS,
    DENOISE_PARAMETERS,
    GIVEN_PARAMETERS,
    INFLATION_PARAMETERS,
    OBSTACLE_PARAMETERS,
    STATIC_PARAMETERS,
    VOXEL_PARAMETERS,
    CostmapConfig,
    DecayConfig,
    DenoiseConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    StaticConfig,
    VoxelConfig,
)

LayerConfig: TypeAlias = (
    StaticConfig | ObstacleConfig | VoxelConfig | DecayConfig | DenoiseConfig | GivenConfig | InflationConfig
)

PLUGINS: Mapping[str, tuple[type[LayerConfig], tuple[Parameter, ...]]] = {
    "StaticLayer": (StaticConfig, STATIC_PARAMETERS),
    "ObstacleLayer": (ObstacleConfig, OBSTACLE_PARAMETERS),
    "VoxelLayer": (VoxelConfig, VOXEL_PARAMETERS),
    "DenoiseLayer": (DenoiseConfig, DENOISE_PARAMETERS),
    "InflationLayer": (InflationConfig, INFLATION_PARAMETERS),
    "DecayLayer": (DecayConfig, DECAY_PARAMETERS),
    "TerrainLayer": (GivenConfig, GIVEN_PARAMETERS),
}
#: Parameters of the whole costmap that Nav2's static layer reads.
OF_STATIC = (
    "trinary_costmap", "lethal_cost_threshold", "inscribed_obstacle_cost_value", "unknown_cost_value", "use_maximum",
)  # fmt: skip
#: Parameters of the first source of observations that its layer's configuration has.
OF_SOURCE = (
    "marking", "clearing", "obstacle_min_range", "obstacle_max_range", "raytrace_min_range", "raytrace_max_range",
    "inf_is_valid",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class NamedLayer:
    """A layer of a parameter file: its name there, and its parameters."""

    name: str
    config: LayerConfig


@dataclass(frozen=True, slots=True)
class SkippedLayer:
    """A layer of a parameter file that is not built here: its ``block`` there, and how many layers lie ``below`` it.

    ``below`` is None for a filter of the list of filters.
    """

    name: str
    block: Mapping[str, Any]
    below: int | None


@dataclass(frozen=True, slots=True)
class Nav2Costmap:
    """A costmap of a Nav2 parameter file.

    ``layers`` are in the order of its plugins, bottom first. ``footprint`` is None for a robot given by its radius.
    ``filters`` are its costmap filters. ``others`` are parameters that change no cost here, by their path below the
    node, which :func:`nav2_yaml` writes again: (name,) of the costmap, (layer, name), (layer, source, name). So are the
    ``skipped`` layers. ``notes`` are sentences on what is understood otherwise than it stands there, or warned of.
    """

    node: str
    general: CostmapConfig
    footprint: Footprint | None
    layers: tuple[NamedLayer, ...]
    filters: tuple[NamedFilter, ...] = ()
    others: Mapping[tuple[str, ...], Any] = field(default_factory=dict)
    skipped: tuple[SkippedLayer, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of the parameters that change no cost here."""
        return tuple(".".join((self.node, *path)) for path in self.others)

    @property
    def outline(self) -> Footprint:
        """The padded outline of the robot."""
        shape = self.footprint or Footprint.circle(self.general.robot_radius)
        return shape.padded(self.general.footprint_padding)
