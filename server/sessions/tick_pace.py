"""The time from one tick of a session to the next."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from server.stream.hub import Hub

T = TypeVar("T")

TICK_S = 1.0 / 30.0
MAX_TICK_S = 0.1  #: longest wall time that one tick simulates: a slow machine plays slower
OVERLOADED_TICK_S = 0.5  #: between ticks that nobody has acknowledged, while ticks wait long for a thread


class TickPace:
    """Chooses the time to the next tick: a frame that no client may be sent yet is not computed.

    While ticks wait for a thread for longer than :data:`TICK_S`, none is computed before a client has acknowledged the
    last frame, or :data:`OVERLOADED_TICK_S` have passed: of two frames that a page receives between two of its own it
    paints the newer one only.
    """

    def __init__(self) -> None:
        self.is_full = False  #: whether no client could be sent a frame when the time was chosen last
        self.waited_s = 0.0  #: for which the newest tick waited for a thread

    def tick_s(self, hub: Hub, *, has_listeners: bool) -> float:
        """Return the time from one tick to the next, seconds; listeners are called at each tick."""
        is_overloaded = self.waited_s > TICK_S
        self.is_full = not has_listeners and not (hub.has_acknowledged if is_overloaded else hub.has_room)
        if not self.is_full:
            return TICK_S
        return OVERLOADED_TICK_S if is_overloaded else MAX_TICK_S

    def measured(self, job: Callable[[], T]) -> Callable[[], T]:
        """Return ``job``, a tick, as a job that notes how long it has waited since now for its thread."""
        asked = time.monotonic()

        def run() -> T:
            self.waited_s = time.monotonic() - asked
            return job()

        return run
