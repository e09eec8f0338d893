"""What a camera of a recording saw of the map, against a pinhole in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.contents.camera_pose import map_projection
from mapper.io.contents.inspection import inspect
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import Said

T0 = 1_700_000_000 * recorded.SECOND
FOCAL, SIZE = 200.0, (320, 240)  # pixels
AHEAD_M, UP_M = 0.3, 1.0  # of the camera on the robot, which looks ahead
TOPIC = "/front/image_raw"


def said(topic: str = "/tf_static", camera: str = "camera") -> list[Said]:
    """A camera on a mast on the robot; the frame of the base is not the root of the robot's frames."""
    return [
        recorded.transform(T0, "footprint", "base_link", z=0.1, topic="/tf_static"),
        recorded.transform(T0, "footprint", camera, AHEAD_M, z=UP_M + 0.1, topic=topic),
        recorded.transform(T0, "camera", "optical", yaw=-math.pi / 2, roll=-math.pi / 2, topic="/tf_static"),
        recorded.camera(T0, SIZE, FOCAL, "/front/camera_info"),
    ]


@pytest.mark.parametrize("kind", recorded.KINDS)
@pytest.mark.parametrize("topic", [TOPIC, f"{TOPIC}/compressed"])
def test_a_place_is_seen_where_a_pinhole_sees_it(tmp_path: Path, kind: str, topic: str) -> None:
    contents = inspect(recorded.written(tmp_path, said(), kind))
    x, y, yaw = 1.0, 2.0, 0.4
    projection = map_projection(contents, topic, "base_link", np.array([x, y, yaw]))
    for ahead, left, up in [(2.0, 0.0, 0.0), (3.0, 0.7, 0.0), (1.5, -0.4, 1.2), (-2.0, 0.5, 0.0)]:
        place = (
            x + ahead * math.cos(yaw) - left * math.sin(yaw),
            y + ahead * math.sin(yaw) + left * math.cos(yaw),
            up,
        )
        depth = ahead - AHEAD_M
        u, v, w = projection @ [*place, 1.0]
        assert w == pytest.approx(depth)
        assert u / w == pytest.approx(0.5 - FOCAL / SIZE[0] * left / depth)
        assert v / w == pytest.approx(0.5 + FOCAL / SIZE[1] * (UP_M - up) / depth)


@pytest.mark.parametrize(
    ("topic", "base", "recording", "why"),
    [
        ("/rear/image_raw", "base_link", said(), "the log has no CameraInfo on /rear/camera_info"),
        (TOPIC, "robot", said(), "no transform joins the camera’s frame 'optical' with 'robot'"),
        (TOPIC, "base_link", said(camera="other"), "no transform joins the camera’s frame 'optical' with 'base_link'"),
        (TOPIC, "base_link", said("/tf"), "the transform from 'camera' to 'footprint' is not static"),
    ],
)
def test_what_a_recording_lacks_is_said(tmp_path: Path, topic: str, base: str, recording: list[Said], why: str) -> None:
    contents = inspect(recorded.written(tmp_path, recording, "mcap"))
    with pytest.raises(ReadError) as refused:
        map_projection(contents, topic, base, np.zeros(3))
    assert refused.value.message == why
