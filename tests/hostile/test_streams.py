"""Streams of recordings as no robot sends them: shared names, a million topics, changing beams, damaged clouds."""

from __future__ import annotations

import struct
import tracemalloc
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, MapperError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.inspection import inspect
from mapper.io.contents.seeking import message_at
from mapper.io.logs import open_log, open_robot_log
from mapper.sensors.scan import ScanLog
from tests.hostile.corpus import T0, bag_record
from tests.hostile.damage import ROUNDS, flipped, opened
from tests.mapper.io.contents.recorded_robot import imu
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import KINDS, SECOND, cloud, echoes, odometry, scan, transform, written

LIMITS = Limits(max_chunk_bytes=1 << 22, max_messages=100_000)


@pytest.mark.parametrize("kind", KINDS)
def test_topics_of_one_name_and_two_types_are_two_sensors_and_two_streams(tmp_path: Path, kind: str) -> None:
    said = []
    for i in range(4):
        at = T0 + i * SECOND
        said += [scan(at, [1.0, 2.0], "/front"), echoes(at, [[3.0], [], [4.0]], "/front")]
        mixed = imu(at, 0.1, 0.2, 0.3)
        mixed.topic = "/points"
        said += [cloud(at, np.ones((5, 3))), mixed]
    path = written(tmp_path, said, kind)
    robot = open_robot_log(path)
    lidars = {name: one for name, one in robot.sensors.items() if name.startswith("/front")}
    assert sorted(one.ranges.shape for one in lidars.values()) == [(4, 2), (4, 3)]
    assert [len(one) for one in robot.clouds["/points"]] == [5] * 4
    assert len(robot.imus["/points"].samples()) == 4
    held = [(one.name, one.type, one.messages) for one in inspect(path).topics if one.name == "/points"]
    assert held == [("/points", "sensor_msgs/Imu", 4), ("/points", "sensor_msgs/PointCloud2", 4)]


def test_a_million_tiny_topics_are_refused_in_one_sentence_and_little_memory(tmp_path: Path) -> None:
    """The file is as a million of them begins: reading does not come farther."""
    path = tmp_path / "a.bag"
    with path.open("wb") as file:
        file.write(b"#ROSBAG V2.0\n")
        kind = b"type=sensor_msgs/LaserScan"
        for i in range(4_000):
            topic = f"topic=/t{i}".encode()
            stated = struct.pack("<I", len(topic)) + topic + struct.pack("<I", len(kind)) + kind
            file.write(bag_record({"op": b"\x07", "conn": struct.pack("<I", i), "topic": topic[6:]}, stated))
    tracemalloc.start()
    try:
        for read in (open_log, inspect):
            with pytest.raises(LimitError) as caught:
                read(path)
            assert caught.value.message == f"The log has more than {DEFAULT_LIMITS.max_topics} topics."
        with pytest.raises(MapperError, match="no messages on '/t9'"):
            message_at(path, "/t9", T0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 16 << 20


@pytest.mark.parametrize("kind", KINDS)
def test_a_sensor_that_changes_its_beams_in_the_middle_loses_no_scan(tmp_path: Path, kind: str) -> None:
    said = [scan(T0 + i * SECOND, [1.0, 2.0, 3.0, 4.0], angles=(-0.3, 0.2)) for i in range(4)]
    said += [scan(T0 + i * SECOND, np.arange(1.0, 8.0), angles=(-0.3, 0.1)) for i in range(4, 6)]
    said += [scan(T0 + 6 * SECOND, [9.0], angles=(0.1, 0.2))]
    log = open_log(written(tmp_path, said, kind))
    measured = [scan[~np.isnan(scan)].tolist() for scan in log.ranges]
    assert measured == [[1.0, 2.0, 3.0, 4.0]] * 4 + [np.arange(1.0, 8.0).tolist()] * 2 + [[9.0]]
    assert any("All 7 messages on /scan do not have the same beams" in note for note in log.notes)


def test_a_mount_that_loops_or_never_comes_leaves_the_scans(tmp_path: Path) -> None:
    scans = [scan(T0 + i * SECOND, [1.0, 2.0], frame="a") for i in range(3)]
    loop = [transform(T0 + i * SECOND, *pair, 0.1 * i) for i in range(3) for pair in (("a", "b"), ("b", "a"))]
    log = opened(tmp_path / "a.log", recorded.mcap_bytes([*loop, *scans]))
    assert isinstance(log, ScanLog)
    assert any("The transforms form a loop" in note for note in log.notes)
    other = [transform(T0, "base_link", "elsewhere"), *scans, *(cloud(T0 + i, np.ones((2, 3))) for i in range(3))]
    path = tmp_path / "b.log"
    path.write_bytes(recorded.mcap_bytes(other))
    robot = open_robot_log(path)
    assert any("tf does not say where the frame 'a' sits" in note for note in robot.first.notes)
    assert robot.clouds["/points"].mounts("velodyne", np.array([T0])) is None
    assert len(list(robot.clouds["/points"])) == 3


def test_a_mount_beyond_the_earth_is_still_a_log(tmp_path: Path) -> None:
    far = DEFAULT_LIMITS.max_pose * 0.9
    said = [transform(T0, "base_link", "mast", far), transform(T0 + SECOND, "base_link", "mast", -far)]
    said += [transform(T0 + i * SECOND, "mast", "laser", far * (1 - 2 * i)) for i in range(2)]
    said += [scan(T0 + i * SECOND, [1.0, 2.0]) for i in range(2)]
    assert isinstance(opened(tmp_path / "a.log", recorded.mcap_bytes(said)), ScanLog | MapperError)


@pytest.mark.sampled
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_clouds_and_imus_are_left_out_or_refused(tmp_path: Path, kind: str) -> None:
    said = []
    layout = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("t", "u4"), ("ring", "u2")]
    for i in range(5):
        at = T0 + i * SECOND // 10
        said += [odometry(at, 0.1 * i, 0.0, 0.0), transform(at, "base_link", "velodyne", 0.1, 0.0, 0.2 * i, 0.3 * i)]
        said += [scan(at, [1.0, 2.0], frame="velodyne"), imu(at, 0.1, 0.2, 0.3)]
        said.append(cloud(at, np.ones((6, 3)), layout=layout, rows=2))
    data = written(tmp_path, said, kind).read_bytes()
    path = tmp_path / "damaged"
    rng = np.random.default_rng(list(kind.encode()))
    n = clouds = samples = 0
    for _ in range(-(-ROUNDS // 5)):
        path.write_bytes(flipped(rng, data))
        try:
            robot = open_robot_log(path, limits=LIMITS)
            for stream in robot.clouds.values():
                for one in islice(stream, 20):
                    clouds += 1
                    assert all(len(field) == len(one) for field in one.fields.values())
            for imus in robot.imus.values():
                samples += len(imus.samples())
        except MapperError:
            continue
        n += 1
    assert min(n, clouds, samples) > 0
