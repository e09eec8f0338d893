"""Comparison of two lidars of one robot: if both see the same walls, their mounts must place them consistently.

Scans of one lidar are matched to scans of the other taken at about the same position of the robot, in the base frame. A
constant mount error results in the same correction everywhere: its ``T_base_true ∘ T_base_stated⁻¹``. Drifting poses,
different clocks and moving objects result in corrections that vary between places, which are not reported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.mounting import CHANGING
from mapper.matching import MatchConfig, match_scan
from mapper.matching.target import Target
from mapper.sensors.joint_log import SEPARATOR
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog
from mapper.slam.scan_store import scans_of

CHECK = "mount.between"
MATCHED = 32  #: scans of the second sensor that are matched, evenly spaced
NEIGHBOURS = 8  #: scans of the first sensor to which each is matched
REACH_M = 1.5  #: metres of the robot's path, a radian counting as one, within which those were taken
WINDOW_M, WINDOW_RAD = 0.8, math.radians(30.0)  #: maximum correction
LEAST_SCORE = 0.6  #: minimum score of a match
FEWEST = 6  #: minimum number of such matches
TOLERANCE_M, TOLERANCE_RAD = 0.06, math.radians(1.5)  #: around the median, within which matches agree
SHARE = 0.6  #: minimum fraction of agreeing matches
LEAST_M, LEAST_RAD = 0.05, math.radians(1.0)  #: smaller corrections are not reported
SIGNIFICANT = 4.0  #: standard errors of the median
SPOILED_BY = frozenset({CHANGING, "mount.turned", "readings.few", "timing.delay"})  #: findings on either sensor


def check_between(
    sensors: Sequence[ScanLog],
    trajectory: str | None,
    of_sensors: Sequence[Sequence[Finding]],
    may_continue: Callable[[], bool],
    time_offset: float = 0.0,
) -> list[Finding]:
    """Return a finding for each lidar of a robot whose walls disagree with those of the first lidar.

    ``of_sensors`` are the findings on each of the ``sensors``; a sensor with one of :data:`SPOILED_BY` is skipped.
    Raises :class:`WorkCancelledError` if ``may_continue`` returns False.
    """
    usable = [
        sensor
        for sensor, findings in zip(sensors, of_sensors, strict=True)
        if sensor.beam_width == 0.0
        and sensor.bearings is None
        and not SPOILED_BY & {finding.check for finding in findings}
    ]
    if len(usable) < 2:
        return []
    first = at_middle_of_sweep(usable[0], trajectory, time_offset)
    disagreements = []
    for part in usable[1:]:
        corrections = _corrections(first, at_middle_of_sweep(part, trajectory, time_offset), trajectory, may_continue)
        finding = _finding(first, part, corrections)
        if finding is not None:
            disagreements.append(finding)
    return disagreements


def _corrections(
    first: ScanLog, second: ScanLog, trajectory: str | None, may_continue: Callable[[], bool]
) -> Float64Array:
    """Return the motions (n, 3), in the base frame, that align scans of the second sensor with the first sensor."""
    config = MatchConfig(window_m=WINDOW_M, window_rad=WINDOW_RAD)
    bases, others = first.trajectory(trajectory).poses, second.trajectory(trajectory).poses
    own_driven, driven = _ways(bases, first.stamps_ns, second.stamps_ns)
    corrections = []
    chosen = np.unique(np.linspace(0, second.n_scans - 1, MATCHED).astype(np.int64))
    for k in chosen.tolist():
        if not may_continue():
            raise WorkCancelledError("doctor.unwanted", "The examination was cancelled: its session has ended.")
        near = np.flatnonzero(np.abs(own_driven - driven[k]) <= REACH_M)
        if not len(near):
            continue
        near = near[np.unique(np.linspace(0, len(near) - 1, NEIGHBOURS).astype(np.int64))]
        try:
            scans = scans_of(first, near.tolist())
            target = Target(scans, np.arange(len(near)), compose(inverse(others[k]), bases[near]))
            match = match_scan(scans_of(second, [k]), 0, target, np.zeros(3), config)
        except (ConfigError, LimitError):
            continue  # none of its points is near the other sensor's
        if match.score >= LEAST_SCORE and not match.is_degenerate:
            corrections.append(match.pose)
    return np.reshape(corrections, (-1, 3))


def _ways(
    poses: Float64Array, stamps_ns: NDArray[np.int64], wanted_ns: NDArray[np.int64]
) -> tuple[Float64Array, Float64Array]:
    """Return the path length at each pose (n,), and at other stamps; a radian counts as a metre."""
    steps = np.diff(poses, axis=0)
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]) + np.abs(wrap_angle(steps[:, 2])))])
    order = np.argsort(stamps_ns, kind="stable")
    seconds = (stamps_ns[order] - stamps_ns[order[0]]) * 1e-9
    return driven, np.interp((wanted_ns - stamps_ns[order[0]]) * 1e-9, seconds, driven[order])


def _finding(first: ScanLog, second: ScanLog, corrections: Float64Array) -> Finding | None:
    if len(corrections) < FEWEST:
        return None
    middle = np.median(corrections, axis=0)
    off = np.abs(corrections - middle)
    agree = (np.hypot(off[:, 0], off[:, 1]) <= TOLERANCE_M) & (off[:, 2] <= TOLERANCE_RAD)
    share = float(agree.mean())
    if agree.sum() < FEWEST or share < SHARE:
        return None
    middle = np.median(corrections[agree], axis=0)
    error = 1.2533 * corrections[agree].std(axis=0, ddof=1) / math.sqrt(agree.sum())  # of a median
    far, turn = math.hypot(middle[0], middle[1]), abs(float(middle[2]))
    is_moved = far > LEAST_M and far > SIGNIFICANT * math.hypot(error[0], error[1])
    is_turned = turn > LEAST_RAD and turn > SIGNIFICANT * float(error[2])
    if not (is_moved or is_turned):
        return None
    x, y, yaw = (float(value) for value in middle)
    mount = compose(middle, np.array(second.mount))
    return Finding(
        CHECK,
        f"The walls of {second.topic} and {first.topic} disagree: they fit with {second.topic} turned by "
        f"{math.degrees(yaw):+.1f}° about the robot’s centre and moved by {x:+.2f} m ahead and {y:+.2f} m to the left, "
        f"in {int(agree.sum())} of {len(corrections)} places alike.",
        f"Measure both mounts again. If that of {first.topic} is right, {second.topic} sits at {_mount(mount)}, not at "
        f"{_mount(np.array(second.mount))}.",
        min(0.97, 0.35 + 0.65 * share),
        sensor=SEPARATOR.join((first.topic, second.topic)),
    )


def _mount(mount: Float64Array) -> str:
    return f"({mount[0]:.2f} m, {mount[1]:.2f} m, {math.degrees(mount[2]):.1f}°)"
