"""Most common class of the points in each voxel, by chunks of drawn voxels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array, UInt8Array
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.occupancy.volume import keys_of

ChunkKey = tuple[int, int, int]  #: the key of a chunk's first voxel, divided by 32
#: For one chunk, the voxel indices (n,), (z · 32 + y) · 32 + x, and their colours (n,).
Painted = Mapping[ChunkKey, tuple[Int64Array, UInt8Array]]


def voxel_classes(points: NDArray[np.float32], classes: NDArray[Any], resolution: float, most: int) -> Painted:
    """Return the most common class of the points (n, 3), metres, in each voxel, as colours 1 + class.

    Of two equally common classes the lower one is used. ``classes`` (n,) are integers; those of ``most`` or more count
    as ``most`` − 1, negative ones as 0. Points outside the lattice are ignored.
    """
    keys, inside = keys_of(np.ascontiguousarray(points, dtype=np.float32), resolution)
    keys = keys[inside]
    kinds = np.clip(np.asarray(classes)[inside].astype(np.int64), 0, most - 1)
    chunks, places = keys // CHUNK, keys % CHUNK
    chunk_codes = (chunks[:, 2] << 22) | (chunks[:, 1] << 11) | chunks[:, 0]
    codes = chunk_codes * CHUNK**3 + (places[:, 2] * CHUNK + places[:, 1]) * CHUNK + places[:, 0]
    both, counts = np.unique(codes * most + kinds, return_counts=True)
    voxels = both // most
    order = np.lexsort((both % most, -counts, voxels))  # the most common of each voxel first
    voxels, class_of_voxel = voxels[order], (both % most)[order]
    voxels, first = np.unique(voxels, return_index=True)
    colours = (1 + class_of_voxel[first]).astype(np.uint8)
    chunk_of = voxels // CHUNK**3
    ends = np.flatnonzero(np.diff(chunk_of)) + 1
    painted: dict[ChunkKey, tuple[Int64Array, UInt8Array]] = {}
    for start, end in zip([0, *ends], [*ends, len(voxels)], strict=True):
        if start < end:
            code = int(chunk_of[start])
            key = (code & 0x7FF, code >> 11 & 0x7FF, code >> 22)
            painted[key] = voxels[start:end] % CHUNK**3, colours[start:end]
    return painted
