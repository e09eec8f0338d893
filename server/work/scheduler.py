"""Fair scheduling of computations in time slices of :data:`SLICE_S`, by address and by visitor.

A job holds a turn while it computes. At its checkpoints it yields the turn if the turn has lasted a slice and other
jobs wait. The next turn goes to the waiting address that holds the fewest turns, on a tie to the one served least
recently; within an address the same rule holds for its visitors. A visitor's jobs therefore share the visitor's part,
and the visitors behind one address share the part of the address.

A job is urgent while a user waits for it and it has computed for at most :data:`URGENT_S`. Other jobs are held back
while an urgent one computes or waits: the threads of this process share the interpreter and the cores. They still get
one slice after each :data:`STAND_BACK_S` of urgent computing.
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
STAND_BACK_S = 0.2  #: urgent computing after which a job that is held back gets a slice
_REMEMBERED = 1024  #: addresses and visitors whose last turn is remembered


@dataclass(frozen=True, slots=True)
class Party:
    """The visitor for whom a job computes, and the visitor's address."""

    visitor: str
    address: str = ""


def _promise() -> Future[None]:
    """Return a future that cannot be cancelled: cancelling a waiting job removes its turn instead."""
    future: Future[None] = Future()
    future.set_running_or_notify_cancel()
    return future


@dataclass(slots=True, eq=False)
class Turn:
    """One job's place: it waits, or it holds a turn. ``computed_s`` is how long it has held turns in all."""

    party: Party
    waited_for: bool
    number: int
    granted: Future[None] = field(default_factory=_promise)
    began: float = 0.0  #: when the slice began
    computed_s: float = 0.0
    stood_back: bool = False  #: whether the slice was granted although urgent jobs waited or ran


