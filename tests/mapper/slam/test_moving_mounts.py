"""A lidar that turns on the robot, as on a pan unit: matched and corrected as the fixed one that sees the same."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse, transform_points
from mapper.matching import prepare_scans
from mapper.matching.kernels.types import NO_POINT
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.simulation.lidar import SensorConfig
from mapper.slam import SlamConfig, slam_log
from tests.mapper.slam.worlds import along, drive

AROUND = SensorConfig(n_beams=120, field_of_view=2.0 * math.pi, range_max=8.0, range_noise=0.02)
CORNERS = [(16.0, 1.25), (22.7, 1.25), (22.7, 7.0)]


@pytest.fixture(scope="module")
def fixed() -> ScanLog:
    return drive("loop", along(CORNERS), sensor=AROUND, mount=(0.1, 0.05, 0.2))


@pytest.fixture(scope="module")
def turning(fixed: ScanLog) -> ScanLog:
    """The same readings of a lidar that the robot turns by a few beams from scan to scan, forth and back."""
    beams = np.round(12 * np.sin(0.4 * np.arange(fixed.n_scans))).astype(int)
    ranges = np.stack([np.roll(row, -k) for row, k in zip(fixed.ranges, beams, strict=True)])
    mounts = np.tile(fixed.mount, (fixed.n_scans, 1))
    mounts[:, 2] += beams * fixed.angle_increment
    return replace(fixed, ranges=ranges, mounts=mounts, mount=tuple(mounts[0]))


def test_points_are_where_the_mount_of_their_scan_puts_them(fixed: ScanLog, turning: ScanLog) -> None:
    assert turning.mounts is not None
    scans = prepare_scans(turning, 3, 9)
    for n in range(6):
        placed = scans.points[n][scans.kind[n] != NO_POINT].astype(np.float64)
        readings = turning.ranges[3 + n]
        hit = (readings >= turning.range_min) & (readings <= turning.range_max)
        ends = readings[hit, None] * np.stack([np.cos(turning.angles[hit]), np.sin(turning.angles[hit])], axis=1)
        expected = transform_points(turning.mounts[3 + n], ends)
        assert len(placed) == len(expected)
        assert np.abs(placed[:, None] - expected).max(axis=2).min(axis=1).max() < 1e-5


def test_slam_finds_the_poses_of_the_base(fixed: ScanLog, turning: ScanLog) -> None:
    config = SlamConfig(refinement=0)
    expected, found = slam_log(fixed, config), slam_log(turning, config)
    off = compose(inverse(expected.poses), found.poses)
    assert np.abs(off).max() < 5e-3
    wrong = slam_log(replace(turning, mounts=None), config)
    off = compose(inverse(expected.poses), wrong.poses)
    assert np.abs(off).max() > 0.05, "without its mounts the log is another one"


def test_of_two_lidars_each_has_its_own_mounts(fixed: ScanLog, turning: ScanLog) -> None:
    both = JointLog.of([replace(turning, topic="pan"), replace(fixed, topic="front", stamps_ns=fixed.stamps_ns + 1000)])
    np.testing.assert_array_equal(both.mount_of(4), turning.mounts_at(2))
    np.testing.assert_array_equal(both.mount_of(5), fixed.mount)
    result = slam_log(both, SlamConfig(refinement=0))
    true = both.trajectory("true").poses
    off = np.hypot(*(result.poses - true)[:, :2].T)
    assert off.max() < 0.25
