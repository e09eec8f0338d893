"""The reserve of address space: when it is given up and taken back, and which errors mean that memory is short."""

from __future__ import annotations

import ctypes
import errno
import os
import resource
import subprocess
import sys

import pytest

from server.work.memory import LEAST_BYTES, RESERVE_BYTES, MemoryReserve, free_address_space, is_out_of_memory


def test_the_reserve_is_given_up_and_taken_back() -> None:
    free = float("inf")
    reserve = MemoryReserve(lambda: free)
    for free, is_short in (
        (float("inf"), False),
        (float(LEAST_BYTES), False),
        (LEAST_BYTES - 1.0, True),
        (RESERVE_BYTES + LEAST_BYTES - 1.0, True),  # what was given up alone is not enough
        (float(RESERVE_BYTES + LEAST_BYTES), False),
        (float(LEAST_BYTES), False),
        (-1.0, True),
    ):
        assert reserve.is_short() is is_short, free
    reserve.give_up()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="it reads /proc")
def test_the_free_address_space_is_the_limit_less_what_is_mapped() -> None:
    """In a process of its own, with the reserve counted by the system."""
    program = """
import resource
from server.work.memory import *
assert free_address_space() == float("inf")
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, resource.RLIM_INFINITY))
reserve = MemoryReserve()
before = free_address_space()
assert 0 < before < 8 << 30
assert not reserve.is_short()
assert abs(before - free_address_space() - RESERVE_BYTES) < 1 << 22
resource.setrlimit(resource.RLIMIT_AS, (int((8 << 30) - free_address_space()), resource.RLIM_INFINITY))
assert reserve.is_short()
assert RESERVE_BYTES - (1 << 22) < free_address_space() < RESERVE_BYTES + (1 << 22)
assert reserve.is_short()
"""
    subprocess.run([sys.executable, "-c", program], check=True, env=os.environ)
    if resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY:
        assert free_address_space() == float("inf")


def test_errors_for_want_of_memory_and_others() -> None:
    short = [
        MemoryError(),
        RuntimeError("can't start new thread"),
        OSError(errno.ENOMEM, os.strerror(errno.ENOMEM)),
        ImportError("libx.so: failed to map segment from shared object"),
    ]
    assert all(is_out_of_memory(error) for error in short)
    with pytest.raises(OSError, match=r"no_such\.so") as missing:
        ctypes.CDLL("no_such.so")
    others = [RuntimeError("else"), OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), ValueError(), missing.value]
    assert not any(is_out_of_memory(error) for error in others)
