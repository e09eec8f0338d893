"""Whether poses are stamped late or early, or by a clock that runs at another rate, as the readings of a log say.

Each source of poses has its own clock. Where the robot turns, scans that are placed by late poses end beside the walls
that others saw. It is asked when a log is read, so that the map is right by itself; of longer delays the doctor asks
(:mod:`mapper.diagnosis.timing`).
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

LOOKED_AT_S = 0.1  #: seconds in which the robot moves, to choose scans by
OFFSETS_S = np.arange(-0.3, 0.301, 0.025)  #: that are tried in each stretch, to find the rate
MOST_RATE = 0.02  #: seconds by which a clock may go wrong in each second
RATES = 49  #: that are tried, evenly spaced up to it, either way
DRIFTS = (-0.02, -0.01, -0.005, 0.005, 0.01, 0.02)  #: rad/s, of headings, which may look like a clock
LEAST_CHANGE_S = 0.02  #: by which a clock must go wrong within the log


@dataclass(frozen=True, slots=True)
class PoseClock:
    """The pose of a scan at time t, seconds, is stamped ``t + offset + rate · (t − middle)``; ``why`` is a sentence."""

    offset: float
    rate: float
    middle: float
    why: str

    def stamped(self, times: Float64Array) -> Float64Array:
        """Return the stamps (n,), seconds, of the poses at ``times`` (n,) of the scans."""
        return np.asarray(times + self.offset + self.rate * (times - self.middle))

    def corrected(self, log: ScanLog, name: str) -> Trajectory:
        """Return a trajectory of a log as it is by the scans' clock. Poses that it does not cover are not known."""
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
    """Return the clock of the poses of a trajectory that have stamps of their own; None where it is that of the scans.

    It must fit the readings much better, as what other faults do to poses may look like a delay: ends of beams, where
    the robot moves, are at most half as far from those of others, and 1 cm nearer.
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
    # Where one delay is right, no rate fits clearly better.
    running = None if is_late and apart <= BY_M else _running(agreement, increment, middle)
    if running is not None and fits(running[0], now, MUCH) and fits(running[0], apart):
        apart, offset, rate = running
    elif not is_late:
        return None
    if not fits(apart, _with_drift(log, name, increment)):
        return None
    return PoseClock(offset, rate, middle, _why(name, offset, rate))


def _why(name: str, offset: float, rate: float) -> str:
    """Return what is said of a clock."""
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
    """Return the least distance, metres, of a log whose headings drift evenly, by one of :data:`DRIFTS`.

    Of a robot that always turns the same way a clock and a heading that drift are alike.
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
    """Return the distance, the offset, seconds, and the rate of a clock with which the stretches fit best.

    None where the clock is right at the end if it is at the beginning.
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
    # Half of the steps between what was tried, and finer.
    step_offset, step_rate = float(OFFSETS_S[1] - OFFSETS_S[0]) / 2.0, steepest / (RATES - 1)
    now = agreement.apart(increment, offset + rate * times)
    for _ in range(3):
        for by in ((step_offset, 0.0), (-step_offset, 0.0), (0.0, step_rate), (0.0, -step_rate)):
            tried = agreement.apart(increment, offset + by[0] + (rate + by[1]) * times)
            if tried < now:
                now, offset, rate = tried, offset + by[0], rate + by[1]
        step_offset, step_rate = step_offset / 2.0, step_rate / 2.0
    return None if abs(rate) * 2.0 * reach < LEAST_CHANGE_S else (now, offset, rate)
