"""Building blocks of floor plans: each function returns polygons (n, 2) in metres, counter-clockwise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import transform_points

Polygon = NDArray[np.float64]
Point = tuple[float, float]


def rect(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    """Return the axis-aligned rectangle between two corners."""
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def box(x: float, y: float, width: float, depth: float, yaw: float = 0.0) -> Polygon:
    """Return a rectangle centred on (x, y), ``width`` along its own x axis, rotated by ``yaw`` radians."""
    return transform_points((x, y, yaw), rect(-width / 2, -depth / 2, width / 2, depth / 2))


def disc(x: float, y: float, radius: float, corners: int = 24) -> Polygon:
    """Return a regular polygon with ``corners`` corners on a circle."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=-1)


def star(x: float, y: float, outer: float, inner: float, spikes: int) -> Polygon:
    """Return a star with its spikes on the circle ``outer`` and its notches on the circle ``inner``."""
    angle = np.pi * np.arange(2 * spikes) / spikes
    radius = np.where(np.arange(2 * spikes) % 2 == 0, outer, inner)
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=-1)


def wall(a: Point, b: Point, thickness: float, doors: Sequence[tuple[float, float]] = ()) -> list[Polygon]:
    """Return the pieces of a wall from ``a`` to ``b``, ``thickness`` wide about that line.

    ``doors`` are openings as (from, to), metres along the wall, in order.
    """
    (ax, ay), (bx, by) = a, b
    length, yaw = float(np.hypot(bx - ax, by - ay)), float(np.arctan2(by - ay, bx - ax))
    cuts = [0.0, *(metre for door in doors for metre in door), length]
    return [
        transform_points((ax, ay, yaw), rect(start, -thickness / 2, stop, thickness / 2))
        for start, stop in zip(cuts[::2], cuts[1::2], strict=True)
        if stop > start
    ]


def outer_walls(x0: float, y0: float, x1: float, y1: float, thickness: float) -> list[Polygon]:
    """Return four walls with the box as their outer faces."""
    return [
        rect(x0, y0, x1, y0 + thickness),
        rect(x0, y1 - thickness, x1, y1),
        rect(x0, y0, x0 + thickness, y1),
        rect(x1 - thickness, y0, x1, y1),
    ]


def legs(x: float, y: float, width: float, depth: float, yaw: float = 0.0, thickness: float = 0.06) -> list[Polygon]:
    """Return the four legs of a table centred on (x, y), the only parts that a low lidar sees."""
    half_w, half_d = (width - thickness) / 2, (depth - thickness) / 2
    corners = np.array([(sx * half_w, sy * half_d) for sx in (-1, 1) for sy in (-1, 1)])
    return [box(float(cx), float(cy), thickness, thickness, yaw) for cx, cy in transform_points((x, y, yaw), corners)]
