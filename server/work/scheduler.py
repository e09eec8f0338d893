"""Fair scheduling of computations in time slices of :data:`SLICE_S`, by address and by visitor.

A job holds a turn while it computes. At its checkpoints it yields the turn if the turn has lasted a slice and other
jobs wait, and at once if its address holds at least two turns more than that of an urgent job that waits. The next turn
goes to the waiting address that holds the fewest turns, on a tie to the one served least recently; within an address
the same rules hold for its visitors. A visitor's jobs therefore share the visitor's part, and the visitors behind one
address share the part of the address.

A job is urgent while it is interactive (a user waits for it) and has computed for at most :data:`URGENT_S`. Other jobs
are deferred while an urgent one computes or waits: the threads of this process share the interpreter and the cores.
They still get one slice after each :data:`DEFERRED_EVERY_S` of urgent computing.

Of jobs that are expected to be brief, such as most ticks, one computes at a time while more than :data:`FEW` of them
wait: threads that need the interpreter's lock every tenth of a millisecond spend more time on handing it over than a
second core gains.

While several turns are held, only the address that has computed least of late may use more than one core for its turn:
a map that a user waits for is then made as when the user is alone, but for one core that is shared.
"""

from __future__ import annotations

import asyncio
import math
import threading
import time
from collections import Counter, OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor
from typing import TypeVar, cast

from mapper.core.parallel import share_cores
from server.work.turn import Finished, JobOwner, Task, Turn, uncancellable
from server.work.waiting_turns import WaitingTurns

__all__ = ["JobOwner", "Scheduler", "Turn", "checkpoint", "wait_without_turn"]

T = TypeVar("T")

SLICE_S = 0.05  #: length of a turn while others wait
URGENT_S = 0.4  #: computing time for which a job stays urgent
DEFERRED_EVERY_S = 0.2  #: urgent computing after which a deferred job gets a slice
RECENT_S = 5.0  #: time after which computing counts 1 / e of what it did
BRIEF_S = 0.005  #: longest computing time of a brief job
FEW = 4  #: waiting brief jobs that are not kept from turns beside another one
BRIEF_LATE_S = 0.02  #: after which a brief job that still computes does not keep others from a turn beside it
_MAX_HISTORY = 1024  #: addresses and visitors whose last turn is recorded


