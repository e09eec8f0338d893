"""Agreement of all scans of a map with one another, by which two graphs of the same scans are compared."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.slam.kernels.agreement import count_agreement
from mapper.slam.loop_test import GATE
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import AROUND, EVERY, OTHERS, spread

APART = 20.0  #: metres of the way: scans nearer than this agree whatever the loops are
MOST_SCANS = 2_000  #: that are compared with others, so that the time grows with the number of scans


def count_map_agreement(store: ScanStore, poses: Float64Array) -> tuple[int, int, int]:
    """Return how many points were compared, how many lie on a wall of other scans, and how many in their free space.

    ``poses`` (n, 3), ``T_map_base``, are those of the scans of the store. Every metre of the way a scan is compared
    with those taken near its pose at least :data:`APART` metres of the way before or after it, as
    :func:`mapper.slam.kernels.agreement.count_agreement` counts.
    """
    way = np.r_[0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))]
    step = max(EVERY, float(way[-1]) / MOST_SCANS)
    counts, total = np.empty(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    for k in np.unique(np.searchsorted(way, np.arange(0.0, way[-1], step))).tolist():
        near = np.hypot(*(poses[:, :2] - poses[k, :2]).T) < AROUND
        others = np.flatnonzero(near & (np.abs(way - way[k]) > APART))
        if len(others):
            count_agreement(store.arrays, k, poses[k], spread(others, OTHERS), poses, GATE, 2, counts)
            total += counts
    points, agreeing, contradicting = total.tolist()
    return points, agreeing, contradicting


def map_score(store: ScanStore, poses: Float64Array, loop_contradicted: float) -> float:
    """Return the score by which two graphs of the same scans are compared: the greater, the better.

    It is the number of points that agree, less those that contradict, each of which counts as 1 / ``loop_contradicted``
    points: a map in which that share of the points contradicts scores less than one whose scans never meet again.
    """
    _, agreeing, contradicting = count_map_agreement(store, poses)
    return agreeing - contradicting / max(loop_contradicted, 1e-3)
