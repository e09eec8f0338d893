"""Test of a loop: a scan is matched with the scans of a place, and refused for one of several reasons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.se2 import compose, inverse
from mapper.matching.kernels.point_to_line import refine_pose
from mapper.matching.kernels.types import PairRule
from mapper.slam.config import SlamConfig
from mapper.slam.fields import ScoreField
from mapper.slam.kernels.agreement import count_agreement, count_common
from mapper.slam.matching_rules import LOOP_ITERATIONS, information_of
from mapper.slam.scan_store import ScanStore

#: metres, metres, radians: coarser than in the front end, because windows are wide; the alignment converges within 0.4
#: m
RESOLUTION, SIGMA, TURN = 0.1, 0.12, 0.025
LEVELS = 4  #: of branch and bound, starting at squares of 16 cells, 1.6 m
SCANS = 6  #: scans of the place with which a matched pose is aligned
LEAST_PAIRS = 30  #: pairs of points: fewer are one short wall, which leaves a direction undetermined
GATE = 0.15  #: metres: points closer than this are on the same wall
PRIOR = np.full(3, 1e-3)  #: weight of the correlation's pose in the alignment, in pairs of points
FARTHEST_SHIFT = 0.4  #: metres between the correlation's pose and the aligned one


@dataclass(frozen=True, slots=True)
class Loop:
    """A tested loop from node ``i`` to node ``j``, the later one.

    ``score`` is the correlation's, 0 to 1, ``inliers`` the fraction of points on the walls of the earlier scans.
    ``reason`` is why it was refused, "" for an accepted loop, whose edge is ``relative`` (3,) and ``information`` (3,
    3).
    """

    i: int
    j: int
    score: float
    inliers: float
    reason: str
    relative: Float64Array
    information: Float64Array

    @property
    def accepted(self) -> bool:
        """Whether the loop became an edge."""
        return not self.reason


@dataclass(frozen=True, slots=True)
class Place:
    """Scans ``members`` (k,) of a store that saw one place, drawn into a field at ``poses`` (n_scans, 3) of all scans.

    The poses are in a frame of the place; ``levels`` is the field's pyramid.
    """

    members: Int64Array
    poses: Float64Array
    field: ScoreField
    levels: NDArray[np.uint8]

    @classmethod
    def of(cls, store: ScanStore, members: Int64Array, poses: Float64Array, range_max: float) -> Place:
        """Return the place of these scans."""
        at = poses[members, :2]
        centre = 0.5 * (at.min(axis=0) + at.max(axis=0))
        reach = max(store.farthest(int(k)) for k in members) + 0.5 * float(np.ptp(at, axis=0).max())
        field = ScoreField(centre, min(reach, range_max) + 1.0, RESOLUTION, SIGMA)
        for k in members:
            field.add(store.arrays, int(k), poses[k])
        return cls(members, poses, field, field.pyramid(LEVELS))


def try_loop(
    store: ScanStore,
    config: SlamConfig,
    rule: PairRule,
    place: Place,
    anchor: int,
    j: int,
    guess: Float64Array,
    window: float,
    turn_window: float,
) -> Loop:
    """Match scan j with a place, from ``guess`` (3,) in its frame.

    ``window`` (metres) and ``turn_window`` (radians) are the search window to each side of the guess. The first node of
    a refused loop is ``anchor``, that of an accepted loop the scan with most in common.
    """
    scans, local, members = store.arrays, place.poses, place.members
    least = config.loop_score
    match, score = place.field.search_pyramid(place.levels, scans, j, guess, window, turn_window, TURN, 3, least)

    def refused(reason: str, inliers: float = 0.0) -> Loop:
        return Loop(anchor, j, score, inliers, reason, np.zeros(3), np.zeros((3, 3)))

    if score <= 0.0:
        return refused(f"no pose in the window scores {least:.2f}")
    others = _with_most_in_common(store, place, j, match)
    pose, hessian = match.copy(), np.empty((3, 3))
    pairs = refine_pose(scans, j, scans, others, local, match, PRIOR, rule, LOOP_ITERATIONS, pose, hessian)[0]
    counts = np.empty(3, dtype=np.int64)
    count_agreement(scans, j, pose, members, local, GATE, 1, counts)
    points, agreeing, contradicting = counts.tolist()
    inliers = agreeing / max(points, 1)
    if pairs < LEAST_PAIRS or agreeing < LEAST_PAIRS:
        return refused(f"only {min(pairs, agreeing)} points correspond", inliers)
    if inliers < config.loop_inliers:
        return refused(f"only {100 * inliers:.0f} % of the points are on walls of the earlier scans", inliers)
    if contradicting > config.loop_contradicted * points:
        part = 100 * contradicting / points
        return refused(f"{part:.0f} % of the points are where the earlier scans saw free space", inliers)
    if np.hypot(*(pose - match)[:2]) > FARTHEST_SHIFT:
        return refused("the alignment leaves the place that the correlation found", inliers)
    first = int(others[0])
    information = information_of(hessian, float(pose[2]), PRIOR)
    return Loop(first, j, score, inliers, "", compose(inverse(local[first]), pose), information)


def share_contradicted_mutually(store: ScanStore, place: Place, loop: Loop) -> float:
    """Return the fraction of visible points, of a loop's later scan and of the place, in the other's free space.

    A scan far from the end of a corridor may fit a place near that end: few of its points contradict the place, but the
    place's end lies in the scan's free space. The place's scans used are those with most in common with the scan.
    """
    scans, members = store.arrays, place.members
    # The later scan may be newer than the poses of the place.
    placed = np.zeros((loop.j + 1, 3))
    placed[: len(place.poses)] = place.poses[: loop.j + 1]
    placed[loop.j] = compose(place.poses[loop.i], loop.relative)
    counts = np.empty(3, dtype=np.int64)
    count_agreement(scans, loop.j, placed[loop.j], members, placed, GATE, 1, counts)
    agreeing, contradicting = int(counts[1]), int(counts[2])
    later = np.array([loop.j])
    for k in _with_most_in_common(store, place, loop.j, placed[loop.j]).tolist():
        count_agreement(scans, k, placed[k], later, placed, GATE, 1, counts)
        agreeing += int(counts[1])
        contradicting += int(counts[2])
    return contradicting / max(agreeing + contradicting, 1)


def _with_most_in_common(store: ScanStore, place: Place, j: int, pose: Float64Array) -> Int64Array:
    """Return the scans of a place with most points in common with scan j at ``pose``, in descending order."""
    common = np.empty(len(place.members), dtype=np.int64)
    count_common(store.arrays, j, pose, place.members, place.poses, 2.0 * GATE, 4, common)
    return place.members[np.argsort(-common, kind="stable")[:SCANS]]