class Scheduler:
    """Gives out ``slots`` turns at a time. May be used from every thread."""

    def __init__(self, slots: int, slice_s: float = SLICE_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._slots, self._slice_s, self._clock = slots, slice_s, clock
        self._lock = threading.Lock()
        self._waiting: list[Turn] = []
        self._running: list[Turn] = []
        self._served: OrderedDict[tuple[str, ...], int] = OrderedDict()  #: when addresses and visitors had a turn last
        self._count = 0
        self._urgent_s = 0.0  #: urgent computing since a job that stands back was given a slice

    # -- jobs ---------------------------------------------------------------------------------------------------------

    async def run(self, pool: Executor, party: Party, job: Callable[[], T], *, waited_for: bool = True) -> T:
        """Compute ``job`` on a thread of ``pool`` when it is its turn; ``waited_for`` says whether a user waits.

        The pool needs a thread for each job that has begun. Cancelled while it waits for its first turn, the job does
        not begin; later, it goes on to its end, which it notices by means of its own.
        """
        turn = self.ask(party, waited_for=waited_for)
        try:
            if not turn.granted.done():
                await asyncio.wrap_future(turn.granted)
            begun = pool.submit(self._computed, turn, job)
        except BaseException:  # cancelled, or the pool takes no more
            self.leave(turn)
            raise
        begun.add_done_callback(lambda _: self.leave(turn))  # also where it is cancelled before a thread took it up
        return await asyncio.wrap_future(begun)

    def _computed(self, turn: Turn, job: Callable[[], T]) -> T:
        _here.scheduler, _here.turn = self, turn
        try:
            return job()
        finally:
            _here.scheduler = _here.turn = None

    # -- turns --------------------------------------------------------------------------------------------------------

    def ask(self, party: Party, *, waited_for: bool = True) -> Turn:
        """Return a new turn, which is held once its ``granted`` is done."""
        with self._lock:
            self._count += 1
            turn = Turn(party, waited_for, self._count)
            self._waiting.append(turn)
            self._give()
        return turn

    def leave(self, turn: Turn) -> None:
        """Give a turn back, or wait for it no longer."""
        with self._lock:
            if turn in self._waiting:
                self._waiting.remove(turn)
            elif turn in self._running:
                self._take_back(turn)
            self._give()

    def is_over(self, turn: Turn) -> bool:
        """Return whether a turn that is held should be handed on now."""
        lasted = self._clock() - turn.began
        if lasted >= self._slice_s:
            return bool(self._waiting)
        return not turn.stood_back and not self._is_urgent(turn) and any(map(self._is_urgent, self._all_but(turn)))

    def hand_on(self, turn: Turn) -> None:
        """Yield a held turn to the next job, and request another one, which may be granted at once."""
        with self._lock:
            self._take_back(turn)
            self._wait_again(turn)

    def give_back(self, turn: Turn) -> None:
        """Yield a held turn without requesting another one."""
        with self._lock:
            self._take_back(turn)
            self._give()

    def ask_again(self, turn: Turn) -> None:
        """Request another turn after :meth:`give_back`; it may be granted at once."""
        with self._lock:
            self._wait_again(turn)

    def _wait_again(self, turn: Turn) -> None:
        self._count += 1
        turn.granted, turn.number = _promise(), self._count
        self._waiting.append(turn)
        self._give()

    def _all_but(self, turn: Turn) -> list[Turn]:
        return [other for other in (*self._running, *self._waiting) if other is not turn]

    def _is_urgent(self, turn: Turn) -> bool:
        running_s = self._clock() - turn.began if turn in self._running else 0.0
        return turn.waited_for and turn.computed_s + running_s <= URGENT_S

    def _take_back(self, turn: Turn) -> None:
        was_urgent = self._is_urgent(turn)
        lasted = self._clock() - turn.began
        self._running.remove(turn)
        turn.computed_s += lasted
        if was_urgent:
            self._urgent_s += lasted

    def _give(self) -> None:
        """Grant free turns to waiting jobs that may run."""
        while len(self._running) < self._slots and (turn := self._next()) is not None:
            self._waiting.remove(turn)
            self._running.append(turn)
            turn.began = self._clock()
            if not self._is_urgent(turn):
                turn.stood_back = any(map(self._is_urgent, self._all_but(turn)))
                self._urgent_s = 0.0
            self._count += 1
            for key in ((turn.party.address,), (turn.party.address, turn.party.visitor)):
                self._served[key] = self._count
                self._served.move_to_end(key)
            while len(self._served) > _REMEMBERED:
                self._served.popitem(last=False)
            turn.granted.set_result(None)

    def _next(self) -> Turn | None:
        """Return the next turn to grant: None if no job waits, or only jobs that are held back."""
        urgent = [turn for turn in self._waiting if self._is_urgent(turn)]
        others = [turn for turn in self._waiting if turn not in urgent]
        if others and (self._urgent_s >= STAND_BACK_S or not (urgent or any(map(self._is_urgent, self._running)))):
            return self._first(others)
        return self._first(urgent) if urgent else None

    def _first(self, turns: list[Turn]) -> Turn:
        addresses = Counter(turn.party.address for turn in self._running)
        visitors = Counter(turn.party for turn in self._running)

        def order(turn: Turn) -> tuple[int, int, int, int, int]:
            party = turn.party
            served = (self._served.get((party.address,), 0), self._served.get((party.address, party.visitor), 0))
            return (addresses[party.address], served[0], visitors[party], served[1], turn.number)

        return min(turns, key=order)


_here = threading.local()


def stand_aside(until: threading.Event, timeout_s: float) -> None:
    """Give this thread's turn back, wait for ``until``, at most so long, and return when the job has another turn."""
    scheduler: Scheduler | None = getattr(_here, "scheduler", None)
    turn: Turn | None = getattr(_here, "turn", None)
    if scheduler is not None and turn is not None:
        scheduler.give_back(turn)
    until.wait(timeout_s)
    if scheduler is not None and turn is not None:
        scheduler.ask_again(turn)
        turn.granted.result()


def checkpoint() -> None:
    """Yield this thread's turn if it is over, and return when the job has another one.

    Jobs call it about every hundredth of a second. Outside a scheduler's job it does nothing.
    """
    scheduler: Scheduler | None = getattr(_here, "scheduler", None)
    turn: Turn | None = getattr(_here, "turn", None)
    if scheduler is not None and turn is not None and scheduler.is_over(turn):
        scheduler.hand_on(turn)
        turn.granted.result()
