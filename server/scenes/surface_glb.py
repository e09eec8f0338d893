"""The triangles of one chunk of a surface as a GLB file, shaded by their normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.volume.mesh.chunk_mesh import ChunkMesh, shaded
from server.scenes.chunk_glb import LIGHT, glb_bytes

_LIGHT = LIGHT.astype(np.float32)


def surface_glb(mesh: ChunkMesh, colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's triangles as a GLB file, in steps of its places; ``colors`` (n, 3) are those of its vertices."""
    return glb_bytes(mesh.places, shaded(colors, mesh.normals, _LIGHT), mesh.triangles)
