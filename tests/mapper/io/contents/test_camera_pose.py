"""What a camera of a recording saw of the map, against a pinhole in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, ReadError
from mapper.io.contents.camera_pose import sight_of
from mapper.io.contents.inspection import inspect
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import Said

T0 = 1_700_000_000 * recorded.SECOND
FOCAL, SIZE = 200.0, (320, 240)  # pixels
AHEAD_M, UP_M = 0.3, 1.0  # of the camera on the robot, which looks ahead
TOPIC = "/front/image_raw"


def said(topic: str = "/tf_static", camera: str = "camera", at_ns: int = T0) -> list[Said]:
    """A camera on a mast on the robot; the frame of the base is not the root of the robot's frames."""
    return [
        recorded.transform(T0, "footprint", "base_link", z=0.1, topic="/tf_static"),
        recorded.transform(at_ns, "footprint", camera, AHEAD_M, z=UP_M + 0.1, topic=topic),
        recorded.transform(T0, "camera", "optical", yaw=-math.pi / 2, roll=-math.pi / 2, topic="/tf_static"),
        recorded.camera(T0, SIZE, FOCAL, "/front/camera_info"),
    ]


@pytest.mark.parametrize("kind", recorded.KINDS)
@pytest.mark.parametrize("topic", [TOPIC, f"{TOPIC}/compressed", "/front/image_rect"])
@pytest.mark.parametrize("tf", ["/tf_static", "/tf"])
def test_a_place_is_seen_where_a_pinhole_sees_it(tmp_path: Path, kind: str, topic: str, tf: str) -> None:
    contents = inspect(recorded.written(tmp_path, said(tf), kind))
    x, y, yaw = 1.0, 2.0, 0.4
    for ahead, left, up in [(2.0, 0.0, 0.0), (3.0, 0.7, 0.0), (1.5, -0.4, 1.2), (1.5, 1.4, 1.2), (-2.0, 0.5, 0.0)]:
        place = (
            x + ahead * math.cos(yaw) - left * math.sin(yaw),
            y + ahead * math.sin(yaw) + left * math.cos(yaw),
            up,
        )
        depth = ahead - AHEAD_M
        sight = sight_of(contents, topic, "base_link", np.array([x, y, yaw]), place, T0)
        u, v = 0.5 - FOCAL / SIZE[0] * left / depth, 0.5 + FOCAL / SIZE[1] * (UP_M - up) / depth
        if depth < 0.0:
            assert sight == ("behind", 0.0, 0.0)
        elif 0.0 <= u <= 1.0:
            assert sight.where == "inside"
            assert sight[1:] == pytest.approx((u, v))
        else:
            assert sight == ("outside", 0.0, 0.0)


def test_a_mount_that_moves_is_that_of_the_moment(tmp_path: Path) -> None:
    later = recorded.transform(T0 + recorded.SECOND, "footprint", "camera", AHEAD_M + 0.2, z=UP_M + 0.1)
    contents = inspect(recorded.written(tmp_path, [*said("/tf"), later], "mcap"))
    half = T0 + recorded.SECOND // 2
    sight = sight_of(contents, TOPIC, "base_link", np.zeros(3), (AHEAD_M + 2.1, 0.5, UP_M), half)
    assert sight[1:] == pytest.approx((0.5 - FOCAL / SIZE[0] * 0.25, 0.5))


def test_only_raw_images_have_the_distortion_of_the_lens(tmp_path: Path) -> None:
    recording = said()
    fields = recording[-1].fields
    fields |= {"d": np.array([-0.2, 0.0, 0.0, 0.0, 0.0])}
    fields["p"][0] = fields["p"][5] = 100.0  # of the rectified image, which shows more
    contents = inspect(recorded.written(tmp_path, recording, "mcap"))
    place = (AHEAD_M + 2.0, -0.5, UP_M)  # 0.25 to the right of the axis
    raw = sight_of(contents, TOPIC, "base_link", np.zeros(3), place, T0)
    assert raw[1:] == pytest.approx((0.5 + FOCAL / SIZE[0] * 0.25 * (1.0 - 0.2 / 16.0), 0.5))
    rectified = sight_of(contents, "/front/image_rect_color/compressed", "base_link", np.zeros(3), place, T0)
    assert rectified[1:] == pytest.approx((0.5 + 100.0 / SIZE[0] * 0.25, 0.5))
    fields["distortion_model"] = "fisheye"
    contents = inspect(recorded.written(tmp_path, recording, "mcap"))
    with pytest.raises(ConfigError, match="'fisheye'"):
        sight_of(contents, TOPIC, "base_link", np.zeros(3), place, T0)


@pytest.mark.parametrize(
    ("topic", "base", "recording", "why"),
    [
        ("/rear/image_raw", "base_link", said(), "the log has no CameraInfo on /rear/camera_info"),
        (TOPIC, "robot", said(), "no transform joins the camera’s frame 'optical' with 'robot'"),
        (TOPIC, "base_link", said(camera="other"), "no transform joins the camera’s frame 'optical' with 'base_link'"),
        (
            TOPIC,
            "base_link",
            said("/tf", at_ns=T0 + 1),
            "no transform from 'camera' to 'footprint' is that old",
        ),
    ],
)
def test_what_a_recording_lacks_is_said(tmp_path: Path, topic: str, base: str, recording: list[Said], why: str) -> None:
    contents = inspect(recorded.written(tmp_path, recording, "mcap"))
    with pytest.raises(ReadError) as refused:
        sight_of(contents, topic, base, np.zeros(3), (1.0, 0.0, 0.0), T0)
    assert refused.value.message == why
