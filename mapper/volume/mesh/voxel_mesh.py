"""The outside of a map's occupied voxels as a mesh of rectangles."""

from __future__ import annotations

import numpy as np

from mapper.volume.mesh.faces import CENTRE, CHUNK, VoxelFaces, chunks_of, face_rule, triangles_of
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.occupancy.volume import OccupancyVolume

_NORMALS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]], dtype=np.float32)


def voxel_mesh(volume: OccupancyVolume) -> Mesh:
    """Return the faces of occupied voxels towards others, neighbouring ones merged to rectangles of two triangles.

    Each rectangle has four vertices of its own with the normal of its side.
    """
    rule = face_rule(volume, -np.inf, np.inf, base=0.0, band=1e9, colours=1)
    faces = VoxelFaces()
    faces.update(volume, rule, chunks_of(volume))
    vertices, normals = [np.empty((0, 3), np.float32)], [np.empty((0, 3), np.float32)]
    triangles, n = [np.empty((0, 3), np.int32)], 0
    for key, quads in faces.chunks.items():
        corners, found = triangles_of(quads)
        place = (corners + (np.array(key) * CHUNK - CENTRE)) * volume.config.resolution
        vertices.append(place.astype(np.float32))
        normals.append(np.repeat(_NORMALS[quads[:, 0]], 4, axis=0))
        triangles.append(found.astype(np.int32) + n)
        n += len(corners)
    return Mesh(np.concatenate(vertices), np.concatenate(normals), np.concatenate(triangles))
