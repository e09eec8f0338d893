"""A trajectory from another program at every scan of a log, which stays whole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.io.trajectories.joining import is_scan_by_scan, time_error
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses


def poses_at_all_scans(log: ScanLog, poses: TimedPoses) -> tuple[NDArray[np.float64], list[str]]:
    """Return ``poses`` at every scan of ``log`` (n_scans, 3), m and rad, in their own frame, and what is to be noted.

    Poses as many as the scans and with their stamps are taken scan by scan, others are interpolated, as
    :func:`mapper.io.trajectories.with_trajectory` does. Scans before the first or after the last pose continue the
    trajectory as the log's own poses move there: the transform between the two frames (map → odom of REP 105) stays
    what it is at the nearest scan that has a pose.

    Raises :class:`ConfigError` where no scan lies within the poses' time, and where some lie outside of it and the log
    has no poses of its own.
    """
    if is_scan_by_scan(log, poses):
        return poses.poses, []
    inside = poses.covers(log.stamps_ns)
    outside = int(np.count_nonzero(~inside))
    if outside == log.n_scans:
        raise time_error(log, poses)
    at_scans = poses.at(log.stamps_ns)
    if not outside:
        return at_scans, []
    own = next((one.poses for one in log.trajectories.values() if not one.is_placeholder), None)
    if own is None:
        raise ConfigError(
            "trajectory.outside",
            f"{outside} of the {log.n_scans} scans lie before the first or after the last pose of the trajectory, and "
            "the log has no poses of its own with which it could be continued there.",
        )
    covered = np.flatnonzero(inside)
    first, last = (int(covered[choose(log.stamps_ns[covered])]) for choose in (np.argmin, np.argmax))
    before = log.stamps_ns < poses.stamps_ns.min()
    for scans, nearest in ((before, first), (~inside & ~before, last)):
        t_map_odom = compose(at_scans[nearest], inverse(own[nearest]))
        at_scans[scans] = compose(t_map_odom, own[scans])
    are = "1 scan lies" if outside == 1 else f"{outside} scans lie"
    return at_scans, [f"{are} before the first or after the last pose: the log's own poses continue the trajectory."]
