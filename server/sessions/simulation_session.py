"""A live world: a simulated robot walks, and its map fills in."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import Any, ClassVar, Literal

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.limits import Limits
from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import SENSOR_PARAMETERS, WORLDS, SensorConfig, World
from mapper.simulation.edits import solid_ids
from mapper.simulation.faults import polished_faces
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.second_map import Vanishing, forgetting_message
from server.sessions.session import Session
from server.sessions.simulation_commands import ACTIONS, act, edits_of, story_of
from server.sessions.tick import TickResult
from server.sessions.view import RobotState, as_pose
from server.sessions.why import Source
from server.stream.layers import GridLayer, Layer
from server.stream.protocol import ProtocolError, integer, text, values

DEFAULT_WORLD = "office"
MAX_STEP_SCANS = 100
SCANS_AT_ONCE = 10  #: of a step in one tick


class SimulationSession(Session):
    """A session of a simulation."""

    kind: ClassVar[Literal["simulation", "log"]] = "simulation"

    def __init__(
        self,
        mapper: LiveMap,
        *,
        owner: str,
        pool: Executor,
        limits: Callable[[Session | None], Limits],
    ) -> None:
        self._mapper = mapper
        mapper.limits = lambda: limits(self)
        mapper.wanted = self.goes_on
        self._second_layer: GridLayer | None = None
        self.max_story_s = math.inf  #: computing that a story of this world may take
        super().__init__(
            owner=owner,
            title=mapper.simulation.world.title,
            grid=mapper.grid,
            config=mapper.config,
            speed=1.0,
            pool=pool,
            limits=limits,
        )
        self._forgetting: tuple[Vanishing | None, int] = (None, 0)  #: what was told of it last

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The map, and the second one where there is one."""
        return (self.map_layer,) if self._second_layer is None else (self.map_layer, self._second_layer)

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        return self._mapper.grid

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
        """How much of the map is done that is being made anew."""
        return self._mapper.fraction

    @property
    def speeds(self) -> tuple[float, float]:
        """Seconds of the world's time in a second."""
        return (0.25, 8.0)

    @property
    def progress(self) -> tuple[int, int]:
        """Of the scans that were taken those that were not taken out again are in the map."""
        return (self._mapper.scans - self._mapper.hidden, self._mapper.scans)

    def robot_state(self) -> RobotState:
        """Where the robot is now, and its newest scan."""
        mapper, simulation = self._mapper, self._mapper.simulation
        scan = mapper.newest
        if scan is None:
            raise RuntimeError("a simulation has taken a scan before it starts")
        seen_from = as_pose(compose(mapper.newest_pose, simulation.mount))
        robot_state = RobotState(simulation.pose, as_pose(simulation.sensor_pose), seen_from, scan, simulation.time)
        if mapper.hidden:
            robot_state = RobotState(mapper.newest_pose, seen_from, seen_from, scan, scan.stamp_ns * 1e-9)
        if mapper.believed_pose == mapper.newest_pose:
            return robot_state
        believed = mapper.believed_pose
        # Since its newest scan the robot has moved as it truly has: the drift of a tenth of a second cannot be seen.
        since = compose(inverse(np.array(mapper.newest_pose)), np.array(robot_state.pose))
        now = as_pose(compose(believed, since))
        return replace(robot_state, believed_pose=now, believed_scan_pose=as_pose(compose(believed, simulation.mount)))

    def sources(self) -> list[Source]:
        """The recordings, one for each kind of sensor."""
        trajectory = self._mapper.faults.trajectory
        logs, hidden = self._mapper.logs(), self._mapper.hidden
        return [
            Source(
                log,
                trajectory,
                log.n_scans - (hidden if log is logs[-1] else 0),
                np.asarray(log.stamps_ns * 1e-9, dtype=np.float64),
            )
            for log in logs
        ]

    def resume(self, story: dict[str, Any]) -> None:
        """Play, or not, at the speed at which the story was told. Raises :class:`ConfigError` for no such speed."""
        low, high = self.speeds
        speed = story.get("speed") or self.speed
        if not low <= speed <= high:
            raise ConfigError("story.speed", f"The speed must be between {low:g} and {high:g}.")
        self.speed, self.playing = float(speed), bool(story.get("playing", True))

    async def story(self) -> dict[str, Any]:
        """Return what is needed to make this world and its map again, as it is between two ticks."""
        async with self._lock:
            return story_of(self._mapper, self.max_story_s) | {"speed": self.speed, "playing": self.playing}

    def initial_config(self) -> MappingConfig:
        """Those of a lidar in a live world."""
        return self._mapper.first_config(SensorConfig())

    def particulars(self) -> dict[str, Any]:
        """The sensor and its parameters."""
        return {
            "sensor": {"table": [asdict(row) for row in SENSOR_PARAMETERS], "values": asdict(self.sensor)},
            "world": self.world.name,
            "seed": self._mapper.seed,
        }

    def parameters_message(self) -> dict[str, Any]:
        """As every session's, with the robot's faults and what the second map has otherwise."""
        second = self._mapper.second
        return super().parameters_message() | {
            "faults": asdict(self._mapper.faults),
            "compare": None if second is None else {"values": second.values, "with_faults": second.with_faults},
        }

    def slots(self) -> list[dict[str, Any]]:
        """The world, besides what every session says."""
        return [*super().slots(), self._world_message()]

    def _world_message(self) -> dict[str, Any]:
        mapper, world = self._mapper, self.world
        added, erased = mapper.edits.as_lists()
        return {
            "type": "world",
            "name": world.name,
            "title": world.title,
            "names": list(WORLDS),
            "bounds": [float(v) for v in world.bounds],
            "polygons": [np.round(solid, 4).tolist() for solid in world.solids],
            "ids": solid_ids(mapper.plan, mapper.edits),
            "edits": {"added": added, "erased": erased},
            "polished": np.round(polished_faces(world), 4).tolist(),
        }

    def frame(self) -> dict[str, Any]:
        """As every session's, and whether the robot walks by itself."""
        return super().frame() | {"auto": self._mapper.simulation.auto}

    def remake(self, config: MappingConfig, outcome: TickResult) -> None:
        """Make the map anew from everything that was seen."""
        self._mapper.remake(config)
        outcome.new_grid = True

    def advance(self, dt: float, outcome: TickResult) -> None:
        """Let the robot walk and see."""
        if dt > 0.0:
            outcome.changed = True
            for change in self._mapper.advance(dt * self.speed):
                outcome.add(change)

    def draw_second(self, outcome: TickResult) -> None:
        """Bring the second map's layer up to date, and tell how the two maps forget."""
        second, vanishing = self._mapper.second, self._mapper.vanishing
        told = (vanishing, 0 if vanishing is None else len(vanishing.first.free))
        if told != self._forgetting:
            self._forgetting = told
            outcome.slot(forgetting_message(vanishing))
        if second is None:
            self._second_layer = None
            return
        if self._second_layer is None:
            self._second_layer = GridLayer("second_map", "Second map")
        whole, box = second.changed()
        outcome.changed |= self._second_layer.update(second.grid, second.config, box, whole=whole)

    def obey(self, command: dict[str, Any], outcome: TickResult) -> None:
        """Carry out a command."""
        mapper = self._mapper
        match command["type"]:
            case kind if kind in ACTIONS:
                second = mapper.second
                act(mapper, command, outcome)
                self.config = mapper.config
                if kind == "drive":
                    self.playing = True  # who takes the wheel wants to move
                if kind == "edit":
                    outcome.slot(self._world_message())
                if kind == "sensor" or mapper.second is not second:
                    outcome.slot(self.parameters_message())
            case "step":
                self._step(command, outcome)
            case "faults":
                mapper.set_up(mapper.config, mapper.faults.with_values(values(command)))
                outcome.new_grid = True
                outcome.slot(self.parameters_message())
            case "compare":
                wanted = command.get("values")
                mapper.compare(None if wanted is None else values(command))
                outcome.slot(self.parameters_message())
            case "world":
                name = text(command, "name")
                if name not in WORLDS:
                    raise ProtocolError("command.name", f"There is no world {name!r:.80}.")
                self._begin(world_named(name), command, outcome)
            case "restart":
                added, erased = mapper.edits.as_lists()
                self._begin(mapper.plan, {"added": added, "erased": erased}, outcome)
                self.playing = True
            case "seek":
                raise ProtocolError("world.seek", "A live world cannot go to another time; restart begins it anew.")
            case other:
                raise ProtocolError("command.unknown", f"A simulation knows no command {other!r:.80}.")

    def _step(self, command: dict[str, Any], outcome: TickResult) -> None:
        scans = integer(command, "scans", 1)
        if not 1 <= abs(scans) <= MAX_STEP_SCANS:
            raise ProtocolError("command.scans", f"A live world steps by 1 to {MAX_STEP_SCANS} scans, on or back.")
        self.playing = False
        if scans < 0:
            outcome.new_grid |= self._mapper.step_back(-scans)
            return
        now = min(scans, SCANS_AT_ONCE)
        for change in self._mapper.step(now):
            outcome.add(change)
        if scans > now:
            outcome.unfinished = command | {"scans": scans - now}

    def _begin(self, world: World, edits: dict[str, Any], outcome: TickResult) -> None:
        self._mapper.begin(world, self.sensor, edits_of(edits))
        self.title = self.world.title
        outcome.new_grid = True
        outcome.slot(self._world_message())
