"""Fair scheduling of computations in time slices of :data:`SLICE_S`, by address and by visitor.

A job holds a turn while it computes. At its checkpoints it yields the turn if the turn has lasted a slice and other
jobs wait, and at once if its address holds at least two turns more than that of an urgent job that waits. The next turn
goes to the waiting address that holds the fewest turns, on a tie to the one served least recently; within an address
the same rules hold for its visitors. A visitor's jobs therefore share the visitor's part, and the visitors behind one
address share the part of the address.

A job is urgent while it is interactive (a user waits for it) and has computed for at most :data:`URGENT_S`. Other jobs
are deferred while an urgent one computes or waits: the threads of this process share the interpreter and the cores.
They still get one slice after each :data:`DEFERRED_EVERY_S` of urgent computing. Urgent jobs of an address that
computed much of late are deferred likewise while an urgent one of an address that computed much less computes or waits.

While several turns are held, only the address that has computed least of late may use more than one core for its turn:
a map that a user waits for is then made as when the user is alone, but for one core that is shared.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import TypeVar, cast

from mapper.core.parallel import share_cores
from server.work.waiting_turns import HEAVY_S, Finished, JobOwner, RecentComputing, Task, Turn, WaitingTurns

T = TypeVar("T")

SLICE_S = 0.05  #: length of a turn while others wait
URGENT_S = 0.4  #: computing time for which a job stays urgent
DEFERRED_EVERY_S = 0.2  #: urgent computing after which a deferred job gets a slice
_MAX_HISTORY = 1024  #: addresses and visitors whose last turn is recorded


def _uncancellable() -> Future[None]:
    """Return a future that cannot be cancelled: cancelling a waiting job removes its turn instead."""
    future: Future[None] = Future()
    future.set_running_or_notify_cancel()
    return future


class Scheduler:
    """Grants at most ``slots`` turns at a time. Thread-safe."""

    def __init__(self, slots: int, slice_s: float = SLICE_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._slots, self._slice_s, self._clock = slots, slice_s, clock
        self._lock = threading.Lock()
        self._urgent, self._deferrable = WaitingTurns(), WaitingTurns()  #: turns that wait
        self._running: list[Turn] = []
        self._served: OrderedDict[tuple[str, ...], int] = OrderedDict()  #: last turn of each address and visitor
        self._recent = RecentComputing()
        self._count = 0
        self._urgent_s = 0.0  #: urgent computing since the last slice of a job that is not urgent
        self._light_s = 0.0  #: urgent computing since the last slice of an address that computed HEAVY_S of late
        self._startable: list[Turn] = []  #: turns that were granted, and whose tasks have no thread yet
        #: Finished tasks that their event loop has not been told of: it is woken once for all of them.
        self._finished: dict[asyncio.AbstractEventLoop, list[Finished]] = {}

    # -- jobs ---------------------------------------------------------------------------------------------------------

    async def run(self, pool: Executor, owner: JobOwner, job: Callable[[], T], *, interactive: bool = True) -> T:
        """Compute ``job`` on a thread of ``pool`` once it has a turn; ``interactive`` says whether a user waits.

        The pool needs a thread for each job that has begun. A job cancelled before its first turn does not begin; one
        cancelled later runs to its end.
        """
        loop = asyncio.get_running_loop()
        task = Task(pool, job, loop, loop.create_future())
        turn = self.request(owner, interactive=interactive, task=task)
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

    def request(self, owner: JobOwner, *, interactive: bool = True, task: Task | None = None) -> Turn:
        """Return a new turn, which is held once its ``granted`` is done."""
        with self._lock:
            self._count += 1
            turn = Turn(owner, interactive, self._count, None if task else _uncancellable(), task=task)
            self._add(turn)
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
            return bool(self._urgent or self._deferrable)
        if self._is_deferred(turn):
            return not turn.was_deferred
        return bool(self._urgent) and len(self._running) > 1 and self._is_one_too_many(turn)

    def _is_one_too_many(self, turn: Turn) -> bool:
        """Whether an urgent turn waits of an address, or of a visitor at this address, that holds fewer turns by two.

        To wait for the end of a slice takes longer than many a map that a user waits for.
        """
        with self._lock:
            addresses, owners = self._held()
            own, here = turn.owner, turn.owner.address
            address = self._urgent.first_address(addresses)
            if address is not None and addresses.get(address, 0) + 2 <= addresses[here]:
                return True
            owner = self._urgent.first_owner(here, owners)
            return owner is not None and owners.get(owner, 0) + 2 <= owners[own]

    def _held(self) -> tuple[dict[str, int], dict[JobOwner, int]]:
        """Return how many turns each address and each owner holds."""
        addresses: dict[str, int] = {}
        owners: dict[JobOwner, int] = {}
        for one in self._running:
            addresses[one.owner.address] = addresses.get(one.owner.address, 0) + 1
            owners[one.owner] = owners.get(one.owner, 0) + 1
        return addresses, owners

    def leaves_cores(self, turn: Turn) -> bool:
        """Return whether a held turn should compute on its own thread only, and leave the other cores to others."""
        with self._lock:
            others = [one for one in self._running if one is not turn]
            if not others:
                return False
            now, address = self._clock(), turn.owner.address
            own = self._recent.of(address, now) + now - turn.began
            return any(
                other.owner.address == address or self._recent.of(other.owner.address, now) + now - other.began <= own
                for other in others
            )

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
        turn.request, turn.number = _uncancellable(), self._count
        self._add(turn)
        self._grant_free()

    def _add(self, turn: Turn) -> None:
        owner = turn.owner
        served = (self._served.get((owner.address,), 0), self._served.get((owner.address, owner.visitor), 0))
        self._queue_of(turn).add(turn, served)

    def _queue_of(self, turn: Turn) -> WaitingTurns:
        """Return the queue of a turn that does not run: its computing time grows only while it runs."""
        return self._urgent if self._is_urgent(turn) else self._deferrable

    def _is_deferred(self, turn: Turn) -> bool:
        """Return whether a turn that does not wait should wait while urgent jobs wait or run."""
        if not self._is_urgent(turn):
            return bool(self._urgent) or any(self._is_urgent(other) for other in self._running if other is not turn)
        return turn.owner.address in self._heavy()

    def _heavy(self) -> set[str]:
        """Return the addresses whose urgent turns are deferred: see :meth:`RecentComputing.much_more`."""
        if not self._recent.any_heavy(now := self._clock()):
            return set()
        running = (one.owner.address for one in self._running.copy() if self._is_urgent(one))
        return self._recent.much_more({*self._urgent.addresses(), *running}, now)

    def _is_urgent(self, turn: Turn) -> bool:
        running_s = self._clock() - turn.began if turn in self._running else 0.0
        return turn.interactive and turn.computed_s + running_s <= URGENT_S

    def _end_slice(self, turn: Turn) -> None:
        was_urgent = self._is_urgent(turn)
        lasted = (now := self._clock()) - turn.began
        self._running.remove(turn)
        turn.computed_s += lasted
        self._recent.add(turn.owner.address, lasted, now)
        if was_urgent:
            self._urgent_s += lasted
            self._light_s += lasted

    def _grant_free(self) -> None:
        """Grant free turns to waiting jobs that may run."""
        while len(self._running) < self._slots and (turn := self._next()) is not None:
            self._queue_of(turn).remove(turn)
            self._running.append(turn)
            turn.began = self._clock()
            turn.was_deferred = self._is_deferred(turn)
            if not self._is_urgent(turn):
                self._urgent_s = 0.0
            if self._recent.of(turn.owner.address, turn.began) >= HEAVY_S:
                self._light_s = 0.0
            self._count += 1
            for key in ((turn.owner.address,), (turn.owner.address, turn.owner.visitor)):
                self._served[key] = self._count
                self._served.move_to_end(key)
            while len(self._served) > _MAX_HISTORY:
                self._served.popitem(last=False)
            for waiting in (self._urgent, self._deferrable):
                waiting.note_served(turn.owner, self._count)
            if turn.task is not None and not turn.granted_before:
                self._startable.append(turn)
            turn.granted_before = True
            if turn.request is not None:
                turn.request.set_result(None)

    def _next(self) -> Turn | None:
        """Return the next turn to grant: None if no job waits, or only deferred ones."""
        if self._deferrable and (
            self._urgent_s >= DEFERRED_EVERY_S or not (self._urgent or any(map(self._is_urgent, self._running)))
        ):
            return self._deferrable.first(*self._held())
        if not self._urgent:
            return None
        is_their_turn = self._light_s >= DEFERRED_EVERY_S
        return self._urgent.first(*self._held(), without=set() if is_their_turn else self._heavy())


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
