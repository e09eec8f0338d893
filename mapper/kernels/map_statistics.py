"""Counts and entropy sums of one map, in one pass over its cells.

Neighbouring cells often hold the same value, and a map few distinct ones. The pass only counts how often each value
occurs, in runs; entropy and state are computed once for each value.
"""

from __future__ import annotations

from math import isnan

from numpy import float32, int32, int64, uint32, uint64, zeros

from mapper.kernels.compiled import jit
from mapper.kernels.entropy import SLOTS, _entropy, _slot
from mapper.kernels.types import Float32Array, Float64Array, Int64Array, UInt8Array

_ALL_OBSERVED = uint64(0x0101010101010101)  #: eight cells of the array of bool
_TWICE = uint64(0x100000001)


@jit
def _add_value(
    value: float,
    cells: int,
    unset: float,
    free_below: float,
    occupied_above: float,
    counts: Int64Array,
    sums: Float64Array,
) -> None:
    """Add ``cells`` cells that hold ``value``, NaN standing for ``unset``."""
    log_odds = unset if isnan(value) else value
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

    ``log_odds`` (n,) of all cells, contiguous, NaN standing for ``unset``; ``observed`` (n,) 1 or 0. A cell is free
    below and occupied above the two log-odds.

    Added to: ``counts`` (3,): cells observed, free, occupied; ``sums`` (1,): the entropy of the observed cells, bits.
    """
    n = len(log_odds)
    whole = n - n % 8
    bits = log_odds.view(int32)
    eights, pairs = observed[:whole].view(uint64), log_odds[:whole].view(uint64)
    values = zeros(SLOTS, dtype=float32)
    keys = values.view(int32)
    cells = zeros(SLOTS, dtype=int64)
    last, run = int32(0), 0
    pair = uint64(0)  # the bits of two cells that hold the last value
    start = 0
    while start < n:
        stop = min(start + 8, n)
        if start < whole:
            eight = eights[start // 8]
            at = start // 2
            if eight == 0:
                start = stop
                continue
            if (
                eight == _ALL_OBSERVED
                and pairs[at] == pair
                and pairs[at + 1] == pair
                and pairs[at + 2] == pair
                and pairs[at + 3] == pair
            ):
                run += 8
                start = stop
                continue
        for i in range(start, stop):
            if observed[i] == 0:
                continue
            if bits[i] == last:
                run += 1
                continue
            slot = _slot(last)
            if keys[slot] != last:
                _add_value(values[slot], cells[slot], unset, free_below, occupied_above, counts, sums)
                keys[slot], cells[slot] = last, 0
            cells[slot] += run
            last, run = bits[i], 1
            pair = uint64(uint32(last)) * _TWICE
        start = stop
    slot = _slot(last)
    if keys[slot] != last:
        _add_value(values[slot], cells[slot], unset, free_below, occupied_above, counts, sums)
        keys[slot], cells[slot] = last, 0
    cells[slot] += run
    for slot in range(SLOTS):
        if cells[slot]:
            _add_value(values[slot], cells[slot], unset, free_below, occupied_above, counts, sums)
