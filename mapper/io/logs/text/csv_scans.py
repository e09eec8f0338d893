"""Scans as comma-separated values: an exchange format for other programs.

::

    angle_min,-1.5708
    angle_increment,0.0174533
    range_min,0.05
    range_max,30
    stamp,x,y,theta,ranges
    12.50,0.0,0.0,0.0,2.31,2.30,inf,2.28
    12.60,0.1,0.0,0.0,2.21,,nan,2.18

The sensor comes first, one name and value per line: ``angle_min`` is the bearing of the first beam and
``angle_increment`` the step between beams (radians, counter-clockwise from straight ahead); ``range_min`` and
``range_max`` are the minimum and maximum range (metres; defaults 0 and no limit), interpreted like those of a recording
(:mod:`mapper.io.logs.grouping.scan_groups`). ``mount_x``, ``mount_y`` and ``mount_yaw`` are optional and give its mount
on the robot, ``time_increment`` the seconds between beams of a scan stamped at its first beam. Then follow the line
``stamp,x,y,theta,ranges`` and one line per scan: its time in seconds (since 1970 also in milli-, micro- or
nanoseconds), the robot's pose in metres and radians, and one range in metres per beam. ``inf`` is no return; ``nan``,
an empty field, zero or a negative number is no measurement. Lines that start with ``#`` are comments. A name may have
another unit as a suffix: ``range_max_mm``, ``theta_deg``, ``stamp [ms]``, ``ranges (cm)``.

As in files from spreadsheets with other locales, fields may be separated by semicolons or tabs, with decimal commas,
and may be in quotation marks.
"""

from __future__ import annotations

import contextlib
import csv
import math
import re

import numpy as np

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.grouping.scan_groups import scan_groups, usable_limits
from mapper.io.logs.grouping.stated_scans import Beaming, StatedScans
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines
from mapper.io.logs.text.packing import ScanStack, take_one_sensor
from mapper.sensors.georeference import FARTHEST_M
from mapper.sensors.scan import ScanLog, are_degrees, georeferenced, is_angle_step

COLUMNS = ("stamp", "x", "y", "theta")
NEEDED = ("angle_min", "angle_increment")
LIMITS = ("range_min", "range_max")  #: may be any number
SEPARATORS = ",;\t"
IN_DEGREES = (
    "angle_min and angle_increment are in degrees, where the format has radians, by which a scan would go round twice "
    "or more: they are converted."
)
INITIAL = {
    "range_min": 0.0,
    "range_max": math.inf,
    "mount_x": 0.0,
    "mount_y": 0.0,
    "mount_yaw": 0.0,
    "time_increment": 0.0,
}
#: Unit suffixes, and how many of the unit are one metre, radian or second.
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_ANGLES = {"rad": 1.0, "deg": math.radians(1.0)}
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNITS = {
    **dict.fromkeys(("angle_min", "angle_increment", "mount_yaw", "theta"), _ANGLES),
    **dict.fromkeys(("range_min", "range_max", "mount_x", "mount_y", "x", "y", "ranges"), _LENGTHS),
    **dict.fromkeys(("time_increment", "stamp"), _TIMES),
}
_NAME = re.compile(r"(.+?)(?:_([a-z]+)| ?[\[(]([a-z]+)[\])])")


def _with_unit(word: str) -> tuple[str, float]:
    """Return a column or value name, and how many of the unit in ``word`` are one base unit; 1 without a unit."""
    match = _NAME.fullmatch(word)
    if word in _UNITS or match is None:
        return word, 1.0
    per_unit = _UNITS.get(match[1], {}).get(match[2] or match[3])
    return (word, 1.0) if per_unit is None else (match[1], per_unit)


def is_csv_scans(head: bytes) -> bool:
    """Return whether the first line that is not a comment names one of the sensor's values."""
    lines = (line.strip() for line in head.split(b"\n"))
    first = next((line for line in lines if line and not _is_remark(line)), b"").decode("latin-1")
    separator = _separator(first)
    return separator is not None and _with_unit(_fields(first, separator)[0])[0] in {*NEEDED, *INITIAL}


