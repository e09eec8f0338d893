"""The model of a simulation: a robot explores a simulated world and maps it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from typing import ClassVar

import msgspec
import numpy as np
from msgspec import Struct

from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.se2 import compose, compose_one
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import LOG_ONLY, PARAMETERS, MappingConfig
from mapper.simulation import SENSOR_PARAMETERS, WORLDS, Edits, SensorConfig, World
from mapper.simulation.edits import solid_ids
from mapper.simulation.faults import polished_faces
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.plan_map import plan_map
from mapper.simulation.second_map import Vanishing
from server.parts import parts_of
from server.parts.mapping.part import MappingParameters
from server.sessions.drawings import COLUMN_M, Drawing, Walls
from server.sessions.hosting import ModelHost
from server.sessions.model import Footprint, ScanReport, SessionModel, set_robot
from server.sessions.part import ExplainedMap, MappedScans, Offers, Plan, Robot, StaticMap
from server.sessions.scene_controls import Choice, ParameterTable, SceneControls
from server.sessions.tick import TickResult
from server.sessions.view import RobotState
from server.sources.history import Action, History
from server.sources.map_drawings import map_drawings, sight_of
from server.sources.simulation_replay import SimulationReplay, act
from server.stream.commands import (
    AutoCommand,
    CancelCommand,
    CompareCommand,
    DriveCommand,
    EditCommand,
    FaultsCommand,
    ParametersCommand,
    RestartCommand,
    SeekCommand,
    SensorCommand,
    StepCommand,
    TeleportCommand,
    WorldCommand,
)
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import Block, Compared, Table, rows_of
from server.stream.message_parts import Edits as EditsMessage
from server.stream.messages import Forgetting, FrameMessage, Hello, ParametersMessage, ScanFields, WorldMessage
from server.stream.protocol import ProtocolError, type_of

MAX_STEP_SCANS = 100
SCANS_AT_ONCE = 10  #: scans of a ``step`` command in one tick
_ROWS = tuple(row for row in PARAMETERS if row.name not in LOG_ONLY)


class SimulationModel(SessionModel):
    """A simulated world, its robot, and the map of its scans."""

    kind: ClassVar[str] = "simulation"
    replacing: ClassVar[tuple[type[Struct], ...]] = (ParametersCommand, RestartCommand)
    resent_on_refusal: ClassVar[Mapping[type[Struct], str]] = {
        ParametersCommand: "parameters",
        SensorCommand: "parameters",
    }

    def __init__(self, host: ModelHost, mapper: LiveMap, max_story_s: float = math.inf) -> None:
        """Create the model. ``max_story_s`` is the longest computing time for replaying its history, seconds."""
        super().__init__()
        self._host = host
        self._mapper = mapper
        mapper.limits, mapper.may_continue = host.limits, host.may_continue
        self.parameters = MappingParameters(host, mapper.config, self._remake, self._parameters_message, _ROWS)
        offers = Offers(
            host,
            grid=lambda: mapper.grid,
            map_title="the belief as it changes",
            robot=self._robot,
            drive=lambda linear, angular, result: act(mapper, DriveCommand(linear, angular), result),
            plans={"plan": Plan("the plan of the world as it was when chosen", self._plan)},
            explained=self._explained,
            simulation=mapper,
            playback=self.playback,
        )
        replay = SimulationReplay(host, mapper, self.playback, max_story_s, self.history)
        self.parts = (self.parameters, replay, *parts_of(offers))
        self._report = ScanReport()
        self._map = GridLayer("map", "Map")
        self._map.update(mapper.grid, mapper.config, None, whole=True)
        self._second: GridLayer | None = None
        self._forgetting: tuple[Vanishing | None, int] = (None, 0)  #: the last `forgetting` message

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The map, the second map if any, and the layers of the parts."""
        second = () if self._second is None else (self._second,)
        return (self._map, *second, *(layer for part in self.parts_on for layer in part.layers))

    @property
    def title(self) -> str:
        """The title of the world."""
        return self.world.title

    @property
    def file_stem(self) -> str:
        """The name of the world."""
        return self.world.name

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        return self._mapper.grid

    @property
    def config(self) -> MappingConfig:
        """The mapping parameters."""
        return self.parameters.config

    @property
    def footprint(self) -> Footprint:
        """Number of cells of the map and of the parts."""
        return Footprint(cells=int(self.grid.log_odds.size) + sum(part.cells for part in self.parts_on))

    @property
    def world(self) -> World:
        """The true world."""
        return self._mapper.simulation.world

    @property
    def sensor(self) -> SensorConfig:
        """The simulated sensor."""
        return self._mapper.simulation.sensor

    @property
    def fraction(self) -> float | None:
        """Completed share of the recomputation of the map, or of a part's computation."""
        shares = (self._mapper.fraction, *(part.progress for part in self.parts_on))
        return next((share for share in shares if share is not None), None)

    @property
    def is_catching_up(self) -> bool:
        """Whether a part still carries out earlier commands."""
        return any(part.is_behind for part in self.parts_on)

    @property
    def progress(self) -> tuple[int, int]:
        """Number of scans in the map, and of recorded scans. ``step`` back removes scans from the map."""
        return (self._mapper.scans - self._mapper.hidden, self._mapper.scans)

    def robot_state(self) -> RobotState:
        """Return the robot's current pose and its newest scan."""
        mapper, simulation = self._mapper, self._mapper.simulation
        scan = mapper.newest
        if scan is None:
            raise RuntimeError("a simulation has taken a scan before its session starts")
        pose, mount = simulation.pose, simulation.mount
        seen_from = compose_one(mapper.newest_pose, mount)
        robot_state = RobotState(pose, compose_one(pose, mount), seen_from, scan, simulation.time)
        if mapper.hidden:
            robot_state = RobotState(mapper.newest_pose, seen_from, seen_from, scan, scan.stamp_ns * 1e-9)
        if mapper.believed_pose == mapper.newest_pose:
            return robot_state
        now, scan_pose = mapper.believed_now, compose_one(mapper.believed_pose, mount)
        return replace(robot_state, believed_pose=now, believed_scan_pose=scan_pose)

    def _robot(self) -> Robot:
        """Return the robot at its own estimate of its pose."""
        mapper, simulation = self._mapper, self._mapper.simulation
        scan = None if mapper.hidden else mapper.newest
        scan_pose = compose(mapper.believed_pose, simulation.mount)
        return Robot(mapper.believed_now, simulation.time, scan, scan_pose, mapper.n_newest)

    def _plan(self) -> StaticMap:
        return StaticMap(plan_map(self.world))

    def sources(self) -> list[MappedScans]:
        """Return the recordings, one for each kind of sensor."""
        trajectory = self._mapper.faults.trajectory
        logs, hidden = self._mapper.logs(), self._mapper.hidden
        return [
            MappedScans(
                log,
                trajectory,
                log.n_scans - (hidden if log is logs[-1] else 0),
                np.asarray(log.stamps_ns * 1e-9, dtype=np.float64),
            )
            for log in logs
        ]

    def _explained(self) -> list[ExplainedMap]:
        return [ExplainedMap(self._map, self.grid, self.config, self.sources, self.progress[0])]

    def drawings(self) -> list[Drawing]:
        """Return the map (unless a part replaces it), the robot, the drawings of the parts, and the true world."""
        world = self.world
        flat = map_drawings(self.grid, self.robot_state(), self.config)
        for part in self.parts_on:
            flat = part.over(flat)
        return [
            *flat,
            *(drawing for part in self.parts_on for drawing in part.drawings()),
            Walls(name="world", label="True world", solids=world.solids, bounds=world.bounds),
        ]

    def controls(self) -> SceneControls:
        """Return the parameters of the map and the sensor, and the worlds."""
        sensor = ParameterTable("Sensor", SENSOR_PARAMETERS, asdict(self.sensor), SensorCommand, ("sensor",))
        return SceneControls(
            playing=self.playback.playing,
            hint=next((part.hint for part in self.parts_on if part.hint), "Click the floor to place the robot there."),
            tables=(self.parameters.controls(), sensor),
            choices=(Choice("World", tuple(WORLDS), self.world.name, WorldCommand),),
            can_restart=True,
            bounds=self.world.bounds,
            heights=(0.0, COLUMN_M),
            sight=sight_of(self.robot_state()),
        )

    def on_scene_click(self, x: float, y: float) -> Struct:
        """Return the command that places the robot at (x, y)."""
        return TeleportCommand(x, y)

    # -- messages -------------------------------------------------------------------------------------------------

    def complete(self, hello: Hello) -> None:
        """Set the parameters, the sensor and the world. The initial parameters are those for a lidar."""
        hello.parameters = self.parameters.table(self._mapper.first_config(SensorConfig()))
        hello.sensor = Table(rows_of(SENSOR_PARAMETERS), asdict(self.sensor))
        hello.world, hello.seed = self.world.name, self._mapper.seed

    def messages(self) -> list[Struct]:
        """Return the parameters, the world, and the messages of the parts."""
        return [self._parameters_message(), world_message(self._mapper), *super().messages()]

    def _parameters_message(self) -> ParametersMessage:
        """Return the parameters, the robot's faults and the parameters that differ in the second map."""
        second = self._mapper.second
        return ParametersMessage(
            values=asdict(self.config),
            sensor=asdict(self.sensor),
            faults=asdict(self._mapper.faults),
            compare=None if second is None else Compared(second.values, second.with_faults),
        )

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the robot's pose, and whether it explores by itself."""
        self.parameters.complete_frame(frame)
        set_robot(frame, self.robot_state())
        frame.auto = self._mapper.simulation.auto

    def scan(self) -> ScanFields:
        """Return the newest scan."""
        return self._report.scan(self.robot_state(), self.config)

    # -- computing ------------------------------------------------------------------------------------------------

    def resume(self, history: History) -> None:
        """Restore playing, speed and costmap from a history. Raises :class:`ConfigError` and :class:`ProtocolError`."""
        low, high = self.playback.speeds
        speed = history.speed or self.playback.speed
        if not low <= speed <= high:
            raise ConfigError("story.speed", f"The speed must be between {low:g} and {high:g}.")
        self.playback.speed, self.playback.playing = speed, history.playing
        kinds = tuple(command for part in self.parts for command in part.recorded)
        for command in history.navigation:
            if not isinstance(command, kinds):
                raise ProtocolError("story.navigation", f"A story cannot hold the command {type_of(command)!r:.80}.")
            self.handle(command, TickResult())

    def _remake(self, config: MappingConfig, result: TickResult) -> None:
        self._mapper.remake(config)
        result.new_grid = True

    def settle(self, result: TickResult) -> None:
        """Recompute the map with other parameters."""
        self.parameters.settle(result)

    def advance(self, dt: float, result: TickResult) -> None:
        """Advance the simulation, and map its scans."""
        if dt > 0.0:
            result.changed = True
            left = dt * self.playback.speed
            while left > 0.0:
                step = min((part.advance(left, result) for part in self.parts_on), default=left)
                left -= step
                for change in self._mapper.advance(step):
                    result.add(change)

    def draw(self, result: TickResult) -> None:
        """Update the layers, and report how both maps forget what was erased from the world."""
        result.changed |= self._map.update(
            self.grid, self.config, result.box, whole=result.new_grid, cells=result.cells
        )
        super().draw(result)
        second, vanishing = self._mapper.second, self._mapper.vanishing
        forgetting = (vanishing, 0 if vanishing is None else len(vanishing.first.free))
        if forgetting != self._forgetting:
            self._forgetting = forgetting
            result.slot(forgetting_message(vanishing))
        if second is None:
            self._second = None
            return
        self._second = self._second or GridLayer("second_map", "Second map")
        whole, box = second.changed()
        result.changed |= self._second.update(second.grid, second.config, box, whole=whole)

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command."""
        match command:
            case TeleportCommand() | DriveCommand() | AutoCommand() | SensorCommand() | EditCommand():
                self._act(command, result)
            case StepCommand(scans=scans):
                self._step(scans, result)
            case FaultsCommand(values=values):
                with self._cancellable():
                    self._mapper.set_up(self._mapper.config, self._mapper.faults.with_values(values))
                    result.new_grid = True
                result.slot(self._parameters_message())
            case CompareCommand(values=wanted):
                with self._cancellable():
                    self._mapper.compare(wanted)
                result.slot(self._parameters_message())
            case CancelCommand():
                self.parameters.cancel(result)
            case WorldCommand(name=name, added=added, erased=erased):
                if name not in WORLDS:
                    raise ProtocolError("command.name", f"There is no world {name!r:.80}.")
                self._begin(world_named(name), Edits.of(added, erased), result)
            case RestartCommand():
                self._begin(self._mapper.plan, self._mapper.edits, result)
                self.playback.playing = True
            case SeekCommand():
                raise ProtocolError("world.seek", "A simulation cannot seek; use restart.")
            case _:
                super().handle(command, result)
                return
        for part in self.parts:
            part.note(command, result)
        result.changed = True

    @contextmanager
    def _cancellable(self) -> Iterator[None]:
        """Return a context for work that has no effect if a client cancels it."""
        with suppress(WorkCancelledError), self._host.cancellable(by_newer=False):
            yield

    def _act(self, command: Action, result: TickResult) -> None:
        mapper, second = self._mapper, self._mapper.second
        if isinstance(command, EditCommand | SensorCommand):
            with self._cancellable():
                act(mapper, command, result)
        else:
            act(mapper, command, result)
        result.changed = True
        self.parameters.adopt(mapper.config)  # another kind of sensor sets its default model
        if isinstance(command, DriveCommand):
            self.playback.playing = True
        if isinstance(command, EditCommand):
            result.slot(world_message(self._mapper))
        if isinstance(command, SensorCommand) or mapper.second is not second:
            result.slot(self._parameters_message())

    def _step(self, scans: int, result: TickResult) -> None:
        if not 1 <= abs(scans) <= MAX_STEP_SCANS:
            raise ProtocolError("command.scans", f"A simulation steps forward or back by 1 to {MAX_STEP_SCANS} scans.")
        self.playback.playing = False
        if scans < 0:
            with self._cancellable():
                result.new_grid |= self._mapper.step_back(-scans)
            return
        now = min(scans, SCANS_AT_ONCE)
        for change in self._mapper.step(now):
            result.add(change)
        if scans > now:
            result.unfinished = StepCommand(scans - now)

    def _begin(self, world: World, edits: Edits, result: TickResult) -> None:
        self._mapper.begin(world, self.sensor, edits)
        result.new_grid = True
        result.slot(world_message(self._mapper))


def world_message(mapper: LiveMap) -> WorldMessage:
    """Return the ``world`` message: the solids of the true world, and the edits of its floor plan; metres."""
    world = mapper.simulation.world
    added, erased = mapper.edits.as_lists()
    return WorldMessage(
        name=world.name,
        title=world.title,
        names=list(WORLDS),
        bounds=world.bounds,
        polygons=[np.round(solid, 4).tolist() for solid in world.solids],
        ids=solid_ids(mapper.plan, mapper.edits),
        edits=msgspec.convert({"added": added, "erased": erased}, EditsMessage),
        polished=np.round(polished_faces(world), 4).tolist(),
        blocks=[
            Block(np.round(block.outline, 4).tolist(), block.bottom, float(block.heights.max()))
            for block in world.blocks
        ],
    )


def forgetting_message(vanishing: Vanishing | None) -> Forgetting:
    """Return the ``forgetting`` message; without cells if nothing is watched."""
    if vanishing is None:
        return Forgetting(0, 0, None, None, 0.0, 0.0)
    pair = (vanishing.first, vanishing.second)
    clamped, unclamped = pair if vanishing.clamped_first else pair[::-1]
    return Forgetting(
        cells=len(vanishing.first.places),
        scans=len(vanishing.first.free),
        with_clamp=clamped.after,
        without_clamp=unclamped.after,
        free_with_clamp=round(clamped.free[-1], 4) if clamped.free else 0.0,
        free_without_clamp=round(unclamped.free[-1], 4) if unclamped.free else 0.0,
    )
