"""Zones that a visitor paints on a costmap: keepout zones and zones with a speed limit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from msgspec import UNSET

from mapper.core.array_types import Float64Array, Int8Array, UInt8Array
from mapper.costmap import NO_INFORMATION, Mask, SpeedFilter, SpeedLimit
from mapper.costmap.kernels.observation import fill_polygon
from mapper.costmap.layers import no_bounds
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.speed_filter import ABSOLUTE, PERCENTAGE
from mapper.grid import GridGeometry
from server.parts.costmap.parameters import SPEED_LIMITS
from server.stream.message_parts import BrushStroke
from server.stream.protocol import ProtocolError

MOST_STROKES = 100
MOST_POINTS = 3000  #: of all strokes together, because a command has at most 64 KiB
WIDEST_M = 5.0
_ROUND = 10  #: number of corners of a brush
#: Type and multiplier of the speed filter's information. Mask values are percent, or hundredths of a m/s.
SPEED_TYPES = dict(zip(SPEED_LIMITS, ((PERCENTAGE, 1.0), (ABSOLUTE, 0.01)), strict=True))


@dataclass(frozen=True, slots=True)
class Stroke:
    """A stroke of the brush: ``points`` (x, y) in m, ``width`` in m, and whether it erases.

    ``speed`` is the value 1 to 100 of a zone in the speed filter's mask, None for a keepout zone. An erasing stroke
    erases both.
    """

    width: float
    erases: bool
    points: tuple[tuple[float, float], ...]
    speed: int | None = None

    def message(self) -> BrushStroke:
        """Return the stroke as its message."""
        return BrushStroke(self.width, self.erases, list(self.points), UNSET if self.speed is None else self.speed)

    def outlines(self) -> Iterator[Float64Array]:
        """Yield polygons (n, 2) in metres that cover the stroke."""
        half = 0.5 * self.width
        turns = np.arange(_ROUND) * (math.tau / _ROUND)
        disc = half * np.column_stack([np.cos(turns), np.sin(turns)])
        points = np.array(self.points)
        for point in points:
            yield point + disc
        for begin, end in pairwise(points):
            along = end - begin
            length = float(np.hypot(*along))
            if length > 0.0:
                side = half / length * np.array([-along[1], along[0]])
                yield np.stack([begin + side, end + side, end - side, begin - side])

    def continues(self, before: Stroke) -> bool:
        """Return whether this is the stroke ``before`` with more points."""
        same = (self.width, self.erases, self.speed) == (before.width, before.erases, before.speed)
        return same and self.points[: len(before.points)] == before.points


def strokes_of(brush_strokes: Sequence[BrushStroke]) -> tuple[Stroke, ...]:
    """Return the strokes of messages. Raises :class:`ProtocolError` for more than :data:`MOST_POINTS` points."""
    strokes = tuple(
        Stroke(
            stroke.width, stroke.erases, tuple(stroke.points), stroke.speed if isinstance(stroke.speed, int) else None
        )
        for stroke in brush_strokes
    )
    if len(strokes) > MOST_STROKES or sum(len(stroke.points) for stroke in strokes) > MOST_POINTS:
        message = f"At most {MOST_STROKES} strokes of {MOST_POINTS} points can be painted; clear some first."
        raise ProtocolError("costmap.strokes", message)
    for stroke in strokes:
        if not (0.0 < stroke.width <= WIDEST_M and stroke.points):
            message = f"A stroke has points, and a width of at most {WIDEST_M:g} m."
            raise ProtocolError("costmap.stroke", message)
        if stroke.speed is not None and not 1 <= stroke.speed <= 100:
            raise ProtocolError("costmap.stroke", f"A speed limit is a value of 1 to 100, not {stroke.speed}.")
    return strokes


class SpeedZones:
    """The painted mask of a speed filter: ``mask`` (rows, cols) int8, 1 to 100, 0 for no limit."""

    def __init__(self, geometry: GridGeometry, kind: str, given: Int8Array | None = None) -> None:
        """Create a mask. ``kind`` is a name of :data:`SPEED_TYPES`; ``given`` is an initial mask."""
        self._geometry, self._given = geometry, given
        self.mask: Int8Array = np.zeros(geometry.shape, dtype=np.int8)
        self.clear()
        self.interpret(kind)

    def interpret(self, kind: str) -> None:
        """Interpret the values as percent or as hundredths of a m/s."""
        number, multiplier = SPEED_TYPES[kind]
        self._filter = SpeedFilter(Mask(self._geometry, self.mask), number, multiplier=multiplier)

    def paint(self, stroke: Stroke) -> None:
        """Paint a stroke with a speed limit, or an erasing one."""
        value = np.int8(0 if stroke.speed is None else stroke.speed)
        for outline in stroke.outlines():
            fill_polygon(self._geometry.to_lattice(outline), value, self.mask, no_bounds())

    def clear(self) -> None:
        """Remove everything that was painted."""
        self.mask[...] = 0 if self._given is None else self._given

    @property
    def filter(self) -> SpeedFilter:
        """The speed filter of the mask."""
        return self._filter

    def at(self, x: float, y: float) -> SpeedLimit:
        """Return the limit for a robot at a point, map metres."""
        return self._filter.at(x, y)

    def why(self, x: float, y: float) -> str | None:
        """Return one sentence about the mask at a point, map metres; None if nothing is painted there.

        The question does not change the limit that applies outside the mask.
        """
        value = self._filter.mask.at(x, y)
        if not value:
            return None
        return f"The speed filter’s mask is {value} here: the limit is {self.named(value)}."

    def named(self, value: int) -> str:
        """Return the limit of a mask value in words."""
        if self._filter.percentage:
            return f"{value} % of the greatest speed"
        return f"{self._filter.multiplier * value:.2f} m/s"

    @property
    def picture(self) -> UInt8Array:
        """The mask as bytes (rows, cols), 255 for no limit."""
        return np.where(self.mask > 0, self.mask, NO_INFORMATION).astype(np.uint8)


def painted_filters(keepout: Int8Array | None, speed: Int8Array | None, kind: str) -> tuple[NamedFilter, ...]:
    """Return the filters of the painted masks, with the names of the masks' downloaded files."""
    filters = []
    if keepout is not None:
        filters.append(NamedFilter("keepout_filter", "keepout", "keepout.yaml"))
    if speed is not None:
        number, multiplier = SPEED_TYPES[kind]
        filters.append(NamedFilter("speed_filter", "speed", "speed.yaml", number, 0.0, multiplier))
    return tuple(filters)
