"""A brake on guesses: who has given many wrong secrets is refused for a while.

The wrong secrets of a network are counted together (an IPv6 address counts as its /64 network) and forgotten at an even
rate. Whoever proves a right secret by a cookie is not concerned. Codes of classes have two, :class:`CodeGuesses`.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable

from server.network_address import network_of

MAX_NETWORKS = 4096  #: of which wrong secrets are recorded


class Brake:
    """Allows ``burst`` wrong secrets of a network at once, and one more each ``60 / per_minute`` seconds."""

    def __init__(self, burst: int, per_minute: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._burst, self._per_s, self._clock = burst, per_minute / 60.0, clock
        self._wrong: OrderedDict[str, tuple[float, float]] = OrderedDict()  #: number and time, oldest first

    def wait_s(self, address: str) -> float:
        """Return the seconds for which a network is refused; 0 if it is not."""
        return max(0.0, (self._count(network_of(address)) - self._burst + 1.0) / self._per_s)

    def count(self, address: str) -> None:
        """Count a wrong secret."""
        network = network_of(address)
        self._wrong[network] = (self._count(network) + 1.0, self._clock())
        self._wrong.move_to_end(network)
        while len(self._wrong) > MAX_NETWORKS:
            self._wrong.popitem(last=False)

    def _count(self, network: str) -> float:
        number, at = self._wrong.get(network, (0.0, 0.0))
        return max(0.0, number - (self._clock() - at) * self._per_s)


class CodeGuesses:
    """Wrong codes of classes: few of one visitor, and many of one network.

    All of a lecture hall have one address, and some of them mistype: one who guesses is refused long before the hall
    is. A visitor is known by a cookie and can drop it: what bounds guessing is the limit of the network.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._of_visitor = Brake(burst=12, per_minute=12.0, clock=clock)
        self._of_network = Brake(burst=300, per_minute=55.0, clock=clock)

    def wait_s(self, visitor: str, address: str) -> float:
        """Return the seconds for which a visitor's codes are refused, right ones too; 0 if they are not."""
        return max(self._of_visitor.wait_s(visitor), self._of_network.wait_s(address))

    def count(self, visitor: str, address: str) -> None:
        """Count a wrong code."""
        self._of_visitor.count(visitor)
        self._of_network.count(address)
