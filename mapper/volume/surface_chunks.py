"""The mesh of a surface in chunks of 32³ voxels, of which only those that changed are made again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int32Array, Int64Array
from mapper.volume.blocks import KEYS
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.mesh import Mesh
from mapper.volume.meshing import blocks_of_change, surface_meshes
from mapper.volume.tsdf import TsdfVolume

STEPS = 1024  #: of a vertex's place in one voxel
_AT_ONCE = 48  #: chunks that are meshed together
ChunkKey = tuple[int, int, int]  #: the key of a chunk's first voxel, divided by 32


@dataclass(frozen=True, slots=True, eq=False)
class ChunkMesh:
    """Triangles of one chunk: ``places`` (n, 3) uint16 in 1 / 1024 voxels from the centre of its first voxel.

    ``normals`` (n, 3) int8 have a length of about 127. ``triangles`` (m, 3) are numbers of vertices, uint16 where these
    are enough, anticlockwise seen from outside. Vertices that two chunks share have the same place in both, so that
    there are no gaps between them.
    """

    places: NDArray[np.uint16]
    normals: NDArray[np.int8]
    triangles: NDArray[np.unsignedinteger[Any]]

    def equals(self, other: ChunkMesh) -> bool:
        """Return whether all arrays are the same."""
        return all(
            np.array_equal(a, b)
            for a, b in (
                (self.triangles, other.triangles), (self.places, other.places), (self.normals, other.normals),
            )
        )  # fmt: skip


class SurfaceChunks:
    """The meshes of the chunks that have triangles; an object is replaced when its chunk has changed.

    :meth:`note_change` says what changed, :meth:`work` makes it again.
    """

    def __init__(self) -> None:
        self.chunks: dict[ChunkKey, ChunkMesh] = {}
        self._pending: set[int] = set()

    @property
    def pending(self) -> int:
        """How many chunks are to be made again."""
        return len(self._pending)

    @property
    def n_triangles(self) -> int:
        """Triangles of all chunks."""
        return sum(len(one.triangles) for one in self.chunks.values())

    def note_change(self, volume: TsdfVolume, slots: Int32Array | None) -> None:
        """Note that blocks (n,) have changed, None for all of them."""
        if slots is None:
            self._pending = {*_codes_of_blocks(volume).tolist(), *map(_code, self.chunks)}
        elif len(slots):
            self._pending |= set(np.unique(_codes_of_blocks(volume)[blocks_of_change(volume, slots)]).tolist())

    def work(self, volume: TsdfVolume, is_over: Callable[[], bool] = lambda: False) -> None:
        """Make the pending chunks again, until ``is_over`` after some of them."""
        if not self._pending:
            return
        codes = _codes_of_blocks(volume)
        order = np.argsort(codes, kind="stable").astype(np.int32)
        pending = np.array(sorted(self._pending), dtype=np.int64)
        begins, ends = (np.searchsorted(codes[order], pending, side=side) for side in ("left", "right"))
        for a in range(0, len(pending), _AT_ONCE):
            some = slice(a, a + _AT_ONCE)
            groups = [order[first:last] for first, last in zip(begins[some], ends[some], strict=True)]
            for code, mesh in zip(pending[some].tolist(), surface_meshes(volume, groups), strict=True):
                self._put(code, mesh, volume.config.resolution)
                self._pending.discard(code)
            if is_over():
                return

    def _put(self, code: int, mesh: Mesh, resolution: float) -> None:
        key = _key(code)
        if not len(mesh.triangles):
            self.chunks.pop(key, None)
            return
        # The centre of the first voxel of the chunk, in voxels from 0 of the map.
        first = CHUNK * np.array(key) - KEYS // 2 + 0.5
        places = np.rint((mesh.vertices.astype(np.float64) / resolution - first) * STEPS)
        kind = np.uint16 if len(places) <= 1 << 16 else np.uint32
        made = ChunkMesh(
            np.clip(places, 0, 65535).astype(np.uint16), np.rint(127.0 * mesh.normals).astype(np.int8),
            mesh.triangles.astype(kind),
        )  # fmt: skip
        before = self.chunks.get(key)
        if before is None or not made.equals(before):
            self.chunks[key] = made


def cut_between(mesh: ChunkMesh, low: float, high: float) -> ChunkMesh | None:
    """Return the triangles all of whose corners have a third place ``low`` … ``high``; the same object for all of them.

    None where there are none.
    """
    z = mesh.places[:, 2]
    is_kept = (z >= low) & (z <= high)
    if is_kept.all():
        return mesh
    triangles = mesh.triangles[is_kept[mesh.triangles].all(axis=1)]
    return ChunkMesh(mesh.places, mesh.normals, triangles) if len(triangles) else None


_BITS = 11  # of one coordinate of a chunk


def _codes_of_blocks(volume: TsdfVolume) -> Int64Array:
    """Return the number (n,) of the chunk of each block: z y x in its bits."""
    x, y, z = (volume.blocks.corners // CHUNK).T
    codes: Int64Array = (z << 2 * _BITS) | (y << _BITS) | x
    return codes


def _code(key: ChunkKey) -> int:
    return key[2] << 2 * _BITS | key[1] << _BITS | key[0]


def _key(code: int) -> ChunkKey:
    low = (1 << _BITS) - 1
    return code & low, code >> _BITS & low, code >> 2 * _BITS
