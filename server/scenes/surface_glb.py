"""The triangles of one chunk of a surface as a GLB file, shaded by their normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.volume.surface_chunks import ChunkMesh
from server.scenes.chunk_glb import LIGHT, glb_bytes, linear_of

_LINEAR = (255.0 * linear_of(np.arange(256, dtype=np.uint8))).astype(np.float32)
_LIGHT = LIGHT.astype(np.float32)


def shades_of(colors: NDArray[np.uint8], normals: NDArray[np.int8]) -> NDArray[np.uint8]:
    """Return colours (n, 3), sRGB, as those (n, 4) of a surface with ``normals`` (n, 3), linear RGB and alpha.

    Where a normal is along an axis the light is that of a voxel's face of this side; the light between them is the
    mean weighted by the squares of the normal's coordinates. Source: McTaggart, Half-Life 2 / Valve Source Shading,
    GDC 2004 (ambient cube).
    """
    away = normals.astype(np.float32)
    squares = away * away
    squares /= np.maximum(squares.sum(axis=1, keepdims=True), 1.0)
    light = (squares * np.where(away < 0.0, _LIGHT[0::2], _LIGHT[1::2])).sum(axis=1)
    shades = np.full((len(colors), 4), 255, dtype=np.uint8)
    shades[:, :3] = np.round(_LINEAR[colors] * (light ** np.float32(2.2))[:, None])
    return shades


def surface_glb(mesh: ChunkMesh, colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's triangles as a GLB file, in steps of its places; ``colors`` (n, 3) are those of its vertices."""
    return glb_bytes(mesh.places, shades_of(colors, mesh.normals), mesh.triangles)
