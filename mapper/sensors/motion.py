"""Interpolation between the poses of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.sensors.joint_log import JointLog, each_part
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses, number_before, poses_at, poses_between

DENSE_S = 0.5  #: seconds: poses at most this far apart determine the motion between them


@dataclass(frozen=True, slots=True)
class Motion:
    """The poses of one trajectory in time order.

    ``times`` (m,) float64 seconds, ascending; ``poses`` (m, 3) ``T_frame_base``, metres and radians.
    """

    times: Float64Array
    poses: Float64Array

    @classmethod
    def of(cls, log: ScanLog, trajectory: str | None = None) -> Motion:
        """Return the motion along a trajectory (None: the default).

        It uses the poses with their own stamps if the trajectory has them, otherwise the known poses at the scans'
        stamps. Poses are sorted if stamps run backwards. Raises :class:`ConfigError` for a trajectory that the log
        lacks.
        """
        chosen, stamps = log.trajectory(trajectory), log.stamps_ns
        if chosen.is_known is not None and chosen.is_known.any():
            chosen, stamps = chosen.take(chosen.is_known), stamps[chosen.is_known]
        timed = chosen.timed if chosen.timed is not None and len(chosen.timed) else TimedPoses(stamps, chosen.poses)
        timed = timed.in_order()
        return cls(timed.stamps_ns.astype(np.float64) * 1e-9, timed.poses)

    def at(self, times: Float64Array) -> Float64Array:
        """Return the poses (..., 3) at ``times`` (...), seconds, like :func:`mapper.sensors.timed_poses.poses_at`."""
        return poses_at(self.times, self.poses, times)

    def along(self, sweeps: Float64Array) -> Float64Array:
        """Return :meth:`at` for the times ``sweeps`` (n, b), seconds, faster if each row is monotonic."""
        low = number_before(self.times, sweeps[:, 0])
        poses = poses_between(self.times, self.poses, low[:, np.newaxis], sweeps)
        others = low != number_before(self.times, sweeps[:, -1])  # sweeps that contain a pose
        if others.any():
            poses[others] = self.at(sweeps[others])
        return poses

    def covers(self, times: Float64Array) -> NDArray[np.bool_]:
        """Return whether ``times`` (...), seconds, are between the first and the last pose."""
        return np.asarray((times >= self.times[0]) & (times <= self.times[-1]))

    def is_dense(self, first: Float64Array, last: Float64Array) -> NDArray[np.bool_]:
        """Return whether the poses are dense around each span from ``first`` to ``last`` (n,), seconds.

        They are if there is a pose at or before the span and one at or after it, at most :data:`DENSE_S` apart.
        """
        low = np.searchsorted(self.times, np.minimum(first, last), side="right") - 1
        high = np.searchsorted(self.times, np.maximum(first, last), side="left")
        inside = (low >= 0) & (high < len(self.times))
        low, high = np.clip(low, 0, None), np.clip(high, None, len(self.times) - 1)
        return np.asarray(inside & (self.times[high] - self.times[low] <= DENSE_S))


def seconds(log: ScanLog) -> Float64Array:
    """Return the stamps of the scans (n_scans,) in seconds."""
    return log.stamps_ns.astype(np.float64) * 1e-9


def at_middle_of_sweep(log: ScanLog, trajectory: str | None = None, time_offset: float = 0.0) -> ScanLog:
    """Return the log with one trajectory, with each scan at the robot's pose in the middle of its sweep.

    This is the best single pose for a scan whose beams cannot be deskewed, and is used to assess a log by few of its
    scans. Scans without dense poses around their sweep (:meth:`Motion.is_dense`) keep the pose at their stamp.
    ``time_offset`` seconds are added to the stamps to look up the poses; scans that the trajectory then does not cover,
    or whose pose is unknown, are NaN. The returned log has no time increment. For several sensors each is processed in
    this way.
    """
    name = trajectory or log.default_trajectory
    if isinstance(log, JointLog):
        return each_part(log, lambda part: at_middle_of_sweep(part, name, time_offset))
    moved = log.trajectory(name)
    time_offset = moved.offset_of_stamps(time_offset)
    times, sweep, ranges = seconds(log) + time_offset, 0.0, log.ranges
    if log.can_deskew(name):
        sweep = (log.n_beams - 1) * log.time_increment
    if log.n_scans and (sweep or time_offset):
        motion = Motion.of(log, name)
        dense = motion.is_dense(times, times + sweep)
        moved = replace(moved, poses=motion.at(times + np.where(dense, 0.5 * sweep, 0.0)), timed=None)
        if time_offset:
            ranges = np.where(motion.covers(times)[:, np.newaxis], ranges, np.float32(np.nan))
    if moved.is_known is not None:
        ranges = np.where(moved.is_known[:, np.newaxis], ranges, np.float32(np.nan))
    return replace(log, ranges=ranges, trajectories={name: moved}, time_increment=0.0)
