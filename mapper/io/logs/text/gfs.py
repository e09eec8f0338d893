"""Logs written by gmapping (``.gfs``): its scans with odometry, and the poses of its best particle.

Source: GridSlamProcessor of gmapping, which writes one record per line::

    LASER_READING n r1 … rn x y theta stamp                  (the robot's pose is that of the odometry)
    SM_UPDATE m x1 y1 theta1 weight1 …                       (the particles, after each scan was matched)
    ODO_UPDATE m x1 y1 theta1 weight1 … stamp
    FRAME number distance angle

Metres, radians, seconds. Angles are not stated: :func:`mapper.io.logs.text.carmen_beams.front_laser_beams`.
"""

from __future__ import annotations

from array import array

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.text import fields
from mapper.io.logs.text.carmen_beams import front_laser_beams
from mapper.io.logs.text.lines import TextLines
from mapper.io.logs.text.packing import ScanStack, note_on_largest_reading, take_one_sensor
from mapper.sensors.scan import ScanLog, Trajectory

WORDS = frozenset({"LASER_READING", "SM_UPDATE", "ODO_UPDATE", "FRAME"})
NO_RETURN = 80.0  #: metres: larger readings are no returns, because the format states no maximum range


class _GfsReader:
    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.stack = ScanStack("LASER_READING", limits)
        self.best = array("d")  #: pose of the best particle after each scan, NaN if not stated

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        tokens = text.decode("latin-1").split()
        if tokens and tokens[0] == "LASER_READING":
            self._take_scan(tokens, line)
        elif tokens and tokens[0] == "SM_UPDATE" and self.stack.n_scans:
            self._take_particles(tokens, line)

    def _take_scan(self, tokens: list[str], line: int) -> None:
        word = tokens[0]
        if len(tokens) < 2:
            raise ReadError("log.truncated_line", f"Line {line}: this {word} line ends after its first word.")
        n = fields.count(tokens[1], line, word, "beams", self.limits.max_beams)
        fields.require_fields(tokens, (n + 6, n + 6), line, word, f"{n} beams")
        pose = fields.pose(tokens[n + 2 : n + 5], line, word, "the robot’s", self.limits)
        stamp = fields.stamp(tokens[n + 5], line, word)
        self.stack.add(line, fields.numbers(tokens[2 : n + 2], line, word), (pose, pose), stamp)
        self.best.extend((np.nan,) * 3)

    def _take_particles(self, tokens: list[str], line: int) -> None:
        values = fields.numbers(tokens[2:], line, tokens[0])
        if len(values) < 4:
            raise ReadError("log.truncated_line", f"Line {line}: this SM_UPDATE line has no particle.")
        particles = [values[at : at + 4] for at in range(0, len(values) - 3, 4)]
        best = max(particles, key=lambda particle: particle[3])
        self.best[-3:] = array(
            "d", fields.pose([str(value) for value in best[:3]], line, tokens[0], "a particle’s", self.limits)
        )


def read_gfs(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the gmapping log at ``path``, plain or compressed. Raises :class:`ReadError`, naming the line."""
    reader = _GfsReader(limits)
    notes = take_one_sensor(
        reader, TextLines(path, limits, progress), topic, "A gmapping log", "it has no LASER_READING line"
    )
    stack = reader.stack
    stack.check_headings()
    ranges, notes_on_ranges = stack.clean_ranges(NO_RETURN)
    beams = front_laser_beams(stack.n_beams, stack.word)
    best = np.array(reader.best).reshape(-1, 3)
    trajectories = {"odom": Trajectory(stack.robot_poses, "the odometry in each LASER_READING line", "odom")}
    if np.isfinite(best).all():
        text = "gmapping’s best particle after each scan (SM_UPDATE)"
        trajectories = {"gmapping": Trajectory(best, text, "map"), **trajectories}
    elif np.isfinite(best).any():
        missing = int(np.count_nonzero(np.isnan(best[:, 0])))
        notes.append(f"{missing} scans have no SM_UPDATE line behind them, so that gmapping’s poses are not used.")
    return ScanLog(
        ranges=ranges,
        angle_min=beams.angle_min,
        angle_increment=beams.angle_increment,
        range_min=0.0,
        range_max=NO_RETURN,
        stamps_ns=stack.stamps_ns,
        trajectories=trajectories,
        name=path.name,
        format="gmapping (.gfs)",
        notes=(*notes, *beams.notes, *notes_on_ranges, *note_on_largest_reading(ranges), *stack.notes_on_time()),
        angles_assumed=beams.is_assumed,
        limits=limits,
    )
