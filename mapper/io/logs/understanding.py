"""Plausibility checks of a whole log: whether its sweeps are possible, and whether it measured anything.

They apply to every log after reading, regardless of its format, so that all use the same rules and messages.

They also detect stated beam times that the readings contradict: simulators and drivers state a ``time_increment`` for
scans that were measured at once, or in reverse order, and none for scans that take the whole time between two. The
check is made when a log is read, so that the map is correct automatically; the doctor checks more thoroughly
(:mod:`mapper.diagnosis.sweep`).

They also detect a distance that means "no return" in logs that state no such limit, because no wall can look like it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.io.logs.agreement import BY_M, MUCH, Agreement, fits
from mapper.io.logs.pose_clocks import pose_clock
from mapper.io.logs.text.packing import note_on_largest_reading
from mapper.sensors.joint_log import each_part, is_measured, sensors_of, with_notes, without_notes
from mapper.sensors.planar.options import is_cut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from mapper.sensors.sparse_poses import ADVICE, sparse_turns

JITTER = 1.25  #: tolerance factor of the sweep's duration over the time between scans, or over the stated one
LEAST_SCANS = 3  #: minimum for the time between scans
FARTHEST_USUAL_M = 300.0  #: maximum usual reading of a driving lidar, the range of the longest-range ones
ENOUGH_READINGS = 100_000
FASTEST_USUAL = 60.0  #: m/s, of a vehicle with a lidar
MOST_EXCLUDED = 0.5  #: of the readings: if a limit excludes more, and none is valid, it is reported as the reason
PAUSE = 5.0  #: usual intervals: longer times between scans are pauses


def understood(robot: RobotLog) -> RobotLog:
    """Return a log whose readings are distances, and whose sweeps fit them, with notes on the deficiencies."""
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
        # Impossible times are not used, but the beams are not simultaneous either, as that note says.
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
    """Return the median of the distinct readings that are distances, metres, in range or not; 0 if there are none.

    A code for no return counts once. In a long log only some of the scans are examined.
    """
    some = log.ranges[:: 1 + log.ranges.size // ENOUGH_READINGS]
    readings = some[np.isfinite(some) & (some > 0.0)]
    return float(np.median(np.unique(readings))) if len(readings) else 0.0


def _with_no_return(log: ScanLog) -> ScanLog:
    """Return the log with its sensor's no-return distance removed, and a note on it."""
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
    """Return the log with the poses of each source by the clock of the scans, and notes on those that differed."""
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
    if sweep.time_increment < 0.0:  # in reverse order, for which nothing was stated
        return _reversed(replace(log, time_increment=-sweep.time_increment))
    return replace(log, time_increment=sweep.time_increment)


def _at_once(log: ScanLog) -> ScanLog:
    return replace(log, time_increment=0.0)


def _reversed(log: ScanLog) -> ScanLog:
    """Return the log with its beams reversed in time.

    The beams are then in the order of measurement; the stamp is that of the first measured beam.
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
    """Return the usual time between scans, seconds; 0 if the stamps (n,) do not determine it.

    It is the median or, if scans arrive in bursts, their mean without pauses.
    """
    steps = np.diff(stamps_ns.astype(np.float64)) * 1e-9
    steps = steps[steps > 0.0]
    if len(steps) < LEAST_SCANS - 1:
        return 0.0
    usual = float(np.median(steps))
    return max(usual, float(np.mean(steps[steps <= PAUSE * usual])))


def impossible_sweep(log: ScanLog, period: float) -> str:
    """Return why the stated beam times are impossible, or nothing if they are possible.

    ``period`` is the usual time between scans, seconds, 0 if unknown. A sweep must end before the next one starts, and
    within the stated ``scan_time``.
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
    """Return a note on each trajectory with an implausibly high usual speed."""
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
    turns = sparse_turns(_longest(log))
    return [] if turns is None else [f"{turns.sentence} {ADVICE}"]


def _notes_on_readings(log: ScanLog) -> list[str]:
    usual = max(_usual_reading(part) for part in sensors_of(log))
    if usual > FARTHEST_USUAL_M:
        note = (
            f"The readings are usually {usual:,.0f} m, farther than a lidar measures: apparently they are in "
            "millimetres or centimetres. They are taken for metres, so hardly any is within the map’s max range."
        )
        return [note]
    total = no_return = 0
    outside = {"range_max": 0, "range_min": 0}  #: distances excluded by a limit
    limits = {"range_max": log.range_max, "range_min": log.range_min}
    for part in sensors_of(log):
        with np.errstate(invalid="ignore"):
            if is_measured(part).any():
                return []
            beyond = (part.ranges > part.range_max) | np.isposinf(part.ranges)
            no_return += int(np.count_nonzero(beyond))
            far = part.ranges[beyond & np.isfinite(part.ranges)]
            if len(far) and np.ptp(far) > 0.0:  # a single value is a code for no return
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


