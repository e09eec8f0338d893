"""Real bags against rosbags' own reader."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags import rosbag1

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from tests.mapper.io.logs.recorded import store


@pytest.mark.parametrize(
    ("name", "topic", "chosen"),
    [
        ("b0-tiny.bag", "horizontal_laser_2d", True),
        pytest.param("b0-2014-07-21-12-42-53-short.bag", "vertical_laser_2d", True, marks=pytest.mark.long),
        pytest.param("b0-2014-07-21-12-42-53-short.bag", "horizontal_laser_2d", False, marks=pytest.mark.long),
        ("scans_demo.bag", "/front_scan", True),
        ("scans_demo.bag", "/rear_scan", False),
    ],
)
def test_the_scans_of_a_bag_are_those_that_rosbags_reads(data_file, name, topic, chosen):
    path = data_file(f"bags/{name}")
    log = open_log(path, topic=None if chosen else topic)
    with rosbag1.Reader(path) as reader:
        streams = [one for one in reader.connections if one.topic == topic]
        expected: list[Any] = [
            store(1).deserialize_ros1(data, one.msgtype) for one, _, data in reader.messages(streams)
        ]
        assert {(one.topic, one.msgcount) for one in reader.connections} == {(t.name, t.count) for t in log.topics}
    assert log.n_scans == len(expected)
    # The lidars of these bags say no return by range_max itself, 60 m.
    code = np.inf if any("exactly range_max" in note for note in log.notes) else None
    for row, stamp, message in zip(log.ranges, log.stamps_ns, expected, strict=True):
        if "MultiEcho" in type(message).__name__:
            ranges = np.array([beam.echoes[0] if len(beam.echoes) else np.inf for beam in message.ranges], np.float32)
        else:
            ranges = message.ranges
        if code is not None:
            ranges = np.where(ranges == np.float32(message.range_max), np.float32(code), ranges)
        np.testing.assert_array_equal(row, np.where(ranges <= 0.0, np.nan, ranges))
        assert stamp == message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    first = expected[0]
    assert (log.angle_min, log.angle_increment) == (first.angle_min, first.angle_increment)
    assert list(log.trajectories) == ["standing still"]


@pytest.mark.parametrize("name", ["cm_moving_obstacle_0.mcap", "cm_moving_obstacle_0.mcap.zstd"])
def test_a_recording_without_scans_names_what_it_contains(data_file, name):
    with pytest.raises(ReadError, match="nav2_msgs/Costmap"):
        open_log(data_file(f"bags/{name}"))
