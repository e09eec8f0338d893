"""Logs of CMU's course on mobile robots (Wean Hall): ``O`` and ``L`` lines in centimetres, radians and seconds.

Source: instruct.txt in the course's data. Times start with the run; every pose is in the odometry frame::

    O x y theta stamp
    L x y theta  laser_x laser_y laser_theta  r1 … r180  stamp

The 180 readings span 180° from the right to the left, 1° apart. Readings of 80 m or more are the SICK LMS's "no return"
(8183 cm). The laser's mount is the difference of the two poses of an ``L`` line, 25 cm ahead.
"""

from __future__ import annotations

import re
from array import array

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.text import fields
from mapper.io.logs.text.carmen_beams import NO_RETURN, front_laser_beams
from mapper.io.logs.text.interpolation import poses_at_scans
from mapper.io.logs.text.lines import TextLines
from mapper.io.logs.text.packing import ScanStack, take_one_sensor
from mapper.sensors.scan import ScanLog, Topic, Trajectory

BEAMS = 180
FIELDS = {"O": 5, "L": 8 + BEAMS}  #: fields per line, including its word
SAME_M, SAME_RAD = 0.01, 0.01  #: tolerance of the difference of the laser's and the robot's pose between lines

_LINE = re.compile(rb"^[LO](?:[ \t]+[-+]?[0-9.][-+.0-9eE]*){4}", re.MULTILINE)


def is_cmu(head: bytes) -> bool:
    """Return whether a line of a text starts like these: one letter, and at least four numbers."""
    return _LINE.search(head) is not None


class _Reader:
    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.stack = ScanStack("L", limits)
        self.odometry = array("d")  #: x, y (m), theta (rad), stamp (s) of each O line
        self.n_odometry = 0

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        tokens = text.decode("latin-1").split()
        if not tokens or tokens[0].startswith("#"):
            return
        word = tokens[0]
        if word not in FIELDS:
            raise ReadError(
                "log.garbage", f"Line {line} is not a CMU message: it starts with {text[:30].decode('latin-1')!r}."
            )
        if len(tokens) < FIELDS[word]:
            raise ReadError(
                "log.truncated_line",
                f"Line {line}: this {word} line ends early: it has {len(tokens)} of {FIELDS[word]} fields.",
            )
        if len(tokens) > FIELDS[word]:
            raise ReadError(
                "log.beam_count", f"Line {line}: an {word} line has {FIELDS[word]} fields, this one has {len(tokens)}."
            )
        robot = self._pose(tokens[1:4], line, word, "the robot’s")
        stamp = fields.stamp(tokens[-1], line, word)
        if word == "O":
            self.odometry.extend([*robot, stamp])
            self.n_odometry += 1
        else:
            laser = self._pose(tokens[4:7], line, word, "the laser’s")
            readings = [0.01 * reading for reading in fields.numbers(tokens[7:-1], line, word)]
            self.stack.add(line, readings, (laser, robot), stamp, (self.n_odometry, 0))

    def _pose(self, tokens: list[str], line: int, word: str, whose: str) -> list[float]:
        x, y, theta = fields.pose(tokens, line, word, whose, self.limits)
        return [0.01 * x, 0.01 * y, theta]


def _mount(stack: ScanStack) -> tuple[tuple[float, float, float], list[str]]:
    """Return ``T_base_laser``, the median over the lines, and a note if the lines differ.

    It is rounded to a micrometre and a microradian, the precision of the lines.
    """
    relative = compose(inverse(stack.robot_poses), stack.laser_poses)
    x, y, yaw = np.median(relative, axis=0).round(6).tolist()
    away = np.abs(relative - [x, y, yaw])
    away[:, 2] = np.abs(wrap_angle(relative[:, 2] - yaw))
    others = int(np.count_nonzero((away > [SAME_M, SAME_M, SAME_RAD]).any(axis=1)))
    note = f"{others} L lines state another place of the laser on the robot; the median of all lines is taken."
    return (x, y, yaw), [note] if others else []


def read_cmu(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the CMU log at ``path``, plain or compressed, in metres; its trajectories are in the frame ``odom``.

    Raises :class:`ReadError`, naming the line, and :class:`LimitError`.
    """
    reader = _Reader(limits)
    notes = take_one_sensor(reader, TextLines(path, limits, progress), topic, "A CMU log", "it has no L line")
    stack = reader.stack
    ranges, notes_on_ranges = stack.clean_ranges(NO_RETURN)
    mount, notes_on_mount = _mount(stack)
    trajectories = {"scan": Trajectory(stack.robot_poses, "the robot’s pose in each L line", "odom")}
    topics = [Topic("L", "laser scan", stack.n_scans, beams=BEAMS, field_of_view_deg=179.0, mount=mount, chosen=True)]
    if reader.n_odometry:
        odometry = np.frombuffer(reader.odometry).reshape(-1, 4)
        poses = poses_at_scans(odometry[:, :3], odometry[:, 3], stack.odometry_before, stack.stamps)
        trajectories["wheel"] = Trajectory(poses, "the O lines at the time of each scan", "odom")
        topics.append(Topic("O", "odometry", reader.n_odometry))
    beams = front_laser_beams(BEAMS, "L")
    return ScanLog(
        ranges=ranges,
        angle_min=beams.angle_min,
        angle_increment=beams.angle_increment,
        range_min=0.0,
        range_max=NO_RETURN,
        stamps_ns=stack.stamps_ns,
        trajectories=trajectories,
        mount=mount,
        name=path.name,
        format="CMU",
        topics=tuple(topics),
        notes=(*notes, *notes_on_ranges, *notes_on_mount, *stack.notes_on_time()),
        limits=limits,
    )
