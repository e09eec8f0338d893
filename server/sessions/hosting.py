"""The interface of the host that a model and its parts use."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from typing import Protocol, TypeVar

from msgspec import Struct

from mapper.core.limits import Limits
from server.sessions.tick import TickResult
from server.work.scheduler import JobOwner, Scheduler

T = TypeVar("T")


class ModelHost(Protocol):
    """The host's interface for its model; implemented by :class:`server.sessions.host.SessionHost`."""

    closed: bool
    scheduler: Scheduler
    job_owner: JobOwner

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def limits(self) -> Limits:
        """Return the present limits of the session's grids (any thread)."""

    def may_continue(self) -> bool:
        """Yield to other sessions, and return whether the computation should continue."""

    def in_background(self) -> Callable[[], bool]:
        """Return a function for a computation that nobody waits for, which calls it all the while.

        It yields to other sessions, waits while this session computes something that takes long, and returns whether
        the session is open.
        """

    def cancellable(self, *, by_newer: bool = True) -> AbstractContextManager[None]:
        """Return a context in which :meth:`may_continue` is False once a client asks to cancel the computation.

        It is False as well, unless ``by_newer`` is False, once a newer command makes the result useless.
        """

    # -- on the event loop ----------------------------------------------------------------------------------------

    async def carried_out(self) -> None:
        """Wait until the commands that are queued now have been carried out, or the session has ended."""

    def locked(self) -> AbstractAsyncContextManager[None]:
        """Return a context in which the session computes nothing, so that its maps can be read."""

    def settled(self) -> AbstractAsyncContextManager[None]:
        """Return a context as :meth:`locked` does, in which the maps are those that commands requested."""

    async def on_thread(self, job: Callable[[], T]) -> T:
        """Compute ``job`` on a worker thread as scheduled."""

    def enqueue(self, command: Struct) -> None:
        """Queue a command of the service itself. Raises :class:`server.stream.protocol.ProtocolError` if it is full."""

    def deliver(self, result: TickResult) -> None:
        """Send the result of a computation between two ticks."""
