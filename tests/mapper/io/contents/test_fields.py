"""Numbers of any topic over time, against what was written."""

from __future__ import annotations

import math
import re
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.writer import Writer
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.io.contents import fields, seeking
from mapper.io.contents.downsampling import derivative, moving_average
from mapper.io.contents.fields import field_series, fields_of, numbers_in, unit_of
from mapper.io.contents.message_tree import raw_message
from mapper.io.contents.seeking import stated_in
from mapper.io.logs.opening import parts_of
from tests.mapper.io.contents.recorded_robot import T0, imu, robot
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_every_number_of_a_topic_over_time(tmp_path: Path, kind: str) -> None:
    said = list(robot(2))
    file = recorded.written(tmp_path, said, kind)
    own = [one for one in said if one.topic == "/odom"]
    shares: list[float] = []
    found = field_series(file, "/odom", "nav_msgs/Odometry", progress=shares.append)
    columns = {column.label: found.values[:, n] for n, column in enumerate(found.columns)}
    np.testing.assert_array_equal(found.stamps_ns, [one.stamp_ns for one in own])
    np.testing.assert_allclose(
        columns["pose.pose.position.x"], [one.fields["pose"]["pose"]["position"]["x"] for one in own]
    )
    np.testing.assert_allclose(columns["pose.pose.orientation.yaw"], 0.0)
    assert "pose.covariance[35]" in columns
    assert shares[-1] == pytest.approx(1.0)
    names = {one.topic: one for one in fields_of(file, [("/odom", "nav_msgs/Odometry"), ("/none", "x/Y")])}
    assert set(names["/odom"].fields) == set(columns)
    assert "no messages on '/none'" in names["/none"].why
    with pytest.raises(ReadError):
        field_series(file, "/none", "x/Y")


@pytest.mark.parametrize("ros", [1, 2])
def test_definitions_whose_lines_end_in_carriage_return_and_line_feed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros: int
) -> None:
    said = list(robot(2))
    plain, file = tmp_path / "a.mcap", tmp_path / "b.mcap"
    plain.write_bytes(recorded.mcap_bytes(said, ros=ros))
    register = Writer.register_schema

    def with_crlf(writer: Writer, name: str, encoding: str, data: bytes) -> int:
        return int(register(writer, name, encoding, data.replace(b"\n", b"\r\n")))

    monkeypatch.setattr(Writer, "register_schema", with_crlf)
    file.write_bytes(recorded.mcap_bytes(said, ros=ros))
    assert stated_in(file, ["/imu"])["/imu"].definition.count(b"\r\n") > 10
    topics = sorted({(one.topic, one.kind) for one in said})
    names = fields_of(file, topics)
    assert names == fields_of(plain, topics)
    assert sum(not one.why for one in names) > 3
    assert repr(raw_message(file, "/imu", T0).tree) == repr(raw_message(plain, "/imu", T0).tree)
    values, expected = (field_series(one, "/odom", "nav_msgs/Odometry").values for one in (file, plain))
    np.testing.assert_array_equal(values, expected)


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_the_fields_of_all_topics_of_a_packed_recording_in_one_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    said = list(robot(2))
    plain = recorded.written(tmp_path, said, kind)
    topics = sorted({(one.topic, one.kind) for one in said})
    packed = tmp_path / "packed.tgz"
    with tarfile.open(packed, "w:gz") as archive:
        archive.add(plain, plain.name)
    opened: list[Path] = []
    open_path = Path.open

    def counted(path: Path, *more: Any, **named: Any) -> Any:
        opened.append(path)
        return open_path(path, *more, **named)

    monkeypatch.setattr(Path, "open", counted)
    fields_of(packed, topics[:1])  # which makes the copy of an SQLite file that look-ups share
    opened.clear()
    fields_of(packed, topics[:1])
    of_one = opened.count(packed)
    opened.clear()
    found = fields_of(packed, topics)
    assert len(found) == len(topics) > 4
    assert opened.count(packed) == of_one > 0
    assert found == fields_of(plain, topics)
    numbers = {one.topic: one.fields for one in found}
    if kind != "db3":  # of which the writer states no definitions
        assert numbers["/odom"] == tuple(numbers_in(raw_message(plain, "/odom", 0).tree))


