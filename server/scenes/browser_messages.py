"""Filter for messages from viser's client to viser. Only those that a scene needs, with valid fields, pass.

At a client's request, viser would also open a public tunnel, accept files and set any property of its objects.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

UNIT_TOLERANCE = 1e-3  #: tolerance of the norm of a unit quaternion

_Number = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
_Point = tuple[_Number, _Number, _Number]
_Pixels = Annotated[float, msgspec.Meta(ge=1, le=100_000)]  # may be fractional


class _Camera(msgspec.Struct, tag_field="type", tag="ViewerCameraMessage", forbid_unknown_fields=True):
    """viser's message with the pose of the browser's camera."""

    wxyz: tuple[_Number, _Number, _Number, _Number]
    position: _Point
    fov: _Number
    near: _Number
    far: _Number
    image_height: _Pixels
    image_width: _Pixels
    look_at: _Point
    up_direction: _Point


class _Moved(msgspec.Struct, tag_field="type", tag="CameraMovedMessage", forbid_unknown_fields=True):
    """:class:`server.scenes.viser_server.CameraMovedMessage`."""


class _Click(msgspec.Struct, tag_field="type", tag="ScenePointerMessage", forbid_unknown_fields=True):
    """viser's message about a click in the scene."""

    event_type: Literal["click"]
    ray_origin: _Point
    ray_direction: _Point
    screen_pos: Annotated[list[tuple[_Number, _Number]], msgspec.Meta(min_length=1, max_length=1)]
    modifier: Annotated[str, msgspec.Meta(max_length=100)] | None


class _Value(msgspec.Struct, forbid_unknown_fields=True):
    value: bool | float | Annotated[str, msgspec.Meta(max_length=100)]


class _Update(msgspec.Struct, tag_field="type", tag="GuiUpdateMessage", forbid_unknown_fields=True):
    """viser's message about a changed control."""

    uuid: Annotated[str, msgspec.Meta(max_length=100)]
    updates: _Value


_NodeName = Annotated[str, msgspec.Meta(pattern=r"^/[A-Za-z0-9_/-]{1,200}\Z")]
_Owner = Literal[""]  #: the scene of the server; viser could also keep a scene for each client


class _GizmoMove(msgspec.Struct, tag_field="type", tag="TransformControlsUpdateMessage", forbid_unknown_fields=True):
    """viser's message about a moved or rotated gizmo."""

    name: _NodeName
    wxyz: tuple[_Number, _Number, _Number, _Number]
    position: _Point
    owner: _Owner = ""


class _GizmoDragStart(
    msgspec.Struct, tag_field="type", tag="TransformControlsDragStartMessage", forbid_unknown_fields=True
):
    """viser's message about the start of a gizmo drag."""

    name: _NodeName
    owner: _Owner = ""


class _GizmoDragEnd(
    msgspec.Struct, tag_field="type", tag="TransformControlsDragEndMessage", forbid_unknown_fields=True
):
    """viser's message about the end of a gizmo drag."""

    name: _NodeName
    owner: _Owner = ""


_passed = msgspec.msgpack.Decoder(_Camera | _Moved | _Click | _Update | _GizmoMove | _GizmoDragStart | _GizmoDragEnd)


def passes(message: bytes) -> bool:
    """Return whether a browser's message may be forwarded. viser closes the connection on an invalid field."""
    try:
        content = _passed.decode(message)
    except (msgspec.DecodeError, RecursionError):
        return False
    if isinstance(content, _Update):
        return not isinstance(content.updates.value, float) or math.isfinite(content.updates.value)
    if isinstance(content, _GizmoMove):
        return abs(math.hypot(*content.wxyz) - 1.0) <= UNIT_TOLERANCE
    return True
