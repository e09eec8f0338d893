"""Live world: a robot with a lidar in a world, and time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, compose_one
from mapper.sensors.scan import LaserScan
from mapper.simulation.explorer import Explorer
from mapper.simulation.kernels import driving
from mapper.simulation.kernels.driving import STEP
from mapper.simulation.lidar import SensorConfig, measure
from mapper.simulation.robot import PoseTuple, Robot
from mapper.simulation.worlds import World

DRIVE_SECONDS = 0.5  #: duration of a manual velocity command
ROBOT_RADIUS = 0.2  #: metres


@dataclass(frozen=True, slots=True)
class Teleport:
    """Result of a teleport: ``pose`` (x, y, yaw), whether it had to be ``moved``, and a message."""

    pose: PoseTuple
    moved: bool
    message: str


class Simulation:
    """A world, a robot in it, its lidar and a clock, which only :meth:`advance` moves.

    The same world, sensor, seed and calls produce the same scans. Noise and exploration have separate random
    generators, so a change of the sensor does not change the path. ``mount`` is ``T_base_laser``: metres, metres,
    radians. Not thread-safe.
    """

    def __init__(
        self,
        world: World,
        sensor: SensorConfig | None = None,
        seed: int = 0,
        *,
        mount: PoseTuple = (0.0, 0.0, 0.0),
        radius: float = ROBOT_RADIUS,
    ) -> None:
        if not all(math.isfinite(v) for v in mount):
            raise ConfigError("simulation.mount", f"The sensor mount must be three finite numbers, not {mount!r}.")
        if not 0.0 < radius <= 1.0:
            raise ConfigError("simulation.radius", f"The robot’s radius must be in (0, 1] m, not {radius!r}.")
        noise, wander = np.random.SeedSequence(seed).spawn(2)
        self._noise, self._wander = np.random.default_rng(noise), np.random.default_rng(wander)
        self.sensor = sensor or SensorConfig()
        self.mount = mount
        self.radius = radius
        self._steps = 0
        self._rest = 0.0  # seconds not yet covered by a whole step
        self._auto = True
        self._drive = (0.0, 0.0)
        self._drive_until = 0.0
        self._control = (0.0, 0.0)
        self._next_scan = STEP  # the first scan is taken immediately
        self.world = world
        self.robot = Robot(world.start, radius)
        self.explorer = Explorer(world, self._wander)
        self._before = world.start

    @property
    def time(self) -> float:
        """Seconds since the start of the simulation."""
        return self._steps * STEP + self._rest

    @property
    def steps(self) -> int:
        """Whole physics steps of :data:`STEP` seconds since the start of the simulation."""
        return self._steps

    @property
    def pose(self) -> PoseTuple:
        """``T_map_base`` now: x, y, yaw; interpolated between physics steps, so that motion looks smooth."""
        share = self._rest / STEP
        (x0, y0, yaw0), (x1, y1, yaw1) = self._before, self.robot.pose
        turn = math.remainder(yaw1 - yaw0, 2.0 * math.pi)
        yaw = math.remainder(yaw0 + share * turn, 2.0 * math.pi)
        return (x0 + share * (x1 - x0), y0 + share * (y1 - y0), yaw)

    @property
    def sensor_pose(self) -> Float64Array:
        """``T_map_laser`` now (3,)."""
        return compose(self.pose, self.mount)

    @property
    def auto(self) -> bool:
        """Whether the robot drives autonomously."""
        return self._auto

    @auto.setter
    def auto(self, value: bool) -> None:
        if value and not self._auto:
            self.explorer.forget_path()
        self._auto = value
        self._drive = self._control = (0.0, 0.0)

    def advance(self, dt: float) -> list[tuple[LaserScan, PoseTuple]]:
        """Advance by ``dt`` seconds; return the scans taken meanwhile, each with the base's pose ``T_map_base``.

        Raises :class:`ConfigError` for a time that is negative or not finite.
        """
        if not (math.isfinite(dt) and dt >= 0.0):
            raise ConfigError(
                "simulation.time", f"Time must advance by a finite number of seconds, at least 0, not {dt!r}."
            )
        self._rest += dt
        count = 0
        while self._rest >= STEP - 1e-9:
            self._rest = max(0.0, self._rest - STEP)
            count += 1
        scans = []
        while count:
            count -= self._drive_on(count)
            if self._steps * STEP >= self._next_scan - 1e-9:
                scans.append(self._scan())
        return scans

    def _drive_on(self, most: int) -> int:
        """Take at least one and at most ``most`` physics steps; return their number."""
        now = self._steps * STEP
        if not self._auto:
            self._control = self._drive if now < self._drive_until else (0.0, 0.0)
            return self._move(1, driving.VELOCITIES)
        done = self._move(most, driving.NOTHING)
        if not done:
            self.explorer.plan(self.robot, now)
            if len(self.explorer.path):
                return self._move(most, driving.PATH)
            self._control = (0.0, 0.6)  # no goal: turn in place
            return self._move(1, driving.VELOCITIES)
        return done

    def _move(self, most: int, known: int) -> int:
        robot, explorer = self.robot, self.explorer
        state = np.array(
            (*robot.pose, robot.linear, robot.angular, *self._control, *explorer.progress, *self._before, 0.0)
        )
        segments, path = self.world.segments, explorer.path
        done = driving.drive(segments, robot.radius, path, state, self._steps, most, self._next_scan, known, 2.0)
        x, y, yaw, robot.linear, robot.angular, *rest = state.tolist()
        wanted_linear, wanted_angular, progress_x, progress_y, progress_time, *before, first = rest
        robot.pose, self._before = (x, y, yaw), (before[0], before[1], before[2])
        self._control = (wanted_linear, wanted_angular)
        explorer.progress = (progress_x, progress_y, progress_time)
        explorer.path = path[int(first) :]
        self._steps += done
        if done and (self._steps - 1) % driving.NOTE_STEPS == 0:
            explorer.note(robot.pose, (self._steps - 1) * STEP)
        return done

    def _scan(self) -> tuple[LaserScan, PoseTuple]:
        now = self._steps * STEP
        self._next_scan = max(self._next_scan + 1.0 / self.sensor.scan_rate, now)
        pose = self.robot.pose
        laser = compose_one(pose, self.mount)
        return measure(self.world, self.sensor, laser, self._noise, round(now * 1e9)), pose

    def drive(self, linear: float, angular: float) -> None:
        """Drive manually for :data:`DRIVE_SECONDS`: m/s forward, rad/s counter-clockwise, limited to the robot's
        maxima.

        Switches :attr:`auto` off. Raises :class:`ConfigError` for a velocity that is not finite.
        """
        if not (math.isfinite(linear) and math.isfinite(angular)):
            raise ConfigError("simulation.drive", f"Velocities must be finite, not {linear!r} and {angular!r}.")
        self.auto = False
        self._drive = (float(linear), float(angular))
        self._drive_until = self._steps * STEP + DRIVE_SECONDS

    def teleport(self, x: float, y: float, yaw: float | None = None) -> Teleport:
        """Place the robot at (x, y) metres, facing ``yaw`` radians (None: unchanged), at rest.

        If it does not fit, it is placed at the nearest free position, and the message says so. Raises
        :class:`ConfigError` for a position or a heading that is not finite.
        """
        if not all(math.isfinite(v) for v in (x, y, 0.0 if yaw is None else yaw)):
            raise ConfigError("simulation.teleport", f"A teleport needs finite numbers, not {x!r}, {y!r}, {yaw!r}.")
        needed = self.radius + 1e-3
        place = self.world.nearest_free((x, y), needed)
        heading = self.robot.pose[2] if yaw is None else math.remainder(yaw, 2.0 * math.pi)
        pose = (float(place[0]), float(place[1]), heading)
        self.robot.pose = self._before = pose
        self.robot.stop()
        self.explorer.forget_path()
        self._drive = self._control = (0.0, 0.0)
        moved = not self.world.is_free((x, y), needed)
        return Teleport(pose, moved, self._landing(x, y, pose) if moved else f"The robot is at ({x:.2f}, {y:.2f}).")

    def _landing(self, x: float, y: float, pose: PoseTuple) -> str:
        clearance = float(self.world.clearance((x, y)))
        away = math.hypot(pose[0] - x, pose[1] - y)
        # Two digits, unless the requested position is extremely far away.
        distance = f"{away:.2f}" if away < 1e4 else f"{away:.3g}"
        why = (
            "Outside the map" if np.isneginf(clearance) else "Inside a wall" if clearance <= 0.0 else "Too tight there"
        )
        return f"{why}, so the robot moved to the nearest free spot, {distance} m away."

    def set_sensor(self, sensor: SensorConfig) -> None:
        """Replace the lidar; the next scan comes from the new one."""
        self.sensor = sensor
        self._next_scan = min(self._next_scan, self._steps * STEP + 1.0 / sensor.scan_rate)

    def alter_world(self, world: World) -> bool:
        """Replace the world by one with the same bounds; the robot stays in place if it still fits.

        Return whether it had to be moved to the nearest free position. Raises :class:`ConfigError` for other bounds and
        for a world in which the robot fits nowhere; nothing has changed then.
        """
        if world.bounds != self.world.bounds:
            raise ConfigError("simulation.bounds", "A changed world must keep its bounds.")
        x, y, yaw = self.robot.pose
        needed = self.radius + 1e-3
        place = world.nearest_free((x, y), needed)
        moved = not world.is_free((x, y), self.radius)
        self.world = world
        self.explorer.enter(world)
        if moved:
            self.robot.pose = self._before = (float(place[0]), float(place[1]), yaw)
            self.robot.stop()
        return moved
