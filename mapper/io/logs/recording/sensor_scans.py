"""Scans of one sensor in a recording in order of arrival; each keeps its stated beams and limits."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import wrap_angle
from mapper.io.logs.grouping.stated_scans import Beaming, StatedScans, median_seconds
from mapper.io.logs.recording.clocks import Clock, with_set_stamps
from mapper.io.logs.recording.runs import Track
from mapper.io.logs.recording.stream import Stream
from mapper.io.logs.recording.timeline import Moments, why_no_stamps
from mapper.io.logs.ros.ros_messages import Beams
from mapper.sensors.planar.options import is_cut

LEAST_BEAMS = 10  #: fewer do not determine the end of their angles
MOST_BEAMS_OFF = 2.0  #: tolerance in beams for the stated end: drivers use the next beam, or the last one twice
MOST_OFF_RAD = 0.01
SAME_SWEEP, MOST_CLOUDS = 0.1, 0.8  #: share by which the sweeps of clouds may differ, and of clouds that agree


class SensorScans:
    """The scans of the sensor ``topic``, from messages of one ``stream``, in ``frame``."""

    def __init__(self, topic: str, stream: Stream, frame: str, beam_width: float) -> None:
        self.topic = topic
        self.stream = stream
        self.frame = frame
        self.beam_width = max(0.0, beam_width)
        self.stamps = array("q")
        self.positions = array("q")  #: index of each scan's message in the recording
        self.offsets: NDArray[np.int64] | None = None  #: offsets that continue the stamps across clock restarts
        self.clock = Clock()
        self.in_degrees = 0  #: messages whose angles were in degrees, now converted to radians
        self.other_ends = 0  #: messages whose angle_max contradicts the angle of their last beam
        self._other_end = ""  #: of the first of them
        self._numbers: dict[Beaming, int] = {}
        self._of_scan = array("q")  #: index of each scan's beaming
        self._ranges = bytearray()
        self._is_repeated = array("b")  #: whether each scan repeats the previous one
        self._time_increments = array("f")
        self._scan_times = array("f")
        self._mounts = array("d")

    def add(self, stamp_ns: int, beams: Beams) -> None:
        """Add one scan."""
        stated = (beams.angle_min, beams.angle_increment, beams.range_min, beams.range_max)
        # NaN is not equal to itself, and would be another key in every message.
        first, step, least, greatest = (np.nan if np.isnan(value) else value for value in map(float, stated))
        beaming = Beaming(first, step, least, greatest, len(beams.ranges))
        readings = beams.ranges.tobytes()
        is_repeated = bool(self.stamps) and self.stamps[-1] == stamp_ns and self._ranges.endswith(readings)
        self._is_repeated.append(is_repeated)
        self.stamps.append(stamp_ns)
        self._of_scan.append(self._numbers.setdefault(beaming, len(self._numbers)))
        self._ranges += readings
        self._time_increments.append(beams.time_increment)
        self._scan_times.append(beams.scan_time)
        if ends_elsewhere(beams):
            self.other_ends += 1
            self._other_end = self._other_end or _said_of_end(beams)
        self._mounts.extend(beams.mount or ())

    @property
    def notes_on_angles(self) -> list[str]:
        """Notes on messages with angles in degrees, or whose ``angle_max`` contradicts their increments."""
        notes = []
        if self.in_degrees:
            notes.append(
                f"{self._of_all(self.in_degrees)} messages on {self.topic} state their angles in degrees, where they "
                "are defined in radians, by which a scan would go round twice or more: they are converted."
            )
        if self.other_ends:
            notes.append(
                f"{self._of_all(self.other_ends)} messages on {self.topic} contradict themselves: {self._other_end}"
            )
        return notes

    def _of_all(self, n: int) -> str:
        return f"{n} of the {self.n_scans}" if n < self.n_scans else f"All {self.n_scans}"

    def take_recorded_times(self) -> str:
        """Use the recording times of the scans if their stamps do not distinguish them.

        Return what is wrong with the stamps, nothing if they are kept: see :func:`why_no_stamps`.
        """
        stamps = np.array(self.stamps)
        recorded = self.clock.recorded(stamps)
        differ = np.frombuffer(self._is_repeated, dtype=np.int8)[1:] == 0
        if not np.ptp(stamps):  # also for a robot at rest in a static scene
            differ = np.ones(len(stamps) - 1, dtype=np.bool_)
        why = "" if recorded is None else why_no_stamps(stamps, recorded, differ)
        if why and recorded is not None:
            self.stamps, self.clock = array("q", recorded.tolist()), Clock()
            for stamp in self.stamps:
                self.clock.add(stamp, stamp)
        return why

    def put_in_order(self, *, by_recording: bool) -> None:
        """Sort the scans by recording time, as far as known.

        With ``by_recording`` their messages are positioned by those times, not by their place in the file.
        """
        recorded = self.clock.recorded(np.array(self.stamps))
        if recorded is not None and by_recording:
            self.positions = array("q", recorded.tobytes())
        if recorded is None or (np.diff(recorded) >= 0).all():
            return
        order = np.argsort(recorded, kind="stable")
        beams = np.array([beaming.beams for beaming in self._numbers])[np.array(self._of_scan)]
        ends = np.cumsum(4 * beams).tolist()
        ranges = [self._ranges[end - 4 * n : end] for end, n in zip(ends, beams.tolist(), strict=True)]
        self._ranges = bytearray().join(ranges[k] for k in order)
        for name in ("stamps", "positions", "_of_scan", "_is_repeated", "_time_increments", "_scan_times"):
            column = getattr(self, name)
            setattr(self, name, array(column.typecode, np.array(column)[order].tobytes()))
        self._mounts = array("d", self.mounts[order].tobytes() if len(self._mounts) else b"")
        self.clock.set_to(np.array(self.stamps), recorded[order])

    def set_stamps(self) -> None:
        """Set the stamps of scans without one by the clock of the others: see :func:`with_set_stamps`."""
        stamps = np.array(self.stamps)
        recorded = self.clock.recorded(stamps)
        corrected = None if recorded is None else with_set_stamps(stamps, recorded)
        if corrected is not None:
            self.set_to(corrected)

    def set_to(self, stamps_ns: NDArray[np.int64]) -> None:
        """Replace the stamps (n,), in recording order."""
        recorded = self.clock.recorded(np.array(self.stamps))
        self.stamps = array("q", stamps_ns.tolist())
        if recorded is not None:
            self.clock.set_to(stamps_ns, recorded)

    @property
    def kind(self) -> str:
        """The type of its messages."""
        return self.stream.kind

    @property
    def scan_time(self) -> float:
        """Median of the stated times between two scans, seconds; 0 if not stated."""
        return median_seconds(np.frombuffer(self._scan_times, dtype=np.float32))

    @property
    def mounts(self) -> NDArray[np.float64]:
        """``T_base_scan`` (n_scans, 3) of scans extracted from clouds; otherwise (0, 3)."""
        return np.array(self._mounts).reshape(-1, 3)

    @property
    def moments(self) -> Moments:
        """Times of the scans, continued across clock restarts."""
        stamps = np.frombuffer(self.stamps, dtype=np.int64)
        counted = stamps if self.offsets is None else stamps + self.offsets
        return Moments(counted, np.frombuffer(self.positions, dtype=np.int64))

    @property
    def track(self) -> Track:
        """The stamps of the scans in recording order."""
        stamps = np.array(self.stamps)
        return Track(self.topic, stamps, np.array(self.positions), self.clock.recorded(stamps))

    @property
    def n_scans(self) -> int:
        """Number of scans so far."""
        return len(self.stamps)

    def readings_around(self, before_ns: int, after_ns: int) -> tuple[NDArray[np.float32], NDArray[np.float32]] | None:
        """Return the readings of the last scan until one time and of the first from another on; None if one is missing.

        The times are continued like those of :attr:`moments`.
        """
        stamps = self.moments.stamps_ns
        earlier, later = np.flatnonzero(stamps <= before_ns), np.flatnonzero(stamps >= after_ns)
        if not len(earlier) or not len(later):
            return None
        ends = np.cumsum(np.array([beaming.beams for beaming in self._numbers])[np.array(self._of_scan)])
        parts = np.split(np.frombuffer(self._ranges, dtype=np.float32), ends[:-1])
        return parts[earlier[np.argmax(stamps[earlier])]], parts[later[np.argmin(stamps[later])]]

    def _even_increments(self) -> NDArray[np.float32]:
        """Return the usual time increment for each scan cut out of a cloud, whose own one is an estimate.

        0 where the clouds do not agree on one.
        """
        own = np.frombuffer(self._time_increments, dtype=np.float32)
        usual = np.float32(np.median(own)) if len(own) else np.float32(0.0)
        if np.mean(np.abs(own - usual) <= SAME_SWEEP * abs(usual)) < MOST_CLOUDS:
            usual = np.float32(0.0)
        return np.full(len(own), usual)

    @property
    def stated(self) -> StatedScans:
        """The scans with the values stated by each message."""
        return StatedScans(
            f"on {self.topic}",
            list(self._numbers),
            np.frombuffer(self._of_scan, dtype=np.int64),
            np.frombuffer(self._ranges, dtype=np.float32),
            self._even_increments() if is_cut(self.kind) else np.frombuffer(self._time_increments, dtype=np.float32),
            is_cut(self.kind),
        )


def ends_elsewhere(beams: Beams) -> bool:
    """Return whether ``angle_max`` differs from the angle of the last beam by more than two beams.

    Angles are compared modulo one turn, but the sweep must have the same direction.
    """
    if not np.isfinite(beams.angle_max) or len(beams.ranges) < LEAST_BEAMS:
        return False
    apart = beams.angle_min + beams.angle_increment * (len(beams.ranges) - 1) - beams.angle_max
    return bool(abs(wrap_angle(apart)) > _near(beams)) or _is_other_way(beams)


def _near(beams: Beams) -> float:
    return MOST_BEAMS_OFF * abs(beams.angle_increment) + MOST_OFF_RAD


def _is_other_way(beams: Beams) -> bool:
    """Return whether ``angle_max`` is the angle of the last beam for the opposite sign of the increments.

    After half a turn the angle is the same either way.
    """
    swept = beams.angle_increment * (len(beams.ranges) - 1)
    return bool(
        abs(abs(swept) - np.pi) > _near(beams)
        and abs(beams.angle_min - swept - beams.angle_max) <= _near(beams)
        and abs(beams.angle_min + swept - beams.angle_max) > _near(beams)
    )


def _said_of_end(beams: Beams) -> str:
    last = beams.angle_min + beams.angle_increment * (len(beams.ranges) - 1)
    first, step, last, stated = np.degrees([beams.angle_min, beams.angle_increment, last, beams.angle_max])
    wrong = "the map is mirrored, its sign is wrong" if _is_other_way(beams) else "walls are bent, it is wrong"
    return (
        f"angle_max is {stated:.4g}°, and {len(beams.ranges)} beams {step:.4g}° apart from {first:.4g}° end at "
        f"{last:.4g}°. angle_increment counts here, as in laser_geometry; if {wrong} in the driver."
    )
