"""Loop closure: scans matched with submaps of places visited long before."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
from mapper.slam.config import SlamConfig
from mapper.slam.front_end import FrontEnd
from mapper.slam.kernels.graph_distance import least_of_ranges
from mapper.slam.loop_test import Loop, Place, share_contradicted_mutually, try_loop
from mapper.slam.matching_rules import pair_rule
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import BEFORE, graph_ways, share_contradicted

KEPT_PLACES = 24  #: submaps cached, most recently searched
WINDOW, DRIFT = 1.0, 0.03  #: metres, and metres per metre of path in the graph, that a pose may be off
TURN_WINDOW, TURN_DRIFT = 0.15, 0.003  #: radians, and radians per metre
SIGHT = 3.0  #: metres: a scan sees nearly the same part of a place from this distance
LEAST_WAY = 8.0  #: metres driven since the last scan of a submap for it to form a loop
MOST_ATTEMPTS = 2_000  #: over a path; beyond it their spacing grows, so their number is logarithmic
CANDIDATES = 2  #: submaps searched in one attempt
FAR = 20.0  #: metres of path in the graph, beyond which the window is so wide that places may be confused
SURE = 15.0  #: metres of path in the graph within which relative poses of scans are reliable


class LoopCloser:
    """Searches for loops from the newest scan to finished submaps of the front end."""

    def __init__(self, store: ScanStore, front_end: FrontEnd, config: SlamConfig) -> None:
        self._store, self._front_end, self._config = store, front_end, config
        self._rule = pair_rule(store.least_step)
        self._places: OrderedDict[int, Place] = OrderedDict()
        self._way_of_last_attempt = -np.inf

    def try_at(self, j: int, poses: Float64Array, driven: Float64Array, loops: list[Loop]) -> list[Loop]:
        """Search for loops from node j; ``poses`` (j + 1, 3) are ``T_map_base``, ``driven`` (j + 1,) the metres driven.

        ``loops`` are those accepted before.
        """
        distance = max(self._config.loop_distance, float(driven[j]) / MOST_ATTEMPTS)
        if driven[j] - self._way_of_last_attempt < distance:
            return []
        self._way_of_last_attempt = driven[j]
        tried = []
        for submap, anchor, drift in self._near(j, poses, driven, loops):
            loop = self._search(submap, anchor, j, poses, drift)
            if loop.accepted and drift > FAR:
                loop = self._checked(loop, submap, poses, driven, loops)
            tried.append(loop)
            if loop.accepted:
                break
        return tried

    def _near(
        self, j: int, poses: Float64Array, driven: Float64Array, loops: list[Loop]
    ) -> list[tuple[int, int, float]]:
        """Return the submaps to search, each with its nearest node and the path length to it in the graph."""
        submaps = np.array(self._front_end.submaps, dtype=np.int64).reshape(-1, 2)
        if not len(submaps):
            return []
        away = np.hypot(poses[:, 0] - poses[j, 0], poses[:, 1] - poses[j, 1])
        nearest = np.empty(len(submaps), dtype=np.int64)
        begin, end = np.ascontiguousarray(submaps[:, 0]), np.ascontiguousarray(submaps[:, 1])
        least_of_ranges(away, begin, end, nearest)
        is_old = driven[j] - driven[end - 1] > LEAST_WAY
        is_near = away[nearest] < self._config.loop_window + SIGHT
        if not (is_old & is_near).any():
            return []
        drift = graph_ways(j, driven, loops)
        window = np.minimum(WINDOW + DRIFT * drift[nearest], self._config.loop_window)
        near = np.flatnonzero(is_old & (away[nearest] < window + SIGHT))
        order = near[np.argsort(away[nearest[near]], kind="stable")][:CANDIDATES]
        return [(int(k), int(nearest[k]), float(drift[nearest[k]])) for k in order]

    def _search(self, submap: int, anchor: int, j: int, poses: Float64Array, drift: float) -> Loop:
        guess = compose(self._front_end.poses[anchor], compose(inverse(poses[anchor]), poses[j]))
        window = min(WINDOW + DRIFT * drift, self._config.loop_window)
        turn_window = min(TURN_WINDOW + TURN_DRIFT * drift, 0.6)
        place = self._place(submap)
        return try_loop(self._store, self._config, self._rule, place, anchor, j, guess, window, turn_window)

    def _checked(self, loop: Loop, submap: int, poses: Float64Array, driven: Float64Array, loops: list[Loop]) -> Loop:
        """Return an accepted loop, refused if the scans on the path, or the loop and its place, contradict each other.

        One scan may fit a place that looks like another, but the scans before it rarely do. Only scans placed reliably
        relative to the loop's first scan are used; others are affected by their own drift.
        """
        most = self._config.loop_contradicted
        is_earlier = graph_ways(loop.i, driven, loops) <= SURE
        is_earlier &= driven < driven[loop.j] - BEFORE - LEAST_WAY
        share = share_contradicted(self._store, [loop], poses, driven, is_earlier)
        if share > most:
            reason = f"on the way there {100 * share:.0f} % of the points are where the earlier scans saw free space"
            return replace(loop, reason=reason)
        share = share_contradicted_mutually(self._store, self._place(submap), loop)
        if share > most:
            reason = (
                f"{100 * share:.0f} % of the points of the scan and the earlier ones are in free space of the other"
            )
            return replace(loop, reason=reason)
        return loop

    def _place(self, submap: int) -> Place:
        if submap in self._places:
            self._places.move_to_end(submap)
            return self._places[submap]
        members = np.arange(*self._front_end.submaps[submap])
        place = Place.of(self._store, members, self._front_end.poses, self._config.range_max)
        self._places[submap] = place
        if len(self._places) > KEPT_PLACES:
            self._places.popitem(last=False)
        return place
