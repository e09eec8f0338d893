"""Sonar rings as two texts in one folder: ``measurement.txt``, one line per round of readings, and ``poses.txt``.

A line of ``measurement.txt`` is the time in milliseconds and the reading of each sonar in millimetres; a line of
``poses.txt`` is the same time and the robot's pose: x and y in millimetres, the heading in tenths of a degree,
counter-clockwise. Readings of 5110 or more are no return. Source: the data of a course's occupancy grid exercises.

The sonars' directions are in neither file. Eight sonars are assumed to be the half ring of those exercises: one to each
side and six ahead, 15° apart, from right to left; any other number is spread evenly over the half circle ahead. Cones
are assumed to be 20° wide, with a minimum range of 0.17 m.
"""

from __future__ import annotations

import math
import re
from array import array
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines, take_lines
from mapper.io.logs.text.packing import notes_on_time
from mapper.sensors.scan import ScanLog, Trajectory

READINGS, POSES = "measurement.txt", "poses.txt"
NO_RETURN_MM = 5110
RANGE_MIN, RANGE_MAX = 0.17, 5.1
BEAM_WIDTH = math.radians(20.0)
EIGHT = np.radians([-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0])
LEAST, MOST = 4, 64  #: sonars
_LINE = re.compile(rb"\s*[0-9]+(?:[ \t]+[0-9]+){4,64}\s*\Z")
_POSE = re.compile(rb"\s*[0-9]+(?:[ \t]+-?[0-9]+){3}\s*\Z")


def is_sonar(head: bytes) -> bool:
    """Return whether the first line of a text is from ``measurement.txt``: five or more integers."""
    return _LINE.match(head.split(b"\n", 1)[0]) is not None


def is_sonar_poses(head: bytes) -> bool:
    """Return whether the first line of a text is from ``poses.txt``: four integers."""
    return _POSE.match(head.split(b"\n", 1)[0]) is not None


class _Rows:
    """Lines of numbers of equal length."""

    def __init__(self, what: str, columns: int | None, limits: Limits) -> None:
        self.what, self.columns, self.limits = what, columns, limits
        self.n = 0
        self._values = array("d")

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        tokens = text.decode("latin-1").split()
        if not tokens:
            return
        if self.columns is None and LEAST < len(tokens) <= MOST + 1:
            self.columns = len(tokens)
        if len(tokens) != self.columns:
            expected = self.columns or f"{LEAST + 1} to {MOST + 1}"
            raise ReadError("log.beams_vary", f"Line {line} of {self.what} has {len(tokens)} numbers, not {expected}.")
        values = fields.numbers(tokens, line, self.what)
        if not all(math.isfinite(value) for value in values):
            raise ReadError("log.garbage", f"Line {line} of {self.what} holds a number that is not finite.")
        if self.n >= self.limits.max_scans:
            raise LimitError("log.too_many_scans", f"Line {line}: the log has more than {self.n} rounds of readings.")
        self._values.extend(values)
        self.n += 1

    def rows(self) -> NDArray[np.float64]:
        """All rows (n, columns)."""
        return np.frombuffer(self._values).reshape(self.n, -1)


def _rows(path: Source, columns: int | None, limits: Limits, progress: Progress | None) -> tuple[_Rows, list[str]]:
    rows, notes = _Rows(path.name, columns, limits), list[str]()
    take_lines(TextLines(path, limits, progress), rows.take, lambda: rows.n, notes)
    if not rows.n:
        raise ReadError("log.no_scans", f"{path.name} holds no readings.")
    return rows, notes


def read_sonar(
    readings: Source,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
    topic: str | None = None,
    *,
    poses: Source | None = None,
) -> ScanLog:
    """Return the log of a sonar ring; its ``poses`` are in the folder of the ``readings`` unless a file is named.

    Raises :class:`ReadError`, naming the file and the line, also if the poses are missing, and :class:`LimitError`.
    """
    if topic is not None:
        raise ReadError("log.topic", f"A sonar log has one ring of sonars and no topic {topic!r:.80}.")
    if poses is None and isinstance(readings, Path) and readings.with_name(POSES).is_file():
        poses = readings.with_name(POSES)
    if poses is None:
        raise ReadError(
            "log.poses",
            f"The poses are missing: next to {readings.name} there is no {POSES}; a sonar log consists of both files"
            ", or of the folder or tar archive that holds them.",
        )
    measured, notes = _rows(readings, None, limits, progress)
    stated, more = _rows(poses, 4, limits, None)
    stamps, ranges = np.split(measured.rows(), [1], axis=1)
    where = stated.rows()
    if len(where) != len(ranges) or not np.array_equal(where[:, :1], stamps):
        raise ReadError(
            "log.poses",
            f"{READINGS} and {POSES} do not belong together: {len(ranges)} rounds of readings and {len(where)} poses, "
            "which must have the same times.",
        )
    metres = np.where(ranges >= NO_RETURN_MM, np.inf, ranges / 1000.0).astype(np.float32)
    metres[metres <= 0.0] = np.nan
    pose = np.column_stack([where[:, 1:3] / 1000.0, np.unwrap(np.radians(where[:, 3] / 10.0))])
    if np.abs(pose[:, :2]).max() > limits.max_pose or np.abs(stamps).max() > 1e15:
        raise ReadError("log.extent", f"A pose or a time in {POSES} is out of range.")
    n_sonars = ranges.shape[1]
    known = n_sonars == len(EIGHT)
    bearings = EIGHT if known else np.linspace(-math.pi / 2.0, math.pi / 2.0, n_sonars)
    assumed = "±90°, ±37.5°, ±22.5° and ±7.5° are" if known else "evenly from −90° to 90° is"
    stamps_ns = (stamps[:, 0] * 1e6).astype(np.int64)
    return ScanLog(
        ranges=metres,
        angle_min=float(bearings[0]),
        angle_increment=0.0,
        range_min=RANGE_MIN,
        range_max=RANGE_MAX,
        stamps_ns=stamps_ns,
        trajectories={"exact": Trajectory(pose, f"the poses in {POSES}, which are said to be exact")},
        bearings=bearings,
        beam_width=BEAM_WIDTH,
        frame_id="sonar",
        name=readings.name,
        format="sonar ring",
        notes=(
            *notes,
            *more,
            *notes_on_time(stamps_ns),
            f"The files do not state where the sonars point: {assumed} assumed, cones of 20°.",
        ),
        limits=limits,
    )
