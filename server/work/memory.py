"""Memory of the process: a reserve of address space, and giving back what is not needed any more.

With the reserve a service at its limit of memory (``ulimit -v``) can still answer.
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

RESERVE_BYTES = 64 << 20  #: of address space; none of its pages is ever used
LEAST_BYTES = 32 << 20  #: of free address space; with less nothing is begun: the stack of one thread takes 8 MB
EVERY_S = 0.5  #: seconds between two looks at the free address space

_STATM = Path("/proc/self/statm")

_log = structlog.get_logger(__name__)


def free_address_space() -> float:
    """Return the bytes that this process may still map; infinity without a limit, or where the system does not say."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return float("inf")
    try:
        used = int(_STATM.read_bytes().split()[0]) * mmap.PAGESIZE
    except OSError:  # not Linux
        return float("inf")
    return float(limit - used)


class MemoryReserve:
    """A reserve of address space, given up while less than :data:`LEAST_BYTES` are free besides (event loop).

    Without it a process at its limit cannot even receive a request, and the start of a thread, for which its caller
    waits, may never end.
    """

    def __init__(self, free: Callable[[], float] = free_address_space) -> None:
        self._free = free
        self._held: mmap.mmap | None = None

    def is_short(self) -> bool:
        """Return whether nothing should be begun now; the reserve is given up or taken back accordingly."""
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
            # Pages that are private and cannot be written count as no memory in use.
            self._held = mmap.mmap(-1, RESERVE_BYTES, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=mmap.PROT_READ)
        except (OSError, MemoryError):
            return False
        return True

    def give_up(self) -> None:
        """Give up the reserve."""
        if self._held is not None:
            self._held.close()
            self._held = None

    async def watch(self) -> None:
        """Give up the reserve when memory gets short, and take it back afterwards, until cancelled."""
        try:
            while True:
                self.is_short()
                await asyncio.sleep(EVERY_S)
        finally:
            self.give_up()


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether an error says that the process may have no more memory, or no more threads."""
    if isinstance(error, MemoryError):
        return True
    message = str(error)
    if isinstance(error, RuntimeError):
        return message == "can't start new thread"
    # Of the dynamic loader: an import that maps a shared library.
    shortages = ("Cannot allocate memory", "cannot allocate memory", "failed to map segment")
    return isinstance(error, ImportError | OSError) and any(shortage in message for shortage in shortages)


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
