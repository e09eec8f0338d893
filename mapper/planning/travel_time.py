"""Travel time along a path with speed limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.costmap.speed_filter import SpeedFilter


def travel_time(points: Float64Array, greatest: float, filters: Sequence[SpeedFilter] = ()) -> float:
    """Return the time in s along the path ``points`` (n, 2), map metres, at the greatest speed that is allowed.

    ``greatest`` is the robot's speed without a limit, m/s; each part between two points has the limit of its middle,
    the least of all ``filters``. Accelerating, turning on the spot and slowing in curves take longer. Raises
    :class:`ConfigError` for a speed that is not above 0.
    """
    if not 0.0 < greatest < float("inf"):
        raise ConfigError("path.speed", f"The robot’s greatest speed must be above 0 m/s, not {greatest!r:.40}.")
    lengths = np.hypot(*np.diff(points, axis=0).T)
    middles = 0.5 * (points[:-1] + points[1:])
    speeds = np.full(len(lengths), greatest)
    for one in filters:
        np.minimum(speeds, one.speeds_along(middles, greatest), out=speeds)
    return float((lengths / speeds).sum())
