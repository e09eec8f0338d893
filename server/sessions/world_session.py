"""A live world: a simulated robot walks, and its map fills in."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict
from typing import Any, ClassVar, Literal

import numpy as np

from mapper.errors import ConfigError
from mapper.geometry import compose
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.integrate import Change, geometry_for, integrate_log, integrate_scan
from mapper.limits import Limits
from mapper.parameters import MappingConfig
from mapper.scan import LaserScan, ScanLog
from mapper.world import SENSOR_PARAMETERS, WORLDS, Recording, SensorConfig, Simulation, World
from mapper.world.lidar import measure
from server.sessions.outcome import Outcome
from server.sessions.session import Session
from server.sessions.view import Moment, Pose, as_pose
from server.sessions.why import Source
from server.stream.protocol import ProtocolError, integer, number, text, values

DEFAULT_WORLD = "office"
MARGIN = 1.0  #: metres around a world that its grid holds from the start, for readings that noise lengthens
WARM_UP_S = 2.0  #: seconds that the robot has walked when a visitor arrives
MAX_STEP_SCANS = 100
SCANS_AT_ONCE = 10  #: of a step in one tick
MAX_SEGMENTS = 32  #: recordings of different sensors that one map is made from


class WorldMapper:
    """A simulation and the map that it makes: what a world session computes. Not for several threads at once.

    Everything the sensor saw is kept, so the whole map can be made anew with other parameters. A sensor with other
    beams begins a recording of its own; the map is made from all of them.
    """

    def __init__(
        self,
        world: World,
        seed: int,
        config: MappingConfig | None = None,
        sensor: SensorConfig | None = None,
        limits: Callable[[], Limits] = Limits,
    ) -> None:
        sensor = sensor or SensorConfig()
        self.seed = seed
        self.limits = limits
        self.config = config or MappingConfig(range_max=sensor.range_max, window=0.2, resolution=0.05)
        self.begin(world, sensor)

    def begin(self, world: World, sensor: SensorConfig) -> None:
        """Start anew in ``world``, the robot having walked for a moment."""
        grid = self._empty_grid(world, self.config, [])
        self.simulation = Simulation(world, sensor, self.seed)
        self._noise = np.random.default_rng(self.seed)
        self.recordings = [Recording(sensor)]
        self.grid = grid
        self.newest: LaserScan | None = None
        self.newest_pose: Pose = self.simulation.pose
        self.scans = 0
        self.advance(WARM_UP_S)
        if self.newest is None:
            self.look()

    def _empty_grid(self, world: World, config: MappingConfig, logs: list[ScanLog]) -> OccupancyGrid:
        """Return a grid that holds the world and all that the logs saw of it."""
        limits = self.limits()
        x0, y0, x1, y1 = world.bounds
        low, high = np.array([x0 - MARGIN, y0 - MARGIN]), np.array([x1 + MARGIN, y1 + MARGIN])
        for log in logs:
            seen = geometry_for(log, config, limits=limits)
            inside = 0.5 * config.resolution
            low = np.minimum(low, np.array(seen.origin[:2]) + inside)
            high = np.maximum(
                high, np.array(seen.origin[:2]) + np.array([seen.cols, seen.rows]) * config.resolution - inside
            )
        geometry = GridGeometry.covering(low, high, config.resolution, limits)
        return OccupancyGrid(geometry, config.log_odds_prior)

    def logs(self) -> list[ScanLog]:
        """What the sensors saw so far, one log for each kind of sensor."""
        return [recording.as_log() for recording in self.recordings if len(recording)]

    def remake(self, config: MappingConfig) -> None:
        """Make the map anew from the recordings. Raises as :func:`geometry_for` does; the old map stays then."""
        logs = self.logs()
        grid = self._empty_grid(self.simulation.world, config, logs)
        for log in logs:
            integrate_log(grid, log, config)
        self.grid, self.config = grid, config

    def advance(self, dt: float) -> list[Change]:
        """Let ``dt`` seconds of the world's time pass; return what each scan changed."""
        return [self._take(scan, pose) for scan, pose in self.simulation.advance(dt)]

    def look(self) -> Change:
        """Take a scan now, whatever the sensor's rate: after a teleport nobody should have to wait."""
        simulation = self.simulation
        stamp_ns = round(simulation.time * 1e9)
        scan = measure(simulation.world, simulation.sensor, simulation.sensor_pose, self._noise, stamp_ns)
        return self._take(scan, simulation.pose)

    def step(self, scans: int) -> list[Change]:
        """Let time pass until ``scans`` more scans are in the map."""
        changes: list[Change] = []
        while len(changes) < scans:
            changes += self.advance(1.0 / self.simulation.sensor.scan_rate)
        return changes

    def _take(self, scan: LaserScan, pose: Pose) -> Change:
        recording = self.recordings[-1]
        generation = recording.generation
        recording.append(scan, pose)
        self.newest, self.newest_pose = scan, pose
        self.scans += 1
        if recording.generation != generation:
            # The recording was thinned: the map is made of what it still holds, as any later re-make will be.
            self.remake(self.config)
            return Change(None, geometry_changed=True, cells_updated=0)
        return integrate_scan(self.grid, scan, compose(pose, self.simulation.mount), self.config)

    def set_sensor(self, sensor: SensorConfig) -> bool:
        """Exchange the sensor; return whether the map had to be made anew, because a recording was given up."""
        self.simulation.set_sensor(sensor)
        if self.recordings[-1].fits(sensor):
            return False
        if not len(self.recordings[-1]):
            self.recordings.pop()
        self.recordings.append(Recording(sensor))
        if len(self.recordings) <= MAX_SEGMENTS:
            return False
        self.recordings.remove(min(self.recordings[:-1], key=len))
        self.remake(self.config)
        return True


