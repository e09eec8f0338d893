"""Who computes next: turns of at most :data:`SLICE_S`, shared out by address and by visitor.

A job holds a turn while it computes. At its checkpoints it hands the turn on when the turn has lasted a slice and
somebody else waits. Of those who wait comes first the address that holds the fewest turns, and of equal ones the one
that was served the longest ago; within an address the same holds for its visitors. So a visitor's many jobs share that
visitor's part, and many visitors behind one address share that of the address.

A job is urgent while a person waits for it and it has computed for no longer than :data:`URGENT_S`. Other jobs stand
back while an urgent one computes or waits: the threads of this process share the interpreter and the cores. They are
given one slice after :data:`STAND_BACK_S` of urgent computing all the same.
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

SLICE_S = 0.05  #: how long a turn lasts where others wait
URGENT_S = 0.4  #: how long a job may have computed and be urgent still
STAND_BACK_S = 0.2  #: urgent computing after which a job that stands back is given a slice
_REMEMBERED = 1024  #: addresses and visitors of whom it is known when they were served last


@dataclass(frozen=True, slots=True)
class Party:
    """For whom something is computed: a visitor, and the address that the visitor came from."""

    visitor: str
    address: str = ""


def _promise() -> Future[None]:
    """Return a future that nobody can cancel any more: whoever waits for it leaves instead."""
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
    stood_back: bool = False  #: whether the slice was given while urgent jobs were about


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

    # -- for whoever computes -----------------------------------------------------------------------------------------

    async def run(self, pool: Executor, party: Party, job: Callable[[], T], *, waited_for: bool = True) -> T:
        """Compute ``job`` on a thread of ``pool`` when it is its turn; ``waited_for`` says whether a person waits.

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
        """Hand a held turn to whoever comes next, and ask for another one, which may be granted at once."""
        with self._lock:
            self._take_back(turn)
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
        """Grant turns while there are free ones and somebody may have them."""
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
        """Return who has the next turn: None where nobody waits, or only who stands back."""
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


def checkpoint() -> None:
    """Hand this thread's turn on where it is over, and return when there is another one.

    Jobs call it about every hundredth of a second. Outside a scheduler's job it does nothing.
    """
    scheduler: Scheduler | None = getattr(_here, "scheduler", None)
    turn: Turn | None = getattr(_here, "turn", None)
    if scheduler is not None and turn is not None and scheduler.is_over(turn):
        scheduler.hand_on(turn)
        turn.granted.result()
