"""A timer that is rescheduled more often than it fires."""

from __future__ import annotations

import asyncio
from collections.abc import Callable


class MovableTimer:
    """Calls ``callback`` once at the time that was set last (event loop).

    A later time, or none, does not change the event loop's own timer, which checks the time when it fires and is
    renewed for the rest. Creating and cancelling timers at each frame of each session costs several times as much.
    """

    def __init__(self, callback: Callable[[], None]) -> None:
        self._callback = callback
        self._loop = asyncio.get_running_loop()
        self._due: float | None = None
        self._handle: asyncio.TimerHandle | None = None

    def set(self, due: float | None) -> None:
        """Call at ``due``, a time of the event loop, instead of the earlier one; None cancels the call."""
        self._due = due
        if due is None or (self._handle is not None and self._handle.when() <= due):
            return
        self.close()
        self._due, self._handle = due, self._loop.call_at(due, self._look)

    def set_in(self, seconds: float) -> None:
        """Call ``seconds`` from now instead."""
        self.set(self._loop.time() + seconds)

    def close(self) -> None:
        """Cancel the call and the event loop's timer."""
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
