"""Sources of poses in a recording, and the robot's pose at each scan by each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.limits import Limits
from mapper.io.logs.transforms import Poses3
from mapper.sensors.scan import Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses, number_before

Int64Array = NDArray[np.int64]
STAMP_LIMIT_NS = 4_000_000_000 * 1_000_000_000  #: the difference of two stamps must fit 64 bits
STILL = "standing still"


@dataclass(frozen=True, slots=True)
class PoseSource:
    """Poses: ``at`` n times, as far as the source ``covers`` (n,) them; ``T_frame_child`` of two frames by name.

    ``timed`` returns them with their own stamps. Its clock is ``ahead_ns`` ahead of the scans' one, as far as the
    recorder tells. ``is_odometry`` says that they are counted from the robot's own motion.
    """

    name: str
    frame_id: str
    child_frame_id: str
    sentence: str
    at: Callable[[Int64Array], Poses3]
    covers: Callable[[Int64Array], NDArray[np.bool_]]
    timed: Callable[[], TimedPoses | None]
    ahead_ns: int
    is_odometry: bool


def trajectories_at(
    stamps_ns: Int64Array, sources: Iterable[PoseSource], base_frame: str, limits: Limits
) -> tuple[dict[str, Trajectory], list[str]]:
    """Return what each source says of the scans' times, in its order, and what is to be noted; at least one trajectory.

    Without a usable source, that is a placeholder: ``base_frame`` at the origin of itself.

    A source whose poses are from another time than the scans is left out, unless their clocks alone differ: then both
    are put together by when they were recorded.
    """
    found: dict[str, Trajectory] = {}
    notes: list[str] = []
    is_any = False
    for source in sources:
        is_any = True
        trajectory, more = _at(stamps_ns, source, limits)
        notes += more
        if trajectory is not None:
            found[source.name] = trajectory
    if not found:
        notes.append(
            "None of the file's poses can be used, so the map shows all scans as from one place."
            if is_any
            else "The file holds no poses, so the map shows all scans as from one place: record /tf and /tf_static, or "
            "the odometry, together with the scans."
        )
        found[STILL] = Trajectory(
            np.zeros((len(stamps_ns), 3)),
            "no poses in the file: one place for all scans",
            frame_id=base_frame,
            child_frame_id=base_frame,
            is_placeholder=True,
        )
    return found, notes


def _at(stamps_ns: Int64Array, source: PoseSource, limits: Limits) -> tuple[Trajectory | None, list[str]]:
    name, ahead = source.name, source.ahead_ns
    notes = []
    timed = source.timed()
    covered = source.covers(stamps_ns)
    if not covered.any() and 0 < abs(ahead) < STAMP_LIMIT_NS:
        stamps_ns = stamps_ns + ahead
        timed = None if timed is None else TimedPoses(timed.stamps_ns - ahead, timed.poses)
        covered = source.covers(stamps_ns)
        apart = f"{abs(ahead) / 1e9:,.1f} s {'ahead of' if ahead > 0 else 'behind'}"
        notes.append(
            f"The clock of {name} is {apart} that of the scans; each scan gets the pose of when it was recorded."
        )
    outside = int(np.count_nonzero(~covered))
    if outside == len(covered):
        why = "are from another time than the scans, and are left out: let all that is recorded have one clock"
        return None, [f"The poses of {name} {why}."]
    planar = np.broadcast_to(source.at(stamps_ns).planar, (len(covered), 3))
    if np.abs(planar[:, :2]).max() > limits.max_pose:
        return None, [f"The poses of {name} are more than {limits.max_pose:g} m away, and are left out."]
    if outside == 1:
        notes.append(f"1 scan is before the first or after the last pose of {name}; it gets the nearest.")
    elif outside:
        notes.append(f"{outside} scans are before the first or after the last pose of {name}; they get the nearest.")
    return Trajectory(planar, source.sentence, source.frame_id, source.child_frame_id, timed=timed), notes


def odometry_among(
    sources: Iterable[PoseSource], trajectories: Mapping[str, Trajectory], stamps_ns: Int64Array
) -> OdometryRecords | None:
    """Return the poses of the first source that is odometry, messages before tf; None where there is none.

    ``stamps_ns`` (n_scans,) place the scans among them: in the order of the stamps.
    """
    found = [source for source in sources if source.is_odometry and source.name in trajectories]
    for source in sorted(found, key=lambda source: source.name.startswith("tf/")):
        trajectory = trajectories[source.name]
        if trajectory.timed is not None:
            messages = trajectory.timed.in_order()
            before = number_before(messages.stamps_ns, stamps_ns)
            before[stamps_ns < messages.stamps_ns[0]] = -1
            return OdometryRecords(messages, before, trajectory.poses)
    return None
