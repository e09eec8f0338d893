"""Map to map: the pose at which the walls of one occupancy grid lie on those of another."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.grid import OccupancyGrid
from mapper.matching.match import Match, match_scan
from mapper.matching.parameters import MAP_CONFIG, MatchConfig
from mapper.matching.target import map_points, map_target


def match_maps(
    first: OccupancyGrid, second: OccupancyGrid, guess: Float64Array | None = None, config: MatchConfig = MAP_CONFIG
) -> Match:
    """Return the pose of the second map's frame in that of the first, ``T_first_second``, from ``guess`` (3,) or 0.

    The centres of the second map's occupied cells are matched to those of the first as the points of a scan are: a
    search over the window, and Gauss–Newton on a field. Raises :class:`ConfigError` for a map with fewer than three
    occupied cells, and what :func:`mapper.matching.match.match_scan` raises.
    """
    target = map_target(map_points(first))
    return match_scan(map_points(second), 0, target, np.zeros(3) if guess is None else guess, config)