def _is_remark(line: bytes) -> bool:
    """Return whether the first field of a line starts with ``#``, also in quotation marks, or is Excel's ``sep=;``."""
    return line.lstrip(b'" ').startswith(b"#") or re.fullmatch(rb"sep=.", line.strip()) is not None


def _separator(line: str) -> str | None:
    """Return the field separator after the first field, a name; None if there is none."""
    return next((sign for sign in line if sign in SEPARATORS), None)


def _fields(line: str, separator: str) -> list[str]:
    words = line.split(separator)
    if '"' in line:
        with contextlib.suppress(csv.Error):
            words = next(csv.reader([line], delimiter=separator), [""])
    return [field.strip() for field in words]


class _Reader:
    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.values = dict(INITIAL)
        self.stack = ScanStack("CSV", limits)
        self.notes: list[str] = []
        self._in_rows = False
        self._separator: str | None = None
        self._per_second: float | None = None  #: of the time unit, once it is known
        self._per_unit = {"x": 1.0, "y": 1.0, "theta": 1.0, "ranges": 1.0}  #: metres, radians
        self._converted: list[str] = []  #: names with another unit
        self._decimal = ""  #: decimal separator, once a number has determined it
        self._first: list[float] | None = None  #: the first scan's pose

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        row = text.decode("latin-1").strip(" \r\n")
        if not row or _is_remark(text):
            return
        self._separator = self._separator or _separator(row) or ","
        tokens = _fields(row, self._separator)
        if not any(tokens):
            return
        if self._in_rows:
            self._take_scan(tokens, line)
            return
        name, per_unit = _with_unit(tokens[0])
        if tuple(_with_unit(token)[0] for token in tokens[:4]) == COLUMNS:
            self._take_columns(tokens)
            self._begin_rows(line)
        elif name in NEEDED or name in INITIAL:
            if len(tokens) < 2 or any(tokens[2:]):
                raise ReadError("log.header", f"Line {line}: {tokens[0]} needs one value, as in {tokens[0]},0.5.")
            (value,) = fields.numbers(self._with_points(tokens[1:2], line, tokens[0]), line, tokens[0])
            self.values[name] = value * per_unit
            if per_unit != 1.0:
                self._converted.append(tokens[0])
        else:
            raise ReadError(
                "log.header",
                f"Line {line}: {tokens[0]!r:.40} is neither a value of the sensor nor the line "
                "'stamp,x,y,theta,ranges' that the scans follow.",
            )

    def _with_points(self, tokens: list[str], line: int, word: str) -> list[str]:
        """Return numbers with decimal points; a file has either points or commas.

        Raises :class:`ReadError`, quoting the file's number, for a point among commas.
        """
        if not self._decimal:
            self._decimal = next((sign for token in tokens for sign in token if sign in ",."), "")
        if self._decimal != ",":
            return tokens
        numbers = [token.replace(",", ".") for token in tokens]
        for token, number in zip(tokens, numbers, strict=True):
            if "." in token or (token and not fields.is_number(number)):
                raise ReadError(
                    "log.not_a_number",
                    f"Line {line}: {token!r:.40} in this {word} line is not a number; this file has decimal commas.",
                )
        return numbers

    def _take_columns(self, tokens: list[str]) -> None:
        """Read the units in the column names."""
        for token in tokens[: len(COLUMNS) + 1]:
            name, per_unit = _with_unit(token)
            if per_unit == 1.0:
                if name != token and name == "stamp":
                    self._per_second = 1.0
                continue
            self._converted.append(token)
            if name == "stamp":
                self._per_second = round(1.0 / per_unit)
            else:
                self._per_unit[name] = per_unit

    def _begin_rows(self, line: int) -> None:
        missing = [name for name in NEEDED if name not in self.values]
        if missing:
            raise ReadError("log.header", f"Line {line}: the lines before this one do not state {missing[0]}.")
        for name, value in self.values.items():
            if not abs(value) <= 1e4 and name not in LIMITS:
                raise ReadError("log.header", f"Before line {line}: {name} cannot be {value:g}.")
        self._in_rows = True
        if self._converted:
            self.notes.append(
                f"{', '.join(self._converted)} state other units than the format has: they are converted to metres, "
                "radians and seconds."
            )

    def _take_scan(self, tokens: list[str], line: int) -> None:
        tokens = self._with_points(tokens, line, "CSV")
        n = len(tokens) - len(COLUMNS)
        if n < 1:
            raise ReadError("log.truncated_line", f"Line {line} ends early: it has {len(tokens)} fields and no ranges.")
        if n > self.limits.max_beams:
            raise LimitError("log.too_many_beams", f"Line {line} has {n} ranges; the limit is {self.limits.max_beams}.")
        if are_degrees(self.values["angle_min"], self.values["angle_increment"], n):
            self.values |= {name: math.radians(self.values[name]) for name in NEEDED}
            self.notes.append(IN_DEGREES)
        if not is_angle_step(self.values["angle_increment"], n):
            raise ReadError(
                "log.header",
                f"Line {line} has {n} ranges, which an angle_increment of {self.values['angle_increment']:g} rad "
                "cannot lie between.",
            )
        if self._per_second is None:
            self._per_second, note = fields.time_unit(tokens[0], line, "CSV")
            self.notes += note
        stamp = fields.stamp(tokens[0], line, "CSV", self._per_second)
        units = [self._per_unit[name] for name in COLUMNS[1:]]
        pose = fields.pose(tokens[1:4], line, "CSV", "the robot’s", self.limits, FARTHEST_M / min(units))
        pose = [value * per_unit for value, per_unit in zip(pose, units, strict=True)]
        self._first = first = self._first or pose
        if max(abs(pose[0] - first[0]), abs(pose[1] - first[1])) > self.limits.max_pose:
            raise ReadError(
                "log.pose",
                f"Line {line}: the robot’s pose in this CSV line, {pose[0]:g}, {pose[1]:g}, {pose[2]:g}, is "
                f"impossible: it is more than {self.limits.max_pose:g} m from the first.",
            )
        readings = fields.numbers([token or "nan" for token in tokens[4:]], line, "CSV")
        if self._per_unit["ranges"] != 1.0:
            readings = [reading * self._per_unit["ranges"] for reading in readings]
        self.stack.add(line, readings, (pose, pose), stamp)


