"""Detection of scans taken while the robot turns between two temporally distant poses, whose poses are interpolated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.core.se2 import wrap_angle
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import number_before

APART_S = 0.3  #: between two poses: longer intervals are not turned at constant speed
TURN_RAD = np.radians(15.0)  #: between two poses
LEAST_SCANS = 3
AT_POSE = 0.02  #: fraction of the time between two poses within which a scan has the pose's position
SAME_M, SAME_RAD = 1e-3, 1e-3  #: tolerance for an interpolated pose, as opposed to one from another source


@dataclass(frozen=True, slots=True)
class SparseTurns:
    """The ``scans`` (n,) between poses ``interval`` seconds apart that differ by up to ``turn`` radians."""

    trajectory: str
    scans: Int64Array
    interval: float
    turn: float

    @property
    def sentence(self) -> str:
        """The description, without advice."""
        return (
            f"The poses of {self.trajectory} are {self.interval:.2g} s apart, and the robot turns by up to "
            f"{np.degrees(self.turn):.0f}° from one to the next: between such poses those of {len(self.scans)} scans "
            "are interpolated, as if it turned and drove evenly, so walls may be bent or double."
        )


ADVICE = "Record transforms or odometry at 10 Hz or more."


def sparse_turns(log: ScanLog, trajectory: str | None = None) -> SparseTurns | None:
    """Return the scans of a one-sensor log that lie in turns between sparse poses; None if there are hardly any.

    ``trajectory`` is a trajectory's name (None: the log's default). Only trajectories with their own stamps are
    examined.
    """
    name = trajectory or log.default_trajectory
    way = log.trajectory(name)
    if way.timed is None or len(way.timed) < 2 or not log.n_scans:
        return None
    motion, times = Motion.of(log, name), seconds(log)
    low = np.clip(number_before(motion.times, times), 0, len(motion.times) - 2)
    span = motion.times[low + 1] - motion.times[low]
    turn = np.abs(wrap_angle(motion.poses[low + 1, 2] - motion.poses[low, 2]))
    share = (times - motion.times[low]) / np.maximum(span, APART_S)
    off = np.abs(motion.at(times) - way.poses)
    off[:, 2] = np.abs(wrap_angle(off[:, 2]))
    is_interpolated = (off[:, :2] < SAME_M).all(axis=1) & (off[:, 2] < SAME_RAD)
    is_between = (share > AT_POSE) & (share < 1.0 - AT_POSE)
    scans = np.flatnonzero((span >= APART_S) & (turn >= TURN_RAD) & is_between & is_interpolated)
    if len(scans) < LEAST_SCANS:
        return None
    return SparseTurns(name, scans, float(np.median(span[scans])), float(turn[scans].max()))
