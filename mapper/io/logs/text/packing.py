"""Collection of scans line by line into packed arrays, with the limits and clean-up common to all text logs."""

from __future__ import annotations

from array import array
from collections.abc import Hashable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.text.lines import TextLines, take_lines

AGREE = 0.1  #: sine of the angle between heading and direction of motion, at the median
LEAST_MOVES = 10  #: minimum number of steps to determine the unit of headings
MOST_CODES = 20  #: distinct readings beyond the maximum range that may be codes for no return
DAY_S = 86_400.0  #: seconds: a longer step between two scans is noted


class ScanStack:
    """The scans of one sensor of a log, in order of arrival.

    Raises :class:`ReadError` for a scan with another number of beams, unless they may ``vary``, and :class:`LimitError`
    for more scans or readings than ``limits`` allow.
    """

    def __init__(self, word: str, limits: Limits, *, vary: bool = False) -> None:
        self.word = word  #: the name of the sensor's lines
        self.limits = limits
        self.n_scans = 0
        self.first_line = 0
        self._vary = vary
        self._kinds: dict[tuple[int, Hashable], int] = {}
        self._kind_of_scan = array("q")
        self._ranges = bytearray()
        self._laser = array("d")
        self._robot = array("d")
        self._stamps = array("d")
        self._odometry_before = array("q")
        self._truth_before = array("q")

    def add(
        self,
        line: int,
        readings: list[float],
        laser_and_robot: tuple[list[float], list[float]],
        stamp: float,
        messages_before: tuple[int, int] = (0, 0),
        beams: Hashable = None,
    ) -> None:
        """Append one scan: metres, radians, seconds, the laser's pose and the robot's.

        ``messages_before`` counts the odometry and true pose messages read so far; ``beams`` has the beams stated by
        the line.
        """
        kind = (len(readings), beams)
        if self.n_scans == 0:
            self.first_line = line
        elif kind not in self._kinds and not self._vary:
            raise ReadError(
                "log.beams_vary",
                f"Line {line}: this {self.word} line has {len(readings)} beams, but line {self.first_line} has "
                f"{self.n_beams}; a log’s scans must have the same number of beams.",
            )
        if self.n_scans >= self.limits.max_scans or len(self._ranges) // 4 + kind[0] > self.limits.max_readings:
            raise LimitError(
                "log.too_many_scans",
                f"Line {line}: the log has more than {self.n_scans} {self.word} scans of {self.n_beams} beams; "
                f"the limits are {self.limits.max_scans} scans and {self.limits.max_readings} readings.",
            )
        self.n_scans += 1
        self._kind_of_scan.append(self._kinds.setdefault(kind, len(self._kinds)))
        self._ranges += array("f", readings)  # values too large for 32 bits become inf
        self._laser.extend(laser_and_robot[0])
        self._robot.extend(laser_and_robot[1])
        self._stamps.append(stamp)
        self._odometry_before.append(messages_before[0])
        self._truth_before.append(messages_before[1])

    @property
    def n_beams(self) -> int:
        """Number of beams; if it varies, that of most scans."""
        return self.kinds[self.usual_kind][0] if self._kinds else 0

    @property
    def kinds(self) -> list[tuple[int, Hashable]]:
        """The distinct numbers of beams, each with the beams stated by its lines."""
        return list(self._kinds)

    @property
    def kind_of_scan(self) -> NDArray[np.int64]:
        """Index of each scan's beams in :attr:`kinds` (n_scans,)."""
        return np.frombuffer(self._kind_of_scan, dtype=np.int64)

    @property
    def usual_kind(self) -> int:
        """Index in :attr:`kinds` of the beams that most scans have."""
        return int(np.argmax(np.bincount(self.kind_of_scan)))

    @property
    def laser_poses(self) -> NDArray[np.float64]:
        """``T_map_laser`` (n_scans, 3)."""
        return np.frombuffer(self._laser).reshape(-1, 3)

    @property
    def robot_poses(self) -> NDArray[np.float64]:
        """``T_map_base`` (n_scans, 3) as stated by the scan lines."""
        return np.frombuffer(self._robot).reshape(-1, 3)

    @property
    def stamps(self) -> NDArray[np.float64]:
        """Seconds (n_scans,)."""
        return np.frombuffer(self._stamps)

    @property
    def odometry_before(self) -> NDArray[np.int64]:
        """Number of odometry messages before each scan (n_scans,)."""
        return np.frombuffer(self._odometry_before, dtype=np.int64)

    @property
    def truth_before(self) -> NDArray[np.int64]:
        """Number of true pose messages before each scan (n_scans,)."""
        return np.frombuffer(self._truth_before, dtype=np.int64)

    @property
    def stamps_ns(self) -> NDArray[np.int64]:
        """Nanoseconds (n_scans,); all zero, as in a log without times, if they were written with too few digits."""
        if few_digits(self.stamps):
            return np.zeros(self.n_scans, dtype=np.int64)
        return np.round(self.stamps * 1e9).astype(np.int64)

    def clean_ranges(self, range_max: float) -> tuple[NDArray[np.float32], list[str]]:
        """Return the readings (n_scans, n_beams) by REP 117, and notes on them.

        Readings of ``range_max`` metres or more are no return, +inf, if that is a code: if most readings are beyond it,
        and differ, they are unchanged. Zero, negative and NaN are invalid, NaN.
        """
        ranges, notes = self.clean_readings(range_max)
        return ranges.reshape(self.n_scans, self.n_beams), notes

    def clean_readings(self, range_max: float | NDArray[np.float64]) -> tuple[NDArray[np.float32], list[str]]:
        """Return :meth:`clean_ranges` of all readings, concatenated, with one ``range_max`` for each or for all."""
        ranges = np.frombuffer(self._ranges, dtype=np.float32)
        notes = []
        with np.errstate(invalid="ignore"):
            invalid = np.isnan(ranges) | (ranges <= 0.0)
            far = ranges >= range_max
            is_code = 2 * np.count_nonzero(far) < len(ranges) or len(np.unique(ranges[far])) < MOST_CODES
            ranges[far if is_code else np.isinf(ranges)] = np.inf
        n_invalid = int(np.count_nonzero(invalid))
        if n_invalid:
            ranges[invalid] = np.nan
            are = "1 reading that is" if n_invalid == 1 else f"{n_invalid} readings that are"
            count = "counts" if n_invalid == 1 else "count"
            notes.append(f"{are} zero, negative or not a number {count} as no measurement.")
        return ranges, notes

    def check_headings(self) -> None:
        """Raise :class:`ReadError` if the poses' headings are in degrees.

        That is, if they agree with the robot's direction of motion, forwards or backwards, as degrees but not as
        radians.
        """
        headings = self.robot_poses[1:, 2]
        if not np.abs(headings).max(initial=0.0) > 2.0 * np.pi:
            return
        steps = np.diff(self.robot_poses[:, :2], axis=0)
        # If both units nearly agree, the motion does not determine the unit.
        tells = (np.hypot(*steps.T) > 0.0) & (np.abs(np.sin(headings - np.radians(headings))) > AGREE)
        if np.count_nonzero(tells) < LEAST_MOVES:
            return
        along = np.arctan2(steps[tells, 1], steps[tells, 0])
        in_radians, in_degrees = (
            float(np.median(np.abs(np.sin(along - read)))) for read in (headings[tells], np.radians(headings[tells]))
        )
        if in_degrees < AGREE and in_radians > 3.0 * AGREE:
            least, most = headings.min(), headings.max()
            raise ReadError(
                "log.degrees",
                f"The headings of the poses, {least:g} to {most:g}, are in degrees: read so, they agree with the "
                "directions in which the robot moves. The format states radians: convert them.",
            )

    def notes_on_time(self) -> list[str]:
        """Return notes on stamps that have too few digits, run backwards or are far apart."""
        step = few_digits(self.stamps)
        if step:
            note = (
                f"The stamps have six significant digits, so they are whole multiples of {step:g} s: too coarse to "
                "tell when a scan was made. The log is read as one without times."
            )
            return [note]
        return notes_on_time(self.stamps_ns)


