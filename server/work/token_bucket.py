"""A token bucket: an initial number of tokens, refilled at a constant rate."""

from __future__ import annotations

import time
from collections.abc import Callable


class TokenBucket:
    """Holds at most ``burst`` tokens and gains ``per_s`` of them each second. Used from one thread."""

    def __init__(self, burst: float, per_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._burst, self._per_s, self._clock = burst, per_s, clock
        self._left, self._at = burst, clock()

    def _gained(self) -> float:
        return min(self._burst, self._left + (self._clock() - self._at) * self._per_s)

    def try_to_spend(self) -> bool:
        """Take one token if there is one; return whether there was."""
        if self._gained() < 1.0:
            return False
        self.spend()
        return True

    def spend(self) -> float:
        """Take one token, even a future one; return the seconds until it is available."""
        self._left = self._gained() - 1.0
        self._at = self._clock()
        return max(0.0, -self._left / self._per_s)

    @property
    def wait_s(self) -> float:
        """Seconds until a token taken now would be available."""
        return max(0.0, (1.0 - self._gained()) / self._per_s)

    @property
    def has_rested(self) -> bool:
        """Whether at least half of the burst was left after the last token was taken."""
        return self._left >= self._burst / 2.0
