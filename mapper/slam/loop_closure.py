"""Loop closure: scans matched with submaps of places that the robot was at long before."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.matching.kernels.point_to_line import refine_pose
from mapper.slam.config import SlamConfig
from mapper.slam.fields import ScoreField
from mapper.slam.front_end import FrontEnd
from mapper.slam.kernels.agreement import count_agreement, count_common
from mapper.slam.kernels.graph_distance import least_of_ranges, ways_from
from mapper.slam.matching_rules import LOOP_ITERATIONS, information_of, pair_rule
from mapper.slam.scan_store import ScanStore

Float64Array = NDArray[np.float64]

RESOLUTION, SIGMA, TURN = 0.1, 0.12, 0.025
LEVELS = 4
KEPT_FIELDS = 24  #: of submaps, searched last
WINDOW, DRIFT = 1.0, 0.03  #: metres, and metres for each metre of the way in the graph, that a pose may be off
TURN_WINDOW, TURN_DRIFT = 0.15, 0.003  #: radians, and radians for each metre
SIGHT = 3.0  #: metres: a scan sees as much of a place from so far away
LEAST_WAY = 8.0  #: metres driven since the last scan of a submap, for it to be a loop
CANDIDATES = 2  #: submaps that are searched in one attempt
SCANS = 6  #: of the submap that a found pose is aligned with
LEAST_PAIRS = 30  #: of points
GATE = 0.15  #: metres: points nearer than this to one another are on the same wall
MOST_CONTRADICTED = 0.15  #: share of the points
PRIOR = np.full(3, 1e-3)  #: weight of the correlation's pose in the alignment, in pairs of points
FARTHEST_SHIFT = 0.4  #: metres, between the correlation's pose and the aligned one


@dataclass(frozen=True, slots=True)
class Loop:
    """A loop that was tried, from node ``i`` to node ``j``, the later one.

    ``score`` is the correlation's, 0 … 1, ``inliers`` the share of points on the walls of the earlier scans.
    ``reason`` says why it was refused, "" for an accepted one, of which ``relative`` (3,) and ``information`` (3, 3)
    are the edge.
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
        """Whether it became an edge."""
        return not self.reason


