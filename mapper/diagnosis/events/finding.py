"""All events of a log."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose
from mapper.diagnosis.events.clock_steps import ClockStep, clock_steps, near_clock_steps, usual_interval
from mapper.diagnosis.events.displacement import Displacement, displacements
from mapper.diagnosis.events.event import CLOCK, GAP, LIFTED, PUSHED, SLIPPED, Event
from mapper.diagnosis.events.gaps import driven_ways, recording_gaps
from mapper.diagnosis.events.motions import Motions, aligned_motions
from mapper.diagnosis.finding import MOST_SCANS
from mapper.io.logs.summary import recorded_seconds
from mapper.sensors.joint_log import by_sensor, sensors_of
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog
from mapper.sensors.sparse_poses import sparse_turns
from mapper.sensors.timed_poses import number_before

LEAST_SCANS = 30  #: fewer do not tell what is usual
LIFTED_SCANS, LIFTED_S = 3, 0.4  #: scans and seconds without a fit, from which the robot was lifted and not pushed
LIFTED_M = 1.0  #: a robot that is displaced farther while its wheels stand was carried
STOOD_M = 0.1  #: way of wheels that stand
PAUSE, PAUSE_S = 5.0, 0.5  #: times the usual time between two poses, and seconds, from which they pause
OPPOSITE = 0.8  #: cosine between the wheels' motion and what is taken off it by a slip
BACK_M, BACK_RAD = 0.03, math.radians(2.0)  #: by which a robot whose wheels slip may seem to go the other way
TURNED_ONLY = 0.05  #: metres: a displacement that is a turn only


def wheels_of(log: ScanLog) -> str | None:
    """Return the trajectory that the robot measured by itself, whose motion scans are compared with; None for none.

    That is the first in a frame ``odom`` (REP 105). Poses in other frames may have been found by means of the scans,
    and poses that never change measure nothing.
    """
    for name, trajectory in log.trajectories.items():
        moves = not trajectory.is_placeholder and len(trajectory.poses) and np.ptp(trajectory.poses, axis=0).any()
        if moves and (trajectory.frame_id or "").strip("/").endswith("odom"):
            return name
    return None


def find_events(
    log: ScanLog,
    may_continue: Callable[[], bool] = lambda: True,
    progress: Callable[[float], None] | None = None,
) -> list[Event]:
    """Return the events of a log in the order of their times; of several sensors by the first lidar.

    A log without times has none. How far the robot came in a gap is told by its wheels, or by the log's default
    trajectory. Pushes, slips and lifts need a lidar, at least :data:`LEAST_SCANS` scans, and the robot's own
    measurement of its motion (:func:`wheels_of`), not interpolated in a turn there. Raises
    :class:`WorkCancelledError` where ``may_continue`` returns False.
    """
    sensors = by_sensor(log)
    lidars = [sensor for sensor in sensors if _is_lidar(sensor[0])]
    sensor, numbers = max(lidars or sensors, key=lambda sensor: sensor[0].n_scans)
    if not (sensor.stamps_ns != sensor.stamps_ns[:1]).any():
        return []
    wheels = wheels_of(sensor)
    steps = clock_steps(sensor, wheels)
    events = [*_of_clock(sensor, steps), *_of_gaps(sensor, wheels, {step.scan for step in steps})]
    if lidars and wheels is not None and sensor.n_scans >= LEAST_SCANS:
        motions = aligned_motions(sensor, wheels, may_continue, progress)
        untold = near_clock_steps(sensor.take(motions.scans), clock_steps(sensor.take(motions.scans), None))
        interpolated = _interpolated_scans(sensor, wheels)
        for displacement in displacements(motions, untold):
            kind = _kind(displacement)
            if kind is None or (displacement.moved is None and kind != LIFTED):
                continue
            if not displacement.lost and is_contradicted(sensor, motions, displacement):
                continue
            ahead, left, turned = (
                (None,) * 3 if displacement.moved is None else (float(value) for value in displacement.moved)
            )
            before, after = int(motions.scans[displacement.before]), int(motions.scans[displacement.after])
            if interpolated[max(before - 1, 0) : after + 2].any():
                continue
            stamp = int(sensor.stamps_ns[before]) + round(
                1e9 * (displacement.begin_s - motions.seconds[displacement.before])
            )
            events.append(
                Event(
                    kind,
                    float(displacement.begin_s),
                    float(displacement.end_s),
                    stamp,
                    before,
                    after,
                    ahead,
                    left,
                    turned,
                )
            )
    return sorted(
        (_of_whole(log, sensor, numbers, event) for event in events), key=lambda event: (event.seconds, event.scan)
    )


def _interpolated_scans(log: ScanLog, wheels: str) -> NDArray[np.bool_]:
    """Return of which scans (n_scans,) the wheels did not measure the motion, as their poses are far apart.

    They are so in turns, or have a pause, as of a program that states poses only while the robot moves.
    """
    found, is_so = sparse_turns(log, wheels), np.zeros(log.n_scans, dtype=np.bool_)
    if found is not None:
        is_so[found.scans] = True
    timed = log.trajectory(wheels).timed
    if timed is not None and len(timed) > 2:
        motion = Motion.of(log, wheels)
        steps = np.diff(motion.times)
        low = np.clip(number_before(motion.times, seconds(log)), 0, len(steps) - 1)
        is_so |= steps[low] > max(PAUSE * float(np.median(steps)), PAUSE_S)
    return is_so


def _of_clock(log: ScanLog, steps: list[ClockStep]) -> list[Event]:
    seconds, usual = recorded_seconds(log), usual_interval(log)
    return [
        Event(
            CLOCK, float(seconds[step.scan]) + usual, float(seconds[step.scan]) + usual,
            int(log.stamps_ns[step.scan]) + round(1e9 * usual), step.scan, step.scan + 1, step_s=step.step_s,
        )
        for step in steps
    ]  # fmt: skip


def _of_gaps(log: ScanLog, wheels: str | None, set_at: set[int]) -> list[Event]:
    """Return the gaps of the recording, but those behind the scans ``set_at``, where the clock was set."""
    driven = driven_ways(log, wheels)
    poses = log.trajectory(wheels).poses
    seconds = recorded_seconds(log)
    gaps = np.flatnonzero(recording_gaps(np.diff(log.stamps_ns.astype(np.float64)) * 1e-9, driven)).tolist()
    return [
        Event(
            GAP, float(seconds[scan]), float(seconds[scan + 1]), int(log.stamps_ns[scan]), scan, scan + 1,
            moved_m=None if driven is None else float(np.hypot(*(poses[scan + 1] - poses[scan])[:2])),
        )
        for scan in gaps[:MOST_SCANS] if scan not in set_at
    ]  # fmt: skip


def _kind(displacement: Displacement) -> str | None:
    """Return what happened: :data:`LIFTED`, :data:`SLIPPED` or :data:`PUSHED`; None for a loss that tells nothing.

    Wheels that slip turn while the robot moves less than they say, or stands, but not the other way.
    """
    wheels, scans, moved = displacement.by_wheels, displacement.by_scans, displacement.moved
    driven, turn = math.hypot(wheels[0], wheels[1]), float(wheels[2])
    stood = driven < STOOD_M
    if (
        displacement.lost
        and displacement.after - displacement.before > LIFTED_SCANS
        and displacement.end_s - displacement.begin_s >= LIFTED_S
        and stood
    ):
        return LIFTED
    if moved is None:
        return None
    far = math.hypot(moved[0], moved[1])
    if stood and far > LIFTED_M:
        return LIFTED
    if far < TURNED_ONLY:
        is_slip = turn * moved[2] < 0.0 and turn * scans[2] > -abs(turn) * BACK_RAD
        return SLIPPED if is_slip else PUSHED
    ahead = wheels[:2] / max(driven, 1e-9)
    against, went = -float(ahead @ moved[:2]) / far, float(ahead @ scans[:2])
    return SLIPPED if against > OPPOSITE and went > -BACK_M else PUSHED


def _is_lidar(log: ScanLog) -> bool:
    return all(part.beam_width == 0.0 and part.bearings is None and part.n_beams > 2 for part in sensors_of(log))


def _of_whole(log: ScanLog, sensor: ScanLog, numbers: NDArray[np.int64], event: Event) -> Event:
    """Return an event of one of a log's sensors with the ``numbers`` and times of the log's scans."""
    if sensor is log:
        return event
    shift = float(recorded_seconds(log)[numbers[0]])
    return replace(
        event, scan=int(numbers[event.scan]), until_scan=int(numbers[event.until_scan]),
        seconds=event.seconds + shift, until_s=event.until_s + shift,
    )  # fmt: skip


SCANS = 8  #: before it and after it that are compared
REACH_M = 30.0  #: of the readings that are compared
FARTHEST_M = 0.3  #: from the nearest end of a beam before: what is farther was not seen then
MOST_BEAMS = 360  #: of each scan


def is_contradicted(log: ScanLog, motions: Motions, displacement: Displacement) -> bool:
    """Return whether what is seen after a displacement fits what was seen before it better without than with it.

    Of a robot that was displaced walls are double where the wheels have it; where only a scan was aligned wrongly, and
    those after it with that one, they are double where the scans have it. All readings of :data:`SCANS` scans on both
    sides count alike, so that somebody who covers many beams of some of them decides nothing.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few logs need

    first, last = max(0, displacement.before - SCANS), min(len(motions.scans) - 1, displacement.after + SCANS)
    back = _chained(motions.by_scans[first : displacement.before])
    seen = cKDTree(_ends(log, motions.scans[first : displacement.before + 1], back))
    forth = _chained(motions.by_scans[displacement.after : last])

    def apart(steps: Float64Array) -> float:
        """Return how far ends after the displacement are from those before it on average, metres."""
        begin = compose(back[-1], _chained(steps)[-1])
        ends = _ends(log, motions.scans[displacement.after : last + 1], compose(begin, forth))
        distances = seen.query(ends, distance_upper_bound=FARTHEST_M)[0]
        return float(np.minimum(distances, FARTHEST_M).mean()) if len(ends) else FARTHEST_M

    window = slice(displacement.before, displacement.after)
    return apart(motions.by_wheels[window]) < apart(motions.by_scans[window])


def _chained(steps: Float64Array) -> Float64Array:
    """Return the poses (n + 1, 3) to which n motions (n, 3) lead one after another, from zero on."""
    poses = np.zeros((len(steps) + 1, 3))
    for k, step in enumerate(steps):
        poses[k + 1] = compose(poses[k], step)
    return poses


def _ends(log: ScanLog, scans: NDArray[np.int64], poses: Float64Array) -> Float64Array:
    """Return where the measured beams of scans with the robot's ``poses`` (n, 3) end, (m, 2)."""
    ends = [np.zeros((0, 2))]
    for number, pose in zip(scans.tolist(), poses, strict=True):
        scan = log.scan(number)
        every = slice(None, None, 1 + len(scan.ranges) // MOST_BEAMS)
        ranges, angles = scan.ranges[every].astype(np.float64), scan.angles[every]
        with np.errstate(invalid="ignore"):
            measured = (ranges >= max(scan.range_min, 1e-3)) & (ranges <= min(scan.range_max, REACH_M))
        x, y, yaw = compose(pose, log.mount_of(number))
        bearings = angles[measured] + yaw
        along = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
        ends.append((x, y) + ranges[measured, np.newaxis] * along)
    return np.concatenate(ends)
