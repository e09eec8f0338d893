"""The host's interface to its model and the model's parts."""

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
    """Interface of the host to its model. Implemented by :class:`server.sessions.host.SessionHost`."""

    closed: bool
    scheduler: Scheduler
    job_owner: JobOwner

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def limits(self) -> Limits:
        """Return the current limits of the session's grids (any thread)."""

    def may_continue(self) -> bool:
        """Yield to other sessions, and return whether the computation should continue."""

    def in_background(self) -> Callable[[], bool]:
        """Return a function that a background computation calls regularly.

        The function yields to other sessions, waits while this session runs a long computation, and returns whether the
        session is open.
        """

    def cancellable(self, *, by_newer: bool = True) -> AbstractContextManager[None]:
        """Return a context in which :meth:`may_continue` is False once a client asks to cancel the computation.

        Unless ``by_newer`` is False, it is also False once a newer command makes the result useless.
        """

    # -- on the event loop ----------------------------------------------------------------------------------------

    async def carried_out(self) -> None:
        """Wait until the commands that are queued now have been carried out, or the session has ended."""

    def locked(self) -> AbstractAsyncContextManager[None]:
        """Return a context in which the session computes nothing, so that its maps can be read."""

    def settled(self) -> AbstractAsyncContextManager[None]:
        """Return a context like :meth:`locked` in which all requested changes of the maps are complete."""

    async def on_thread(self, job: Callable[[], T]) -> T:
        """Compute ``job`` on a scheduled worker thread."""

    def enqueue(self, command: Struct) -> None:
        """Queue a command of the service. Raises :class:`server.stream.protocol.ProtocolError` if the queue is full."""

    def deliver(self, result: TickResult) -> None:
        """Send the result of a computation between two ticks."""
