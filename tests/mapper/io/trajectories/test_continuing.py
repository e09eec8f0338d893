"""A trajectory of another program at all scans of a log: equal where it has poses, rigid beyond them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.io.trajectories import poses_at_all_scans
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses

SECOND = 1_000_000_000
MOVED = np.array([10.0, -3.0, 0.7])  #: T_map_odom


def log_of(n: int = 6) -> ScanLog:
    rng = np.random.default_rng(4)
    return ScanLog(
        ranges=np.ones((n, 3), dtype=np.float32),
        angle_min=0.0,
        angle_increment=0.1,
        range_min=0.0,
        range_max=10.0,
        stamps_ns=np.arange(n, dtype=np.int64) * SECOND,
        trajectories={"odometry": Trajectory(rng.uniform(-3.0, 3.0, (n, 3)))},
    )


def test_scans_beyond_the_poses_move_as_the_log_says() -> None:
    log = log_of()
    own = log.trajectory().poses
    other = compose(MOVED, own)
    got, notes = poses_at_all_scans(log, TimedPoses(log.stamps_ns[2:5], other[2:5]))
    np.testing.assert_allclose(got, other, atol=1e-12)
    assert notes == [
        "3 scans lie before the first or after the last pose: the log’s own poses continue the trajectory."
    ]


def test_the_correction_at_the_nearest_scan_is_kept() -> None:
    log = log_of()
    own = log.trajectory().poses
    other = compose(MOVED, own)
    drifted = compose(other[3], np.array([0.5, 0.0, 0.1]))
    got, _ = poses_at_all_scans(log, TimedPoses(log.stamps_ns[2:4], np.stack([other[2], drifted])))
    np.testing.assert_allclose(got[:2], other[:2], atol=1e-12)
    for k in (4, 5):
        np.testing.assert_allclose(compose(inverse(got[3]), got[k]), compose(inverse(own[3]), own[k]), atol=1e-12)


def test_poses_scan_by_scan_are_taken_as_they_are() -> None:
    log = replace(log_of(4), stamps_ns=np.array([3, 1, 1, 2], dtype=np.int64) * SECOND)
    poses = np.arange(12.0).reshape(4, 3) / 10.0
    got, notes = poses_at_all_scans(log, TimedPoses(log.stamps_ns, poses))
    np.testing.assert_array_equal(got, poses)
    assert not notes


def test_poses_of_another_time_are_refused() -> None:
    log = log_of()
    with pytest.raises(ConfigError, match=r"from 100.000 to 101.000 s") as caught:
        poses_at_all_scans(log, TimedPoses(np.array([100, 101]) * SECOND, np.zeros((2, 3))))
    assert caught.value.code == "trajectory.time"


def test_a_log_without_poses_cannot_continue_a_trajectory() -> None:
    placeholder = Trajectory(np.zeros((6, 3)), is_placeholder=True)
    log = replace(log_of(), trajectories={"none": placeholder})
    with pytest.raises(ConfigError, match="2 of the 6 scans") as caught:
        poses_at_all_scans(log, TimedPoses(log.stamps_ns[:4], np.zeros((4, 3))))
    assert caught.value.code == "trajectory.outside"
