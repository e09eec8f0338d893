"""Formatting of numbers as text."""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float32Array, UInt8Array
from mapper.core.jit import jit

MOST_BYTES = 16  #: for a number and the following comma
GREATEST = 1e9  #: numbers must be below this value
TOO_LARGE = -1
_NULL = np.frombuffer(b"null", dtype=np.uint8)


@jit
def write_thousandths(values: Float32Array, low: float, high: float, out: UInt8Array) -> int:
    """Write ``values`` (n,) as an array in JSON, rounded to thousandths; return the number of bytes.

    A value outside [``low``, ``high``], with ``low`` ≥ 0, or not finite is written as null. ``out`` has room for
    :data:`MOST_BYTES` bytes per value plus two. Each text is the shortest that parses to the same float64. Returns
    :data:`TOO_LARGE` if a value is :data:`GREATEST` or more.
    """
    out[0] = ord("[")
    at = 1
    for i in range(len(values)):
        value = float(values[i])
        if i > 0:
            out[at] = ord(",")
            at += 1
        if not (low <= value <= high and math.isfinite(value)):
            out[at : at + 4] = _NULL
            at += 4
            continue
        if value >= GREATEST:
            return TOO_LARGE
        thousandths = int(np.rint(value * 1000.0))
        whole, rest = thousandths // 1000, thousandths % 1000
        size = 1
        power = 10
        while power <= whole:
            size += 1
            power *= 10
        for place in range(size - 1, -1, -1):
            out[at + place] = ord("0") + whole % 10
            whole //= 10
        at += size
        out[at] = ord(".")
        out[at + 1] = ord("0") + rest // 100
        at += 2
        if rest % 100:
            out[at] = ord("0") + rest // 10 % 10
            at += 1
        if rest % 10:
            out[at] = ord("0") + rest % 10
            at += 1
    out[at] = ord("]")
    return at + 1
