"""Selection of a log's odometry, and of the scans to match."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, interpolate, inverse
from mapper.sensors.joint_log import part_of_scan, sensors_of
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig

SHORT_S = 0.1  #: seconds within which unmatched scans can be interpolated
LONG_S = 0.5  #: seconds: poses farther apart do not determine the velocity
FAR, FAR_TURN = 0.2, 0.2  #: metres, radians: maximum expected motion between matched scans


def odometry_name(log: ScanLog) -> str | None:
    """Return the trajectory used as odometry: the first in a frame ``odom``, else the log's first; None if there is
    none.

    Placeholders and poses that never change are not odometry; then only the scans are used.
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
    """Return the scans to match: those at which the odometry ``poses`` (n_scans, 3) has moved or turned enough.

    Motion counts from the previous matched scan of the same sensor, ``sensor`` (n_scans,), and the first and the last
    scan of each sensor are always matched. If there are more than ``max_nodes``, the distances are doubled until there
    are not. Without odometry (None) it is all scans, or ``max_nodes`` of them evenly spaced, of which :func:`next_scan`
    skips some.
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

    It is the last one within :data:`SHORT_S` before which a robot with ``velocity`` (3,), metres and radians per
    second, moves no more than :data:`FAR` and :data:`FAR_TURN`; scan k + 1 if the times are not usable. A longer time
    is not allowed even if the robot seems to be at rest, because its motion along a corridor is not observed.
    """
    speed, turning = float(np.hypot(velocity[0], velocity[1])), abs(float(velocity[2]))
    end = times[k] + min(SHORT_S, FAR / max(speed, 1e-9), FAR_TURN / max(turning, 1e-9)) + 1e-6
    last = k + 1
    while last + 1 < len(times) and times[k] < times[last] < times[last + 1] <= end:
        last += 1
    return last


def sweep_velocities(log: ScanLog, name: str) -> Float64Array:
    """Return the velocity (n_scans, 3) of the base during each scan, from a trajectory, in the base's frame.

    Metres and radians per second; 0 for scans of sensors without times between beams.
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
    """Return the velocity (n, 3) from each of ``poses`` (n, 3) to the next, in its own frame, per second.

    At the last pose, and if the next is later than :data:`LONG_S`, it is that from the pose before; 0 if that is also
    too long ago.
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
    """Return poses (n, 3) of the scans up to the last node: those of the nodes (m,), with odometry in between.

    ``odometry`` (n, 3) is chained from the node before, and its difference at the node after is distributed in
    proportion to the motion. Without odometry (None), poses are interpolated by the scans' ``times`` (n,), or by their
    indices if times are equal.
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
