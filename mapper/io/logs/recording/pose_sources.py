"""Sources of poses in a recording, and the robot's pose at each scan by each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.limits import Limits
from mapper.core.se2 import wrap_angle
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.timeline import Moments
from mapper.sensors.georeference import Offset, note_on_offset, offset_of
from mapper.sensors.scan import FROM_ONE_PLACE, Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses, number_before

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]
STAMP_LIMIT_NS = 4_000_000_000 * 1_000_000_000  #: the difference of two stamps must fit 64 bits
SAME = 1e-3  #: metres and radians
STILL = "standing still"


@dataclass(frozen=True, slots=True)
class StatedPoses:
    """The planar poses (n, 3) of a source at the times at which it states them itself.

    ``stamps_ns`` (n,) are as stated, ``counted_ns`` (n,) those by which they ascend, also where a clock began again.
    """

    stamps_ns: Int64Array
    counted_ns: Int64Array
    poses: Float64Array


@dataclass(frozen=True, slots=True)
class PoseSource:
    """Poses: ``at`` n times, as far as the source ``covers`` (n,) them; ``T_frame_child`` of two frames by name.

    ``stated`` returns them with their own stamps. Its clock is ``ahead_ns`` ahead of the scans' one, as far as the
    recorder tells. ``is_odometry`` says that they are counted from the robot's own motion, and ``repeats`` that they
    may be those of another source again, as of a tracker that states its pose in tf as well: then they are left out.
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


def trajectories_at(
    when: Moments, sources: Iterable[PoseSource], base_frame: str, limits: Limits, refused: str = ""
) -> tuple[dict[str, Trajectory], list[str]]:
    """Return what each source says of the scans' times, in its order, and what is to be noted; at least one trajectory.

    Without a usable source, that is a placeholder: ``base_frame`` at the origin of itself. ``refused`` says which poses
    could not be read, and why.

    A source whose poses are from another time than the scans is left out, unless their clocks alone differ: then both
    are put together by when they were recorded. Poses that are far from the origin of their frame, as projected
    coordinates are, lose an offset: one for all in the same frame.
    """
    found: dict[str, Trajectory] = {}
    notes: list[str] = []
    offsets: dict[str, Offset] = {}
    is_any = False
    for source in sources:
        is_any = True
        trajectory, more = _at(when, source, limits, offsets)
        is_known = trajectory is not None and any(_are_alike(trajectory, one) for one in found.values())
        if source.repeats and is_known:
            continue
        notes += more
        if trajectory is not None:
            found[source.name] = trajectory
    if not found:
        notes.append(_without_poses(is_any=is_any, refused=refused))
        found[STILL] = Trajectory(
            np.zeros((len(when), 3)),
            "no poses in the file: one place for all scans",
            frame_id=base_frame,
            child_frame_id=base_frame,
            is_placeholder=True,
        )
    return found, notes


def _are_alike(one: Trajectory, other: Trajectory) -> bool:
    """Return whether two trajectories are the same poses in the same frame, to a millimetre and a milliradian."""
    if (one.frame_id, one.offset) != (other.frame_id, other.offset):
        return False
    apart = one.poses - other.poses
    apart[:, 2] = wrap_angle(apart[:, 2])
    return bool(np.abs(apart).max(initial=0.0) < SAME)


def _without_poses(*, is_any: bool, refused: str) -> str:
    if refused:
        return f"None of the file's poses can be used ({refused}), so {FROM_ONE_PLACE}."
    if is_any:
        return f"None of the file's poses can be used, so {FROM_ONE_PLACE}."
    return (
        f"The file holds no poses, so {FROM_ONE_PLACE}: record /tf and /tf_static, or the odometry, together with the "
        "scans."
    )


def _at(
    when: Moments, source: PoseSource, limits: Limits, offsets: dict[str, Offset]
) -> tuple[Trajectory | None, list[str]]:
    name, ahead = source.name, source.ahead_ns
    notes = []
    shift = 0
    covered = source.covers(when.stamps_ns)
    if not covered.any() and 0 < abs(ahead) < STAMP_LIMIT_NS:
        shift = ahead
        covered = source.covers(when.stamps_ns + ahead)
        apart = f"{abs(ahead) / 1e9:,.1f} s {'ahead of' if ahead > 0 else 'behind'}"
        notes.append(
            f"The clock of {name} is {apart} that of the scans; each scan gets the pose of when it was recorded."
        )
    outside = int(np.count_nonzero(~covered))
    if outside == len(covered):
        why = "are from another time than the scans, and are left out: let all that is recorded have one clock"
        return None, [f"The poses of {name} {why}."]
    planar = np.array(np.broadcast_to(source.at(when + shift).planar, (len(covered), 3)))
    stated = source.stated()
    offset = offsets.get(source.frame_id) or offset_of(planar if stated is None else stated.poses)
    if offset != (0.0, 0.0):
        offsets[source.frame_id] = offset
        notes.append(note_on_offset(f"The poses of {name}", offset))
    planar[:, :2] -= offset
    if np.abs(planar[:, :2]).max() > limits.max_pose:
        return None, [f"The poses of {name} are more than {limits.max_pose:g} m away, and are left out."]
    if outside == 1:
        notes.append(f"1 scan is before the first or after the last pose of {name}; it gets the nearest.")
    elif outside:
        notes.append(f"{outside} scans are before the first or after the last pose of {name}; they get the nearest.")
    timed = None if stated is None else _timed(stated, shift, offset, limits)
    names = (source.frame_id, source.child_frame_id)
    return Trajectory(planar, source.sentence, *names, timed=timed, offset=offset), notes


def _timed(stated: StatedPoses, shift_ns: int, offset: Offset, limits: Limits) -> TimedPoses | None:
    """Return poses with stamps; None where they are beyond the limit of coordinates, or where a clock began again.

    Then a time would be that of several poses.
    """
    poses = stated.poses - np.array([*offset, 0.0])
    if np.abs(poses[:, :2]).max() > limits.max_pose or not (stated.stamps_ns == stated.counted_ns).all():
        return None
    return TimedPoses(stated.stamps_ns - shift_ns, poses)


def odometry_among(
    sources: Iterable[PoseSource], trajectories: Mapping[str, Trajectory], when: Moments
) -> OdometryRecords | None:
    """Return the poses of the first source that is odometry, messages before tf; None where there is none.

    The times ``when`` of the scans place them among the messages, in the order of the stamps.
    """
    found = [source for source in sources if source.is_odometry and source.name in trajectories]
    for source in sorted(found, key=lambda source: source.name.startswith("tf/")):
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
