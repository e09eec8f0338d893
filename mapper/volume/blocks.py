"""Hash of blocks of 8³ voxels: which blocks exist, and the slot of each.

The contents of voxels are stored by the owner, in arrays (slots, 8, 8, 8, ...) that grow with
:attr:`BlockHash.capacity`.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Int32Array, Int64Array
from mapper.core.errors import LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.volume.kernels.blocks import add_blocks, find_slots
from mapper.volume.kernels.types import BlockTable

BLOCK = 8  #: voxels along the side of a block
KEYS = 1 << 16  #: voxels along an axis; key 32768 starts at coordinate 0


class BlockHash:
    """The blocks of a volume. Slots are numbered from 0 in insertion order."""

    def __init__(self, limits: Limits = DEFAULT_LIMITS) -> None:
        self.limits = limits
        self.table = _empty_table(64)
        self._codes = np.empty(0, dtype=np.int64)
        self.count = 0

    @property
    def codes(self) -> Int64Array:
        """The codes (n,) of the blocks in slot order."""
        return self._codes[: self.count]

    @property
    def capacity(self) -> int:
        """Number of blocks for which an owner's arrays should have room."""
        return len(self._codes)

    @property
    def corners(self) -> Int64Array:
        """The keys (n, 3), x y z, of the first voxels of the blocks in slot order."""
        codes = self.codes
        return np.stack([codes & 0x1FFF, codes >> 13 & 0x1FFF, codes >> 26], axis=1) * BLOCK

    def find(self, codes: Int64Array) -> Int32Array:
        """Return the slots (n,) of blocks, −1 for missing ones."""
        out = np.empty(len(codes), dtype=np.int32)
        find_slots(self.table, codes, out)
        return out

    def add(self, codes: Int64Array) -> Int32Array:
        """Return the slots (n,) of blocks, adding missing ones; the ``codes`` (n,) must be distinct.

        Raises :class:`LimitError` for more blocks than the limits allow; none is then added.
        """
        needed = self.count + int((self.find(codes) < 0).sum())
        if needed > self.limits.max_blocks:
            raise LimitError(
                "volume.too_large",
                f"The map would need {needed:,} blocks of 8 × 8 × 8 voxels, more than {self.limits.max_blocks:,}; "
                "choose a coarser resolution or a shorter longest beam.",
            )
        if 2 * needed > len(self.table.codes):
            self.table = _empty_table(1 << (2 * needed).bit_length())
            add_blocks(self.table, self.codes, 0, np.empty(self.count, dtype=np.int32))
        if needed > self.capacity:
            more = np.empty(max(needed, self.capacity * 3 // 2), dtype=np.int64)
            more[: self.count] = self.codes
            self._codes = more
        slots = np.empty(len(codes), dtype=np.int32)
        first = self.count
        self.count += add_blocks(self.table, codes, first, slots)
        new = slots >= first
        self._codes[slots[new]] = codes[new]
        return slots


def _empty_table(length: int) -> BlockTable:
    return BlockTable(np.full(length, -1, dtype=np.int64), np.zeros(length, dtype=np.int32))
