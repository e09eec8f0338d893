"""The scans of one sensor in a recording, as they come, put on the beams that most of them have."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.io.logs.clocks import Clock
from mapper.io.logs.ros_messages import Beams
from mapper.io.logs.stream import Stream
from mapper.io.logs.timeline import Moments
from mapper.sensors.scan import MAX_STATED_S

Beaming = tuple[float, float, float, float, int]  #: angle_min, angle_increment, range_min, range_max, beams


class SensorScans:
    """The scans of the sensor ``topic``, of messages of one ``stream``, in ``frame``."""

    def __init__(self, topic: str, stream: Stream, frame: str, beam_width: float) -> None:
        self.topic = topic
        self.stream = stream
        self.frame = frame
        self.beam_width = max(0.0, beam_width)
        self.stamps = array("q")
        self.positions = array("q")  #: the number of each scan's message in the recording
        self.offsets: NDArray[np.int64] | None = None  #: what counts the stamps on where the clock began again
        self.clock = Clock()
        self._numbers: dict[Beaming, int] = {}
        self._of_scan = array("q")  #: the number of each scan's geometry
        self._ranges = bytearray()
        self._time_increments = array("f")
        self._scan_times = array("f")
        self._mounts = array("d")

    def add(self, stamp_ns: int, beams: Beams) -> None:
        """Take one scan."""
        geometry = (
            float(beams.angle_min),
            float(beams.angle_increment),
            float(beams.range_min),
            float(beams.range_max),
            len(beams.ranges),
        )
        self.stamps.append(stamp_ns)
        self._of_scan.append(self._numbers.setdefault(geometry, len(self._numbers)))
        self._ranges += beams.ranges.tobytes()
        self._time_increments.append(beams.time_increment)
        self._scan_times.append(beams.scan_time)
        self._mounts.extend(beams.mount or ())

    @property
    def kind(self) -> str:
        """The type of its messages."""
        return self.stream.kind

    @property
    def time_increment(self) -> float:
        """Median of the stated times between two beams, seconds; 0 where none is stated."""
        return _median_seconds(self._time_increments)

    @property
    def scan_time(self) -> float:
        """Median of the stated times between two scans, seconds; 0 where none is stated."""
        return _median_seconds(self._scan_times)

    @property
    def mounts(self) -> NDArray[np.float64]:
        """``T_base_scan`` (n_scans, 3) of scans that were cut out of clouds; of others there is none, (0, 3)."""
        return np.array(self._mounts).reshape(-1, 3)

    @property
    def moments(self) -> Moments:
        """When the scans were made, counted on where the clock began again."""
        stamps = np.frombuffer(self.stamps, dtype=np.int64)
        counted = stamps if self.offsets is None else stamps + self.offsets
        return Moments(counted, np.frombuffer(self.positions, dtype=np.int64))

    @property
    def n_scans(self) -> int:
        """Scans taken so far."""
        return len(self.stamps)

    @property
    def usual(self) -> Beaming:
        """The beams that most scans have."""
        counts = np.bincount(np.frombuffer(self._of_scan, dtype=np.int64))
        return list(self._numbers)[int(np.argmax(counts))]

    def packed(self, limits: Limits) -> tuple[NDArray[np.float32], list[str]]:
        """Return the readings (n_scans, n_beams) on the usual beams, and what is to be noted about them.

        Raises :class:`LimitError` where they would be too many.
        """
        angle_min, increment, _, _, n = self.usual
        flat = np.frombuffer(self._ranges, dtype=np.float32)
        if len(self._numbers) == 1:
            return flat.reshape(-1, n), []
        if self.n_scans * n > limits.max_readings:
            raise LimitError(
                "log.too_many_scans",
                f"{self.n_scans} scans of {n} beams on {self.topic} are more than {limits.max_readings} readings.",
            )
        out = np.full((self.n_scans, n), np.nan, dtype=np.float32)
        at = 0
        others = 0
        places: dict[Beaming, tuple[NDArray[np.intp], NDArray[np.intp]]] = {}
        geometries = list(self._numbers)
        for row, number in enumerate(self._of_scan):
            geometry = geometries[number]
            readings = flat[at : at + geometry[4]]
            at += geometry[4]
            if geometry[0] == angle_min and geometry[1] == increment:
                same = min(n, len(readings))
                out[row, :same] = readings[:same]
            else:
                if geometry not in places and len(places) < 100:
                    places[geometry] = _nearest(geometry, self.usual)
                to, taken = places[geometry] if geometry in places else _nearest(geometry, self.usual)
                out[row, to] = readings[taken]
            others += geometry != self.usual
        note = (
            f"{others} of the {self.n_scans} scans on {self.topic} have other beams or range limits than the rest; "
            "their readings count at the nearest of the usual beams."
        )
        return out, [note]


def _median_seconds(stated: array[float]) -> float:
    """Return the median of the stated times that are finite and not absurd, else 0."""
    seconds = np.frombuffer(stated, dtype=np.float32)
    good = seconds[np.abs(seconds) <= MAX_STATED_S]  # false for NaN
    return float(np.median(good)) if len(good) else 0.0


def _nearest(theirs: Beaming, usual: Beaming) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of the usual beams have one of theirs within half a step, and which one that is."""
    angles = usual[0] + usual[1] * np.arange(usual[4])
    if theirs[4] == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    if theirs[1] == 0.0:
        index = np.zeros(usual[4])
    else:
        index = np.clip(np.rint((angles - theirs[0]) / theirs[1]), 0, theirs[4] - 1)
    near = np.abs(theirs[0] + theirs[1] * index - angles) <= max(abs(usual[1]), abs(theirs[1])) / 2.0 + 1e-9
    return np.nonzero(near)[0], index[near].astype(np.intp)
