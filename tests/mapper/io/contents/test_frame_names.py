"""The frames that messages name, of recordings with and without definitions, against what was written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from mapper.io.contents import fields
from mapper.io.contents.fields import HEADED, MAX_FRAMES, MAX_NAME, fields_of, frames_in, frames_of_type
from mapper.io.contents.seeking import Stated
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.logs import recorded

SAID = [
    *robot(1),
    recorded.sonar(T0, 1.0, frame="/sonar_link"),
    recorded.text(T0, "hello"),
    recorded.path(T0, [recorded.pose_stamped(T0, 1.0, 2.0, 0.0, frame="plan")]),
]
NAMED = {
    "/imu": ("imu",),
    "/scan": ("laser",),
    "/sonar": ("sonar_link",),
    "/odom": ("odom", "base_link"),
    "/battery": ("base_link",),
    "/cmd_vel": (),
    "/chatter": (),
    "/trajectory": ("map", "plan"),
    "/tf": ("odom", "base_link"),
    "/tf_static": ("base_link", "laser"),
}
TOPICS = sorted({(one.topic, one.kind.replace("/msg/", "/")) for one in SAID})


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_every_frame_of_the_first_message_of_each_topic(tmp_path: Path, kind: str) -> None:
    found = fields_of(recorded.written(tmp_path, SAID, kind), TOPICS)
    assert {one.topic: one.frames for one in found} == NAMED


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_without_definitions_the_frames_of_known_types(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    def nothing(*_: object) -> dict[str, Stated]:
        return {}

    monkeypatch.setattr(fields, "stated_in", nothing)
    found = {one.topic: one for one in fields_of(recorded.written(tmp_path, SAID, kind), TOPICS)}
    transforms = {"/tf": (), "/tf_static": (), "/trajectory": ("map",)}  # their lists are not gone through
    assert {topic: one.frames for topic, one in found.items()} == NAMED | transforms
    assert all("does not define" in one.why for one in found.values())


def test_types_that_begin_with_a_header() -> None:
    for ros in (1, 2):
        store = recorded.store(ros)
        known = {name.replace("/msg/", "/"): definition for name, definition in store.fielddefs.items()}
        for kind in HEADED & set(known):
            name, (_, what) = known[kind][1][0]
            assert (name, what) == ("header", "std_msgs/msg/Header"), kind
    assert len(HEADED - set(known)) <= 1, "ROS 2 knows all but the cloud that it dropped"


def test_names_of_a_hostile_message_are_limited() -> None:
    many: dict[str, Any] = {"all": [{"header": {"frame_id": f"f{n}"}} for n in range(2 * MAX_FRAMES)]}
    assert len(frames_in(many)) == MAX_FRAMES
    assert [len(one) for one in frames_in({"frame_id": "x" * 10_000})] == [MAX_NAME]
    assert frames_in({"frame_id": "", "child_frame_id": 7}) == ()
    assert frames_in({"frame_id": "a\x1b[2Jb"}) != ("a\x1b[2Jb",)
    whole = recorded.serialised(recorded.sonar(T0, 1.0), 2)
    assert frames_of_type("sensor_msgs/Range", whole, cdr=True) == ("sonar",)
    assert frames_of_type("sensor_msgs/Range", whole[:14], cdr=True) == ()
