"""Splitting of a mesh into parts, and lighting; numba twins of :mod:`mapper.volume.mesh.textbook`."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import (
    Float32Array,
    Float64Array,
    Int8Array,
    Int32Array,
    Int64Array,
    UInt8Array,
    UInt16Array,
)
from mapper.core.jit import jit


@jit
def number_vertices(
    triangles: Int32Array, ends: Int64Array, part_of: Int32Array, numbers: Int32Array, out: Int32Array,
    out_used: Int32Array, out_starts: Int64Array,
) -> None:  # fmt: skip
    """Write the triangles (m, 3) of parts with vertex indices per part, in order of use.

    Part i has the triangles up to ``ends`` (g,), starting at the end of the part before. ``out_used`` (3 m,) are the
    vertices of all parts in turn, and ``out_starts`` (g + 1,) the first vertex of each. ``part_of`` (n,), −1 for all
    vertices, and ``numbers`` (n,) are overwritten.
    """
    count, first = 0, 0
    out_starts[0] = 0
    for part in range(ends.shape[0]):
        for i in range(first, ends[part]):
            for k in range(3):
                vertex = triangles[i, k]
                if part_of[vertex] != part:
                    part_of[vertex] = part
                    numbers[vertex] = count - out_starts[part]
                    out_used[count] = vertex
                    count += 1
                out[i, k] = numbers[vertex]
        first = ends[part]
        out_starts[part + 1] = count


@jit
def write_places(
    vertices: Float32Array, normals: Float32Array, used: Int32Array, starts: Int64Array, firsts: Float64Array,
    resolution: float, steps: float, out_places: UInt16Array, out_normals: Int8Array,
) -> None:  # fmt: skip
    """Write the vertices of parts as integers, ``steps`` per voxel, and their normals times 127.

    ``firsts`` (g, 3) are the origins of each part in voxels; ``used`` and ``starts`` (g + 1,) are those of
    :func:`number_vertices`. ``out_places`` and ``out_normals`` start with the first vertex of the first part.
    """
    for part in range(firsts.shape[0]):
        for i in range(starts[part], starts[part + 1]):
            vertex, to = used[i], i - starts[0]
            for k in range(3):
                place = np.rint((np.float64(vertices[vertex, k]) / resolution - firsts[part, k]) * steps)
                out_places[to, k] = np.uint16(min(max(place, 0.0), 65535.0))
                out_normals[to, k] = np.int8(np.rint(np.float32(127.0) * normals[vertex, k]))


@jit
def shade(colors: UInt8Array, normals: Int8Array, linear: Float32Array, light: Float32Array, out: UInt8Array) -> None:
    """Apply ambient cube lighting to the sRGB colours (n, 3) of a surface; write (n, 4) linear RGB and alpha.

    ``linear`` (256,) are the linear values 0 to 255 of sRGB, ``light`` (6,) that from −x, +x, −y, +y, −z, +z.
    """
    for i in range(colors.shape[0]):
        total, weighted = np.float32(0.0), np.float32(0.0)
        for k in range(3):
            away = np.float32(normals[i, k])
            square = away * away
            total += square
            weighted += square * light[2 * k + (1 if away >= 0.0 else 0)]
        bright = (weighted / max(total, np.float32(1.0))) ** np.float32(2.2)
        for k in range(3):
            out[i, k] = np.uint8(np.rint(linear[colors[i, k]] * bright))
        out[i, 3] = 255
