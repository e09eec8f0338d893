"""Kernels compute in declared widths, and the check of it finds computations that do not."""

import numpy as np
import pytest

from tests.agreement.widths import faults, kernel_sources

ALIASES = """
UInt8Array = NDArray[np.uint8]
UInt16Array = NDArray[np.uint16]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
Float32Array = NDArray[np.float32]

class Tables(NamedTuple):
    counts: UInt8Array
    limit: int

def other(n: int, x: float) -> int:
    return n
"""


def kernel(body: str) -> str:
    head = "def kernel(bits: UInt8Array, cells: Int32Array, sums: Int64Array, values: Float32Array, t: Tables, n: int):"
    return ALIASES + head + "".join(f"\n    {line}" for line in body.splitlines())


def test_kernels_compute_in_declared_widths() -> None:
    assert faults(kernel_sources()) == []


@pytest.mark.parametrize(
    "body",
    [
        "count = 0\nfor i in range(n):\n    count += t.counts[i]",  # what overflowed in surface_cells
        "count = 0\nfor i in range(n):\n    count = count + bits[i]",
        "row = cells[n] // 8\nat = row * n",
        "one = bits[n]\ntwo = one\nwhile n:\n    n = 3 * two",
        "a, b = bits[0], sums[0]\nn = a + 1",
        "line = bits[3:n]\nsums[0] = line[1] + line[2]",
        "local = np.empty(n, dtype=np.uint16)\nsums[0] = local[0] << 3",
        "most = max(bits[0], bits[1])\nsums[0] = 256 - most",
        "n = -bits[0]",
        "n = other(bits[0], 1.0)",
        "n = int(bits[0]) - int(bits[1])",
        "cells[0] = bits[0] + bits[1]",  # stored wider than it is computed
        "cells[0] = np.int32(bits[0] * 3)",
        "bits[0] = (bits[1] + bits[2]) >> 1",  # the shift brings bits back that the sum has lost
        "here = bits[0] if n else 0\nn = here + 1",
    ],
)
def test_an_undeclared_width_is_found(body: str) -> None:
    assert faults({"kernel.py": kernel(body)}) != []


@pytest.mark.parametrize(
    "body",
    [
        "count = 0\nfor i in range(n):\n    count += np.int64(t.counts[i])",
        "sums[0] = sums[1] + bits[0]",
        "sums[0] += bits[0]",
        "cells[0] += bits[0]",  # an element of an array stays of its width
        "x = 0.5 * bits[0]",
        "x = values[0] * cells[0]",
        "bits[0] = np.uint8(bits[1] + np.uint8(1))",
        "bits[0] = bits[1] - bits[2] + bits[3]",
        "n = bits[0] >> 3 & 1",
        "n = np.int64(bits[0]) << 8 | np.int64(bits[1])",
        "n = other(np.int64(bits[0]), 1.0)",
        "n = t.limit + 1",
    ],
)
def test_a_declared_width_is_let_through(body: str) -> None:
    assert faults({"kernel.py": kernel(body)}) == []


def test_python_adds_in_the_width_of_the_element() -> None:
    """What the check is for: NumPy's scalars decide the width of a sum with a number of Python."""
    with pytest.warns(RuntimeWarning, match="overflow"):
        assert 200 + np.uint8(100) == 44