def read_csv_scans(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the CSV log at ``path``, plain or compressed.

    Raises :class:`ReadError`, naming the line, and :class:`LimitError`.
    """
    reader = _Reader(limits)
    missing = "no line follows 'stamp,x,y,theta,ranges'"
    notes = take_one_sensor(reader, TextLines(path, limits, progress), topic, "A CSV log", missing)
    stack, v = reader.stack, reader.values
    stack.check_headings()
    least, most, _ = usable_limits(v["range_min"], v["range_max"])
    ranges, notes_on_ranges = stack.clean_readings(float(np.nextafter(np.float32(most), np.float32(np.inf))))
    beaming = Beaming(v["angle_min"], v["angle_increment"], v["range_min"], v["range_max"], stack.n_beams)
    times = np.full(stack.n_scans, v["time_increment"], dtype=np.float32)
    stated = StatedScans("of the log", [beaming], stack.kind_of_scan, ranges, times)
    (scans,), notes_on_limits = scan_groups(stated, limits)
    poses, notes_on_poses = georeferenced(stack.robot_poses, "The poses", "the pose in each scan’s line", limits)
    return ScanLog(
        ranges=scans.ranges,
        angle_min=v["angle_min"],
        angle_increment=v["angle_increment"],
        range_min=least,
        range_max=most,
        stamps_ns=stack.stamps_ns,
        trajectories={"scan": poses},
        mount=(v["mount_x"], v["mount_y"], v["mount_yaw"]),
        time_increment=v["time_increment"],
        name=path.name,
        format="CSV",
        notes=(*notes, *reader.notes, *notes_on_ranges, *notes_on_limits, *notes_on_poses, *stack.notes_on_time()),
        limits=limits,
    )
