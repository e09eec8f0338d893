"""Place recognition: loops with a larger error than the window search covers.

Each submap, some metres of path, is a local map (:mod:`mapper.slam.local_map`). Its corners are paired with those of
earlier submaps by their descriptors, and RANSAC finds the relative pose. From there, scans of the submap are matched
with the earlier ones as for every loop. A single loop is never accepted, only a group of loops whose relative poses
agree with each other along the driven path between them (Mangelson et al. 2018). The group must span some metres, leave
no direction uncertain, not be contradicted by free space along the path, and have no competing group at another place.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.sensors.pose_graph import PoseGraph
from mapper.slam.config import SlamConfig
from mapper.slam.front_end import FrontEnd
from mapper.slam.kernels.keypoint_pairs import nearest_descriptors, pose_of_pairs
from mapper.slam.local_map import LocalMap, local_map
from mapper.slam.loop_test import Loop, Place, try_loop
from mapper.slam.matching_rules import pair_rule
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import BEFORE, graph_ways, share_contradicted, spread

MOST_STEPS = 20_000  #: of the search, after which the largest group so far is used
STAGE = "place recognition: "  #: prefix of the reasons for refusal
SPACING = 2.5  #: metres of path between the ends of two submaps, so that a place lies well inside one
LEAST_WAY = 20.0  #: metres driven between two submaps for them to form a loop
TURN_WINDOW, TURN_DRIFT, MOST_TURN = 0.3, 0.01, np.pi  #: radians, radians per metre of path, radians
NEAREST = 5  #: descriptors that each corner is paired with
TOLERANCE, LEAST_DISTANCE = 0.3, 1.0  #: metres: of a corner's position, and between the corners of a sample
MOST_SUBMAPS = 60  #: earlier submaps with which a submap is compared
KEPT_MAPS = 500  #: local maps cached, most recently used
VERIFIED = 3  #: earlier submaps whose poses are verified
SCANS = 4  #: scans of a submap that are matched with the earlier one
MEMBERS = 40  #: scans of the earlier submap with which they are matched
WINDOW, TURN = 0.6, 0.15  #: metres, radians: around RANSAC's pose, to each side
MEMORY = 60.0  #: metres of path after which a loop stops waiting for others
LEAST_SPAN = 2.0  #: metres between the two most distant loops of a group: scans at one place are not independent
OFF, OFF_SHARE = 0.3, 0.03  #: metres, and metres per metre driven, that two loops may disagree
TURN_OFF, TURN_OFF_SHARE = 0.06, 0.003  #: radians, and radians per metre driven
MOST_UNCERTAIN = 0.1  #: metres: standard deviation of a group in its least certain direction
CONTRADICTING = (
    0.4  #: of the group's loops, from which other loops that contradict it and agree with one another refuse it
)
LEAST_WEIGHT = 0.5  #: robust kernel weight of a loop with which the graph is consistent


def largest_consistent(consistent: BoolArray) -> Int64Array:
    """Return the indices of the largest group (k,), ascending; ``consistent`` (n, n) is symmetric.

    It is a maximum clique, found by the Bron–Kerbosch algorithm with pivoting (Tomita 2006) and a bound; of equally
    large ones the first found.
    """
    n = len(consistent)
    others = [
        {int(k) for k in np.flatnonzero(row)} - {i} for i, row in enumerate(np.asarray(consistent, dtype=np.bool_))
    ]
    best: list[int] = []
    steps = 0
    # For each open branch: the group so far, the remaining candidates, and the vertices already processed.
    stack: list[tuple[list[int], set[int], set[int]]] = [([], set(range(n)), set())]
    while stack and steps < MOST_STEPS:
        steps += 1
        group, open_, tried = stack.pop()
        if len(group) > len(best):
            best = group
        if len(group) + len(open_) <= len(best):
            continue
        pivot = max(sorted(open_ | tried), key=lambda k: len(open_ & others[k]))
        branches = []
        for k in sorted(open_ - others[pivot]):
            branches.append(([*group, k], open_ & others[k], tried & others[k]))
            open_ = open_ - {k}
            tried = tried | {k}
        stack += reversed(branches)
    return np.array(sorted(best), dtype=np.int64)


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A loop that waits for others: its index in the list of all tried loops."""

    number: int
    loop: Loop


