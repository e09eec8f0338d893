"""Memory of the process: a reserve of address space, and the release of unused memory.

With the reserve, a service at its memory limit (``ulimit -v``) can still answer.
"""

from __future__ import annotations

import asyncio
import ctypes
import gc
import mmap
import resource
from collections.abc import Callable
from pathlib import Path

import structlog

RESERVE_BYTES = 64 << 20  #: of address space; its pages are never used
LEAST_BYTES = 32 << 20  #: of free address space; with less nothing is started, because the stack of a thread needs 8 MB
EVERY_S = 0.5  #: seconds between two checks of the free address space

_STATM = Path("/proc/self/statm")

_log = structlog.get_logger(__name__)


def free_address_space() -> float:
    """Return the bytes that this process may still map; infinity without a limit, or if the system reports none."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return float("inf")
    try:
        used = int(_STATM.read_bytes().split()[0]) * mmap.PAGESIZE
    except OSError:  # not Linux
        return float("inf")
    return float(limit - used)


class MemoryReserve:
    """A reserve of address space, released while less than :data:`LEAST_BYTES` are free otherwise (event loop).

    Without it, a process at its limit cannot even receive a request, and the start of a thread, for which its caller
    waits, may never finish.
    """

    def __init__(self, free: Callable[[], float] = free_address_space) -> None:
        self._free = free
        self._held: mmap.mmap | None = None

    def is_short(self) -> bool:
        """Return whether nothing should be started now; release or reacquire the reserve accordingly."""
        free = self._free()
        if self._held is not None:
            if free >= LEAST_BYTES:
                return False
            self.give_up()
            _log.warning("memory is short: nothing new is begun", free=free)
            return True
        return free < RESERVE_BYTES + LEAST_BYTES or not self._take()

    def _take(self) -> bool:
        try:
            # Private pages that cannot be written do not count as used memory.
            self._held = mmap.mmap(-1, RESERVE_BYTES, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=mmap.PROT_READ)
        except (OSError, MemoryError):
            return False
        return True

    def give_up(self) -> None:
        """Release the reserve."""
        if self._held is not None:
            self._held.close()
            self._held = None

    async def watch(self) -> None:
        """Release the reserve when memory gets short, and reacquire it afterwards, until cancelled."""
        try:
            while True:
                self.is_short()
                await asyncio.sleep(EVERY_S)
        finally:
            self.give_up()


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether an error means that the process cannot get more memory or more threads."""
    if isinstance(error, MemoryError):
        return True
    message = str(error)
    if isinstance(error, RuntimeError):
        return message == "can't start new thread"
    # Errors of the dynamic loader for an import that maps a shared library.
    shortages = ("Cannot allocate memory", "cannot allocate memory", "failed to map segment")
    return isinstance(error, ImportError | OSError) and any(shortage in message for shortage in shortages)


def give_back(*, is_idle: bool) -> None:
    """Free objects that only reference cycles hold, and return free memory to the system (any thread).

    glibc keeps memory that threads have freed for later allocations; malloc_trim(3) returns it.

    The collector stops all threads while it traverses the objects, for a sixth of a second if they are those of the
    whole service. It therefore runs only if the service ``is_idle``. Afterwards, existing objects such as modules and
    kernels are excluded (``gc.freeze``) until the service is idle again.
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
