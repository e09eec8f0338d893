"""Long computations of a session: progress is shown, and computations in the background wait."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine

from server.sessions.messages import working_message
from server.stream.hub import Hub
from server.work.movable_timer import MovableTimer
from server.work.scheduler import checkpoint, wait_without_turn

SHOWN_AFTER_S = 0.3  #: computations that take longer send their progress,
SHOWN_EVERY_S = 0.25  #: at this interval
#: What a background computation waits for long ones of its session, in all: it holds a thread.
MAX_BACKGROUND_WAIT_S = 60.0


class Showing:
    """Runs ``show`` as a task while a computation lasts, from :data:`SHOWN_AFTER_S` after its begin on.

    Most computations end earlier and need no task. It may be begun again.
    """

    def __init__(self, show: Callable[[], Coroutine[None, None, None]]) -> None:
        self._show = show
        self._task: asyncio.Task[None] | None = None
        self._timer = MovableTimer(self._start)

    def begin(self) -> None:
        """Note that a computation has begun."""
        self._timer.set_in(SHOWN_AFTER_S)

    def _start(self) -> None:
        self._task = asyncio.ensure_future(self._show())

    def end(self) -> None:
        """Note that the computation has ended."""
        self._timer.set(None)
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def close(self) -> None:
        """Note that the computation has ended, and that none follows."""
        self.end()
        self._timer.close()


class LongWork:
    """The progress of a session's computations.

    ``fraction`` returns the share of the present one that is done, and ``what`` what it computes.
    """

    def __init__(
        self, hub: Hub, fraction: Callable[[], float | None], clock: Callable[[], float], what: Callable[[], str]
    ) -> None:
        self._hub, self._fraction, self._clock, self._what = hub, fraction, clock, what
        self._nothing_long = threading.Event()  #: whether nothing is computed whose progress is shown
        self._nothing_long.set()

    def showing(self) -> Showing:
        """Return what sends the progress of a computation from its begin to its end."""
        return Showing(self._show)

    async def _show(self) -> None:
        began = self._clock() - SHOWN_AFTER_S
        try:
            self._nothing_long.clear()
            while True:
                self._hub.set_slot(working_message(self._clock() - began, self._fraction(), self._what()))
                await asyncio.sleep(SHOWN_EVERY_S)
        finally:
            self._nothing_long.set()
            self._hub.set_slot(working_message())

    def close(self) -> None:
        """Let computations in the background wait no more."""
        self._nothing_long.set()

    def in_background(self, is_open: Callable[[], bool]) -> Callable[[], bool]:
        """Return a function for a computation that nobody waits for, which calls it all the while (worker thread).

        It yields to other sessions, waits while this session computes something long, in all up to
        :data:`MAX_BACKGROUND_WAIT_S`, and returns ``is_open()``.
        """
        left = MAX_BACKGROUND_WAIT_S

        def waited() -> bool:
            nonlocal left
            checkpoint()
            if left > 0.0 and not self._nothing_long.is_set():
                began = time.monotonic()
                wait_without_turn(self._nothing_long, left)
                left -= time.monotonic() - began
            return is_open()

        return waited
