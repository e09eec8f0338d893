"""Marching cubes as in the paper, cell by cell, and conversion and lighting of mesh parts.

Source: Lorensen & Cline, Marching cubes: a high resolution 3D surface construction algorithm, SIGGRAPH 1987; the
polygons of a cell are those of :func:`mapper.volume.mesh.cube_cases.polygons`.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array, Int8Array, Int64Array, UInt8Array, UInt16Array
from mapper.volume.mesh.cube_cases import corners_of, polygons
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.occupancy.textbook import CENTRE

Index = tuple[int, int, int]


def march(distances: Float32Array, known: np.ndarray, corner: Int64Array, resolution: float) -> Mesh:
    """Return the surface where the distances (nz, ny, nx) are 0, in the cells whose eight corners are ``known``.

    ``corner`` (3,), x y z, is the key of the first voxel.
    """
    numbers: dict[tuple[Index, Index], int] = {}
    vertices: list[Float32Array] = []
    normals: list[Float64Array] = []
    triangles: list[list[int]] = []
    for z, y, x in itertools.product(*(range(n - 1) for n in distances.shape)):
        corners = [(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) for c in range(8)]
        if not all(known[k, j, i] for i, j, k in corners):
            continue
        case = sum(1 << c for c, (i, j, k) in enumerate(corners) if distances[k, j, i] < 0.0)
        for polygon in polygons(case):
            outline = []
            for edge in polygon:
                a, b = (corners[c] for c in corners_of(edge))
                if (a, b) not in numbers:
                    numbers[a, b] = len(vertices)
                    vertex, normal = vertex_between(distances, known, a, b)
                    vertices.append(((vertex + (corner - CENTRE + 0.5)) * resolution).astype(np.float32))
                    normals.append(normal)
                outline.append(numbers[a, b])
            triangles += [[outline[0], outline[n], outline[n + 1]] for n in range(1, len(outline) - 1)]
    return Mesh(
        np.array(vertices, dtype=np.float32).reshape(-1, 3),
        np.array(normals, dtype=np.float32).reshape(-1, 3),
        np.array(triangles, dtype=np.int32).reshape(-1, 3),
    )


def vertex_between(distances: Float32Array, known: np.ndarray, a: Index, b: Index) -> tuple[Float64Array, Float64Array]:
    """Return the vertex (3,) on the edge between two voxels, in voxels of the box, and its normal (3,)."""
    da, db = distances[a[::-1]], distances[b[::-1]]
    t = da / (da - db)
    before, after = gradient(distances, known, a), gradient(distances, known, b)
    slope = before + float(t) * (after - before)
    length = math.sqrt(float(slope @ slope))
    along = np.array(b, dtype=np.float64) - np.array(a)
    normal = slope / length if length > 0.0 else along * np.sign(float(db) - float(da))
    return np.array(a) + float(t) * along, normal


def gradient(distances: Float32Array, known: np.ndarray, at: Index) -> Float64Array:
    """Return the gradient (3,) per voxel: central differences, or one-sided ones towards a known neighbour, or 0."""
    out = np.zeros(3)
    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        sides = []
        for side in (at + step, at - step):
            inside = all(0 <= c < n for c, n in zip(side, distances.shape[::-1], strict=True))
            there = (side[2], side[1], side[0])
            sides.append(float(distances[there]) if inside and known[there] else None)
        after, before = sides
        here = float(distances[at[::-1]])
        if after is not None and before is not None:
            out[axis] = 0.5 * (after - before)
        elif after is not None:
            out[axis] = after - here
        elif before is not None:
            out[axis] = here - before
    return out


def part_of_mesh(
    mesh: Mesh, triangles: NDArray[np.signedinteger[Any]], first: Float64Array, resolution: float, steps: int
) -> tuple[UInt16Array, Int8Array, NDArray[np.int64]]:
    """Return the positions (n, 3), normals (n, 3) and triangles (m, 3) of a part of a mesh, in order of use.

    Positions are integers, ``steps`` per voxel, from ``first`` (3,), voxels; normals are multiplied by 127.
    """
    vertices, begin, number = np.unique(triangles, return_index=True, return_inverse=True)
    order = np.argsort(begin)
    used = vertices[order]
    rank = np.argsort(order)
    places = np.rint((mesh.vertices[used].astype(np.float64) / resolution - first) * steps)
    normals = np.rint(np.float32(127.0) * mesh.normals[used])
    return np.clip(places, 0, 65535).astype(np.uint16), normals.astype(np.int8), rank[number.reshape(triangles.shape)]


def linear_of(colors: UInt8Array) -> Float64Array:
    """Convert sRGB colours to linear ones, 0 to 1, for each of the 256 values. Source: IEC 61966-2-1."""
    values = [k / 255.0 for k in range(256)]
    return np.array([v / 12.92 if v <= 0.04045 else math.pow((v + 0.055) / 1.055, 2.4) for v in values])[colors]


def shaded(colors: UInt8Array, normals: Int8Array, light: Float32Array) -> UInt8Array:
    """Apply lighting to the colours (n, 3), sRGB, of a surface with ``normals`` (n, 3); return (n, 4) linear RGB and
    alpha.

    ``light`` (6,) is that of faces towards −x, +x, −y, +y, −z, +z. In between it is the mean weighted by the squares of
    the normal's components, to the power of 2.2, because equal steps of the sRGB value look equal. Source: McTaggart,
    Half-Life 2 / Valve Source Shading, GDC 2004 (ambient cube).
    """
    away = normals.astype(np.float32)
    squares = away * away
    squares /= np.maximum(squares.sum(axis=1, keepdims=True), 1.0)
    bright = (squares * np.where(away < 0.0, light[0::2], light[1::2])).sum(axis=1)
    shades = np.full((len(colors), 4), 255, dtype=np.uint8)
    shades[:, :3] = np.round(255.0 * linear_of(colors) * (bright.astype(np.float64) ** 2.2)[:, None])
    return shades