class PlaceRecognizer:
    """Recognizes places from the newest scans of the front end."""

    def __init__(self, store: ScanStore, front_end: FrontEnd, config: SlamConfig) -> None:
        self._store, self._front_end, self._config = store, front_end, config
        self._rule = pair_rule(store.least_step)
        self._submaps: list[Int64Array] = []  # their nodes
        self._maps: OrderedDict[int, LocalMap] = OrderedDict()  # most recently used
        self._next = config.place_length  # metres of path at which the next submap ends
        self._waiting: list[_Waiting] = []

    def try_at(
        self, j: int, poses: Float64Array, driven: Float64Array, loops: list[Loop], tried: list[Loop]
    ) -> list[int]:
        """Search for places from node j and append the tried loops to ``tried``; return the indices of those forming a
        group.

        ``poses`` (j + 1, 3) are ``T_map_base``, ``driven`` (j + 1,) the metres driven, ``loops`` those accepted before.
        Waiting loops are in ``tried`` as refused. A returned group must be passed to :meth:`accept` or :meth:`refuse`.
        """
        if driven[j] < self._next:
            return []
        self._next = driven[j] + SPACING
        members = np.flatnonzero(driven > driven[j] - self._config.place_length)
        self._submaps.append(members)
        # A submap from which a loop was closed already has a known position.
        if any(loop.j >= members[0] for loop in reversed(loops)):
            return []
        drift = graph_ways(j, driven, loops)
        before = len(self._waiting)
        self._recognize(poses, driven, drift, tried)
        if len(self._waiting) == before:
            return []
        self._waiting = [candidate for candidate in self._waiting if driven[candidate.loop.j] > driven[j] - MEMORY]
        return self._group(poses, driven, tried)

    def candidates(self, numbers: Sequence[int]) -> list[Loop]:
        """Return the loops of a returned group."""
        return [candidate.loop for candidate in self._waiting if candidate.number in numbers]

    def accept(self, numbers: Sequence[int], tried: list[Loop]) -> None:
        """Accept the loops of a group. All other waiting loops are dropped."""
        for candidate in self._waiting:
            if candidate.number in numbers:
                tried[candidate.number] = candidate.loop
        self._waiting = []

    def refuse(self, numbers: Sequence[int], tried: list[Loop], reason: str) -> None:
        """Refuse the loops of a group permanently."""
        self._waiting = [candidate for candidate in self._waiting if candidate.number not in numbers]
        for number in numbers:
            tried[number] = refused(tried[number], reason)

    def _map(self, submap: int) -> LocalMap:
        """Return the local map of a submap, in the frame of the node in its middle."""
        if submap in self._maps:
            self._maps.move_to_end(submap)
            return self._maps[submap]
        members = self._submaps[submap]
        self._maps[submap] = local_map(self._store, members, _middle(members), self._front_end.poses)
        if len(self._maps) > KEPT_MAPS:
            self._maps.popitem(last=False)
        return self._maps[submap]

    def _recognize(self, poses: Float64Array, driven: Float64Array, drift: Float64Array, tried: list[Loop]) -> None:
        """Pair the corners of the newest local map with those of earlier ones, and verify the best of the poses."""
        newest = len(self._submaps) - 1
        new = self._submaps[newest]
        origins = np.array([_middle(members) for members in self._submaps])
        last = np.array([members[-1] for members in self._submaps])
        window = self._config.place_drift * drift[origins]
        away = np.hypot(*(poses[origins] - poses[origins[-1]])[:, :2].T)
        possible = np.flatnonzero(
            (driven[new[0]] - driven[last] >= LEAST_WAY) & (away <= window + self._config.place_length)
        )
        # If there are many, those with the least uncertain pose.
        possible = np.sort(possible[np.argsort(away[possible] - window[possible], kind="stable")][:MOST_SUBMAPS])
        recognized: list[tuple[int, int, Float64Array]] = []
        most = 0
        for number in possible.tolist():
            off, origin = float(drift[origins[number]]), origins[number]
            guess = compose(inverse(poses[origin]), poses[origins[-1]])
            turn_window = min(TURN_WINDOW + TURN_DRIFT * off, MOST_TURN)
            pose = np.zeros(3)
            count = _corners_in_common(
                self._map(newest), self._map(number), guess, float(window[number]), turn_window, pose
            )
            if count >= self._config.place_corners:
                recognized.append((count, number, pose))
            most = max(most, count)
        if not recognized and len(possible):
            nearest = int(origins[possible[np.argmin(away[possible])]])
            reason = f"{STAGE}at most {most} corners of an earlier submap correspond"
            tried.append(Loop(nearest, int(origins[-1]), 0.0, 0.0, reason, np.zeros(3), np.zeros((3, 3))))
        for _, number, pose in sorted(recognized, key=lambda item: -item[0])[:VERIFIED]:
            self._verify(self._map(newest), self._map(number), pose, tried)

    def _verify(self, new: LocalMap, old: LocalMap, pose: Float64Array, tried: list[Loop]) -> None:
        """Match scans of the newest submap with an earlier one, starting from the ``pose`` (3,) of the first in the
        second.
        """
        local = self._front_end.poses
        place = Place.of(self._store, spread(old.members, MEMBERS), local, self._config.range_max)
        at = compose(local[old.origin], pose)
        for j in spread(new.members, SCANS).tolist():
            guess = compose(at, compose(inverse(local[new.origin]), local[j]))
            loop = try_loop(self._store, self._config, self._rule, place, old.origin, j, guess, WINDOW, TURN)
            if loop.accepted:
                self._waiting.append(_Waiting(len(tried), loop))
                tried.append(refused(loop, "too few other loops agree with it"))
            else:
                tried.append(refused(loop, loop.reason))

    def _group(self, poses: Float64Array, driven: Float64Array, tried: list[Loop]) -> list[int]:
        """Return the waiting loops that form a group, or none, with the reason, if it is refused."""
        waiting = [candidate.loop for candidate in self._waiting]
        if len(waiting) < self._config.place_group:
            return []
        agree = self._agree(waiting, poses, driven)
        group = largest_consistent(agree)
        if len(group) < self._config.place_group:
            return []
        numbers = [self._waiting[int(k)].number for k in group]
        chosen = [waiting[int(k)] for k in group]
        reason = self._reason_against(chosen, poses, driven)
        others = np.flatnonzero(~agree[group].any(axis=0))
        if not reason and len(others):
            agreeing = len(largest_consistent(agree[np.ix_(others, others)]))
            if agreeing >= CONTRADICTING * len(group):
                reason = f"{agreeing} others agree on another place"
        if reason:
            for number in numbers:
                tried[number] = refused(tried[number], reason)
            return []
        return numbers

    def _agree(self, waiting: list[Loop], poses: Float64Array, driven: Float64Array) -> BoolArray:
        """Return which pairs of loops (n, n) agree: the poses around the cycle of both return to the start."""
        n = len(waiting)
        agree = np.zeros((n, n), dtype=np.bool_)
        measured = np.array([loop.relative for loop in waiting])
        first, second = (np.array([getattr(loop, end) for loop in waiting]) for end in "ij")
        for k in range(n):
            there = compose(measured[k], compose(inverse(poses[second[k]]), poses[second]))
            other = compose(compose(inverse(poses[first[k]]), poses[first]), measured)
            off = compose(inverse(there), other)
            between = np.hypot(*(poses[first] - poses[first[k]])[:, :2].T) + np.abs(driven[second] - driven[second[k]])
            agree[k] = np.hypot(off[:, 0], off[:, 1]) < OFF + OFF_SHARE * between
            agree[k] &= np.abs(wrap_angle(off[:, 2])) < TURN_OFF + TURN_OFF_SHARE * between
        agree &= agree.T
        np.fill_diagonal(agree, val=False)
        return agree

    def _reason_against(self, group: list[Loop], poses: Float64Array, driven: Float64Array) -> str:
        """Return the reason to refuse a group of agreeing loops, "" for none."""
        ends = poses[[loop.j for loop in group], :2]
        span = float(np.hypot(*(ends[:, np.newaxis] - ends).reshape(-1, 2).T).max())
        if span < LEAST_SPAN:
            return f"the loops that agree span only {span:.1f} m"
        total = np.zeros((2, 2))
        for loop in group:
            yaw = float(poses[loop.i, 2] + loop.relative[2])
            c, s = np.cos(yaw), np.sin(yaw)
            turn = np.array([[c, -s], [s, c]])
            total += turn @ _of_place(loop.information) @ turn.T
        uncertain = 1.0 / np.sqrt(max(float(np.linalg.eigvalsh(total)[0]), 1e-12))
        if uncertain > MOST_UNCERTAIN:
            return f"the scans leave one direction uncertain, by {uncertain:.1f} m"
        first = float(driven[[loop.j for loop in group]].min()) - BEFORE
        contradicted = share_contradicted(self._store, group, poses, driven, driven < max(first, 0.0) - LEAST_WAY)
        if contradicted > self._config.loop_contradicted:
            return f"on the way there {100 * contradicted:.0f} % of the points are where earlier scans saw free space"
        return ""


