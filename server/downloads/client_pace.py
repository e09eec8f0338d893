"""How slow the client of a download may be: no piece may take too long, nor all of them together."""

from __future__ import annotations

STALLED_S = 30.0  #: within which a client must accept a piece
LEAST_BYTES_PER_S = 32 << 10  #: mean over the whole download


class ClientPace:
    """What the client of one download has accepted, and the time that this took.

    Only the time of sending counts, not that in which the file is made. A client may be ``STALLED_S`` behind the least
    mean rate, as one that is disconnected for a moment, or whose network stores much before it sends it on.
    """

    def __init__(self) -> None:
        self._bytes, self._seconds = 0, 0.0

    @property
    def seconds_left(self) -> float:
        """Return the time in which the client must accept the next piece."""
        allowed = STALLED_S + self._bytes / LEAST_BYTES_PER_S
        return min(STALLED_S, max(0.0, allowed - self._seconds))

    @property
    def told(self) -> dict[str, float]:
        """Return what a log tells of it."""
        return {"bytes": self._bytes, "seconds": round(self._seconds, 1)}

    def accept(self, nbytes: int, seconds: float) -> None:
        """Note that the client has accepted a piece in this time."""
        self._bytes += nbytes
        self._seconds += seconds
