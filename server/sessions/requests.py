"""Commands that replace the map of a session and so make the present computation useless."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: After this time without a finished map, commands no longer cancel the computation: a map must be shown.
MAX_CANCELLING_S = 1.5


class ReplacingRequests:
    """The commands that replace the map: queued, begun, finished. Fields are set on the event loop, read anywhere."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._is_cancellable = False  #: whether the current computation may be cancelled
        self._is_outdatable = False  #: and also by a newer command that replaces the map
        self._is_cancelled = False  #: whether a client asked to end it
        self._queued = self._begun = 0  #: how many were queued, and how many of them were started
        self._since: float | None = None  #: arrival of the first of those without a finished map

    def add(self) -> None:
        """Note that one was queued."""
        self._queued += 1
        self._since = self._clock() if self._since is None else self._since

    def cancel(self) -> None:
        """Note that a client asked to end the current computation."""
        self._is_cancelled = True

    def begin_tick(self) -> None:
        """Note that a computation begins of all that were queued."""
        self._begun = self._queued

    def accept_cancel(self) -> None:
        """Note that a ``cancel`` that came before concerns what was computed before."""
        self._is_cancelled = False

    def end_tick(self, *, was_cancelled: bool) -> None:
        """Note that the computation has ended."""
        if self._queued == self._begun:
            self._since = None
        elif not was_cancelled:
            self._since = self._clock()

    @contextmanager
    def cancellable(self, *, by_newer: bool = True) -> Iterator[None]:
        """Return a context in which ``cancel``, and a newer command, cancels the computation (worker thread)."""
        self._is_cancellable, self._is_outdatable = True, by_newer
        try:
            yield
        finally:
            self._is_cancellable = False

    @property
    def is_useless(self) -> bool:
        """Whether the current computation should end (any thread)."""
        return self._is_cancellable and (self._is_cancelled or self._is_outdated())

    def _is_outdated(self) -> bool:
        since = self._since
        is_new = self._is_outdatable and self._queued > self._begun
        return is_new and since is not None and self._clock() - since < MAX_CANCELLING_S
