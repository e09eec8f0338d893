"""Random numbers as a function of a key and a counter, so that they do not depend on which thread draws them.

Each number is a hash of its counter: two rounds of a 32-bit integer hash with two multiplications, each with half of
the key. The hash is one that C. Wellons' search for hashes with little bias found. Source of the idea: Salmon et al.
2011, Parallel random numbers: as easy as 1, 2, 3. Normal deviates are the inverse of the normal distribution (Wichura
1988, algorithm AS 241, PPND7, error below 1e-6).
"""

from __future__ import annotations

from math import log, sqrt

from mapper.core.jit import jit

_WORD = 0xFFFFFFFF


@jit
def _hashed(x: int) -> int:
    """Return a hash of x, both 32-bit. Products stay below 2⁶³."""
    x ^= x >> 16
    x = (x * 0x21F0AAAD) & _WORD
    x ^= x >> 15
    x = (x * 0x735A2D97) & _WORD
    return x ^ (x >> 15)


@jit
def _uniform(key: int, counter: int) -> float:
    """Return a number in (0, 1), one of 2³², for a key of 62 bits and a counter below 2³²."""
    word = _hashed(_hashed((counter ^ key) & _WORD) ^ ((key >> 31) & _WORD))
    return (word + 0.5) / 4294967296.0


@jit
def _normal(p: float) -> float:
    """Return the value that a standard normal variate does not exceed with probability ``p``, 0 < p < 1."""
    q = p - 0.5
    if abs(q) <= 0.425:
        r = 0.180625 - q * q
        above = ((5.9109374720e1 * r + 1.5929113202e2) * r + 5.0434271938e1) * r + 3.3871327179
        below = ((6.7187563600e1 * r + 7.8757757664e1) * r + 1.7895169469e1) * r + 1.0
        return q * above / below
    r = sqrt(-log(p if q < 0.0 else 1.0 - p))
    if r <= 5.0:
        r -= 1.6
        above = ((1.7023821103e-1 * r + 1.3067284816) * r + 2.7568153900) * r + 1.4234372777
        below = (1.2021132975e-1 * r + 7.3700164250e-1) * r + 1.0
    else:
        r -= 5.0
        above = ((1.7337203997e-2 * r + 4.2868294337e-1) * r + 3.0812263860) * r + 6.6579051150
        below = (1.2258202635e-2 * r + 2.4197894225e-1) * r + 1.0
    return -above / below if q < 0.0 else above / below
