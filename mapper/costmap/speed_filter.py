"""Speed limits painted on a map (SpeedFilter), which affect the robot's speed but not the costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.costmap.masks import Mask

PERCENTAGE, ABSOLUTE = 1, 2  #: types in nav2_msgs/CostmapFilterInfo


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """The limit at a position: m/s, or % of the maximum speed with ``percentage``; None for no limit.

    ``note`` is the reason for no limit.
    """

    limit: float | None
    percentage: bool
    note: str = ""

    def of(self, greatest: float) -> float:
        """Return the maximum speed here, m/s, of a robot with a maximum speed of ``greatest`` m/s."""
        if self.limit is None:
            return greatest
        return min(greatest, self.limit / 100.0 * greatest if self.percentage else self.limit)


class SpeedFilter:
    """A mask of speed limits: the limit is ``base`` + ``multiplier`` · value.

    ``kind`` 1 is percent of the maximum speed, 2 is m/s. A value of 0 means no limit. Raises :class:`ConfigError` for
    another kind and numbers that are not finite. Source: nav2_costmap_2d, speed_filter.cpp.
    """

    def __init__(self, mask: Mask, kind: int = PERCENTAGE, base: float = 0.0, multiplier: float = 1.0) -> None:
        if kind not in (PERCENTAGE, ABSOLUTE):
            raise ConfigError("costmap.speed_type", f"A speed filter’s type must be 1 or 2, not {kind!r:.40}.")
        if not np.isfinite([base, multiplier]).all():
            message = (
                f"A speed filter’s base and multiplier must be finite numbers, not {base!r:.40}, {multiplier!r:.40}."
            )
            raise ConfigError("costmap.speed_scale", message)
        self.mask, self.percentage, self.base, self.multiplier = mask, kind == PERCENTAGE, base, multiplier
        self._last = SpeedLimit(None, self.percentage)

    def at(self, x: float, y: float) -> SpeedLimit:
        """Return the limit for a robot at a point in map metres.

        Outside the mask and in unknown cells the last limit remains in effect, as in Nav2. A limit below 0 or above 100
        % means no limit.
        """
        value = self.mask.at(x, y)
        if value is None or value < 0:
            where = "outside the mask" if value is None else "in an unknown cell of the mask"
            return SpeedLimit(self._last.limit, self.percentage, f"The robot is {where}: the last limit holds.")
        if value == 0:
            self._last = SpeedLimit(None, self.percentage, "The mask’s value is 0: no limit.")
            return self._last
        limit = value * self.multiplier + self.base
        unit, most = ("%", 100.0) if self.percentage else ("m/s", float("inf"))
        if not 0.0 <= limit <= most:
            note = f"The limit of {limit:g} {unit} is impossible: no limit."
            self._last = SpeedLimit(None, self.percentage, note)
        elif limit == 0.0:
            self._last = SpeedLimit(None, self.percentage, "A limit of 0 is no limit in Nav2.")
        else:
            self._last = SpeedLimit(limit, self.percentage)
        return self._last

    def speeds_along(self, points_xy: Float64Array, greatest: float) -> Float64Array:
        """Return the maximum speed (n,), m/s, at each of the positions (n, 2), map metres, passed in order.

        ``greatest`` is the robot's own maximum, m/s. Equivalent to :meth:`at` for one position after another, without
        changing the current limit.
        """
        rows, cols = self.mask.geometry.shape
        at = self.mask.geometry.world_to_cell(points_xy)
        is_inside = ((at >= 0) & (at < (rows, cols))).all(axis=1)
        values = np.full(len(at), -1)
        values[is_inside] = self.mask.values[at[is_inside, 0], at[is_inside, 1]]
        limits = values * self.multiplier + self.base
        most = 100.0 if self.percentage else np.inf
        is_none = (values == 0) | ~((limits > 0.0) & (limits <= most))
        speeds = np.minimum(limits / 100.0 * greatest if self.percentage else limits, greatest)
        speeds[is_none] = greatest
        # The entry before the first position is the current limit; unknown positions inherit the previous one.
        known = np.concatenate([[0], np.where(values >= 0, np.arange(1, len(at) + 1), 0)])
        return np.concatenate([[self._last.of(greatest)], speeds])[np.maximum.accumulate(known)[1:]]
