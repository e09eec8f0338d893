"""Giving back memory that is not needed any more."""

from __future__ import annotations

import ctypes
import gc


def give_back(*, is_idle: bool) -> None:
    """Free what only cycles of references hold, and return free memory to the system (any thread).

    Of the memory that threads have freed, glibc keeps what may be asked for again; malloc_trim(3) returns it.

    The collector stops all threads while it looks through the objects, a sixth of a second for those of the whole
    service. So it looks at all only where the service ``is_idle``, and leaves out what is there then (``gc.freeze``),
    modules and kernels, until it is idle again.
    """
    if is_idle:
        gc.unfreeze()
    gc.collect()
    if is_idle:
        gc.freeze()
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except AttributeError:  # another C library
        return
    trim(0)
