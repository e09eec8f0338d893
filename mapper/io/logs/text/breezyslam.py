"""BreezySLAM's ``.dat`` logs of the mine rover of Mines ParisTech: one scan and wheel encoder readings per line.

Source: the example programs of BreezySLAM (Levy; after Steux & El Hamzaoui, CoreSLAM, 2010). A line has integers
separated by spaces: the time in microseconds, one unused column, the ticks of the left and right wheel, twenty unused
columns, the distances in millimetres, one unused column.

The robot's constants are not in the file; they are those of the examples: wheels of 77 mm radius with 2,000 ticks per
revolution, 330 mm apart, and the lidar 145 mm ahead of their axle. The lidar is a Hokuyo URG-04LX: of the 1,024 steps
of a turn it reports 44 to 725, with 384 ahead; distances below 20 mm are error codes, and the maximum range is 5.6 m.
"""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import wrap_angle
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines
from mapper.io.logs.text.packing import ScanStack, take_one_sensor
from mapper.sensors.scan import ScanLog, Trajectory

WHEEL_RADIUS = 0.077  #: metres
TICKS_PER_TURN = 2000
AXLE = 0.330  #: metres between the wheels
LASER_AHEAD = 0.145  #: metres
STEP = 2.0 * math.pi / 1024
ANGLE_MIN = (44 - 384) * STEP
RANGE_MIN, RANGE_MAX = 0.02, 5.6
BEFORE, AFTER = 24, 1  #: columns of a line before and after the distances
MAX_TICKS = 1e12

_LINE = re.compile(rb"\s*[0-9]+(?:[ \t]+-?[0-9.]+){25,}\s*\Z")


def is_breezyslam(head: bytes) -> bool:
    """Return whether the first line of a text is in this format: many numbers, the first an integer."""
    return _LINE.match(head.split(b"\n", 1)[0]) is not None


class _Reader:
    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.stack = ScanStack("BreezySLAM", limits)

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        tokens = text.decode("latin-1").split()
        if not tokens:
            return
        if len(tokens) <= BEFORE + AFTER:
            raise ReadError(
                "log.truncated_line",
                f"Line {line} ends early: {len(tokens)} columns, and the distances begin after {BEFORE}.",
            )
        if len(tokens) > self.limits.max_beams + BEFORE + AFTER:
            raise LimitError(
                "log.too_many_beams",
                f"Line {line} has {len(tokens) - BEFORE - AFTER} distances; the limit is {self.limits.max_beams}.",
            )
        micros, left, right = fields.numbers([tokens[0], *tokens[2:4]], line, "BreezySLAM")
        if not (abs(left) < MAX_TICKS and abs(right) < MAX_TICKS):
            raise ReadError("log.ticks", f"Line {line}: the wheels’ ticks, {left:g} and {right:g}, are impossible.")
        if not abs(micros) < fields.MAX_STAMP * 1e6:
            raise ReadError("log.stamp", f"Line {line}: the time {tokens[0]!r:.40} of this line is impossible.")
        distances = fields.numbers(tokens[BEFORE:-AFTER], line, "BreezySLAM")
        ticks = [left, right, 0.0]
        self.stack.add(line, [d / 1000.0 for d in distances], (ticks, ticks), micros / 1e6)


def wheel_poses(ticks: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``T_start_base`` (n, 3) from the ticks (n, 2) of the left and right wheel.

    Each step is an arc, whose chord has half its turn as direction. Source: Probabilistic Robotics, 5.4; Siegwart &
    Nourbakhsh, 5.2.4.
    """
    left, right = np.diff(ticks, axis=0).T * (2.0 * math.pi * WHEEL_RADIUS / TICKS_PER_TURN)
    turn = (right - left) / AXLE
    theta = np.concatenate([[0.0], np.cumsum(turn)])
    ahead = (left + right) / 2.0 * np.sinc(turn / (2.0 * math.pi))
    x = np.concatenate([[0.0], np.cumsum(ahead * np.cos(theta[:-1] + turn / 2.0))])
    y = np.concatenate([[0.0], np.cumsum(ahead * np.sin(theta[:-1] + turn / 2.0))])
    return np.column_stack([x, y, wrap_angle(theta)])


def read_breezyslam(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the BreezySLAM log at ``path``, plain or compressed.

    Raises :class:`ReadError`, naming the line, and :class:`LimitError`.
    """
    reader = _Reader(limits)
    notes = take_one_sensor(reader, TextLines(path, limits, progress), topic, "A BreezySLAM log")
    stack = reader.stack
    ranges, _ = stack.clean_ranges(RANGE_MAX)
    ranges[ranges < RANGE_MIN] = np.nan
    poses = wheel_poses(stack.robot_poses[:, :2])
    if np.abs(poses[:, :2]).max() > limits.max_pose:
        raise ReadError(
            "log.extent",
            f"The wheels’ ticks put the robot more than {limits.max_pose:g} m from its start, the limit of a position.",
        )
    return ScanLog(
        ranges=ranges,
        angle_min=ANGLE_MIN,
        angle_increment=STEP,
        range_min=RANGE_MIN,
        range_max=RANGE_MAX,
        stamps_ns=stack.stamps_ns,
        trajectories={
            "wheel": Trajectory(poses, "the wheels’ encoders, with the constants of BreezySLAM’s rover", "odom")
        },
        mount=(LASER_AHEAD, 0.0, 0.0),
        name=path.name,
        format="BreezySLAM",
        notes=(*notes, *stack.notes_on_time()),
        limits=limits,
    )
