"""Areas of polygons on a map, by their corners."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

Corner = tuple[float, float]


def area_of(corners: Sequence[Corner]) -> float:
    """Return the area of a polygon, positive where its corners are counter-clockwise: the shoelace formula."""
    return 0.5 * sum(one[0] * two[1] - two[0] * one[1] for one, two in _sides(corners))


def centroid(corners: Sequence[Corner]) -> Corner:
    """Return the centroid of a polygon whose area is not 0."""
    origin_x, origin_y = corners[0]  # far from the map's origin the products would lose digits
    near = [(x - origin_x, y - origin_y) for x, y in corners]
    sum_x = sum_y = 0.0
    for (x0, y0), (x1, y1) in _sides(near):
        cross = x0 * y1 - x1 * y0
        sum_x += (x0 + x1) * cross
        sum_y += (y0 + y1) * cross
    scale = 6.0 * area_of(near)
    return origin_x + sum_x / scale, origin_y + sum_y / scale


def _sides(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    return list(pairwise([*corners, corners[0]]))
