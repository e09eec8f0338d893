"""The messages ``hello`` and ``frame`` of a session, and sending what a tick computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import structlog

from server.sessions.model import SessionModel
from server.sessions.tick import TickResult
from server.stream.hub import Hub
from server.stream.message_parts import Table
from server.stream.messages import ErrorMessage, FrameMessage, Hello
from server.stream.protocol import SUBPROTOCOL

_log = structlog.get_logger(__name__)


def publish_frame(model: SessionModel, hub: Hub, *, watched: bool) -> None:
    """Publish the present state of a model; while it plays and is ``watched`` the next tick replaces the frame."""
    frame, scan = frame_message(model), model.scan()
    running = model.playback.playing and watched
    hub.publish(frame, scan, frame.pose[:2], settled=not running)


def send_result(
    result: TickResult, model: SessionModel, hub: Hub, hello: Callable[[], Hello], *, watched: bool
) -> None:
    """Send what a computation changed; ``hello`` returns the message that is sent where it has to be new."""
    hub.set_layers(model.layers)
    if result.is_new_hello:
        hub.set_slot(hello())
    for message in result.slots.values():
        hub.set_slot(message)
    if result.changed:
        publish_frame(model, hub, watched=watched)
    send_answers(result, hub)


def send_answers(result: TickResult, hub: Hub) -> None:
    """Send the answers to commands, what is sent again to those whose commands were refused, and notices."""
    for client, message in result.answers:
        if client is not None:
            client.send(message)
        elif isinstance(message, ErrorMessage):
            _log.info("command refused", code=message.code)
    for client, kind in result.resent:
        if client is not None:
            client.resend(kind)
    for message in result.notices:
        hub.send_all(message)


def call_each(callbacks: Iterable[Callable[[], None]]) -> None:
    """Call each; an exception that one raises is logged, and the others are called."""
    for callback in (*callbacks,):
        try:
            callback()
        except Exception:  # noqa: BLE001 - a defect in one listener must not stop the session
            _log.exception("a listener failed")


def hello_message(model: SessionModel, session_id: str, epoch_id: str) -> Hello:
    """Return the ``hello`` message of a session."""
    hello = Hello(
        protocol=SUBPROTOCOL,
        session=session_id,
        kind=model.kind,
        title=model.title,
        epoch_id=epoch_id,
        speeds=model.playback.speeds,
        parameters=Table([], {}),
        sensor=None,
        log=None,
        tables=model.tables(),
    )
    model.complete(hello)
    return hello


def frame_message(model: SessionModel) -> FrameMessage:
    """Return the ``frame`` message of a model, without its time and its scan."""
    index, count = model.progress
    frame = FrameMessage(
        t=0.0,
        playing=model.playback.playing,
        speed=model.playback.speed,
        index=index,
        count=count,
        stamp=0.0,
        pose=(0.0, 0.0, 0.0),
        sensor_pose=(0.0, 0.0, 0.0),
        auto=False,
    )
    model.complete_frame(frame)
    return frame
