"""Motion of the robot between scans: by the wheels, and by scan alignment.

Each scan is aligned with those shortly before it by SLAM's front end, starting from the motion measured by the wheels.
If a scan cannot be aligned, the next scan that can is searched for in a wide window around the last aligned one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.se2 import compose, inverse
from mapper.io.logs.summary import recorded_seconds
from mapper.matching import MatchConfig, match_scan
from mapper.matching.target import Target
from mapper.sensors.joint_log import part_of_scan, sensors_of
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.front_end import FrontEnd
from mapper.slam.odometry import motions
from mapper.slam.scan_store import ScanStore, scans_of

MOST_SCANS = 20_000  #: aligned scans; longer logs are thinned evenly, with coarser event times
ASKED_EVERY = 100  #: scans between two checks for cancellation
FITS = 0.4  #: agreement below which an alignment is not usable
WITHIN = 5  #: steps between losses that are merged into one, because some scans fit by chance
BESIDE = 2  #: scans around a loss that are not used
BEFORE = 5  #: scans before a loss with which a scan after it is compared
WINDOW_M, WINDOW_RAD = 3.0, math.pi  #: window of that search
LEAST_SCORE = 0.55  #: of its pose
MOST_LOSSES = 40  #: losses examined; a log with more of them does not show one place
SAME_PLACE_M, SAME_PLACE_RAD = 0.3, math.radians(10.0)
CLEARLY = 0.08  #: minimum difference in score to any other pose


@dataclass(frozen=True, slots=True)
class Loss:
    """Scans that cannot be aligned: ``before`` is the last aligned one, ``after`` the next one.

    ``moved`` (3,) is the motion between the two by the scans, None if undetermined.
    """

    before: int
    after: int
    moved: Float64Array | None


@dataclass(frozen=True, slots=True)
class Motions:
    """Motions of the base between n consecutive scans, (n − 1, 3), ``T_before_after``, metres and radians.

    ``scans`` (n,) are the indices of the scans in the log, ``seconds`` (n,) their recorded time. For steps within a
    loss ``by_scans`` is the wheels' motion.
    """

    scans: NDArray[np.int64]
    seconds: Float64Array
    by_wheels: Float64Array
    by_scans: Float64Array
    losses: tuple[Loss, ...]


def aligned_motions(
    log: ScanLog, wheels: str, may_continue: Callable[[], bool], progress: Callable[[float], None] | None = None
) -> Motions:
    """Return the motions of a lidar's log along its trajectory ``wheels`` and by scan alignment.

    Raises :class:`WorkCancelledError` if ``may_continue`` returns False, and :class:`ConfigError` for a sonar.
    """
    seconds = recorded_seconds(log)
    numbers = np.unique(np.linspace(0, log.n_scans - 1, min(log.n_scans, MOST_SCANS)).astype(np.int64))
    some = at_middle_of_sweep(log, wheels).take(numbers)
    seconds, by_wheels = seconds[numbers], motions(some.trajectory().poses)
    config = SlamConfig()
    front = FrontEnd(ScanStore(sensors_of(some), config.range_max, int(config.n_beams)), config)
    parts = part_of_scan(some).tolist()
    by_scans = by_wheels.copy()
    fits = np.ones(len(by_wheels), dtype=np.bool_)
    for k in range(some.n_scans):
        if k % ASKED_EVERY == 0:
            if not may_continue():
                raise WorkCancelledError("doctor.unwanted", "The examination was cancelled: its session has ended.")
            if progress is not None:
                progress(k / some.n_scans)
        passed = float(seconds[k] - seconds[k - 1]) if k else 0.0
        step = front.add(
            some.ranges[k], by_wheels[k - 1] if k else None, sensor=parts[k],
            seconds=passed if passed > 0.0 else None, mount=some.mount_of(k),
        )  # fmt: skip
        if k:
            fits[k - 1] = step.is_aligned and step.agreement >= FITS
            by_scans[k - 1] = step.relative
    by_scans[~fits] = by_wheels[~fits]
    losses = []
    for before, after in _runs(~fits)[:MOST_LOSSES]:
        losses.append(Loss(before, after, _found_again(some, before, after)))
        by_scans[before:after] = by_wheels[before:after]
    return Motions(numbers, seconds, by_wheels, by_scans, tuple(losses))


def _runs(lost: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the scans before and after each run of lost steps, merged over short interruptions."""
    steps = np.flatnonzero(lost)
    if not len(steps):
        return []
    ends = np.flatnonzero(np.diff(steps) > WITHIN)
    firsts = steps[np.concatenate([[0], ends + 1])]
    lasts = steps[np.concatenate([ends, [len(steps) - 1]])]
    return [(int(first), int(last) + 1) for first, last in zip(firsts, lasts, strict=True)]


def _found_again(log: ScanLog, before: int, after: int) -> Float64Array | None:
    """Return the motion from scan ``before`` to ``after``, searched in a wide window; None if there is no unique
    pose.
    """
    poses = log.trajectory().poses
    # The last scan before and the first after may be from a slightly tilted robot, and fit by chance.
    last = max(0, before - BESIDE)
    first, source = max(0, last - BEFORE + 1), min(after + BESIDE, log.n_scans - 1)
    near = np.arange(first, last + 1)
    moved = compose(inverse(poses[before]), poses[source])
    guess = moved if math.hypot(moved[0], moved[1]) < WINDOW_M else np.zeros(3)
    try:
        target = Target(
            scans_of(log, near.tolist()), np.arange(len(near)), compose(inverse(poses[before]), poses[near])
        )
        match = match_scan(
            scans_of(log, [source]), 0, target, guess,
            replace(MatchConfig(), window_m=WINDOW_M, window_rad=WINDOW_RAD),
        )  # fmt: skip
    except (ConfigError, LimitError):
        return None
    off = compose(inverse(match.pose), match.candidates)
    other = (np.hypot(off[:, 0], off[:, 1]) > SAME_PLACE_M) | (np.abs(off[:, 2]) > SAME_PLACE_RAD)
    next_best = float(match.scores[other].max(initial=0.0))
    if match.score < LEAST_SCORE or match.is_degenerate or next_best > match.score - CLEARLY:
        return None
    return compose(match.pose, compose(inverse(poses[source]), poses[after]))
