"""Parts of a mesh with whole numbers as places, and the light on them, in plain NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array, Int8Array, UInt8Array, UInt16Array
from mapper.volume.mesh.mesh import Mesh


def part_of_mesh(
    mesh: Mesh, triangles: NDArray[np.signedinteger[Any]], first: Float64Array, resolution: float, steps: int
) -> tuple[UInt16Array, Int8Array, NDArray[np.int64]]:
    """Return the places (n, 3), normals (n, 3) and triangles (m, 3) of a part of a mesh, in the order of their use.

    Places are whole numbers of ``steps`` in a voxel from ``first`` (3,), voxels; normals are multiplied by 127.
    """
    vertices, begin, number = np.unique(triangles, return_index=True, return_inverse=True)
    order = np.argsort(begin)
    used = vertices[order]
    rank = np.argsort(order)
    places = np.rint((mesh.vertices[used].astype(np.float64) / resolution - first) * steps)
    normals = np.rint(np.float32(127.0) * mesh.normals[used])
    return np.clip(places, 0, 65535).astype(np.uint16), normals.astype(np.int8), rank[number.reshape(triangles.shape)]


def linear_of(colors: UInt8Array) -> Float64Array:
    """Return sRGB colours as linear ones, 0 to 1. Source: IEC 61966-2-1."""
    srgb = colors.astype(np.float64) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def shaded(colors: UInt8Array, normals: Int8Array, light: Float32Array) -> UInt8Array:
    """Return colours (n, 3), sRGB, as those (n, 4) of a surface with ``normals`` (n, 3), linear RGB and alpha.

    ``light`` (6,) is that of faces towards −x, +x, −y, +y, −z, +z, between which the light is the mean weighted by the
    squares of the normal's coordinates, to the power of 2.2, since equal steps of the sRGB value look equal. Source:
    McTaggart, Half-Life 2 / Valve Source Shading, GDC 2004 (ambient cube).
    """
    away = normals.astype(np.float32)
    squares = away * away
    squares /= np.maximum(squares.sum(axis=1, keepdims=True), 1.0)
    bright = (squares * np.where(away < 0.0, light[0::2], light[1::2])).sum(axis=1)
    shades = np.full((len(colors), 4), 255, dtype=np.uint8)
    shades[:, :3] = np.round(255.0 * linear_of(colors) * (bright.astype(np.float64) ** 2.2)[:, None])
    return shades
