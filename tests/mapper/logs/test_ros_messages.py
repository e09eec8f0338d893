"""Our decoder of a few messages against rosbags' serialiser of any, in both serialisations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.logs.ros_messages import POSES, SENSORS, TRANSFORMS, BadMessageError, plain_type
from tests.mapper.logs import recorded

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
def test_multi_echo_scan_takes_the_first_echo(ros, stamp, frame, beams):
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
    for said in (recorded.odometry(stamp, x, -2.0, yaw), recorded.estimate(stamp, x, -2.0, yaw)):
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
def test_a_length_of_four_billion_is_refused(ros):
    for said in SAID:
        decoder = (SENSORS | POSES | TRANSFORMS)[plain_type(said.kind)]
        data = recorded.serialised(said, ros)
        for at in range(0, len(data) - 4, 4):
            lying = data[:at] + b"\xff\xff\xff\xff" + data[at + 4 :]
            try:
                decoder(lying, cdr=ros == 2)
            except BadMessageError:
                continue


def test_big_endian_cdr():
    import struct

    text = (
        struct.pack(">BBHiII", 0, 0, 0, 5, 7, 6) + b"laser\0\0\0" + struct.pack(">7fI2fI", *range(1, 8), 2, 8.0, 9.0, 0)
    )
    found = SENSORS["sensor_msgs/LaserScan"](text, cdr=True)
    assert (found.stamp_ns, found.frame) == (5_000_000_007, "laser")
    assert (found.angle_min, found.angle_increment, found.range_min, found.range_max) == (1, 3, 6, 7)
    assert found.ranges.tolist() == [8.0, 9.0]


@pytest.mark.parametrize(
    ("name", "plain"),
    [("sensor_msgs/msg/LaserScan", "sensor_msgs/LaserScan"), ("tf/tfMessage", "tf/tfMessage"), ("odd", "odd")],
)
def test_plain_type(name, plain):
    assert plain_type(name) == plain
