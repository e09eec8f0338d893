"""Path test of a loop: whether the scans on the path to it contradict the scans among which the loop places them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.se2 import compose, inverse
from mapper.slam.kernels.agreement import count_agreement
from mapper.slam.kernels.graph_distance import ways_from
from mapper.slam.loop_test import GATE, Loop
from mapper.slam.scan_store import ScanStore

BEFORE, EVERY = 10.0, 1.0  #: metres of path before the loops, and between two scans, that are examined
AROUND, OTHERS = 4.0, 8  #: metres, and number of scans near a placed scan with which it is compared
BACK = 2  #: number of these that are compared back with the scans on the path


def graph_ways(node: int, driven: Float64Array, loops: Sequence[Loop]) -> Float64Array:
    """Return the path length (n,) in the graph from a node to each node, metres; ``driven`` (n,) is the metres
    driven.
    """
    ends = np.array([(loop.i, loop.j) for loop in loops], dtype=np.int64).reshape(-1, 2)
    out = np.empty(len(driven))
    ways_from(node, driven, np.ascontiguousarray(ends[:, 0]), np.ascontiguousarray(ends[:, 1]), out)
    return out


def share_contradicted(
    store: ScanStore, loops: Sequence[Loop], poses: Float64Array, driven: Float64Array, is_earlier: BoolArray
) -> float:
    """Return the fraction of points on the path to the loops that lie in free space of other scans, and vice versa.

    ``poses`` (n, 3) and ``driven`` (n,), metres driven, are those of all scans. Each scan from :data:`BEFORE` metres
    before the first loop on is placed by the nearest loop in the chain. These scans are compared with nearby scans that
    are ``is_earlier`` (n,), and the latter with them; 0 if there are none.
    """
    ends = np.array([loop.j for loop in loops])
    later = np.flatnonzero(driven >= max(float(driven[ends].min()) - BEFORE, 0.0))
    moved = [compose(compose(poses[loop.i], loop.relative), inverse(poses[loop.j])) for loop in loops]
    nearest = np.argmin(np.abs(driven[ends][np.newaxis] - driven[later][:, np.newaxis]), axis=1)
    placed = poses.copy()
    placed[later] = compose(np.array(moved)[nearest], poses[later])
    earlier = np.flatnonzero(is_earlier[: later[0]])
    scans = store.arrays
    counts, total = np.empty(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    samples = np.searchsorted(driven, np.arange(driven[later[0]], driven[-1], EVERY))
    for k in np.unique(samples).tolist():
        near = earlier[np.hypot(*(placed[earlier, :2] - placed[k, :2]).T) < AROUND]
        if not len(near):
            continue
        count_agreement(scans, k, placed[k], spread(near, OTHERS), placed, GATE, 2, counts)
        total += counts
        there = later[np.hypot(*(placed[later, :2] - placed[k, :2]).T) < AROUND]
        for index in spread(near, BACK).tolist():
            count_agreement(scans, index, placed[index], spread(there, OTHERS), placed, GATE, 2, counts)
            total += counts
    return float(total[2]) / max(int(total[0]), 1)


def spread(values: Int64Array, most: int) -> Int64Array:
    """Return at most ``most`` evenly spaced values, including the first and the last."""
    if len(values) <= most:
        return values
    return values[np.linspace(0, len(values) - 1, most).round().astype(np.int64)]
