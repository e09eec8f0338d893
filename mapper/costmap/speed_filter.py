"""Speed limits painted on a map (SpeedFilter): they change no cost, but how fast the robot may drive."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.errors import ConfigError
from mapper.costmap.masks import Mask

PERCENTAGE, ABSOLUTE = 1, 2  #: the types of nav2_msgs/CostmapFilterInfo


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """The limit at a place: m/s, or % of the greatest speed with ``percentage``; None where there is no limit.

    ``note`` says why there is none.
    """

    limit: float | None
    percentage: bool
    note: str = ""

    def of(self, greatest: float) -> float:
        """Return the greatest speed here in m/s of a robot whose greatest speed is ``greatest`` m/s."""
        if self.limit is None:
            return greatest
        return min(greatest, self.limit / 100.0 * greatest if self.percentage else self.limit)


class SpeedFilter:
    """A mask of speed limits: the limit is ``base`` + ``multiplier`` · value.

    ``kind`` 1 is percent of the greatest speed, 2 m/s. A value 0 is no limit. Raises :class:`ConfigError` for another
    kind. Source: nav2_costmap_2d, speed_filter.cpp.
    """

    def __init__(self, mask: Mask, kind: int = PERCENTAGE, base: float = 0.0, multiplier: float = 1.0) -> None:
        if kind not in (PERCENTAGE, ABSOLUTE):
            raise ConfigError("costmap.speed_type", f"A speed filter's type must be 1 or 2, not {kind!r:.40}.")
        self.mask, self.percentage, self.base, self.multiplier = mask, kind == PERCENTAGE, base, multiplier
        self._last = SpeedLimit(None, self.percentage)

    def at(self, x: float, y: float) -> SpeedLimit:
        """Return the limit for a robot at a point in map metres.

        Outside the mask and in an unknown cell of it the last limit holds, as in Nav2. A limit below 0, or above 100 %,
        is none.
        """
        value = self.mask.at(x, y)
        if value is None or value < 0:
            where = "outside the mask" if value is None else "in an unknown cell of the mask"
            return SpeedLimit(self._last.limit, self.percentage, f"The robot is {where}: the last limit holds.")
        if value == 0:
            self._last = SpeedLimit(None, self.percentage, "The mask's value is 0: no limit.")
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
