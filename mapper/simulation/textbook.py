"""Rays in a world in three dimensions, in plain NumPy: the kernel must return the same.

A ray p = o + t·d meets a flat face where n · (o + t·d) = n · v, with n the face's normal and v one of its corners, if
that point is inside the face; for this test the coordinate along which n is greatest is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]


def normal_of(face: Float64Array) -> Float64Array:
    """Return a normal (3,) of a flat polygon (n, 3), twice its area long (Newell's method)."""
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
    """Return how far a ray goes to a flat polygon (n, 3), infinite where it misses it."""
    normal = normal_of(face)
    towards = float(normal @ direction)
    if towards == 0.0:
        return math.inf
    t = float(normal @ (face[0] - origin)) / towards
    kept = [axis for axis in range(3) if axis != int(np.argmax(np.abs(normal)))]
    place = (origin + t * direction)[kept]
    return t if t >= 0.0 and is_inside(face[:, kept], place) else math.inf


def cast_ray(faces: Iterable[Float64Array], origin: Float64Array, direction: Float64Array, range_max: float) -> float:
    """Return how far a ray goes to the nearest of some faces or to the ground z = 0, infinite beyond ``range_max``."""
    ground = -origin[2] / direction[2] if direction[2] < 0.0 <= origin[2] else math.inf
    nearest = min([ground, *(distance_to_face(face, origin, direction) for face in faces)])
    return nearest if nearest <= range_max else math.inf
