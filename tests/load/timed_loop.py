"""``python -m tests.load.timed_loop REPORT serve …``: the command with each callback of its event loops timed.

When the command ends a file is written on those that took their thread longer than :data:`LIMIT_S` of processor time,
of which the part is stated that Python's cyclic collector took, and on those that waited as long for a core or for the
interpreter's lock. The service has one event loop, in the main thread, and each 3D view one in a thread of its own,
which delays the service only while it holds the lock.
"""

from __future__ import annotations

import asyncio
import gc
import json
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from inspect import CORO_CREATED, getcoroutinestate
from pathlib import Path
from types import CoroutineType
from typing import Any

from server.cli import main

LIMIT_S = 0.005
OWN = "/server/"


def _awaited(coroutine: Any) -> Iterator[CoroutineType[Any, Any, Any]]:
    """Yield a coroutine and those that it waits for, one within the other."""
    while isinstance(coroutine, CoroutineType):
        yield coroutine
        coroutine = coroutine.cr_await


def _name_of(callback: Any) -> str:
    """Return the functions of the service in which a callback is now, or what it is."""
    task = getattr(callback, "__self__", None)
    if not isinstance(task, asyncio.Task):
        return str(getattr(callback, "__qualname__", callback))
    chain = list(_awaited(task.get_coro()))
    own = [one.__qualname__ for one in chain if OWN in one.cr_code.co_filename]
    ended = " (ended)" if chain and chain[0].cr_frame is None else ""
    begun = " (not begun)" if chain and getcoroutinestate(chain[0]) == CORO_CREATED else ""
    return " › ".join(own or [one.__qualname__ for one in chain[:1]]) + ended + begun


class Longest:
    """How often each callback took longer than the limit, or waited, with the longest times, seconds."""

    def __init__(self) -> None:
        self._found: dict[tuple[bool, str], tuple[int, float, float]] = {}
        self._waits: dict[tuple[bool, str], tuple[int, float]] = {}
        self._collected: defaultdict[int, float] = defaultdict(float)  # by thread, seconds of processor time
        self._began = 0.0  # of the collection that runs: there is one at a time

    def watch(self) -> None:
        """Time the callbacks of all event loops of this process from now on."""
        run = asyncio.Handle._run
        gc.callbacks.append(self._note_collection)

        def timed(handle: asyncio.Handle) -> None:
            thread = threading.get_ident()
            collected = self._collected[thread]
            at, began = time.perf_counter(), time.thread_time()
            run(handle)
            lasted = time.thread_time() - began
            waited = time.perf_counter() - at - lasted
            if max(lasted, waited) > LIMIT_S:
                name = thread == threading.main_thread().ident, _name_of(handle._callback)  # type: ignore[attr-defined]
                if lasted > LIMIT_S:
                    times, longest, part = self._found.get(name, (0, 0.0, 0.0))
                    longest, part = max((longest, part), (lasted, self._collected[thread] - collected))
                    self._found[name] = times + 1, longest, part
                if waited > LIMIT_S:
                    times, most = self._waits.get(name, (0, 0.0))
                    self._waits[name] = times + 1, max(most, waited)

        asyncio.Handle._run = timed  # type: ignore[assignment, method-assign]

    def _note_collection(self, phase: str, _: Mapping[str, int]) -> None:
        if phase == "start":
            self._began = time.thread_time()
        else:
            self._collected[threading.get_ident()] += time.thread_time() - self._began

    def write(self, path: Path) -> None:
        """Write rows of those that ran, and of those that waited: is it the service's loop, name, number, times."""
        lists = [
            sorted(([*name, *row] for name, row in rows.items()), key=lambda row: -row[3])
            for rows in (self._found, self._waits)
        ]
        path.write_text(json.dumps(lists), encoding="utf-8")


if __name__ == "__main__":
    report = Path(sys.argv.pop(1))
    longest = Longest()
    longest.watch()
    try:
        main()
    finally:
        longest.write(report)
