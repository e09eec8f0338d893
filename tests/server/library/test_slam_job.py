"""What the worker process does with logs that SLAM can and cannot use, with SLAM itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.io.trajectories import read_tum
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from server.library.graph_file import read_graph
from server.library.log_pack import write_pack
from server.library.slam_job import SlamJob, SlamOutcome, _slam, read_progress
from tests.mapper.slam.worlds import drive, without_poses


@pytest.fixture(scope="module")
def log() -> ScanLog:
    """Thirty scans of a room, along a wall and back, whose odometry drifts."""
    there = np.stack([np.linspace(1.5, 4.4, 15), np.full(15, 2.0), np.zeros(15)], axis=1)
    return drive("room", np.concatenate([there, there[::-1]]), turn_bias=0.2)


def done(folder: Path, log: ScanLog) -> SlamOutcome:
    write_pack(RobotLog.of_one(log), folder / "log.npz")
    return _slam(SlamJob(str(folder / "log.npz"), str(folder / "slam"), None, {"refinement": 2.0}, 60.0, 60.0, 1 << 32))


def test_it_leaves_a_trajectory_a_graph_and_how_far_it_is(tmp_path: Path, log: ScanLog) -> None:
    outcome = done(tmp_path, log)
    poses = read_tum(tmp_path / "slam.tum")
    np.testing.assert_array_equal(poses.stamps_ns, log.stamps_ns)
    graph, tried = read_graph((tmp_path / "slam.graph").read_bytes())
    assert (outcome.odometry, outcome.loops, outcome.nodes) == ("odometry", graph.n_loops, len(graph.nodes))
    assert len(tried) >= graph.n_loops
    before, after = outcome.sharpness
    assert 0.0 < before < after <= 1.0
    progress = read_progress(tmp_path / "slam")
    assert progress is not None
    assert 0.0 < progress.fraction <= 1.0
    assert len(progress.poses) <= log.n_scans


def test_a_log_without_odometry_is_aligned_by_its_scans(tmp_path: Path, log: ScanLog) -> None:
    outcome = done(tmp_path, without_poses(log))
    assert outcome.odometry is None
    assert outcome.sharpness[1] > outcome.sharpness[0]


def test_one_scan_stays_where_it_is(tmp_path: Path, log: ScanLog) -> None:
    assert (done(tmp_path, log.take(slice(0, 1))).loops, len(read_tum(tmp_path / "slam.tum"))) == (0, 1)


def test_what_cannot_be_aligned_is_said(tmp_path: Path, log: ScanLog) -> None:
    empty = replace(log, ranges=np.full_like(log.ranges, np.inf))
    with pytest.raises(ConfigError, match="No scan of this log has a return"):
        done(tmp_path, empty)
    with pytest.raises(ConfigError, match="sonar"):
        done(tmp_path, replace(log, beam_width=0.3))
    assert not (tmp_path / "slam.tum").exists()
