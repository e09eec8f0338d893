"""Outline of a robot: inscribed and circumscribed radius, and its position on the map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import transform_points

Vertices: TypeAlias = "tuple[tuple[float, float], ...]"

_CIRCLE = 16  #: vertices of a round robot's outline, as in Nav2's makeFootprintFromRadius
MAX_VERTICES = 200


@dataclass(frozen=True, slots=True)
class Footprint:
    """Outline of a robot: a polygon with vertices in the robot's frame, metres.

    A vertex equal to the next one, such as the last of a closed outline, is removed. As in Nav2, the polygon need not
    contain the origin and may cross itself. Raises :class:`ConfigError` for fewer than three or more than 200 vertices,
    and values that are not finite.
    """

    vertices: Vertices

    def __post_init__(self) -> None:
        try:
            points = np.asarray(self.vertices, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise ConfigError("footprint.vertices", "A footprint must be a list of points [x, y].") from error
        if points.ndim == 2 and len(points):
            points = points[(points != np.roll(points, -1, axis=0)).any(axis=1)]
        if points.ndim != 2 or points.shape[1:] != (2,) or not 3 <= len(points) <= MAX_VERTICES:
            raise ConfigError(
                "footprint.vertices",
                f"A footprint must have 3 to {MAX_VERTICES} points [x, y], not an array of shape {points.shape}.",
            )
        if not (np.isfinite(points).all() and np.abs(points).max() <= 100.0):
            raise ConfigError("footprint.vertices", "The points of a footprint must be finite and within 100 m.")
        object.__setattr__(self, "vertices", tuple((float(x), float(y)) for x, y in points))

    @classmethod
    def circle(cls, radius: float) -> Footprint:
        """Return the outline of a round robot with a radius in metres: 16 points on the circle.

        Raises :class:`ConfigError` for a radius that is not a positive finite number.
        """
        if not (np.isfinite(radius) and radius > 0.0):
            raise ConfigError("footprint.radius", f"The robot’s radius must be positive, not {radius!r}.")
        angles = 2.0 * np.pi * np.arange(_CIRCLE) / _CIRCLE
        return cls(tuple((radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angles))

    def padded(self, padding: float) -> Footprint:
        """Return the footprint with each coordinate moved away from 0 by ``padding`` metres, as Nav2 pads it."""
        points = np.asarray(self.vertices)
        signs = np.where(points > 0.0, 1.0, np.where(points < 0.0, -1.0, 0.0))
        return Footprint(tuple((float(x), float(y)) for x, y in points + padding * signs))

    @property
    def crossing(self) -> tuple[int, int] | None:
        """The first pair of non-adjacent edges that intersect, as the indices from 0 of their start points."""
        points = np.asarray(self.vertices)
        n = len(points)
        for i in range(n):
            for j in range(i + 2, n):
                if (j + 1) % n != i and _meet(points[i], points[i + 1], points[j], points[(j + 1) % n]):
                    return i, j
        return None

    @property
    def holds_origin(self) -> bool:
        """Whether the origin, the robot's centre of rotation, is inside the polygon or on its outline."""
        points, origin = np.asarray(self.vertices), np.zeros(2)
        inside = False
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
            if _turn(a, b, origin) == 0.0 and _on(a, b, origin):
                return True
            if (a[1] > 0.0) != (b[1] > 0.0) and (b[0] - a[0]) * -a[1] / (b[1] - a[1]) + a[0] > 0.0:
                inside = not inside
        return inside

    @property
    def inscribed_radius(self) -> float:
        """Distance from the centre to the nearest point of the outline, metres."""
        points = np.asarray(self.vertices)
        ends = np.roll(points, -1, axis=0)
        edges = ends - points
        lengths = np.maximum((edges**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(-(points * edges).sum(axis=1) / lengths, 0.0, 1.0)
        return float(np.hypot(*(points + share[:, None] * edges).T).min())

    @property
    def circumscribed_radius(self) -> float:
        """Distance from the centre to the farthest point of the outline, metres."""
        return float(np.hypot(*np.asarray(self.vertices).T).max())

    def at(self, pose: Sequence[float] | ArrayLike) -> Float64Array:
        """Return the vertices (n, 2) in map metres of a robot at ``pose`` (x, y, yaw)."""
        return transform_points(pose, np.asarray(self.vertices))


def _turn(a: Float64Array, b: Float64Array, c: Float64Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _on(a: Float64Array, b: Float64Array, c: Float64Array) -> bool:
    """Whether c, which is on the line through a and b, is between them."""
    return bool((np.minimum(a, b) <= c).all() and (c <= np.maximum(a, b)).all())


def _meet(a: Float64Array, b: Float64Array, c: Float64Array, d: Float64Array) -> bool:
    """Whether the segments a b and c d have a point in common."""
    turns = _turn(a, b, c), _turn(a, b, d), _turn(c, d, a), _turn(c, d, b)
    if turns[0] * turns[1] < 0.0 and turns[2] * turns[3] < 0.0:
        return True
    ends = ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
    return any(turn == 0.0 and _on(*three) for turn, three in zip(turns, ends, strict=True))
