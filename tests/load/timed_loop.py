"""``python -m tests.load.timed_loop REPORT serve …``: the command with each callback of its event loop timed.

Of those that took the loop's thread longer than :data:`LIMIT_S` of processor time, a file is written when the command
ends: a list of what ran, the longest first, with how often it did and the longest time. Time for which the thread
waited for a core, or for the interpreter's lock, is not in it.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Iterator
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
    """How often each callback took longer than the limit, and the longest time, seconds."""

    def __init__(self) -> None:
        self._found: dict[str, tuple[int, float]] = {}

    def watch(self) -> None:
        """Time the callbacks of all event loops of this process from now on."""
        run = asyncio.Handle._run

        def timed(handle: asyncio.Handle) -> None:
            began = time.thread_time()
            run(handle)
            lasted = time.thread_time() - began
            if lasted > LIMIT_S:
                name = _name_of(handle._callback)  # type: ignore[attr-defined]
                times, longest = self._found.get(name, (0, 0.0))
                self._found[name] = times + 1, max(longest, lasted)

        asyncio.Handle._run = timed  # type: ignore[assignment, method-assign]

    def write(self, path: Path) -> None:
        """Write a list of name, number and longest time."""
        rows = [(name, *found) for name, found in self._found.items()]
        path.write_text(json.dumps(sorted(rows, key=lambda row: -row[2])), encoding="utf-8")


if __name__ == "__main__":
    report = Path(sys.argv.pop(1))
    longest = Longest()
    longest.watch()
    try:
        main()
    finally:
        longest.write(report)
