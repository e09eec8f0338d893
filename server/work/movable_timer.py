"""A timer whose time changes more often than it ends."""

from __future__ import annotations

import asyncio
from collections.abc import Callable


class MovableTimer:
    """Calls ``callback`` once when the time that was set last has come (event loop).

    A later time, or none, leaves the event loop's own timer as it is: that one looks at the time when it ends, and is
    made again for the rest. Timers made and cancelled at each frame of each session cost several times as much.
    """

    def __init__(self, callback: Callable[[], None]) -> None:
        self._callback = callback
        self._loop = asyncio.get_running_loop()
        self._due: float | None = None
        self._handle: asyncio.TimerHandle | None = None

    def set(self, due: float | None) -> None:
        """Call at ``due``, a time of the event loop, instead of before; None: not at all."""
        self._due = due
        if due is None or (self._handle is not None and self._handle.when() <= due):
            return
        self.close()
        self._due, self._handle = due, self._loop.call_at(due, self._look)

    def set_in(self, seconds: float) -> None:
        """Call in ``seconds`` from now instead."""
        self.set(self._loop.time() + seconds)

    def close(self) -> None:
        """Do not call any more, and keep no timer of the event loop."""
        self._due = None
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None

    def _look(self) -> None:
        ended, self._handle = self._handle, None
        due = self._due
        if due is None or ended is None:
            return
        if due > ended.when():
            self.set(due)
            return
        self._due = None
        self._callback()
