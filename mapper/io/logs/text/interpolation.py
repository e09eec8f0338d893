"""Interpolation of poses from one stream of messages at the times of another: odometry at each scan.

All poses are ``T_map_base``: metres and radians; all stamps are seconds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.se2 import compose, interpolate, inverse, wrap_angle


def poses_at_scans(
    poses: Float64Array, stamps: Float64Array, before: Int64Array, scan_stamps: Float64Array
) -> Float64Array:
    """Return the pose (n, 3) at each of n scans, from m ≥ 1 messages' ``poses`` (m, 3) and ``stamps`` (m,).

    ``before`` (n,) counts the messages before each scan in the file. Recorded clocks jump backwards, so the file's
    order selects the two neighbours, and the stamps are only interpolation weights. If most scans are before the first
    or after the last message, as in a file sorted by kind, the stamps also select the neighbours. Positions are
    interpolated linearly, angles along the shorter arc; there is no extrapolation.
    """
    m = len(poses)
    after = before
    if np.count_nonzero((before > 0) & (before < m)) * 2 < len(before):
        stamps = np.maximum.accumulate(stamps)
        after = np.searchsorted(stamps, scan_stamps, side="right").astype(np.int64)
    low, high = np.clip(after - 1, 0, m - 1), np.clip(after, 0, m - 1)
    span = stamps[high] - stamps[low]
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(span > 0.0, np.clip((scan_stamps - stamps[low]) / span, 0.0, 1.0), 0.0)
    return interpolate(poses[low], poses[high], weight)


def restarts(
    poses: Float64Array, stamps: Float64Array, before: Int64Array, scan_poses: Float64Array, scan_stamps: Float64Array
) -> NDArray[np.bool_]:
    """Return which of m messages (m,) only restart the odometry from the scan before them.

    A mapper that writes a corrected log, such as gmapping, writes an odometry message with the corrected pose after
    each scan, and continues from there. Its stamp is uninitialised, so it is not the scan's.
    """
    is_restart = np.zeros(len(poses), dtype=np.bool_)
    follows = (before > 0) & (before < len(poses))
    index = before[follows]
    same_pose = np.all(np.abs(poses[index] - scan_poses[follows]) < 1e-5, axis=-1)
    is_restart[index[same_pose & (np.abs(stamps[index] - scan_stamps[follows]) > 1.0)]] = True
    return is_restart


def without_restarts(poses: Float64Array, restart: NDArray[np.bool_]) -> Float64Array:
    """Return the wheels' own odometry (m, 3), without motion at messages that are a ``restart`` (m,)."""
    steps = compose(inverse(poses[:-1]), poses[1:])
    steps[restart[1:]] = 0.0
    theta = poses[0, 2] + np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    cos, sin = np.cos(theta[:-1]), np.sin(theta[:-1])
    x = poses[0, 0] + np.concatenate([[0.0], np.cumsum(cos * steps[:, 0] - sin * steps[:, 1])])
    y = poses[0, 1] + np.concatenate([[0.0], np.cumsum(sin * steps[:, 0] + cos * steps[:, 1])])
    return np.stack([x, y, wrap_angle(theta)], axis=-1)
