"""Sources of poses in a recording, and the robot's pose at each scan from each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.limits import Limits
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.logs.recording.clocks import AHEAD_NS
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.timeline import Moments
from mapper.sensors.georeference import Offset, note_on_offset, offset_of
from mapper.sensors.scan import Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses, number_before

STAMP_LIMIT_NS = 4_000_000_000 * 1_000_000_000  #: the difference of two stamps must fit into 64 bits
SAME = 1e-3  #: metres and radians
STILL = "standing still"
FAR_NS = 1_000_000_000  #: from the nearest scan with a pose of a trajectory; longer continuations are noted


@dataclass(frozen=True, slots=True)
class StatedPoses:
    """The planar poses (n, 3) of a source at its own times.

    ``stamps_ns`` (n,) are as stated, ``counted_ns`` (n,) are ascending, also across restarts of the clock.
    """

    stamps_ns: Int64Array
    counted_ns: Int64Array
    poses: Float64Array


@dataclass(frozen=True, slots=True)
class PoseSource:
    """Poses: ``at`` n times, if the source ``covers`` (n,) them; ``T_frame_child`` of two named frames.

    ``stated`` returns them with their own stamps. Its clock is ``ahead_ns`` ahead of the scans' clock, according to the
    recorder; ``is_scans_clock_own`` means that the scans' clock certainly differs from the recorder's. ``is_odometry``
    means that they are integrated from the robot's own motion, and ``repeats`` that they may duplicate another source,
    as for a tracker that also publishes its pose in tf; they are then dropped.
    """

    name: str
    frame_id: str
    child_frame_id: str
    sentence: str
    at: Callable[[Moments], Poses3]
    covers: Callable[[Int64Array], NDArray[np.bool_]]
    stated: Callable[[], StatedPoses | None]
    ahead_ns: int
    is_odometry: bool
    repeats: bool = False
    is_scans_clock_own: bool = False


@dataclass(frozen=True, slots=True)
class PosesAtScans:
    """The trajectories of n scans by name, which of the scans are ``kept`` (n,), and notes.

    Scans at whose time no source has a pose are dropped: as in tf2, nothing is extrapolated.
    """

    trajectories: dict[str, Trajectory]
    kept: NDArray[np.bool_]
    notes: list[str]


def trajectories_at(
    when: Moments,
    sources: Iterable[PoseSource],
    base_frame: str,
    limits: Limits,
    refused: str = "",
    unused: str = "",
) -> PosesAtScans:
    """Return each source's poses at the scans' times, in order; at least one trajectory.

    Without a usable source, that is a placeholder: ``base_frame`` at its own origin. ``refused`` has the poses that
    could not be read, and why, ``unused`` the messages that state positions but are not a source.

    A source whose poses are from another time than the scans is dropped, unless only their clocks differ: then both are
    matched by their recording times, as they are if the scans' clock certainly differs and more scans have poses in
    this way. If another source has poses for more scans, it continues a trajectory before its first pose and after its
    last (:func:`_continued`). An offset is subtracted from poses far from the origin of their frame, such as projected
    coordinates: one for all in the same frame.
    """
    by_name: dict[str, Trajectory] = {}
    known: dict[str, NDArray[np.bool_]] = {}
    notes: list[str] = []
    offsets: dict[str, Offset] = {}
    is_any = False
    for source in sources:
        is_any = True
        trajectory, covered, more = _at(when, source, limits, offsets)
        is_known = trajectory is not None and any(
            _are_alike(trajectory, other, covered & known[name]) for name, other in by_name.items()
        )
        if source.repeats and is_known:
            continue
        notes += more
        if trajectory is not None:
            by_name[source.name], known[source.name] = trajectory, covered
    if by_name:
        by_name = _moving_first(by_name, notes)
        has_pose = _known_to_any(by_name, known)
        notes += _notes_on_left_out(when, by_name, known, has_pose)
        trajectories, more = _continued(when, by_name, known, has_pose)
        return PosesAtScans(trajectories, has_pose, [*notes, *more])
    note = _without_poses(is_any=is_any, refused=refused, unused=unused)
    still = Trajectory(
        np.zeros((len(when), 3)),
        "no poses in the file: one place for all scans",
        frame_id=base_frame,
        child_frame_id=base_frame,
        is_placeholder=True,
        placeholder_note=note,
    )
    return PosesAtScans({STILL: still}, np.ones(len(when), dtype=np.bool_), [*notes, note])


def _moving_first(trajectories: dict[str, Trajectory], notes: list[str]) -> dict[str, Trajectory]:
    """Return trajectories with those that never move last, with a note if the first one never moves."""
    still = [name for name, trajectory in trajectories.items() if not np.ptp(trajectory.poses, axis=0).any()]
    first = next(iter(trajectories))
    if first not in still or len(still) == len(trajectories):
        return trajectories
    ordered = sorted(trajectories, key=lambda name: name in still)
    notes.append(f"By {first} the robot never moves, but by {ordered[0]} it does: {ordered[0]} is used first.")
    return {name: trajectories[name] for name in ordered}


def _known_to_any(trajectories: Mapping[str, Trajectory], known: Mapping[str, NDArray[np.bool_]]) -> NDArray[np.bool_]:
    """Return for which scans (n,) any trajectory has a pose; one that never moves does not count if others move."""
    moving = [name for name, trajectory in trajectories.items() if np.ptp(trajectory.poses, axis=0).any()]
    return np.asarray(np.any([known[name] for name in moving or known], axis=0))


def _notes_on_left_out(
    when: Moments,
    trajectories: Mapping[str, Trajectory],
    known: Mapping[str, NDArray[np.bool_]],
    has_pose: NDArray[np.bool_],
) -> list[str]:
    """Return a note on the scans without a pose, with the reason."""
    if has_pose.all():
        return []
    first = next(iter(trajectories))
    reasons = _before_and_after(when, ~has_pose, known[first])
    n = int(np.count_nonzero(~has_pose))
    others = "" if len(trajectories) == 1 else ", and no other source of poses has them"
    left = "1 scan is left out" if n == 1 else f"{n} scans are left out"
    return [f"{left}: {reasons} pose of {first}{others}. As in tf2, poses are not extrapolated."]


def _before_and_after(when: Moments, scans: NDArray[np.bool_], known: NDArray[np.bool_]) -> str:
    """Return how many of ``scans`` (n,) are before the first, between, and after the last of those ``known`` (n,)."""
    stamps = when.stamps_ns
    before = int(np.count_nonzero(scans & (stamps < stamps[known].min())))
    after = int(np.count_nonzero(scans & (stamps > stamps[known].max())))
    between = int(np.count_nonzero(scans)) - before - after
    parts = [f"{before} before the first" if before else "", f"{after} after the last" if after else ""]
    parts.insert(1, f"{between} between the runs of the clock, which have no" if between else "")
    return " and ".join(part for part in parts if part)


def _continued(
    when: Moments,
    trajectories: Mapping[str, Trajectory],
    known: Mapping[str, NDArray[np.bool_]],
    has_pose: NDArray[np.bool_],
) -> tuple[dict[str, Trajectory], list[str]]:
    """Return the trajectories of the scans for which ``has_pose`` (n,), and notes.

    If a trajectory has no pose for a scan and another one has, it moves like the other there: the transform between
    their frames (map → odom of REP 105) is that at the nearest scan for which both have a pose.
    """
    whole: dict[str, Trajectory] = {}
    notes: list[str] = []
    moving = [name for name, trajectory in trajectories.items() if np.ptp(trajectory.poses, axis=0).any()] or list(
        trajectories
    )
    for name, trajectory in trajectories.items():
        poses, rest = trajectory.poses.copy(), has_pose & ~known[name]
        for other in moving:
            both = np.flatnonzero(known[name] & known[other])
            scans = np.flatnonzero(rest & known[other])
            if other == name or not len(both) or not len(scans):
                continue
            nearest = both[_nearest(when.stamps_ns[both], when.stamps_ns[scans])]
            there = trajectories[other].poses
            poses[scans] = compose(compose(poses[nearest], inverse(there[nearest])), there[scans])
            rest[scans] = False
            far = int(np.count_nonzero(np.abs(when.stamps_ns[scans] - when.stamps_ns[nearest]) > FAR_NS))
            if not far:
                continue
            are = "1 scan is" if far == 1 else f"{far} scans are"
            notes.append(f"{are} before the first or after the last pose of {name}, which moves as {other} there.")
        whole[name] = replace(trajectory, poses=poses)
    return whole, notes


def _nearest(of_ns: Int64Array, stamps_ns: Int64Array) -> Int64Array:
    """Return the index of the time in ``of_ns`` (m,) nearest to each of ``stamps_ns`` (n,)."""
    order = np.argsort(of_ns, kind="stable")
    ascending = of_ns[order]
    after = np.searchsorted(ascending, stamps_ns)
    low, high = np.maximum(after - 1, 0), np.minimum(after, len(of_ns) - 1)
    is_low = np.abs(stamps_ns - ascending[low]) <= np.abs(ascending[high] - stamps_ns)
    return np.asarray(order[np.where(is_low, low, high)])


def _are_alike(first: Trajectory, other: Trajectory, at: NDArray[np.bool_]) -> bool:
    """Return whether two trajectories are the same poses in the same frame, to a millimetre and a milliradian.

    They are compared ``at`` the scans (n,) for which both have one.
    """
    if (first.frame_id, first.offset) != (other.frame_id, other.offset) or not at.any():
        return False
    apart = first.poses[at] - other.poses[at]
    apart[:, 2] = wrap_angle(apart[:, 2])
    return bool(np.abs(apart).max(initial=0.0) < SAME)


_FROM_ONE_PLACE = "the map shows all scans as from one place"


def _without_poses(*, is_any: bool, refused: str, unused: str) -> str:
    if refused:
        return f"None of the file’s poses can be used ({refused}), so {_FROM_ONE_PLACE}."
    if is_any:
        return f"None of the file’s poses can be used, so {_FROM_ONE_PLACE}."
    content = f"no poses along which the robot moved ({unused})" if unused else "no poses"
    return (
        f"The file holds {content}, so {_FROM_ONE_PLACE}: record /tf and /tf_static, or the odometry, together with "
        "the scans."
    )


def _at(
    when: Moments, source: PoseSource, limits: Limits, offsets: dict[str, Offset]
) -> tuple[Trajectory | None, NDArray[np.bool_], list[str]]:
    """Return the poses of a source at the scans, for which scans (n,) it has one, and notes."""
    name, ahead = source.name, source.ahead_ns
    notes = []
    shift = 0
    covered = source.covers(when.stamps_ns)
    shifted = source.covers(when.stamps_ns + ahead) if abs(ahead) < STAMP_LIMIT_NS else covered
    is_apart = source.is_scans_clock_own and abs(ahead) > AHEAD_NS
    if np.count_nonzero(shifted) > np.count_nonzero(covered) and (is_apart or not covered.any()):
        shift, covered = ahead, shifted
        apart = f"{abs(ahead) / 1e9:,.1f} s {'ahead of' if ahead > 0 else 'behind'}"
        notes.append(
            f"The clock of {name} is {apart} that of the scans; each scan gets the pose of when it was recorded."
        )
    if not covered.any():
        why = "are from another time than the scans, and are left out: let all that is recorded have one clock"
        return None, covered, [f"The poses of {name} {why}."]
    planar = np.array(np.broadcast_to(source.at(when + shift).planar, (len(covered), 3)))
    stated = source.stated()
    offset = offsets.get(source.frame_id) or offset_of(planar if stated is None else stated.poses)
    if offset != (0.0, 0.0):
        offsets[source.frame_id] = offset
        notes.append(note_on_offset(f"The poses of {name}", offset))
    planar[:, :2] -= offset
    if np.abs(planar[:, :2]).max() > limits.max_pose:
        return None, covered, [f"The poses of {name} are more than {limits.max_pose:g} m away, and are left out."]
    timed = None if stated is None else _timed(stated, shift, offset, limits)
    names = (source.frame_id, source.child_frame_id)
    return Trajectory(planar, source.sentence, *names, timed=timed, offset=offset), covered, notes


def _timed(stated: StatedPoses, shift_ns: int, offset: Offset, limits: Limits) -> TimedPoses | None:
    """Return poses with stamps; None if they exceed the limit of coordinates, or if a clock restarted.

    A time would then belong to several poses.
    """
    poses = stated.poses - np.array([*offset, 0.0])
    if np.abs(poses[:, :2]).max() > limits.max_pose or not (stated.stamps_ns == stated.counted_ns).all():
        return None
    return TimedPoses(stated.stamps_ns - shift_ns, poses)


def odometry_among(
    sources: Iterable[PoseSource], trajectories: Mapping[str, Trajectory], when: Moments
) -> OdometryRecords | None:
    """Return the poses of the first odometry source, messages before tf; None if there is none.

    The times ``when`` of the scans place them among the messages, in stamp order.
    """
    odometries = [source for source in sources if source.is_odometry and source.name in trajectories]
    for source in sorted(odometries, key=lambda source: source.name.startswith("tf/")):
        trajectory = trajectories[source.name]
        stated = source.stated()
        if stated is None:
            continue
        if trajectory.timed is not None:
            messages = trajectory.timed.in_order()
            counted = messages.stamps_ns
        elif not (stated.stamps_ns == stated.counted_ns).all():
            counted = stated.counted_ns
            poses = stated.poses - np.array([*trajectory.offset, 0.0])
            messages = TimedPoses(stated.stamps_ns, poses)
        else:
            continue
        before = number_before(counted, when.stamps_ns)
        before[when.stamps_ns < counted[0]] = -1
        return OdometryRecords(messages, before, trajectory.poses)
    return None