def reason_against_group(before: PoseGraph, after: PoseGraph) -> str:
    """Return the reason to refuse the loops that a graph has beyond ``before``, "" for none.

    ``after`` is optimised, ``before`` has the weights at the previous poses. A group is refused if the robust kernel
    gives it a low weight, or if it removes weight from more than half as many other loops.
    """
    n = len(before.weight)
    if (after.weight[n:] < LEAST_WEIGHT).any():
        return "the rest of the graph contradicts them"
    lost = np.count_nonzero((after.weight[:n] < LEAST_WEIGHT) & (before.weight >= LEAST_WEIGHT))
    if 2 * lost > len(after.weight) - n:
        return f"they contradict {lost} loops that were accepted before"
    return ""


def _corners_in_common(
    new: LocalMap, old: LocalMap, guess: Float64Array, window: float, turn_window: float, pose: Float64Array
) -> int:
    """Write the pose (3,) of the new map in the old one on which most corners agree; return their number."""
    if not len(new.corners) or not len(old.corners):
        return 0
    near = np.empty((len(new.corners), min(NEAREST, len(old.corners))), dtype=np.int64)
    nearest_descriptors(new.descriptors, old.descriptors, near)
    owner, rank = np.nonzero(near >= 0)
    ours, theirs = new.corners[owner], old.corners[near[owner, rank]]
    return pose_of_pairs(ours, theirs, owner, guess, window, turn_window, TOLERANCE, LEAST_DISTANCE, pose)


def _of_place(information: Float64Array) -> Float64Array:
    """Return the information (2, 2) of x and y, marginalised over the angle, from a pose's (3, 3)."""
    part = information[:2, 2:] @ information[2:, :2] / max(float(information[2, 2]), 1e-12)
    return np.asarray(information[:2, :2] - part)


def refused(loop: Loop, reason: str) -> Loop:
    """Return the loop as refused by place recognition."""
    return replace(loop, reason=f"{STAGE}{reason}")


def _middle(members: Int64Array) -> int:
    return int(members[len(members) // 2])
