"""A session: one grid, its parameters, its clock, and the browsers that watch it.

One asyncio task for each session waits for commands and for the next tick, lets a worker thread compute (the kernels
release the GIL), and publishes the outcome. What the worker touches is touched by nobody else meanwhile; everything
else (hub, listeners, slots) belongs to the event loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import time
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import AbstractAsyncContextManager
from functools import partial
from typing import Any, TypeVar

import structlog

from mapper.core.limits import Limits
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.replay.incremental import CheckpointPrefetcher
from server.sessions.messages import parameter_table, working_message
from server.sessions.model import SessionModel
from server.sessions.tick import QueuedCommand, TickResult, error_message
from server.stream.hub import Client, Hub
from server.stream.protocol import SUBPROTOCOL, ProtocolError, encode_text
from server.work.scheduler import Party, Scheduler, checkpoint

TICK_S = 1.0 / 30.0
MAX_TICK_S = 0.1  #: a tick never makes up for more wall time than this: a slow machine plays slower
MAX_ORDERS = 256  #: commands that wait for one session
PAUSE_S = 0.05  #: between two times that what is owed is computed, and no more than a quarter of the time
PATIENCE_S = 0.2  #: what is owed waits no longer than this for a moment without commands
SHOWN_AFTER_S = 0.3  #: a computation that takes longer shows how far it is,
SHOWN_EVERY_S = 0.25  #: as often as this
GIVE_UP_S = 1.5  #: commands that follow one another for longer than this end no computation: something must be shown
_WISHES = ("parameters", "seek", "restart", "trajectory")  #: commands that make a map of no use that is being made

T = TypeVar("T")

_log = structlog.get_logger(__name__)


class Session(SessionModel):
    """What simulation and log sessions share. Make them with the registry, on the event loop."""

    def __init__(
        self,
        *,
        owner: str,
        title: str,
        grid: OccupancyGrid,
        config: MappingConfig,
        speed: float,
        pool: Executor,
        limits: Callable[[Session | None], Limits],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(config=config, speed=speed)
        self.map_layer.update(grid, config, None, whole=True)
        self.hub = Hub(self.layers, clock)
        self.id = secrets.token_urlsafe(18)
        self.epoch_id = secrets.token_hex(8)
        self.owner = owner
        self.link: str | None = None  #: the link by which its owner came, a guest then
        self.title = title
        self.listeners: list[Callable[[], None]] = []  #: called after each tick that changed something
        self.on_close: list[Callable[[], None]] = []
        self.unwatched_since = self.commanded_at = clock()
        self.remake_seconds: Callable[[float], None] = lambda _: None
        self.scheduler = Scheduler(1)
        self.party = Party(owner)
        self._clock = clock
        self._pool = pool
        self._limits = limits
        self._orders: list[QueuedCommand] = []
        self._wake = asyncio.Event()
        self._lock = asyncio.Lock()
        self._loop = asyncio.get_running_loop()
        self._task: asyncio.Task[None] | None = None
        self._owed_at = 0.0  #: when what is owed is due
        self._wishes = self._wishes_begun = 0  #: commands that ask for another map: those taken in, and carried out
        self._wished_since: float | None = None  #: when the first came of those for which no map was finished yet

    # -- for everybody on the event loop --------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to tick."""
        for message in self.slots():
            self.hub.set_slot(message)
        self._publish_frame()
        self._task = self._loop.create_task(self._run(), name=f"session {self.kind}")

    async def close(self) -> None:
        """End the session: the task, then whatever hangs on it."""
        if self.closed:
            return
        self.closed = True
        self._wake.set()
        if self._task is not None:
            await asyncio.gather(self._task, return_exceptions=True)
        for client in self.hub.clients:
            client.wake.set()
        for callback in (*self.on_close,):
            try:
                callback()
            except Exception:  # noqa: BLE001 - one listener's defect must not keep the others from closing
                _log.exception("a listener failed while its session closed")
        self.listeners.clear()

    def listen(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` on the event loop after each tick that changed something; the session runs meanwhile."""
        self.listeners.append(callback)
        self._wake.set()

    def ignore(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` no longer."""
        if callback in self.listeners:
            self.listeners.remove(callback)
            self._left()

    def join(self) -> Client:
        """Return a new client, which is sent everything."""
        self.hub.slots["hello"] = encode_text(self._hello())
        client = self.hub.join()
        self._wake.set()
        return client

    def leave(self, client: Client) -> None:
        """Forget a client."""
        self.hub.leave(client)
        self._left()

    def _left(self) -> None:
        if not self.watched:
            self.unwatched_since = self._clock()
            self.hub.settled = True  # nothing runs now: what was true stays true

    @property
    def watched(self) -> bool:
        """Whether anybody sees what the session does."""
        return bool(self.hub.clients or self.listeners)

    def enqueue(self, command: dict[str, Any], client: Client | None = None) -> None:
        """Take a command. Raises :class:`ProtocolError` where too many wait already."""
        if len(self._orders) >= MAX_ORDERS:
            raise ProtocolError("session.busy", "Too many commands wait; this one was dropped.")
        self._orders.append(QueuedCommand(command, client))
        self.commanded_at = self._clock()
        if command["type"] in _WISHES:
            self._wishes += 1
            self._wished_since = self.commanded_at if self._wished_since is None else self._wished_since
        self._wake.set()

    @property
    def has_queued_commands(self) -> bool:
        """Whether commands wait to be carried out, or are being."""
        return bool(self._orders)

    @property
    def is_busy(self) -> bool:
        """Whether the session computes, or is about to."""
        return self.has_queued_commands or self._lock.locked()

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return who prepares seeks while nobody waits; None where there is nothing to prepare."""
        return None

    def post(self, command: dict[str, Any]) -> None:
        """Take a command from any thread; one that is refused is only logged."""
        self._loop.call_soon_threadsafe(self._post, command)

    def _post(self, command: dict[str, Any]) -> None:
        try:
            self.enqueue(command)
        except ProtocolError as error:
            _log.info("command refused", code=error.code)

    def still(self) -> AbstractAsyncContextManager[None]:
        """Return a context in which nothing computes in the session, so that its maps can be read (event loop)."""
        return self._lock

    async def snapshot(self) -> OccupancyGrid:
        """Return a copy of the map between two ticks."""
        async with self._lock:
            return await self.on_thread(self._copy)

    def _copy(self) -> OccupancyGrid:
        grid = self.grid
        copy = OccupancyGrid(grid.geometry, grid.log_odds_prior)
        copy.log_odds[:], copy.observed[:] = grid.log_odds, grid.observed
        return copy

    def limits(self) -> Limits:
        """What the session's grid may grow to now."""
        return self._limits(self)

    @property
    def cells(self) -> int:
        """Cells of the grid."""
        return int(self.grid.log_odds.size)

    # -- messages -------------------------------------------------------------------------------------------------

    def _hello(self) -> dict[str, Any]:
        return {
            "type": "hello",
            "protocol": SUBPROTOCOL,
            "session": self.id,
            "kind": self.kind,
            "title": self.title,
            "epoch_id": self.epoch_id,
            "speeds": list(self.speeds),
            "parameters": parameter_table(self.config, self.initial_config()),
            "sensor": None,
            "log": None,
        } | self.particulars()

    def _publish_frame(self) -> None:
        frame, scan = self.frame(), self.scan_fields()
        running = self.playing and self.watched
        self.hub.publish(frame, scan, (frame["pose"][0], frame["pose"][1]), settled=not running)

    # -- the task -------------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        last = self._clock()
        while True:
            ticking = self.playing and self.watched
            if self._pays_now():
                await self._run_deferred_work()
            elif not self._orders:
                await self._wait(self._idle_s(last + TICK_S if ticking else None))
            if self.closed:
                return
            now = self._clock()
            if not ticking:
                last = now - TICK_S  # time in which nothing ran does not count
            due = self.playing and self.watched and now - last >= TICK_S
            orders = [*self._orders]
            if not (orders or due):
                continue
            dt = min(now - last, MAX_TICK_S) if due else 0.0
            last = now if due else last
            rest: list[QueuedCommand] = []
            try:
                async with self._lock:
                    self._wishes_begun = self._wishes
                    outcome = await self.on_thread(partial(self._compute, orders, dt), waited_for=self.watched)
                if self._wishes == self._wishes_begun:
                    self._wished_since = None
                elif self._pending is None:
                    self._wished_since = self._clock()
                rest = outcome.rest
                self._deliver(outcome)
            except Exception:  # noqa: BLE001 - the session stops, and says so, instead of failing 30 times a second
                _log.exception("a tick failed")
                self._stop()
            finally:
                self._orders[: len(orders)] = rest

    def _pays_now(self) -> bool:
        """Whether what is owed is due, and nothing else, or for too long."""
        if not (self.has_deferred_work and self.watched) or self.closed:
            return False
        late = self._clock() - self._owed_at
        return late >= 0.0 and (not self._orders or late > PATIENCE_S)

    def _idle_s(self, tick_at: float | None) -> float | None:
        """Return how long nothing is due, in seconds; None for as long as nobody commands."""
        due = [] if tick_at is None else [tick_at]
        if self.has_deferred_work and self.watched:
            due.append(self._owed_at)
        return min(due) - self._clock() if due else None

    async def _run_deferred_work(self) -> None:
        began = self._clock()
        outcome = TickResult()
        try:
            async with self._lock:
                await self.on_thread(partial(self.run_deferred_work, outcome), waited_for=False)
            self._deliver(outcome)
        except Exception:  # noqa: BLE001 - a defect in what nobody waits for must not stop the map
            _log.exception("what was owed could not be computed")
        now = self._clock()
        self._owed_at = now + max(PAUSE_S, 3.0 * (now - began))

    async def on_thread(self, job: Callable[[], T], *, waited_for: bool = True) -> T:
        """Compute ``job`` on a worker thread in its turn; whoever watches is told of it where that takes long."""
        showing = asyncio.ensure_future(self._show_work())
        try:
            return await self.scheduler.run(self._pool, self.party, job, waited_for=waited_for)
        finally:
            showing.cancel()

    async def _show_work(self) -> None:
        """Tell whoever watches how far a computation is, from :data:`SHOWN_AFTER_S` on until cancelled."""
        began = self._clock()
        await asyncio.sleep(SHOWN_AFTER_S)
        try:
            while True:
                self.hub.set_slot(working_message(self._clock() - began, self.fraction))
                await asyncio.sleep(SHOWN_EVERY_S)
        finally:
            self.hub.set_slot(working_message())

    def goes_on(self) -> bool:
        """Let others have their turn (worker thread), and return whether what is being computed is still wanted."""
        checkpoint()
        return not (self.closed or (self._may_give_up and self._is_outdated()))

    def is_open(self) -> bool:
        """Let others have their turn (worker thread), and return whether the session has not ended: for computations
        that no newer command replaces.
        """
        checkpoint()
        return not self.closed

    def _is_outdated(self) -> bool:
        since = self._wished_since
        return self._wishes > self._wishes_begun and since is not None and self._clock() - since < GIVE_UP_S

    def _stop(self) -> None:
        """Stand still after a defect, and say so."""
        self.playing = False
        self._redraw = True
        self.hub.tell_all(error_message("internal", "The session stopped because of a defect in the service."))
        with contextlib.suppress(Exception):  # the defect may lie in what is shown
            self._publish_frame()

    async def _wait(self, seconds: float | None) -> None:
        """Wait for a command or a client, at most ``seconds``."""
        self._wake.clear()
        if self.closed or self._orders or (seconds is not None and seconds <= 0.0):
            return
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._wake.wait()

    def _deliver(self, outcome: TickResult) -> None:
        """Send what a tick left (event loop)."""
        if self.closed:
            return
        self.hub.set_layers(self.layers)
        for message in outcome.slots.values():
            self.hub.set_slot(message)
        if outcome.remade_ms is not None:
            self.remake_seconds(outcome.remade_ms / 1000.0)
        if outcome.changed:
            self._publish_frame()
        for client, message in outcome.answers:
            if client is not None:
                client.tell(message)
            else:
                _log.info("command refused", code=message.get("code"))
        for client in outcome.reminded:
            if client is not None:
                client.remind("parameters")
        for message in outcome.notices:
            self.hub.tell_all(message)
        if outcome.changed:
            for listener in (*self.listeners,):
                try:
                    listener()
                except Exception:  # noqa: BLE001 - one listener's defect must not stop the session
                    _log.exception("a listener failed")
