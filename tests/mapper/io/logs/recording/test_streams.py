"""Clouds and IMUs of recordings as streams: against what was written, and against rosbags' decoder."""

from __future__ import annotations

import threading
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

from mapper.core.errors import ConfigError, ReadError
from mapper.io.clouds import open_clouds
from mapper.io.logs import open_robot_log
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS, Cloud
from mapper.io.logs.selection import Selection
from mapper.sensors.point_cloud import PointCloud
from tests.mapper.io.contents.recorded_robot import imu
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import KINDS, SECOND, Said, cloud, odometry, scan, transform, written

T0, TENTH = 1_600_000_000 * SECOND, SECOND // 10
LAYOUT = [("intensity", "f4"), ("z", "f4"), ("x", "f4"), ("ring", "u2"), ("y", "f4"), ("t", "u4")]


def run(n: int = 8) -> list[Said]:
    """A robot with a lidar, so that its clouds are not cut, an organised cloud of 4 × 25 points, and an IMU."""
    rng = np.random.default_rng(0)
    said = [transform(T0, "base_link", "laser", topic="/tf_static")]
    for i in range(n):
        at = T0 + i * TENTH
        said += [odometry(at, 0.1 * i, 0.0, 0.0), transform(at, "base_link", "velodyne", 0.2, 0.1, 0.3 * i, z=1.0)]
        said += [scan(at, np.full(31, 4.0)), imu(at, float(i), 0.5, 0.3 * i, oriented=i > 2)]
        said.append(cloud(at + 5, rng.normal(0.0, 5.0, (100, 3)).astype(np.float32), layout=LAYOUT, rows=4))
    return said


@pytest.mark.parametrize("kind", KINDS)
def test_clouds_and_imus_beside_a_lidar_are_streams_with_frame_mount_and_stamps(tmp_path: Path, kind: str) -> None:
    said = run()
    path = written(tmp_path, said, kind)
    robot = open_robot_log(path, selection=Selection())
    assert list(robot.sensors) == ["/scan"]
    (topic, stream), (imu_topic, samples) = next(iter(robot.clouds.items())), next(iter(robot.imus.items()))
    assert (len(robot.clouds), len(robot.imus), stream.count, samples.count) == (1, 1, 8, 8)
    clouds = list(stream)
    assert len(list(stream)) == 8, "each iteration reads it again"
    stamps = np.array([T0 + i * TENTH + 5 for i in range(8)])
    np.testing.assert_array_equal(stream.stamps_ns(), stamps)
    theirs: list[Any] = []
    turns: list[Any] = []
    with AnyReader([path]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic == topic:
                theirs.append(reader.deserialize(data, connection.msgtype))
            elif connection.topic == imu_topic:
                turns.append(reader.deserialize(data, connection.msgtype))
    for ours, message in zip(clouds, theirs, strict=True):
        assert (ours.shape, ours.is_organised, ours.frame_id) == ((4, 25), True, "velodyne")
        kinds = {1: "i1", 2: "u1", 4: "u2", 6: "u4", 7: "f4", 8: "f8"}
        layout = np.dtype(
            {
                "names": [one.name for one in message.fields],
                "formats": [kinds[one.datatype] for one in message.fields],
                "offsets": [one.offset for one in message.fields],
                "itemsize": message.point_step,
            }
        )
        points = np.frombuffer(message.data.tobytes(), layout)
        assert ours.points.dtype == np.float32
        np.testing.assert_array_equal(ours.points, np.stack([points[axis] for axis in "xyz"], axis=1))
        assert set(ours.fields) == {"intensity", "ring", "t"}
        for name in ours.fields:
            np.testing.assert_array_equal(ours.fields[name], points[name])
        assert ours.times is not None
        np.testing.assert_allclose(ours.times, points["t"] * 1e-9)
    mounts = stream.mounts("velodyne", stamps - 5)
    assert mounts is not None
    np.testing.assert_allclose(mounts[:, :3, 3], np.tile([0.2, 0.1, 1.0], (8, 1)), atol=1e-12)
    expected = Rotation.from_euler("z", 0.3 * np.arange(8)[:, np.newaxis]).as_matrix()
    np.testing.assert_allclose(mounts[:, :3, :3], expected, atol=1e-12)
    assert stream.mounts("elsewhere", stamps) is None
    whole = samples.samples()
    np.testing.assert_array_equal(whole.stamps_ns, stamps - 5)
    np.testing.assert_array_equal(whole.angular_velocity[:, 2], [one.angular_velocity.z for one in turns])
    np.testing.assert_array_equal(whole.linear_acceleration[:, 0], [one.linear_acceleration.x for one in turns])
    assert whole.frame_id == "imu"
    assert np.isnan(whole.orientation[:3]).all()
    np.testing.assert_array_equal(whole.orientation[3:, 2], [one.orientation.z for one in turns[3:]])


@pytest.mark.parametrize("kind", KINDS)
def test_clouds_of_a_robot_without_a_lidar_are_opened_without_being_cut(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = [one for one in run() if one.topic != "/scan"]
    path = written(tmp_path, said, kind)
    decoded: list[object] = []
    decode = CLOUD_DECODERS["sensor_msgs/PointCloud2"]

    def counted(data: bytes, *, cdr: bool) -> Cloud:
        decoded.append(data)
        return decode(data, cdr=cdr)

    monkeypatch.setitem(CLOUD_DECODERS, "sensor_msgs/PointCloud2", counted)
    (stream,) = open_clouds(path).values()
    assert decoded == []  # none is decoded until they are asked for
    assert [one.stamp_ns for one in stream] == [T0 + i * TENTH + 5 for i in range(8)]
    mounts = stream.mounts("velodyne", np.array([T0 + 2 * TENTH]))
    assert mounts is not None
    np.testing.assert_allclose(mounts[0, :3, 3], [0.2, 0.1, 1.0])
    folder = tmp_path / "none"
    folder.mkdir()
    with pytest.raises(ReadError, match="holds no point clouds"):
        open_clouds(written(folder, [one for one in said if one.topic != "/points"], kind))


def test_no_more_than_a_few_clouds_are_in_memory_and_reading_ends_with_the_reader(tmp_path: Path) -> None:
    points = np.zeros((40_000, 3), dtype=np.float32)
    said = [scan(T0, np.full(31, 4.0)), *(cloud(T0 + i, points) for i in range(30))]
    path = recorded.write_bag(tmp_path / "a.bag", said)
    stream = open_robot_log(path).clouds["/points"]
    before = threading.active_count()
    tracemalloc.start()
    try:
        assert sum(len(one) for one in stream) == 30 * 40_000
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 10 * points.nbytes < path.stat().st_size
    some = iter(stream)
    next(some)
    some.close()  # type: ignore[attr-defined]
    assert threading.active_count() == before


def test_a_cloud_that_cannot_be_read_is_left_out_and_a_cut_recording_gives_what_it_has(tmp_path: Path) -> None:
    said = run(4)
    bad = next(one for one in said if one.topic == "/points")
    bad.fields["point_step"] = 1
    path = recorded.write_bag(tmp_path / "a.bag", said)
    assert len(list(open_robot_log(path).clouds["/points"])) == 3
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 5])
    assert 0 < len(list(open_robot_log(path).clouds["/points"])) < 3


