"""Messages of a browser that pass the proxy to viser."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from viser._messages import Message

from server.scenes.browser_messages import passes
from server.scenes.viser_server import CameraMovedMessage
from tests.server.scenes.viser_client import CAMERA

CLICK = {
    "type": "ScenePointerMessage",
    "event_type": "click",
    "ray_origin": (1.0, 2.0, 5.0),
    "ray_direction": (0.0, 0.0, -1.0),
    "screen_pos": ((0.5, 0.5),),
    "modifier": None,
}


MOVE = {
    "type": "TransformControlsUpdateMessage",
    "name": "/goal/handles",
    "wxyz": (0.6, 0.0, 0.0, 0.8),
    "position": (1.0, 2.0, 0),
    "owner": "",
}
GRIP = {"type": "TransformControlsDragStartMessage", "name": "/goal/handles", "owner": ""}


@pytest.mark.parametrize(
    ("message", "passed"),
    [
        (CAMERA, True),
        (CAMERA | {"image_height": 600.5, "position": (0, 1, 2)}, True),
        (CAMERA | {"image_height": 0}, False),
        (CAMERA | {"position": None}, False),
        (CAMERA | {"position": (1.0, 2.0)}, False),
        (CAMERA | {"fov": float("nan")}, False),
        (CAMERA | {"more": 1}, False),
        (CLICK, True),
        (CLICK | {"modifier": "shift"}, True),
        (CLICK | {"ray_origin": None}, False),
        (CLICK | {"ray_direction": (0.0, 0.0, float("inf"))}, False),
        (CLICK | {"event_type": "rect-select"}, False),
        (CLICK | {"screen_pos": ()}, False),
        ({key: value for key, value in CLICK.items() if key != "modifier"}, False),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}}, True),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "per_scan"}}, True),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": float("nan")}}, False),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": [1]}}, False),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "x" * 1000}}, False),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"uuid": "y"}}, False),
        ({"type": "GuiUpdateMessage", "uuid": "x"}, False),
        ({"type": "RunJavascriptMessage", "source": "alert(1)"}, False),
        ({"type": "GetRenderResponseMessage"}, False),
        ({"type": CameraMovedMessage.__name__}, True),
        ({"type": "CameraMovedMessage", "position": (1.0, 2.0, 3.0)}, False),
        (MOVE, True),
        (MOVE | {"wxyz": (0, 0, 0, -1)}, True),
        (MOVE | {"wxyz": (0.0, 0.0, 0.0, 0.0)}, False),
        (MOVE | {"wxyz": (2.0, 0.0, 0.0, 0.0)}, False),
        (MOVE | {"wxyz": (float("nan"), 0.0, 0.0, 1.0)}, False),
        (MOVE | {"wxyz": (1.0, 0.0, 0.0)}, False),
        (MOVE | {"position": (0.0, float("inf"), 0.0)}, False),
        (MOVE | {"position": (0.0, 1e10, 0.0)}, False),
        (MOVE | {"position": "abc"}, False),
        (MOVE | {"position": None}, False),
        (MOVE | {"name": "goal"}, False),
        (MOVE | {"name": "/"}, False),
        (MOVE | {"name": "/goal\n"}, False),
        (MOVE | {"name": "/" + 1000 * "x"}, False),
        (MOVE | {"name": 7}, False),
        (MOVE | {"owner": "1"}, False),
        (MOVE | {"props": {}}, False),
        ({key: value for key, value in MOVE.items() if key != "position"}, False),
        (GRIP, True),
        (GRIP | {"type": "TransformControlsDragEndMessage"}, True),
        (GRIP | {"owner": "1"}, False),
        (GRIP | {"name": ["/goal/handles"]}, False),
        (GRIP | {"wxyz": (1.0, 0.0, 0.0, 0.0)}, False),
        ({"type": "TransformControlsDragEndMessage"}, False),
        ({"type": "TransformControlsMessage", "name": "/goal/handles"}, False),
        ({"type": "SceneNodeDragMessage", "name": "/goal/handles"}, False),
        (["ViewerCameraMessage"], False),
        ({"type": ["ViewerCameraMessage"]}, False),
        (17, False),
    ],
)
def test_messages_that_pass_the_proxy(message: Any, passed: bool) -> None:
    encoded = msgspec.msgpack.encode(message)
    assert passes(encoded) is passed
    if passed:  # viser, which would close the connection otherwise, can read it
        assert type(Message.deserialize(encoded)).__name__ == message["type"]
