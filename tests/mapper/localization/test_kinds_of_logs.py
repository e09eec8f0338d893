"""Logs whose lidar moves on the robot, of several lidars, and whose stamps run backwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.localization import LocalizationConfig, localize_log
from mapper.localization.localize import carry_back, covariance_lines
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from tests.mapper.localization.rooms import office

CONFIG = LocalizationConfig(max_particles=1000, laser_max_beams=30, reset_below=0.0)


def on_mounts(log: ScanLog, mounts: np.ndarray) -> ScanLog:
    """Return the log of the same scans by a lidar at ``mounts`` (n, 3) of its robot, which moves accordingly."""
    ways = {name: replace(one, poses=compose(one.poses, inverse(mounts))) for name, one in log.trajectories.items()}
    return replace(log, trajectories=ways, mount=tuple(mounts[0].tolist()))


def median_error(log: ScanLog, poses: np.ndarray) -> float:
    return float(np.median(np.hypot(*(poses - log.trajectory("true").poses)[:, :2].T)))


def median_turn(log: ScanLog, poses: np.ndarray) -> float:
    return float(np.median(np.abs(wrap_angle((poses - log.trajectory("true").poses)[:, 2]))))


def test_a_lidar_that_moves_on_the_robot_is_where_it_was_at_each_scan():
    grid, whole = office()
    log = whole.take(slice(0, 40))
    turns = 0.9 * np.sin(np.arange(log.n_scans) / 6.0)
    mounts = np.column_stack([0.3 * np.cos(turns), 0.3 * np.sin(turns), turns])
    moving = replace(on_mounts(log, mounts), mounts=mounts)
    start = moving.trajectory("true").poses[0]
    found = localize_log(moving, grid, CONFIG, initial_pose=start)
    assert median_error(moving, found.poses) < 0.15
    assert median_turn(moving, found.poses) < 0.1
    as_fixed = localize_log(replace(moving, mounts=None), grid, CONFIG, initial_pose=start)
    assert median_turn(moving, as_fixed.poses) > 0.3


def test_two_lidars_whose_stamps_run_backwards_give_a_line_for_each_scan_in_the_order_of_the_log():
    grid, whole = office()
    log = whole.take(slice(0, 40))
    stamps = log.stamps_ns.copy()
    stamps[20:24] -= 2_000_000_000
    log = replace(log, stamps_ns=stamps)
    # The scans by turns of two lidars; the robot is where the one that took the scan is mounted on it.
    front, rear = np.array([0.3, 0.0, 0.2]), np.array([-0.2, 0.1, -0.2])
    mounts = np.where(np.arange(log.n_scans)[:, np.newaxis] % 2 == 0, front, rear)
    log = on_mounts(log, mounts)
    joint = JointLog.of(
        [
            replace(log.take(np.arange(first, 40, 2)), topic=topic, mount=tuple(mount.tolist()))
            for first, topic, mount in ((0, "front", front), (1, "rear", rear))
        ]
    )
    found = localize_log(joint, grid, CONFIG, initial_pose=joint.trajectory("true").poses[0])
    assert len(found.poses) == joint.n_scans == 40
    assert median_error(joint, found.poses) < 0.15
    lines = covariance_lines(joint, found)[1:]
    assert [int(line.split(",")[1]) for line in lines] == joint.stamps_ns.tolist()
    assert (np.diff(joint.stamps_ns) < 0).any()


def test_scans_before_convergence_get_the_converged_pose_carried_back_along_the_odometry():
    """The poses are exact at the most certain of the first scans that converged, and nonsense before."""
    rng = np.random.default_rng(2)
    true = np.cumsum(rng.normal(0.0, (0.2, 0.1, 0.2), (30, 3)), axis=0)
    odometry = compose(np.array([3.0, -1.0, 0.7]), true)  # in a frame of its own
    converged = np.arange(30) >= 12
    converged[20:22] = False
    covariance = np.tile(np.eye(3) * 0.1, (30, 1, 1))
    covariance[15] *= 0.01
    poses = true + 0.05  # after convergence, off by the filter's noise
    poses[:12] = rng.normal(0.0, 10.0, (12, 3))
    poses[15] = true[15]
    found = poses.copy()
    carry_back(found, odometry, covariance, converged)
    np.testing.assert_allclose(found[:12, :2], true[:12, :2], atol=1e-9)
    np.testing.assert_allclose(wrap_angle(found[:12, 2] - true[:12, 2]), 0.0, atol=1e-9)
    np.testing.assert_array_equal(found[12:], poses[12:])
    for never in (np.zeros(30, dtype=bool), np.ones(30, dtype=bool)):
        same = poses.copy()
        carry_back(same, odometry, covariance, never)
        np.testing.assert_array_equal(same, poses)
