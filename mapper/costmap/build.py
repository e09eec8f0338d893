"""Put together the costmap that a parameter file describes."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError
from mapper.costmap.footprint import Footprint
from mapper.costmap.layered import LayeredCostmap
from mapper.costmap.layers import InflationLayer, KeepoutLayer, Layer, ObstacleLayer, StaticLayer
from mapper.costmap.nav2_parameters import NamedLayer, Nav2Costmap
from mapper.costmap.parameters import CostmapConfig, InflationConfig, ObstacleConfig, StaticConfig
from mapper.grid.occupancy_grid import GridGeometry

DEFAULT = Nav2Costmap(
    "global_costmap",
    CostmapConfig(),
    None,
    (NamedLayer("static_layer", StaticConfig()), NamedLayer("inflation_layer", InflationConfig())),
)  #: what Nav2 makes of a map without a parameter file


@dataclass(frozen=True, slots=True)
class BuiltCostmap:
    """A costmap with those of its layers that are given observations, painted or asked."""

    costmap: LayeredCostmap
    obstacles: tuple[ObstacleLayer, ...]
    keepout: KeepoutLayer


def build_costmap(
    geometry: GridGeometry, values: Int8Array, parameters: Nav2Costmap = DEFAULT, footprint: Footprint | None = None
) -> BuiltCostmap:
    """Return the costmap of a map with the layers of ``parameters``, and a keepout layer below the inflation.

    ``values`` (rows, cols) int8 are those of nav_msgs/OccupancyGrid. ``footprint`` replaces the parameters' padded
    outline. The voxel layer is used as an obstacle layer: observations are those of planar sensors. Raises
    :class:`ConfigError` for two inflation layers and for a map without a cell that the robot can be in.
    """
    outline = footprint or parameters.outline
    below: list[Layer] = []
    above: list[Layer] = []
    obstacles: list[ObstacleLayer] = []
    inflation: InflationLayer | None = None
    keepout = KeepoutLayer(geometry)
    for named in parameters.layers:
        place = below if inflation is None else above
        if isinstance(named.config, InflationConfig):
            if inflation is not None:
                raise ConfigError("costmap.inflation", "A costmap can have one inflation layer only.")
            below.append(keepout)
            inflation = InflationLayer(geometry, named.config, outline.inscribed_radius)
        elif isinstance(named.config, StaticConfig):
            place.append(StaticLayer(geometry, values, named.config, parameters.general))
        elif isinstance(named.config, ObstacleConfig):
            obstacles.append(ObstacleLayer(geometry, named.config, parameters.general))
            place.append(obstacles[-1])
    if inflation is None:
        below.append(keepout)
    built = LayeredCostmap(geometry, parameters.general, outline, below, inflation, above)
    return BuiltCostmap(built, tuple(obstacles), keepout)
