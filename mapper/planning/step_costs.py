"""Cost of a step onto a cell, for each of the 256 values of a costmap."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.costmap.costs import INSCRIBED, LETHAL, NO_INFORMATION
from mapper.planning.parameters import PlannerConfig

HIGHEST = 253  #: the greatest cost of a straight step (NavFn: COST_OBS - 1), which is that onto an unknown cell
BLOCKED = np.inf


def step_costs(config: PlannerConfig, inscribed_passable: bool = False) -> Float64Array:
    """Return the costs (256,) of a straight step onto a cell of each value; infinity where the robot cannot be.

    A whole number, neutral_cost + cost_factor · value, at most 253 (NavFn::setCostmap). A lethal and an inscribed cell
    are blocked; ``inscribed_passable`` gives the inscribed ones the highest cost instead.
    """
    values = np.arange(256)
    table: Float64Array = np.minimum(np.floor(config.neutral_cost + config.cost_factor * values), HIGHEST)
    table[LETHAL] = BLOCKED
    table[INSCRIBED] = HIGHEST if inscribed_passable else BLOCKED
    table[NO_INFORMATION] = HIGHEST if config.allow_unknown else BLOCKED
    return table
