"""Parallel work: one thread pool for kernels that release the GIL."""

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
    """Return the number of cores that this process may use.

    It is 1 within :func:`single_threaded`, and on a thread of :func:`share_cores` while other work needs the cores.
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
    """Limit this thread to one core from now on whenever ``needed`` returns true."""
    _here.needed = needed


@cache
def _pool() -> ThreadPoolExecutor:
    # The caller works too, so the pool has one thread fewer than cores. No task in the pool waits for another.
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="mapper")


def in_parallel(tasks: Sequence[Callable[[], T]]) -> list[T]:
    """Run the tasks on the calling thread and on free threads of the pool; return their results in order.

    Each free thread takes the next task, so on a busy machine the caller may run all tasks without waiting.
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
_KEEP_WORDS = 1 << 24  # 128 MB, mostly untouched: buffers up to this size are kept for the thread's next use


@contextmanager
def scratch(words: int) -> Iterator[NDArray[np.int64]]:
    """Yield a buffer (n,) int64 of at least ``words`` zeros. The caller must set it to zero again before the block
    ends.

    The buffer is reused because page faults on fresh memory cost more than many kernels.
    """
    present: NDArray[np.int64] | None = getattr(_thread_words, "words", None)
    lent = present if present is not None and len(present) >= words else np.zeros(words, dtype=np.int64)
    _thread_words.words = None  # after an error it may not be all 0
    yield lent
    _thread_words.words = lent if len(lent) <= _KEEP_WORDS else None


def shares(n: int, parts: int) -> list[tuple[int, int]]:
    """Split [0, n) into ranges of nearly equal length."""
    return list(pairwise(round(i * n / parts) for i in range(parts + 1)))


def bands(work: NDArray[np.float64], parts: int) -> list[tuple[int, int]]:
    """Split rows [0, n) into at most ``parts`` non-empty ranges of nearly equal total ``work`` (n,)."""
    total = np.cumsum(work)
    if len(work) < 2 or parts < 2 or total[-1] <= 0.0:
        return [(0, len(work))]
    cuts = 1 + np.searchsorted(total, total[-1] * np.arange(1, parts) / parts)
    edges = sorted({0, len(work), *(int(cut) for cut in cuts if cut < len(work))})
    return list(pairwise(edges))