LONGEST_S = 0.5  #: maximum duration of a lidar's turn considered
_ONLY_SO = "only so do they end, where the robot turns, on walls that other scans saw."


@dataclass(frozen=True, slots=True)
class Sweep:
    """Measurement times of a scan's beams according to the readings; ``why`` is a sentence.

    ``time_increment`` is the time between beams, seconds; ``reversed`` means the opposite order of that stated.
    """

    why: str
    time_increment: float = 0.0
    reversed: bool = False


def contradicted_sweep(log: ScanLog, period: float) -> Sweep | None:
    """Return how a scan's beams were measured, if it differs from the stated times; None if that is not clear.

    Poses are those of the log's first trajectory; ``period`` is the usual time between scans, seconds, 0 if unknown.
    Each order is evaluated with its best delay, so that late poses have no influence, and the stated one must fit
    clearly worse.
    """
    if log.can_deskew():
        return _contradicted(log)
    if log.time_increment == 0.0 and 0.0 < period <= LONGEST_S and not log.trajectory().is_placeholder:
        return _not_stated(log, period)
    return None


def _contradicted(log: ScanLog) -> Sweep | None:
    sweep = log.time_increment * (log.n_beams - 1)
    agreement = Agreement(log, sweep)
    if not agreement.tells or agreement.apart(log.time_increment) <= BY_M:  # nothing can fit clearly better
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
    """Return the sweep of a lidar that turns once between two scans, in a log that states no times."""
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


LEAST_READINGS = 20  #: of the maximum distance, in wide runs of beams, and of all others
LEAST_SCANS_WITH_RUNS = 5  #: with such runs
LEAST_RUN_RAD = np.radians(30.0)  #: of neighbouring beams that all read the same distance
WIDER = 2.0  #: times the width at which a flat wall has one distance
APART_M = 0.5  #: between two positions with such runs
LEAST_STEP_M = 1e-3  #: distances that differ by less are in one quantisation step, with 32-bit errors
ENOUGH = 100_000  #: readings used to estimate the step


def code_for_no_return(log: ScanLog) -> float | None:
    """Return the maximum distance of a log, metres, if it means no return; None if it may be a wall.

    Beams that hit a flat wall read one distance d only as long as rounding hides the increase to the sides: with a
    quantisation step q over an angle of √(8 q / d). If many neighbouring beams read the maximum distance over twice
    that angle, and at least 30°, in 5 scans and from positions 0.5 m apart, the wall would be an arc around the sensor
    that moves with it. Sonars, whose cones read the nearest wall, are not tested.
    """
    if log.beam_width > 0.0 or log.bearings is not None or log.n_beams < 2:
        return None
    readings = log.ranges
    counts = (readings >= log.range_min) & (readings <= log.range_max) & (readings > 0.0) & np.isfinite(readings)
    if not counts.any():
        return None
    greatest = float(readings[counts].max())
    if np.count_nonzero(counts & (readings < np.float32(greatest))) < LEAST_READINGS:
        return None
    rows = np.flatnonzero((counts & (readings == np.float32(greatest))).any(axis=1))
    scans, widths, beams = _runs(readings[rows] == np.float32(greatest), abs(log.angle_increment))
    flat = np.sqrt(8.0 * _step(readings[counts]) / greatest)
    wide = widths >= max(LEAST_RUN_RAD, WIDER * flat)
    if beams[wide].sum() < LEAST_READINGS:
        return None
    seen_in = np.unique(rows[scans[wide]])
    places = log.trajectory().poses[seen_in, :2]
    return (
        greatest if len(seen_in) >= LEAST_SCANS_WITH_RUNS and float(np.ptp(places, axis=0).max()) >= APART_M else None
    )


def without_code(log: ScanLog, code: float) -> ScanLog:
    """Return the log with the readings equal to the code replaced by +inf, no return."""
    return replace(log, ranges=np.where(log.ranges == np.float32(code), np.float32(np.inf), log.ranges))


def _step(readings: NDArray[np.float32]) -> float:
    """Return the usual difference between consecutive distinct distances, metres."""
    steps = np.diff(np.unique(readings[:: 1 + len(readings) // ENOUGH]).astype(np.float64))
    steps = steps[steps >= LEAST_STEP_M]
    return float(np.quantile(steps, 0.1)) if len(steps) else 0.0


def _runs(is_same: NDArray[np.bool_], increment: float) -> tuple[Int64Array, NDArray[np.float64], Int64Array]:
    """Return the runs of neighbouring beams in (n_scans, n_beams): their scans, angles in radians and beams, (n,)."""
    edges = np.diff(np.pad(is_same, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    scans, first = np.nonzero(edges == 1)
    beams = (np.nonzero(edges == -1)[1] - first).astype(np.int64)
    return scans.astype(np.int64), np.asarray((beams - 1) * increment, dtype=np.float64), beams
