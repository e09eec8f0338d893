"""A brake on guesses: who has given many wrong secrets is refused for a while.

The wrong secrets of a network are counted together (an IPv6 address counts as its /64 network) and forgotten at an even
rate. Whoever proves a right secret by a cookie is not concerned.
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
