"""Poses that are too far apart in time for the turns of the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.diagnosis import diagnose, examine
from mapper.diagnosis.drifting import first_cause
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.sparse_poses import sparse_turns
from mapper.sensors.timed_poses import TimedPoses, poses_at
from tests.mapper.diagnosis.runs import true_run

N = 300


@pytest.fixture(scope="module")
def clean() -> ScanLog:
    return true_run(N, every=3)


def stated_each(log: ScanLog, seconds: float) -> ScanLog:
    """The log with the true poses stated so many seconds apart, and interpolated at the scans."""
    stamps, poses = log.stamps_ns, log.trajectory().poses
    every = max(1, round(seconds / float(np.median(np.diff(stamps))) * 1e9))
    kept = np.arange(0, N, every)
    timed = TimedPoses(stamps[kept], poses[kept])
    at_scans = poses_at(timed.stamps_ns, timed.poses, stamps)
    return replace(log, trajectories={"tf/odom": Trajectory(at_scans, frame_id="odom", timed=timed)})


def test_sparse_poses_in_turns_are_the_first_finding_and_no_event(clean: ScanLog) -> None:
    log = stated_each(clean, 2.0)
    found = diagnose(log)
    assert found.findings[0].check == "timing.sparse"
    assert "walls.drift" not in {finding.check for finding in found.findings}
    assert "s apart, and the robot turns by up to" in found.findings[0].sentence
    assert not [event for event in found.events if event.kind in {"pushed", "slipped"}]
    cause = first_cause(log, None, MappingConfig())
    assert cause is None or cause.check == "timing.sparse"


def test_poses_that_pause_while_the_robot_stands_are_no_event(clean: ScanLog) -> None:
    """lidar_slam_ros2#64: odometry that is stated only while it changes; it was a slip, and then a push."""
    standing = 60
    order = np.concatenate([np.arange(100), np.full(standing, 100), np.arange(100, N - standing)])
    log = replace(clean.take(np.arange(N)), ranges=clean.ranges[order])
    poses, stamps = clean.trajectory().poses[order], log.stamps_ns
    moved = np.append(True, (np.diff(poses, axis=0) != 0.0).any(axis=1))
    timed = TimedPoses(stamps[moved], poses[moved])
    at_scans = poses_at(timed.stamps_ns, timed.poses, stamps)
    log = replace(log, trajectories={"tf/odom": Trajectory(at_scans, frame_id="odom", timed=timed)})
    assert [event for event in diagnose(log).events if event.kind in {"pushed", "slipped"}] == []


def test_dense_poses_are_not_sparse(clean: ScanLog) -> None:
    log = stated_each(clean, 0.0)
    assert sparse_turns(log) is None
    assert examine(log) == []


def test_a_pose_that_goes_another_sources_way_is_not_interpolated(clean: ScanLog) -> None:
    """As of amcl_pose beside odometry: its few messages are met, and between them the odometry's way is taken."""
    log = stated_each(clean, 2.0)
    way = replace(log.trajectory(), poses=clean.trajectory().poses)
    assert sparse_turns(replace(log, trajectories={"amcl_pose": way})) is None
