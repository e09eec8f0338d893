"""The values of a costmap's cells, as Nav2 numbers them.

Source: nav2_costmap_2d, cost_values.hpp and inflation_layer.hpp.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import UInt8Array

FREE = 0
MAX_NON_OBSTACLE = 252  #: the maximum cost of inflation outside the inscribed radius
INSCRIBED = 253  #: a robot with its centre here touches an obstacle, whatever its heading
LETHAL = 254  #: an obstacle
NO_INFORMATION = 255

CELLS_EPSILON = 1e-9  #: so that rounding errors do not make 0.55 m at 0.05 m 12 instead of 11 cells


def name_of_cost(cost: int) -> str:
    """Return the meaning of a cost in words."""
    names = {FREE: "free", INSCRIBED: "inscribed", LETHAL: "lethal", NO_INFORMATION: "no information"}
    return names.get(cost, f"cost {cost}")


def cells_of(distance: float, resolution: float) -> int:
    """Convert a distance in metres to cells, rounded up (Costmap2D::cellDistance)."""
    return max(0, math.ceil(distance / resolution - CELLS_EPSILON))


def cost_of_distance(distance: float, inscribed_radius: float, cost_scaling_factor: float) -> int:
    """Return the cost at ``distance`` metres from the nearest obstacle (InflationLayer::computeCost)."""
    if distance == 0.0:
        return LETHAL
    if distance <= inscribed_radius:
        return INSCRIBED
    return int(MAX_NON_OBSTACLE * math.exp(-cost_scaling_factor * (distance - inscribed_radius)))


def cost_table(cell_radius: int, resolution: float, inscribed_radius: float, cost_scaling_factor: float) -> UInt8Array:
    """Return the costs (cell_radius² + 2,) uint8 of the squared distances 0, 1, 2, ... in cells.

    The last entry is the cost of everything farther away: 0.
    """
    table = np.zeros(cell_radius * cell_radius + 2, dtype=np.uint8)
    for squared in range(cell_radius * cell_radius + 1):
        distance = math.sqrt(squared) * resolution
        table[squared] = cost_of_distance(distance, inscribed_radius, cost_scaling_factor)
    return table
