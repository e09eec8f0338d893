"""Whether the readings of a log contradict the times at which its beams were measured, by what its messages state.

Simulators and drivers state a ``time_increment`` of scans that were measured at once, or in another order, and none of
scans that take all of the time between two. It is asked when a log is read, so that the map is right by itself; the
doctor asks more thoroughly (:mod:`mapper.diagnosis.sweep`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mapper.io.logs.agreement import BY_M, MUCH, Agreement, fits
from mapper.sensors.planar.options import is_cut
from mapper.sensors.scan import ScanLog

LONGEST_S = 0.5  #: a turn of a lidar that is looked for
_ONLY_SO = "only so do they end, where the robot turns, on walls that other scans saw."


@dataclass(frozen=True, slots=True)
class Sweep:
    """When the beams of a scan were measured, as the readings say; ``why`` is a sentence.

    ``time_increment`` is from one beam to the next, seconds; of the other order than is stated it is ``reversed``.
    """

    why: str
    time_increment: float = 0.0
    reversed: bool = False


def contradicted_sweep(log: ScanLog, period: float) -> Sweep | None:
    """Return how the beams of a scan were measured in place of the stated times; None where that is not clear.

    Poses are those of the log's first trajectory; ``period`` is the usual time between scans, seconds, 0 if unknown.
    Each order is taken with the delay with which it fits best, so that late poses do not decide, and the stated one
    must fit clearly worse.
    """
    if log.can_deskew():
        return _contradicted(log)
    if log.time_increment == 0.0 and 0.0 < period <= LONGEST_S and not log.trajectory().is_placeholder:
        return _not_stated(log, period)
    return None


def _contradicted(log: ScanLog) -> Sweep | None:
    sweep = log.time_increment * (log.n_beams - 1)
    agreement = Agreement(log, sweep)
    if not agreement.tells or agreement.apart(log.time_increment) <= BY_M:  # nothing fits clearly better
        return None
    stated, _ = agreement.best(log.time_increment)
    at_once, _ = agreement.best(0.0)
    backwards, _ = agreement.best(-log.time_increment, sweep)
    if not fits(min(at_once, backwards), stated):
        return None
    lasts = f"A sweep of {log.n_beams} beams takes {abs(sweep):.3g} s by the stated time_increment, and their readings"
    if fits(backwards, at_once):
        begins = "last" if sweep > 0.0 else "first"
        why = (
            f"{lasts} fit together as measured in the other order, the {begins} beam first: {_ONLY_SO} They are "
            "mapped so."
        )
        return Sweep(why, -log.time_increment, reversed=True)
    return Sweep(f"{lasts} fit together as measured at once: {_ONLY_SO} The time_increment is not used (deskew off).")


def _not_stated(log: ScanLog, period: float) -> Sweep | None:
    """Return the sweep of a lidar that turns once in the time between two scans, of which the log states nothing."""
    turn = log.scan_time if 0.0 < log.scan_time <= period else period
    increment = turn * abs(log.angle_increment) / (2.0 * math.pi)
    sweep = increment * (log.n_beams - 1)
    agreement = Agreement(log, sweep)
    if not agreement.tells or agreement.apart(0.0) <= BY_M:
        return None
    at_once, _ = agreement.best(0.0)
    forwards, _ = agreement.best(increment)
    backwards, _ = agreement.best(-increment, sweep)
    if not fits(min(forwards, backwards), at_once, MUCH):
        return None
    first = "first" if forwards <= backwards else "last"
    is_of_clouds = any(topic.name == log.topic and is_cut(topic.type) for topic in log.topics)
    what = "clouds state no even times of their points" if is_of_clouds else "scans state no possible time_increment"
    why = (
        f"The {what}, and their readings fit together as measured in {sweep:.3g} s, "
        f"the {first} beam first: {_ONLY_SO} They are mapped so."
    )
    return Sweep(why, increment if first == "first" else -increment, reversed=False)
