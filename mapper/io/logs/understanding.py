"""What no single message of a log can say: whether its sweeps are possible, and whether it measured anything.

It is asked of every log once it is read, whatever its format, so that one rule and one sentence serve all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.io.logs.no_return import code_for_no_return, without_code
from mapper.io.logs.pose_clocks import pose_clock
from mapper.io.logs.sweeps import Sweep, contradicted_sweep
from mapper.io.logs.text.packing import note_on_largest_reading
from mapper.sensors.joint_log import each_part, is_measured, sensors_of, with_notes, without_notes
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from mapper.sensors.sparse_poses import ADVICE, sparse_turns

JITTER = 1.25  #: a sweep may last so much longer than the time between scans, or than the stated one
LEAST_SCANS = 3  #: fewer tell nothing of the time between them
FARTHEST_USUAL_M = 300.0  #: the usual reading of no lidar that drives: those of the longest range see so far at most
ENOUGH_READINGS = 100_000
FASTEST_USUAL = 60.0  #: m/s, of what drives with a lidar
MOST_EXCLUDED = 0.5  #: of the readings: where a limit excludes more, and none counts, that is the reason
PAUSE = 5.0  #: usual intervals: longer times between scans are pauses


def understood(robot: RobotLog) -> RobotLog:
    """Return a log whose readings are distances, and whose sweeps fit them, with notes on what these lack."""
    sensors = {name: _understood(log) for name, log in robot.sensors.items()}
    return replace(robot, sensors=sensors)


def _understood(log: ScanLog) -> ScanLog:
    log = _with_no_return(log)
    period = time_between_scans(log.stamps_ns)
    why = [impossible_sweep(part, period) for part in sensors_of(log)]
    if any(why):
        log = each_part(log, lambda part: _at_once(part) if impossible_sweep(part, period) else part)
    contradicted = contradicted_sweep(_longest(log), period)
    if contradicted is not None:
        # What is impossible is not used then, but neither are the beams measured at once, as that note says.
        log, why = each_part(log, lambda part: _as_swept(part, contradicted)), [contradicted.why]
    reason = next(filter(None, why[::-1]), "")
    if reason:
        log = each_part(log, lambda part: replace(part, wrong_sweep=reason))
    log, late = _by_one_clock(log)
    why += late
    return with_notes(
        log, [*dict.fromkeys(filter(None, why)), *_notes_on_readings(log), *_notes_on_speed(log), *_notes_on_turns(log)]
    )


def _usual_reading(log: ScanLog) -> float:
    """Return the median of the different readings that are distances, metres, in range or not; 0 without.

    A number that stands for no return is one of them. Of a long log only some of the scans are looked at.
    """
    some = log.ranges[:: 1 + log.ranges.size // ENOUGH_READINGS]
    readings = some[np.isfinite(some) & (some > 0.0)]
    return float(np.median(np.unique(readings))) if len(readings) else 0.0


def _with_no_return(log: ScanLog) -> ScanLog:
    """Return the log without the distance that its sensor reads where nothing returns, and a note on it."""
    code = code_for_no_return(_longest(log))
    if code is None:
        return log
    n = int(np.count_nonzero(log.ranges == np.float32(code)))
    note = (
        f"{n} readings ({100.0 * n / log.ranges.size:.1f} %) are exactly {code:.4g} m, the greatest there is, and "
        "neighbouring beams read it over wider angles than any wall looks so from several places: they say that "
        "nothing returned, and count as no return, not as a wall."
    )
    log = without_notes(log, note_on_largest_reading(log.ranges))
    return with_notes(each_part(log, lambda part: without_code(part, code)), [note])


def _longest(log: ScanLog) -> ScanLog:
    return max(sensors_of(log), key=lambda part: part.n_scans)


def _by_one_clock(log: ScanLog) -> tuple[ScanLog, list[str]]:
    """Return the log with the poses of each source by the clock of the scans, and notes on those that were not."""
    longest = _longest(log)
    clocks = {name: pose_clock(longest, name) for name in longest.trajectories}
    known = {name: clock for name, clock in clocks.items() if clock is not None}
    if not known:
        return log, []

    def corrected(part: ScanLog) -> ScanLog:
        return replace(part, trajectories={**part.trajectories, **{n: c.corrected(part, n) for n, c in known.items()}})

    notes = list(dict.fromkeys(clock.why for clock in known.values()))
    return each_part(log, lambda part: replace(corrected(part), wrong_clock=notes[0])), notes


def _as_swept(log: ScanLog, sweep: Sweep) -> ScanLog:
    if sweep.reversed:
        return _reversed(log)
    if sweep.time_increment < 0.0:  # in the other order, of which nothing was stated
        return _reversed(replace(log, time_increment=-sweep.time_increment))
    return replace(log, time_increment=sweep.time_increment)


def _at_once(log: ScanLog) -> ScanLog:
    return replace(log, time_increment=0.0)


def _reversed(log: ScanLog) -> ScanLog:
    """Return the log with the last beam of each scan measured first, or the first where they were in that order.

    The beams are in the order in which they were measured then; the stamp is when the first of them was.
    """
    if log.time_increment <= 0.0:
        return replace(log, time_increment=-log.time_increment)
    return replace(
        log,
        ranges=np.ascontiguousarray(log.ranges[:, ::-1]),
        angle_min=log.angle_min + log.angle_increment * (log.n_beams - 1),
        angle_increment=-log.angle_increment,
        bearings=None if log.bearings is None else log.bearings[::-1],
    )


def time_between_scans(stamps_ns: NDArray[np.int64]) -> float:
    """Return the usual time from one scan to the next, seconds; 0 where the stamps (n,) do not tell it.

    It is the median or, where scans come in bursts, their mean without pauses.
    """
    steps = np.diff(stamps_ns.astype(np.float64)) * 1e-9
    steps = steps[steps > 0.0]
    if len(steps) < LEAST_SCANS - 1:
        return 0.0
    usual = float(np.median(steps))
    return max(usual, float(np.mean(steps[steps <= PAUSE * usual])))


def impossible_sweep(log: ScanLog, period: float) -> str:
    """Return why the beams of a scan cannot have been measured at the times that are stated; nothing if they can.

    ``period`` is the usual time between scans, seconds, 0 if unknown. A sweep ends before the next one begins, and
    before the stated ``scan_time`` has passed.
    """
    sweep = abs(log.time_increment) * max(0, log.n_beams - 1)
    stated = f"A sweep of {log.n_beams} beams takes {sweep:.3g} s by the stated time_increment"
    so = "the time_increment is not used, and the beams of a scan are taken as measured at once (deskew off)."
    if period > 0.0 and sweep > JITTER * period:
        return f"{stated}, and the scans are {period:.3g} s apart: {so}"
    if log.scan_time > 0.0 and sweep > JITTER * log.scan_time:
        return f"{stated}, and the stated scan_time is {log.scan_time:.3g} s: {so}"
    return ""


def _notes_on_speed(log: ScanLog) -> list[str]:
    """Return a note on each trajectory by which the robot usually moves faster than robots do."""
    seconds = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    notes = []
    for name, trajectory in log.trajectories.items():
        steps = np.hypot(*np.diff(trajectory.poses[:, :2], axis=0).T)
        speeds = steps[(seconds > 0.0) & (steps > 0.0)] / seconds[(seconds > 0.0) & (steps > 0.0)]
        usual = float(np.median(speeds)) if len(speeds) >= LEAST_SCANS else 0.0
        if usual > FASTEST_USUAL:
            notes.append(
                f"By {name} the robot usually moves at {usual:,.0f} m/s: apparently its poses are in millimetres or "
                "centimetres, or the times are in another unit. They are taken for metres and seconds."
            )
    return notes


def _notes_on_turns(log: ScanLog) -> list[str]:
    found = sparse_turns(_longest(log))
    return [] if found is None else [f"{found.sentence} {ADVICE}"]


def _notes_on_readings(log: ScanLog) -> list[str]:
    usual = max(_usual_reading(part) for part in sensors_of(log))
    if usual > FARTHEST_USUAL_M:
        note = (
            f"The readings are usually {usual:,.0f} m, farther than a lidar measures: apparently they are in "
            "millimetres or centimetres. They are taken for metres, so hardly any is within the map’s max range."
        )
        return [note]
    total = no_return = 0
    outside = {"range_max": 0, "range_min": 0}  #: distances that a limit excludes
    limits = {"range_max": log.range_max, "range_min": log.range_min}
    for part in sensors_of(log):
        with np.errstate(invalid="ignore"):
            if is_measured(part).any():
                return []
            beyond = (part.ranges > part.range_max) | np.isposinf(part.ranges)
            no_return += int(np.count_nonzero(beyond))
            far = part.ranges[beyond & np.isfinite(part.ranges)]
            if len(far) and np.ptp(far) > 0.0:  # one value stands for no return
                outside["range_max"] += len(far)
            outside["range_min"] += int(np.count_nonzero((part.ranges > 0.0) & (part.ranges < part.range_min)))
        total += part.ranges.size
    if not total:
        return []
    name, excluded = max(outside.items(), key=lambda item: item[1])
    if excluded >= MOST_EXCLUDED * total:
        side = "beyond" if name == "range_max" else "below"
        note = (
            f"None of the {total} readings counts, so the map has no walls: {excluded} are {side} {name}, "
            f"{limits[name]:g} m. They are usually {usual:,.3g} m: apparently that limit is wrong, or the readings "
            "are in another unit."
        )
        return [note]
    if no_return == total:
        note = (
            f"All {total} readings are no return (infinite, or beyond range_max), so the map has no walls. Where "
            "nothing was in reach, no_return free (--no-return free) clears the cells up to the greatest range."
        )
        return [note]
    rest = f"; {no_return} are no return, with which no_return free clears cells" if no_return else ""
    note = (
        f"None of the {total} readings is a measured distance, so the map has no walls: {total - no_return} are not a "
        f"number, zero, negative, −inf or below range_min{rest}."
    )
    return [note]