class Scheduler:
    """Grants at most ``slots`` turns at a time. Thread-safe."""

    def __init__(self, slots: int, slice_s: float = SLICE_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._slots, self._slice_s, self._clock = slots, slice_s, clock
        self._lock = threading.Lock()
        #: Turns that wait: urgent ones, those of them that are brief, and others.
        self._urgent, self._brief, self._deferrable = WaitingTurns(), WaitingTurns(), WaitingTurns()
        self._running: list[Turn] = []
        #: Number of the last turn of each address and visitor.
        self._served: OrderedDict[tuple[str, ...], int] = OrderedDict()
        #: Computing of each address of late, seconds, and when it was computed.
        self._recent: OrderedDict[str, tuple[float, float]] = OrderedDict()
        self._count = 0
        self._urgent_s = 0.0  #: urgent computing since the last slice of a deferred job
        self._startable: list[Turn] = []  #: turns that were granted, and whose tasks have no thread yet
        #: Finished tasks that their event loop has not been told of: it is woken once for all of them.
        self._finished: dict[asyncio.AbstractEventLoop, list[Finished]] = {}

    # -- jobs ---------------------------------------------------------------------------------------------------------

    async def run(
        self, pool: Executor, owner: JobOwner, job: Callable[[], T], *, interactive: bool = True, is_brief: bool = False
    ) -> T:
        """Compute ``job`` on a thread of ``pool`` once it has a turn; ``interactive`` says whether a user waits.

        ``is_brief`` says that it is expected to take less than :data:`BRIEF_S`.
        The pool needs a thread for each job that has begun. A job cancelled before its first turn does not begin; one
        cancelled later runs to its end.
        """
        loop = asyncio.get_running_loop()
        task = Task(pool, job, loop, loop.create_future())
        turn = self.request(owner, interactive=interactive, is_brief=is_brief, task=task)
        try:
            return cast("T", await task.done)
        except asyncio.CancelledError:
            self._withdraw(turn)
            raise

    def _withdraw(self, turn: Turn) -> None:
        with self._lock:
            waiting = self._queue_of(turn)
            if turn in waiting and not turn.granted_before:
                waiting.remove(turn)

    def _work(self, turn: Turn) -> None:
        """Compute a turn's task, then those of the turns that are granted next, on this thread of their pool."""
        share_cores(_leaves_cores)
        if turn not in self._running:  # the pool had no thread for it at first, and it was given up
            return
        following: Turn | None = turn
        while following is not None and (task := following.task) is not None:
            _current.scheduler, _current.turn = self, following
            finished = task.compute()
            _current.scheduler = _current.turn = None
            with self._lock:
                self._end_slice(following)
                self._grant_free()
                following = next((one for one in self._startable if one.task and one.task.pool is task.pool), None)
                if following is not None:
                    self._startable.remove(following)
            self._tell(task.loop, finished)
            self._start()

    def _start(self) -> None:
        """Begin the tasks of granted turns on threads of their pools."""
        while self._startable:
            with self._lock:
                turn = self._startable.pop(0) if self._startable else None
            if turn is None or turn.task is None:
                return
            try:
                turn.task.pool.submit(self._work, turn)
            except RuntimeError as error:  # the pool takes no more
                self._tell(turn.task.loop, Finished(turn.task.done, None, error))
                self.release(turn)

    def _tell(self, loop: asyncio.AbstractEventLoop, finished: Finished) -> None:
        with self._lock:
            waiting = self._finished.setdefault(loop, [])
            waiting.append(finished)
            is_first = len(waiting) == 1
        if is_first:
            try:
                loop.call_soon_threadsafe(self._tell_all, loop)
            except RuntimeError:  # the loop is closed: nobody waits any more
                self._finished.pop(loop, None)

    def _tell_all(self, loop: asyncio.AbstractEventLoop) -> None:
        with self._lock:
            finished = self._finished.pop(loop, [])
        for one in finished:
            one.tell()

    # -- turns --------------------------------------------------------------------------------------------------------

    def request(
        self, owner: JobOwner, *, interactive: bool = True, is_brief: bool = False, task: Task | None = None
    ) -> Turn:
        """Return a new turn, which is held once its ``granted`` is done."""
        with self._lock:
            self._count += 1
            request = None if task else uncancellable()
            turn = Turn(owner, interactive, self._count, request, is_brief=is_brief, task=task)
            self._queue_of(turn).add(turn)
            self._grant_free()
        self._start()
        return turn

    def release(self, turn: Turn) -> None:
        """End a held turn, or withdraw a waiting one."""
        with self._lock:
            waiting = self._queue_of(turn)
            if turn in waiting:
                waiting.remove(turn)
            elif turn in self._running:
                self._end_slice(turn)
            self._grant_free()
        self._start()

    def should_yield(self, turn: Turn) -> bool:
        """Return whether a held turn should be yielded now."""
        lasted = self._clock() - turn.began
        if lasted >= self._slice_s:
            return bool(self._grantable() or self._deferrable)
        if not self._is_urgent(turn):
            return not turn.was_deferred and self._has_urgent_besides(turn)
        return bool(self._grantable()) and len(self._running) > 1 and self._is_one_too_many(turn)

    def _is_one_too_many(self, turn: Turn) -> bool:
        """Whether an urgent turn waits of an address, or of a visitor at this address, that holds fewer turns by two.

        To wait for the end of a slice takes longer than many a map that a user waits for.
        """
        with self._lock:
            addresses = Counter(one.owner.address for one in self._running)
            visitors = Counter(one.owner for one in self._running)
            own, here = turn.owner, turn.owner.address
            return any(
                visitors[owner] + 2 <= visitors[own]
                if owner.address == here
                else addresses[owner.address] + 2 <= addresses[here]
                for owner in {waiting.owner for waiting in self._grantable()}
            )

    def leaves_cores(self, turn: Turn) -> bool:
        """Return whether a held turn should compute on its own thread only, and leave the other cores to others."""
        with self._lock:
            others = [one for one in self._running if one is not turn]
            if not others:
                return False
            now, address = self._clock(), turn.owner.address
            own = self._computed_of_late(address, now) + now - turn.began
            return any(
                one.owner.address == address or self._computed_of_late(one.owner.address, now) + now - one.began <= own
                for one in others
            )

    def _computed_of_late(self, address: str, now: float) -> float:
        seconds, at = self._recent.get(address, (0.0, now))
        return seconds * math.exp((at - now) / RECENT_S)

    def yield_turn(self, turn: Turn) -> None:
        """Yield a held turn to the next job, and request another one, which may be granted at once."""
        with self._lock:
            self._end_slice(turn)
            self._request_again(turn)
        self._start()

    def suspend(self, turn: Turn) -> None:
        """Yield a held turn without requesting another one."""
        with self._lock:
            self._end_slice(turn)
            self._grant_free()
        self._start()

    def resume(self, turn: Turn) -> None:
        """Request another turn after :meth:`suspend`; it may be granted at once."""
        with self._lock:
            self._request_again(turn)
        self._start()

    def _request_again(self, turn: Turn) -> None:
        self._count += 1
        turn.request, turn.number = uncancellable(), self._count
        self._queue_of(turn).add(turn)
        self._grant_free()

    def _queue_of(self, turn: Turn) -> WaitingTurns:
        """Return the queue of a turn that does not run: its computing time grows only while it runs."""
        if not self._is_urgent(turn):
            return self._deferrable
        return self._brief if turn.is_brief else self._urgent

    def _grantable(self) -> list[Turn]:
        """Return the first urgent turn of each owner that may be granted beside those that are held."""
        firsts = self._urgent.firsts()
        if self._brief and not (len(self._brief) > FEW and self._runs_brief()):
            firsts += self._brief.firsts()
        return firsts

    def _runs_brief(self) -> bool:
        late = self._clock() - BRIEF_LATE_S
        return any(one.is_brief and one.began > late for one in self._running)

    def _has_urgent_besides(self, turn: Turn) -> bool:
        return bool(self._urgent or self._brief) or any(
            self._is_urgent(other) for other in self._running if other is not turn
        )

    def _is_urgent(self, turn: Turn) -> bool:
        running_s = self._clock() - turn.began if turn in self._running else 0.0
        return turn.interactive and turn.computed_s + running_s <= URGENT_S

    def _end_slice(self, turn: Turn) -> None:
        was_urgent = self._is_urgent(turn)
        now, address = self._clock(), turn.owner.address
        lasted = now - turn.began
        self._running.remove(turn)
        turn.computed_s += lasted
        self._recent[address] = (self._computed_of_late(address, now) + lasted, now)
        self._recent.move_to_end(address)
        if len(self._recent) > _MAX_HISTORY:
            self._recent.popitem(last=False)
        if was_urgent:
            self._urgent_s += lasted

    def _grant_free(self) -> None:
        """Grant free turns to waiting jobs that may run."""
        while len(self._running) < self._slots and (turn := self._next()) is not None:
            self._queue_of(turn).remove(turn)
            self._running.append(turn)
            turn.began = self._clock()
            if not self._is_urgent(turn):
                turn.was_deferred = self._has_urgent_besides(turn)
                self._urgent_s = 0.0
            self._count += 1
            for key in ((turn.owner.address,), (turn.owner.address, turn.owner.visitor)):
                self._served[key] = self._count
                self._served.move_to_end(key)
            while len(self._served) > _MAX_HISTORY:
                self._served.popitem(last=False)
            if turn.task is not None and not turn.granted_before:
                self._startable.append(turn)
            turn.granted_before = True
            if turn.request is not None:
                turn.request.set_result(None)

    def _next(self) -> Turn | None:
        """Return the next turn to grant: None if no job waits, or only deferred ones."""
        has_urgent = bool(self._urgent or self._brief) or any(map(self._is_urgent, self._running))
        if self._deferrable and (self._urgent_s >= DEFERRED_EVERY_S or not has_urgent):
            return self._fairest(self._deferrable.firsts())
        return self._fairest(self._grantable())

    def _fairest(self, firsts: list[Turn]) -> Turn | None:
        """Return the turn to grant next: of the ``firsts`` of owners, whose turns differ in their numbers only."""
        if len(firsts) <= 1:
            return firsts[0] if firsts else None
        addresses = Counter(turn.owner.address for turn in self._running)
        visitors = Counter(turn.owner for turn in self._running)

        def order(turn: Turn) -> tuple[int, int, int, int, int]:
            owner = turn.owner
            served = (self._served.get((owner.address,), 0), self._served.get((owner.address, owner.visitor), 0))
            return (addresses[owner.address], served[0], visitors[owner], served[1], turn.number)

        return min(firsts, key=order)


_current = threading.local()


def _leaves_cores() -> bool:
    scheduler: Scheduler | None = getattr(_current, "scheduler", None)
    turn: Turn | None = getattr(_current, "turn", None)
    return scheduler is not None and turn is not None and scheduler.leaves_cores(turn)


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
