"""Addition of a trajectory from another program to a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.io.logs.pose_clocks import pose_clock
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses


def poses_at_all_scans(log: ScanLog, poses: TimedPoses) -> tuple[NDArray[np.float64], list[str]]:
    """Return ``poses`` at every scan of ``log`` (n_scans, 3), m and rad, in their own frame, and notes.

    If there are as many poses as scans, with equal stamps, they are assigned scan by scan; otherwise they are
    interpolated as in :func:`mapper.io.trajectories.with_trajectory`, by the clock of the scans if the readings
    contradict their stamps (:mod:`mapper.io.logs.pose_clocks`). Scans before the first or after the last pose continue
    the trajectory with the motion of the log's own poses: the transform between the two frames (map → odom of REP 105)
    is that at the nearest scan with a pose. Raises :class:`ConfigError` if no scan is within the poses' time, and if
    some are outside it and the log has no poses of its own.
    """
    if is_scan_by_scan(log, poses):
        return poses.poses, []
    poses, notes = _by_the_clock_of_scans(log, poses, TUM)
    inside = poses.covers(log.stamps_ns)
    outside = int(np.count_nonzero(~inside))
    if outside == log.n_scans:
        raise time_error(log, poses)
    at_scans = poses.at(log.stamps_ns)
    if not outside:
        return at_scans, notes
    own = next((trajectory.poses for trajectory in log.trajectories.values() if not trajectory.is_placeholder), None)
    if own is None:
        raise ConfigError(
            "trajectory.outside",
            f"{outside} of the {log.n_scans} scans lie before the first or after the last pose of the trajectory, and "
            "the log has no poses of its own with which to continue it there.",
        )
    covered = np.flatnonzero(inside)
    first, last = (int(covered[choose(log.stamps_ns[covered])]) for choose in (np.argmin, np.argmax))
    before = log.stamps_ns < poses.stamps_ns.min()
    for scans, nearest in ((before, first), (~inside & ~before, last)):
        t_map_odom = compose(at_scans[nearest], inverse(own[nearest]))
        at_scans[scans] = compose(t_map_odom, own[scans])
    are = "1 scan lies" if outside == 1 else f"{outside} scans lie"
    note = f"{are} before the first or after the last pose: the log’s own poses continue the trajectory."
    return at_scans, [*notes, note]


TUM = "tum"  #: name of the trajectory from a TUM file
SAME_NS = 1_000  #: stamps that differ by no more are equal, written with six or more digits
FAR_S = 1.0  #: seconds: scans farther from every pose are noted


def with_trajectory(log: ScanLog, poses: TimedPoses, name: str = TUM) -> ScanLog:
    """Return ``log`` with ``poses`` of its base as the trajectory ``name``, as its first and therefore default one.

    If there are as many poses as scans, with stamps equal to a microsecond, they are assigned scan by scan. Otherwise
    they are interpolated at the scans' stamps, linearly in position and along the shorter arc in angle, and scans
    before the first or after the last pose are removed from the log; a note states how many, and how many scans are far
    from any pose. The trajectory's fixed frame is unknown (None). A placeholder for missing poses is removed, with its
    note. Raises :class:`ConfigError` if the log has a trajectory of this name, and if no scan is within the poses'
    time.
    """
    if name in log.trajectories:
        raise ConfigError("trajectory.name", f"The log has a trajectory {name!r:.80} already.")
    notes: list[str] = []
    at_scans = poses.poses
    if not is_scan_by_scan(log, poses):
        poses, new_notes = _by_the_clock_of_scans(log, poses, name)
        log, notes = cut_to(log, poses)
        notes += new_notes
        at_scans = poses.at(log.stamps_ns)
    added = Trajectory(at_scans, "the poses of a TUM file at the time of each scan", offset=poses.offset)
    known = {own: trajectory for own, trajectory in log.trajectories.items() if not trajectory.is_placeholder}
    outdated = {trajectory.placeholder_note for trajectory in log.trajectories.values()}
    old_notes = [note for note in log.notes if note not in outdated]
    return replace(log, trajectories={name: added, **known}, notes=(*old_notes, *poses.notes, *notes))


def _by_the_clock_of_scans(log: ScanLog, poses: TimedPoses, name: str) -> tuple[TimedPoses, list[str]]:
    """Return poses corrected for late or early stamps according to the readings, and a note in that case."""
    longest = max(sensors_of(log), key=lambda part: part.n_scans)
    trajectory = Trajectory(poses.at(longest.stamps_ns), timed=poses, offset=poses.offset)
    alone = replace(longest, trajectories={name: trajectory})
    clock = pose_clock(alone, name)
    if clock is None:
        return poses, []
    return clock.corrected(alone, name).timed or poses, [clock.why]


def is_scan_by_scan(log: ScanLog, poses: TimedPoses) -> bool:
    """Return whether there are as many ``poses`` as scans of ``log``, with equal stamps in the same order."""
    return len(poses) == log.n_scans and bool((np.abs(poses.stamps_ns - log.stamps_ns) <= SAME_NS).all())


def cut_to(log: ScanLog, poses: TimedPoses) -> tuple[ScanLog, list[str]]:
    """Return the scans of ``log`` within the time of ``poses``, and notes. Raises the errors above."""
    inside = poses.covers(log.stamps_ns)
    outside = int(np.count_nonzero(~inside))
    if outside == log.n_scans:
        raise time_error(log, poses)
    notes = []
    if outside:
        scans = "1 scan lies" if outside == 1 else f"{outside} scans lie"
        left = "is left out" if outside == 1 else "are left out"
        notes.append(f"{scans} before the first or after the last pose of the trajectory, and {left}.")
        log = log.take(inside)
    far = int(np.count_nonzero(_to_nearest_ns(log.stamps_ns, poses.stamps_ns) > FAR_S * 1e9))
    if far:
        scans = "1 scan is" if far == 1 else f"{far} scans are"
        notes.append(f"{scans} more than {FAR_S:g} s from any pose of the trajectory; poses are interpolated there.")
    return log, notes


def time_error(log: ScanLog, poses: TimedPoses) -> ConfigError:
    """Return the error for poses whose time contains no scan of ``log``."""
    return ConfigError(
        "trajectory.time",
        f"No scan is within the time of the trajectory: its poses are from {_span(poses.stamps_ns)}, the scans from "
        f"{_span(log.stamps_ns)}.",
    )


def _to_nearest_ns(stamps_ns: NDArray[np.int64], of_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the distance of each of ``stamps_ns`` (n,) from the nearest of ``of_ns`` (m,), ns."""
    known = np.sort(of_ns)
    after = np.searchsorted(known, stamps_ns)
    low, high = known[np.clip(after - 1, 0, None)], known[np.clip(after, None, len(known) - 1)]
    return np.asarray(np.minimum(np.abs(stamps_ns - low), np.abs(high - stamps_ns)), dtype=np.int64)


def _span(stamps_ns: NDArray[np.int64]) -> str:
    return f"{stamps_ns.min() / 1e9:.3f} to {stamps_ns.max() / 1e9:.3f} s" if len(stamps_ns) else "no time"
