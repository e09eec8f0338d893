"""The contents of a recording against what rosbags wrote into it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from rosbags import rosbag1
from rosbags.rosbag1 import Reader

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.core.se3 import to_euler
from mapper.io.contents import inspection
from mapper.io.contents.inspection import MAX_NAME, MAX_PUBLISHERS, inspect, open_inspected
from mapper.io.contents.model import Contents, FrameEdge, Series
from mapper.io.logs import open_robot_log
from mapper.io.logs.containers import mcap_file, ros1_bag, ros2_db3
from tests.mapper.io.contents.recorded_robot import T0, imu, robot
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, serialised

TICK = SECOND // 10


def series(contents: Contents, topic: str) -> Series:
    return next(one for one in contents.series if one.topic == topic)


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_every_topic_with_count_bytes_span_and_rate(tmp_path: Path, kind: str) -> None:
    said = [*robot(), recorded.text(T0 + SECOND, "hello")]
    contents = inspect(recorded.written(tmp_path, said, kind))
    ros = 1 if kind == "bag" else 2
    held = {topic.name: topic for topic in contents.topics}
    assert set(held) == {one.topic for one in said}
    for name, topic in held.items():
        own = [one for one in said if one.topic == name]
        assert topic.type == own[0].kind.replace("/msg/", "/")
        assert topic.messages == len(own)
        assert topic.bytes == sum(len(serialised(one, ros)) for one in own)
        assert (topic.first_ns, topic.last_ns) == (own[0].stamp_ns, own[-1].stamp_ns)
    assert held["/scan"].rate_hz == pytest.approx(10.0)
    assert held["/tf_static"].rate_hz is None
    assert contents.notes == ()


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_the_numbers_of_the_plots(tmp_path: Path, kind: str) -> None:
    said = list(robot())
    contents = inspect(recorded.written(tmp_path, said, kind))
    turned = series(contents, "/imu")
    assert [column.label for column in turned.columns] == ["x", "y", "z", "x", "y", "z", "yaw"]
    own = [one for one in said if one.topic == "/imu"]
    np.testing.assert_array_equal(turned.stamps_ns, [one.stamp_ns for one in own])
    np.testing.assert_allclose(turned.values[:, 2], [one.fields["angular_velocity"]["z"] for one in own], rtol=1e-6)
    np.testing.assert_allclose(turned.values[:, 3:6], np.tile([0.5, 0.0, 9.81], (len(own), 1)), rtol=1e-6)
    np.testing.assert_allclose(turned.values[:, 6], 0.01 * np.arange(len(own)), atol=1e-6)
    np.testing.assert_allclose(series(contents, "/battery").values[0], [12.0, -1.5, 90.0, 30.5], rtol=1e-6)
    np.testing.assert_allclose(series(contents, "/cmd_vel").values[-1], [0.5, 0.0, -0.25])
    assert series(contents, "/cmd_vel").stamps_ns[1] == T0 + SECOND  # it states no time: that of recording counts
    # Its twist is empty, so the speeds are those of the poses: 0.1 m each tenth of a second.
    driven = series(contents, "/odom")
    assert [column.label for column in driven.columns[:2]] == ["forward from poses", "sideways from poses"]
    np.testing.assert_allclose(driven.values[1], [1.0, 0.0, 0.0, 0.1, 0.0, 0.0], atol=1e-6)


def test_speeds_that_an_odometry_states_are_kept(tmp_path: Path) -> None:
    said = [recorded.odometry(T0 + n * TICK, 1.0 * n, 0.0, 0.0) for n in range(3)]
    said[1].fields["twist"]["twist"]["linear"] = {"x": 9.0, "y": 0.0, "z": 0.0}
    driven = series(inspect(recorded.written(tmp_path, said, "mcap")), "/odom")
    assert driven.columns[0].label == "forward"
    np.testing.assert_allclose(driven.values[:, 0], [0.0, 9.0, 0.0])


def test_speeds_of_poses_far_from_the_origin(tmp_path: Path) -> None:
    """On a circle of 2 m at 0.5 m/s, in UTM coordinates, of which float32 keeps no more than half metres."""
    radius, speed, east, north = 2.0, 0.5, 500_000.0, 5_400_000.0
    angles = speed / radius * 0.02 * np.arange(200)
    said = [
        recorded.odometry(
            T0 + n * SECOND // 50,
            east + radius * math.sin(at),
            north - radius * math.cos(at),
            math.remainder(at, math.tau),
        )
        for n, at in enumerate(angles)
    ]
    driven = series(inspect(recorded.written(tmp_path, said, "mcap")), "/odom")
    assert np.isnan(driven.values[0, :3]).all()
    np.testing.assert_allclose(driven.values[1:, 0], speed, atol=1e-4)
    np.testing.assert_allclose(driven.values[1:, 1], 0.0, atol=1e-4)
    np.testing.assert_allclose(driven.values[1:, 2], speed / radius, atol=1e-4)
    far = [recorded.odometry(T0 + n, 1e37 * (-1) ** n, 0.0, 0.0) for n in range(2)]
    assert np.isnan(series(inspect(recorded.written(tmp_path, far, "db3")), "/odom").values[1, 0])
    still = [recorded.odometry(T0 + n * TICK, 3.0, 0.0, 0.0) for n in range(3)]
    standing = series(inspect(recorded.written(tmp_path, still, "bag")), "/odom")
    np.testing.assert_array_equal(standing.values[:, :3], np.zeros((3, 3)))


def test_an_imu_without_orientation_has_no_yaw(tmp_path: Path) -> None:
    contents = inspect(recorded.written(tmp_path, [imu(T0, 0.1, 0.0, 1.0, oriented=False)], "mcap"))
    assert math.isnan(series(contents, "/imu").values[0, 6])


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_the_transforms_and_their_ages(tmp_path: Path, kind: str) -> None:
    fixed, moving = inspect(recorded.written(tmp_path, list(robot()), kind)).edges
    assert (fixed.parent, fixed.child, fixed.is_static) == ("base_link", "laser", True)
    assert fixed.age_s(T0 + 3600 * SECOND) == 0.0
    assert (moving.parent, moving.child, moving.is_static) == ("odom", "base_link", False)
    assert moving.rate_hz == pytest.approx(10.0)
    assert moving.age_s(T0 + 5 * TICK + TICK // 4) == pytest.approx(0.025)
    assert moving.age_s(T0 + 100 * SECOND) == pytest.approx(96.1)
    assert moving.age_s(T0 - 1) is None


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_where_a_frame_is_at_a_moment(tmp_path: Path, kind: str) -> None:
    turns = [recorded.transform(T0 + n * SECOND, "odom", "base_link", 2.0 * n, n, 0.5 * n) for n in range(3)]
    mast = [
        recorded.transform(T0, "base_link", "mast", 0.2, 0.1, yaw, 0.3, z=0.5, topic="/tf_static") for yaw in (2, 1)
    ]
    fixed, moving = inspect(recorded.written(tmp_path, [*mast, *turns], kind)).edges
    assert moving.pose_at(T0 - 1) is None
    for seconds in (0.0, 0.75, 2.0):
        pose = moving.pose_at(T0 + round(seconds * SECOND))
        assert pose is not None
        assert (*pose[:3], *to_euler(*pose[3:])) == pytest.approx((2.0 * seconds, seconds, 0, 0, 0, 0.5 * seconds))
    assert moving.pose_at(T0 + 60 * SECOND) == moving.pose_at(T0 + 2 * SECOND)
    pose = fixed.pose_at(T0 - 60 * SECOND)
    assert pose is not None, "a static transform is valid at all times"
    assert (*pose[:3], *to_euler(*pose[3:])) == pytest.approx((0.2, 0.1, 0.5, 0.3, 0.0, 1.0))


def test_of_a_long_recording_poses_are_dropped_and_times_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = [recorded.transform(T0 + n * SECOND, "odom", "base_link", 2.0 * n) for n in range(100)]
    said += [recorded.transform(T0 + n * 50 * SECOND, "map", "odom", n) for n in range(2)]
    file = recorded.written(tmp_path, said, "mcap")
    monkeypatch.setattr(inspection, "MAX_POSES", 20)
    slow, fast = inspect(file).edges
    assert (len(slow.poses), len(fast.stamps_ns)) == (2, 100)
    assert 10 <= len(fast.poses) <= 20
    for seconds in (0.0, 17.5, 98.5, 99.0):
        pose = fast.pose_at(T0 + round(seconds * SECOND))
        assert pose is not None
        assert pose[0] == pytest.approx(2.0 * seconds), "the robot drove straight on"


def test_the_age_of_a_transform_over_time() -> None:
    edge = FrameEdge("odom", "base_link", False, T0 + SECOND * np.array([0, 1, 5]))
    ages = edge.ages(T0 + 7 * SECOND)
    assert ((ages.stamps_ns - T0) // SECOND).tolist() == [0, 1, 1, 5, 5, 7]
    assert ages.values[:, 0].tolist() == [0.0, 1.0, 0.0, 4.0, 0.0, 2.0]
    assert edge.ages(T0).values[-1, 0] == 0.0, "the log of scans ends before it"


def test_who_published_a_transform(tmp_path: Path) -> None:
    moving = recorded.transform(T0, "odom", "base_link")
    mast = recorded.transform(T0, "base_link", "mast", topic="/tf_static")
    bag = tmp_path / "run.bag"
    with rosbag1.Writer(bag) as writer:
        for node in ("/amcl", "/ekf" + "x" * 300):
            one = writer.add_connection("/tf", moving.kind, typestore=recorded.store(1), callerid=node)
            writer.write(one, T0, serialised(moving, 1))
        one = writer.add_connection("/tf_static", mast.kind, typestore=recorded.store(1))
        writer.write(one, T0, serialised(mast, 1))
    unnamed, named = inspect(bag).edges
    assert (unnamed.publishers, named.publishers[0]) == ((), "/amcl")
    assert len(named.publishers[1]) == MAX_NAME

    file = tmp_path / "run.mcap"
    with file.open("wb") as out:
        made = Writer(out)
        made.start("ros1")
        definition, _ = recorded.store(1).generate_msgdef(moving.kind, ros_version=1)
        schema = made.register_schema("tf2_msgs/TFMessage", "ros1msg", definition.encode())
        for n in range(MAX_PUBLISHERS + 3):
            channel = made.register_channel("/tf", "ros1", schema, {"callerid": f"/node{n}"})
            made.add_message(channel, T0, serialised(moving, 1), T0)
        made.finish()  # type: ignore[no-untyped-call]
    (edge,) = inspect(file).edges
    assert edge.publishers == tuple(f"/node{n}" for n in range(MAX_PUBLISHERS))


def test_a_message_of_another_length_than_its_type_is_counted_and_noted(tmp_path: Path) -> None:
    lying = imu(T0, 0.1, 0.0, 0.0)
    data = recorded.mcap_bytes([lying, imu(T0 + 1, 0.2, 0.0, 0.0)], compression="none", enable_crcs=False)
    whole = serialised(lying, 2)
    at = data.index(whole[20:])
    path = tmp_path / "run.mcap"
    path.write_bytes(data[: at - 8] + b"\xff\xff\xff\x7f" + data[at - 4 :])  # the length of the frame's name
    contents = inspect(path)
    assert contents.topics[0].messages == 2
    assert contents.notes == ("Messages that could not be read: 1 of 2 on /imu.",)
    assert len(series(contents, "/imu").stamps_ns) == 1


def test_too_many_messages_and_no_log(tmp_path: Path) -> None:
    path = recorded.written(tmp_path, list(robot(1)), "mcap")
    with pytest.raises(LimitError) as caught:
        inspect(path, limits=Limits(max_messages=10))
    assert caught.value.code == "log.too_many_messages"
    (tmp_path / "holiday.txt").write_text("sun, sea\n")
    with pytest.raises(ReadError):
        inspect(tmp_path / "holiday.txt")


def test_the_words_of_a_carmen_log(tmp_path: Path) -> None:
    lines = [f"ODOM {x} 0.0 0.1 0.5 -0.2 0.0 {10 + x} host {x}" for x in range(3)]
    scans = [f"FLASER 2 1.0 2.0 0 0 0 0 0 0 {10 + x} host {x}" for x in range(2)]
    (tmp_path / "a.log").write_text("\n".join(["# a comment", *lines, *scans, "ODOM 1 2"]) + "\n")
    contents = inspect(tmp_path / "a.log")
    odom, flaser = sorted(contents.topics, key=lambda topic: topic.name == "FLASER")
    assert (odom.messages, odom.bytes, odom.span_s) == (4, sum(map(len, lines)) + 3 + len("ODOM 1 2\n"), 2.0)
    assert (flaser.messages, flaser.rate_hz) == (2, 1.0)
    np.testing.assert_allclose(
        series(contents, "ODOM").values, [[0.5, -0.2, 0.0, x, 0.0, 0.1] for x in range(3)], rtol=1e-6
    )


@pytest.mark.parametrize("name", ["bags/b0-tiny.bag", "bags/scans_demo.bag"])
def test_real_recordings_against_rosbags(data_file: Callable[[str], Path], name: str) -> None:
    path = data_file(name)
    counts: dict[str, list[int]] = {}
    with Reader(path) as reader:
        for connection, _, data in reader.messages():
            known = counts.setdefault(connection.topic, [0, 0])
            known[0] += 1
            known[1] += len(data)
    assert {topic.name: [topic.messages, topic.bytes] for topic in inspect(path).topics} == counts


def counted(function: Callable[..., Any], calls: list[object]) -> Callable[..., Any]:
    def call(*args: object) -> Any:
        calls.append(args)
        return function(*args)

    return call


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_a_recording_is_opened_and_inspected_in_one_pass(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded.written(tmp_path, list(robot()), kind)
    expected, alone = inspect(path), open_robot_log(path)
    reads: list[object] = []
    for module, name in ((mcap_file, "byte_stream"), (ros1_bag, "byte_stream"), (ros2_db3, "_opened")):
        monkeypatch.setattr(module, name, counted(getattr(module, name), reads))
    log, contents = open_inspected(path)
    assert len(reads) == 1
    assert contents.topics == expected.topics
    assert [one.topic for one in contents.series] == [one.topic for one in expected.series]
    for ours, theirs in zip(contents.series, expected.series, strict=True):
        np.testing.assert_array_equal(ours.values, theirs.values)
    assert [(one.parent, one.child) for one in contents.edges] == [(one.parent, one.child) for one in expected.edges]
    assert list(log.sensors) == list(alone.sensors)
    np.testing.assert_array_equal(log.first.ranges, alone.first.ranges)
    assert log.first.notes == alone.first.notes
