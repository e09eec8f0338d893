"""Bit masks of the voxels that end a cast ray, recomputed where the map changed."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from mapper.core.array_types import Int32Array, Int64Array, UInt8Array, UInt64Array
from mapper.core.parallel import cores, in_parallel, shares
from mapper.volume.kernels.casts import index_blocks, stop_masks
from mapper.volume.kernels.types import Belief, StopMasks

_SHARE = 1024  # blocks above which a second thread is worthwhile
_NO_GRID = np.empty((0, 0, 0), dtype=np.int32)
MOST_PLACES = 32  #: grid places per block of a map: as many bytes as its bits


class StopMaskCache:
    """The stop masks of a map's blocks; they are only computed when rays are cast."""

    def __init__(self) -> None:
        self._masks = StopMasks(*_empty_masks(0), _NO_GRID, 0, 0, 0)
        self._stale = np.empty(0, dtype=np.bool_)  # blocks whose log-odds have changed since

    @property
    def n_bytes(self) -> int:
        """Memory of the masks in bytes."""
        words, found, grid, *_ = self._masks
        return words.nbytes + found.nbytes + grid.nbytes + self._stale.nbytes

    def mark_stale(self, slots: Int32Array | slice) -> None:
        """Record that the log-odds of blocks changed, by slot."""
        self._stale[slots if isinstance(slots, slice) else slots[slots < len(self._stale)]] = True

    def masks_of(self, belief: Belief, codes: Int64Array, occupied: float) -> StopMasks:
        """Return the masks of a map's blocks with ``codes`` (n,); ``occupied`` is the log-odds threshold."""
        n, capacity, before = len(codes), len(belief.parts), len(self._stale)
        if n > before:
            (words, found), stale = _empty_masks(capacity), np.ones(capacity, dtype=np.bool_)
            words[:before], found[:before], stale[:before] = self._masks.words, self._masks.found, self._stale
            self._masks, self._stale = self._masks._replace(words=words, found=found), stale
        masks, stale = self._masks, self._stale
        if stale[:n].any():
            parts = shares(n, min(cores(), 1 + n // _SHARE))
            in_parallel(
                [
                    partial(
                        stop_masks,
                        belief.parts[a:b],
                        belief.values,
                        occupied,
                        stale[a:b],
                        masks.words[a:b],
                        masks.found[a:b],
                    )
                    for a, b in parts
                ]
            )
            stale[:n] = False
            self._masks = _with_grid(masks, codes)
        return self._masks


def _empty_masks(n: int) -> tuple[UInt64Array, UInt8Array]:
    return np.empty((n, 2, 8), dtype=np.uint64), np.empty(n, dtype=np.uint8)


def _with_grid(masks: StopMasks, codes: Int64Array) -> StopMasks:
    """Return the masks with the grid of blocks (n,), n > 0, or with an empty one if it would be too large."""
    box = [(int(at.min()), int(at.max())) for at in (codes & 8191, codes >> 13 & 8191, codes >> 26)]
    shape = [high - low + 1 for low, high in reversed(box)]
    x, y, z = (low for low, _ in box)
    if math.prod(shape) > MOST_PLACES * len(codes):
        return StopMasks(masks.words, masks.found, _NO_GRID, x, y, z)
    grid = np.empty(shape, dtype=np.int32)
    index_blocks(codes, masks.found, x, y, z, grid)
    return StopMasks(masks.words, masks.found, grid, x, y, z)
