"""Trajectories in the format of the TUM RGB-D benchmark, written by evo and many SLAM programs.

Source: the benchmark's file formats: ``timestamp tx ty tz qx qy qz qw``, seconds, metres, a unit quaternion; lines that
start with ``#`` are comments. :func:`mapper.io.export.tum_lines` writes it. Tables with commas, semicolons or tabs are
also supported; a line of column names defines their order.
"""

from __future__ import annotations

import math
import os
from array import array
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.text import fields
from mapper.io.trajectories.lines import rows, stamp_ns
from mapper.sensors.georeference import FARTHEST_M, NO_OFFSET, note_on_offset, offset_of
from mapper.sensors.timed_poses import TimedPoses

COLUMNS = "timestamp tx ty tz qx qy qz qw"
#: Names of the columns in tables, in lower case → those of the format.
SYNONYMS = {
    **dict.fromkeys(("time", "t", "stamp", "seconds", "sec", "secs"), "timestamp"),
    **{
        form.format(axis): f"t{axis}"
        for axis in "xyz"
        for form in (
            "{}",
            "p{}",
            "p_{}",
            "pos_{}",
            "position_{}",
            "pos.{}",
            "position.{}",
            "translation_{}",
            "p_rs_r_{}",
        )
    },
    **{
        form.format(part): f"q{part}"
        for part in "xyzw"
        for form in ("q_{}", "quat_{}", "rot_{}", "orientation_{}", "orientation.{}", "rotation_{}", "q_rs_{}")
    },
}
NORM_TOLERANCE = 0.05  #: tolerance of a quaternion's length around 1: files have as few as two digits
FLAT_M, FLAT_RAD = 0.05, math.radians(3.0)  #: variations of height and tilt of a planar trajectory


def read_tum(path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> TimedPoses:
    """Return the poses of a TUM file, plain or compressed, projected to the plane, in file order.

    A note is added if the ignored heights or tilts exceed those of a planar robot, and if stamps run backwards or
    repeat. Raises :class:`ReadError`, naming the line, for a line without eight numbers, an invalid pose or time, and
    for a file without poses; :class:`LimitError` for one with more lines or bytes than ``limits`` allow.
    """
    stamped, table, row_notes = tum_rows(Path(path), limits)
    poses = Poses3(table[:, :3], table[:, 3:])
    planar = poses.planar
    offset = offset_of(planar)
    planar[:, :2] -= offset
    notes = [*row_notes, *_notes_on_space(poses), *_notes_on_time(stamped)]
    if offset != NO_OFFSET:
        notes.append(note_on_offset("The poses of the TUM file", offset))
    return TimedPoses(stamped, planar, tuple(notes), offset)


def tum_rows(path: Path, limits: Limits) -> tuple[NDArray[np.int64], NDArray[np.float64], list[str]]:
    """Return the stamps (n,), ns, and poses (n, 7) of a TUM file: x y z, metres, and the unit quaternion x y z w.

    If the times cannot be seconds, they are in the smaller unit in which the first is a time since 1970, which a
    returned note states. Raises the errors of :func:`read_tum`.
    """
    stamps, values = array("q"), array("d")
    per_second, notes = 1.0, list[str]()
    for line, tokens in rows(path, limits, "TUM", COLUMNS, SYNONYMS):
        if not stamps:
            per_second, notes = fields.time_unit(tokens[0], line, "TUM")
        stamps.append(stamp_ns(tokens[0], line, "TUM", per_second))
        numbers = fields.numbers(tokens[1:], line, "TUM")
        place, rotation = numbers[:3], numbers[3:]
        if not all(math.isfinite(value) and abs(value) <= FARTHEST_M for value in place):
            raise ReadError(
                "trajectory.pose",
                f"Line {line}: the position {', '.join(f'{value:g}' for value in place)} must be "
                f"finite and within {FARTHEST_M:g} m.",
            )
        if values and not all(abs(a - b) <= limits.max_pose for a, b in zip(place, values[:3], strict=True)):
            raise ReadError(
                "trajectory.pose",
                f"Line {line}: the position {', '.join(f'{value:g}' for value in place)} is more than "
                f"{limits.max_pose:g} m from the first.",
            )
        norm = math.hypot(*rotation)
        if not abs(norm - 1.0) <= NORM_TOLERANCE:
            raise ReadError(
                "trajectory.rotation",
                f"Line {line}: the quaternion {', '.join(f'{value:g}' for value in rotation)} is not a rotation: its "
                f"length is {norm:.3g}, not 1.",
            )
        values.extend([*place, *(value / norm for value in rotation)])
    if not stamps:
        raise ReadError("trajectory.empty", f"The file holds no poses, lines of {COLUMNS}.")
    return np.array(stamps, dtype=np.int64), np.array(values).reshape(-1, 7), notes


def _notes_on_space(poses: Poses3) -> list[str]:
    height = float(np.ptp(poses.positions[:, 2]))
    tilt = float(np.arccos(np.clip(poses.up, -1.0, 1.0)).max())
    if height <= FLAT_M and tilt <= FLAT_RAD:
        return []
    seen = f"heights differ by {height:.2f} m and it tilts by up to {math.degrees(tilt):.0f}°"
    return [f"The trajectory is not planar: {seen}. It is taken as seen from above."]


def _notes_on_time(stamps_ns: np.ndarray[tuple[int], np.dtype[np.int64]]) -> list[str]:
    steps = np.diff(stamps_ns)
    backwards, repeated = int(np.count_nonzero(steps < 0)), int(np.count_nonzero(steps == 0))
    if not backwards and not repeated:
        return []
    return [f"Of {len(stamps_ns)} stamps {backwards} are earlier than the one before, and {repeated} equal to it."]
