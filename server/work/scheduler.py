"""Fair scheduling of computations in time slices of :data:`SLICE_S`, by address and by visitor.

A job holds a turn while it computes. At its checkpoints it yields the turn if the turn has lasted a slice and other
jobs wait, and immediately if its address holds at least two turns more than that of a waiting urgent job. The next turn
goes to the waiting address that holds the fewest turns, on a tie to the one served least recently. Within an address
the same rules apply to its visitors. A visitor's jobs therefore share the visitor's part, and the visitors behind one
address share the part of the address.

A job is urgent while it is interactive (a user waits for it) and has computed for at most :data:`URGENT_S`. Other jobs
are deferred while an urgent one computes or waits, because the threads of this process share the interpreter and the
cores. They still get one slice after each :data:`DEFERRED_EVERY_S` of urgent computing. Urgent jobs of an address that
computed much recently are also deferred while an urgent job of an address that computed much less computes or waits.

While several turns are held, only the address that has computed least recently may use more than one core for its turn.
A map that a user waits for is then computed as if the user were alone, except that one core is shared.
"""

from __future__ import annotations

import asyncio
import math
import threading
import time
from bisect import bisect_left, insort
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Mapping
from collections.abc import Set as AbstractSet
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from mapper.core.parallel import share_cores

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)

SLICE_S = 0.05  #: length of a turn while others wait
URGENT_S = 0.4  #: computing time for which a job stays urgent
DEFERRED_EVERY_S = 0.2  #: urgent computing after which a deferred job gets a slice
_MAX_HISTORY = 1024  #: addresses and visitors whose last turn is recorded
RECENT_S = 5.0  #: time after which computing counts by a factor of 1 / e
HEAVY_S = 1.0  #: recent computing of an address above which much less of another address matters
LIGHTER = 0.5  #: share of the other address's recent computing that counts as much less
_MAX_ADDRESSES = 1024


@dataclass(frozen=True, slots=True)
class JobOwner:
    """The visitor for whom a job computes, and the visitor's address."""

    visitor: str
    address: str = ""


@dataclass(slots=True, eq=False)
class Task:
    """Computation of a turn on a thread of ``pool``, and the future of ``loop`` for its result."""

    pool: Executor
    job: Callable[[], Any]
    loop: asyncio.AbstractEventLoop
    done: asyncio.Future[Any]

    def compute(self) -> Finished:
        """Run the job. An error is part of the result."""
        try:
            return Finished(self.done, self.job(), None)
        except BaseException as error:  # noqa: BLE001 - whoever waits for the job gets it
            return Finished(self.done, None, error)


@dataclass(frozen=True, slots=True)
class Finished:
    """Result of a job, or the error that it raised, for the future of its caller."""

    done: asyncio.Future[Any]
    result: Any
    error: BaseException | None

    def tell(self) -> None:
        """Set the future (event loop), unless it was cancelled."""
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
    request: Future[None] | None = None  #: done when the turn is granted; None if nothing waits for it
    began: float = 0.0  #: start of the slice
    computed_s: float = 0.0
    was_deferred: bool = False  #: whether the slice was granted while urgent jobs waited or ran
    granted_before: bool = False  #: whether it was granted a slice before
    task: Task | None = None  #: what :meth:`Scheduler.run` computes in it; None: its requester computes

    @property
    def granted(self) -> Future[None]:
        """Done once the turn is held. A turn requested for a task has this only after its first slice."""
        if self.request is None:
            raise RuntimeError("nobody waits for this turn")
        return self.request


class _ServiceOrder(Generic[K]):
    """Waiting keys, the one served least recently first; of those never served, the one that has waited longest."""

    def __init__(self) -> None:
        self._order: list[tuple[int, int, K]] = []  #: when it was served, the number of its waiting turn, the key
        self._places: dict[K, tuple[int, int, K]] = {}

    def __bool__(self) -> bool:
        return bool(self._order)

    def __contains__(self, key: K) -> bool:
        return key in self._places

    def place(self, key: K, served: int, number: int) -> None:
        """Add a key, or move it. ``number`` is different for each key."""
        self.remove(key)
        self._places[key] = place = (served, number, key)
        insort(self._order, place)

    def remove(self, key: K) -> None:
        """Remove a key, if it waits."""
        place = self._places.pop(key, None)
        if place is not None:
            del self._order[bisect_left(self._order, place)]

    def keys(self) -> list[K]:
        """Return the waiting keys (any thread)."""
        return list(self._places)

    def first(self, running: Mapping[K, int], without: AbstractSet[K] = frozenset()) -> K | None:
        """Return the first key of those with the fewest turns in ``running``; None if all are in ``without``.

        It examines at most as many other keys as there are in ``running`` and ``without``.
        """
        best: K | None = None
        for _, _, key in self._order:
            if key in without:
                continue
            if not running.get(key):
                return key
            if best is None or running[key] < running[best]:
                best = key
        return best


