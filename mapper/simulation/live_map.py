"""Computation of a lab session: a simulation, the recording of its sensor, and the maps made from it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.core.parameter import Values
from mapper.core.se2 import compose, compose_one, inverse, pose_tuple
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import Change, geometry_for, integrate_parts, integrate_scan
from mapper.mapping.parameters import MappingConfig, sensor_defaults
from mapper.sensors.scan import LaserScan, RangeScan, ScanLog
from mapper.simulation.edits import Edits, edited
from mapper.simulation.faults import Faults, lengthened, with_lengthened
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.lidar import SensorConfig, measure
from mapper.simulation.odometry import Odometer
from mapper.simulation.pose_correction import MakeCorrector, PoseCorrection
from mapper.simulation.recording import Recording
from mapper.simulation.robot import PoseTuple
from mapper.simulation.second_map import SecondMap, Vanishing
from mapper.simulation.simulation import Simulation
from mapper.simulation.worlds import World

SNAP_M = 0.2  #: metres that a robot may be displaced without a message
MARGIN = 1.0  #: metres around a world covered by its initial grid, for readings lengthened by noise
WARM_UP_S = 2.0  #: seconds that the robot has already driven when a visitor arrives
MAX_SEGMENTS = 32  #: recordings of different sensors used for one map


class LiveMap:
    """A simulation and its map. Not thread-safe.

    All sensor readings are kept, so the whole map can be recomputed with other parameters, with or without the robot's
    faults. A sensor with other beams starts a separate recording; the map is made from all of them.
    """

    def __init__(
        self,
        world: World,
        seed: int,
        config: MappingConfig | None = None,
        sensor: SensorConfig | None = None,
        limits: Callable[[], Limits] = Limits,
        edits: Edits | None = None,
        *,
        mapping: bool = True,
        may_continue: Callable[[], bool] = lambda: True,
        make_corrector: MakeCorrector = lambda *_: None,
    ) -> None:
        """Start in ``world``. Without ``mapping``, scans are only recorded, until :meth:`begin_mapping`.

        ``make_corrector`` creates the pose corrector of a sensor, for :attr:`Faults.slam`.
        """
        self._make_corrector = make_corrector
        sensor = sensor or SensorConfig()
        self.may_continue = (
            may_continue  #: called while maps are computed; False cancels with :class:`WorkCancelledError`
        )
        self.fraction: float | None = None  #: completed fraction of the map being computed; None if none is
        self._mapping = mapping
        self.seed = seed
        self.limits = limits
        self.config = _live(config or self.first_config(sensor))
        self.faults = Faults()
        self.second: SecondMap | None = None
        self.vanishing: Vanishing | None = None
        self.begin(world, sensor, edits)

    @staticmethod
    def first_config(sensor: SensorConfig) -> MappingConfig:
        """Return the initial parameters of a live world."""
        first = {"range_max": sensor.range_max, "window": 0.2, "resolution": 0.05}
        return MappingConfig().with_values(sensor_defaults(sensor.cone, first))

    def begin(self, world: World, sensor: SensorConfig, edits: Edits | None = None) -> None:
        """Restart in ``world``, modified by ``edits``, after the robot has driven for :data:`WARM_UP_S`.

        Raises the errors of :func:`mapper.simulation.edited`; nothing has changed then.
        """
        edits = edits or Edits()
        altered = edited(world, edits, self.limits())
        altered.nearest_free(world.start[:2])  # raises if nothing fits any more
        self.plan, self.edits = world, edits  #: the world as built, and the person's edits
        grid = self._empty_grid(altered, self.config, [])
        self.simulation = Simulation(altered, sensor, self.seed)
        self.first_sensor, self.first_edits = sensor, edits
        self.journal: list[tuple[int, Any]] = []  #: the actions, as recorded by the caller, with the step before each
        self._noise = np.random.default_rng(self.seed)
        self._odometer = Odometer(self.simulation.pose, np.random.default_rng([self.seed, 1]))
        self.recordings = [Recording(sensor)]
        self.pose_correction = PoseCorrection(self._make_corrector)
        self._has_moved = False  #: whether poses of mapped scans have been corrected since the map was computed
        self.grid = grid
        self.vanishing = None
        if self.second is not None:
            self.second.begin(self.second.config, self._empty_grid(altered, self.second.config, []))
        self.newest: RangeScan | None = None
        self.newest_pose: PoseTuple = self.simulation.pose
        self.believed_pose: PoseTuple = self.simulation.pose  #: the base's pose in the map at the newest scan
        self.scans = 0
        self.n_newest = 0  #: number of newest scans so far
        self.hidden = 0  #: newest scans removed from the map again, to be stepped through
        if not altered.is_free(world.start[:2], self.simulation.radius):
            self.simulation.teleport(*world.start)
            self._odometer.place(self.simulation.pose)
        self.advance(WARM_UP_S)
        if self.newest is None:
            self.look()

    def _empty_grid(self, world: World, config: MappingConfig, logs: list[ScanLog]) -> OccupancyGrid:
        """Return a grid that covers the world and everything the logs observed in it."""
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

    def logs(self, faults: Faults | None = None) -> list[ScanLog]:
        """Readings of the sensors so far, one log for each kind of sensor; None for the current faults.

        With None, and with faults that correct poses, the logs have the corrected poses, if those of all scans are
        known.
        """
        is_corrected = faults is None or faults.corrects_poses
        faults = faults or self.faults
        return [
            recording.as_log(
                specular=faults.specular,
                corrected=self.pose_correction.poses_of(recording) if is_corrected else None,
            )
            for recording in self.recordings
            if len(recording)
        ]

    # -- the maps ---------------------------------------------------------------------------------------------------

    def _made(self, config: MappingConfig, faults: Faults) -> OccupancyGrid:
        logs = self.logs(faults)
        used = [_only(log, faults.trajectory) for log in logs]
        grid = self._empty_grid(self.plan, config, used)
        total, done = sum(log.n_scans for log in used), 0
        try:
            for log in used:
                stop = log.n_scans - (self.hidden if log is used[-1] else 0)
                for at, _ in integrate_parts(grid, log, config, None, 0, stop):
                    self.fraction = (done + at) / max(1, total)
                    if not self.may_continue():
                        raise WorkCancelledError("world.unwanted", "The map is not wanted any more.")
                done += stop
        finally:
            self.fraction = None
        return grid

    def remake(self, config: MappingConfig) -> None:
        """Recompute the map from the recordings. Raises the errors of :func:`geometry_for`; the old map is then
        kept.
        """
        self.set_up(config, self.faults)

    def set_up(self, config: MappingConfig, faults: Faults) -> None:
        """Recompute both maps with other parameters or faults. Raises the errors of :meth:`remake`."""
        config = _live(config)
        if faults.corrects_poses:
            self._correct_poses(faults)
        if not self._mapping:
            self.config, self.faults = config, faults
            return
        second = self.second
        if second is not None:
            other = _live(second.config_for(config))
            remade = self._made(other, faults if second.with_faults else Faults())
        grid = self._made(config, faults)
        self.grid, self.config, self.faults = grid, config, faults
        if second is not None:
            second.begin(other, remade)
        self.vanishing = None
        self._has_moved = False

    def _correct_poses(self, faults: Faults) -> None:
        """Correct the poses of the recordings. Raises :class:`WorkCancelledError`; another call then continues."""

        def wanted(fraction: float) -> bool:
            self.fraction = fraction
            return self.may_continue()

        try:
            for recording in self.recordings:
                self.pose_correction.add(recording, wanted, specular=faults.specular)
        finally:
            self.fraction = None

    def begin_mapping(self) -> None:
        """Map what was recorded without a map, and continue mapping. Raises the errors of :meth:`remake`."""
        self._mapping = True
        self.remake(self.config)

    def compare(self, values: Values | None, *, with_faults: bool = False) -> None:
        """Keep a second map of the same recording with other ``values``; None removes it.

        It has true poses and readings, unless ``with_faults``. Raises :class:`ConfigError` for invalid values.
        """
        self.vanishing = None
        if values is None:
            self.second = None
            return
        config = _live(self.config.with_values(values))
        grid = self._made(config, self.faults if with_faults else Faults())
        self.second = SecondMap(values, with_faults, config, grid)

    # -- time -------------------------------------------------------------------------------------------------------

    def advance(self, dt: float) -> list[Change]:
        """Advance the world by ``dt`` seconds; return the change made by each scan."""
        changes = []
        for scan, pose in self.simulation.advance(dt):
            changes.append(self._take(scan, pose))
            self.may_continue()  # lets other computations run; the time advances anyway
        if self._has_moved and self._mapping:
            self.remake(self.config)
            changes.append(Change(None, geometry_changed=True, cells_updated=0))
        return changes

    @property
    def believed_now(self) -> PoseTuple:
        """The robot's believed pose in the map now.

        Its true motion since the newest scan is added, because the drift in a tenth of a second is negligible.
        """
        since = compose(inverse(np.array(self.newest_pose)), np.array(self.simulation.pose))
        return pose_tuple(compose(self.believed_pose, since))

    def look(self) -> Change:
        """Take a scan now, regardless of the sensor's rate; called after a teleport."""
        simulation = self.simulation
        stamp_ns = round(simulation.time * 1e9)
        scan = measure(simulation.world, simulation.sensor, simulation.sensor_pose, self._noise, stamp_ns)
        return self._take(scan, simulation.pose)

    def step_back(self, scans: int) -> bool:
        """Remove the newest ``scans`` from the map, but not the sensor's first; return whether there were any."""
        hidden = min(self.hidden + scans, len(self.recordings[-1]) - 1)
        if hidden <= self.hidden:
            return False
        before, self.hidden = self.hidden, hidden
        try:
            self.remake(self.config)
        except MapperError:
            self.hidden = before
            raise
        self._recall()
        return True

    def _recall(self) -> RangeScan:
        """Remove and return the newest scan that is not hidden, with its true readings."""
        recording = self.recordings[-1]
        at = len(recording) - 1 - self.hidden
        log = recording.as_log(specular=self.faults.specular, corrected=self.pose_correction.poses_of(recording))
        self.newest = log.scan(at)
        self.n_newest += 1
        self.newest_pose = pose_tuple(log.trajectory("true").poses[at])
        self.believed_pose = pose_tuple(log.trajectory(self.faults.trajectory).poses[at])
        return recording.as_log().scan(at)

    def _reveal(self, scans: int) -> list[Change]:
        """Add up to ``scans`` hidden scans to the map again."""
        changes = []
        for _ in range(min(scans, self.hidden)):
            self.hidden -= 1
            changes.append(self._integrate(self._recall()))
        return changes

    def step(self, scans: int) -> list[Change]:
        """Advance time until ``scans`` more scans are in the map; hidden scans come first."""
        changes = self._reveal(scans)
        while len(changes) < scans:
            changes += self.advance(1.0 / self.simulation.sensor.scan_rate)
        return changes

    def _take(self, scan: LaserScan, pose: PoseTuple) -> Change:
        self._reveal(self.hidden)
        recording = self.recordings[-1]
        generation = recording.generation
        odometry = self._odometer.move(pose)
        longer = self._lengthened(pose)
        recording.append(scan, pose, odometry, longer)
        self.newest, self.newest_pose = scan, pose
        self.n_newest += 1
        if self.faults.specular:
            self.newest = replace(scan, ranges=with_lengthened(scan.ranges, longer, scan.range_max))
        self.believed_pose = odometry if self.faults.drift else pose
        if self.faults.corrects_poses:
            self._has_moved |= self.pose_correction.add(recording, specular=self.faults.specular)
            corrector = self.pose_correction.corrector_of(recording)
            if corrector is not None:
                self.believed_pose = corrector.newest
        self.scans += 1
        if recording.generation != generation:
            # The recording was thinned, so the map is recomputed from what it still holds, like any later map.
            self.remake(self.config)
            return Change(None, geometry_changed=True, cells_updated=0)
        return self._integrate(scan)

    def _integrate(self, scan: RangeScan) -> Change:
        """Add the newest scan to the maps: as reported, and the true ``scan`` to a map without faults."""
        mount, reported = self.simulation.mount, self.newest
        if reported is None:
            raise RuntimeError("there is no newest scan")
        if not self._mapping:
            return Change(None, geometry_changed=False, cells_updated=0)
        change = integrate_scan(self.grid, reported, compose_one(self.believed_pose, mount), self.config)
        second = self.second
        if second is not None:
            seen, at = (reported, self.believed_pose) if second.with_faults else (scan, self.newest_pose)
            second.add(integrate_scan(second.grid, seen, compose_one(at, mount), second.config))
            if self.vanishing is not None:
                self.vanishing.look(self.grid, second.grid)
        return change

    def _lengthened(self, pose: PoseTuple) -> NDArray[np.float16]:
        simulation = self.simulation
        return lengthened(simulation.world, simulation.sensor, compose_one(pose, simulation.mount))

    # -- what a person changes --------------------------------------------------------------------------------------

    def teleport(self, x: float, y: float, yaw: float | None) -> tuple[Change, str | None]:
        """Place the robot somewhere and scan; return the change, and a message if it had to be placed elsewhere.

        No message is returned for a displacement of at most :data:`SNAP_M`.
        """
        landed = self.simulation.teleport(x, y, yaw)
        self._odometer.place(landed.pose)
        is_told = landed.moved and math.hypot(landed.pose[0] - x, landed.pose[1] - y) > SNAP_M
        return self.look(), landed.message if is_told else None

    def set_sensor(self, sensor: SensorConfig) -> bool:
        """Replace the sensor; return whether the map had to be recomputed because a recording was dropped.

        Thin beams and cones need different models, so with a sensor of another kind the map starts again, with the
        default model of that sensor. Raises :class:`WorkCancelledError` if the new map is cancelled; sensor, map and
        recordings are then unchanged.
        """
        self._reveal(self.hidden)
        before, old = self.simulation.sensor, [*self.recordings]
        try:
            return self._exchange(sensor)
        except WorkCancelledError:
            self.simulation.set_sensor(before)
            self.recordings = old
            raise

    def _exchange(self, sensor: SensorConfig) -> bool:
        other_kind = sensor.kind != self.simulation.sensor.kind
        self.simulation.set_sensor(sensor)
        if other_kind:
            defaults = sensor_defaults(sensor.cone)
            model = {"model": defaults.pop("model", "fixed_increments")}
            self.recordings = [Recording(sensor)]
            self.remake(self.config.with_values(model | defaults))
            self.look()
            return True
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

    def edit(self, edits: Edits, *, watch: bool = False) -> bool:
        """Modify the world around the robot; return whether the robot had to be moved.

        With ``watch``, a second map without the clamp (or with it, if the first has none) is started, and both are
        watched while they forget the erased solids. Raises the errors of :func:`mapper.simulation.edited`, and
        :class:`ConfigError` if the map contains nothing of the erased solids; the world is then unchanged.
        """
        before = self.simulation.world
        after = edited(self.plan, edits, self.limits())
        if self.vanishing is not None and not watch:
            self.compare(None)
        vanishing = Vanishing.of(self.grid, self.config, before, after) if watch else None
        if vanishing is not None:
            self.compare({"clamp": not self.config.clamp}, with_faults=True)
        moved = self.simulation.alter_world(after)
        self.edits = edits
        if moved:
            self._odometer.place(self.simulation.pose)
        if vanishing is not None:
            self.vanishing = vanishing
        return moved


def _live(config: MappingConfig) -> MappingConfig:
    """Return the parameters without a time offset, because the future poses of a live robot are unknown."""
    return config.with_values({"time_offset": 0.0}) if config.time_offset else config


def _only(log: ScanLog, trajectory: str) -> ScanLog:
    return replace(log, trajectories={trajectory: log.trajectory(trajectory)})


def world_named(name: str) -> World:
    """Return a world. Raises :class:`ConfigError` for an unknown name."""
    if name not in WORLDS:
        raise ConfigError("world.name", f"There is no world {name!r:.80}; there are {', '.join(WORLDS)}.")
    return WORLDS[name]
