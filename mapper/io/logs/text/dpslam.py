"""DP-SLAM logs: ``Odometry x y theta`` followed by ``Laser n r1 … rn``; metres, radians, no times.

Source: the data files of the DP-SLAM project (Eliazar & Parr). The laser is a SICK LMS in millimetre mode with beams 1°
apart. Readings of 8.183 m or more are codes for no return.
"""

from __future__ import annotations

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.text import fields
from mapper.io.logs.text.carmen_beams import front_laser_beams
from mapper.io.logs.text.lines import TextLines
from mapper.io.logs.text.packing import ScanStack, take_one_sensor
from mapper.sensors.scan import ScanLog, Trajectory

WORDS = frozenset({"Odometry", "Laser"})
RANGE_MAX = 8.18  #: metres


class _DpslamReader:
    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.stack = ScanStack("Laser", limits)
        self._pose: list[float] | None = None

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        tokens = text.decode("latin-1").split()
        if not tokens or tokens[0].startswith("#"):
            return
        word = tokens[0]
        if word == "Odometry":
            if len(tokens) != 4:
                raise ReadError(
                    "log.truncated_line", f"Line {line}: an Odometry line has 4 fields, this one has {len(tokens)}."
                )
            self._pose = fields.pose(tokens[1:4], line, word, "the robot’s", self.limits)
        elif word == "Laser":
            if len(tokens) < 2:
                raise ReadError("log.truncated_line", f"Line {line}: this Laser line ends after its first word.")
            n = fields.count(tokens[1], line, word, "beams", self.limits.max_beams)
            fields.require_fields(tokens, (n + 2, n + 2), line, word, f"{n} beams")
            if self._pose is None:
                raise ReadError("log.pose", f"Line {line}: this Laser line has no Odometry line before it.")
            self.stack.add(line, fields.numbers(tokens[2:], line, word), (self._pose, self._pose), 0.0)
            self._pose = None
        else:
            raise ReadError(
                "log.garbage", f"Line {line} is not a DP-SLAM message: it starts with {text[:30].decode('latin-1')!r}."
            )


def read_dpslam(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the DP-SLAM log at ``path``, plain or compressed; its stamps are zero.

    Raises :class:`ReadError`, naming the line, and :class:`LimitError`.
    """
    reader = _DpslamReader(limits)
    lines = TextLines(path, limits, progress)
    notes = take_one_sensor(reader, lines, topic, "A DP-SLAM log", "it has no Laser line")
    stack = reader.stack
    stack.check_headings()
    ranges, notes_on_ranges = stack.clean_ranges(RANGE_MAX)
    beams = front_laser_beams(stack.n_beams, "Laser")
    return ScanLog(
        ranges=ranges,
        angle_min=beams.angle_min,
        angle_increment=beams.angle_increment,
        range_min=0.0,
        range_max=RANGE_MAX,
        stamps_ns=stack.stamps_ns,
        trajectories={"scan": Trajectory(stack.robot_poses, "the Odometry line before each scan", "odom")},
        name=path.name,
        format="DP-SLAM",
        notes=("The log has no times.", *notes, *beams.notes, *notes_on_ranges),
        angles_assumed=beams.is_assumed,
        limits=limits,
    )
