"""The motion of the robot from scan to scan: by the wheels, and by the scans themselves.

The scans are aligned one after another with those shortly before them, by SLAM's front end, which begins at the motion
that the wheels measured. Where a scan fits those before it nowhere near, the first scan after that fits again is looked
for in a wide window around the last one before.
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

MOST_SCANS = 20_000  #: that are aligned; longer logs are thinned evenly, and their events timed less finely
ASKED_EVERY = 100  #: scans between two questions whether the work is still wanted
FITS = 0.4  #: agreement of an alignment below which it says nothing of the motion
WITHIN = 5  #: steps from one that is lost to the next, up to which they are one loss: some scans fit by chance
BESIDE = 2  #: scans beside a loss that are not used
BEFORE = 5  #: scans that a scan after a loss is compared with
WINDOW_M, WINDOW_RAD = 3.0, math.pi  #: in which it is looked for
LEAST_SCORE = 0.55  #: of its place
MOST_LOSSES = 40  #: that are looked at; a log with more of them is no log of one place
SAME_PLACE_M, SAME_PLACE_RAD = 0.3, math.radians(10.0)
CLEARLY = 0.08  #: by how much the score of the place must exceed that of any other


@dataclass(frozen=True, slots=True)
class Loss:
    """Scans that fit nothing: ``before`` is the last one that does, ``after`` the first one that does again.

    ``moved`` (3,) is the motion from the one to the other by the scans, None where they do not tell it.
    """

    before: int
    after: int
    moved: Float64Array | None


@dataclass(frozen=True, slots=True)
class Motions:
    """Motions of the base from each of n scans to the next, (n − 1, 3), ``T_before_after``, metres and radians.

    ``scans`` (n,) are the numbers of the scans in the log, ``seconds`` (n,) their recorded time. Of steps within a
    loss ``by_scans`` is that by the wheels.
    """

    scans: NDArray[np.int64]
    seconds: Float64Array
    by_wheels: Float64Array
    by_scans: Float64Array
    losses: tuple[Loss, ...]


def aligned_motions(
    log: ScanLog, wheels: str, may_continue: Callable[[], bool], progress: Callable[[float], None] | None = None
) -> Motions:
    """Return the motions of a lidar's log along its trajectory ``wheels`` and by its scans.

    Raises :class:`WorkCancelledError` where ``may_continue`` returns False, and :class:`ConfigError` for a sonar.
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
    """Return the scans before and after each run of steps that are lost, with the few steps between two of them."""
    steps = np.flatnonzero(lost)
    if not len(steps):
        return []
    ends = np.flatnonzero(np.diff(steps) > WITHIN)
    firsts = steps[np.concatenate([[0], ends + 1])]
    lasts = steps[np.concatenate([ends, [len(steps) - 1]])]
    return [(int(first), int(last) + 1) for first, last in zip(firsts, lasts, strict=True)]


def _found_again(log: ScanLog, before: int, after: int) -> Float64Array | None:
    """Return the motion from scan ``before`` to ``after``, found in a wide window; None where no one place fits."""
    poses = log.trajectory().poses
    # The last scan before and the first after may be of a robot that was tilted a little already, and fit by chance.
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
