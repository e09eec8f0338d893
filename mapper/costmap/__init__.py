"""Costmaps derived from a map: layers of costs with Nav2's names, formulas and values.

A cell's cost is 0 (free) to 252, 253 (within the inscribed radius of an obstacle), 254 (an obstacle) or 255 (no
information). Source: the Nav2 documentation, Costmap 2D; nav2_costmap_2d.
"""

from mapper.costmap.costs import FREE, INSCRIBED, LETHAL, NO_INFORMATION, cost_of_distance
from mapper.costmap.decay_layer import DecayLayer
from mapper.costmap.denoise_layer import DenoiseLayer
from mapper.costmap.footprint import Footprint
from mapper.costmap.given_layer import GivenLayer
from mapper.costmap.keepout_layer import KeepoutLayer
from mapper.costmap.layered import CellReason, LayeredCostmap
from mapper.costmap.layers import InflationLayer, Observation, ObstacleLayer, StaticLayer
from mapper.costmap.masks import Mask
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
from mapper.costmap.speed_filter import SpeedFilter, SpeedLimit
from mapper.costmap.voxel_layer import VoxelLayer

__all__ = [
    "FREE",
    "INSCRIBED",
    "LETHAL",
    "NO_INFORMATION",
    "CellReason",
    "CostmapConfig",
    "DecayConfig",
    "DecayLayer",
    "DenoiseConfig",
    "DenoiseLayer",
    "Footprint",
    "GivenConfig",
    "GivenLayer",
    "InflationConfig",
    "InflationLayer",
    "KeepoutLayer",
    "LayeredCostmap",
    "Mask",
    "Observation",
    "ObstacleConfig",
    "ObstacleLayer",
    "SpeedFilter",
    "SpeedLimit",
    "StaticConfig",
    "StaticLayer",
    "VoxelConfig",
    "VoxelLayer",
    "cost_of_distance",
]
