"""The timeline of a session that shows a 3D map: which of its scans the map should contain."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from server.sessions.view import Playback

FILL_S = 20.0  #: initial duration of playback


class ScanTimeline:
    """``target`` is the number of scans that the map should contain, set by playback or by a command.

    ``times`` (n,) are the times of the scans, seconds after the first.
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
        """Return a playback with a duration of about :data:`FILL_S`, if there are several scans."""
        speeds = (0.1, max(100.0, self.duration / 5.0))
        return Playback(self.count > 1, float(np.clip(float(f"{self.duration / FILL_S:.2g}"), *speeds)), speeds)

    def stamp(self, index: int) -> float:
        """Return the time of the newest of the first ``index`` scans, seconds."""
        return float(self.times[max(index - 1, 0)])

    def go_to(self, index: int) -> None:
        """Request a map of this number of scans, clamped to the available ones."""
        self.target = min(max(index, 0), self.count)
        self._time = self.stamp(self.target) if self.target else 0.0

    def play(self, seconds: float) -> None:
        """Advance the time. Scans up to then should be in the map."""
        self._time = min(self._time + seconds, self.duration)
        self.target = max(self.target, int(np.searchsorted(self.times, self._time, side="right")))
