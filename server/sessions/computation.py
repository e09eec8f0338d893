"""One tick of a session's computation: commands, then time, then layers, then questions."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import structlog

from mapper.core.errors import MapperError, WorkCancelledError
from server.sessions.model import SessionModel
from server.sessions.tick import QueuedCommand, TickResult, error_message
from server.stream.commands import PauseCommand, PlayCommand, SpeedCommand
from server.stream.protocol import ProtocolError, type_of

COMMANDS_S = (
    0.05  #: computing time after which further commands wait for the next tick: other sessions need the threads
)

_log = structlog.get_logger(__name__)


def compute_tick(
    model: SessionModel,
    commands: Sequence[QueuedCommand],
    dt: float,
    closed: Callable[[], bool],
    *,
    whole: bool = False,
) -> TickResult:
    """Carry out ``commands``, advance the model by ``dt`` seconds, and return what to send (worker thread).

    ``closed`` returns whether the session has ended meanwhile; with ``whole`` the layers are drawn completely.
    """
    result = TickResult(rest=[*commands], new_grid=whole)
    started = time.perf_counter()
    while result.rest and not closed():
        queued = result.rest.pop(0)
        _carry_out(model, queued, result)
        if result.unfinished is not None:
            result.rest.insert(0, replace(queued, command=result.unfinished))
            break
        if time.perf_counter() - started > COMMANDS_S:
            break
    if closed():
        return result
    model.settle(result)
    try:
        model.advance(dt if model.playback.playing else 0.0, result)
    except WorkCancelledError:
        result.new_grid = True  # the map is between two states
    except MapperError as error:
        model.playback.playing = False
        result.changed = True
        result.notices.append(error_message(error.code, error.message))
    model.draw(result)
    for answer in result.questions.values():
        answer()
    return result


def _carry_out(model: SessionModel, queued: QueuedCommand, result: TickResult) -> None:
    command = queued.command
    result.client = queued.client
    try:
        match command:
            case PlayCommand():
                model.play()
                result.changed = True
            case PauseCommand():
                model.playback.playing = False
                result.changed = True
            case SpeedCommand(value=value):
                model.playback.set_speed(value)
                result.changed = True
            case _:
                model.handle(command, result)
    except (ProtocolError, MapperError) as error:
        result.refuse(queued.client, error)
        if type(command) in model.resent_on_refusal:
            result.resent.append((queued.client, model.resent_on_refusal[type(command)]))
    except Exception:  # noqa: BLE001 - a defect in one command must not end the session
        _log.exception("a command failed", command=type_of(command))
        message = "The command failed because of a defect in the service."
        result.answers.append((queued.client, error_message("internal", message)))
