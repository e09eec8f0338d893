"""Choice of the poses of a log that are its odometry, and of the scans that are matched."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, interpolate, inverse
from mapper.sensors.joint_log import part_of_scan, sensors_of
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig

SHORT_S = 0.1  #: seconds: within them scans that are not matched are interpolated without harm
LONG_S = 0.5  #: seconds: poses that are farther apart do not tell the velocity
FAR, FAR_TURN = 0.2, 0.2  #: metres, radians: that the robot may be expected to move from a matched scan to the next


def odometry_name(log: ScanLog) -> str | None:
    """Return the trajectory to begin with: the first in a frame ``odom``, else the log's first; None for none.

    Placeholders and poses that never change are none: then the scans alone count.
    """
    moving = [
        name
        for name, trajectory in log.trajectories.items()
        if not trajectory.is_placeholder and len(trajectory.poses) and np.ptp(trajectory.poses, axis=0).any()
    ]
    raw = [name for name in moving if (log.trajectories[name].frame_id or "").strip("/").endswith("odom")]
    chosen = raw or moving
    return chosen[0] if chosen else None


def motions(poses: Float64Array) -> Float64Array:
    """Return the motion (n − 1, 3) from each pose (n, 3) to the next."""
    return compose(inverse(poses[:-1]), poses[1:])


def matched_scans(sensor: NDArray[np.int64], poses: Float64Array | None, config: SlamConfig) -> NDArray[np.int64]:
    """Return the scans to match: those at which the odometry ``poses`` (n_scans, 3) moved or turned enough.

    The first and the last of each sensor, ``sensor`` (n_scans,), are always matched, and what is enough counts since
    the last matched scan of the same sensor. Where they are more than ``max_nodes``, the distances are doubled until
    they are not. Without odometry (None) it is all scans, or ``max_nodes`` of them, evenly spread;
    :func:`next_scan` passes over some of them.
    """
    if poses is None:
        n, most = len(sensor), int(config.max_nodes)
        return np.arange(n) if n <= most else np.linspace(0, n - 1, most).astype(np.int64)
    distance, turn = config.node_distance, config.node_turn
    own = [np.flatnonzero(sensor == k) for k in np.unique(sensor)]
    while True:
        matched = np.sort(np.concatenate([scans[_spaced(poses[scans], distance, turn)] for scans in own]))
        if len(matched) <= max(config.max_nodes, 2 * len(own)):
            return matched
        distance, turn = max(2.0 * distance, 0.01), max(2.0 * turn, 0.01)


def next_scan(k: int, times: Float64Array, velocity: Float64Array) -> int:
    """Return which of the scans at ``times`` (n,), seconds, to match after scan k without odometry.

    It is the last one within :data:`SHORT_S`, until which a robot that moves on with ``velocity`` (3,), metres and
    radians a second, does not come farther than :data:`FAR` and :data:`FAR_TURN`; scan k + 1 where the times do not
    tell. A longer time would not do, even where the robot seems to stand: along a corridor its motion is not seen.
    """
    speed, turning = float(np.hypot(velocity[0], velocity[1])), abs(float(velocity[2]))
    end = times[k] + min(SHORT_S, FAR / max(speed, 1e-9), FAR_TURN / max(turning, 1e-9)) + 1e-6
    last = k + 1
    while last + 1 < len(times) and times[k] < times[last] < times[last + 1] <= end:
        last += 1
    return last


def sweep_velocities(log: ScanLog, name: str) -> Float64Array:
    """Return the velocity (n_scans, 3) of the base while each scan was taken, by a trajectory, in the base's frame.

    Metres and radians a second; 0 for scans of sensors that do not state the times of their beams.
    """
    out = np.zeros((log.n_scans, 3))
    for number, part in enumerate(sensors_of(log)):
        if part.can_deskew(name):
            times, sweep = seconds(part), (part.n_beams - 1) * part.time_increment
            motion = Motion.of(part, name)
            moved = compose(inverse(motion.at(times)), motion.at(times + sweep))
            out[part_of_scan(log) == number] = moved / sweep
    return out


def velocities_along(times: Float64Array, poses: Float64Array) -> Float64Array:
    """Return the velocity (n, 3) at each of ``poses`` (n, 3), until the next, in its own frame, a second.

    At the last pose, and where the next is later than :data:`LONG_S`, it is that since the one before; 0 where that is
    longer ago too.
    """
    out = np.zeros_like(poses)
    if len(poses) < 2:
        return out
    steps = np.diff(times)
    known = (steps > 0.0) & (steps <= LONG_S)
    velocities = np.where(known[:, np.newaxis], motions(poses) / np.where(known, steps, 1.0)[:, np.newaxis], 0.0)
    out[:-1], out[-1] = velocities, velocities[-1]
    unknown = np.flatnonzero(~known[1:]) + 1
    out[unknown] = velocities[unknown - 1]
    return out


def _spaced(poses: Float64Array, distance: float, turn: float) -> NDArray[np.int64]:
    steps = motions(poses)
    moved = np.hypot(steps[:, 0], steps[:, 1]).tolist()
    turned = np.abs(steps[:, 2]).tolist()
    spaced, driven, angle = [0], 0.0, 0.0
    for k in range(len(moved)):
        driven += moved[k]
        angle += turned[k]
        if driven >= distance or angle >= turn:
            spaced.append(k + 1)
            driven = angle = 0.0
    if spaced[-1] != len(poses) - 1:
        spaced.append(len(poses) - 1)
    return np.array(spaced, dtype=np.int64)


def carry(
    nodes: NDArray[np.int64], node_poses: Float64Array, odometry: Float64Array | None, times: Float64Array
) -> Float64Array:
    """Return poses (n, 3) of the scans up to the last node: those of the nodes (m,), and between them the odometry.

    ``odometry`` (n, 3) is chained from the node before and from the node after, and the difference of the two is
    distributed in proportion to the motion. Without it (None) poses are interpolated by the scans' ``times`` (n,), and
    by their numbers where time does not pass.
    """
    every = np.arange(int(nodes[-1]) + 1)
    low = np.clip(np.searchsorted(nodes, every, side="right") - 1, 0, max(0, len(nodes) - 2))
    high = np.minimum(low + 1, len(nodes) - 1)
    if odometry is None:
        span = times[nodes[high]] - times[nodes[low]]
        share = (every - nodes[low]) / np.maximum(nodes[high] - nodes[low], 1)
        passed = (times[every] - times[nodes[low]]) / np.where(span > 0.0, span, 1.0)
        share = np.where((span > 0.0) & (passed >= 0.0) & (passed <= 1.0), passed, share)
        return interpolate(node_poses[low], node_poses[high], share)
    odometry = odometry[: len(every)]
    from_low = compose(inverse(odometry[nodes[low]]), odometry)
    from_high = compose(inverse(odometry[nodes[high]]), odometry)
    forward, backward = compose(node_poses[low], from_low), compose(node_poses[high], from_high)
    amount = [
        np.hypot(motions[:, 0], motions[:, 1]) + 0.5 * np.abs(motions[:, 2]) + 1e-9 for motions in (from_low, from_high)
    ]
    weight = amount[0] / (amount[0] + amount[1])
    out = compose(forward, compose(inverse(forward), backward) * weight[:, np.newaxis])
    out[nodes] = node_poses
    return out