class WorldSession(Session):
    """A session of the live world."""

    kind: ClassVar[Literal["world", "log"]] = "world"

    def __init__(
        self,
        mapper: WorldMapper,
        *,
        owner: str,
        pool: Executor,
        limits: Callable[[Session | None], Limits],
    ) -> None:
        self._mapper = mapper
        mapper.limits = lambda: limits(self)
        super().__init__(
            owner=owner,
            title=mapper.simulation.world.title,
            grid=mapper.grid,
            config=mapper.config,
            speed=1.0,
            pool=pool,
            limits=limits,
        )

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
    def speeds(self) -> tuple[float, float]:
        """Seconds of the world's time in a second."""
        return (0.25, 8.0)

    @property
    def progress(self) -> tuple[int, int]:
        """All scans that were taken are in the map."""
        return (self._mapper.scans, self._mapper.scans)

    def logs(self) -> list[ScanLog]:
        """What the sensors saw so far."""
        return self._mapper.logs()

    def moment(self) -> Moment:
        """Where the robot is now, and its newest scan."""
        simulation = self._mapper.simulation
        scan = self._mapper.newest
        if scan is None:
            raise RuntimeError("a world session has taken a scan before it starts")
        seen_from = compose(self._mapper.newest_pose, simulation.mount)
        return Moment(simulation.pose, as_pose(simulation.sensor_pose), as_pose(seen_from), scan, simulation.time)

    def sources(self) -> list[Source]:
        """The recordings, one for each kind of sensor."""
        return [
            Source(log, log.default_trajectory, log.n_scans, np.asarray(log.stamps_ns * 1e-9, dtype=np.float64))
            for log in self.logs()
        ]

    def particulars(self) -> dict[str, Any]:
        """The sensor and its parameters."""
        return {
            "sensor": {"table": [asdict(row) for row in SENSOR_PARAMETERS], "values": asdict(self.sensor)},
            "world": self.world.name,
        }

    def slots(self) -> list[dict[str, Any]]:
        """The world, besides what every session says."""
        return [*super().slots(), self._world_message()]

    def _world_message(self) -> dict[str, Any]:
        world = self.world
        return {
            "type": "world",
            "name": world.name,
            "title": world.title,
            "names": list(WORLDS),
            "bounds": [float(v) for v in world.bounds],
            "polygons": [np.round(solid, 4).tolist() for solid in world.solids],
        }

    def frame(self) -> dict[str, Any]:
        """As every session's, and whether the robot walks by itself."""
        return super().frame() | {"auto": self._mapper.simulation.auto}

    def remake(self, config: MappingConfig, outcome: Outcome) -> None:
        """Make the map anew from everything that was seen."""
        self._mapper.remake(config)
        outcome.new_grid = True

    def advance(self, dt: float, outcome: Outcome) -> None:
        """Let the robot walk and see."""
        if dt > 0.0:
            outcome.changed = True
            for change in self._mapper.advance(dt * self.speed):
                outcome.add(change)

    def obey(self, command: dict[str, Any], outcome: Outcome) -> None:
        """Carry out a command."""
        mapper, simulation = self._mapper, self._mapper.simulation
        match command["type"]:
            case "step":
                scans = integer(command, "scans", 1)
                if not 1 <= scans <= MAX_STEP_SCANS:
                    raise ProtocolError("command.scans", f"A live world steps on by 1 to {MAX_STEP_SCANS} scans.")
                self.playing = False
                now = min(scans, SCANS_AT_ONCE)
                for change in mapper.step(now):
                    outcome.add(change)
                if scans > now:
                    outcome.unfinished = command | {"scans": scans - now}
            case "teleport":
                yaw = None if command.get("yaw") is None else number(command, "yaw")
                landed = simulation.teleport(number(command, "x"), number(command, "y"), yaw)
                outcome.add(mapper.look())
                if landed.moved:
                    outcome.notice("teleport.moved", landed.message)
            case "drive":
                simulation.drive(number(command, "linear"), number(command, "angular"))
                self.playing = True  # who takes the wheel wants to move
            case "auto":
                value = command.get("value")
                if not isinstance(value, bool):
                    raise ProtocolError("command.value", f'"value" must be true or false, not {value!r:.80}.')
                simulation.auto = value
            case "sensor":
                outcome.new_grid |= mapper.set_sensor(simulation.sensor.with_values(values(command)))
                outcome.slot(self.parameters_message())
            case "world":
                name = text(command, "name")
                if name not in WORLDS:
                    raise ProtocolError("command.name", f"There is no world {name!r:.80}.")
                mapper.begin(WORLDS[name], simulation.sensor)
                self.title = self.world.title
                outcome.new_grid = True
                outcome.slot(self._world_message())
            case "restart":
                mapper.begin(simulation.world, simulation.sensor)
                self.playing = True
                outcome.new_grid = True
            case "seek":
                raise ProtocolError("world.seek", "A live world cannot go to another time; restart begins it anew.")
            case other:
                raise ProtocolError("command.unknown", f"A world session knows no command {other!r:.80}.")


def world_named(name: str) -> World:
    """Return a world. Raises :class:`ConfigError` for a name that there is not."""
    if name not in WORLDS:
        raise ConfigError("world.name", f"There is no world {name!r:.80}; there are {', '.join(WORLDS)}.")
    return WORLDS[name]