def few_digits(stamps: NDArray[np.float64]) -> float:
    """Return the step in seconds of stamps (n,) printed with six significant digits, 0 for all others.

    That is C++'s default for a double; seconds since 1970 become multiples of 10,000 s.
    """
    largest = float(np.abs(stamps).max(initial=0.0))
    if len(stamps) < 2 or largest < 1e6:  # below a million seconds the resolution is 1 s or better
        return 0.0
    step = float(10.0 ** (np.floor(np.log10(largest)) - 5.0))
    return step if not np.any(np.fmod(stamps, step)) else 0.0


def notes_on_time(stamps_ns: NDArray[np.int64]) -> list[str]:
    """Return notes on stamps (n,) in nanoseconds that run backwards or are far apart."""
    notes = []
    back = int(np.count_nonzero(stamps_ns[1:] < stamps_ns[:-1]))
    if back:
        times = "once" if back == 1 else f"{back} times"
        notes.append(f"The time runs backwards {times}; the scans stay in the file’s order.")
    steps = np.diff(stamps_ns.astype(np.float64)) * 1e-9  # the difference of two such stamps may overflow in 64 bits
    far = int(np.count_nonzero(np.abs(steps) > DAY_S))
    if far:
        worst = int(np.argmax(np.abs(steps)))
        more = f", and by more than a day {far} times in all" if far > 1 else ""
        notes.append(
            f"Before scan {worst + 1} the time jumps by {steps[worst]:.3g} s ({steps[worst] / DAY_S:.0f} days){more}: "
            "either stamps are wrong, or the file joins several runs."
        )
    return notes


def note_on_largest_reading(ranges: NDArray[np.float32]) -> list[str]:
    """Return a note if the largest readings accumulate at one value, as for a sensor without "no return"."""
    finite = ranges[np.isfinite(ranges)]
    if not finite.size:
        return []
    largest = float(finite.max())
    piled = int(np.count_nonzero(finite > 0.995 * largest))
    if piled < max(20, 0.002 * finite.size):
        return []
    note = (
        f"{piled} readings are at the largest value, {largest:.2f} m, which is likely the sensor’s code for "
        "no return: a max range below it leaves them out."
    )
    return [note]


class LineReader(Protocol):
    """Reader of the lines of one format, which collects their scans."""

    stack: ScanStack

    def take(self, line: int, text: bytes) -> None:
        """Process one line, numbered from 1. Raises :class:`ReadError` or :class:`LimitError` naming it."""


def take_one_sensor(reader: LineReader, lines: TextLines, topic: str | None, log: str, missing: str = "") -> list[str]:
    """Pass all lines of a log with one sensor to ``reader``; return notes on its end, like :func:`take_lines`.

    ``log`` describes a log of the format in errors ("A CMU log"), and ``missing`` the lines without which it has no
    scans. Raises :class:`ReadError` if a ``topic`` is requested, for an invalid line and for a log without scans, and
    :class:`LimitError`.
    """
    if topic is not None:
        raise ReadError("log.topic", f"{log} has one sensor and no topic {topic!r:.80}.")
    notes: list[str] = []
    take_lines(lines, reader.take, lambda: reader.stack.n_scans, notes)
    if not reader.stack.n_scans:
        raise ReadError("log.no_scans", f"The log holds no scans{missing and ': '}{missing}.")
    return notes
