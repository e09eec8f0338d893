"""Triangle meshes: extruded polygons, boxes and an arrow. NumPy only.

A mesh is ``vertices`` (V, 3) float32 in metres and ``faces`` (F, 3) uint32, counter-clockwise seen from outside.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]

# A box's corners in units of its sides, and its five visible faces (the bottom is not visible).
_CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
_FACES = np.array(
    [(4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
)


def boxes(low: NDArray[np.float64], high: NDArray[np.float64]) -> Mesh:
    """Return upright boxes between the corners ``low`` and ``high`` (n, 3), without their bottoms."""
    vertices = low[:, None, :] + _CORNERS * (high - low)[:, None, :]
    faces = _FACES + 8 * np.arange(len(low))[:, None, None]
    return vertices.reshape(-1, 3).astype(np.float32), faces.reshape(-1, 3).astype(np.uint32)


def extruded(polygons: Iterable[NDArray[np.float64]], height: float) -> Mesh:
    """Return simple polygons (n, 2), counter-clockwise, as solids of ``height`` metres without their bottoms."""
    vertices, faces, count = [], [], 0
    for polygon in polygons:
        n = len(polygon)
        vertices += [np.column_stack([polygon, np.full(n, z)]) for z in (0.0, height)]
        i = np.arange(n)
        j = (i + 1) % n
        sides = np.concatenate([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
        faces += [sides + count, triangles(polygon) + n + count]
        count += 2 * n
    if not vertices:
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32)


def triangles(polygon: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the triangles (n − 2, 3), as indices, of a simple counter-clockwise polygon (n, 2).

    Source: ear clipping (Meisters 1975, "Polygons have ears"); quadratic, for polygons of a few dozen corners.
    """
    left = list(range(len(polygon)))
    corners: list[tuple[int, int, int]] = []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(polygon, left, k)), 0)  # 0 for a degenerate remainder
        corners.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    corners.append((left[0], left[1], left[2]))
    return np.array(corners, dtype=np.int64)


def _is_ear(polygon: NDArray[np.float64], left: list[int], k: int) -> bool:
    """Return whether corner ``k`` of those in ``left`` is convex and its triangle contains no other corner."""
    corners = (left[k - 1], left[k], left[(k + 1) % len(left)])
    a, b, c = polygon[list(corners)]
    if _cross(a, b, c) <= 0.0:
        return False
    others = polygon[[i for i in left if i not in corners]]
    inside = (_cross(a, b, others) >= 0.0) & (_cross(b, c, others) >= 0.0) & (_cross(c, a, others) >= 0.0)
    # A corner at the same point as one of the ear's corners does not count, because polygons may touch themselves.
    distinct = (others[:, None, :] != np.stack([a, b, c])).any(axis=2).all(axis=1)
    return not bool(np.any(inside & distinct))


def _cross(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return twice the signed area of the triangles a, b, c; positive if c is to the left of a → b."""
    return np.asarray((b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0]))


def arrow(length: float, width: float, height: float) -> Mesh:
    """Return a flat arrowhead that points along +x, centred at the origin, ``height`` metres thick."""
    half = length / 2
    outline = np.array([(-half, -width / 2), (half, 0.0), (-half, width / 2), (-half + 0.25 * length, 0.0)])
    return extruded([outline], height)
