"""The decoder of ROS messages against rosbags' serialiser, in both serialisations."""

from __future__ import annotations

import contextlib
import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.ros_messages import POSES, SENSORS, TRANSFORMS, plain_type
from tests.hostile.lengths import lies
from tests.mapper.io.logs import recorded

SINGLE = st.floats(width=32, allow_nan=False, min_value=-1e6, max_value=1e6)
STAMP = st.integers(0, 2**31 * recorded.SECOND - 1)
FRAME = st.text(st.characters(codec="utf-8", exclude_characters="\0/"), max_size=12)
ROS = st.sampled_from([1, 2])


@given(ROS, STAMP, FRAME, st.lists(SINGLE, max_size=40))
def test_laser_scan(ros, stamp, frame, ranges):
    said = recorded.scan(stamp, ranges, frame=frame)
    found = SENSORS["sensor_msgs/LaserScan"](recorded.serialised(said, ros), cdr=ros == 2)
    assert (found.stamp_ns, found.frame) == (stamp, frame)
    np.testing.assert_array_equal(found.ranges, np.array(ranges, dtype=np.float32))
    expected = np.array([-1.5, 0.1, 0.1, 30.0], dtype=np.float32)
    assert [found.angle_min, found.angle_increment, found.range_min, found.range_max] == expected.tolist()


@given(ROS, STAMP, FRAME, st.lists(st.lists(SINGLE, max_size=3), max_size=20))
def test_multi_echo_scans_use_the_first_echo(ros, stamp, frame, beams):
    said = recorded.echoes(stamp, beams, frame=frame)
    found = SENSORS["sensor_msgs/MultiEchoLaserScan"](recorded.serialised(said, ros), cdr=ros == 2)
    assert (found.stamp_ns, found.frame) == (stamp, frame)
    np.testing.assert_array_equal(found.ranges, np.array([row[0] if row else np.inf for row in beams], np.float32))


@given(ROS, STAMP, FRAME, SINGLE)
def test_range(ros, stamp, frame, reading):
    said = recorded.sonar(stamp, reading, frame=frame)
    found = SENSORS["sensor_msgs/Range"](recorded.serialised(said, ros), cdr=ros == 2)
    assert (found.stamp_ns, found.frame, found.beam_width) == (stamp, frame, 0.5)
    assert found.ranges.tolist() == [reading]
    assert [found.range_min, found.range_max] == np.array([0.02, 4.0], dtype=np.float32).tolist()


@given(ROS, STAMP, st.floats(-100, 100), st.floats(-3, 3))
def test_poses_and_transforms(ros, stamp, x, yaw):
    q = recorded.quaternion(yaw)
    expected = (x, -2.0, 0.0, q["x"], q["y"], q["z"], q["w"])
    for said in (make(stamp, x, -2.0, yaw) for make in (recorded.odometry, recorded.estimate)):
        (found,) = POSES[plain_type(said.kind)](recorded.serialised(said, ros), cdr=ros == 2)
        assert (found.stamp_ns, found.pose) == (stamp, expected)
    said = recorded.transform(stamp, "odom", "base_link", x, -2.0, yaw)
    (found,) = TRANSFORMS["tf2_msgs/TFMessage"](recorded.serialised(said, ros), cdr=ros == 2)
    assert (found.stamp_ns, found.frame, found.child, found.pose) == (stamp, "odom", "base_link", expected)


SAID = [
    recorded.scan(1, [1.0, 2.0]),
    recorded.echoes(1, [[1.0], [], [2.0, 3.0]]),
    recorded.sonar(1, 1.0),
    recorded.odometry(1, 1, 2, 3),
    recorded.estimate(1, 1, 2, 3),
    recorded.transform(1, "map", "odom"),
]


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize("said", SAID, ids=lambda said: plain_type(said.kind))
def test_every_prefix_of_a_message_is_refused_but_for_padding(said, ros):
    decoder = (SENSORS | POSES | TRANSFORMS)[plain_type(said.kind)]
    data = recorded.serialised(said, ros)
    # Of a multi-echo scan the intensities, which end it, are not read at all.
    needed = len(data) - 28 if "Echo" in said.kind else len(data)
    for n in range(needed):
        with pytest.raises(BadMessageError):
            decoder(data[:n], cdr=ros == 2)


@pytest.mark.parametrize("ros", [1, 2])
def test_a_wrong_length_at_any_offset_is_refused_or_not_a_length(ros):
    for said in SAID:
        decoder = (SENSORS | POSES | TRANSFORMS)[plain_type(said.kind)]
        data = recorded.serialised(said, ros)
        for at in range(0, len(data) - 4, 4):
            for lie in lies(4):
                with contextlib.suppress(BadMessageError):  # at most places there is no length
                    decoder(data[:at] + lie + data[at + 4 :], cdr=ros == 2)


@pytest.mark.parametrize("said", SAID, ids=lambda said: plain_type(said.kind))
def test_big_endian_cdr(said):
    decoder = (SENSORS | POSES | TRANSFORMS)[plain_type(said.kind)]
    little, big = recorded.serialised(said, 2), recorded.serialised(said, 2, little_endian=False)
    assert little != big
    for found, expected in zip(_as_list(decoder(big, cdr=True)), _as_list(decoder(little, cdr=True)), strict=True):
        for field in dataclasses.fields(expected):
            np.testing.assert_array_equal(getattr(found, field.name), getattr(expected, field.name))


def _as_list(found: Any) -> list[Any]:
    return found if isinstance(found, list) else [found]


@pytest.mark.parametrize(
    ("name", "plain"),
    [("sensor_msgs/msg/LaserScan", "sensor_msgs/LaserScan"), ("tf/tfMessage", "tf/tfMessage"), ("odd", "odd")],
)
def test_plain_type(name, plain):
    assert plain_type(name) == plain
