"""Log-odds of blocks of 8³ voxels, stored only for parts of 2 × 2 × 8 voxels with known voxels."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array, UInt16Array
from mapper.volume.blocks import BLOCK
from mapper.volume.kernels.update import add_parts

PARTS = 16  #: of a block
_SHAPE = (2, 2, BLOCK)  # of a part, z y x


class BlockParts:
    """Storage of the voxels' log-odds: ``numbers`` (slots, 16) are the indices of a block's parts in ``values``.

    ``values`` (parts, 2, 2, 8) are float32, z y x, NaN if unknown. Part (z, y) of a block, four along each axis, is
    entry 4 z + y of its row. Part 0 is all unknown and stands for missing parts. Both arrays have room for more than
    ``count`` parts and the owner's blocks.
    """

    def __init__(self) -> None:
        self.numbers = np.empty((0, PARTS), dtype=np.int32)
        self.values = np.full((1, *_SHAPE), np.nan, dtype=np.float32)
        self.count = 1

    @property
    def known_values(self) -> Float32Array:
        """The log-odds (n, 2, 2, 8) of all allocated parts."""
        return self.values[1 : self.count]

    def n_bytes(self, blocks: int) -> int:
        """Bytes of the log-odds of this number of blocks, and of their part indices."""
        return self.count * self.values[:1].nbytes + blocks * self.numbers.itemsize * PARTS

    def reserve(self, capacity: int, used: int) -> None:
        """Make room for ``capacity`` blocks; the first ``used`` keep their parts and the others have none."""
        numbers = np.zeros((capacity, PARTS), dtype=np.int32)
        numbers[:used] = self.numbers[:used]
        self.numbers = numbers

    def add(self, slots: Int32Array, wanted: UInt16Array) -> None:
        """Allocate for blocks the parts that are bits of ``wanted`` (n,), new ones unknown; ``slots`` (n,) are
        distinct.
        """
        before = self.count
        self.count += add_parts(self.numbers, slots, wanted, before)
        if self.count > len(self.values):
            more = np.empty((max(self.count, len(self.values) * 3 // 2), *_SHAPE), dtype=np.float32)
            more[:before] = self.values[:before]
            self.values = more
        self.values[before : self.count] = np.nan

    def blocks(self, slots: Int32Array | Int64Array | slice) -> Float32Array:
        """Return a copy of the log-odds (n, 8, 8, 8), z y x, of blocks by slot."""
        rows = self.values[self.numbers[slots]].reshape(-1, 4, 4, *_SHAPE)
        return rows.transpose(0, 1, 3, 2, 4, 5).reshape(-1, BLOCK, BLOCK, BLOCK)

    def set_blocks(self, slots: Int32Array, values: Float32Array) -> None:
        """Set the log-odds of the voxels (n, 8, 8, 8) of blocks; ``slots`` (n,) are distinct."""
        rows = values.reshape(-1, 4, 2, 4, 2, BLOCK).transpose(0, 1, 3, 2, 4, 5).reshape(-1, PARTS, *_SHAPE)
        known = ~np.isnan(rows).all(axis=(2, 3, 4))
        self.add(slots, (known * (1 << np.arange(PARTS))).sum(axis=1).astype(np.uint16))
        numbers = self.numbers[slots]
        there = numbers > 0
        self.values[numbers[there]] = rows[there]
