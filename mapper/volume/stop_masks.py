"""Voxels of a map that end a cast ray, as bits that are computed again where the map changed."""

from __future__ import annotations

from functools import partial

import numpy as np

from mapper.core.array_types import Int32Array
from mapper.core.parallel import cores, in_parallel, shares
from mapper.volume.kernels.casts import stop_masks
from mapper.volume.kernels.types import Belief, StopMasks

_SHARE = 1024  # blocks from which a second thread is worth its start


class StopMaskCache:
    """The stop masks of a map's blocks. A map that no ray is cast through has none."""

    def __init__(self) -> None:
        self._masks = _empty_masks(0)
        self._stale = np.empty(0, dtype=np.bool_)  # blocks whose log-odds changed since

    @property
    def n_bytes(self) -> int:
        """Bytes that the masks take."""
        return self._masks.words.nbytes + self._masks.found.nbytes + self._stale.nbytes

    def mark_stale(self, slots: Int32Array | slice) -> None:
        """Note that the log-odds of blocks changed, by their slots."""
        self._stale[slots if isinstance(slots, slice) else slots[slots < len(self._stale)]] = True

    def masks_of(self, belief: Belief, n: int, occupied: float) -> StopMasks:
        """Return the masks of the first ``n`` blocks of a map, which are all; occupied is from those log-odds."""
        capacity, before = len(belief.parts), len(self._stale)
        if n > before:
            masks, stale = _empty_masks(capacity), np.ones(capacity, dtype=np.bool_)
            masks.words[:before], masks.found[:before], stale[:before] = (
                self._masks.words, self._masks.found, self._stale,
            )  # fmt: skip
            self._masks, self._stale = masks, stale
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
        return masks


def _empty_masks(n: int) -> StopMasks:
    return StopMasks(np.empty((n, 2, 8), dtype=np.uint64), np.empty(n, dtype=np.uint8))