class LoopCloser:
    """Looks for loops from the newest scan to finished submaps of the front end."""

    def __init__(self, store: ScanStore, front_end: FrontEnd, config: SlamConfig) -> None:
        self._store, self._front_end, self._config = store, front_end, config
        self._rule = pair_rule(store.least_step)
        self._pyramids: OrderedDict[int, tuple[ScoreField, NDArray[np.uint8]]] = OrderedDict()
        self._way_of_last_attempt = -np.inf

    def try_at(self, j: int, poses: Float64Array, way: Float64Array, loops: list[Loop]) -> list[Loop]:
        """Look for loops from node j; ``poses`` (j + 1, 3) are ``T_map_base``, ``way`` (j + 1,) the metres driven.

        ``loops`` are those accepted before.
        """
        if way[j] - self._way_of_last_attempt < self._config.loop_distance:
            return []
        self._way_of_last_attempt = way[j]
        tried = []
        for submap, anchor, drift in self._near(j, poses, way, loops):
            loop = self._search(submap, anchor, j, poses, drift)
            tried.append(loop)
            if loop.accepted:
                break
        return tried

    def _near(self, j: int, poses: Float64Array, way: Float64Array, loops: list[Loop]) -> list[tuple[int, int, float]]:
        """Return the submaps to search, each with its node that is nearest and the way to it in the graph."""
        submaps = np.array(self._front_end.submaps, dtype=np.int64).reshape(-1, 2)
        if not len(submaps):
            return []
        away = np.hypot(poses[:, 0] - poses[j, 0], poses[:, 1] - poses[j, 1])
        nearest = np.empty(len(submaps), dtype=np.int64)
        begin, end = np.ascontiguousarray(submaps[:, 0]), np.ascontiguousarray(submaps[:, 1])
        least_of_ranges(away, begin, end, nearest)
        is_old = way[j] - way[end - 1] > LEAST_WAY
        is_near = away[nearest] < self._config.loop_window + SIGHT
        if not (is_old & is_near).any():
            return []
        ends = np.array([(loop.i, loop.j) for loop in loops], dtype=np.int64).reshape(-1, 2)
        drift = np.empty(j + 1)
        ways_from(j, way, np.ascontiguousarray(ends[:, 0]), np.ascontiguousarray(ends[:, 1]), drift)
        window = np.minimum(WINDOW + DRIFT * drift[nearest], self._config.loop_window)
        found = np.flatnonzero(is_old & (away[nearest] < window + SIGHT))
        order = found[np.argsort(away[nearest[found]], kind="stable")][:CANDIDATES]
        return [(int(k), int(nearest[k]), float(drift[nearest[k]])) for k in order]

    def _search(self, submap: int, anchor: int, j: int, poses: Float64Array, drift: float) -> Loop:
        begin, end = self._front_end.submaps[submap]
        local = self._front_end.poses
        guess = compose(local[anchor], compose(inverse(poses[anchor]), poses[j]))
        window = min(WINDOW + DRIFT * drift, self._config.loop_window)
        turn_window = min(TURN_WINDOW + TURN_DRIFT * drift, 0.6)
        field, levels = self._pyramid(submap)
        scans = self._store.arrays
        least = self._config.loop_score
        found, score = field.search_pyramid(levels, scans, j, guess, window, turn_window, TURN, 3, least)

        def refused(reason: str, inliers: float = 0.0) -> Loop:
            return Loop(anchor, j, score, inliers, reason, np.zeros(3), np.zeros((3, 3)))

        if score <= 0.0:
            return refused(f"no pose in the window scores {least:.2f}")
        members = np.arange(begin, end)
        common = np.empty(len(members), dtype=np.int64)
        count_common(scans, j, found, members, local, 2.0 * GATE, 4, common)
        others = members[np.argsort(-common, kind="stable")[:SCANS]]
        pose, hessian = found.copy(), np.empty((3, 3))
        pairs = refine_pose(
            scans,
            j,
            scans,
            others,
            local,
            found,
            PRIOR,
            self._rule,
            LOOP_ITERATIONS,
            pose,
            hessian,
        )[0]
        counts = np.empty(3, dtype=np.int64)
        count_agreement(scans, j, pose, members, local, GATE, 1, counts)
        points, agreeing, contradicting = counts.tolist()
        inliers = agreeing / max(points, 1)
        if pairs < LEAST_PAIRS or agreeing < LEAST_PAIRS:
            return refused(f"only {min(pairs, agreeing)} points correspond", inliers)
        if inliers < self._config.loop_inliers:
            return refused(f"only {100 * inliers:.0f} % of the points are on walls of the earlier scans", inliers)
        if contradicting > MOST_CONTRADICTED * points:
            part = 100 * contradicting / points
            return refused(f"{part:.0f} % of the points are where the earlier scans saw free space", inliers)
        if np.hypot(*(pose - found)[:2]) > FARTHEST_SHIFT:
            return refused("the alignment leaves the place that the correlation found", inliers)
        first = int(others[0])
        information = information_of(hessian, float(pose[2]), PRIOR)
        return Loop(first, j, score, inliers, "", compose(inverse(local[first]), pose), information)

    def _pyramid(self, submap: int) -> tuple[ScoreField, NDArray[np.uint8]]:
        if submap in self._pyramids:
            self._pyramids.move_to_end(submap)
            return self._pyramids[submap]
        begin, end = self._front_end.submaps[submap]
        local = self._front_end.poses
        places = local[begin:end, :2]
        centre = 0.5 * (places.min(axis=0) + places.max(axis=0))
        reach = max(self._store.farthest(k) for k in range(begin, end)) + 0.5 * float(np.ptp(places, axis=0).max())
        field = ScoreField(centre, min(reach, self._config.range_max) + 1.0, RESOLUTION, SIGMA)
        for k in range(begin, end):
            field.add(self._store.arrays, k, local[k])
        self._pyramids[submap] = field, field.pyramid(LEVELS)
        if len(self._pyramids) > KEPT_FIELDS:
            self._pyramids.popitem(last=False)
        return self._pyramids[submap]
