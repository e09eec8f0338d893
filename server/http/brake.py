"""A brake on guessing: a client with many wrong secrets is refused for a while.

The wrong secrets of a network are counted together (an IPv6 address counts as its /64 network), and the count decreases
at a constant rate. Clients that prove a right secret by a cookie are not affected. Class codes have two brakes,
:class:`CodeGuesses`.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Protocol

from server.network_address import network_of
from server.workers.shared import MAX_NETWORKS


class Counts(Protocol):
    """Numbers by key, each with the time at which it was set."""

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and its time; 0 and 0 if there is none."""

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key."""


class OwnCounts:
    """The newest ``size`` numbers, for one process."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._entries: OrderedDict[str, tuple[float, float]] = OrderedDict()  #: oldest first

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and its time; 0 and 0 if there is none."""
        return self._entries.get(key, (0.0, 0.0))

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key."""
        self._entries[key] = (number, at)
        self._entries.move_to_end(key)
        while len(self._entries) > self._size:
            self._entries.popitem(last=False)


class Brake:
    """Allows ``burst`` wrong secrets of a network at once, and one more each ``60 / per_minute`` seconds.

    ``counts`` are shared by all processes of the service; None if there is only one.
    """

    def __init__(
        self,
        burst: int,
        per_minute: float,
        clock: Callable[[], float] = time.monotonic,
        counts: Counts | None = None,
    ) -> None:
        self._burst, self._per_s, self._clock = burst, per_minute / 60.0, clock
        self._wrong: Counts = OwnCounts(MAX_NETWORKS) if counts is None else counts

    def wait_s(self, address: str) -> float:
        """Return the seconds for which a network is refused; 0 if it is not."""
        return max(0.0, (self._count(network_of(address)) - self._burst + 1.0) / self._per_s)

    def count(self, address: str) -> None:
        """Count a wrong secret."""
        network = network_of(address)
        self._wrong.set(network, self._count(network) + 1.0, self._clock())

    def _count(self, network: str) -> float:
        number, at = self._wrong.get(network)
        return max(0.0, number - (self._clock() - at) * self._per_s)


class CodeGuesses:
    """Wrong codes of classes: few for one visitor, and many for one network.

    A lecture hall shares one address, and some people mistype. A guessing visitor is refused long before the hall is. A
    visitor is identified by a cookie and can drop it, so the limit of the network is what bounds guessing.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        of_visitor: Counts | None = None,
        of_network: Counts | None = None,
    ) -> None:
        """Count for this process, or for all processes that share ``of_visitor`` and ``of_network``."""
        self._of_visitor = Brake(burst=12, per_minute=12.0, clock=clock, counts=of_visitor)
        self._of_network = Brake(burst=300, per_minute=55.0, clock=clock, counts=of_network)

    def wait_s(self, visitor: str, address: str) -> float:
        """Return the seconds for which a visitor's codes, even right ones, are refused; 0 if they are not."""
        return max(self._of_visitor.wait_s(visitor), self._of_network.wait_s(address))

    def count(self, visitor: str, address: str) -> None:
        """Count a wrong code."""
        self._of_visitor.count(visitor)
        self._of_network.count(address)
