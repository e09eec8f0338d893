"""Giving back memory that is not needed any more."""

from __future__ import annotations

import ctypes
import gc


def give_back() -> None:
    """Free what only cycles of references hold, and return free memory to the system (any thread).

    Of the memory that threads have freed, glibc keeps what may be asked for again; malloc_trim(3) returns it.
    """
    gc.collect()
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except AttributeError:  # another C library
        return
    trim(0)
