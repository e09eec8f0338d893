"""``python -m mapper.tools.precompile``: compile every kernel, so that the first visitor does not wait for it.

With ``--lab``, compile only those needed by a new simulated world. With ``--background``, compile all at the lowest
priority until standard input ends, unless that was done before or another process is doing it. With ``--part NAME``,
compile one of :data:`PARTS`: without options this is done for all parts, one process per core.

numba caches compiled code (in NUMBA_CACHE_DIR, or next to the sources), so an image or a machine that ran this once
starts at full speed. It exits with 1 and names the kernel if one was missed.
"""

from __future__ import annotations

import fcntl
import importlib
import itertools
import os
import pkgutil
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import mapper
from mapper.core.kernels.decimals import write_thousandths
from mapper.core.parallel import cores
from mapper.costmap import DecayConfig, InflationConfig, Observation, ObstacleConfig, VoxelConfig
from mapper.costmap.build import DEFAULT, build_costmap
from mapper.costmap.inflation import inflate, squared_distances
from mapper.costmap.nav2.costmap import NamedLayer
from mapper.grid import TILE, GridGeometry, OccupancyGrid
from mapper.grid.compare import compare
from mapper.grid.kernels.lattice import Frame
from mapper.grid.kernels.quantise import NEVER_OBSERVED, quantise, quantise_cells, sort_by_tile
from mapper.grid.metrics import map_metrics
from mapper.localization import LocalizationConfig, MonteCarloLocalizer
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.matching.beams import prepare_scans
from mapper.matching.kernels.likelihood_field import accumulate_field
from mapper.matching.kernels.point_to_line import accumulate_pairs, solve_step
from mapper.matching.kernels.types import CAUCHY, PairRule
from mapper.matching.match import match_scan
from mapper.matching.parameters import METHODS, MatchConfig
from mapper.matching.target import Target, scan_target
from mapper.planning import PlannerConfig, plan_path
from mapper.replay import Replay
from mapper.sensors.camera import Intrinsics
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import WORLDS, Recording, Simulation
from mapper.simulation.faults import reflected_away
from mapper.simulation.kernels.raycast import arc_clearance, farthest_in_sight, nearest_edge
from mapper.simulation.live_map import LiveMap
from mapper.simulation.sensors_3d import Sensor3D, measure_3d
from mapper.slam import SlamConfig, slam_log
from mapper.slam.kernels.agreement import count_agreement, count_common
from mapper.slam.kernels.graph_distance import least_of_ranges, ways_from
from mapper.slam.kernels.keypoint_pairs import nearest_descriptors, pose_of_pairs
from mapper.slam.local_map import local_map
from mapper.slam.scan_store import ScanStore
from mapper.terrain import Patches, agreeing, assess, find_ground
from mapper.terrain.kernels.extension import mark_near
from mapper.volume import (
    OccupancyVolume,
    Octree,
    TsdfConfig,
    TsdfVolume,
    VolumeConfig,
    cast,
    distance_to_obstacle,
    octree_file,
    project,
)
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.mesh.chunk_mesh import shaded
from mapper.volume.mesh.faces import VoxelFaces, chunks_of, face_rule
from mapper.volume.mesh.surface_chunks import SurfaceChunks
from mapper.volume.octree.files import octree_of_bytes

SECONDS = 1.0  # of simulated driving: a few scans and a plan


class _NoEvidence:
    """A user-defined sensor model."""

    reach = 0.0

    def increments(self, s: NDArray[np.float64], _z: NDArray[np.float64], _range_max: float) -> NDArray[np.float64]:
        return np.zeros_like(s)


def precompile_lab() -> None:
    """Explore a simulated world with the default parameters, recompute its map, and draw it."""
    live = LiveMap(WORLDS["office"], seed=0)
    live.advance(SECONDS)
    live.remake(live.config)
    _draw(live.grid)


