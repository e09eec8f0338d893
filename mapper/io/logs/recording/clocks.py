"""The clocks of a recording: each sender stamps its messages by its own, and one recorder notes when each came."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray


class Clock:
    """Offset of one sender's stamps from the times at which its messages were recorded."""

    def __init__(self) -> None:
        self._ahead = array("q")

    def add(self, stamp_ns: int, recorded_ns: int) -> None:
        """Take one message's stamp and when it was recorded, 0 where that is not known."""
        if recorded_ns:
            self._ahead.append(stamp_ns - recorded_ns)

    def reset(self) -> None:
        """Let the stamps be the times at which the messages were recorded."""
        self._ahead = array("q", bytes(8 * len(self._ahead)))

    @property
    def ahead_ns(self) -> int | None:
        """By how much its stamps are ahead, usually; None where that is not known."""
        return int(np.median(np.frombuffer(self._ahead, dtype=np.int64))) if self._ahead else None

    def recorded(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Return when all messages, with these stamps (n,), were recorded, ns; None if it is not known."""
        return None if len(self._ahead) != len(stamps_ns) else stamps_ns - np.frombuffer(self._ahead, dtype=np.int64)

    def ahead_of(self, other: Clock) -> int:
        """Return by how many nanoseconds this clock is ahead of another; 0 where that is not known."""
        mine, theirs = self.ahead_ns, other.ahead_ns
        return 0 if mine is None or theirs is None else mine - theirs
