"""The time of a session that shows a map in 3D: which of its scans the map should have."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from server.sessions.view import Playback

FILL_S = 20.0  #: in which a sequence plays at first


class ScanTimeline:
    """``target`` is the number of scans that the map should have: by the time while it plays, or by a command.

    ``times`` (n,) are those of the scans, seconds after the first.
    """

    def __init__(self, times: Float64Array, count: int) -> None:
        self.times, self.count = times, count
        self.target = count if count == 1 else 0
        self._time = 0.0

    @property
    def duration(self) -> float:
        """The time of the last scan, seconds."""
        return float(self.times[-1])

    def first_playback(self) -> Playback:
        """Return a playback that plays the scans in about :data:`FILL_S`, if there are several."""
        speeds = (0.1, max(100.0, self.duration / 5.0))
        return Playback(self.count > 1, float(np.clip(float(f"{self.duration / FILL_S:.2g}"), *speeds)), speeds)

    def stamp(self, index: int) -> float:
        """Return the time of the newest of the first ``index`` scans, seconds."""
        return float(self.times[max(index - 1, 0)])

    def go_to(self, index: int) -> None:
        """Have the map brought to a number of scans, at least none and at most all."""
        self.target = min(max(index, 0), self.count)
        self._time = self.stamp(self.target) if self.target else 0.0

    def play(self, seconds: float) -> None:
        """Advance the time: scans that have been taken by then should be in the map."""
        self._time = min(self._time + seconds, self.duration)
        self.target = max(self.target, int(np.searchsorted(self.times, self._time, side="right")))
