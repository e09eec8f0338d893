"""Clock steps of a log: stamps that jump back, and stamps that jump ahead while the robot's motion does not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
from mapper.sensors.scan import ScanLog

LEAST_BACK = 2.0  #: usual intervals: stamps that jump back by less are out of order, as with two writing threads
LEAST_AHEAD_S = 0.5  #: seconds, and five usual intervals
AHEAD = 5.0
AROUND = 5  #: steps before and after whose speeds are compared
LEAST_SPEED = 0.05  #: m/s, a radian counting as 0.3 m: a robot at rest does not tell how long it rested
SAME_SPEED = 2.0  #: maximum ratio of the speeds before and after
REGULAR = 0.8  #: fraction of the intervals within a quarter of the usual one in a log recorded by time
SHORT = 0.3  #: fraction of the path expected at that speed, below which the time did not pass
MARGIN_S = 0.3  #: seconds around times that occur twice, in which poses may have been interpolated between either
MOST = 20


@dataclass(frozen=True, slots=True)
class ClockStep:
    """The clock was set by ``step_s`` seconds between the scans ``scan`` and ``scan`` + 1."""

    scan: int
    step_s: float


def usual_interval(log: ScanLog) -> float:
    """Return the median scan interval, seconds; 0 for a log without times."""
    steps = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def clock_steps(log: ScanLog, trajectory: str | None) -> list[ClockStep]:
    """Return the clock steps in scan order.

    A jump back is a clock step if the stamps continue as usual afterwards. A jump ahead is one if the log is recorded
    by time, the robot drove at a similar speed before and after it, and came no farther than in a usual interval.
    Otherwise the recording has a gap, or the robot was at rest.
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
        if len(after) and (after > 0.0).all():  # otherwise stamps are out of order, and no clock was set
            clock_changes.append(ClockStep(k, float(steps[k]) - usual))
    is_regular = float(np.mean(np.abs(steps / usual - 1.0) < 0.25)) > REGULAR
    if driven is not None and is_regular:
        jumps = np.flatnonzero(steps > max(LEAST_AHEAD_S, AHEAD * usual)).tolist()
        clock_changes += [
            ClockStep(k, float(steps[k]) - usual) for k in jumps if _did_not_pass(steps, driven, usual, k)
        ]
    return sorted(clock_changes, key=lambda step: step.scan)[:MOST]


def near_clock_steps(log: ScanLog, steps: list[ClockStep]) -> NDArray[np.bool_]:
    """Return for the step from each scan to the next, (n - 1,), whether its time is ambiguous because of a clock step.

    After a jump back some times occur twice, and the poses at them may belong to either.
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
    """Return whether the robot, driving at constant speed, came no farther in the step than in a usual one."""
    around = [slice(max(0, k - AROUND), k), slice(k + 1, k + 1 + AROUND)]
    speeds = []
    for part in around:
        if len(steps[part]) < AROUND or (steps[part] <= 0.0).any():
            return False
        speeds.append(float(driven[part].sum() / steps[part].sum()))
    slow, fast = sorted(speeds)
    if slow < LEAST_SPEED or fast > SAME_SPEED * slow:
        return False
    # If the poses were stamped by the same clock, the path of this step is that of a usual interval.
    return bool(driven[k] <= max(SHORT * slow * steps[k], SAME_SPEED * fast * usual)) and slow * steps[k] > 0.1
