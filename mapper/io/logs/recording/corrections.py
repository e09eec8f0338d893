"""Motion of a robot in a fixed frame that is related to its odometry frame by a transform with corrections.

A localiser publishes ``map → odom``, and the wheels ``odom → base_link`` (REP 105). tf2 looks up each of the two at the
time of a scan, interpolated between the transforms around it (``TimeCache::getData``). For a localiser's transforms
this is not what was intended, for three reasons:

- The last correction is repeated until there is a new one, so that tf2 holds each and then jumps: AMCL with each scan,
  slam_toolbox every 20 ms. Repetitions count as one correction here, made when it was first published.
- AMCL and slam_toolbox stamp it ahead by ``transform_tolerance`` or ``transform_timeout``, so that others need not wait
  for the next one; tf2 then looks up an older one. Here it applies from the odometry from which it was computed.
- Between two corrections the wheels drift gradually while driving. If odometry is reset by the step of the correction,
  each correction holds until the next. The alternative with the smoother robot motion is used. A step far beyond any
  drift is made by the localiser, for example by loop closure or by setting a pose, and no scan lies between its two
  sides.

A drift is distributed along the odometry (:func:`shared_out`) according to its usual model (Thrun, Burgard, Fox 2005,
section 5.4): heading errors grow with rotation, and less with distance; position errors grow with distance. Between two
corrections the robot thus follows the odometry's path, bent to meet both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.se2 import wrap_angle
from mapper.io.logs.recording.poses3 import Poses3, angles_between, interpolated, rotated
from mapper.io.logs.recording.timeline import Moments, Timeline
from mapper.io.logs.recording.transforms import FrameTree, Path

LEAST_AHEAD_NS, MOST_AHEAD_NS = 50_000_000, 3_000_000_000  #: by which corrections are stamped ahead
DENSER = 1.5  #: ratio of pose rates above which odometry determines the motion between another source's poses
TURN_M = 0.5  #: metres of path per radian of turn
MOST_DRIFT = 0.5  #: of the driven path: a larger step is not due to the wheels
HEADING_PER_M = 0.1  #: radians of turning per metre of path, when a drift of the heading is distributed
FAR_M, FAR_RAD = 0.5, 0.3  #: larger jumps are reported
FEW_LEAPS, MOST_LEAPS = 3, 0.1  #: up to this number, or up to this fraction of all steps, they are reported
SAME_M = 1e-6  #: metres, and quaternion components: smaller differences are repetitions

Odometry = Callable[[Moments], Poses3]  #: the robot's poses at n times


@dataclass(frozen=True, slots=True)
class Corrections:
    """The transform between two fixed frames, interpolated between m ``values`` at ``stamps_ns`` (m,), ascending.

    Of two values at one time the first holds before it, and the second from then on. ``ahead_ns`` is by how much the
    corrections were stamped ahead, and ``leaps`` are those that are not drift.
    """

    stamps_ns: Int64Array
    values: Poses3
    ahead_ns: int = 0
    leaps: tuple[Leap, ...] = ()

    def at(self, stamps_ns: Int64Array) -> Poses3:
        """Return the transform at n times; the first before all, the last after all."""
        if len(self.stamps_ns) == 1:
            return self.values
        low = np.clip(np.searchsorted(self.stamps_ns, stamps_ns, side="right") - 1, 0, len(self.stamps_ns) - 2)
        spans = self.stamps_ns[low + 1] - self.stamps_ns[low]
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(spans > 0, np.clip((stamps_ns - self.stamps_ns[low]) / spans, 0.0, 1.0), 1.0)
        return interpolated(self.values[low], self.values[low + 1], shares)


def shared_out(
    stamps_ns: Int64Array, values: Poses3, odometry: Odometry, odometry_ns: Int64Array, held: NDArray[np.bool_]
) -> Corrections:
    """Return corrections interpolated between k values, each made at one of ``stamps_ns`` (k,), according to drift.

    ``odometry`` is known at ``odometry_ns`` (m,). At steps that are ``held`` (k − 1,), the earlier value holds until
    the next.
    """
    steps = np.arange(len(stamps_ns) - 1)
    if not len(steps):
        return Corrections(stamps_ns, values)
    inside = odometry_ns[(odometry_ns > stamps_ns[0]) & (odometry_ns < stamps_ns[-1])]
    times = np.concatenate([inside, stamps_ns[:-1], stamps_ns[1:]])
    step = np.concatenate([np.searchsorted(stamps_ns, inside, side="right") - 1, steps, steps])
    order = np.lexsort((times, step))
    times, step = times[order], step[order]
    first = np.searchsorted(step, steps)
    last = np.append(first[1:], len(step)) - 1
    poses = odometry(Moments(times))
    moved = np.diff(poses.positions, axis=0)
    moved[step[1:] != step[:-1]] = 0.0
    driven = np.linalg.norm(moved, axis=1)
    turned = np.where(step[1:] == step[:-1], angles_between(poses[:-1], poses[1:]), 0.0)

    def shares(passed: Float64Array) -> Float64Array:
        """Return the cumulative fraction of each step's sum of these (m − 1,) at (m,): of the time, if the sum is 0."""
        total = np.append(0.0, np.cumsum(passed))
        of_step = (total[last] - total[first])[step]
        of_time = (times - times[first][step]) / (times[last] - times[first])[step]
        with np.errstate(divide="ignore", invalid="ignore"):
            corrected = np.where(of_step > 0.0, (total - total[first][step]) / of_step, of_time)
        return np.where(held[step], 0.0, corrected)

    rotations = interpolated(values[step], values[step + 1], shares(turned + HEADING_PER_M * driven)).rotations
    moved = 0.5 * (rotated(rotations[:-1], moved) + rotated(rotations[1:], moved))
    path = np.append(np.zeros((1, 3)), np.cumsum(moved, axis=0), axis=0)
    places = (values[:-1] @ poses[first]).positions[step] + path - path[first][step]
    missing = (values[1:] @ poses[last]).positions - places[last]
    places += shares(driven)[:, np.newaxis] * missing[step]
    corrected = Poses3(places - rotated(rotations, poses.positions), rotations)
    return Corrections(
        np.append(times, stamps_ns[-1]),
        Poses3(
            np.append(corrected.positions, values.positions[-1:], axis=0),
            np.append(corrected.rotations, values.rotations[-1:], axis=0),
        ),
    )


