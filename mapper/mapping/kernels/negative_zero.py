"""Marking of touched cells by the sign of zero, instead of a second write for each update.

A cell that was never observed holds the prior. If the prior is 0, it is encoded as −0. Adding evidence to −0 gives the
same result as adding it to +0, and no sum of the map is ever −0 again (IEEE 754, section 6.3: x + y is −0 only if both
are). So cells that are still −0 at the end were not touched. This saves the write to ``observed``, whose cache misses
cost more than the addition itself.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int64Array
from mapper.core.jit import jit
from mapper.mapping.kernels.types import LogOddsUpdate

_UNOBSERVED = np.int32(-(1 << 31))  # the bits of −0


@jit
def encode_unobserved(log_odds: Float32Array, observed: BoolArray, box: Int64Array) -> bool:
    """Set the never-observed cells of ``box`` (row0, row1, col0, col1) to −0; return whether all could be.

    ``log_odds`` (rows, cols) float32; ``observed`` (rows, cols) bool. If one of these cells is not 0, nothing is
    encoded.
    """
    for r in range(box[0], box[1]):
        cells, seen = log_odds[r, box[2] : box[3]], observed[r, box[2] : box[3]]
        strange = 0
        for c in range(len(cells)):
            strange |= (not seen[c]) & (cells[c] != np.float32(0.0))
        if strange:
            return False
    for r in range(box[0], box[1]):
        cells, seen = log_odds[r, box[2] : box[3]], observed[r, box[2] : box[3]]
        for c in range(len(cells)):
            cells[c] = cells[c] if seen[c] else np.float32(-0.0)
    return True


@jit
def decode_observed(log_odds: Float32Array, observed: BoolArray, box: Int64Array) -> None:
    """Set the −0 cells of ``box`` back to +0 and mark all others as observed."""
    for r in range(box[0], box[1]):
        bits, noted = log_odds[r, box[2] : box[3]].view(np.int32), observed[r, box[2] : box[3]]
        for c in range(len(bits)):
            seen = bits[c] != _UNOBSERVED
            noted[c] = noted[c] | seen
            bits[c] = bits[c] if seen else np.int32(0)


@jit
def _without_minus_zero(log_odds_update: LogOddsUpdate) -> LogOddsUpdate:
    """Return the update with each −0 replaced by +0, because evidence of −0 would leave a cell marked as unobserved."""
    miss, hit, low, high = log_odds_update
    return LogOddsUpdate(_unsigned_zero(miss), _unsigned_zero(hit), _unsigned_zero(low), _unsigned_zero(high))


@jit
def _unsigned_zero(value: np.float32) -> np.float32:
    # Not written as value + 0: compilers drop that sum in the clamp's comparison but keep it in its selection, and then
    # cannot use a combined instruction, which makes a whole map a fifth slower.
    return np.float32(0.0) if value == np.float32(0.0) else value
