"""Simulated drives whose true poses are known, of which a localization is asked how sure it is."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.lidar import RANGE_MIN, SensorConfig
from mapper.simulation.odometry import ALPHAS, TURN_BIAS, WORN_ALPHAS, WORN_TURN_BIAS, drifting_odometry
from mapper.simulation.plan_map import with_moved_furniture
from mapper.simulation.robot import PoseTuple
from mapper.simulation.shapes import box, outer_walls, wall
from mapper.simulation.simulation import Simulation
from mapper.simulation.worlds import World

SCANS = 100  #: of a drive
KIDNAPPED_AT = 40  #: scan before which the robot is carried elsewhere
RATE = 2.5  #: scans in a second

SENSORS = {
    "8 m, 360°": SensorConfig(n_beams=180, range_max=8.0, range_noise=0.01, scan_rate=RATE),
    "5 m, 180°": SensorConfig(n_beams=90, field_of_view=math.pi, range_max=5.0, range_noise=0.02, scan_rate=RATE),
    "20 m, 270°": SensorConfig(
        n_beams=135, field_of_view=1.5 * math.pi, range_max=20.0, range_noise=0.03, scan_rate=RATE
    ),
}
ODOMETRY = {"good": (ALPHAS, TURN_BIAS), "worn": (WORN_ALPHAS, WORN_TURN_BIAS)}
CASES = ("anywhere", "known", "wrong start", "kidnapped", "changed")


def _wards() -> World:
    """A corridor with six equal rooms on each side: turned by half it is the same, and each room is like the next."""
    solids = outer_walls(0.0, 0.0, 30.0, 12.0, 0.2)
    doors = [(2.0 + 5.0 * k, 3.2 + 5.0 * k) for k in range(6)]
    for y in (5.0, 7.0):
        solids += wall((0.0, y), (30.0, y), 0.15, doors)
    for x in range(5, 30, 5):
        solids += wall((x, 0.0), (x, 5.0), 0.15) + wall((x, 7.0), (x, 12.0), 0.15)
    return World("wards", "Equal rooms along a corridor", (0.0, 0.0, 30.0, 12.0), tuple(solids), (15.0, 6.0, 0.0))


def _square() -> World:
    """A square hall with four equal pillars, the same turned by a quarter, and one small box that breaks it."""
    solids = outer_walls(0.0, 0.0, 14.0, 14.0, 0.2)
    solids += [box(x, y, 0.8, 0.8) for x in (4.0, 10.0) for y in (4.0, 10.0)]
    solids.append(box(12.5, 7.0, 0.4, 0.4))
    return World(
        "square", "A hall that is almost the same turned", (0.0, 0.0, 14.0, 14.0), tuple(solids), (7.0, 7.0, 0.0)
    )


DRIVEN = dict(WORLDS) | {"wards": _wards(), "square": _square()}


@dataclass(frozen=True)
class Name:
    """A drive: world, sensor, odometry, case and the seed of its random numbers."""

    world: str
    sensor: str
    odometry: str
    case: str
    seed: int

    @property
    def words(self) -> tuple[str, ...]:
        return self.world, self.sensor, self.odometry, self.case


@dataclass(frozen=True)
class Drive:
    """A log with the trajectories "odometry" and "true", and where the filter begins, (3,); None for anywhere."""

    name: Name
    log: ScanLog
    start: np.ndarray | None


def names(before: int = 0) -> Iterator[Name]:
    """Yield all combinations of worlds, sensors, odometry and cases; from a known start with worn odometry only.

    Their seeds are those after ``before``.
    """
    combinations = itertools.product(DRIVEN, SENSORS, CASES, ODOMETRY)
    for seed, (world, sensor, case, odometry) in enumerate(combinations, before + 1):
        if (case, odometry) != ("known", "good"):
            yield Name(world, sensor, odometry, case, seed)


def made(name: Name) -> Drive:
    """Return one drive.

    Cases: "anywhere", "known": the filter is told the start; "wrong start": it is told another one; "kidnapped": it is
    told the start, and later the robot is carried elsewhere; "changed": furniture has moved since the map was made.
    """
    rng = np.random.default_rng(name.seed)
    place, config = DRIVEN[name.world], SENSORS[name.sensor]
    driven = with_moved_furniture(place) if name.case == "changed" else place
    poses, ranges, stamps = simulated(
        driven, config, name.seed, carried=[KIDNAPPED_AT] if name.case == "kidnapped" else ()
    )
    wheels = drifting_odometry(poses, rng, *ODOMETRY[name.odometry])
    if name.case == "kidnapped":  # the wheels do not notice
        at = KIDNAPPED_AT
        wheels[at:] = compose(compose(wheels[at - 1], inverse(wheels[at])), wheels[at:])
    log = ScanLog(
        ranges, config.angle_min, config.angle_increment, RANGE_MIN, config.range_max, stamps,
        {"odometry": Trajectory(wheels, "wheels", "odom"), "true": Trajectory(poses)},
    )  # fmt: skip
    start = poses[0] if name.case in ("known", "kidnapped") else None
    if name.case == "wrong start":
        others = simulated(place, config, 10_000 + name.seed, n=60)[0]
        start = max(others, key=lambda pose: math.hypot(*(pose[:2] - poses[0, :2])))
    return Drive(name, log, start)


@cache
def plan(world: str, sensor: str) -> OccupancyGrid:
    """Return the map of a world by forty short drives from anywhere, with true poses."""
    config = MappingConfig(resolution=0.05)
    seen = SENSORS[sensor]
    poses, ranges, stamps = simulated(DRIVEN[world], seen, 1_000_000, n=800, carried=range(20, 800, 20))
    log = ScanLog(
        ranges, seen.angle_min, seen.angle_increment, RANGE_MIN, seen.range_max, stamps, {"true": Trajectory(poses)}
    )
    grid = grid_for(log, config, "true")
    integrate_log(grid, log, config, "true")
    return grid


def simulated(
    world: World, sensor: SensorConfig, seed: int, n: int = SCANS, *, carried: Sequence[int] = ()
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the poses (n, 3), ranges (n, b) and stamps (n,) of a drive.

    Before some of its scans the robot is ``carried`` elsewhere.
    """
    simulation = Simulation(world, sensor, seed)
    rng = np.random.default_rng(seed)
    x0, y0, x1, y1 = world.bounds

    def elsewhere() -> None:
        simulation.teleport(rng.uniform(x0, x1), rng.uniform(y0, y1), rng.uniform(-math.pi, math.pi))
        simulation.auto = True

    elsewhere()
    taken: list[tuple[LaserScan, PoseTuple]] = []
    while len(taken) < n:
        if len(taken) in carried:
            elsewhere()
        taken += simulation.advance(1.0 / sensor.scan_rate)
    taken = taken[:n]
    poses = np.array([pose for _, pose in taken])
    ranges = np.array([scan.ranges for scan, _ in taken])
    return poses, ranges, np.array([scan.stamp_ns for scan, _ in taken])