class Leap(NamedTuple):
    """A step of the robot, by ``metres`` and ``radians``, that its odometry did not make, at ``stamp_ns``."""

    stamp_ns: int
    metres: float
    radians: float


@dataclass(frozen=True, slots=True)
class Motion:
    """Poses of a path's first frame in its last: ``at`` n times, if known (``covers``, (n,)).

    ``ahead_ns`` is by how much the corrections among its transforms are stamped ahead. ``leaps`` are those that are not
    drift.
    """

    at: Callable[[Moments], Poses3]
    covers: Callable[[Int64Array], NDArray[np.bool_]]
    ahead_ns: int = 0
    leaps: tuple[Leap, ...] = ()


def motion_along(tree: FrameTree, path: Path) -> Motion:
    """Return the motion along a path: by the rules above if it has corrections, else by tf2's."""
    by_tf2 = Motion(partial(tree.lookup, path), partial(tree.covers, path))
    moving = tree.moving_lines(path)
    if len(moving) < 2:
        return by_tf2
    last, line = moving[-1]
    odometry = max((track for _, track in moving[:-1]), key=len)
    below, edge, above = path[: last + 1], path[last : last + 2], path[last + 1 :]
    corrections = None if line.has_runs or odometry.has_runs else _corrections(tree, below, edge, line, odometry)
    if corrections is None:
        return by_tf2

    def at(when: Moments) -> Poses3:
        return tree.lookup(above, when) @ corrections.at(when.stamps_ns) @ tree.lookup(below, when)

    def covers(stamps_ns: Int64Array) -> NDArray[np.bool_]:
        return tree.covers(below, stamps_ns) & tree.covers(edge, stamps_ns + corrections.ahead_ns)

    return Motion(at, covers, corrections.ahead_ns, corrections.leaps)


