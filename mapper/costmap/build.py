"""Put together the costmap that a parameter file describes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError
from mapper.costmap.decay_layer import DecayLayer
from mapper.costmap.denoise_layer import DenoiseLayer
from mapper.costmap.footprint import Footprint
from mapper.costmap.given_layer import GivenLayer
from mapper.costmap.keepout_layer import KeepoutLayer
from mapper.costmap.layered import LayeredCostmap
from mapper.costmap.layers import InflationLayer, Layer, ObstacleLayer, StaticLayer
from mapper.costmap.masks import Mask
from mapper.costmap.nav2.costmap import NamedLayer, Nav2Costmap
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.parameters import (
    CostmapConfig,
    DecayConfig,
    DenoiseConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    StaticConfig,
    VoxelConfig,
)
from mapper.costmap.speed_filter import SpeedFilter
from mapper.costmap.voxel_layer import VoxelLayer
from mapper.grid.occupancy_grid import GridGeometry
from mapper.io.maps import load_map

DEFAULT = Nav2Costmap(
    "global_costmap",
    CostmapConfig(),
    None,
    (NamedLayer("static_layer", StaticConfig()), NamedLayer("inflation_layer", InflationConfig())),
)  #: what Nav2 makes of a map without a parameter file


ObservedLayer = ObstacleLayer | VoxelLayer | DecayLayer


@dataclass(frozen=True, slots=True)
class BuiltCostmap:
    """A costmap with those of its layers that are given observations, painted or asked.

    ``unmasked`` are the names of filters without a mask, which have no effect. ``given`` are layers whose costs have to
    be set, by their names; without costs they have no effect. ``observed`` are the names of ``obstacles``.
    """

    costmap: LayeredCostmap
    obstacles: tuple[ObservedLayer, ...]
    keepout: KeepoutLayer
    speed: tuple[SpeedFilter, ...] = ()
    unmasked: tuple[str, ...] = field(default=())
    given: Mapping[str, GivenLayer] = field(default_factory=dict)
    observed: tuple[str, ...] = ()


def load_masks(parameters: Nav2Costmap, folder: Path, frame: str | None = None) -> dict[str, Mask]:
    """Return the masks of the parameters' filters by the names of the filters; file names are relative to ``folder``.

    A mask may have another resolution and origin than the map. ``frame`` is the map's, where it is known. Raises
    :class:`mapper.core.errors.ReadError` for a mask that cannot be read, and :class:`ConfigError` for one whose file
    states another frame: how that lies in the map's frame is not known.
    """
    masks = {}
    for one in parameters.filters:
        if one.mask is not None and one.kind != "binary":
            loaded = load_map(folder / one.mask)
            stated = loaded.description.frame
            if frame is not None and stated is not None and frame.strip("/") != stated.strip("/"):
                raise ConfigError(
                    "costmap.frame",
                    f"The mask {one.mask!r:.80} of {one.name} is in the frame {stated!r:.80}, the map in "
                    f"{frame!r:.80}: all layers must be in one frame.",
                )
            masks[one.name] = Mask(loaded.grid.geometry, loaded.values, loaded.notes)
    return masks


def build_costmap(
    geometry: GridGeometry,
    values: Int8Array,
    parameters: Nav2Costmap = DEFAULT,
    footprint: Footprint | None = None,
    masks: Mapping[str, Mask] | None = None,
) -> BuiltCostmap:
    """Return the costmap of a map with the layers and filters of ``parameters``, and a keepout layer to paint on.

    ``values`` (rows, cols) int8 are those of nav_msgs/OccupancyGrid. ``footprint`` replaces the parameters' padded
    outline. ``masks`` are those of the filters, by their names. The painted keepout layer lies below the inflation;
    filters lie where the parameters have them, which in Nav2's list of filters is above all layers. Raises
    :class:`ConfigError` for two inflation layers.
    """
    outline = footprint or parameters.outline
    below: list[Layer] = []
    above: list[Layer] = []
    obstacles: list[ObservedLayer] = []
    given: dict[str, GivenLayer] = {}
    inflation: InflationLayer | None = None
    keepout = KeepoutLayer(geometry, name="painted_keepout" if _keepouts(parameters) else "keepout_filter")
    masks = masks or {}

    observed: list[str] = []

    def add_keepouts(place: list[Layer], n_below: int | None) -> None:
        used = [
            keepout
            for keepout in _keepouts(parameters)
            if keepout.below == n_below and keepout.enabled and keepout.name in masks
        ]
        place.extend(KeepoutLayer(geometry, masks[one.name], one.name) for one in used)

    for k, named in enumerate(parameters.layers):
        place = below if inflation is None else above
        config, general = named.config, parameters.general
        add_keepouts(place, k)
        if isinstance(config, InflationConfig):
            if inflation is not None:
                raise ConfigError("costmap.inflation", "A costmap can have one inflation layer only.")
            below.append(keepout)
            inflation = InflationLayer(geometry, config, outline.inscribed_radius)
        elif isinstance(config, StaticConfig):
            place.append(StaticLayer(geometry, values, config, general))
        elif isinstance(config, DenoiseConfig):
            place.append(DenoiseLayer(geometry, config, general, named.name))
        elif isinstance(config, GivenConfig):
            if config.enabled:
                given[named.name] = GivenLayer(geometry, named.name)
                place.append(given[named.name])
        elif isinstance(config, ObstacleConfig):
            obstacles.append(_observed(geometry, config, general))
            observed.append(named.name)
            place.append(obstacles[-1])
    if inflation is None:
        below.append(keepout)
    place = below if inflation is None else above
    add_keepouts(place, len(parameters.layers))
    add_keepouts(place, None)
    speed = tuple(
        SpeedFilter(masks[one.name], one.type, one.base, one.multiplier)
        for one in parameters.filters
        if one.kind == "speed" and one.enabled and one.name in masks
    )
    unmasked = tuple(one.name for one in parameters.filters if one.name not in masks)
    built = LayeredCostmap(geometry, parameters.general, outline, below, inflation, above)
    return BuiltCostmap(built, tuple(obstacles), keepout, speed, unmasked, given, tuple(observed))


def _keepouts(parameters: Nav2Costmap) -> list[NamedFilter]:
    return [one for one in parameters.filters if one.kind == "keepout"]


def _observed(geometry: GridGeometry, config: ObstacleConfig, general: CostmapConfig) -> ObservedLayer:
    if isinstance(config, VoxelConfig):
        return VoxelLayer(geometry, config, general)
    if isinstance(config, DecayConfig):
        return DecayLayer(geometry, config, general)
    return ObstacleLayer(geometry, config, general)
