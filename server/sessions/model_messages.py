"""The messages ``hello`` and ``frame`` of a session, whatever its kind."""

from __future__ import annotations

from typing import Any

from server.sessions.model import SessionModel
from server.stream.protocol import SUBPROTOCOL


def hello_message(model: SessionModel, session_id: str, epoch_id: str) -> dict[str, Any]:
    """Return the ``hello`` message of a session."""
    return {
        "type": "hello",
        "protocol": SUBPROTOCOL,
        "session": session_id,
        "kind": model.kind,
        "title": model.title,
        "epoch_id": epoch_id,
        "speeds": list(model.playback.speeds),
        "parameters": {"table": [], "values": {}},
        "sensor": None,
        "log": None,
    } | model.particulars()


def frame_fields_of(model: SessionModel) -> dict[str, Any]:
    """Return the ``frame`` message of a model, without its type, its time and its scan."""
    playback, (index, count) = model.playback, model.progress
    at_origin = {"stamp": 0.0, "pose": [0.0, 0.0, 0.0], "sensor_pose": [0.0, 0.0, 0.0]}
    frame = {"playing": playback.playing, "speed": playback.speed, "index": index, "count": count, "auto": False}
    return frame | at_origin | model.frame()
