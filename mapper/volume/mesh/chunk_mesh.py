"""Triangles of one chunk of a surface, in compact integer arrays for browsers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float32Array, Float64Array, Int8Array, Int64Array, UInt8Array, UInt16Array
from mapper.core.errors import ConfigError
from mapper.core.parallel import cores, in_parallel, shares
from mapper.volume.kernels.mesh_chunks import number_vertices, shade, write_places
from mapper.volume.mesh.mesh import Mesh

STEPS = 1024  #: vertex positions per voxel
_SHARE = 20_000  # vertices above which a second thread is worthwhile


def linear_of(colors: UInt8Array) -> Float64Array:
    """Convert sRGB colours to linear ones, 0 to 1. Source: IEC 61966-2-1."""
    srgb = colors.astype(np.float64) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


_LINEAR = (255.0 * linear_of(np.arange(256, dtype=np.uint8))).astype(np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class ChunkMesh:
    """Triangles of one chunk: ``places`` (n, 3) uint16 in 1 / 1024 voxels from the centre of its first voxel.

    ``normals`` (n, 3) int8 have a length of about 127. ``triangles`` (m, 3) are vertex indices, uint16 if sufficient,
    counter-clockwise seen from outside. Vertices shared by two chunks have the same position in both, so that there are
    no gaps.
    """

    places: UInt16Array
    normals: Int8Array
    triangles: NDArray[np.unsignedinteger[Any]]

    def equals(self, other: ChunkMesh) -> bool:
        """Return whether all arrays are equal."""
        return all(
            np.array_equal(a, b)
            for a, b in (
                (self.triangles, other.triangles), (self.places, other.places), (self.normals, other.normals),
            )
        )  # fmt: skip


def chunk_meshes(mesh: Mesh, ends: Int64Array, firsts: Float64Array, resolution: float) -> list[ChunkMesh]:
    """Return parts of a mesh: the triangles up to each of ``ends`` (g,), starting at the end before.

    ``firsts`` (g, 3) are the origins, in voxels from 0 of the map, of each part's vertex positions.
    """
    n, m = len(mesh.vertices), len(mesh.triangles)
    numbered, used = np.empty((m, 3), dtype=np.int32), np.empty(3 * m, dtype=np.int32)
    starts = np.empty(len(ends) + 1, dtype=np.int64)
    part_of = np.full(n, -1, dtype=np.int32)
    number_vertices(mesh.triangles, ends, part_of, np.empty(n, dtype=np.int32), numbered, used, starts)
    places = np.empty((starts[-1], 3), dtype=np.uint16)
    normals = np.empty((starts[-1], 3), dtype=np.int8)
    in_parallel(
        [
            partial(
                write_places, mesh.vertices, mesh.normals, used, starts[a : b + 1], firsts[a:b], resolution, STEPS,
                places[starts[a] :], normals[starts[a] :],
            )
            for a, b in shares(len(ends), min(cores(), 1 + int(starts[-1]) // _SHARE))
        ]
    )  # fmt: skip
    parts, first = [], 0
    # Copies, because a part outlives the mesh when other parts are replaced.
    for end, a, b in zip(ends.tolist(), starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        kind = np.uint16 if b - a <= 1 << 16 else np.uint32
        parts.append(ChunkMesh(places[a:b].copy(), normals[a:b].copy(), numbered[first:end].astype(kind)))
        first = end
    return parts


def cut_between(mesh: ChunkMesh, low: ArrayLike, high: ArrayLike) -> ChunkMesh | None:
    """Return the triangles with all corners in ``low`` … ``high`` (3,), the same object if that is all of them.

    None if there are none.
    """
    is_kept = np.all((mesh.places >= np.asarray(low)) & (mesh.places <= np.asarray(high)), axis=1)
    if is_kept.all():
        return mesh
    triangles = mesh.triangles[is_kept[mesh.triangles].all(axis=1)]
    return ChunkMesh(mesh.places, mesh.normals, triangles) if len(triangles) else None


def shaded(colors: UInt8Array, normals: Int8Array, light: Float32Array) -> UInt8Array:
    """Apply lighting to the colours (n, 3) of a surface, like :func:`mapper.volume.mesh.textbook.shaded`.

    Raises :class:`ConfigError` for arrays of other shapes.
    """
    if colors.shape != normals.shape or colors.shape[1:] != (3,) or light.shape != (6,):
        raise ConfigError(
            "mesh.shape",
            f"Colours and normals are (n, 3), light is (6,), not {colors.shape}, {normals.shape} and {light.shape}.",
        )
    out = np.empty((len(colors), 4), dtype=np.uint8)
    shade(colors, normals, _LINEAR, light, out)
    return out
