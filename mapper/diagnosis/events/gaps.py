"""When a recording has a gap: no scan came, and the robot drove on meanwhile.

Many logs hold a scan for each half metre of the robot's way rather than for each tenth of a second. Their intervals are
uneven, and long where the robot stood: so the way beside the time decides whether something is missing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import wrap_angle
from mapper.sensors.scan import ScanLog

GAP_S, USUAL_INTERVALS = 2.0, 5.0  #: a gap is longer than both, the second in usual intervals
TURN_M = 0.3  #: metres of way that a turn by one radian counts
MOVED_M = 0.02  #: of way, from which a robot moved
CLOCK_SET_S = 86_400.0  #: a jump of the stamps that is no pause of a robot, however little it moved
FARTHER = 1.5  #: times nearly the longest usual way, from which the robot moved during a gap


def driven_ways(log: ScanLog, trajectory: str | None) -> Float64Array | None:
    """Return the robot's way (n - 1,) from scan to scan, metres, with its turns; None where no poses tell it."""
    along = log.trajectory(trajectory)
    moved = np.diff(along.poses, axis=0)
    driven = np.hypot(moved[:, 0], moved[:, 1]) + TURN_M * np.abs(wrap_angle(moved[:, 2]))
    return None if along.is_placeholder or not (driven > MOVED_M).any() else driven


def least_gap_s(steps: Float64Array) -> float:
    """Return the seconds from which an interval can be a gap; ``steps`` (n,) are all intervals, some greater than 0."""
    return max(GAP_S, USUAL_INTERVALS * float(np.median(steps[steps > 0.0])))


def recording_gaps(steps: Float64Array, driven: Float64Array | None) -> NDArray[np.bool_]:
    """Return which of the intervals ``steps`` (n,), seconds, are gaps; ``driven`` (n,) is the way in each, metres."""
    if not (steps > 0.0).any():
        return np.zeros(len(steps), dtype=np.bool_)
    gap: NDArray[np.bool_] = steps > least_gap_s(steps)
    if driven is not None and (~gap).any():
        # A robot that stood, or whose scans are recorded by distance, has missed nothing.
        gap &= (driven > max(MOVED_M, FARTHER * float(np.quantile(driven[~gap], 0.95)))) | (steps > CLOCK_SET_S)
    return gap
