"""The ticks of a session: what each tick computes (commands, time, layers, questions) and sends, and their pace.

Long computations report their progress, and background computations wait for them.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

import structlog

from mapper.core.errors import MapperError, WorkCancelledError
from server.sessions.model import SessionModel
from server.sessions.tick import QueuedCommand, TickResult
from server.stream.commands import PauseCommand, PlayCommand, SpeedCommand
from server.stream.hub import Hub
from server.stream.message_parts import Table
from server.stream.messages import ErrorMessage, FrameMessage, Hello, WorkingMessage
from server.stream.protocol import SUBPROTOCOL, ProtocolError, type_of
from server.work.movable_timer import MovableTimer
from server.work.scheduler import checkpoint, wait_without_turn

COMMANDS_S = (
    0.05  #: computing time after which further commands wait for the next tick, so that other sessions get threads
)

_log = structlog.get_logger(__name__)
T = TypeVar("T")
TICK_S = 1.0 / 30.0
MAX_TICK_S = 0.1  #: longest wall time that one tick simulates; a slow machine plays more slowly
OVERLOADED_TICK_S = 0.5  #: between unacknowledged ticks while ticks wait long for a thread
SHOWN_AFTER_S = 0.3  #: computations that take longer send their progress,
SHOWN_EVERY_S = 0.25  #: at this interval
#: Longest total time that a background computation waits for long ones of its session, since it holds a thread.
MAX_BACKGROUND_WAIT_S = 60.0


def compute_tick(
    model: SessionModel,
    commands: Sequence[QueuedCommand],
    dt: float,
    closed: Callable[[], bool],
    *,
    whole: bool = False,
) -> TickResult:
    """Carry out ``commands``, advance the model by ``dt`` seconds, and return what to send (worker thread).

    ``closed`` returns whether the session has ended in the meantime. If ``whole``, the layers are drawn completely.
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
        result.new_grid = True  # the map was left half updated
    except MapperError as error:
        model.playback.playing = False
        result.changed = True
        result.notices.append(ErrorMessage(error.code, error.message))
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
        result.answers.append((queued.client, ErrorMessage("internal", message)))


def publish_frame(model: SessionModel, hub: Hub, *, watched: bool) -> None:
    """Publish the current state of a model. If it plays and is ``watched``, the next tick replaces the frame."""
    frame, scan = frame_message(model), model.scan()
    running = model.playback.playing and watched
    hub.publish(frame, scan, frame.pose[:2], settled=not running)


def send_result(
    result: TickResult, model: SessionModel, hub: Hub, hello: Callable[[], Hello], *, watched: bool
) -> None:
    """Send what a computation changed. ``hello`` returns the message that is sent if it has to be renewed."""
    hub.set_layers(model.layers)
    if result.is_new_hello:
        hub.set_slot(hello())
    for message in result.slots.values():
        hub.set_slot(message)
    if result.changed:
        publish_frame(model, hub, watched=watched)
    send_answers(result, hub)


def send_answers(result: TickResult, hub: Hub) -> None:
    """Send the answers to commands, the messages that are resent after refused commands, and the notices."""
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
    """Call each callback; log an exception of one and continue with the others."""
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


def working_message(elapsed_s: float | None = None, fraction: float | None = None, what: str = "map") -> WorkingMessage:
    """Return a ``working`` message. Without ``elapsed_s`` it says that the computation has ended."""
    return WorkingMessage(
        elapsed_s=None if elapsed_s is None else round(elapsed_s, 2),
        fraction=None if fraction is None else round(fraction, 3),
        what=what,
    )


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


class TickPace:
    """Chooses the time until the next tick, so that no frame is computed before a client can receive it.

    While ticks wait for a thread for longer than :data:`TICK_S`, the next one is computed only after a client has
    acknowledged the last frame or :data:`OVERLOADED_TICK_S` have passed: if a page receives two frames between two
    repaints, it paints only the newer one.
    """

    def __init__(self) -> None:
        self.is_full = False  #: whether no client could be sent a frame when the time was last chosen
        self.waited_s = 0.0  #: how long the newest tick waited for a thread

    def tick_s(self, hub: Hub, *, has_listeners: bool) -> float:
        """Return the time from one tick to the next, seconds. Listeners are called at each tick."""
        is_overloaded = self.waited_s > TICK_S
        self.is_full = not has_listeners and not (hub.has_acknowledged if is_overloaded else hub.has_room)
        if not self.is_full:
            return TICK_S
        return OVERLOADED_TICK_S if is_overloaded else MAX_TICK_S

    def measured(self, job: Callable[[], T]) -> Callable[[], T]:
        """Return ``job``, a tick, wrapped so that it records how long it waited for its thread from now on."""
        asked = time.monotonic()

        def run() -> T:
            self.waited_s = time.monotonic() - asked
            return job()

        return run


class Showing:
    """Runs ``show`` as a task during a computation, from :data:`SHOWN_AFTER_S` after its start.

    Most computations end earlier and need no task. It can be restarted.
    """

    def __init__(self, show: Callable[[], Coroutine[None, None, None]]) -> None:
        self._show = show
        self._task: asyncio.Task[None] | None = None
        self._timer = MovableTimer(self._start)

    def begin(self) -> None:
        """Record that a computation has started."""
        self._timer.set_in(SHOWN_AFTER_S)

    def _start(self) -> None:
        self._task = asyncio.ensure_future(self._show())

    def end(self) -> None:
        """Record that the computation has ended."""
        self._timer.set(None)
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def close(self) -> None:
        """Record that the computation has ended and that none follows."""
        self.end()
        self._timer.close()


class LongWork:
    """The progress of a session's computations.

    ``fraction`` returns the completed share of the current computation, and ``what`` its subject.
    """

    def __init__(
        self, hub: Hub, fraction: Callable[[], float | None], clock: Callable[[], float], what: Callable[[], str]
    ) -> None:
        self._hub, self._fraction, self._clock, self._what = hub, fraction, clock, what
        self._nothing_long = threading.Event()  #: set while no computation shows its progress
        self._nothing_long.set()

    def showing(self) -> Showing:
        """Return the :class:`Showing` that sends the progress of a computation."""
        return Showing(self._show)

    async def _show(self) -> None:
        began = self._clock() - SHOWN_AFTER_S
        try:
            self._nothing_long.clear()
            while True:
                self._hub.set_slot(working_message(self._clock() - began, self._fraction(), self._what()))
                await asyncio.sleep(SHOWN_EVERY_S)
        finally:
            self._nothing_long.set()
            self._hub.set_slot(working_message())

    def close(self) -> None:
        """Release the background computations that wait."""
        self._nothing_long.set()

    def in_background(self, is_open: Callable[[], bool]) -> Callable[[], bool]:
        """Return a function that a background computation calls regularly (worker thread).

        The function yields to other sessions, waits while this session runs a long computation, for at most
        :data:`MAX_BACKGROUND_WAIT_S` in total, and returns ``is_open()``.
        """
        left = MAX_BACKGROUND_WAIT_S

        def waited() -> bool:
            nonlocal left
            checkpoint()
            if left > 0.0 and not self._nothing_long.is_set():
                began = time.monotonic()
                wait_without_turn(self._nothing_long, left)
                left -= time.monotonic() - began
            return is_open()

        return waited
