"""Fair scheduling of computations in time slices of :data:`SLICE_S`, by address and by visitor.

A job holds a turn while it computes. At its checkpoints it yields the turn if the turn has lasted a slice and other
jobs wait. The next turn goes to the waiting address that holds the fewest turns, on a tie to the one served least
recently; within an address the same rule holds for its visitors. A visitor's jobs therefore share the visitor's part,
and the visitors behind one address share the part of the address.

A job is urgent while it is interactive (a user waits for it) and has computed for at most :data:`URGENT_S`. Other jobs
are deferred while an urgent one computes or waits: the threads of this process share the interpreter and the cores.
They still get one slice after each :data:`DEFERRED_EVERY_S` of urgent computing.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections import Counter, OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from typing import TypeVar

T = TypeVar("T")

SLICE_S = 0.05  #: length of a turn while others wait
URGENT_S = 0.4  #: computing time for which a job stays urgent
DEFERRED_EVERY_S = 0.2  #: urgent computing after which a deferred job gets a slice
_MAX_HISTORY = 1024  #: addresses and visitors whose last turn is recorded


@dataclass(frozen=True, slots=True)
class JobOwner:
    """The visitor for whom a job computes, and the visitor's address."""

    visitor: str
    address: str = ""


def _uncancellable() -> Future[None]:
    """Return a future that cannot be cancelled: cancelling a waiting job removes its turn instead."""
    future: Future[None] = Future()
    future.set_running_or_notify_cancel()
    return future


@dataclass(slots=True, eq=False)
class Turn:
    """A job's turn, waiting or held. ``computed_s`` is the total time for which the job has held turns."""

    owner: JobOwner
    interactive: bool
    number: int
    granted: Future[None] = field(default_factory=_uncancellable)
    began: float = 0.0  #: when the slice began
    computed_s: float = 0.0
    was_deferred: bool = False  #: whether the slice was granted while urgent jobs waited or ran


