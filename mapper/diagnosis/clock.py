"""Checks of the stamps: jumps, duplicates, gaps, dropped scans, an irregular rate, and a unit below the second.

Gaps are defined in :mod:`mapper.diagnosis.events.gaps`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.time_units import UNITS
from mapper.diagnosis.consistency import Examined
from mapper.diagnosis.events.gaps import MOVED_M, driven_ways, least_gap_s, recording_gaps
from mapper.diagnosis.finding import MOST_SCANS, Finding
from mapper.sensors.scan import ScanLog

JITTER = 0.35  #: half of the intervals differ from the usual one by more than this fraction of it
DROPPED_SHARE = 0.005  #: of all intervals: fewer are accidental
REGULAR = 0.6  #: fraction of intervals within a quarter of the usual one above which double intervals are reported
#: The same if the robot does not move, or too little to tell how far it came while a scan was missing.
REGULAR_STILL = 0.8
FEWEST_MOVED = 3  #: intervals with motion needed to judge by the path
#: Fraction of the path expected at the usual speed in a longer interval, above which the robot kept driving. While
#: scans are missing a robot drives on; if scans are recorded by distance, the path per interval is constant.
DROVE_ON = 0.7
#: Correlation of the speed between consecutive intervals above which stamps are measurement times: a robot has inertia,
#: while stamps of arrival make its speed jump. It is 0.5 to 0.6 for logs recorded by distance, and 0 to 0.1 for
#: irregular stamps.
SMOOTH = 0.4


def _places(where: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple((np.flatnonzero(where)[:MOST_SCANS] + 1).tolist())


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times"


def _are_dropped(missing: NDArray[np.bool_], ratio: NDArray[np.float64], driven: NDArray[np.float64] | None) -> bool:
    """Return whether scans are missing in the intervals ``missing`` (n,), ``ratio`` (n,) times the usual one.

    If scans are recorded by time, the robot drives on while one is missing; if they are recorded by distance, a longer
    interval means a slower robot.
    """
    regular = np.abs(ratio - 1.0) < 0.25
    if missing.mean() <= DROPPED_SHARE or regular.mean() <= REGULAR:
        return False
    moved = None if driven is None else driven > MOVED_M
    if driven is None or moved is None or min((moved & missing).sum(), (moved & regular).sum()) < FEWEST_MOVED:
        return bool(regular.mean() > REGULAR_STILL)
    usual = float(np.median(driven[moved & regular]))
    return bool(np.median(driven[moved & missing] / np.round(ratio[moved & missing])) > DROVE_ON * usual)


def _speeds_are_smooth(steps: NDArray[np.float64], driven: NDArray[np.float64] | None) -> bool:
    """Return whether the robot's speed, computed with these stamps, is correlated between consecutive intervals."""
    if driven is None:
        return False
    moves = (steps > 0.0) & (driven > MOVED_M)
    both = moves[1:] & moves[:-1]
    if both.sum() < FEWEST_MOVED:
        return False
    speed = driven / np.where(steps > 0.0, steps, 1.0)
    ranks = [np.argsort(np.argsort(speeds[both])).astype(np.float64) for speeds in (speed[1:], speed[:-1])]
    first, second = (rank - rank.mean() for rank in ranks)
    return float(np.mean(first * second)) > SMOOTH * float(np.std(first) * np.std(second))


