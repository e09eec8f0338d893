"""Work on several cores: one pool of threads for kernels that release the GIL."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
from threading import Lock, local
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")


_here = local()


def cores() -> int:
    """Return how many cores this process may use.

    Within :func:`single_threaded` it is 1, and on a thread of :func:`share_cores` while others need the cores.
    """
    needed = getattr(_here, "needed", None)
    if getattr(_here, "single_threaded", False) or (needed is not None and needed()):
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def single_threaded() -> Iterator[None]:
    """Run the block on this thread only: inside it :func:`cores` returns 1 to this thread."""
    before, _here.single_threaded = getattr(_here, "single_threaded", False), True
    try:
        yield
    finally:
        _here.single_threaded = before


def share_cores(needed: Callable[[], bool]) -> None:
    """Leave this thread one core only from now on whenever ``needed`` says that others need them."""
    _here.needed = needed


@cache
def _pool() -> ThreadPoolExecutor:
    # The caller works too, so one thread fewer than cores. Nothing in the pool ever waits for the pool.
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="mapper")


def in_parallel(tasks: Sequence[Callable[[], T]]) -> list[T]:
    """Run the tasks on the calling thread and as many others as are free; return their results in order.

    Each free thread takes the next task, so on a busy machine the caller may run all of them without waiting.
    """
    if len(tasks) == 1:
        return [tasks[0]()]
    results: dict[int, T] = {}
    waiting = iter(enumerate(tasks))
    lock = Lock()

    def work() -> None:
        while True:
            with lock:
                place, task = next(waiting, (None, None))
            if place is None or task is None:
                return
            results[place] = task()

    helpers = [_pool().submit(work) for _ in range(min(len(tasks), cores()) - 1)]
    try:
        work()
    finally:
        for helper in helpers:
            if not helper.cancel():
                helper.result()
    return [results[place] for place in range(len(tasks))]


_thread_words = local()
_KEEP_WORDS = 1 << 24  # 128 MB, of which little is ever touched: so much is kept for a thread's next use


@contextmanager
def scratch(words: int) -> Iterator[NDArray[np.int64]]:
    """Yield at least ``words`` words (n,) int64, all 0, which must be all 0 again at the end.

    Memory that is used again has its pages already; to fetch them from the system costs more than many a kernel.
    """
    present: NDArray[np.int64] | None = getattr(_thread_words, "words", None)
    lent = present if present is not None and len(present) >= words else np.zeros(words, dtype=np.int64)
    _thread_words.words = None  # after an error it may not be all 0
    yield lent
    _thread_words.words = lent if len(lent) <= _KEEP_WORDS else None


def shares(n: int, parts: int) -> list[tuple[int, int]]:
    """Split [0, n) into ranges of about equal length."""
    return list(pairwise(round(i * n / parts) for i in range(parts + 1)))


def bands(work: NDArray[np.float64], parts: int) -> list[tuple[int, int]]:
    """Split rows [0, n) into at most ``parts`` ranges of about equal ``work`` (n,); none of them is empty."""
    total = np.cumsum(work)
    if len(work) < 2 or parts < 2 or total[-1] <= 0.0:
        return [(0, len(work))]
    cuts = 1 + np.searchsorted(total, total[-1] * np.arange(1, parts) / parts)
    edges = sorted({0, len(work), *(int(cut) for cut in cuts if cut < len(work))})
    return list(pairwise(edges))
