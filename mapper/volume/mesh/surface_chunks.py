"""Mesh of a surface in chunks of 32³ voxels, of which only changed ones are recomputed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mapper.core.array_types import Int32Array, Int64Array
from mapper.volume.blocks import KEYS
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.mesh.chunk_mesh import ChunkMesh, chunk_meshes
from mapper.volume.mesh.meshing import blocks_of_change, surface_of_groups
from mapper.volume.surface.tsdf import TsdfVolume

_AT_ONCE = 128  #: chunks meshed together
ChunkKey = tuple[int, int, int]  #: the key of a chunk's first voxel, divided by 32


class SurfaceChunks:
    """The meshes of the non-empty chunks; the object of a changed chunk is replaced.

    :meth:`note_change` records changes, and :meth:`work` recomputes the meshes.
    """

    def __init__(self) -> None:
        self.chunks: dict[ChunkKey, ChunkMesh] = {}
        self._pending: set[int] = set()

    @property
    def pending(self) -> int:
        """Number of chunks to be recomputed."""
        return len(self._pending)

    @property
    def n_triangles(self) -> int:
        """Total number of triangles."""
        return sum(len(chunk.triangles) for chunk in self.chunks.values())

    def note_change(self, volume: TsdfVolume, slots: Int32Array | None) -> None:
        """Record that blocks (n,) have changed, None for all."""
        if slots is None:
            self._pending = {*_codes_of_blocks(volume).tolist(), *map(_code, self.chunks)}
        elif len(slots):
            self._pending |= set(np.unique(_codes_of_blocks(volume)[blocks_of_change(volume, slots)]).tolist())

    def work(self, volume: TsdfVolume, is_over: Callable[[], bool] = lambda: False) -> None:
        """Recompute pending chunks until ``is_over`` returns true."""
        if not self._pending:
            return
        codes = _codes_of_blocks(volume)
        order = np.argsort(codes, kind="stable").astype(np.int32)
        pending = np.array(sorted(self._pending), dtype=np.int64)
        begins, lasts = (np.searchsorted(codes[order], pending, side=side) for side in ("left", "right"))
        for a in range(0, len(pending), _AT_ONCE):
            some = slice(a, a + _AT_ONCE)
            groups = [order[first:last] for first, last in zip(begins[some], lasts[some], strict=True)]
            mesh, ends = surface_of_groups(volume, groups)
            keys = [_key(code) for code in pending[some].tolist()]
            # The centres of the first voxels of the chunks, in voxels from 0 of the map.
            firsts = CHUNK * np.array(keys) - KEYS // 2 + 0.5
            for key, chunk in zip(keys, chunk_meshes(mesh, ends, firsts, volume.config.resolution), strict=True):
                self._put(key, chunk)
            self._pending.difference_update(pending[some].tolist())
            if is_over():
                return

    def _put(self, key: ChunkKey, chunk: ChunkMesh) -> None:
        if not len(chunk.triangles):
            self.chunks.pop(key, None)
            return
        before = self.chunks.get(key)
        if before is None or not chunk.equals(before):
            self.chunks[key] = chunk


_BITS = 11  # per coordinate of a chunk


def _codes_of_blocks(volume: TsdfVolume) -> Int64Array:
    """Return the chunk code (n,) of each block: z, y and x packed in bits."""
    x, y, z = (volume.blocks.corners // CHUNK).T
    codes: Int64Array = (z << 2 * _BITS) | (y << _BITS) | x
    return codes


def _code(key: ChunkKey) -> int:
    return key[2] << 2 * _BITS | key[1] << _BITS | key[0]


def _key(code: int) -> ChunkKey:
    low = (1 << _BITS) - 1
    return code & low, code >> _BITS & low, code >> 2 * _BITS