class WaitingTurns:
    """The waiting turns of each owner, the longest-waiting one first, and the order of the owners."""

    def __init__(self) -> None:
        self._queues: dict[JobOwner, deque[Turn]] = {}
        self._addresses: _ServiceOrder[str] = _ServiceOrder()
        self._owners: dict[str, _ServiceOrder[JobOwner]] = {}  #: by address

    def __bool__(self) -> bool:
        return bool(self._queues)

    def __contains__(self, turn: Turn) -> bool:
        return turn in self._queues.get(turn.owner, ())

    def add(self, turn: Turn, served: tuple[int, int]) -> None:
        """Add a turn as the most recent one.

        ``served`` are the numbers of the last turns of its address and its owner, 0 if they had none.
        """
        owner = turn.owner
        queue = self._queues.get(owner)
        if queue is not None:
            queue.append(turn)
            return
        self._queues[owner] = deque((turn,))
        if owner.address not in self._addresses:
            self._owners[owner.address] = _ServiceOrder()
            self._addresses.place(owner.address, served[0], turn.number)
        self._owners[owner.address].place(owner, served[1], turn.number)

    def remove(self, turn: Turn) -> None:
        """Remove a turn. Raises :class:`ValueError` if it is not waiting."""
        owner = turn.owner
        queue = self._queues.get(owner, deque())
        queue.remove(turn)
        if queue:
            return
        del self._queues[owner]
        owners = self._owners[owner.address]
        owners.remove(owner)
        if not owners:
            del self._owners[owner.address]
            self._addresses.remove(owner.address)

    def note_served(self, owner: JobOwner, count: int) -> None:
        """Record that the ``count``-th turn was granted to an owner at its address."""
        if owner.address in self._addresses:
            self._addresses.place(owner.address, count, count)
        if owner in self._queues:
            self._owners[owner.address].place(owner, count, count)

    def first(
        self, addresses: Mapping[str, int], owners: Mapping[JobOwner, int], without: AbstractSet[str] = frozenset()
    ) -> Turn | None:
        """Return the next turn to grant, given the turns that addresses and owners hold.

        Returns None if only turns of the addresses ``without`` wait.
        """
        address = self.first_address(addresses, without)
        owner = None if address is None else self.first_owner(address, owners)
        return None if owner is None else self._queues[owner][0]

    def first_address(self, running: Mapping[str, int], without: AbstractSet[str] = frozenset()) -> str | None:
        """Return the waiting address with the fewest running turns that was served least recently."""
        return self._addresses.first(running, without)

    def first_owner(self, address: str, running: Mapping[JobOwner, int]) -> JobOwner | None:
        """Return the waiting owner at an address with the fewest running turns who was served least recently."""
        owners = self._owners.get(address)
        return None if owners is None else owners.first(running)

    def addresses(self) -> list[str]:
        """Return the addresses of the turns (any thread)."""
        return self._addresses.keys()


class RecentComputing:
    """Seconds of computing of each address, weighted with exp(-age / :data:`RECENT_S`). Not thread-safe."""

    def __init__(self) -> None:
        self._computed: OrderedDict[str, tuple[float, float]] = OrderedDict()  #: seconds, and when they were added
        self._heavy_until = -math.inf  #: no address has computed :data:`HEAVY_S` from then on

    def add(self, address: str, seconds: float, now: float) -> None:
        """Add computing that ended at ``now``."""
        total = self.of(address, now) + seconds
        self._computed[address] = (total, now)
        self._computed.move_to_end(address)
        if len(self._computed) > _MAX_ADDRESSES:
            self._computed.popitem(last=False)
        if total > HEAVY_S:
            self._heavy_until = max(self._heavy_until, now + RECENT_S * math.log(total / HEAVY_S))

    def of(self, address: str, now: float) -> float:
        """Return the weighted seconds of an address."""
        seconds, at = self._computed.get(address, (0.0, now))
        return seconds * math.exp((at - now) / RECENT_S)

    def any_heavy(self, now: float) -> bool:
        """Return whether an address computed at least :data:`HEAVY_S`."""
        return now < self._heavy_until

    def much_more(self, addresses: set[str], now: float) -> set[str]:
        """Return those of ``addresses`` that computed at least :data:`HEAVY_S`, and much more than another one."""
        computed = {address: self.of(address, now) for address in addresses}
        least = max(HEAVY_S, min(computed.values(), default=0.0) / LIGHTER)
        return {address for address, seconds in computed.items() if seconds >= least}


def _uncancellable() -> Future[None]:
    """Return a future that cannot be cancelled, because cancelling a waiting job removes its turn instead."""
    future: Future[None] = Future()
    future.set_running_or_notify_cancel()
    return future


