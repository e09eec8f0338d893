"""A pack is read back unchanged, and every other file is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic, Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses
from server.library.logs.cache import LogCache
from server.library.packs.log import (
    NotPackedError,
    StalePackError,
    nbytes,
    read_pack,
    write_pack,
)


def log_of(n_scans: int, n_beams: int = 4, **changes: object) -> ScanLog:
    rng = np.random.default_rng(n_scans)
    ranges = rng.uniform(0, 10, (n_scans, n_beams)).astype(np.float32)
    values = {
        "ranges": ranges,
        "angle_min": -1.5,
        "angle_increment": 1.0,
        "range_min": 0.1,
        "range_max": 20.0,
        "stamps_ns": np.arange(n_scans)[::-1],
        "trajectories": {
            "scan": Trajectory(rng.uniform(-5, 5, (n_scans, 3)), "as stated — “so”", "map"),
            "wheel": Trajectory(
                rng.uniform(-5, 5, (n_scans, 3)), "", "odom", "base", is_placeholder=True, placeholder_note="two"
            ),
        },
        "mount": (0.1, 0.2, 0.3),
        "upside_down": True,
        "frame_id": "front_laser",
        "time_increment": 0.0002,
        "scan_time": 0.1,
        "name": "Café 地図",
        "format": "CARMEN",
        "topics": (
            Topic("/scan", "sensor_msgs/LaserScan", 7, "laser", 4, 3.0, 10.0, (0.1, 0.2, 0.3), chosen=True),
            Topic("/tf", "tf2_msgs/TFMessage", 9),
        ),
        "notes": ("one", "two"),
        "angles_assumed": True,
    }
    return ScanLog(**(values | changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("n_scans", [0, 1, 7])
@pytest.mark.parametrize("range_max", [20.0, float("inf")])
def test_a_pack_is_read_back_unchanged(tmp_path: Path, n_scans: int, range_max: float) -> None:
    log = log_of(n_scans, range_max=range_max)
    if n_scans:
        log.ranges[0] = [np.nan, np.inf, -np.inf, 1.0]
    write_pack(RobotLog.of_one(log), tmp_path / "log.npz")
    again = read_pack(tmp_path / "log.npz")
    np.testing.assert_array_equal(again.ranges, log.ranges)
    np.testing.assert_array_equal(again.stamps_ns, log.stamps_ns)
    assert list(again.trajectories) == ["scan", "wheel"]
    for name, trajectory in log.trajectories.items():
        np.testing.assert_array_equal(again.trajectories[name].poses, trajectory.poses)
        for field in ("description", "frame_id", "child_frame_id", "is_placeholder", "placeholder_note"):
            assert getattr(again.trajectories[name], field) == getattr(trajectory, field), field
    for name in ("angle_min", "angle_increment", "range_min", "range_max", "mount", "upside_down", "name", "format"):
        assert getattr(again, name) == getattr(log, name), name
    for name in ("frame_id", "time_increment", "scan_time", "angles_assumed"):
        assert getattr(again, name) == getattr(log, name), name
    assert (again.topics, again.notes) == (log.topics, log.notes)
    assert again.bearings is None


def test_the_bearings_of_sonars_are_packed(tmp_path: Path) -> None:
    log = log_of(3, bearings=np.array([-1.5, -0.1, 0.1, 1.5]), beam_width=0.35)
    write_pack(RobotLog.of_one(log), tmp_path / "log.npz")
    again = read_pack(tmp_path / "log.npz")
    assert log.bearings is not None
    assert again.bearings is not None
    np.testing.assert_array_equal(again.bearings, log.bearings)
    assert again.beam_width == 0.35


def test_the_mounts_of_a_sensor_that_moves_are_packed(tmp_path: Path) -> None:
    log = log_of(5, mounts=np.random.default_rng(1).uniform(-1, 1, (5, 3)))
    write_pack(RobotLog.of_one(log), tmp_path / "log.npz")
    mounts = read_pack(tmp_path / "log.npz").mounts
    assert mounts is not None
    np.testing.assert_array_equal(mounts, log.mounts)
    assert nbytes(log) == nbytes(replace(log, mounts=None)) + mounts.nbytes


def test_each_packed_sensor_is_read_with_its_own_poses(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    timed = TimedPoses(np.arange(50) * 10, np.random.default_rng(0).uniform(-1, 1, (50, 3)), ("a note",))
    topics = [Topic("/front", "sensor_msgs/LaserScan", 3, chosen=True), Topic("/rear", "sensor_msgs/LaserScan", 5)]
    logs = {}
    for name, n in (("/front", 3), ("/rear", 5)):
        way = Trajectory(np.zeros((n, 3)), "tf", "odom", timed=timed)
        odometry = OdometryRecords(timed, np.arange(n) - 1, np.ones((n, 3)))
        listed = tuple(replace(one, chosen=one.name == name) for one in topics)
        logs[name] = log_of(n, topic=name, topics=listed, trajectories={"tf": way}, odometry=odometry)
    write_pack(RobotLog(logs), path)
    assert read_pack(path).topic == "/front"
    for name, log in logs.items():
        again = read_pack(path, name)
        np.testing.assert_array_equal(again.ranges, log.ranges)
        assert again.topics == log.topics
        found = again.trajectory("tf").timed
        assert found is not None
        assert again.odometry is not None
        assert log.odometry is not None
        np.testing.assert_array_equal(found.stamps_ns, timed.stamps_ns)
        np.testing.assert_array_equal(found.poses, timed.poses)
        assert found.notes == timed.notes
        np.testing.assert_array_equal(again.odometry.messages.poses, timed.poses)
        np.testing.assert_array_equal(again.odometry.before_scan, log.odometry.before_scan)
        assert again.odometry.at_scans is not None
        assert nbytes(again) == nbytes(log)
    with pytest.raises(NotPackedError):
        read_pack(path, "/left")
    assert path.stat().st_size < 12_000  # the poses that both share are stored once


def test_no_other_file_is_left(tmp_path: Path) -> None:
    write_pack(RobotLog.of_one(log_of(2)), tmp_path / "log.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["log.npz"]


def test_nothing_else_is_a_pack(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    with pytest.raises(StalePackError):
        read_pack(path)
    write_pack(RobotLog.of_one(log_of(3)), path)
    whole = path.read_bytes()
    for data in (b"", b"PK", whole[:100], whole[: len(whole) // 2], whole[:-10], b"x" * 1000):
        path.write_bytes(data)
        with pytest.raises(StalePackError):
            read_pack(path)
    with path.open("wb") as file:  # a pickle is never opened
        np.savez(file, about=np.array([{"version": 1}], dtype=object))
    with pytest.raises(StalePackError):
        read_pack(path)


def test_the_cache_keeps_the_most_recently_used() -> None:
    logs = {name: log_of(100) for name in "abc"}
    size = nbytes(logs["a"])
    assert size == 100 * (4 * 4 + 8 + 2 * 24)
    cache = LogCache(2 * size)
    cache.put("a", logs["a"])
    cache.put("b", logs["b"])
    assert cache.get("a") is logs["a"]
    cache.put("c", logs["c"])
    assert cache.get("b") is None
    assert cache.get("a") is logs["a"]
    assert cache.bytes == 2 * size
    cache.drop("a")
    cache.drop("a")
    assert cache.bytes == size
    huge = log_of(1000)
    cache.put("huge", huge)
    assert cache.get("huge") is huge, "whoever opens it at the same time shares it"
    assert cache.get("c") is None
    cache.put("a", logs["a"])
    assert cache.get("huge") is None
    assert cache.bytes == size
