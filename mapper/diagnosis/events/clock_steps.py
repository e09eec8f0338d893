"""When the clock of a log was set: stamps that jump back, and stamps that jump ahead while the robot did not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
from mapper.sensors.scan import ScanLog

LEAST_BACK = 2.0  #: usual intervals: stamps that jump back by less are out of order, as where two threads write
LEAST_AHEAD_S = 0.5  #: seconds, and five usual intervals
AHEAD = 5.0
AROUND = 5  #: steps before and after, whose speed is compared
LEAST_SPEED = 0.05  #: m/s, a radian counting 0.3 m: a robot that stands does not tell how long it stood
SAME_SPEED = 2.0  #: the factor within which the speeds before and after must agree
REGULAR = 0.8  #: share of the intervals within a quarter of the usual one: of a log that is recorded by time
SHORT = 0.3  #: share of the way at that speed, below which the time did not pass
MARGIN_S = 0.3  #: seconds beside times that come twice: of the poses between which those at the scans lie
MOST = 20


@dataclass(frozen=True, slots=True)
class ClockStep:
    """The clock was set by ``step_s`` seconds between the scans ``scan`` and ``scan`` + 1."""

    scan: int
    step_s: float


def usual_interval(log: ScanLog) -> float:
    """Return the median time from scan to scan, seconds; 0 for a log without times."""
    steps = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def clock_steps(log: ScanLog, trajectory: str | None) -> list[ClockStep]:
    """Return when the clock was set, in the order of the scans.

    A jump back is one, if the stamps go on from there as usual. A jump ahead is one in a log that is recorded by time,
    where the robot drove at about one speed before and after it and came no farther than it does in a usual interval:
    else the recording has a gap, or the robot stood.
    """
    steps = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    forward = steps[steps > 0.0]
    if len(forward) < 2 * AROUND:
        return []
    usual = usual_interval(log)
    driven = None
    if trajectory is not None:
        poses = log.trajectory(trajectory).poses
        moved = compose(inverse(poses[:-1]), poses[1:])
        driven = np.hypot(moved[:, 0], moved[:, 1]) + 0.3 * np.abs(moved[:, 2])
    clock_changes = []
    for k in np.flatnonzero(steps < -LEAST_BACK * usual).tolist():
        after = steps[k + 1 : k + 1 + AROUND]
        if len(after) and (after > 0.0).all():  # else stamps are out of order, and no clock was set
            clock_changes.append(ClockStep(k, float(steps[k]) - usual))
    is_regular = float(np.mean(np.abs(steps / usual - 1.0) < 0.25)) > REGULAR
    if driven is not None and is_regular:
        jumps = np.flatnonzero(steps > max(LEAST_AHEAD_S, AHEAD * usual)).tolist()
        clock_changes += [
            ClockStep(k, float(steps[k]) - usual) for k in jumps if _did_not_pass(steps, driven, usual, k)
        ]
    return sorted(clock_changes, key=lambda step: step.scan)[:MOST]


def near_clock_steps(log: ScanLog, steps: list[ClockStep]) -> NDArray[np.bool_]:
    """Return for the step from each scan to the next, (n - 1,), whether the clock leaves open when it was.

    After a jump back some times come twice, and the poses at them may be those of either time.
    """
    stamps = log.stamps_ns.astype(np.float64) * 1e-9
    near = np.zeros(max(0, log.n_scans - 1), dtype=np.bool_)
    for step in steps:
        low, high = sorted((stamps[step.scan], stamps[step.scan + 1]))
        twice = (
            (stamps > low - MARGIN_S) & (stamps < high + MARGIN_S) if step.step_s < 0.0 else np.zeros(len(stamps), bool)
        )
        twice[step.scan : step.scan + 2] = True
        near |= twice[1:] | twice[:-1]
    return near


def _did_not_pass(steps: Float64Array, driven: Float64Array, usual: float, k: int) -> bool:
    """Return whether the robot, which drove on at one speed, came no farther in the step than in a usual one."""
    around = [slice(max(0, k - AROUND), k), slice(k + 1, k + 1 + AROUND)]
    speeds = []
    for part in around:
        if len(steps[part]) < AROUND or (steps[part] <= 0.0).any():
            return False
        speeds.append(float(driven[part].sum() / steps[part].sum()))
    slow, fast = sorted(speeds)
    if slow < LEAST_SPEED or fast > SAME_SPEED * slow:
        return False
    # Whether the poses were stamped by the same clock: then the way of this step is that of a usual interval.
    return bool(driven[k] <= max(SHORT * slow * steps[k], SAME_SPEED * fast * usual)) and slow * steps[k] > 0.1
