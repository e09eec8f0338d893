"""Correction of a log's sensor mount and clock, as the mapping parameters do."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.se2 import compose
from mapper.sensors.joint_log import JointLog, each_part
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses

NO_MOUNT = (0.0, 0.0, 0.0)


def corrected_log(
    log: ScanLog, mount: ArrayLike = NO_MOUNT, *, turned_over: bool = False, time_offset: float = 0.0
) -> ScanLog:
    """Return the log with a corrected mount, ``T_laser_corrected`` (3,), and a corrected clock.

    ``turned_over`` flips the sensor upside down. ``time_offset`` seconds are added to the scans' stamps to look up
    their poses, like the mapping parameter of that name. Scans that a trajectory then does not cover keep its first or
    last pose, and poses estimated from the scans do not change. Mapping the result without corrections equals mapping
    ``log`` with them. For a :class:`JointLog` each sensor is corrected.
    """
    target = np.asarray(mount, dtype=np.float64)
    if not (target.any() or turned_over or time_offset):
        return log
    if isinstance(log, JointLog):
        return each_part(log, partial(corrected_log, mount=target, turned_over=turned_over, time_offset=time_offset))
    x, y, yaw = compose(log.mount, target).tolist()
    return replace(
        log,
        mount=(x, y, yaw),
        mounts=None if log.mounts is None else compose(log.mounts, target),
        upside_down=log.upside_down != turned_over,
        trajectories={name: _shifted(log, name, time_offset) for name in log.trajectories},
    )


def _shifted(log: ScanLog, name: str, time_offset: float) -> Trajectory:
    trajectory = log.trajectory(name)
    offset = trajectory.offset_of_stamps(time_offset)
    if offset == 0.0 or not log.n_scans or trajectory.is_placeholder:
        return trajectory
    poses = Motion.of(log, name).at(seconds(log) + offset)
    timed = trajectory.timed
    if timed is not None:
        timed = TimedPoses(timed.stamps_ns - round(offset * 1e9), timed.poses, timed.notes)
    return replace(trajectory, poses=poses, timed=timed)
