"""What a session computes: its map and its parameters, the commands that change them, the ticks that let time pass.

Everything here runs on a worker thread or is only read by the event loop between two ticks; it knows no browser's
socket and no asyncio. :class:`server.sessions.session.Session` puts it on the event loop.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from typing import Any, ClassVar, Literal

import structlog

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import SensorConfig, World
from server.sessions.messages import cell_message, frame_fields, parameters_message, scan_fields
from server.sessions.tick import QueuedCommand, TickResult, error_message
from server.sessions.view import RobotState, SessionView, Side
from server.sessions.why import Source, why_message
from server.stream.hub import Client
from server.stream.layers import GridLayer, Layer
from server.stream.protocol import ProtocolError, integer, number, text, values

ORDERS_S = 0.05  #: computing time of a tick after which its further commands wait: other sessions want the threads too

_log = structlog.get_logger(__name__)


class SessionModel(ABC):
    """What simulation and log sessions compute."""

    kind: ClassVar[Literal["simulation", "log"]]

    def __init__(self, *, config: MappingConfig, speed: float) -> None:
        self.config = config
        self.speed = speed
        self.map_layer = GridLayer("map", "Map")
        self.playing = True
        self.closed = False
        self._remade_ms: float | None = None
        self._pending: MappingConfig | None = None  #: parameters whose map was given up for a newer command
        self._may_give_up = False  #: whether what is being computed can be given up and begun anew
        self._told: tuple[tuple[Any, ...], dict[str, Any]] | None = None  #: the scan told last, and in which words
        self._redraw = False  #: whether a tick was cut off before the picture followed the grid

    # -- what each kind of session says of itself -----------------------------------------------------------------

    @property
    @abstractmethod
    def grid(self) -> OccupancyGrid:
        """The map."""

    @abstractmethod
    def robot_state(self) -> RobotState:
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
    def obey(self, command: dict[str, Any], outcome: TickResult) -> None:
        """Carry out a command of this kind of session (worker thread).

        Raises :class:`ProtocolError` or :class:`MapperError` for one that is refused; nothing has changed then.
        """

    @abstractmethod
    def remake(self, config: MappingConfig, outcome: TickResult) -> None:
        """Make the whole map anew with other parameters (worker thread). Raises as :meth:`obey` does."""

    @abstractmethod
    def advance(self, dt: float, outcome: TickResult) -> None:
        """Let ``dt`` seconds pass, 0 to only carry out what commands left to do (worker thread)."""

    @abstractmethod
    def sources(self) -> list[Source]:
        """The scans that the map is made of, in that order (worker thread)."""

    @abstractmethod
    def initial_config(self) -> MappingConfig:
        """The parameters that such a session begins with where nobody says others."""

    @abstractmethod
    def particulars(self) -> dict[str, Any]:
        """What ``hello`` says beyond the common fields."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """What the session shows: the map first."""
        return (self.map_layer,)

    def draw_second(self, outcome: TickResult) -> None:  # noqa: B027 - most sessions have no second map
        """Bring the second map's layer up to date (worker thread)."""

    def side(self, layer: str) -> Side:
        """Return the map that a layer shows. Raises :class:`ProtocolError` for a layer that shows none."""
        if layer != self.map_layer.name:
            raise ProtocolError("command.layer", f"There is no map {layer!r:.80} to ask about.")
        return Side(self.grid, self.config, self.sources, self.progress[0], self.map_layer)

    @property
    def fraction(self) -> float | None:
        """How much of the map that is being computed is done, 0 to 1; None where that is not known."""
        return None

    @property
    def has_deferred_work(self) -> bool:
        """Whether something is left to compute that no picture waits for: :meth:`run_deferred_work` does, when there is
        time.
        """
        return False

    def run_deferred_work(self, outcome: TickResult) -> None:
        """Compute what is owed (worker thread)."""
        raise RuntimeError(f"a {self.kind} session owes nothing, not even {outcome}")

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

    def view(self) -> SessionView:
        """Return what the session shows now."""
        grid, robot_state = self.grid, self.robot_state()
        index, count = self.progress
        return SessionView(
            geometry=grid.geometry,
            log_odds=grid.log_odds,
            observed=grid.observed,
            pose=robot_state.pose,
            sensor_pose=robot_state.scan_pose,
            ranges=robot_state.scan.ranges,
            angles=robot_state.scan.angles,
            range_max=min(robot_state.scan.range_max, self.config.range_max),
            world=self.world,
            config=self.config,
            sensor=self.sensor,
            playing=self.playing,
            index=index,
            count=count,
        )

    def parameters_message(self) -> dict[str, Any]:
        """The ``parameters`` message."""
        return parameters_message(self.config, self.sensor)

    def frame(self) -> dict[str, Any]:
        """The ``frame`` message, without its type, its time and its scan."""
        index, count = self.progress
        frame = {"playing": self.playing, "speed": self.speed, "index": index, "count": count, "auto": False}
        if self._remade_ms is not None:
            frame["remade_ms"] = round(self._remade_ms, 2)
        return frame | frame_fields(self.robot_state())

    def scan_fields(self) -> dict[str, Any]:
        """The part of the ``frame`` message that tells of the newest scan: the same object while that is the same."""
        robot_state = self.robot_state()
        key = (robot_state.scan, robot_state.scan_pose, robot_state.believed_scan_pose, self.config.range_max)
        told = self._told
        if told is None or told[0][0] is not robot_state.scan or told[0][1:] != key[1:]:
            told = self._told = (key, scan_fields(robot_state, self.config))
        return told[1]

    # -- on a worker thread ---------------------------------------------------------------------------------------

    def _compute(self, orders: list[QueuedCommand], dt: float) -> TickResult:
        outcome = TickResult()
        config, asked_by = self._pending or self.config, None
        started = time.perf_counter()
        outcome.rest = [*orders]
        while outcome.rest and not self.closed:
            order = outcome.rest.pop(0)
            try:
                if order.command["type"] == "parameters":
                    config, asked_by = config.with_values(values(order.command)), order.client
                else:
                    before = self.config
                    self._obey(order, outcome)
                    # A sensor of another kind brings the model that suits it.
                    config = config.with_values(_changed(before, self.config))
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
            self._pending = config
            if config != self.config:
                self._remake(config, outcome)
            self._pending = None
        except WorkCancelledError:
            pass  # the newer command comes with the next tick, and these parameters with it
        except MapperError as error:
            self._pending = None
            self._refuse(outcome, asked_by, error)
            outcome.reminded.append(asked_by)
        try:
            self.advance(dt if self.playing else 0.0, outcome)
        except WorkCancelledError:
            outcome.new_grid = True  # it stands somewhere on the way
        except MapperError as error:
            self.playing = False
            outcome.changed = True
            outcome.notices.append(error_message(error.code, error.message))
        self._draw(outcome)
        for client, question in outcome.questions.items():
            self._explain(client, question, outcome)
        return outcome

    @contextmanager
    def giving_up(self) -> Iterator[None]:
        """In the block a newer command may end a computation with :class:`WorkCancelledError`; nothing is lost by
        it.
        """
        self._may_give_up = True
        try:
            yield
        finally:
            self._may_give_up = False

    def _refuse(self, outcome: TickResult, client: Client | None, error: ProtocolError | MapperError) -> None:
        outcome.answers.append((client, error_message(error.code, error.message)))

    def _remake(self, config: MappingConfig, outcome: TickResult) -> None:
        started = time.perf_counter()
        with self.giving_up():
            self.remake(config, outcome)
        self.config = config
        self._remade_ms = outcome.remade_ms = (time.perf_counter() - started) * 1000.0
        outcome.changed = True
        outcome.slot(self.parameters_message())

    def _draw(self, outcome: TickResult) -> None:
        """Bring the layers up to date with what changed in the maps."""
        whole = outcome.new_grid or self._redraw
        outcome.changed |= self.map_layer.update(self.grid, self.config, outcome.box, whole=whole)
        self._redraw = False
        self.draw_second(outcome)

    def _obey(self, order: QueuedCommand, outcome: TickResult) -> None:
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
                side = self._side_of(command)
                row, col, epoch = self._cell_of(command, side)
                answer = cell_message(side.grid, row, col, epoch) | {"layer": side.layer.name}
                outcome.answers.append((order.client, answer))
                return
            case "why":
                outcome.questions[order.client] = command  # answered once, from the map that this tick leaves
                return
            case _:
                self.obey(command, outcome)
        outcome.changed = True

    def _side_of(self, command: dict[str, Any]) -> Side:
        """Return the map that a command is about."""
        return self.side(text(command, "layer") if "layer" in command else self.map_layer.name)

    def _cell_of(self, command: dict[str, Any], side: Side) -> tuple[int, int, int]:
        """Return the row, column and epoch that a command names, of a cell of a map."""
        row, col, epoch = (integer(command, key) for key in ("row", "col", "epoch"))
        now = side.layer.epoch
        if epoch != now:
            raise ProtocolError("command.epoch", f"Epoch {epoch} is over; the map is in epoch {now}.")
        if not side.grid.geometry.contains((row, col)):
            raise ProtocolError("command.cell", f"Cell ({row}, {col}) lies outside the map.")
        return row, col, epoch

    def _explain(self, client: Client | None, command: dict[str, Any], outcome: TickResult) -> None:
        """Answer a "why" from the map as this tick leaves it."""
        try:
            side = self._side_of(command)
            row, col, epoch = self._cell_of(command, side)
            until = None if command.get("until") is None else integer(command, "until")
            about = {"row": row, "col": col, "epoch": epoch, "index": side.index}
            answer = why_message(side.grid, side.sources(), side.config, about, until)
            outcome.answers.append((client, answer | {"layer": side.layer.name}))
        except (ProtocolError, MapperError) as error:
            self._refuse(outcome, client, error)
        except Exception:  # noqa: BLE001 - a defect in one answer must not end the session
            _log.exception("a command failed", command="why")
            outcome.answers.append((client, error_message("internal", "The cell could not be explained.")))


def _changed(before: MappingConfig, after: MappingConfig) -> dict[str, Any]:
    """Return the values of ``after`` that are not those of ``before``."""
    return {name: value for name, value in asdict(after).items() if value != getattr(before, name)}
