"""Entropy of a cell, and the hash by which tables of entropies are looked up.

Most cells of a map hold one of few values. Looking up an entropy costs a fraction of computing an exponential and a
logarithm.
"""

from __future__ import annotations

from math import exp, inf, log, log1p

from numpy import float64, uint64

from mapper.core.jit import jit

SLOTS = 4096  #: entries of such a table: 2 ** 12
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
    """Return the slot, 0 … SLOTS − 1, of log-odds whose float32 representation is ``bits``, uint32; that of 0.0 is 0.

    Multiplicative hashing: the upper twelve of the product's lower 32 bits (Knuth, The Art of Computer Programming 3,
    section 6.4).
    """
    return int(((uint64(bits) * _GOLDEN) >> uint64(20)) & uint64(SLOTS - 1))
