"""The raw message of any topic, from each container."""

from __future__ import annotations

from pathlib import Path

import pytest

from mapper.core.errors import ReadError
from mapper.io.contents.message_tree import raw_message
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.logs import recorded


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_the_newest_message_at_a_moment_is_read_by_the_recording_s_definition(tmp_path: Path, kind: str) -> None:
    file = recorded.written(tmp_path, list(robot(2)), kind)
    found = raw_message(file, "/imu", T0 + recorded.SECOND)
    assert found.type == "sensor_msgs/Imu"
    assert abs(found.stamp_ns - T0 - recorded.SECOND) < recorded.SECOND // 10
    stamp = found.tree["header"]["stamp"]
    seconds = stamp.get("sec", stamp.get("secs"))
    assert seconds * recorded.SECOND + stamp.get("nanosec", stamp.get("nsecs")) == found.stamp_ns
    assert set(found.tree["angular_velocity"]) == {"x", "y", "z"}
    assert len(found.tree["orientation_covariance"]) == 9
    scan = raw_message(file, "/scan", T0)
    assert scan.tree["header"]["frame_id"] == "laser"
    assert scan.bytes > 4 * len(scan.tree["ranges"])
    with pytest.raises(ReadError, match="no messages on"):
        raw_message(file, "/nothing", T0)
