"""The worker process on logs that SLAM can and cannot use, with SLAM itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points
from mapper.io.trajectories import read_tum
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.lidar import SensorConfig
from server.library.graph_file import read_graph
from server.library.pose_jobs import packed
from server.library.slam_job import SlamJob, SlamOutcome, _slam, read_progress
from server.sessions.models.loop_hill import hill_of
from server.sessions.models.solved_graph import SolvedGraph
from server.sessions.view import GraphChange
from tests.mapper.slam.worlds import drive, without_poses


@pytest.fixture(scope="module")
def log() -> ScanLog:
    """Thirty scans of a room, along a wall and back, whose odometry drifts."""
    there = np.stack([np.linspace(1.5, 4.4, 15), np.full(15, 2.0), np.zeros(15)], axis=1)
    return drive("room", np.concatenate([there, there[::-1]]), turn_bias=0.2)


def done(folder: Path, log: ScanLog) -> SlamOutcome:
    packed(log, folder / "log.npz")
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


def test_two_lidars_are_healed_and_their_graph_shows_each_scan_where_it_was_taken(tmp_path: Path) -> None:
    there = np.stack([np.linspace(1.5, 4.4, 15), np.full(15, 2.0), np.zeros(15)], axis=1)
    path = np.concatenate([there, there[::-1]])
    wide = SensorConfig(n_beams=120, field_of_view=np.pi, range_max=8.0, range_noise=0.01)
    turning = replace(wide, n_beams=180, field_of_view=2.0 * np.pi * 179 / 180)
    front = replace(drive("room", path, sensor=wide, mount=(0.2, 0.1, 0.0), turn_bias=0.2), topic="/front")
    back = drive("room", path, sensor=turning, mount=(-0.3, 0.0, np.pi), turn_bias=0.2)
    back = replace(back, topic="/back", trajectories=front.trajectories)  # at the stamps of the other
    log = JointLog.of([front, back])
    outcome = done(tmp_path, log)
    assert outcome.sharpness[0] < outcome.sharpness[1]
    poses = read_tum(tmp_path / "slam.tum")
    assert len(poses) == log.n_scans == 60
    log = replace(log, trajectories={**log.trajectories, "SLAM": Trajectory(poses.poses)})
    solved = SolvedGraph.of("SLAM", poses.poses, *read_graph((tmp_path / "slam.graph").read_bytes()))
    true = log.trajectory("true").poses
    # Where the scans end in the world, in the frame of the healed poses, which is that of the first of them.
    to_map = compose(poses.poses[0], inverse(true[0]))
    changed = solved.changed(log, GraphChange(add=(3, 56)))
    (edge,) = [one["edge"] for one in changed.public()["loops"] if one["scans"] == [3, 56]]
    pair = changed.edge(log, edge)
    for name, scan in (("i", 3), ("aligned", 56)):
        part = log.parts[log.part_of_scan[scan]]
        seen = np.isfinite(log.ranges[scan, : part.n_beams])
        angles, ranges = part.angles[seen], log.ranges[scan, : part.n_beams][seen].astype(np.float64)
        points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=1)
        expected = transform_points(compose(compose(to_map, true[scan]), np.array(part.mount)), points)
        found = np.array(pair["points"][name])
        assert len(found) == seen.sum() > 100
        away = np.hypot(*(found[:, np.newaxis] - expected).transpose(2, 0, 1)).min(axis=1)
        assert away.max() < 0.1
    assert max(hill_of(changed, log, edge)["scores"]) > 50
    # After a change of its poses each sensor's own log has those of its scans.
    parts = changed.in_log(log)
    assert isinstance(parts, JointLog)
    np.testing.assert_array_equal(parts.parts[1].trajectory("SLAM").poses, changed.poses[log.part_of_scan == 1])


def test_what_cannot_be_aligned_is_said(tmp_path: Path, log: ScanLog) -> None:
    empty = replace(log, ranges=np.full_like(log.ranges, np.inf))
    with pytest.raises(ConfigError, match="No scan of this log has a return"):
        done(tmp_path, empty)
    with pytest.raises(ConfigError, match="sonar"):
        done(tmp_path, replace(log, beam_width=0.3))
    assert not (tmp_path / "slam.tum").exists()
