"""The clocks of a recording: each sender stamps its messages by its own, and one recorder notes when each came."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

FAR_NS = 10_000_000_000_000_000  #: a third of a year: a clock so far from the recorder's is a simulation's
#: A clock is not the recorder's where its stamps are usually so far ahead of that, or behind. Nothing is recorded
#: before it is made, although transforms are stamped ahead by up to some 2 s (transform_tolerance of AMCL); what a
#: slow program makes is late by different times.
AHEAD_NS, BEHIND_NS, SPREAD_NS = 1_000_000_000, 3_000_000_000, 200_000_000


def with_set_stamps(stamps_ns: NDArray[np.int64], recorded_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return the stamps (n,) of one sender, a few of which are 0, by its own clock; None where there is nothing to do.

    Stamps that are 0, as before a simulation's clock has come, are the times at which the messages were recorded here
    (n,), 0 where that is not known. Where the sender's other stamps are of another clock, theirs are counted from that
    of the message nearest in the recording, at the rate of that clock: a simulation is slower than the time, or faster.
    """
    ahead = stamps_ns - recorded_ns
    unset = (ahead == 0) & (recorded_ns != 0)
    n = int(np.count_nonzero(unset))
    if not n or 2 * n > len(stamps_ns):
        return None
    known, places = np.flatnonzero(~unset), np.arange(len(stamps_ns))
    after = np.minimum(np.searchsorted(known, places), len(known) - 1)
    before = np.maximum(after - 1, 0)
    is_before = np.abs(known[before] - places) < np.abs(known[after] - places)
    nearest = known[np.where(is_before, before, after)]
    if np.abs(ahead[nearest][unset]).min() < FAR_NS:
        return None
    since = _rate(stamps_ns[known], recorded_ns[known]) * (recorded_ns - recorded_ns[nearest])
    return np.where(unset, stamps_ns[nearest] + np.rint(since).astype(np.int64), stamps_ns)


def _rate(stamps_ns: NDArray[np.int64], recorded_ns: NDArray[np.int64]) -> float:
    """Return how many seconds a clock usually goes on in one of the recorder's; 1 where that is not known."""
    passed = np.diff(recorded_ns)
    rates = np.diff(stamps_ns)[passed > 0] / passed[passed > 0]
    return float(np.median(rates)) if len(rates) else 1.0


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

    def set_to(self, stamps_ns: NDArray[np.int64], recorded_ns: NDArray[np.int64]) -> None:
        """Take stamps (n,) in place of all before, of messages that were recorded at these times (n,)."""
        self._ahead = array("q", (stamps_ns - recorded_ns).tolist())

    @property
    def ahead_ns(self) -> int | None:
        """By how much its stamps are ahead, usually; None where that is not known."""
        return int(np.median(np.frombuffer(self._ahead, dtype=np.int64))) if self._ahead else None

    def recorded(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Return when all messages, with these stamps (n,), were recorded, ns; None if it is not known."""
        return None if len(self._ahead) != len(stamps_ns) else stamps_ns - np.frombuffer(self._ahead, dtype=np.int64)

    @property
    def is_own(self) -> bool:
        """Whether it is another clock than the recorder's, of which its stamps are always as far ahead or behind."""
        if not self._ahead:
            return False
        least, usual, most = np.quantile(np.frombuffer(self._ahead, dtype=np.int64), (0.1, 0.5, 0.9))
        return bool(most - least < SPREAD_NS and not -BEHIND_NS <= usual <= AHEAD_NS)

    def ahead_of(self, other: Clock) -> int:
        """Return by how many nanoseconds this clock is ahead of another; 0 where that is not known."""
        mine, theirs = self.ahead_ns, other.ahead_ns
        return 0 if mine is None or theirs is None else mine - theirs
