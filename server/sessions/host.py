"""The host of a session: its clients, its queue of commands, its clock, and the scheduling of its model's computation.

One asyncio task for each session waits for commands and for the next tick, computes the tick on a worker thread (the
kernels release the GIL), and publishes the result. Only the worker thread uses the model during a tick; everything else
(hub, listeners, messages) belongs to the event loop. The host does not depend on the kind of session.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Executor
from contextlib import AbstractAsyncContextManager, AbstractContextManager, asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, TypeVar

import structlog
from msgspec import Struct

from mapper.core.limits import Limits
from server.sessions.computation import (
    MAX_TICK_S,
    TICK_S,
    LongWork,
    Showing,
    TickPace,
    call_each,
    compute_tick,
    hello_message,
    publish_frame,
    send_result,
)
from server.sessions.model import SessionModel
from server.sessions.tick import CommandQueue, QueuedCommand, ReplacingRequests, TickResult
from server.stream.commands import CancelCommand, MeasureCommand
from server.stream.hub import Client, Hub
from server.stream.messages import ErrorMessage
from server.stream.protocol import ProtocolError, encode_text
from server.stream.traffic import Traffic
from server.work.movable_timer import MovableTimer
from server.work.scheduler import URGENT_S, JobOwner, Scheduler, checkpoint

if TYPE_CHECKING:
    from mapper.replay.replay import CheckpointPrefetcher

PAUSE_S = 0.05  #: shortest pause between two runs of deferred work, which takes at most a quarter of the time
MAX_DEFERRAL_S = 0.2  #: longest time that deferred work waits for an empty queue of commands

T = TypeVar("T")

_log = structlog.get_logger(__name__)


class SessionHost:
    """Host that runs one model. The registry creates it on the event loop; :meth:`start` starts the model."""

    model: SessionModel
    hub: Hub

    def __init__(
        self,
        *,
        job_owner: JobOwner,
        pool: Executor,
        limits: Callable[[SessionHost], Limits],
        scheduler: Scheduler,
        link: str | None = None,
        traffic: Traffic | None = None,
        remake_seconds: Callable[[float], None] = lambda _: None,
        clock: Callable[[], float] = time.monotonic,
        place: str = "",
    ) -> None:
        #: A reverse proxy finds the service of a session by the part of the id before the point.
        self.id = f"{place}.{secrets.token_urlsafe(18)}" if place else secrets.token_urlsafe(18)
        self.place = place
        self.epoch_id = secrets.token_hex(8)
        self.job_owner = job_owner
        self.owner = job_owner.visitor
        self.link = link  #: the link that the owner followed, for a guest; else None
        self.scheduler = scheduler
        self.closed = False
        self.listeners: list[Callable[[], None]] = []  #: called after each tick that changed what is shown
        self.on_close: list[Callable[[], None]] = []
        self.unwatched_since = self.commanded_at = clock()
        self._traffic, self._remake_seconds = traffic or Traffic(), remake_seconds
        self._clock, self._pool, self._limits = clock, pool, limits
        self._queue = CommandQueue()
        self._wake = asyncio.Event()
        self._lock = asyncio.Lock()
        self._loop = asyncio.get_running_loop()
        self._task: asyncio.Task[None] | None = None
        self._tick_failed = False  #: whether a tick ended before the layers were updated
        self._pace = TickPace()
        self._is_draw_due = False  #: whether a layer must be drawn that was not watched before
        self._hello_is_old = True  #: whether anything was computed since the ``hello`` message was made
        self._deferred_due = 0.0
        self._requests = ReplacingRequests(clock)
        self._catching_up_since: float | None = None  #: start of the first of the ticks that together compute one map
        self._caught_up = asyncio.Event()  #: set while no such map is being computed
        self._caught_up.set()
        self._showing: Showing  #: progress of such a map, and of each tick
        self._timer = MovableTimer(self._wake.set)

    def prepare(self, model: SessionModel) -> None:
        """Compute the initial state of ``model``, as clients receive it (any thread, before :meth:`start`)."""
        self.model = model
        self._hello = partial(hello_message, model, self.id, self.epoch_id)
        self.hub = Hub(model.layers, self._clock, self._traffic, self._draw_on_demand)
        for message in model.messages():
            self.hub.set_slot(message)
        publish_frame(model, self.hub, watched=self.watched)

    # -- on the event loop --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start running the prepared model."""
        model = self.model
        self._long_work = LongWork(self.hub, lambda: model.fraction, self._clock, lambda: model.working_on)
        self._showing = self._long_work.showing()
        if model.is_catching_up:
            self._caught_up.clear()
        self._task = self._loop.create_task(self._run(), name=f"session {model.kind}")

    async def close(self) -> None:
        """End the session: cancel the task, then disconnect its clients and call the callbacks of ``on_close``."""
        if self.closed:
            return
        self.closed = True
        self._wake.set()
        self._caught_up.set()
        self._queue.close()
        if self._task is not None:
            self._long_work.close()
            await asyncio.gather(self._task, return_exceptions=True)
            self._showing.close()
            self._timer.close()
        for client in self.hub.clients:
            client.notify()
        call_each(self.on_close)
        self.listeners.clear()

    def listen(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` on the event loop after each tick that changed something. It keeps the session running."""
        self.listeners.append(callback)
        self._wake.set()

    def ignore(self, callback: Callable[[], None]) -> None:
        """Remove a callback that :meth:`listen` added."""
        if callback in self.listeners:
            self.listeners.remove(callback)
            self._left()

    def join(self, *, follows: bool = False, page: str = "") -> Client:
        """Return a new client, which will receive the complete state. ``follows`` is whether it belongs to a class."""
        if self._hello_is_old:  # a class of hundreds of clients joins within seconds
            self.hub.slots["hello"], self._hello_is_old = encode_text(self._hello()), False
        client = self.hub.join(follows=follows, page=page)
        self._wake.set()
        return client

    def leave(self, client: Client) -> None:
        """Remove a client."""
        self.hub.leave(client)
        self._left()

    def _left(self) -> None:
        if not self.watched:
            self.unwatched_since = self._clock()
            self.hub.settled = True  # nothing is being computed, so the newest frame remains valid

    @property
    def watched(self) -> bool:
        """Whether the session has a client or a listener."""
        return bool(self.hub.clients or self.listeners)

    @property
    def is_seen(self) -> bool:
        """Whether the session has a listener, or a client that is not stalled."""
        return bool(self.listeners) or any(not client.is_stalled for client in self.hub.clients)

    def acknowledge(self, client: Client, seq: int) -> None:
        """Record that a client has painted the frames up to ``seq``. Raises :class:`ProtocolError`."""
        was_stalled = client.is_stalled
        client.acknowledge(seq)
        if was_stalled or self._pace.is_full:
            self._wake.set()

    def select(self, client: Client, place: tuple[float, float] | None) -> None:
        """Mark ``place``, in map metres, in the 3D views of a client's page; None removes the mark."""
        client.selected = place
        call_each(self.listeners)

    def measure(self, client: Client, measured: MeasureCommand) -> None:
        """Draw a page's measurement in its 3D views. Clicks there are then answered with a `place` message."""
        client.measured = None if measured.points is None else measured
        call_each(self.listeners)

    @property
    def cells(self) -> int:
        """Number of cells of the model's grids."""
        return self.model.footprint.cells

    def enqueue(self, command: Struct, client: Client | None = None) -> None:
        """Queue a command. Raises :class:`ProtocolError` if the queue is full."""
        self._queue.add(command, client)
        self.commanded_at = self._clock()
        if isinstance(command, CancelCommand):
            self._requests.cancel()
        if isinstance(command, self.model.replacing):
            self._requests.add()
        self._wake.set()

    @property
    def has_queued_commands(self) -> bool:
        """Whether commands are queued or being carried out."""
        return bool(self._queue)

    @property
    def is_busy(self) -> bool:
        """Whether the session is computing or has queued commands."""
        return self.has_queued_commands or self._lock.locked() or not self._caught_up.is_set()

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return the prefetcher of checkpoints; None if no checkpoint is missing."""
        return self.model.prefetcher()

    def announce(self, message: Struct) -> None:
        """Send ``message`` to all clients, unless a newer one of its type replaces it first (event loop)."""
        self.hub.set_slot(message)

    def post(self, command: Struct, client: Client | None = None) -> None:
        """Queue a command from any thread; a refused command is only logged."""
        self._loop.call_soon_threadsafe(self._post, command, client)

    def _post(self, command: Struct, client: Client | None) -> None:
        try:
            self.enqueue(command, client)
        except ProtocolError as error:
            _log.info("command refused", code=error.code)

    async def carried_out(self) -> None:
        """Wait until the commands that are queued now have been carried out, or the session has ended (event loop)."""
        await self._queue.carried_out()

    def locked(self) -> AbstractAsyncContextManager[None]:
        """Return a context in which the session computes nothing, so that its maps can be read (event loop)."""
        return self._lock

    @asynccontextmanager
    async def settled(self) -> AsyncIterator[None]:
        """Return a context like :meth:`locked` in which all requested changes of the maps are complete (event loop)."""
        await self._queue.carried_out()
        while True:
            await self._caught_up.wait()
            async with self._lock:
                if self._caught_up.is_set():
                    yield
                    return

    def limits(self) -> Limits:
        """Return the current limits of the session's grids."""
        return self._limits(self)

    def _draw_on_demand(self) -> None:
        self._is_draw_due = True
        self._wake.set()

    # -- task -----------------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        last = self._clock()
        playback = self.model.playback
        while True:
            ticking = playback.playing and self.is_seen
            if self._is_deferred_work_due():
                await self._run_deferred_work()
            elif not (self._queue or self._is_draw_due):
                idle_s = self._idle_s(last + self._tick_s() if ticking else None)
                await self._wait(idle_s if self._caught_up.is_set() else self.model.catch_up_pause_s)
            if self.closed:
                return
            now = self._clock()
            last = last if ticking else now - TICK_S  # time while paused does not count
            due = playback.playing and self.is_seen and now - last >= self._tick_s()
            commands = self._queue.waiting()
            is_due = commands or due or self._is_draw_due
            if not is_due and (self._caught_up.is_set() or self.model.catch_up_pause_s > 0.0):
                continue
            self._is_draw_due = False
            dt = min(now - last, MAX_TICK_S) if due else 0.0
            last = now if due else last
            await self._tick(commands, dt)
            if self.listeners:
                await asyncio.sleep(0)  # lets a task that reads the model run before the next tick

    async def _tick(self, commands: list[QueuedCommand], dt: float) -> None:
        """Compute a tick with ``commands``, the first of the queue, and send its result."""
        rest: list[QueuedCommand] = []
        self._requests.accept_cancel()
        try:
            async with self._lock:
                self._requests.begin_tick()
                job = partial(compute_tick, self.model, commands, dt, lambda: self.closed, whole=self._tick_failed)
                result = await self._computed_tick(self._pace.measured(job))
            self._requests.end_tick(was_cancelled=result.cancelled)
            rest = result.rest
            self._tick_failed = False
            self.deliver(result)
        except Exception:  # noqa: BLE001 - the session stops with an error instead of failing 30 times a second
            _log.exception("a tick failed")
            self._note_catching_up(is_catching_up=False)
            self._stop()
        finally:
            self._queue.finish(len(commands), rest)

    async def _computed_tick(self, job: Callable[[], TickResult]) -> TickResult:
        """Compute a tick. Progress covers all ticks that together compute one map."""
        began = self._catching_up_since
        if began is None:
            began = self._clock()
            self._showing.begin()
        is_catching_up = False
        try:
            is_urgent = self._clock() - began < URGENT_S
            result = await self.scheduler.run(self._pool, self.job_owner, job, interactive=self.watched and is_urgent)
            is_catching_up = self.model.is_catching_up and not self.closed
        finally:
            self._catching_up_since = began
            self._note_catching_up(is_catching_up=is_catching_up)
        return result

    def _note_catching_up(self, *, is_catching_up: bool) -> None:
        if is_catching_up:
            self._caught_up.clear()
            return
        self._caught_up.set()
        self._catching_up_since = None
        self._showing.end()

    def _tick_s(self) -> float:
        return self._pace.tick_s(self.hub, has_listeners=bool(self.listeners))

    def _is_deferred_work_due(self) -> bool:
        """Return whether deferred work is due and no command is queued, or has been due for :data:`MAX_DEFERRAL_S`."""
        if not (self.model.has_deferred_work and self.watched) or self.closed or not self._caught_up.is_set():
            return False
        late = self._clock() - self._deferred_due
        return late >= 0.0 and (not self._queue or late > MAX_DEFERRAL_S)

    def _idle_s(self, tick_at: float | None) -> float | None:
        """Return the seconds until something is due; None if only a command ends the wait."""
        due = [] if tick_at is None else [tick_at]
        if self.model.has_deferred_work and self.watched:
            due.append(self._deferred_due)
        return min(due) - self._clock() if due else None

    async def _run_deferred_work(self) -> None:
        began = self._clock()
        result = TickResult()
        try:
            async with self._lock:
                await self.on_thread(partial(self.model.run_deferred_work, result), interactive=False)
            self.deliver(result)
        except Exception:  # noqa: BLE001 - a defect in deferred work must not stop the session
            _log.exception("deferred work failed")
        now = self._clock()
        self._deferred_due = now + max(PAUSE_S, 3.0 * (now - began))

    async def on_thread(self, job: Callable[[], T], *, interactive: bool = True) -> T:
        """Compute ``job`` on a scheduled worker thread. Clients receive its progress if it takes long."""
        showing = self._long_work.showing()
        showing.begin()
        try:
            return await self.scheduler.run(self._pool, self.job_owner, job, interactive=interactive)
        finally:
            showing.close()

    def cancellable(self, *, by_newer: bool = True) -> AbstractContextManager[None]:
        """Return a context in which ``cancel`` or a newer command cancels the computation (worker thread)."""
        return self._requests.cancellable(by_newer=by_newer)

    def may_continue(self) -> bool:
        """Yield to other sessions (worker thread), and return whether the computation should continue."""
        checkpoint()
        return not (self.closed or self._requests.is_useless)

    def in_background(self) -> Callable[[], bool]:
        """Return a function for a background computation, see :meth:`LongWork.in_background`."""
        return self._long_work.in_background(lambda: not self.closed)

    def _stop(self) -> None:
        """Pause after an internal error, and send an error message."""
        self.model.playback.playing = False
        self._tick_failed = True
        self.hub.send_all(ErrorMessage("internal", "The session stopped because of a defect in the service."))
        with contextlib.suppress(Exception):  # the cause may be what the frame shows
            publish_frame(self.model, self.hub, watched=self.watched)

    async def _wait(self, seconds: float | None) -> None:
        """Wait for a command or a client, for at most ``seconds``."""
        self._wake.clear()
        if not (self.closed or self._queue or (seconds is not None and seconds <= 0.0)):
            if seconds is not None:
                self._timer.set_in(seconds)
            await self._wake.wait()
            self._timer.set(None)

    def deliver(self, result: TickResult) -> None:
        """Send the result of a computation (event loop)."""
        self._wake.set()
        self._hello_is_old = True
        if self.closed:
            return
        send_result(result, self.model, self.hub, self._hello, watched=self.watched)
        if result.remade_ms is not None:
            self._remake_seconds(result.remade_ms / 1000.0)
        if result.changed:
            call_each(self.listeners)
