"""Gaps of a recording: no scans arrived while the robot drove on.

Many logs hold a scan for each half metre of the robot's path rather than for each tenth of a second. Their intervals
are uneven, and long when the robot was at rest, so the path is considered in addition to the time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import wrap_angle
from mapper.sensors.scan import ScanLog

GAP_S, USUAL_INTERVALS = 2.0, 5.0  #: minimum length of a gap, both required, the second in usual intervals
TURN_M = 0.3  #: metres of path per radian of turn
MOVED_M = 0.02  #: metres of path above which a robot moved
CLOCK_SET_S = 86_400.0  #: a jump of the stamps that is no pause of a robot, however little it moved
FARTHER = 1.5  #: times nearly the longest usual path, above which the robot moved during a gap


def driven_ways(log: ScanLog, trajectory: str | None) -> Float64Array | None:
    """Return the robot's path length (n - 1,) between scans, metres, including turns; None without poses."""
    along = log.trajectory(trajectory)
    moved = np.diff(along.poses, axis=0)
    driven = np.hypot(moved[:, 0], moved[:, 1]) + TURN_M * np.abs(wrap_angle(moved[:, 2]))
    return None if along.is_placeholder or not (driven > MOVED_M).any() else driven


def least_gap_s(steps: Float64Array) -> float:
    """Return the minimum interval in seconds for a gap; ``steps`` (n,) are all intervals, some greater than 0."""
    return max(GAP_S, USUAL_INTERVALS * float(np.median(steps[steps > 0.0])))


def recording_gaps(steps: Float64Array, driven: Float64Array | None) -> NDArray[np.bool_]:
    """Return which of the intervals ``steps`` (n,), seconds, are gaps; ``driven`` (n,) is the path length in each,
    metres.
    """
    if not (steps > 0.0).any():
        return np.zeros(len(steps), dtype=np.bool_)
    gap: NDArray[np.bool_] = steps > least_gap_s(steps)
    if driven is not None and (~gap).any():
        # A robot at rest, or with scans recorded by distance, has missed nothing.
        gap &= (driven > max(MOVED_M, FARTHER * float(np.quantile(driven[~gap], 0.95)))) | (steps > CLOCK_SET_S)
    return gap
