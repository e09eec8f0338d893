"""Updates in which the misses of a scan are ignored in the cells that the scan hits.

Implements :func:`mapper.mapping.textbook.update_hits_first`. A test in each cell that a beam passes would cost as much
as the update itself. Instead, a scan's hits are added first, then all its beams are drawn, and finally the hit cells
are restored to their values after the hits.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float32Array, Int64Array
from mapper.core.jit import jit
from mapper.mapping.kernels.negative_zero import _without_minus_zero
from mapper.mapping.kernels.types import LogOddsUpdate


@jit
def _add_hits(log_odds: Float32Array, hits: Int64Array, log_odds_update: LogOddsUpdate) -> Float32Array:
    """Add a hit to each of the cells ``hits`` (n,) of ``log_odds`` (rows · cols,); return their new values (n,)."""
    _, hit, low, high = _without_minus_zero(log_odds_update)
    for n in range(len(hits)):
        log_odds[hits[n]] = min(max(log_odds[hits[n]] + hit, low), high)
    held = np.empty(len(hits), dtype=np.float32)
    for n in range(len(hits)):
        held[n] = log_odds[hits[n]]
    return held


@jit
def _put_back(log_odds: Float32Array, hits: Int64Array, held: Float32Array) -> None:
    """Restore the values returned by :func:`_add_hits`."""
    for n in range(len(hits)):
        log_odds[hits[n]] = held[n]