def _corrections(tree: FrameTree, below: Path, edge: Path, line: Timeline, odometry: Timeline) -> Corrections | None:
    """Return the corrections that ``line`` states along an ``edge``; None if they are as dense as the odometry."""
    when = line.in_order[0]
    values = tree.lookup(edge, when)
    rows = np.column_stack([values.positions, values.rotations])
    is_new = np.append(True, np.abs(np.diff(rows, axis=0)).max(axis=1) > SAME_M)
    known = odometry.in_order[0]
    if np.count_nonzero(is_new) * DENSER > len(known):
        return None
    ahead = _ahead_ns(line, odometry)
    stamps, values = when.stamps_ns[is_new] - ahead, values[is_new]
    driven = partial(tree.lookup, below)
    poses = driven(known)

    def corrections_of(held: NDArray[np.bool_]) -> Corrections:
        return replace(shared_out(stamps, values, driven, known.stamps_ns, held), ahead_ns=ahead)

    held, none = corrections_of(np.ones(len(stamps) - 1, dtype=np.bool_)), np.zeros(len(stamps) - 1, dtype=np.bool_)
    if _roughness(held.at(known.stamps_ns) @ poses) < _roughness(corrections_of(none).at(known.stamps_ns) @ poses):
        return held
    are_leaps, leaps = leaps_of(stamps, values, driven, known)
    return replace(corrections_of(are_leaps), leaps=leaps)


def leaps_of(
    stamps_ns: Int64Array, values: Poses3, odometry: Odometry, known: Moments
) -> tuple[NDArray[np.bool_], tuple[Leap, ...]]:
    """Return which steps (k − 1,) between values made at ``stamps_ns`` (k,) are larger than any drift.

    ``known`` are the times at which the odometry is known. Also included are far jumps of the robot; none if there are
    many, because the odometry is then not a reference for them.
    """
    driven = odometry(known).planar
    distance = np.append(0.0, np.cumsum(_apart(driven[1:], driven[:-1])))
    there = odometry(Moments(stamps_ns[1:]))
    after, before = (values[1:] @ there).planar, (values[:-1] @ there).planar
    between = np.diff(np.interp(stamps_ns, known.stamps_ns, distance))
    are_leaps = np.asarray(_apart(after, before) > MOST_DRIFT * between)
    metres, radians = np.hypot(*(after - before)[:, :2].T), np.abs(wrap_angle(after[:, 2] - before[:, 2]))
    far = np.flatnonzero(are_leaps & ((metres > FAR_M) | (radians > FAR_RAD)))
    if len(far) > max(FEW_LEAPS, MOST_LEAPS * len(are_leaps)):
        return are_leaps, ()
    return are_leaps, tuple(Leap(int(stamps_ns[k + 1]), float(metres[k]), float(radians[k])) for k in far)


def _ahead_ns(line: Timeline, odometry: Timeline) -> int:
    """Return by how much the transforms of ``line`` are usually ahead of the odometry recorded before them, ns.

    0 if that may be delay of the odometry.
    """
    stamps, positions, _ = line.track
    own, before, _ = odometry.track
    number = np.searchsorted(before, positions, side="right") - 1
    stamps, number = stamps[number >= 0], number[number >= 0]
    if not len(stamps):
        return 0
    ahead = int(np.median(stamps - own[number]))
    least = max(LEAST_AHEAD_NS, 2 * int(np.median(np.abs(np.diff(own)))))
    return ahead if least <= ahead <= MOST_AHEAD_NS else 0


def _apart(first: Float64Array, other: Float64Array) -> Float64Array:
    """Return the distance (n,) between planar poses (n, 3), metres, including turns."""
    difference = first - other
    return np.asarray(np.hypot(difference[:, 0], difference[:, 1]) + TURN_M * np.abs(wrap_angle(difference[:, 2])))


def _roughness(poses: Poses3) -> float:
    """Return the total change between steps of a motion: metres, including turns."""
    planar = poses.planar
    steps = np.diff(planar, axis=0)
    steps[:, 2] = wrap_angle(steps[:, 2])
    return float(_apart(steps[1:], steps[:-1]).sum())
