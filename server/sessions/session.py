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
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from typing import Any, ClassVar, Literal

import structlog

from mapper.errors import MapperError
from mapper.grid import OccupancyGrid
from mapper.integrate import CellBox
from mapper.limits import Limits
from mapper.parameters import MappingConfig
from mapper.world import SensorConfig, World
from server.sessions.messages import cell_message, moment_fields, parameter_table, parameters_message
from server.sessions.outcome import Order, Outcome, error_message
from server.sessions.view import Moment, SessionView
from server.sessions.why import Source, why_message
from server.stream.hub import Client, Hub
from server.stream.protocol import SUBPROTOCOL, ProtocolError, encode_text, integer, number, values
from server.stream.tiles import TilePicture, picture_range

TICK_S = 1.0 / 30.0
MAX_TICK_S = 0.1  #: a tick never makes up for more wall time than this: a slow machine plays slower
MAX_ORDERS = 256  #: commands that wait for one session
HEAVY_S = 0.05  #: a session whose ticks compute for longer than this takes turns with others of its kind
ORDERS_S = 0.05  #: computing time of a tick after which its further commands wait: other sessions want the threads too

_log = structlog.get_logger(__name__)


class Session(ABC):
    """What world and log sessions share. Make them with the registry, on the event loop."""

    kind: ClassVar[Literal["world", "log"]]

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
        self.id = secrets.token_urlsafe(18)
        self.epoch_id = secrets.token_hex(8)
        self.owner = owner
        self.title = title
        self.config = config
        self.speed = speed
        self.playing = True
        self.listeners: list[Callable[[], None]] = []  #: called after each tick that changed something
        self.on_close: list[Callable[[], None]] = []
        self.closed = False
        self.unwatched_since = clock()
        self.remake_seconds: Callable[[float], None] = lambda _: None
        self.turns: asyncio.Semaphore | None = None  #: of the sessions that compute for long
        self._clock = clock
        self._pool = pool
        self._limits = limits
        self._orders: list[Order] = []
        self._wake = asyncio.Event()
        self._lock = asyncio.Lock()
        self._loop = asyncio.get_running_loop()
        self._task: asyncio.Task[None] | None = None
        self._remade_ms: float | None = None
        self._load = 0.0  #: seconds that a tick computes: rises at once, falls slowly
        self._redraw = False  #: whether a tick was cut off before the picture followed the grid
        picture = TilePicture(grid.geometry, *picture_range(config), epoch=1)
        picture.update(grid, CellBox(0, grid.geometry.rows, 0, grid.geometry.cols))
        self.hub = Hub(picture, clock)

    # -- what each kind of session says of itself -----------------------------------------------------------------

    @property
    @abstractmethod
    def grid(self) -> OccupancyGrid:
        """The map."""

    @abstractmethod
    def moment(self) -> Moment:
        """The newest scan and where it was taken."""

    @property
    @abstractmethod
    def progress(self) -> tuple[int, int]:
        """``(index, count)``: scans in the map, scans that there are."""

    @property
    @abstractmethod
    def speeds(self) -> tuple[float, float]:
        """The least and the greatest speed."""

    @abstractmethod
    def obey(self, command: dict[str, Any], outcome: Outcome) -> None:
        """Carry out a command of this kind of session (worker thread).

        Raises :class:`ProtocolError` or :class:`MapperError` for one that is refused; nothing has changed then.
        """

    @abstractmethod
    def remake(self, config: MappingConfig, outcome: Outcome) -> None:
        """Make the whole map anew with other parameters (worker thread). Raises as :meth:`obey` does."""

    @abstractmethod
    def advance(self, dt: float, outcome: Outcome) -> None:
        """Let ``dt`` seconds pass, 0 to only carry out what commands left to do (worker thread)."""

    @abstractmethod
    def sources(self) -> list[Source]:
        """The scans that the map is made of, in that order (worker thread)."""

    @abstractmethod
    def particulars(self) -> dict[str, Any]:
        """What ``hello`` says beyond the common fields."""

    def play(self) -> None:
        """Go on."""
        self.playing = True

    def slots(self) -> list[dict[str, Any]]:
        """Further messages that each new client gets: the newest of each type."""
        return [self.parameters_message()]

    @property
    def world(self) -> World | None:
        """The true world, where there is one."""
        return None

    @property
    def sensor(self) -> SensorConfig | None:
        """The simulated sensor, where there is one."""
        return None

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
        self._orders.append(Order(command, client))
        self._wake.set()

    @property
    def has_orders(self) -> bool:
        """Whether commands wait to be carried out, or are being."""
        return bool(self._orders)

    def post(self, command: dict[str, Any]) -> None:
        """Take a command from any thread; one that is refused is only logged."""
        self._loop.call_soon_threadsafe(self._post, command)

    def _post(self, command: dict[str, Any]) -> None:
        try:
            self.enqueue(command)
        except ProtocolError as error:
            _log.info("command refused", code=error.code)

    def view(self) -> SessionView:
        """Return what the session shows now."""
        grid, moment = self.grid, self.moment()
        index, count = self.progress
        return SessionView(
            geometry=grid.geometry,
            log_odds=grid.log_odds,
            observed=grid.observed,
            pose=moment.pose,
            sensor_pose=moment.scan_pose,
            ranges=moment.scan.ranges,
            angle_min=moment.scan.angle_min,
            angle_increment=moment.scan.angle_increment,
            range_max=min(moment.scan.range_max, self.config.range_max),
            world=self.world,
            config=self.config,
            sensor=self.sensor,
            playing=self.playing,
            index=index,
            count=count,
        )

    async def snapshot(self) -> OccupancyGrid:
        """Return a copy of the map between two ticks."""
        async with self._lock:
            return await self._loop.run_in_executor(self._pool, self._copy)

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
            "parameters": parameter_table(self.config),
            "sensor": None,
            "log": None,
        } | self.particulars()

    def parameters_message(self) -> dict[str, Any]:
        """The ``parameters`` message."""
        return parameters_message(self.config, self.sensor)

    def frame(self) -> dict[str, Any]:
        """The ``frame`` message, without its type and time."""
        index, count = self.progress
        frame = {"playing": self.playing, "speed": self.speed, "index": index, "count": count, "auto": False}
        if self._remade_ms is not None:
            frame["remade_ms"] = round(self._remade_ms, 2)
        return frame | moment_fields(self.moment(), self.config)

    def _publish_frame(self) -> None:
        frame = self.frame()
        running = self.playing and self.watched
        self.hub.publish(frame, (frame["pose"][0], frame["pose"][1]), settled=not running)

    # -- the task -------------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        last = self._clock()
        while True:
            ticking = self.playing and self.watched
            if not self._orders:
                await self._wait(last + TICK_S - self._clock() if ticking else None)
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
            rest: list[Order] = []
            try:
                async with self._turn(), self._lock:
                    outcome = await self._loop.run_in_executor(self._pool, self._compute, orders, dt)
                rest = outcome.rest
                self._deliver(outcome)
            except Exception:  # noqa: BLE001 - the session stops, and says so, instead of failing 30 times a second
                _log.exception("a tick failed")
                self._stop()
            finally:
                self._orders[: len(orders)] = rest

    def _turn(self) -> AbstractAsyncContextManager[None]:
        """Return what to hold while a tick computes: sessions of short ticks need not wait for those of long ones."""
        return contextlib.nullcontext() if self.turns is None or self._load <= HEAVY_S else self.turns

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

    def _deliver(self, outcome: Outcome) -> None:
        """Send what a tick left (event loop)."""
        if self.closed:
            return
        if outcome.picture is not None:
            self.hub.set_picture(outcome.picture)
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

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def _compute(self, orders: list[Order], dt: float) -> Outcome:
        outcome = Outcome()
        config, asked_by = self.config, None
        started = time.perf_counter()
        outcome.rest = [*orders]
        while outcome.rest and not self.closed:
            order = outcome.rest.pop(0)
            try:
                if order.command["type"] == "parameters":
                    config, asked_by = config.with_values(values(order.command)), order.client
                else:
                    self._obey(order, outcome)
            except (ProtocolError, MapperError) as error:
                self._refuse(outcome, order.client, error)
                if order.command["type"] in ("parameters", "sensor"):
                    outcome.reminded.append(order.client)
            except Exception:  # noqa: BLE001 - a defect in one command must not end the session
                _log.exception("a command failed", command=order.command["type"])
                message = error_message("internal", "The command failed because of a defect in the service.")
                outcome.answers.append((order.client, message))
            if outcome.unfinished is not None:
                outcome.rest.insert(0, replace(order, command=outcome.unfinished))
                break
            if time.perf_counter() - started > ORDERS_S:
                break
        if self.closed:
            return outcome
        try:
            # Of many changes that came meanwhile only the newest is computed.
            if config != self.config:
                self._remake(config, outcome)
        except MapperError as error:
            self._refuse(outcome, asked_by, error)
            outcome.reminded.append(asked_by)
        try:
            self.advance(dt if self.playing else 0.0, outcome)
        except MapperError as error:
            self.playing = False
            outcome.changed = True
            outcome.notices.append(error_message(error.code, error.message))
        self._draw(outcome)
        for client, question in outcome.questions.items():
            self._explain(client, question, outcome)
        self._load = max(time.perf_counter() - started, 0.5 * self._load)
        return outcome

    def _refuse(self, outcome: Outcome, client: Client | None, error: ProtocolError | MapperError) -> None:
        outcome.answers.append((client, error_message(error.code, error.message)))

    def _remake(self, config: MappingConfig, outcome: Outcome) -> None:
        started = time.perf_counter()
        self.remake(config, outcome)
        self.config = config
        self._remade_ms = outcome.remade_ms = (time.perf_counter() - started) * 1000.0
        outcome.changed = True
        outcome.slot(self.parameters_message())

    def _draw(self, outcome: Outcome) -> None:
        """Bring the picture up to date with what changed in the grid."""
        grid = self.grid
        whole = CellBox(0, grid.geometry.rows, 0, grid.geometry.cols)
        old = self.hub.picture
        low, high = picture_range(self.config)
        if not old.shows(grid.geometry, low, high):
            outcome.picture = TilePicture(grid.geometry, low, high, old.epoch + 1, old.newest)
            outcome.picture.update(grid, whole)
            outcome.changed = True
        elif outcome.new_grid or self._redraw:
            old.update(grid, whole)
        elif outcome.box is not None:
            old.update(grid, outcome.box)
        self._redraw = False

    def _obey(self, order: Order, outcome: Outcome) -> None:
        command = order.command
        match command["type"]:
            case "play":
                self.play()
            case "pause":
                self.playing = False
            case "speed":
                value = number(command, "value")
                low, high = self.speeds
                if not low <= value <= high:
                    raise ProtocolError("command.value", f"The speed must be between {low:g} and {high:g}.")
                self.speed = value
            case "inspect":
                row, col, epoch = self._cell_of(command)
                outcome.answers.append((order.client, cell_message(self.grid, row, col, epoch)))
                return
            case "why":
                outcome.questions[order.client] = command  # answered once, from the map that this tick leaves
                return
            case _:
                self.obey(command, outcome)
        outcome.changed = True

    def _cell_of(self, command: dict[str, Any], picture: TilePicture | None = None) -> tuple[int, int, int]:
        """Return the row, column and epoch that a command names, of a cell of the map."""
        row, col, epoch = (integer(command, key) for key in ("row", "col", "epoch"))
        now = (picture or self.hub.picture).epoch
        if epoch != now:
            raise ProtocolError("command.epoch", f"Epoch {epoch} is over; the map is in epoch {now}.")
        if not self.grid.geometry.contains((row, col)):
            raise ProtocolError("command.cell", f"Cell ({row}, {col}) lies outside the map.")
        return row, col, epoch

    def _explain(self, client: Client | None, command: dict[str, Any], outcome: Outcome) -> None:
        """Answer a "why" from the map as this tick leaves it."""
        try:
            row, col, epoch = self._cell_of(command, outcome.picture)
            until = None if command.get("until") is None else integer(command, "until")
            about = {"row": row, "col": col, "epoch": epoch, "index": self.progress[0]}
            answer = why_message(self.grid, self.sources(), self.config, about, until)
            outcome.answers.append((client, answer))
        except (ProtocolError, MapperError) as error:
            self._refuse(outcome, client, error)
        except Exception:  # noqa: BLE001 - a defect in one answer must not end the session
            _log.exception("a command failed", command="why")
            outcome.answers.append((client, error_message("internal", "The cell could not be explained.")))
