"""The worker process on logs that SLAM can and cannot use, with SLAM itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points
from mapper.diagnosis.verdict import map_of
from mapper.io.trajectories import read_tum
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from mapper.simulation.lidar import SensorConfig
from server.jobs.process import JobLimits
from server.library.packs.graph import read_graph
from server.library.processing.log_jobs import packed, read_report
from server.library.processing.slam import PartialPoses, SlamJob, SlamOutcome
from server.parts.slam.loop_landscape import landscape_of
from server.parts.slam.solved_graph import SolvedGraph
from server.sessions.view import GraphChange
from tests.mapper.slam.worlds import drive, without_poses


@pytest.fixture(scope="module")
def log() -> ScanLog:
    """Thirty scans of a room, along a wall and back, whose odometry drifts."""
    there = np.stack([np.linspace(1.5, 4.4, 15), np.full(15, 2.0), np.zeros(15)], axis=1)
    return drive("room", np.concatenate([there, there[::-1]]), turn_bias=0.2)


def done(folder: Path, log: ScanLog, mapping: dict[str, Any] | None = None) -> SlamOutcome:
    packed(log, folder / "log.npz")
    files = (str(folder / "log.npz"), str(folder / "slam"))
    return SlamJob(*files, None, {"refinement": 2.0}, mapping or {}, JobLimits()).compute()


def test_it_leaves_a_trajectory_a_graph_and_how_far_it_is(tmp_path: Path, log: ScanLog) -> None:
    outcome = done(tmp_path, log)
    poses = read_tum(tmp_path / "slam.tum")
    np.testing.assert_array_equal(poses.stamps_ns, log.stamps_ns)
    graph, tried = read_graph((tmp_path / "slam.graph").read_bytes())
    assert (outcome.odometry, outcome.loops, outcome.nodes) == ("odometry", graph.n_loops, len(graph.nodes))
    assert len(tried) >= graph.n_loops
    before, after = outcome.before, outcome.after
    assert 0.0 < before.sharpness < after.sharpness <= 1.0
    assert before.contradicted is not None
    assert after.contradicted is not None
    assert after.contradicted < before.contradicted
    progress = read_report(tmp_path / "slam", PartialPoses)
    assert progress is not None
    assert 0.0 < progress.fraction <= 1.0
    assert len(progress.poses) <= log.n_scans


def test_the_map_with_a_corrected_mount_and_clock_is_healed_with_both(tmp_path: Path, log: ScanLog) -> None:
    """The log says that its sensor sits elsewhere, and its clock is late: the corrections count once."""
    right = done(tmp_path, log).after
    claimed = compose(log.mount, inverse((0.3, -0.2, 0.3))).tolist()
    late = replace(log, mount=(claimed[0], claimed[1], claimed[2]), stamps_ns=log.stamps_ns - 200_000_000)
    late = replace(late, trajectories={name: _timed(log, one) for name, one in late.trajectories.items()})
    mapping = {"mount_x": 0.3, "mount_y": -0.2, "mount_yaw": 0.3, "time_offset": 0.2}
    healed = done(tmp_path, late, mapping).after
    assert healed.sharpness == pytest.approx(right.sharpness, abs=0.03)
    assert healed.drift_m == pytest.approx(right.drift_m, abs=0.101)
    healed_log = replace(
        late, trajectories={"SLAM": Trajectory(read_tum(tmp_path / "slam.tum").poses, from_scans=True)}
    )
    config = MappingConfig().with_values(mapping)
    occupied = {
        name: int((map_of(one, None, config).p_occ > 0.65).sum())
        for name, one in (("healed", healed_log), ("right", _claiming(log, claimed)))
    }
    assert occupied["healed"] == pytest.approx(occupied["right"], rel=0.15)


def _timed(log: ScanLog, one: Trajectory) -> Trajectory:
    """The trajectory with the stamps that it was recorded with, at scans whose stamps are 0.2 s earlier."""
    timed = TimedPoses(log.stamps_ns, one.poses)
    return replace(one, poses=timed.at(log.stamps_ns - 200_000_000), timed=timed)


def _claiming(log: ScanLog, mount: list[float]) -> ScanLog:
    """The log along its true poses, with a false mount."""
    true = replace(log.trajectory("true"), from_scans=True)
    return replace(log, mount=(mount[0], mount[1], mount[2]), trajectories={"true": true})


def test_a_log_without_odometry_is_aligned_by_its_scans(tmp_path: Path, log: ScanLog) -> None:
    outcome = done(tmp_path, without_poses(log))
    assert outcome.odometry is None
    assert outcome.after.sharpness > outcome.before.sharpness


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
    assert outcome.before.sharpness < outcome.after.sharpness
    poses = read_tum(tmp_path / "slam.tum")
    assert len(poses) == log.n_scans == 60
    log = replace(log, trajectories={**log.trajectories, "SLAM": Trajectory(poses.poses)})
    solved = SolvedGraph.of("SLAM", poses.poses, *read_graph((tmp_path / "slam.graph").read_bytes()))
    true = log.trajectory("true").poses
    # Where the scans end in the world, in the frame of the healed poses, which is that of the first of them.
    to_map = compose(poses.poses[0], inverse(true[0]))
    changed = solved.changed(log, GraphChange(add=(3, 56)))
    (edge,) = [one.edge for one in changed.public().loops if one.scans == (3, 56)]
    pair = changed.edge(log, edge)
    for name, scan in (("i", 3), ("aligned", 56)):
        part = log.parts[log.part_of_scan[scan]]
        seen = np.isfinite(log.ranges[scan, : part.n_beams])
        angles, ranges = part.angles[seen], log.ranges[scan, : part.n_beams][seen].astype(np.float64)
        points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=1)
        expected = transform_points(compose(compose(to_map, true[scan]), np.array(part.mount)), points)
        found = np.array(getattr(pair.points, name))
        assert len(found) == seen.sum() > 100
        away = np.hypot(*(found[:, np.newaxis] - expected).transpose(2, 0, 1)).min(axis=1)
        assert away.max() < 0.1
    assert max(landscape_of(changed, log, edge).scores) > 50
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
