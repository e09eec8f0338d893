"""Several sensors exported to one MCAP file, read with rosbags and with our own reader."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.io.export import GrowingMap, write_mcap
from mapper.io.logs import open_robot_log
from mapper.io.maps import occupancy_values
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from tests.mapper.io.export.exported import read, sonars_of


@pytest.fixture
def two(office_log: ScanLog) -> JointLog:
    front = replace(office_log.take(slice(0, 30)), topic="/front/scan", frame_id="front_laser", mount=(0.3, 0.1, 0.2))
    rear = replace(
        front, topic="/rear scan#2", frame_id="rear_laser", mount=(-0.3, 0.0, 3.0), upside_down=True,
        ranges=front.ranges[:, ::3].copy(), angle_increment=3.0 * front.angle_increment,
        stamps_ns=front.stamps_ns + 7_000_000,
    )  # fmt: skip
    return JointLog.of([front, rear])


def test_another_reader_finds_the_scans_of_each_sensor_and_one_map(tmp_path: Path, two: JointLog) -> None:
    config = MappingConfig(resolution=0.1)
    grid = OccupancyGrid(geometry_for(two, config))
    integrate_log(grid, two, config)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, two, GrowingMap(grid, config), "true")
    found = read(path)
    topics = ("/front/scan", "/rear_scan_2")
    assert set(found) == {"/map", "/tf", "/tf_static", "/pose", *topics, *(f"{topic}/points" for topic in topics)}
    poses = [(stamp, (one.pose.position.x, one.pose.position.y)) for stamp, one in found["/pose"]]
    assert [stamp for stamp, _ in poses] == two.stamps_ns.tolist()
    assert [place for _, place in poses] == [(x, y) for x, y, _ in two.trajectory("true").poses.tolist()]
    for topic, part in zip(topics, two.parts, strict=True):
        assert [stamp for stamp, _ in found[topic]] == part.stamps_ns.tolist()
        for (_, scan), (_, cloud), ranges in zip(found[topic], found[f"{topic}/points"], part.ranges, strict=True):
            np.testing.assert_array_equal(scan.ranges, ranges)
            assert scan.header.frame_id == cloud.header.frame_id == part.frame_id
            assert scan.angle_increment == pytest.approx(part.angle_increment)
            assert cloud.width == np.count_nonzero(
                (ranges > 0) & (ranges >= part.range_min) & (ranges <= part.range_max)
            )
    mounts = {one.child_frame_id: one.transform for one in found["/tf_static"][0][1].transforms}
    assert {frame: (one.translation.x, one.translation.y) for frame, one in mounts.items()} == {
        "front_laser": (0.3, 0.1), "rear_laser": (-0.3, 0.0),
    }  # fmt: skip
    turn = mounts["front_laser"].rotation
    assert (turn.z, turn.w) == pytest.approx((math.sin(0.1), math.cos(0.1)))
    np.testing.assert_array_equal(found["/map"][-1][1].data.reshape(grid.geometry.shape), occupancy_values(grid))


def test_the_file_is_read_as_the_same_sensors_and_makes_the_same_map(tmp_path: Path, two: JointLog) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, two, None, "true")
    robot = open_robot_log(path)
    assert set(robot.sensors) == {"/front/scan", "/rear_scan_2"}
    again = JointLog.of([robot.sensors[name] for name in ("/front/scan", "/rear_scan_2")])
    np.testing.assert_array_equal(again.part_of_scan, two.part_of_scan)
    config = MappingConfig(resolution=0.1)
    maps = []
    for log in (two, again):
        grid = OccupancyGrid(geometry_for(two, config))
        integrate_log(grid, log, config, "true" if log is two else "tf/map")
        maps.append(grid)
    # The times between beams are not stated; the angles of a LaserScan are float32, so a few beams cross other cells.
    assert np.mean(maps[0].observed != maps[1].observed) < 1e-3


def test_sensors_that_share_a_topic_or_a_frame_get_names_of_their_own(tmp_path: Path, two: JointLog) -> None:
    parts = [replace(part, topic=topic, frame_id="laser") for part, topic in zip(two.parts, ("/tf", ""), strict=True)]
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, JointLog.of(parts), None, "true")
    found = read(path)
    scans = {topic: one[0][1] for topic, one in found.items() if hasattr(one[0][1], "ranges")}
    assert {topic: scan.header.frame_id for topic, scan in scans.items()} == {"/tf_0": "laser", "/scan_1": "laser_1"}
    assert {one.child_frame_id for one in found["/tf_static"][0][1].transforms} == {"laser", "laser_1"}
    assert len(found["/tf"]) == two.n_scans


def test_sonars_of_several_topics_are_range_messages_on_theirs(tmp_path: Path, office_log: ScanLog) -> None:
    ring = sonars_of(office_log.take(slice(0, 5)))
    assert ring.bearings is not None
    single = replace(ring, ranges=ring.ranges[:, :1].copy(), bearings=np.zeros(1), topic="/left", frame_id="left")
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, JointLog.of([replace(ring, topic="/ring"), single]))
    found = read(path)
    assert {"/ring_0", "/ring_1", "/ring_2", "/left"} < set(found)
    assert [one.range for _, one in found["/left"]] == single.ranges[:, 0].tolist()
    assert found["/left"][0][1].header.frame_id == "left"
    assert found["/ring_2"][0][1].header.frame_id == "ring_2"


def test_a_lidar_that_was_switched_stays_one_sensor(tmp_path: Path, two: JointLog) -> None:
    first = replace(two.parts[0], topic="/scan", frame_id="laser")
    late = replace(
        first, ranges=first.ranges[:, ::2].copy(), angle_increment=2.0 * first.angle_increment,
        stamps_ns=first.stamps_ns + 1_000,
    )  # fmt: skip
    log = JointLog.of([first, late])
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, None, "true")
    again = open_robot_log(path)
    assert set(again.sensors) == {"/scan"}
    assert isinstance(again.first, JointLog)
    assert sorted(part.n_beams for part in again.first.parts) == [late.n_beams, first.n_beams]
    assert again.first.n_scans == log.n_scans
