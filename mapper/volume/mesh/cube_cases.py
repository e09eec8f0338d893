"""Derivation of the marching cubes cases: the triangles of a cube for the signs of its eight corners.

Source: Lorensen & Cline, Marching cubes: a high resolution 3D surface construction algorithm, SIGGRAPH 1987. Faces with
alternating corner signs − + − + are ambiguous (Dürst 1988); here the two negative corners of such a face are always
separated. This depends only on the face, so the two cubes that share it agree and the surface has no holes.

Corner c of a cube is at x = c & 1, y = c >> 1 & 1, z = c >> 2. Edge e is parallel to axis e >> 2; bits 0 and 1 of e are
the coordinates of its first corner on the other axes, the lower axis first. Bit c of case k is set if corner c is
negative.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from mapper.volume.kernels.types import CubeTables

# The corners of the faces, counter-clockwise seen from outside.
FACES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))


def edge_between(a: int, b: int) -> int:
    """Return the edge between two corners that differ along one axis."""
    axis, first = (a ^ b).bit_length() - 1, min(a, b)
    low = (first >> (1 if axis == 0 else 0)) & 1
    high = (first >> (1 if axis == 2 else 2)) & 1
    return axis * 4 + low + 2 * high


def corners_of(edge: int) -> tuple[int, int]:
    """Return the first and the last corner of an edge."""
    axis, low, high = edge >> 2, edge & 1, edge >> 1 & 1
    first = low << (1 if axis == 0 else 0) | high << (1 if axis == 2 else 2)
    return first, first | 1 << axis


def polygons(case: int) -> list[list[int]]:
    """Return the polygons of a case as sequences of edges, counter-clockwise seen from the positive side.

    On each face, the outline connects every edge that enters a run of negative corners with the edge that leaves it.
    """
    following: dict[int, int] = {}
    for face in FACES:
        negative = [bool(case >> corner & 1) for corner in face]
        for k in range(4):
            if negative[k] or not negative[(k + 1) % 4]:
                continue
            end = next(n for n in range(k + 1, k + 5) if not negative[(n + 1) % 4])
            comes = edge_between(face[k], face[(k + 1) % 4])
            leaves = edge_between(face[end % 4], face[(end + 1) % 4])
            following[comes] = leaves
    loops = []
    while following:
        outline = [min(following)]
        while (edge := following.pop(outline[-1])) != outline[0]:
            outline.append(edge)
        loops.append(outline)
    return loops


def triangles(case: int) -> list[tuple[int, int, int]]:
    """Return the triangles of a case as edges: each polygon as a fan."""
    return [(polygon[0], polygon[k], polygon[k + 1]) for polygon in polygons(case) for k in range(1, len(polygon) - 1)]


@cache
def cube_tables() -> CubeTables:
    """Return the cases as arrays for kernels."""
    all_cases = [triangles(case) for case in range(256)]
    counts = np.array([len(polygons) for polygons in all_cases], dtype=np.uint8)
    edges = np.zeros((256, 3 * int(counts.max())), dtype=np.uint8)
    for case, polygons in enumerate(all_cases):
        edges[case, : 3 * len(polygons)] = [edge for triangle in polygons for edge in triangle]
    firsts = np.array([corners_of(edge)[0] for edge in range(12)], dtype=np.uint8)
    bits = np.array([byte.bit_count() for byte in range(256)], dtype=np.uint8)
    return CubeTables(counts, edges, firsts, bits)
