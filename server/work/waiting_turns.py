"""Turns, and the order in which owners get those that wait: with hundreds of visitors few of them are looked at."""

from __future__ import annotations

import asyncio
import math
from bisect import bisect_left, insort
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Mapping
from collections.abc import Set as AbstractSet
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

RECENT_S = 5.0  #: time after which computing counts 1 / e of what it did
HEAVY_S = 1.0  #: recent computing of an address from which on much less of another address counts
LIGHTER = 0.5  #: recent computing of an address that is much less, as a share of the other's
_MAX_ADDRESSES = 1024

K = TypeVar("K", bound=Hashable)


@dataclass(frozen=True, slots=True)
class JobOwner:
    """The visitor for whom a job computes, and the visitor's address."""

    visitor: str
    address: str = ""


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
    task: Task | None = None  #: what :meth:`Scheduler.run` computes in it; None: whoever requested it computes

    @property
    def granted(self) -> Future[None]:
        """Done once the turn is held. A turn that was requested for a task has it after its first slice only."""
        if self.request is None:
            raise RuntimeError("nobody waits for this turn")
        return self.request


class _ServiceOrder(Generic[K]):
    """Keys that wait, the one served least recently first; of those never served, the one that has waited longest."""

    def __init__(self) -> None:
        self._order: list[tuple[int, int, K]] = []  #: when it was served, the number of the turn it waits for, the key
        self._places: dict[K, tuple[int, int, K]] = {}

    def __bool__(self) -> bool:
        return bool(self._order)

    def __contains__(self, key: K) -> bool:
        return key in self._places

    def place(self, key: K, served: int, number: int) -> None:
        """Add a key, or put it at another place. ``number`` is another one for each key."""
        self.remove(key)
        self._places[key] = place = (served, number, key)
        insort(self._order, place)

    def remove(self, key: K) -> None:
        """Remove a key, if it waits."""
        place = self._places.pop(key, None)
        if place is not None:
            del self._order[bisect_left(self._order, place)]

    def keys(self) -> list[K]:
        """Return the keys that wait (any thread)."""
        return list(self._places)

    def first(self, running: Mapping[K, int], without: AbstractSet[K] = frozenset()) -> K | None:
        """Return the first key of those with the fewest turns in ``running``; None if all that wait are in ``without``.

        At most as many others are looked at as there are in ``running`` and ``without``.
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
    """The waiting turns of each owner, the one that has waited longest first, and the order of the owners."""

    def __init__(self) -> None:
        self._queues: dict[JobOwner, deque[Turn]] = {}
        self._addresses: _ServiceOrder[str] = _ServiceOrder()
        self._owners: dict[str, _ServiceOrder[JobOwner]] = {}  #: of each address

    def __bool__(self) -> bool:
        return bool(self._queues)

    def __contains__(self, turn: Turn) -> bool:
        return turn in self._queues.get(turn.owner, ())

    def add(self, turn: Turn, served: tuple[int, int]) -> None:
        """Add a turn, which has waited for the shortest time.

        ``served`` are the numbers of the last turns that its address and its owner got, 0 if they never got one.
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
        """Remove a turn. Raises :class:`ValueError` if it does not wait."""
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
        """Note that a turn was granted to an owner, at its address, as the ``count``-th one of all."""
        if owner.address in self._addresses:
            self._addresses.place(owner.address, count, count)
        if owner in self._queues:
            self._owners[owner.address].place(owner, count, count)

    def first(
        self, addresses: Mapping[str, int], owners: Mapping[JobOwner, int], without: AbstractSet[str] = frozenset()
    ) -> Turn | None:
        """Return the next turn to grant, where addresses and owners hold so many turns.

        None if no turn waits but those of the addresses ``without``.
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
        self._heavy_until = -math.inf  #: from then on no address has computed :data:`HEAVY_S`

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
        """Return those of ``addresses`` that computed at least :data:`HEAVY_S`, and much more than another of them."""
        computed = {address: self.of(address, now) for address in addresses}
        least = max(HEAVY_S, min(computed.values(), default=0.0) / LIGHTER)
        return {address for address, seconds in computed.items() if seconds >= least}
