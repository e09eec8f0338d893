"""Detection of poses stamped late or early, or by a clock with another rate, from the readings of a log.

Each source of poses has its own clock. Where the robot turns, scans placed by late poses end off the walls seen by
others. The check is made when a log is read, so that the map is correct automatically; the doctor checks for longer
delays (:mod:`mapper.diagnosis.timing`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose
from mapper.io.logs.agreement import BY_M, FEWER_BEAMS, MUCH, Agreement, fits
from mapper.sensors.joint_log import with_trajectories
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses

LOOKED_AT_S = 0.1  #: seconds of motion by which scans are selected
OFFSETS_S = np.arange(-0.3, 0.301, 0.025)  #: tried in each stretch to find the rate
MOST_RATE = 0.02  #: maximum clock rate error, seconds per second
RATES = 49  #: number of rates tried, evenly spaced up to it in both directions
DRIFTS = (-0.02, -0.01, -0.005, 0.005, 0.01, 0.02)  #: rad/s, of headings, which may look like a clock error
LEAST_CHANGE_S = 0.02  #: minimum clock change within the log


@dataclass(frozen=True, slots=True)
class PoseClock:
    """Clock of poses: the pose at time t, seconds, is stamped ``t + offset + rate · (t − middle)``; ``why`` is a
    sentence.
    """

    offset: float
    rate: float
    middle: float
    why: str

    def stamped(self, times: Float64Array) -> Float64Array:
        """Return the stamps (n,), seconds, of the poses at ``times`` (n,) of the scans."""
        return np.asarray(times + self.offset + self.rate * (times - self.middle))

    def corrected(self, log: ScanLog, name: str) -> Trajectory:
        """Return a trajectory of a log by the scans' clock. Poses outside its range are marked unknown."""
        trajectory, at = log.trajectory(name), self.stamped(seconds(log))
        motion = Motion.of(log, name)
        known = motion.covers(at) if trajectory.is_known is None else motion.covers(at) & trajectory.is_known
        timed = trajectory.timed
        if timed is not None:
            stamps = timed.stamps_ns.astype(np.float64) * 1e-9
            ahead = self.offset + self.rate * (stamps - self.middle - self.offset) / (1.0 + self.rate)
            stamps_ns = timed.stamps_ns - np.round(ahead * 1e9).astype(np.int64)
            timed = TimedPoses(stamps_ns, timed.poses, timed.notes, timed.offset)
        return replace(trajectory, poses=motion.at(at), timed=timed, is_known=None if known.all() else known)


def pose_clock(log: ScanLog, name: str) -> PoseClock | None:
    """Return the clock of a trajectory's separately stamped poses; None if it is that of the scans.

    It must fit the readings much better, because other pose errors may look like a delay: in scans with motion,
    endpoints must be at most half as far from those of others, and 1 cm nearer.
    """
    trajectory = log.trajectory(name)
    if (
        trajectory.timed is None
        or trajectory.from_scans
        or trajectory.is_placeholder
        or log.mount_assumed
        or not log.n_scans
    ):
        return None
    increment = log.time_increment if log.can_deskew(name) else 0.0
    agreement = Agreement(log, LOOKED_AT_S, name)
    now = agreement.apart(increment) if agreement.tells else 0.0
    if now <= BY_M:
        return None
    middle = float(agreement.times.mean())
    apart, offset = agreement.best(increment)
    rate, is_late = 0.0, fits(apart, now, MUCH)
    # If one delay is right, no rate fits clearly better.
    running = None if is_late and apart <= BY_M else _running(agreement, increment, middle)
    if running is not None and fits(running[0], now, MUCH) and fits(running[0], apart):
        apart, offset, rate = running
    elif not is_late:
        return None
    if not fits(apart, _with_drift(log, name, increment)):
        return None
    return PoseClock(offset, rate, middle, _why(name, offset, rate))


def _why(name: str, offset: float, rate: float) -> str:
    """Return the sentence on a clock."""
    if rate:
        parts = float(f"{abs(rate) * 1e6:.2g}")
        return (
            f"By the readings, the clock of {name} runs about {parts:,.0f} parts per million "
            f"{'faster' if rate > 0.0 else 'slower'} than that of the scans: only with this correction do walls "
            "coincide where the robot turns. Its stamps are converted."
        )
    late, early, after = ("late", "early", "after") if offset > 0.0 else ("early", "late", "before")
    return (
        f"By the readings, the poses of {name} are stamped {abs(offset):.2g} s too {late}, or the scans too {early}: "
        "only with this correction do walls coincide where the robot turns. Each scan gets the pose that is stamped "
        f"{abs(offset):.2g} s {after} it."
    )


def _with_drift(log: ScanLog, name: str, increment: float) -> float:
    """Return the minimum distance, metres, for headings that drift evenly by one of :data:`DRIFTS`.

    For a robot that always turns in the same direction, a clock error and a heading drift are equivalent.
    """
    motion = Motion.of(log, name)
    stamps_ns = np.round(motion.times * 1e9).astype(np.int64)
    distances = []
    for drift in DRIFTS:
        turned = np.zeros_like(motion.poses)
        turned[:, 2] = drift * (motion.times - motion.times[0])
        drifting = replace(log.trajectory(name), timed=TimedPoses(stamps_ns, compose(turned, motion.poses)))
        distances.append(Agreement(with_trajectories(log, {name: drifting}), LOOKED_AT_S, name).apart(increment))
    return min(distances)


def _running(agreement: Agreement, increment: float, middle: float) -> tuple[float, float, float] | None:
    """Return the distance, offset, seconds, and rate of the clock for which the stretches fit best.

    None if a clock that is right at the beginning is also right at the end.
    """
    times = agreement.times - middle
    table = np.stack(
        [agreement.by_stretch(increment, offset, FEWER_BEAMS)[0] for offset in OFFSETS_S]
    )  # (offsets, stretches)
    reach = float(np.abs(times).max())
    steepest = min(MOST_RATE, float(np.ptp(OFFSETS_S)) / 2.0 / reach)
    least = (np.inf, 0.0, 0.0)
    for rate in np.linspace(-steepest, steepest, RATES):
        for offset in OFFSETS_S:
            corrected_s = offset + rate * times
            if np.abs(corrected_s).max() > OFFSETS_S[-1] + 1e-9:
                continue
            total = sum(float(np.interp(w, OFFSETS_S, column)) for w, column in zip(corrected_s, table.T, strict=True))
            least = min(least, (total, float(offset), float(rate)))
    _, offset, rate = least
    # Half the step of the first search, and finer.
    step_offset, step_rate = float(OFFSETS_S[1] - OFFSETS_S[0]) / 2.0, steepest / (RATES - 1)
    now = agreement.apart(increment, offset + rate * times)
    for _ in range(3):
        for by in ((step_offset, 0.0), (-step_offset, 0.0), (0.0, step_rate), (0.0, -step_rate)):
            tried = agreement.apart(increment, offset + by[0] + (rate + by[1]) * times)
            if tried < now:
                now, offset, rate = tried, offset + by[0], rate + by[1]
        step_offset, step_rate = step_offset / 2.0, step_rate / 2.0
    return None if abs(rate) * 2.0 * reach < LEAST_CHANGE_S else (now, offset, rate)
