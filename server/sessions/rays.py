"""Lines of sight of clicks into 3D views."""

from __future__ import annotations

import math

from msgspec import Struct

from server.sessions.drawings import Point


class MeasureRay(Struct):
    """A click into the 3D view of a page that measures, which only the service sends.

    Its line of sight goes from ``origin`` along ``direction``, and ends at ``met`` on a column of the map, map metres;
    None: it meets none.
    """

    origin: Point
    direction: Point
    met: Point | None


def on_floor(origin: Point, direction: Point) -> tuple[float, float] | None:
    """Return where a line of sight comes down (or up) to the floor, x and y, metres; None: nowhere."""
    (ox, oy, oz), (dx, dy, dz) = origin, direction
    if dz * oz >= 0.0:
        return None
    x, y = ox - dx * oz / dz, oy - dy * oz / dz
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
