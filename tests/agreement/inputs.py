"""Random scans on random grids; edge cases are much more frequent than at random."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from mapper.core.se2 import compose, transform_points
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.parameters import HIT_OR_PASSED, MappingConfig
from mapper.sensors.camera import Intrinsics
from mapper.sensors.planar.cloud import Placement
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import LEAST_ANGLE_STEP, RangeScan, ScanLog, Trajectory, is_angle_step

STEPS = ("fixed_increments", "step_window")  #: models of three zones
QUARTERS = [k * np.pi / 4 for k in range(-4, 5)]


@dataclass(frozen=True)
class MappingCase:
    """A log of a few scans, the grid and the parameters to map it with, and perhaps a map that is known before."""

    geometry: GridGeometry
    log: ScanLog
    config: MappingConfig
    prior_map: np.ndarray | None

    def grid(self) -> OccupancyGrid:
        return OccupancyGrid(self.geometry, self.config.log_odds_prior, self.prior_map)

    def sensor_poses(self) -> np.ndarray:
        return compose(self.log.sensor_poses(), np.array(self.config.mount))

    def scans(self) -> list[RangeScan]:
        """The scans as the textbook takes them, with bearings as the mount has them."""
        scans = [self.log.scan(t) for t in range(self.log.n_scans)]
        if not self.config.mount_upside_down:
            return scans
        return [scan.turned_over() for scan in scans]


def some(*values: float, low: float, high: float) -> st.SearchStrategy[float]:
    return st.sampled_from(values) | st.floats(low, high, allow_nan=False)


@st.composite
def geometries(draw: st.DrawFn) -> GridGeometry:
    resolution = draw(some(0.05, 0.1, 0.25, 1.0, low=0.02, high=1.0))
    steps = st.integers(-40, 40).map(lambda n: n * resolution)
    origin = (
        draw(steps | st.floats(-5, 5)),
        draw(steps | st.floats(-5, 5)),
        draw(some(0.0, *QUARTERS, low=-3, high=3)),
    )
    return GridGeometry(resolution, draw(st.integers(1, 60)), draw(st.integers(1, 60)), origin)


@st.composite
def poses(draw: st.DrawFn, geometry: GridGeometry) -> list[float]:
    """Inside the grid, on borders, corners and centres of cells, and outside on every side."""
    halves = st.integers(-20, 140).map(lambda n: n / 2)
    lattice = [draw(halves | st.floats(-10, 70)), draw(halves | st.floats(-10, 70))]
    x, y = transform_points(geometry.origin, np.array(lattice) * geometry.resolution)
    theta = draw(some(geometry.origin[2], *QUARTERS, low=-4, high=4))
    return [float(x), float(y), theta]


@st.composite
def configs(draw: st.DrawFn, update: str, models: tuple[str, ...]) -> MappingConfig:
    config = MappingConfig(
        update=update,
        model=draw(st.sampled_from(models)),
        range_max=draw(some(2.0, 30.0, low=0.5, high=20.0)),
        window=draw(some(0.0, 0.05, 0.2, 2.0, low=0.0, high=2.0)),
        log_odds_hit=draw(some(0.85, 0.0, 3.0, low=0.0, high=3.0)),
        log_odds_miss=draw(some(-0.4, 0.0, -3.0, low=-3.0, high=0.0)),
        traversal=draw(st.sampled_from(["bresenham", "amanatides_woo"])),
        no_return=draw(st.sampled_from(["ignore", "free", "hit"])),
        clamp=draw(st.booleans()),
        log_odds_prior=draw(some(0.0, low=-0.3, high=0.3)),
    )
    shape = {
        "sigma": some(0.03, 0.5, low=0.005, high=0.5),
        "sigma_growth": some(0.01, 0.0, low=0.0, high=0.2),
        "opening": some(0.52, 1.57, 0.01, low=0.01, high=1.57),
        "cone_profile": st.sampled_from(["flat", "gaussian"]),
        "prior_weight": some(2.0, 0.1, low=0.1, high=50.0),
        "resolution": some(0.05, low=0.01, high=1.0),
    }
    mounted = shape | {
        "mount_upside_down": st.booleans(),
        "mount_x": some(0.0, low=-1, high=1),
        "mount_y": some(0.0, low=-1, high=1),
        "mount_yaw": some(0.0, low=-3, high=3),
    }
    if config.model in HIT_OR_PASSED:
        mounted["hit_and_passed"] = st.sampled_from(["both_count", "only_hits"])
    return config.with_values({name: draw(values) for name, values in mounted.items()})


def some_log_odds(seed: int, shape: tuple[int, int]) -> np.ndarray:
    """Log-odds of which 3 in 10 are NaN: nothing is known there."""
    random = np.random.default_rng(seed)
    return np.where(random.random(shape) < 0.3, np.nan, random.normal(0, 1, shape)).astype(np.float32)


SEEDS = st.integers(0, 2**32 - 1)


@st.composite
def mapping_cases(draw: st.DrawFn, update: str, models: tuple[str, ...] = STEPS) -> MappingCase:
    geometry = draw(geometries())
    config = draw(configs(update, models))
    n_scans, n_beams = draw(st.integers(1, 3)), draw(st.integers(1, 12))
    range_min = draw(st.sampled_from([0.0, 0.1]))
    range_max = draw(st.sampled_from([5.0, 80.0, np.inf]))
    z_max = min(range_max, config.range_max)
    special = [np.nan, np.inf, -np.inf, -1.0, 0.0, range_min, z_max, np.nextafter(np.float32(z_max), np.inf), 2 * z_max]
    reading = (
        st.sampled_from([float(z) for z in special])
        | st.integers(0, 60).map(lambda n: n * geometry.resolution / 2)
        | st.floats(0.0, min(1.2 * z_max, 40 * geometry.resolution))
    )
    ranges = draw(st.lists(reading, min_size=n_scans * n_beams, max_size=n_scans * n_beams))
    base = np.array([draw(poses(geometry)) for _ in range(n_scans)])
    bearing = some(0.0, *QUARTERS, low=-7, high=7)
    uneven = draw(st.none() | st.lists(bearing, min_size=n_beams, max_size=n_beams))
    full_turn = 2 * np.pi / n_beams
    step = some(full_turn, -full_turn, 0.0, LEAST_ANGLE_STEP, np.pi / 180, np.pi / 4, np.pi / 2, 3.0, low=-1, high=1)
    log = ScanLog(
        np.array(ranges, dtype=np.float32).reshape(n_scans, n_beams),
        draw(some(0.0, *QUARTERS, low=-4, high=4)),
        draw(step.filter(lambda angle: is_angle_step(angle, n_beams))),
        range_min,
        range_max,
        np.zeros(n_scans, dtype=np.int64),
        {"drawn": Trajectory(base)},
        mount=(draw(some(0.0, low=-1, high=1)), 0.0, draw(some(0.0, np.pi, low=-3, high=3))),
        upside_down=draw(st.booleans()),
        bearings=None if uneven is None else np.array(uneven),
    )
    known = draw(st.none() | SEEDS)
    return MappingCase(geometry, log, config, None if known is None else some_log_odds(known, geometry.shape))


@st.composite
def sweeping_cases(draw: st.DrawFn, models: tuple[str, ...] = STEPS) -> MappingCase:
    """A robot that moves while its beams are measured one after another, with poses near and far in time."""
    case = draw(mapping_cases("per_beam", models).filter(lambda case: case.log.n_scans > 1 and case.log.n_beams > 1))
    steps = st.sampled_from([0, 1, 100_000_000, 400_000_000, 600_000_000, -100_000_000]) | st.integers(0, 10**9)
    later = draw(st.lists(steps, min_size=case.log.n_scans - 1, max_size=case.log.n_scans - 1).filter(any))
    stamps = 10**9 + np.cumsum([0, *later])
    increment = draw(st.sampled_from([0.1, -0.05, 0.4]) | st.floats(1e-4, 0.3)) / case.log.n_beams
    log = replace(case.log, stamps_ns=stamps, time_increment=increment)
    timed = {"deskew": draw(st.sampled_from(["auto", "on"])), "time_offset": draw(some(0.0, 0.1, low=-1, high=1))}
    return replace(case, log=log, config=case.config.with_values(timed))


@dataclass(frozen=True)
class LineCase:
    """A line between two cells, and a grid that may hold all, part or nothing of it."""

    shape: tuple[int, int]
    start: tuple[int, int]
    end: tuple[int, int]


def lines() -> st.SearchStrategy[LineCase]:
    coordinate = st.integers(-40, 40)
    side = st.integers(1, 30)
    cell = st.tuples(coordinate, coordinate)
    return st.builds(LineCase, st.tuples(side, side), cell, cell)


@dataclass(frozen=True)
class RayCase:
    """A segment between two points (column, row), in cells, and a grid that may hold all, part or nothing of it."""

    shape: tuple[int, int]
    start: tuple[float, float]
    end: tuple[float, float]


@st.composite
def rays(draw: st.DrawFn) -> RayCase:
    # Halves of a cell, and as often whole cells from one end to the other: segments go through corners, along borders.
    shape = (draw(st.integers(1, 8)), draw(st.integers(1, 8)))
    halves = st.integers(-4, 20).map(lambda n: n / 2)
    start = (draw(halves | st.floats(-2, 10)), draw(halves | st.floats(-2, 10)))
    if draw(st.booleans()):
        return RayCase(shape, start, (draw(halves | st.floats(-2, 10)), draw(halves | st.floats(-2, 10))))
    return RayCase(shape, start, (start[0] + draw(st.integers(-7, 7)), start[1] + draw(st.integers(-7, 7))))


@dataclass(frozen=True)
class PictureCase:
    """Log-odds, a box of them to quantise, the range to quantise over, and room for so many changed cells."""

    log_odds: np.ndarray
    observed: np.ndarray
    box: tuple[int, int, int, int]
    low: float
    high: float
    room: int


@st.composite
def pictures(draw: st.DrawFn) -> PictureCase:
    rows, cols = draw(st.integers(1, 20)), draw(st.integers(1, 20))
    random = np.random.default_rng(draw(SEEDS))
    bound = st.integers(-3, 23)
    return PictureCase(
        random.uniform(-4, 5, (rows, cols)).astype(np.float32),
        random.random((rows, cols)) < 0.7,
        (draw(bound), draw(bound), draw(bound), draw(bound)),
        draw(some(-2.0, low=-10, high=-0.1)),
        draw(some(3.5, low=0.1, high=10)),
        draw(st.integers(0, 400)),
    )


@dataclass(frozen=True)
class ListedCells:
    """A picture and cells of it, ``row << 16 | col``, some of them twice."""

    picture: np.ndarray
    cells: np.ndarray


@st.composite
def listed_cells(draw: st.DrawFn) -> ListedCells:
    rows, cols = draw(st.integers(1, 40)), draw(st.integers(1, 40))
    random = np.random.default_rng(draw(SEEDS))
    n = draw(st.integers(0, 60))
    cells = random.integers(0, rows, n) << 16 | random.integers(0, cols, n)
    return ListedCells(random.integers(-128, 128, (rows, cols)).astype(np.int8), cells.astype(np.uint32))


@dataclass(frozen=True)
class TwoMaps:
    """Two grids on one lattice; cell (0, 0) of the second lies at ``offset`` (rows, columns) in the first."""

    a: OccupancyGrid
    b: OccupancyGrid
    offset: tuple[int, int]


@st.composite
def two_maps(draw: st.DrawFn) -> TwoMaps:
    a = draw(geometries())
    offset = (draw(st.integers(-30, 30)), draw(st.integers(-30, 30)))
    corner = a.cell_to_world((offset[0] - 0.5, offset[1] - 0.5))
    sides = (draw(st.integers(1, 30)), draw(st.integers(1, 30)))
    b = GridGeometry(a.resolution, *sides, (float(corner[0]), float(corner[1]), a.origin[2]))
    number = draw(some(0.0, low=-2, high=2))
    # One map of the whole neighbourhood is what both went on from: rows and columns count from (-30, -30) of a.
    known = some_log_odds(draw(SEEDS), (120, 120)) if draw(st.booleans()) else None
    grids = []
    for geometry, (row, col) in ((a, (30, 30)), (b, (30 + offset[0], 30 + offset[1]))):
        part = None if known is None else known[row : row + geometry.rows, col : col + geometry.cols]
        grid = OccupancyGrid(geometry, number, part)
        seen = some_log_odds(draw(SEEDS), geometry.shape)
        grid.log_odds = np.where(np.isnan(seen), grid.log_odds, grid.log_odds + seen).astype(np.float32)
        grid.observed |= ~np.isnan(seen)
        grids.append(grid)
    return TwoMaps(grids[0], grids[1], offset)


@dataclass(frozen=True)
class StatesCase:
    """A map, and the probabilities above and below which a cell is occupied and free."""

    grid: OccupancyGrid
    occupied: float
    free: float


@st.composite
def states(draw: st.DrawFn) -> StatesCase:
    shape = (draw(st.integers(1, 20)), draw(st.integers(1, 20)))
    known = some_log_odds(draw(SEEDS), shape) if draw(st.booleans()) else None
    grid = OccupancyGrid(GridGeometry(0.1, *shape), draw(some(0.0, low=-2, high=2)), known)
    seen = some_log_odds(draw(SEEDS), shape) * draw(st.sampled_from([1.0, 0.0, 5.0, 100.0]))
    grid.log_odds = np.where(np.isnan(seen), grid.log_odds, seen).astype(np.float32)
    grid.observed |= ~np.isnan(seen)
    free, occupied = sorted((draw(some(0.25, 0.5, 0.0, low=0, high=1)), draw(some(0.65, 0.5, 1.0, low=0, high=1))))
    # Rounded: where p is the last number below 1 the textbook cannot tell which side of such a threshold a cell is on.
    return StatesCase(grid, round(occupied, 9), round(free, 9))


@dataclass(frozen=True)
class CloudCase:
    """Points (n, 3) in the frame of a sensor that is placed somewhere on a robot, and how a scan is cut out of them."""

    points: np.ndarray
    placement: Placement
    cut: PlanarCut


@st.composite
def clouds(draw: st.DrawFn) -> CloudCase:
    random = np.random.default_rng(draw(SEEDS))
    points = random.normal(0, 3, (draw(st.integers(0, 60)), 3)).round(draw(st.integers(0, 9)))
    for at in draw(st.lists(st.integers(0, max(0, points.size - 1)), max_size=3)):
        if points.size:
            points.reshape(-1)[at] = draw(st.sampled_from([np.nan, np.inf, -np.inf, 0.0, 1e200]))
    rotation, _ = np.linalg.qr(random.normal(0, 1, (3, 3)))
    placement = Placement(rotation if draw(st.booleans()) else np.eye(3), random.normal(0, 1, 3))
    first, low = draw(some(-np.pi, low=-3.1, high=2.0)), draw(some(-1.0, low=-3, high=2))
    cut = PlanarCut(
        low,
        low + draw(some(1.0, low=0.1, high=4)),
        first,
        draw(some(np.pi, low=first + 1.0, high=np.pi)),
        draw(some(np.pi / 180, low=0.005, high=0.9)),
        cloud_range=(draw(some(0.0, low=0, high=2)), draw(some(np.inf, low=2, high=9))),
    )
    return CloudCase(points, placement, cut)


@dataclass(frozen=True)
class DepthCase:
    """A depth image (height, width), metres, its camera, and how a scan is cut out of it."""

    depth: np.ndarray
    camera: Intrinsics
    cut: PlanarCut


@st.composite
def depths(draw: st.DrawFn) -> DepthCase:
    random = np.random.default_rng(draw(SEEDS))
    height, width = draw(st.integers(4, 20)), draw(st.integers(1, 30))
    depth = random.uniform(0, 12, (height, width)).astype(np.float32)
    for value in (np.nan, np.inf, 0.0):
        depth[random.random(depth.shape) < 0.1] = value
    centre = random.uniform(0.4, 0.6, 2)
    focal = float(random.uniform(3, 40))
    camera = Intrinsics(width, height, focal, focal, centre[0] * width, centre[1] * height)
    rows = draw(st.integers(1, max(1, int(0.7 * height))))
    return DepthCase(depth, camera, PlanarCut(scan_height=float(rows)))
