"""What a model and its parts may ask of the host that runs them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from typing import Protocol, TypeVar

from mapper.core.limits import Limits
from server.sessions.tick import TickResult
from server.work.scheduler import Party, Scheduler

T = TypeVar("T")


class ModelHost(Protocol):
    """The host as its model sees it; :class:`server.sessions.host.SessionHost` is one."""

    closed: bool
    scheduler: Scheduler
    party: Party

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def limits(self) -> Limits:
        """Return what the session's grids may grow to now (any thread)."""

    def may_continue(self) -> bool:
        """Let others have their turn, and return whether what is being computed is still wanted."""

    def is_open(self) -> bool:
        """Let others have their turn, and return whether the session has not ended."""

    def cancellable(self) -> AbstractContextManager[None]:
        """Return a context in which :meth:`may_continue` is False once a newer command makes the result useless."""

    # -- on the event loop ----------------------------------------------------------------------------------------

    def locked(self) -> AbstractAsyncContextManager[None]:
        """Return a context in which nothing computes in the session, so that its maps can be read."""

    async def on_thread(self, job: Callable[[], T]) -> T:
        """Compute ``job`` on a worker thread in its turn."""

    def deliver(self, result: TickResult) -> None:
        """Send what was computed between two ticks."""
