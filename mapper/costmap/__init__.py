"""Costmaps on top of a map: layers of costs with Nav2's names, formulas and values.

A cell's cost is 0 (free) to 252, 253 (within the inscribed radius of an obstacle), 254 (an obstacle) or 255 (no
information). Source: the Nav2 documentation, Costmap 2D; nav2_costmap_2d.
"""

from mapper.costmap.costs import FREE, INSCRIBED, LETHAL, NO_INFORMATION, cost_of_distance
from mapper.costmap.footprint import Footprint
from mapper.costmap.layered import CellReason, LayeredCostmap
from mapper.costmap.layers import (
    DecayLayer,
    InflationLayer,
    KeepoutLayer,
    Observation,
    ObstacleLayer,
    StaticLayer,
)
from mapper.costmap.parameters import CostmapConfig, DecayConfig, InflationConfig, ObstacleConfig, StaticConfig

__all__ = [
    "FREE",
    "INSCRIBED",
    "LETHAL",
    "NO_INFORMATION",
    "CellReason",
    "CostmapConfig",
    "DecayConfig",
    "DecayLayer",
    "Footprint",
    "InflationConfig",
    "InflationLayer",
    "KeepoutLayer",
    "LayeredCostmap",
    "Observation",
    "ObstacleConfig",
    "ObstacleLayer",
    "StaticConfig",
    "StaticLayer",
    "cost_of_distance",
]