def _draw(grid: OccupancyGrid) -> None:
    """Quantise a map for its picture."""
    rows, cols = grid.geometry.shape
    picture = np.full((rows, cols), NEVER_OBSERVED, dtype=np.int8)
    changed = np.zeros((-(-rows // TILE), -(-cols // TILE)), dtype=np.bool_)
    cells = np.empty(rows * cols, dtype=np.uint32)
    count = quantise(
        grid.log_odds, grid.observed, -2.0, 3.5, -1.0, 0.6, 0, rows, 0, cols, TILE, picture, changed, cells, 0
    )
    every = np.arange(rows * cols, dtype=np.uint32)
    quantise_cells(grid.log_odds, grid.observed, -2.0, 3.5, -1.0, 0.6, every, TILE, picture, changed, cells, 0)
    sort_by_tile(
        picture,
        cells[:count],
        TILE,
        np.empty((count, 3), np.int16),
        np.empty(count, np.uint16),
        np.empty(count, np.int8),
    )


def precompile() -> None:
    """Use each part of the mapper once, like the service."""
    log = _map()
    _match(log)
    _close_a_loop(log)
    _map_surfaces()


def _map() -> ScanLog:
    """Drive and record, map with every kernel, localize, plan, and draw; return the recorded log."""
    world = WORLDS["room"]
    simulation = Simulation(world)
    recording = Recording(simulation.sensor)
    for scan, pose in simulation.advance(SECONDS):
        recording.append(scan, pose)
    arc_clearance(world.segments, *world.start, 0.5, 0.1, 0.5, 5)
    nearest_edge(world.segments, *world.start[:2], np.empty(2))
    farthest_in_sight(world.segments, *world.start[:2], np.zeros((1, 2)), 0, 0.1)
    reflected_away(world, np.full(2, 1.0), np.zeros(2), world.start)
    measure_3d(world, Sensor3D(), world.start, np.random.default_rng(0))
    replay = Replay(recording.as_log(), MappingConfig(resolution=0.1))
    replay.advance_to(replay.log.n_scans)
    _localize(replay.log, replay.grid)
    _plan(replay.grid.geometry)
    for model, update, traversal, no_return in itertools.product(
        *(BY_NAME[name].choices for name in ("model", "update", "traversal", "no_return"))
    ):
        replay.reconfigure(
            replay.config.with_values(
                {"model": model, "update": update, "traversal": traversal, "no_return": no_return, "window": 0.2}
            )
        )
        replay.advance_to(0)
        replay.advance_to(replay.log.n_scans)
        replay.provenance(0, 0)
    grid = replay.grid
    _draw(grid)
    compare(grid, grid)
    map_metrics(grid)
    pose = replay.log.sensor_poses()[0]
    config = MappingConfig(resolution=0.1)
    integrate_scan(grid.emptied(), replay.log.scan(0), pose, config)
    write_thousandths(replay.log.ranges[0], 0.0, 1.0, np.empty(1 << 14, dtype=np.uint8))
    for traversal in BY_NAME["traversal"].choices:
        integrate_scan(grid.emptied(), replay.log.scan(0), pose, replace(config, traversal=traversal), _NoEvidence())
    return replay.log


def _localize(log: ScanLog, grid: OccupancyGrid) -> None:
    """Process the first scan of a log with each sensor model, from a global start and from a given pose."""
    pose = grid.geometry.cell_to_world((grid.geometry.rows // 2, grid.geometry.cols // 2)).tolist()
    for model in ("likelihood_field_prob", "beam"):
        robot = MonteCarloLocalizer(grid, LocalizationConfig(laser_model_type=model, global_particles=1000))
        robot.update(np.zeros(3), log.scan(0))
        robot.start_at([*pose, 0.0])
        robot.predict(np.zeros(3), np.array([0.5, 0.0, 0.0]))


def _plan(geometry: GridGeometry) -> None:
    """Apply the layers of a costmap to an empty map with one observation, and plan with each algorithm."""
    seen_by = (
        NamedLayer("obstacle_layer", ObstacleConfig()),
        NamedLayer("voxel_layer", VoxelConfig()),
        NamedLayer("dynamic_layer", DecayConfig()),
    )
    layers = (*DEFAULT.layers[:1], *seen_by, *DEFAULT.layers[1:])
    values = np.zeros(geometry.shape, dtype=np.int8)
    built = build_costmap(geometry, values, replace(DEFAULT, layers=layers))
    middle = geometry.cell_to_world((geometry.rows // 2, geometry.cols // 2))
    seen = Observation(np.array([*middle, 0.3]), np.array([[*middle + 1.0, 0.3]]))
    for layer in built.obstacles:
        layer.observe(seen)
    corners = middle + np.array([[0.5, 0.0], [1.0, 0.0], [1.0, 0.5]])
    built.keepout.paint(corners, 100)
    built.costmap.update(0.0, (float(middle[0]), float(middle[1]), 0.0))
    far = InflationConfig(inflation_radius=200 * geometry.resolution)  # for 32-bit distances
    inflate(built.costmap.costs, far, geometry.resolution, 0.1, np.empty_like(built.costmap.costs))
    squared_distances(built.costmap.costs, 1)
    for use_astar in (False, True):
        plan_path(built.costmap.costs, geometry, middle, middle, PlannerConfig(use_astar=use_astar))


def _match(log: ScanLog) -> None:
    """Match the first two scans of a log, and a scan with both, with each method."""
    scans, guess = prepare_scans(log, 0, 2), np.zeros(3)
    single, both = scan_target(scans, 0), Target(scans, np.arange(2), log.trajectory().poses[:2])
    for method in METHODS:
        config = MatchConfig(method=method, window_m=0.2, window_rad=0.1)
        match_scan(scans, 1, single, guess, config)
        match_scan(scans, 1, both, both.poses[1], config)
    first = np.zeros(1, dtype=np.int64)
    hessians, gradients = np.zeros((1, 6, 6)), np.zeros((1, 6))
    rule = PairRule(0.5, 12, CAUCHY, 0.03, 1)
    accumulate_pairs(scans, first, first, np.zeros((2, 3)), 0.3, rule, hessians, gradients, np.zeros((1, 4)))
    solve_step(hessians[0, :3, :3].copy(), gradients[0, :3].copy(), np.empty(3))
    scores, frame = np.zeros((10, 10), dtype=np.uint8), Frame(0.0, 0.0, 1.0, 0.0, 0.1)
    accumulate_field(scores, frame, scans, 0, guess, 1, np.empty((3, 3)), np.empty(3))


def _close_a_loop(log: ScanLog) -> None:
    """Run SLAM over a few scans that go back and forth, and call the functions that it only calls when a loop
    closes.
    """
    order = np.tile(np.arange(min(3, log.n_scans)), 10)
    poses = np.column_stack([np.arange(len(order)) * 0.2, np.zeros((len(order), 2))])
    again = replace(log, ranges=log.ranges[order], stamps_ns=log.stamps_ns[order], trajectories={"": Trajectory(poses)})
    slam_log(again, SlamConfig(refinement=1, submap_scans=5))
    scans, single, three = prepare_scans(log, 0, 1), np.zeros(1, dtype=np.int64), np.zeros(3, dtype=np.int64)
    count_agreement(scans, 0, poses[0], single, poses[:1], 0.1, 1, three)
    count_common(scans, 0, poses[0], single, poses[:1], 0.1, 1, three[:1])
    ways_from(0, np.arange(2.0), single, single + 1, np.zeros(2))
    least_of_ranges(np.zeros(2), single, single + 1, single.copy())
    store = ScanStore([log], 30.0, 360)
    store.append(log.ranges[0])
    local_map(store, single, 0, poses[:1])
    nearest_descriptors(
        np.zeros((1, 2), dtype=np.float32), np.zeros((1, 2), dtype=np.float32), single.reshape(1, 1).copy()
    )
    pose_of_pairs(np.zeros((1, 2)), np.zeros((1, 2)), single, np.zeros(3), 1.0, 1.0, 1.0, 1.0, np.zeros(3))


def _map_in_3d() -> None:
    """Map one beam as voxels, query the map, and write and read its octree."""
    volume = OccupancyVolume(VolumeConfig(half_life=10.0))
    volume.insert_scan(np.ones((1, 3)), np.zeros(3))
    volume.decay(1.0)
    cast(volume, np.zeros((1, 3)), np.ones((1, 3)))
    distance_to_obstacle(volume, np.zeros((1, 3)), 1.0)
    project(volume)
    VoxelFaces().update(volume, face_rule(volume, -9.0, 9.0, base=0.0, band=1.0, colours=2), chunks_of(volume))
    slot_of(volume.blocks.table, block_code(0, 0, 0))
    for kind in (".bt", ".ot"):
        octree_of_bytes(octree_file(Octree.of(volume), kind, volume.config).bytes(), kind).tree.volume(volume.config)


def _fuse_surfaces() -> None:
    """Fuse a depth image and a beam, and mesh the surface."""
    surface = TsdfVolume(TsdfConfig(resolution=0.1))
    surface.fuse_depth(np.ones((8, 8)), Intrinsics(8, 8, 8.0, 8.0, 3.5, 3.5), np.eye(4))
    surface.fuse_points(np.ones((1, 3)), np.zeros(3))
    chunks = SurfaceChunks()
    chunks.note_change(surface, None)
    chunks.work(surface)
    colors, normals = np.zeros((1, 3), dtype=np.uint8), np.zeros((1, 3), dtype=np.int8)
    shaded(colors, normals, np.ones(6, dtype=np.float32))


def _assess_terrain() -> None:
    """Find the ground of a few points with gaps between them, and the planes of its patches."""
    points = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 3.0, 0.5], [3.0, 3.0, 4.0]])
    find_ground(points)
    flags = np.zeros((4, 4), dtype=np.bool_)
    mark_near(points, flags[0], np.zeros(2), 1.0, 1, flags)  # called when points are added to the ground
    agreeing(points, Patches.of(points, 4.0), 0.1)
    assess(Patches.of(points, 4.0).parents())


def _match_without_driving() -> None:
    """Match and close a loop on a log that is made without a kernel."""
    poses = np.column_stack([0.1 * np.arange(3.0), np.zeros((3, 2))])
    ranges = np.tile(2.0 + 0.01 * np.arange(360.0), (3, 1)).astype(np.float32)
    stamps = 100_000_000 * np.arange(3, dtype=np.int64)
    log = ScanLog(ranges, -np.pi, np.pi / 180.0, 0.1, 10.0, stamps, {"": Trajectory(poses)})
    _match(log)
    _close_a_loop(log)


def _map_surfaces() -> None:
    """Map in 3D, fuse surfaces, and assess terrain."""
    _map_in_3d()
    _fuse_surfaces()
    _assess_terrain()


#: Parts of :func:`precompile` that use different kernels but for a few.
PARTS = {"map": _map, "match": _match_without_driving, "surfaces": _map_surfaces}


def _compile_parts() -> None:
    """Compile the parts in as many processes as there are cores. The cause of a failure shows in :func:`precompile`."""
    with ThreadPoolExecutor(cores()) as pool:
        for name in PARTS:
            pool.submit(subprocess.run, [sys.executable, "-m", "mapper.tools.precompile", "--part", name], check=False)


def kernels() -> dict[str, bool]:
    """Return every jitted function of the packages ``mapper.*.kernels`` by its full name, and whether it is compiled.

    Functions with a leading underscore are compiled into their callers and do not count.
    """
    compiled: dict[str, bool] = {}
    for info in pkgutil.walk_packages(mapper.__path__, "mapper."):
        if not re.fullmatch(r"mapper\.\w+\.kernels\.\w+", info.name):
            continue
        for value in vars(importlib.import_module(info.name)).values():
            function = getattr(value, "py_func", None)
            if function is not None and function.__module__ == info.name and not function.__name__.startswith("_"):
                compiled[f"{info.name}.{function.__name__}"] = bool(value.signatures)
    return compiled


def _mark() -> Path:
    """Return the path of the empty marker file for "all current kernels are compiled for this processor"."""
    import llvmlite  # noqa: PLC0415 - imports numba, which `--lab` does later
    from llvmlite.binding import get_host_cpu_features, get_host_cpu_name  # noqa: PLC0415

    from mapper.core.compile_cache import cache_folder  # noqa: PLC0415

    folders = [cache_folder(package) for package in sorted({name.split(".")[1] for name in kernels()})]
    made_by = llvmlite.__version__, get_host_cpu_name(), get_host_cpu_features().flatten()
    text = "\n".join([*made_by, *(folder.name for folder in folders)])
    return folders[0].parent / f"compiled-{sha256(text.encode()).hexdigest()[:16]}"


def _end_with_input() -> None:
    """End this process when its standard input ends, that is, when the process at the other end has ended."""
    while os.read(sys.stdin.fileno(), 4096):
        pass
    os._exit(0)


def _background_turn(mark: Path) -> bool:
    """Lower the priority; return whether there is something to compile and no other process is compiling it."""
    os.nice(19)
    with suppress(OSError):  # Linux: if memory runs out, this process is killed first
        Path("/proc/self/oom_score_adj").write_text("1000")
    threading.Thread(target=_end_with_input, daemon=True).start()
    if mark.exists():
        return False
    try:
        mark.parent.mkdir(parents=True, exist_ok=True)
        fcntl.flock(os.open(mark.parent, os.O_RDONLY), fcntl.LOCK_EX | fcntl.LOCK_NB)  # until this process ends
    except BlockingIOError:
        return False
    except OSError:  # no such folder: numba caches the kernels in a folder of the user
        return True
    return not mark.exists()


def main() -> int:
    """Compile the kernels and print the time taken; return the exit status."""
    began = time.perf_counter()
    if sys.argv[1:] == ["--lab"]:
        precompile_lab()
        print(f"the lab's kernels ready in {time.perf_counter() - began:.1f} s")
        return 0
    if sys.argv[1:2] == ["--part"]:
        PARTS[sys.argv[2]]()
        return 0
    mark = _mark()
    if sys.argv[1:] == ["--background"]:
        if not _background_turn(mark):
            return 0
        precompile_lab()
    elif not mark.exists() and cores() > 1:
        _compile_parts()
    precompile()
    done = kernels()
    cold = [name for name, compiled in done.items() if not compiled]
    for name in cold:
        print(f"{name} was not compiled: mapper/tools/precompile.py does not use it.", file=sys.stderr)
    print(f"{len(done) - len(cold)} of {len(done)} kernels ready in {time.perf_counter() - began:.1f} s")
    if not cold:
        with suppress(OSError):  # if it is not writable, the next run finds the kernels compiled one by one
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.touch()
    return 1 if cold else 0


if __name__ == "__main__":
    sys.exit(main())
