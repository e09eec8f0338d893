"""Which poses of a log are its odometry, and which scans are matched."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, interpolate, inverse
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig

Float64Array = NDArray[np.float64]


def odometry_name(log: ScanLog) -> str | None:
    """Return the trajectory to begin with: the first in a frame ``odom``, else the log's first; None for none.

    Placeholders and poses that never change are none: then the scans alone count.
    """
    moving = [
        name
        for name, one in log.trajectories.items()
        if not one.is_placeholder and len(one.poses) and np.ptp(one.poses, axis=0).any()
    ]
    raw = [name for name in moving if (log.trajectories[name].frame_id or "").strip("/").endswith("odom")]
    found = raw or moving
    return found[0] if found else None


def motions(poses: Float64Array) -> Float64Array:
    """Return the motion (n − 1, 3) from each pose (n, 3) to the next."""
    return compose(inverse(poses[:-1]), poses[1:])


def matched_scans(n_scans: int, poses: Float64Array | None, config: SlamConfig) -> NDArray[np.int64]:
    """Return the scans to match: those at which the odometry ``poses`` (n_scans, 3) moved or turned enough.

    The first and the last are always matched. Where they are more than ``max_nodes``, the distances are doubled until
    they are not. Without odometry (None) it is all scans, or ``max_nodes`` of them, evenly spread.
    """
    if poses is None:
        most = int(config.max_nodes)
        return np.arange(n_scans) if n_scans <= most else np.linspace(0, n_scans - 1, most).astype(np.int64)
    distance, turn = config.node_distance, config.node_turn
    while True:
        found = _spaced(poses, distance, turn)
        if len(found) <= config.max_nodes:
            return found
        distance, turn = max(2.0 * distance, 0.01), max(2.0 * turn, 0.01)


def _spaced(poses: Float64Array, distance: float, turn: float) -> NDArray[np.int64]:
    steps = motions(poses)
    moved = np.hypot(steps[:, 0], steps[:, 1]).tolist()
    turned = np.abs(steps[:, 2]).tolist()
    found, way, angle = [0], 0.0, 0.0
    for k in range(len(moved)):
        way += moved[k]
        angle += turned[k]
        if way >= distance or angle >= turn:
            found.append(k + 1)
            way = angle = 0.0
    if found[-1] != len(poses) - 1:
        found.append(len(poses) - 1)
    return np.array(found, dtype=np.int64)


def carry(nodes: NDArray[np.int64], node_poses: Float64Array, odometry: Float64Array | None) -> Float64Array:
    """Return poses (n, 3) of the scans up to the last node: those of the nodes (m,), and between them the odometry.

    ``odometry`` (n, 3) is chained from the node before and from the node after, and the difference of the two is
    distributed in proportion to the motion. Without it (None) poses are interpolated by the number of the scan.
    """
    every = np.arange(int(nodes[-1]) + 1)
    low = np.clip(np.searchsorted(nodes, every, side="right") - 1, 0, max(0, len(nodes) - 2))
    high = np.minimum(low + 1, len(nodes) - 1)
    if odometry is None:
        share = (every - nodes[low]) / np.maximum(nodes[high] - nodes[low], 1)
        return interpolate(node_poses[low], node_poses[high], share)
    odometry = odometry[: len(every)]
    from_low = compose(inverse(odometry[nodes[low]]), odometry)
    from_high = compose(inverse(odometry[nodes[high]]), odometry)
    forward, backward = compose(node_poses[low], from_low), compose(node_poses[high], from_high)
    amount = [np.hypot(one[:, 0], one[:, 1]) + 0.5 * np.abs(one[:, 2]) + 1e-9 for one in (from_low, from_high)]
    weight = amount[0] / (amount[0] + amount[1])
    out = compose(forward, compose(inverse(forward), backward) * weight[:, np.newaxis])
    out[nodes] = node_poses
    return out