class Scheduler:
    """Grants at most ``slots`` turns at a time. Thread-safe."""

    def __init__(self, slots: int, slice_s: float = SLICE_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._slots, self._slice_s, self._clock = slots, slice_s, clock
        self._lock = threading.Lock()
        self._waiting: list[Turn] = []
        self._running: list[Turn] = []
        #: Number of the last turn of each address and visitor.
        self._served: OrderedDict[tuple[str, ...], int] = OrderedDict()
        self._count = 0
        self._urgent_s = 0.0  #: urgent computing since the last slice of a deferred job

    # -- jobs ---------------------------------------------------------------------------------------------------------

    async def run(self, pool: Executor, owner: JobOwner, job: Callable[[], T], *, interactive: bool = True) -> T:
        """Compute ``job`` on a thread of ``pool`` once it has a turn; ``interactive`` says whether a user waits.

        The pool needs a thread for each job that has begun. A job cancelled before its first turn does not begin; one
        cancelled later runs to its end.
        """
        turn = self.request(owner, interactive=interactive)
        try:
            if not turn.granted.done():
                await asyncio.wrap_future(turn.granted)
            running = pool.submit(self._run_job, turn, job)
        except BaseException:  # cancelled, or the pool takes no more
            self.release(turn)
            raise
        running.add_done_callback(lambda _: self.release(turn))  # also if it is cancelled before it begins
        return await asyncio.wrap_future(running)

    def _run_job(self, turn: Turn, job: Callable[[], T]) -> T:
        _current.scheduler, _current.turn = self, turn
        try:
            return job()
        finally:
            _current.scheduler = _current.turn = None

    # -- turns --------------------------------------------------------------------------------------------------------

    def request(self, owner: JobOwner, *, interactive: bool = True) -> Turn:
        """Return a new turn, which is held once its ``granted`` is done."""
        with self._lock:
            self._count += 1
            turn = Turn(owner, interactive, self._count)
            self._waiting.append(turn)
            self._grant_free()
        return turn

    def release(self, turn: Turn) -> None:
        """End a held turn, or withdraw a waiting one."""
        with self._lock:
            if turn in self._waiting:
                self._waiting.remove(turn)
            elif turn in self._running:
                self._end_slice(turn)
            self._grant_free()

    def should_yield(self, turn: Turn) -> bool:
        """Return whether a held turn should be yielded now."""
        lasted = self._clock() - turn.began
        if lasted >= self._slice_s:
            return bool(self._waiting)
        return not turn.was_deferred and not self._is_urgent(turn) and any(map(self._is_urgent, self._others(turn)))

    def yield_turn(self, turn: Turn) -> None:
        """Yield a held turn to the next job, and request another one, which may be granted at once."""
        with self._lock:
            self._end_slice(turn)
            self._request_again(turn)

    def suspend(self, turn: Turn) -> None:
        """Yield a held turn without requesting another one."""
        with self._lock:
            self._end_slice(turn)
            self._grant_free()

    def resume(self, turn: Turn) -> None:
        """Request another turn after :meth:`suspend`; it may be granted at once."""
        with self._lock:
            self._request_again(turn)

    def _request_again(self, turn: Turn) -> None:
        self._count += 1
        turn.granted, turn.number = _uncancellable(), self._count
        self._waiting.append(turn)
        self._grant_free()

    def _others(self, turn: Turn) -> list[Turn]:
        return [other for other in (*self._running, *self._waiting) if other is not turn]

    def _is_urgent(self, turn: Turn) -> bool:
        running_s = self._clock() - turn.began if turn in self._running else 0.0
        return turn.interactive and turn.computed_s + running_s <= URGENT_S

    def _end_slice(self, turn: Turn) -> None:
        was_urgent = self._is_urgent(turn)
        lasted = self._clock() - turn.began
        self._running.remove(turn)
        turn.computed_s += lasted
        if was_urgent:
            self._urgent_s += lasted

    def _grant_free(self) -> None:
        """Grant free turns to waiting jobs that may run."""
        while len(self._running) < self._slots and (turn := self._next()) is not None:
            self._waiting.remove(turn)
            self._running.append(turn)
            turn.began = self._clock()
            if not self._is_urgent(turn):
                turn.was_deferred = any(map(self._is_urgent, self._others(turn)))
                self._urgent_s = 0.0
            self._count += 1
            for key in ((turn.owner.address,), (turn.owner.address, turn.owner.visitor)):
                self._served[key] = self._count
                self._served.move_to_end(key)
            while len(self._served) > _MAX_HISTORY:
                self._served.popitem(last=False)
            turn.granted.set_result(None)

    def _next(self) -> Turn | None:
        """Return the next turn to grant: None if no job waits, or only deferred ones."""
        urgent = [turn for turn in self._waiting if self._is_urgent(turn)]
        others = [turn for turn in self._waiting if turn not in urgent]
        if others and (self._urgent_s >= DEFERRED_EVERY_S or not (urgent or any(map(self._is_urgent, self._running)))):
            return self._fairest(others)
        return self._fairest(urgent) if urgent else None

    def _fairest(self, turns: list[Turn]) -> Turn:
        addresses = Counter(turn.owner.address for turn in self._running)
        visitors = Counter(turn.owner for turn in self._running)

        def order(turn: Turn) -> tuple[int, int, int, int, int]:
            owner = turn.owner
            served = (self._served.get((owner.address,), 0), self._served.get((owner.address, owner.visitor), 0))
            return (addresses[owner.address], served[0], visitors[owner], served[1], turn.number)

        return min(turns, key=order)


_current = threading.local()


def wait_without_turn(until: threading.Event, timeout_s: float) -> None:
    """Yield this thread's turn, wait for ``until``, at most so long, and return when the job has another turn."""
    scheduler: Scheduler | None = getattr(_current, "scheduler", None)
    turn: Turn | None = getattr(_current, "turn", None)
    if scheduler is not None and turn is not None:
        scheduler.suspend(turn)
    until.wait(timeout_s)
    if scheduler is not None and turn is not None:
        scheduler.resume(turn)
        turn.granted.result()


def checkpoint() -> None:
    """Yield this thread's turn if it is over, and return when the job has another one.

    Jobs call it about every hundredth of a second. Outside a scheduler's job it does nothing.
    """
    scheduler: Scheduler | None = getattr(_current, "scheduler", None)
    turn: Turn | None = getattr(_current, "turn", None)
    if scheduler is not None and turn is not None and scheduler.should_yield(turn):
        scheduler.yield_turn(turn)
        turn.granted.result()
