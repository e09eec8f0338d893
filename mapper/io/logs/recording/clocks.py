"""Clocks of a recording: each sender stamps its messages with its own clock, and the recorder notes their arrival."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

FAR_NS = 10_000_000_000_000_000  #: a third of a year: a clock this far from the recorder's belongs to a simulation
#: Usual offset from which a clock differs from the recorder's, for stamps ahead of it or behind. Nothing is recorded
#: before it is sent, although transforms are stamped ahead by up to about 2 s (transform_tolerance of AMCL); the delays
#: of a slow program vary.
AHEAD_NS, BEHIND_NS, SPREAD_NS = 1_000_000_000, 3_000_000_000, 200_000_000


def with_set_stamps(stamps_ns: NDArray[np.int64], recorded_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return the stamps (n,) of one sender, a few of which are 0, completed by its own clock; None if nothing changes.

    Stamps that are 0, as before a simulation's clock has arrived, are replaced by the recording times of the messages
    (n,), 0 if unknown. If the sender's other stamps are from another clock, they are extrapolated from the message
    nearest in the recording, at the rate of that clock, because a simulation may run slower or faster than real time.
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
    """Return the usual rate of a clock relative to the recorder's; 1 if unknown."""
    passed = np.diff(recorded_ns)
    rates = np.diff(stamps_ns)[passed > 0] / passed[passed > 0]
    return float(np.median(rates)) if len(rates) else 1.0


class Clock:
    """Offset of one sender's stamps from the recording times of its messages."""

    def __init__(self) -> None:
        self._ahead = array("q")

    def add(self, stamp_ns: int, recorded_ns: int) -> None:
        """Add one message's stamp and recording time, 0 if unknown."""
        if recorded_ns:
            self._ahead.append(stamp_ns - recorded_ns)

    def reset(self) -> None:
        """Use the recording times as the stamps."""
        self._ahead = array("q", bytes(8 * len(self._ahead)))

    def set_to(self, stamps_ns: NDArray[np.int64], recorded_ns: NDArray[np.int64]) -> None:
        """Replace all stamps by these (n,), of messages with these recording times (n,)."""
        self._ahead = array("q", (stamps_ns - recorded_ns).tolist())

    @property
    def ahead_ns(self) -> int | None:
        """Usual lead of its stamps; None if unknown."""
        return int(np.median(np.frombuffer(self._ahead, dtype=np.int64))) if self._ahead else None

    def recorded(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Return the recording times, ns, of all messages with these stamps (n,); None if unknown."""
        return None if len(self._ahead) != len(stamps_ns) else stamps_ns - np.frombuffer(self._ahead, dtype=np.int64)

    @property
    def is_own(self) -> bool:
        """Whether it differs from the recorder's clock: its stamps are ahead or behind by a constant amount."""
        if not self._ahead:
            return False
        least, usual, most = np.quantile(np.frombuffer(self._ahead, dtype=np.int64), (0.1, 0.5, 0.9))
        return bool(most - least < SPREAD_NS and not -BEHIND_NS <= usual <= AHEAD_NS)

    def ahead_of(self, other: Clock) -> int:
        """Return by how many nanoseconds this clock is ahead of another; 0 if unknown."""
        mine, theirs = self.ahead_ns, other.ahead_ns
        return 0 if mine is None or theirs is None else mine - theirs
