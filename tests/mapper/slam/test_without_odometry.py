"""SLAM by the scans alone: a robot that stands, and stamps that are wrong."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mapper.evaluation import absolute_errors, align
from mapper.simulation.lidar import SensorConfig
from mapper.slam import slam_log
from mapper.slam.fields import ScoreField
from tests.mapper.slam.worlds import along, drive, without_poses


def test_a_robot_that_stands_gets_no_nodes_without_odometry() -> None:
    path = along([(2.0, 2.0), (3.0, 2.0)], 0.08)
    stands = np.concatenate([path[:6], np.repeat(path[5:6], 30, axis=0), path[6:]])
    wide = SensorConfig(n_beams=180, field_of_view=1.5 * np.pi, range_max=10.0, range_noise=0.01)
    log = drive("room", stands, sensor=wide)
    found = slam_log(without_poses(log))
    assert len(found.graph.nodes) < len(path) + 6
    assert found.graph.nodes[-1] == log.n_scans - 1
    true = log.trajectory("true").poses
    assert absolute_errors(true, align(true, found.poses).apply(found.poses))[0].mean() < 0.02
    # The poses of the scans without a node are those of the front end: the robot stands.
    assert np.ptp(found.poses[6:36, :2], axis=0).max() < 0.02


def test_stamps_that_are_wrong_do_not_carry_the_poses_away() -> None:
    """Without odometry a motion in a microsecond is a great velocity, and scans that fit nothing go on with it."""
    log = without_poses(drive("room", along([(2.0, 2.0), (3.0, 2.0)], 0.1)))
    stamps = log.stamps_ns // 100_000  # a scan each microsecond
    stamps[4:] += 2_000_000_000
    ranges = log.ranges.copy()
    ranges[4:] = np.inf
    found = slam_log(replace(log, stamps_ns=stamps, ranges=ranges))
    assert np.abs(found.poses).max() < 25.0


def test_scans_soon_after_one_that_fitted_are_not_searched_for(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = SensorConfig(n_beams=180, field_of_view=1.5 * np.pi, range_max=10.0, range_noise=0.01)
    log = drive("room", along([(2.0, 2.0), (3.6, 2.0)], 0.04), sensor=wide)
    searches: list[int] = []
    search = ScoreField.search

    def counted(self: ScoreField, *given: Any) -> Any:
        searches.append(1)
        return search(self, *given)

    monkeypatch.setattr(ScoreField, "search", counted)
    true, counts = log.trajectory("true").poses, []
    for step_s in (0.2, 1.0):
        searches.clear()
        stamps = (np.arange(log.n_scans) * step_s * 1e9).astype(np.int64)
        found = slam_log(without_poses(replace(log, stamps_ns=stamps)))
        assert absolute_errors(true, align(true, found.poses).apply(found.poses))[0].mean() < 0.02
        counts.append(len(searches))
    assert counts[0] < log.n_scans / 2
    assert counts[1] >= log.n_scans - 1  # too late for the motion to go on as before
