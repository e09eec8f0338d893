"""Ray casts, beams and path relaxation in plain NumPy; the kernels must return the same.

A ray p = o + t·d hits a flat face where n · (o + t·d) = n · v, with n the face's normal and v one of its corners, if
that point is inside the face; for this test the coordinate with the largest component of n is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.simulation.kernels.lidar import VERTEX_SLACK
from mapper.simulation.lidar import RANGE_MIN
from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import World


def prism_faces(outline: Polygon, bottom: float, top: tuple[float, float, float]) -> list[Float64Array]:
    """Return bottom, top and sides of a prism as 3D polygons (n, 3), counter-clockwise seen from outside."""
    a, b, c = top
    low = np.column_stack([outline, np.full(len(outline), bottom)])
    high = np.column_stack([outline, a + outline @ (b, c)])
    after = np.roll(np.arange(len(outline)), -1)
    sides = [np.array([low[k], low[j], high[j], high[k]]) for k, j in enumerate(after)]
    return [low[::-1].copy(), high, *sides]


def normal_of(face: Float64Array) -> Float64Array:
    """Return the normal (3,) of a flat polygon (n, 3), with a length of twice its area (Newell's method)."""
    total = np.zeros(3)
    for here, there in zip(face, np.roll(face, -1, axis=0), strict=True):
        total += np.cross(here, there)
    return total


def is_inside(polygon: Float64Array, point: Float64Array) -> bool:
    """Return whether a line from a point (2,) crosses the border of a polygon (n, 2) an odd number of times."""
    inside = False
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (ay > point[1]) != (by > point[1]) and point[0] < ax + (point[1] - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside


def distance_to_face(face: Float64Array, origin: Float64Array, direction: Float64Array) -> float:
    """Return the distance along a ray to a flat polygon (n, 3), infinite if it misses."""
    normal = normal_of(face)
    towards = float(normal @ direction)
    if towards == 0.0:
        return math.inf
    t = float(normal @ (face[0] - origin)) / towards
    axes = [axis for axis in range(3) if axis != int(np.argmax(np.abs(normal)))]
    place = (origin + t * direction)[axes]
    return t if t >= 0.0 and is_inside(face[:, axes], place) else math.inf


def cast_ray(faces: Iterable[Float64Array], origin: Float64Array, direction: Float64Array, range_max: float) -> float:
    """Return the distance along a ray to the nearest face or the ground z = 0, infinite beyond ``range_max``."""
    ground = -origin[2] / direction[2] if direction[2] < 0.0 <= origin[2] else math.inf
    nearest = min([ground, *(distance_to_face(face, origin, direction) for face in faces)])
    return nearest if nearest <= range_max else math.inf


def relaxed(world: World, path: Float64Array, least: float, rounds: int) -> Float64Array:
    """Return ``path`` (n, 2), metres, with relaxed corners and fixed ends.

    In each of ``rounds`` rounds each point moves halfway to the midpoint of its neighbours, unless its clearance there
    is less than both ``least`` metres and its initial value: Laplacian smoothing with a constraint.
    """
    path = path.copy()
    floor = np.minimum(world.clearance(path), least)
    for _ in range(rounds):
        moved = path.copy()
        moved[1:-1] = 0.5 * path[1:-1] + 0.25 * (path[:-2] + path[2:])
        is_clear = world.clearance(moved) >= floor
        path[is_clear] = moved[is_clear]
    return path


def cast_beams(segments: Float64Array, x: float, y: float, bearings: Float64Array, range_max: float) -> Float64Array:
    """Return the distance of each beam (n,) from (x, y) to the nearest edge, +inf beyond ``range_max`` metres.

    ``segments`` (m, 4) as in :mod:`mapper.simulation.kernels.raycast`; ``bearings`` (n,) radians, map frame. Every beam
    is intersected with every edge: a + u·e = t·d (O'Rourke, Computational Geometry in C, section 7.2).
    """
    ax, ay = segments[:, 0] - x, segments[:, 1] - y
    ex, ey = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    dx, dy = np.cos(bearings)[:, np.newaxis], np.sin(bearings)[:, np.newaxis]
    d_cross_e = dx * ey - dy * ex
    crosses = np.abs(d_cross_e) >= 1e-12
    divisor = np.where(crosses, d_cross_e, 1.0)
    t, u = (ax * ey - ay * ex) / divisor, (ax * dy - ay * dx) / divisor
    on_edge = crosses & (t >= 0.0) & (t <= range_max) & (u >= -VERTEX_SLACK) & (u <= 1.0 + VERTEX_SLACK)
    nearest: Float64Array = np.where(on_edge, t, np.inf).min(axis=1, initial=np.inf)
    return nearest


def noisy(ranges: Float64Array, noise: Float64Array, sigma: float, range_max: float) -> NDArray[np.float32]:
    """Return the readings of ``ranges`` (n,), metres, with ``sigma`` metres times ``noise`` (n,), as reported by a
    lidar.

    None is below RANGE_MIN; readings beyond ``range_max`` are +inf.
    """
    readings = np.maximum(ranges + sigma * noise, RANGE_MIN).astype(np.float32)
    readings[readings > range_max] = np.inf
    return readings