def test_a_damaged_first_message_of_one_topic_leaves_the_fields_of_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rosbag2 can compress each message by itself."""
    said = list(robot(2))
    topics = sorted({(one.topic, one.kind) for one in said})
    plain, packed = tmp_path / "plain.mcap", tmp_path / "packed.mcap"
    plain.write_bytes(recorded.mcap_bytes(said))
    add = Writer.add_message

    def compressed(writer: Writer, channel_id: int, log_time: int, data: bytes, *more: Any, **named: Any) -> None:
        data = zstandard.compress(data)
        if channel_id == damaged:
            data = data[:4] + b"\xff" * 20
        add(writer, channel_id, log_time, data, *more, **named)

    monkeypatch.setattr(Writer, "add_message", compressed)
    expected = fields_of(plain, topics)
    damaged = 0
    packed.write_bytes(recorded.mcap_bytes(said))
    assert fields_of(packed, topics) == expected
    damaged = 1  # the channel of the first message
    packed.write_bytes(recorded.mcap_bytes(said))
    for one, whole in zip(fields_of(packed, topics), expected, strict=True):
        if one.topic == said[0].topic:
            assert one.fields == ()
            assert re.search("damaged|zstd", one.why), one.why
        else:
            assert one == whole


def test_definitions_are_looked_for_up_to_the_part_that_has_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = list(robot(2))
    of_imu, of_odom = ([one for one in said if one.topic == topic] for topic in ("/imu", "/odom"))
    for number, part in enumerate((of_imu, of_imu + of_odom, said)):
        (tmp_path / f"run_{number}.mcap").write_bytes(recorded.mcap_bytes(part))
    assert len(parts_of(tmp_path)[0]) == 3
    looked_at: list[str] = []
    one_file = seeking._stated_in_file

    def counted(file: Path, *more: Any) -> dict[str, seeking.Stated]:
        looked_at.append(file.name)
        return one_file(file, *more)

    monkeypatch.setattr(seeking, "_stated_in_file", counted)
    assert set(stated_in(tmp_path, ["/imu"])) == {"/imu"}
    assert looked_at == ["run_0.mcap"]
    looked_at.clear()
    assert set(stated_in(tmp_path, ["/odom", "/imu"])) == {"/imu", "/odom"}
    assert looked_at == ["run_0.mcap", "run_1.mcap"]


def test_a_message_as_numbers() -> None:
    quarter = math.sqrt(0.5)
    tree = {
        "name": "left",
        "on": True,
        "position": [1, 2.5],
        "ranges": list(range(100)),
        "level": ".inf",
        "orientation": {"x": 0, "y": 0, "z": quarter, "w": quarter},
    }
    found = numbers_in(tree)
    assert (found["on"], found["position[1]"], found["level"]) == (1.0, 2.5, math.inf)
    assert [name for name in found if name.startswith("ranges")] == [f"ranges[{n}]" for n in range(fields.FIRST)]
    assert found["orientation.yaw"] == pytest.approx(math.pi / 2.0)
    assert "name" not in found
    assert numbers_in({}) == {}
    assert math.isnan(numbers_in({"x": 0, "y": 0, "z": 0, "w": 0})[".yaw"])
    assert [unit_of(one) for one in ("twist.twist.linear.x", "a.yaw", "ranges[0]", "linear.w")] == [
        "m/s",
        "rad",
        "",
        "",
    ]


def test_a_long_recording_keeps_its_extremes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fields, "MAX_VALUES", 20_000)
    said = [imu(T0 + n * SECOND // 1000, 9.0 if n == 1234 else math.sin(n), 0.0, 0.0) for n in range(2000)]
    path = tmp_path / "fast.mcap"
    path.write_bytes(recorded.mcap_bytes(said))
    found = field_series(path, "/imu", "sensor_msgs/Imu")
    assert found.values.size <= 20_000
    n = [column.label for column in found.columns].index("angular_velocity.z")
    assert found.values[:, n].max() == 9.0
    assert (np.diff(found.stamps_ns) >= 0).all()


def test_derivative_and_moving_average() -> None:
    stamps = np.arange(0, 101, dtype=np.int64) * (SECOND // 10)
    x: NDArray[np.float64] = np.linspace(0.0, 10.0, 101, dtype=np.float64)
    np.testing.assert_allclose(derivative(stamps, 3.0 * x + 1.0)[1:], 3.0)
    assert np.isnan(derivative(stamps, x)[0])
    turning: NDArray[np.float64] = np.remainder(2.0 * x + np.pi, 2.0 * np.pi) - np.pi
    np.testing.assert_allclose(derivative(stamps, turning, is_angle=True)[1:], 2.0)
    late = stamps + np.where(np.arange(101) >= 50, 60 * SECOND, 0)  # a pause of a minute
    assert np.flatnonzero(np.isnan(derivative(late, x))).tolist() == [0, 50]

    values = np.random.default_rng(4).normal(1e6, 1.0, 101)
    values[7] = np.nan
    own = [np.nanmean(values[np.abs(stamps - stamp) <= SECOND // 2]) for stamp in stamps]
    np.testing.assert_allclose(moving_average(stamps, values, 1.0), own)
    around = np.array([3.1, -3.1, 3.1, -3.1, 3.1])
    mean = moving_average(stamps[:5], around, 10.0, is_angle=True)
    assert (np.abs(np.abs(mean) - math.pi) < 0.05).all()
