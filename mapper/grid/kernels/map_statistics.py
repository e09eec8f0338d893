"""Counts and entropy sums of one map, in one pass over its cells.

A map has few distinct values. The pass counts how often each value occurs, in a hash table. Entropy and state are
computed once per value, and again for values evicted from their slot, because a lookup costs a fraction of computing an
exponential and a logarithm.
"""

from __future__ import annotations

from math import exp, inf, isnan, log, log1p

from numpy import float32, float64, int64, uint32, uint64, zeros

from mapper.core.array_types import Float32Array, Float64Array, Int64Array, UInt8Array
from mapper.core.jit import jit

SLOTS = 4096  #: entries of the table: 2 ** 12
_GOLDEN = uint64(0x9E3779B9)  #: 2 ** 32 divided by the golden ratio
_LN2 = log(2.0)


@jit
def _entropy(log_odds: float) -> float:
    """Return H(p) in bits, as :func:`mapper.grid.metrics.entropy`."""
    distance = abs(float64(log_odds))  # numba's float() leaves a float32 as it is
    if distance == inf:
        return 0.0
    small = exp(-distance)
    return (log1p(small) + distance * small / (1.0 + small)) / _LN2


@jit
def _slot(bits: int) -> int:
    """Return the slot, 0 to SLOTS − 1, of log-odds with the float32 representation ``bits``, uint32; that of 0.0 is 0.

    Multiplicative hashing: the upper twelve of the product's lower 32 bits (Knuth, The Art of Computer Programming 3,
    section 6.4).
    """
    return int(((uint64(bits) * _GOLDEN) >> uint64(20)) & uint64(SLOTS - 1))


@jit
def _add_value(
    log_odds: float,
    cells: int,
    unset: float,
    free_below: float,
    occupied_above: float,
    counts: Int64Array,
    sums: Float64Array,
) -> None:
    """Add ``cells`` cells with the value ``log_odds``, NaN meaning ``unset``."""
    if isnan(log_odds):
        log_odds = unset
    counts[0] += cells
    if log_odds < free_below:
        counts[1] += cells
    elif log_odds > occupied_above:
        counts[2] += cells
    sums[0] += cells * _entropy(log_odds)


@jit
def sum_map(
    log_odds: Float32Array,
    observed: UInt8Array,
    unset: float,
    free_below: float,
    occupied_above: float,
    counts: Int64Array,
    sums: Float64Array,
) -> None:
    """Count the observed cells and sum their entropy.

    ``log_odds`` (n,) of all cells, contiguous, NaN meaning ``unset``; ``observed`` (n,) 1 or 0. A cell is free below
    ``free_below`` and occupied above ``occupied_above``.

    Added to: ``counts`` (3,): cells observed, free, occupied; ``sums`` (1,): the entropy of the observed cells, bits.
    """
    n = len(log_odds)
    whole = n - n % 8
    bits = log_odds.view(uint32)
    eights = observed[:whole].view(uint64)
    values = zeros(SLOTS, dtype=float32)
    keys = values.view(uint32)
    cells = zeros(SLOTS, dtype=int64)
    for eight in range(len(eights)):
        if eights[eight] == 0:
            continue
        # A separate loop of eight iterations, a number known to the compiler, takes a quarter less time.
        for k in range(8):
            i = 8 * eight + k
            slot = _slot(bits[i])
            if keys[slot] != bits[i]:
                _add_value(float64(values[slot]), cells[slot], unset, free_below, occupied_above, counts, sums)
                keys[slot], cells[slot] = bits[i], 0
            cells[slot] += observed[i]  # without a branch: a cell that is not observed adds 0
    for i in range(whole, n):
        _add_value(float64(log_odds[i]), int(int64(observed[i])), unset, free_below, occupied_above, counts, sums)
    for slot in range(SLOTS):
        if cells[slot]:
            _add_value(float64(values[slot]), cells[slot], unset, free_below, occupied_above, counts, sums)
