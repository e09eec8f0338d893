"""Costmap as described by a Nav2 parameter file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from mapper.core.parameter import Parameter, check_fields, choice, flag
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.parameters import (
    COMBINATIONS,
    DECAY_PARAMETERS,
    DENOISE_PARAMETERS,
    GIVEN_PARAMETERS,
    INFLATION_PARAMETERS,
    OBSTACLE_PARAMETERS,
    SOURCE_PARAMETERS,
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

PluginConfig: TypeAlias = (
    StaticConfig | ObstacleConfig | VoxelConfig | DecayConfig | DenoiseConfig | GivenConfig | InflationConfig
)
LayerConfig: TypeAlias = "PluginConfig | ContainerConfig"

PLUGINS: Mapping[str, tuple[type[PluginConfig], tuple[Parameter, ...]]] = {
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
#: Parameters of an observation source that its layer does not have.
OF_SOURCE = frozenset(row.name for row in SOURCE_PARAMETERS) - {"min_obstacle_height", "max_obstacle_height"}
CONTAINER = "PluginContainerLayer"  #: the plugin that contains layers


@dataclass(frozen=True, slots=True)
class ContainerConfig:
    """Parameters of a PluginContainerLayer; ``inner`` has its layers, filters, and the whole costmap's parameters.

    ``combination_method`` is how their combined costs are applied to the layers before.
    """

    inner: Nav2Costmap
    # fmt: off
    enabled: bool = flag("Enabled", "container", True, "Whether the layers in the container are used.")
    combination_method: str = choice(
        "Combination method", "container", "max",
        "How the layers together are laid over those before: overwrite, the greater cost, or that of known cells.",
        COMBINATIONS,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class NamedLayer:
    """A layer of a parameter file: its name and its parameters."""

    name: str
    config: LayerConfig


@dataclass(frozen=True, slots=True)
class SkippedLayer:
    """A layer of a parameter file that is not supported: its ``block``, and the number of layers ``below`` it.

    ``below`` is None for an entry of the filter list.
    """

    name: str
    block: Mapping[str, Any]
    below: int | None


@dataclass(frozen=True, slots=True)
class Nav2Costmap:
    """A costmap of a Nav2 parameter file.

    ``layers`` are in the order of its plugins, bottom first. ``footprint`` is None for a robot defined by its radius.
    ``filters`` are its costmap filters. ``others`` are parameters that do not affect the costs here, by their path
    below the node: (name,) of the costmap, (layer, name), (layer, source, name). :func:`nav2_yaml` writes them again,
    and also the ``skipped`` layers. ``notes`` are sentences on values that are interpreted differently, or that Nav2
    warns of.
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
        """The names of the parameters that do not affect the costs here."""
        own = tuple(".".join((self.node, *path)) for path in self.others)
        return own + tuple(name for container in self.containers for name in container.inner.unused)

    @property
    def containers(self) -> tuple[ContainerConfig, ...]:
        """The containers among its layers."""
        return tuple(layer.config for layer in self.layers if isinstance(layer.config, ContainerConfig))

    def all_layers(self) -> Iterator[NamedLayer]:
        """Yield its layers by their names below the first node, each container before its layers."""
        for layer in self.layers:
            yield layer
            if isinstance(layer.config, ContainerConfig):
                for inner in layer.config.inner.all_layers():
                    yield NamedLayer(f"{layer.name}.{inner.name}", inner.config)

    @property
    def outline(self) -> Footprint:
        """The padded outline of the robot."""
        shape = self.footprint or Footprint.circle(self.general.robot_radius)
        return shape.padded(self.general.footprint_padding)
