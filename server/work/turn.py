"""The turns that the scheduler grants, and what is computed in them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class JobOwner:
    """The visitor for whom a job computes, and the visitor's address."""

    visitor: str
    address: str = ""


def uncancellable() -> Future[None]:
    """Return a future that cannot be cancelled: cancelling a waiting job removes its turn instead."""
    future: Future[None] = Future()
    future.set_running_or_notify_cancel()
    return future


@dataclass(slots=True, eq=False)
class Task:
    """Computation of a turn on a thread of ``pool``, and the future of ``loop`` that waits for it."""

    pool: Executor
    job: Callable[[], Any]
    loop: asyncio.AbstractEventLoop
    done: asyncio.Future[Any]

    def compute(self) -> Finished:
        """Compute it; an error is part of the result."""
        try:
            return Finished(self.done, self.job(), None)
        except BaseException as error:  # noqa: BLE001 - whoever waits for the job gets it
            return Finished(self.done, None, error)


@dataclass(frozen=True, slots=True)
class Finished:
    """Result of a job, or the error that it raised, for the future that waits for it."""

    done: asyncio.Future[Any]
    result: Any
    error: BaseException | None

    def tell(self) -> None:
        """Set the future (event loop), unless the wait for it was cancelled."""
        if self.done.done():
            return
        if self.error is None:
            self.done.set_result(self.result)
        else:
            self.done.set_exception(self.error)


@dataclass(slots=True, eq=False)
class Turn:
    """A job's turn, waiting or held. ``computed_s`` is the total time for which the job has held turns."""

    owner: JobOwner
    interactive: bool
    number: int
    request: Future[None] | None = None  #: done when the turn is granted; None while nobody waits for that
    began: float = 0.0  #: when the slice began
    computed_s: float = 0.0
    was_deferred: bool = False  #: whether the slice was granted while urgent jobs waited or ran
    granted_before: bool = False  #: whether a slice of it was granted
    is_brief: bool = False  #: whether it is expected to take a few ms
    task: Task | None = None  #: what the scheduler computes in it; None: whoever requested it computes

    @property
    def granted(self) -> Future[None]:
        """Done once the turn is held. A turn that was requested for a task has it after its first slice only."""
        if self.request is None:
            raise RuntimeError("nobody waits for this turn")
        return self.request