@pytest.mark.parametrize(
    ("layout", "stated", "expected"),
    [
        (("t", "u4"), 250, 250e-9),
        (("offset_time", "u4"), 2_000_000, 2e-3),
        (("time", "f4"), 0.25, 0.25),
        (("timestamp", "f8"), 1_600_000_000.25, 0.25),
        (("timestamp", "f8"), 1_600_000_000.25e9, 0.25),
    ],
)
def test_times_of_points_by_the_customs_of_drivers(
    tmp_path: Path, layout: tuple[str, str], stated: float, expected: float
) -> None:
    one = cloud(T0, np.ones((6, 3)), layout=[("x", "f4"), ("y", "f4"), ("z", "f4"), layout])
    step = int(one.fields["point_step"])
    data = np.asarray(one.fields["data"]).reshape(6, step).copy()
    (field,) = [field for field in one.fields["fields"] if field["name"] == layout[0]]
    size = np.dtype(layout[1]).itemsize
    data[:, field["offset"] : field["offset"] + size] = np.frombuffer(np.array(stated, layout[1]).tobytes(), np.uint8)
    one.fields["data"] = data.reshape(-1)
    path = written(tmp_path, [scan(T0, np.full(31, 4.0)), one], "mcap")
    (found,) = open_robot_log(path).clouds["/points"]
    assert found.times is not None
    np.testing.assert_allclose(found.times, expected, atol=1e-6)


def test_fields_that_share_bytes_do_not_grow_the_message(tmp_path: Path) -> None:
    one = cloud(T0, np.ones((50, 3)), layout=[("x", "f4"), ("y", "f4"), ("z", "f4"), ("rest", "u1")])
    fields = one.fields["fields"]
    step = int(one.fields["point_step"])
    lie = {"name": "all", "offset": 0, "datatype": 2, "count": step}
    fields += [{**lie, "name": f"all{i}"} for i in range(200)] + [{**lie, "name": "far", "count": 2**32 - 1}]
    path = written(tmp_path, [scan(T0, np.full(31, 4.0)), one], "mcap")
    (found,) = open_robot_log(path).clouds["/points"]
    assert sum(field.nbytes for field in found.fields.values()) <= 50 * step
    np.testing.assert_array_equal(found.points, 1.0)


def test_clouds_of_other_lengths_are_refused() -> None:
    points = np.zeros((6, 3))
    assert not PointCloud(points).is_organised
    for wrong in ({"shape": (2, 4)}, {"fields": {"ring": np.zeros(5)}}, {"times": np.zeros(7)}):
        with pytest.raises(ConfigError):
            PointCloud(points, **wrong)
    with pytest.raises(ConfigError):
        PointCloud(np.zeros((6, 4)))
