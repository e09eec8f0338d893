"""All events of a log.

Among them are the times at which its clock was set: stamps that jump back, and stamps that jump ahead while the robot
did not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
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


LEAST_SCANS = 30  #: fewer scans do not determine what is usual
LIFTED_SCANS, LIFTED_S = 3, 0.4  #: scans and seconds without alignment above which the robot was lifted, not pushed
LIFTED_M = 1.0  #: a robot displaced farther while its wheels are at rest was carried
STOOD_M = 0.1  #: path length of wheels at rest
PAUSE, PAUSE_S = 5.0, 0.5  #: poses pause: multiple of the usual pose interval, and minimum seconds
OPPOSITE = 0.8  #: cosine between the wheels' motion and the motion removed by a slip
BACK_M, BACK_RAD = 0.03, math.radians(2.0)  #: apparent reverse motion allowed for a robot whose wheels slip
TURNED_ONLY = 0.05  #: metres: a smaller displacement is a rotation only


def wheels_of(log: ScanLog) -> str | None:
    """Return the robot's own odometry, whose motion is compared with that of the scans; None if there is none.

    It is the first trajectory in a frame ``odom`` (REP 105). Poses in other frames may have been estimated from the
    scans, and poses that never change are no measurement.
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
    """Return the events of a log in time order; with several sensors, those by the first lidar.

    A log without times has none. The motion during a gap comes from the wheels, or from the log's default trajectory.
    Pushes, slips and lifts require a lidar, at least :data:`LEAST_SCANS` scans, and odometry (:func:`wheels_of`) that
    is not interpolated in a turn. Raises :class:`WorkCancelledError` if ``may_continue`` returns False.
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
    """Return the scans (n_scans,) whose motion the wheels did not measure, because their poses are far apart.

    This is the case in turns, and in pauses, as of a program that publishes poses only while the robot moves.
    """
    turns, is_so = sparse_turns(log, wheels), np.zeros(log.n_scans, dtype=np.bool_)
    if turns is not None:
        is_so[turns.scans] = True
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
    """Return the gaps of the recording, except those after the scans ``set_at``, where the clock was set."""
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
    """Return the kind: :data:`LIFTED`, :data:`SLIPPED` or :data:`PUSHED`; None for an inconclusive loss.

    Slipping wheels turn while the robot moves less than they indicate or is at rest, but not in the opposite direction.
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


SCANS = 8  #: scans before and after it that are compared
REACH_M = 30.0  #: range limit of the compared readings
FARTHEST_M = 0.3  #: from the nearest end of a beam before: what is farther was not visible then
MOST_BEAMS = 360  #: of each scan


def is_contradicted(log: ScanLog, motions: Motions, displacement: Displacement) -> bool:
    """Return whether the scans after a displacement fit those before it better without than with it.

    If the robot was displaced, walls are double at the wheels' poses; if only a scan and its successors were
    misaligned, they are double at the scans' poses. All readings of :data:`SCANS` scans on both sides have equal
    weight, so that a person who blocks many beams of some scans has no influence.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few logs need

    first, last = max(0, displacement.before - SCANS), min(len(motions.scans) - 1, displacement.after + SCANS)
    back = _chained(motions.by_scans[first : displacement.before])
    seen = cKDTree(_ends(log, motions.scans[first : displacement.before + 1], back))
    forth = _chained(motions.by_scans[displacement.after : last])

    def apart(steps: Float64Array) -> float:
        """Return the mean distance of endpoints after the displacement from those before it, metres."""
        begin = compose(back[-1], _chained(steps)[-1])
        ends = _ends(log, motions.scans[displacement.after : last + 1], compose(begin, forth))
        distances = seen.query(ends, distance_upper_bound=FARTHEST_M)[0]
        return float(np.minimum(distances, FARTHEST_M).mean()) if len(ends) else FARTHEST_M

    window = slice(displacement.before, displacement.after)
    return apart(motions.by_wheels[window]) < apart(motions.by_scans[window])


def _chained(steps: Float64Array) -> Float64Array:
    """Return the poses (n + 1, 3) reached by n successive motions (n, 3) from zero."""
    poses = np.zeros((len(steps) + 1, 3))
    for k, step in enumerate(steps):
        poses[k + 1] = compose(poses[k], step)
    return poses


def _ends(log: ScanLog, scans: NDArray[np.int64], poses: Float64Array) -> Float64Array:
    """Return the endpoints (m, 2) of the measured beams of scans with the robot's ``poses`` (n, 3)."""
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
