"""The scans of one sensor in a recording, as they come; each keeps the beams and the limits that it states."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from mapper.io.logs.grouping.stated_scans import Beaming, StatedScans, median_seconds
from mapper.io.logs.recording.clocks import Clock
from mapper.io.logs.recording.stream import Stream
from mapper.io.logs.recording.timeline import Moments
from mapper.io.logs.ros.ros_messages import Beams
from mapper.sensors.planar.options import is_cut

LEAST_APART_NS = 1_000_000  #: mean interval of the recorded times, from which they count as times of scans
LEAST_ALIKE = 3  #: scans of one stamp that are a fault of their driver


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
        self._of_scan = array("q")  #: the number of each scan's beaming
        self._ranges = bytearray()
        self._time_increments = array("f")
        self._scan_times = array("f")
        self._mounts = array("d")

    def add(self, stamp_ns: int, beams: Beams) -> None:
        """Take one scan."""
        stated = (beams.angle_min, beams.angle_increment, beams.range_min, beams.range_max)
        # nan is not itself, and would be another key in every message.
        first, step, least, greatest = (np.nan if np.isnan(value) else value for value in map(float, stated))
        beaming = Beaming(first, step, least, greatest, len(beams.ranges))
        self.stamps.append(stamp_ns)
        self._of_scan.append(self._numbers.setdefault(beaming, len(self._numbers)))
        self._ranges += beams.ranges.tobytes()
        self._time_increments.append(beams.time_increment)
        self._scan_times.append(beams.scan_time)
        self._mounts.extend(beams.mount or ())

    def take_recorded_times(self) -> bool:
        """Give scans that all have one stamp the times at which they were recorded; return whether that was done."""
        stamps = np.array(self.stamps)
        recorded = self.clock.recorded(stamps)
        if self.n_scans < LEAST_ALIKE or np.ptp(stamps) or recorded is None:
            return False
        if np.ptp(recorded) < LEAST_APART_NS * (self.n_scans - 1):  # faster than any sensor: not times of scans
            return False
        self.stamps, self.clock = array("q", recorded.tolist()), Clock()
        for stamp in self.stamps:
            self.clock.add(stamp, stamp)
        return True

    @property
    def kind(self) -> str:
        """The type of its messages."""
        return self.stream.kind

    @property
    def scan_time(self) -> float:
        """Median of the stated times between two scans, seconds; 0 where none is stated."""
        return median_seconds(np.frombuffer(self._scan_times, dtype=np.float32))

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
    def stated(self) -> StatedScans:
        """The scans with what each message states."""
        return StatedScans(
            self.topic,
            list(self._numbers),
            np.frombuffer(self._of_scan, dtype=np.int64),
            np.frombuffer(self._ranges, dtype=np.float32),
            np.frombuffer(self._time_increments, dtype=np.float32),
            is_cut(self.kind),
        )