class Scheduler:
    """Grants at most ``slots`` turns at a time. Thread-safe."""

    def __init__(self, slots: int, slice_s: float = SLICE_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._slots, self._slice_s, self._clock = slots, slice_s, clock
        self._lock = threading.Lock()
        self._urgent, self._deferrable = WaitingTurns(), WaitingTurns()  #: waiting turns
        self._running: list[Turn] = []
        self._served: OrderedDict[tuple[str, ...], int] = OrderedDict()  #: last turn of each address and visitor
        self._recent = RecentComputing()
        self._count = 0
        self._urgent_s = 0.0  #: urgent computing since the last slice of a non-urgent job
        self._light_s = 0.0  #: urgent computing since the last slice of an address that computed HEAVY_S recently
        self._startable: list[Turn] = []  #: granted turns whose tasks have no thread yet
        #: Finished tasks that were not reported to their event loop yet, which is woken once for all of them.
        self._finished: dict[asyncio.AbstractEventLoop, list[Finished]] = {}

    # -- jobs ---------------------------------------------------------------------------------------------------------

    async def run(self, pool: Executor, owner: JobOwner, job: Callable[[], T], *, interactive: bool = True) -> T:
        """Compute ``job`` on a thread of ``pool`` once it has a turn; ``interactive`` says whether a user waits.

        The pool needs a thread for each started job. A job cancelled before its first turn is not started; one
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
        """Compute a turn's task, then those of the turns granted next, on this thread of their pool."""
        share_cores(_leaves_cores)
        if turn not in self._running:  # the pool had no thread for it, and it was withdrawn
            return
        following: Turn | None = turn
        while following is not None and (task := following.task) is not None:
            _current.scheduler, _current.turn = self, following
            finished = task.compute()
            _current.scheduler = _current.turn = None
            with self._lock:
                self._end_slice(following)
                self._grant_free()
                following = next(
                    (turn_ for turn_ in self._startable if turn_.task and turn_.task.pool is task.pool), None
                )
                if following is not None:
                    self._startable.remove(following)
            self._tell(task.loop, finished)
            self._start()

    def _start(self) -> None:
        """Start the tasks of granted turns on threads of their pools."""
        while self._startable:
            with self._lock:
                turn = self._startable.pop(0) if self._startable else None
            if turn is None or turn.task is None:
                return
            try:
                turn.task.pool.submit(self._work, turn)
            except RuntimeError as error:  # the pool accepts no more jobs
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
            except RuntimeError:  # the loop is closed, so nothing waits any more
                self._finished.pop(loop, None)

    def _tell_all(self, loop: asyncio.AbstractEventLoop) -> None:
        with self._lock:
            finished = self._finished.pop(loop, [])
        for task in finished:
            task.tell()

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
        """Return whether an urgent turn waits whose address, or visitor at this address, holds at least two turns less.

        Waiting for the end of a slice would take longer than computing many of the maps that users wait for.
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
        """Return the numbers of turns that each address and each owner holds."""
        addresses: dict[str, int] = {}
        owners: dict[JobOwner, int] = {}
        for turn_ in self._running:
            addresses[turn_.owner.address] = addresses.get(turn_.owner.address, 0) + 1
            owners[turn_.owner] = owners.get(turn_.owner, 0) + 1
        return addresses, owners

    def leaves_cores(self, turn: Turn) -> bool:
        """Return whether a held turn should compute only on its own thread, and leave the other cores to others."""
        with self._lock:
            others = [turn_ for turn_ in self._running if turn_ is not turn]
            if not others:
                return False
            now, address = self._clock(), turn.owner.address
            own = self._recent.of(address, now) + now - turn.began
            return any(
                other.owner.address == address or self._recent.of(other.owner.address, now) + now - other.began <= own
                for other in others
            )

    def yield_turn(self, turn: Turn) -> None:
        """Yield a held turn to the next job, and request another one, which may be granted immediately."""
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
        """Request another turn after :meth:`suspend`. It may be granted immediately."""
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
        """Return the queue of a turn that does not run; its computing time grows only while it runs."""
        return self._urgent if self._is_urgent(turn) else self._deferrable

    def _is_deferred(self, turn: Turn) -> bool:
        """Return whether a turn that does not wait should wait while urgent jobs wait or run."""
        if not self._is_urgent(turn):
            return bool(self._urgent) or any(self._is_urgent(other) for other in self._running if other is not turn)
        return turn.owner.address in self._heavy()

    def _heavy(self) -> set[str]:
        """Return the addresses whose urgent turns are deferred; see :meth:`RecentComputing.much_more`."""
        if not self._recent.any_heavy(now := self._clock()):
            return set()
        running = (turn_.owner.address for turn_ in self._running.copy() if self._is_urgent(turn_))
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
        """Return the next turn to grant; None if no job waits, or only deferred ones."""
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
    """Yield this thread's turn, wait for ``until``, at most ``timeout_s``, and return with another turn."""
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

    Jobs call it about every hundredth of a second. Outside a scheduled job it does nothing.
    """
    scheduler: Scheduler | None = getattr(_current, "scheduler", None)
    turn: Turn | None = getattr(_current, "turn", None)
    if scheduler is not None and turn is not None and scheduler.should_yield(turn):
        scheduler.yield_turn(turn)
        turn.granted.result()
