"""The stamps: jumps, duplicates, gaps, dropped scans, and an irregular rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.diagnosis.consistency import Examined
from mapper.diagnosis.finding import MOST_SCANS, Finding
from mapper.sensors.scan import ScanLog

GAP_S = 2.0  #: and at least five times the usual interval
JITTER = 0.35  #: half of the intervals differ from the usual one by more than this share of it
DROPPED_SHARE = 0.005  #: of all intervals: fewer are an accident


def _places(where: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple((np.flatnonzero(where)[:MOST_SCANS] + 1).tolist())


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times"


def check(log: ScanLog, seen: Examined) -> list[Finding]:  # noqa: ARG001 - as all checks
    """Look at the whole log's stamps; none in a log without times."""
    steps = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    if not steps.any():
        return []
    found = []
    back = steps < 0.0
    if back.any():
        found.append(
            Finding(
                "clock.backwards",
                f"The time runs backwards {_times(int(back.sum()))}, by up to {-steps.min():.2f} s.",
                "Poses are matched to scans by time: check the recorder's clock, and the map around these scans.",
                1.0,
                _places(back),
            )
        )
    same = steps == 0.0
    if same.any():
        found.append(
            Finding(
                "clock.doubled",
                f"{int(same.sum())} scan{'s have' if same.sum() > 1 else ' has'} the same time as the one before.",
                "Look whether the readings are doubled as well: then a scan was recorded twice.",
                1.0,
                _places(same),
            )
        )
    forward = steps[steps > 0.0]
    if not forward.size:
        return found
    usual = float(np.median(forward))
    gap = steps > max(GAP_S, 5.0 * usual)
    if gap.any():
        found.append(
            Finding(
                "clock.gap",
                f"Nothing was recorded for {steps.max():.1f} s"
                + (
                    f", and {_times(int(gap.sum()))} for more than {max(GAP_S, 5.0 * usual):.1f} s."
                    if gap.sum() > 1
                    else "."
                ),
                "If the robot moved meanwhile, no scan shows where to: check the map after the gap.",
                1.0,
                _places(gap),
            )
        )
    # A scan that is missing leaves an interval of two, three, ... usual ones, while the others are regular.
    ratio = steps / usual
    regular = np.abs(ratio - 1.0) < 0.25
    missing = ~gap & (ratio > 1.5) & (np.abs(ratio - np.round(ratio)) < 0.25)
    if regular.mean() > 0.6 and missing.mean() > DROPPED_SHARE:
        lost = int(np.round(ratio[missing] - 1.0).sum())
        found.append(
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
    if spread > JITTER:
        found.append(
            Finding(
                "clock.jitter",
                f"The scans come irregularly: half of the intervals differ from {usual:.3f} s by more than "
                f"{100 * spread:.0f} %.",
                "If the sensor turns evenly, the stamps are those of arrival and not of measurement.",
                0.6,
            )
        )
    return found