def check(log: ScanLog, seen: Examined) -> list[Finding]:
    """Check the whole log's stamps, using the robot's path; no findings for a log without times."""
    steps = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    if not steps.any():
        return []
    driven = driven_ways(log, seen.trajectory)
    findings = []
    back = steps < 0.0
    if back.any():
        findings.append(
            Finding(
                "clock.backwards",
                f"The time runs backwards {_times(int(back.sum()))}, by up to {-steps.min():.2f} s.",
                "Poses are matched to scans by time: check the recorder’s clock, and the map around these scans.",
                1.0,
                _places(back),
            )
        )
    same = steps == 0.0
    if same.any():
        findings.append(
            Finding(
                "clock.doubled",
                f"{int(same.sum())} scan{'s have' if same.sum() > 1 else ' has'} the same time as the one before.",
                "Check whether the readings are repeated too: then a scan was recorded twice.",
                1.0,
                _places(same),
            )
        )
    forward = steps[steps > 0.0]
    if not forward.size:
        return findings
    usual = float(np.median(forward))
    gap = recording_gaps(steps, driven)
    if gap.any():
        findings.append(
            Finding(
                "clock.gap",
                f"Nothing was recorded for {steps.max():.1f} s"
                + (
                    f", and {_times(int(gap.sum()))} for more than {least_gap_s(steps):.1f} s."
                    if gap.sum() > 1
                    else "."
                ),
                "If the robot moved meanwhile, no scan shows where it went: check the map after the gap.",
                1.0,
                _places(gap),
            )
        )
    # A missing scan leaves an interval of two, three, ... usual ones, while the others are regular.
    ratio = steps / usual
    missing = ~gap & (ratio > 1.5) & (np.abs(ratio - np.round(ratio)) < 0.25)
    if _are_dropped(missing, ratio, driven):
        lost = int(np.round(ratio[missing] - 1.0).sum())
        findings.append(
            Finding(
                "clock.dropped",
                f"About {lost} scans are missing: one comes every {usual:.3f} s, and {_times(int(missing.sum()))} "
                "the next was left out.",
                "The recorder or the network did not keep up: the map has less evidence there.",
                0.8,
                _places(missing),
            )
        )
    spread = float(np.median(np.abs(forward - usual))) / usual
    if spread > JITTER and not _speeds_are_smooth(steps, driven):
        findings.append(
            Finding(
                "clock.jitter",
                f"The scans come irregularly: half of the intervals differ from {usual:.3f} s by more than "
                f"{100 * spread:.0f} %.",
                "If the sensor turns evenly, the stamps are those of arrival and not of measurement.",
                0.6,
            )
        )
    return findings


RARE_S = 10.0  #: a robot that maps takes scans more often
DRIVEN_M = 1.0  #: least extent of the path; poses of a standing robot differ by noise
LEAST_STEP_M = 1e-3  #: least motion between two scans
SPEEDS = (0.01, 3.0)  #: m/s, of robots; less than a factor of 1000 apart, so that at most one unit fits


def check_unit(log: ScanLog, trajectory: str) -> list[Finding]:
    """Compare the scan interval and the robot's speed with the usual values.

    A finding requires a median interval of more than 10 s, and a median speed of the moving robot that is below 0.01
    m/s for stamps in seconds, and plausible for milli-, micro- or nanoseconds.
    """
    along = log.trajectory(trajectory)
    passed = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    step = np.hypot(*np.diff(along.poses[:, :2], axis=0).T)
    moves = (passed > 0.0) & (step > LEAST_STEP_M)
    if along.is_placeholder or not moves.any() or np.ptp(along.poses[:, :2], axis=0).max() < DRIVEN_M:
        return []
    usual = float(np.median(passed[passed > 0.0]))
    speed = float(np.median(step[moves] / passed[moves]))
    fitting = [(factor, unit) for factor, unit in UNITS if SPEEDS[0] <= speed * factor <= SPEEDS[1]]
    if usual < RARE_S or not fitting or speed >= SPEEDS[0]:
        return []
    factor, unit = fitting[0]
    return [
        Finding(
            "clock.unit",
            f"The times are likely {unit} that are read as seconds: by them one scan comes every {usual:,.0f} s, in "
            f"which the robot drives {speed * usual:.2g} m; in {unit} these are {usual / factor:.2g} s, and "
            f"{speed * factor:.2g} m/s.",
            f"Divide the log’s times by {factor:,.0f}: until then its durations, speeds and delays are wrong.",
            0.9,
        )
    ]
