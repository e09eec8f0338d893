"""How long each address has computed of late."""

from __future__ import annotations

import math
from collections import OrderedDict

RECENT_S = 5.0  #: time after which computing counts 1 / e of what it did
HEAVY_S = 1.0  #: recent computing of an address from which on much less of another address counts
LIGHTER = 0.5  #: recent computing of an address that is much less, as a share of the other's
_MAX_ADDRESSES = 1024


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
