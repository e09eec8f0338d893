"""Odometry that restarts at 0, for example after a restart of the base driver, is continued from there.

A robot that drives back to its start is not at 0 to a millimetre, and not immediately; a tracker that loses tracking
states 0 for a while and then continues where it was. For restarts of the whole recording, see
:mod:`mapper.io.logs.recording.runs`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.core.se2 import compose, wrap_angle
from mapper.io.logs.recording.pose_sources import PoseSource, StatedPoses
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.timeline import Moments

EXACT = 1e-3  #: metres and radians from 0: only restarted odometry is this near
NEAR = 0.02  #: the same, if the robot would have come there impossibly fast
LEAST_AWAY = 0.3  #: metres or radians from which it would have come
MOST_BETWEEN_S = 10.0  #: since the pose before; in a longer time it may have driven there, or a clock was set
ALIKE_M, ALIKE = 0.1, 0.1  #: metres, and relative tolerance, for distances in two scans
MOST_ALIKE = 0.7  #: fraction of agreeing distances in two scans of one place
FASTEST, FASTER = 3.0, 3.0  #: m/s and rad/s, and a factor of the 95th percentile: impossible speeds


def restarts_of(stated: StatedPoses) -> Int64Array:
    """Return the indices of the poses (n, 3) at which odometry restarts at 0; none if it also jumps otherwise."""
    poses, seconds = stated.poses, np.diff(stated.counted_ns) * 1e-9
    if len(poses) < 3:
        return np.zeros(0, dtype=np.int64)
    from_zero = np.maximum(np.hypot(poses[:, 0], poses[:, 1]), np.abs(wrap_angle(poses[:, 2])))
    steps = np.diff(poses, axis=0)
    sizes = np.maximum(np.hypot(steps[:, 0], steps[:, 1]), np.abs(wrap_angle(steps[:, 2])))
    with np.errstate(divide="ignore", invalid="ignore"):
        speeds = np.where(seconds > 0.0, sizes / seconds, 0.0)
    is_fast = speeds > max(FASTEST, FASTER * float(np.quantile(speeds, 0.95)))
    begins = (from_zero[1:] < EXACT) | (is_fast & (from_zero[1:] < NEAR))
    begins &= (from_zero[:-1] > LEAST_AWAY) & (seconds < MOST_BETWEEN_S)
    if (is_fast & (sizes > LEAST_AWAY) & ~begins).any():
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(begins) + 1


def sees_the_same(ranges: NDArray[np.float32], other: NDArray[np.float32]) -> bool:
    """Return whether two scans may be from one place, in any heading: their distances agree.

    They do not if the robot was carried back to its start, like a simulated robot that is reset.
    """
    known = [scan[np.isfinite(scan) & (scan > 0.0)] for scan in (ranges, other)]
    if min(map(len, known)) == 0:
        return False
    first, second = (np.quantile(scan, np.linspace(0.025, 0.975, 20)) for scan in known)
    return bool(np.mean(np.abs(first - second) < ALIKE_M + ALIKE * first) >= MOST_ALIKE)


def counted_on(source: PoseSource, stated: StatedPoses, restarts: Int64Array) -> PoseSource:
    """Return a source whose poses continue at the ``restarts``, the indices of poses at which they restart."""
    before, begins = stated.counted_ns[restarts - 1], stated.counted_ns[restarts]
    ends, starts = source.at(Moments(before)), source.at(Moments(begins))
    ahead = Poses3(np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]))
    frames = [ahead]
    for k in range(len(restarts)):
        ahead = ahead @ ends[k : k + 1] @ starts[k : k + 1].inverse
        frames.append(ahead)
    moved = Poses3(
        np.concatenate([frame.positions for frame in frames]), np.concatenate([frame.rotations for frame in frames])
    )

    def at(when: Moments) -> Poses3:
        number = np.searchsorted(begins, when.stamps_ns, side="right")
        following = np.minimum(number, len(begins) - 1)
        is_between = (number < len(begins)) & (when.stamps_ns > before[following])
        held = np.where(is_between, before[following], when.stamps_ns)
        return moved[number] @ source.at(Moments(held, when.positions))

    number = np.searchsorted(restarts, np.arange(len(stated.poses)), side="right")
    poses = compose(moved.planar[number], stated.poses)
    return replace(source, at=at, stated=lambda: replace(stated, poses=poses))
