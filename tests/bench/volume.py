"""Occupancy in 3D beside OctoMap: inserting scans, casting rays, memory; in processor time of one process."""

from __future__ import annotations

import itertools
import math
import os
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pyoctomap

from mapper.io.clouds import read_scan_graph
from mapper.volume import OccupancyVolume, Octree, VolumeConfig, cast, octree_file
from mapper.volume.occupancy.queries import HIT
from tests.bench.volume_limits import cast_limit, cast_reads, insertion_limit
from tests.bench.volume_parts import cast_parts, insertion_parts

N_POINTS, N_RAYS = 100_000, 20_000
LISTED = 0.001  #: difference between a list of a limit and the map that is allowed


def room_scan(n: int = N_POINTS) -> tuple[np.ndarray, np.ndarray]:
    """A scan of n directions, evenly spread over the sphere, in a hall of 12 × 9 × 3.5 m with range noise of 1 cm."""
    rng = np.random.default_rng(0)
    k = np.arange(n) + 0.5
    z, turn = 1.0 - 2.0 * k / n, math.pi * (1.0 + math.sqrt(5.0)) * k
    away = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    with np.errstate(divide="ignore"):
        ranges = np.where(away > 0.0, np.array([6.2, 4.9, 2.3]) / away, np.array([-5.8, -4.1, -1.2]) / away).min(axis=1)
    points = away * (ranges + rng.normal(0.0, 0.01, n))[:, None]
    return points.astype(np.float32), np.full(3, 0.013, dtype=np.float32)


def cpu_ms(works: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the least processor time of each, over all threads, in ms; they take turns."""
    best = dict.fromkeys(works, math.inf)
    for _ in range(rounds):
        for name, work in works.items():
            began = time.process_time()
            work()
            best[name] = min(best[name], 1e3 * (time.process_time() - began))
    return best


def ours(scan: tuple[np.ndarray, np.ndarray], config: VolumeConfig) -> OccupancyVolume:
    volume = OccupancyVolume(config)
    volume.insert_scan(*scan)
    return volume


def theirs(scan: tuple[np.ndarray, np.ndarray], config: VolumeConfig) -> pyoctomap.OcTree:
    points, origin = scan
    tree = pyoctomap.OcTree(config.resolution)
    tree.insertPointCloud(points.astype(np.float64), origin.astype(np.float64), discretize=config.discretise)
    return tree


def insertion(scans: dict[str, tuple[np.ndarray, np.ndarray]], rounds: int = 3) -> None:
    """Print the table of insertions into an empty map, and of its memory."""
    print(f"inserting one scan, ms of processor time, best of {rounds}; memory per known voxel, and per OctoMap's node")
    print("the limit: the voxels of the rays marked, and those of the map added to, in this order, from lists")
    print(
        "| scan | voxels | beams to | ours | limit | ratio | OctoMap | ratio | our memory | OctoMap's | trees equal |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for (name, scan), resolution in ((one, r) for one in scans.items() for r in (0.1, 0.05)):
        for discretise in (False, True):
            config = VolumeConfig(resolution=resolution, discretise=discretise)
            works: dict[str, Callable[[], object]] = {
                "ours": partial(ours, scan, config),
                "theirs": partial(theirs, scan, config),
            }
            volume, tree = ours(scan, config), theirs(scan, config)
            works["limit"], share = insertion_limit(volume, *scan)
            works["limit"]()  # the kernels are loaded
            took = cpu_ms(works, rounds)
            check_listed(share)
            nodes = Octree.of(volume)
            print(
                f"| {name}, {len(scan[0])} points | {100 * resolution:g} cm | {'voxels' if discretise else 'points'} | "
                f"{took['ours']:.1f} | {took['limit']:.1f} | {took['ours'] / took['limit']:.2f} | "
                f"{took['theirs']:.0f} | {took['theirs'] / took['ours']:.0f} × | "
                f"{volume.n_bytes / volume.n_known:.1f} B | {tree.memoryUsage() / tree.size():.1f} B | "
                f"{'yes' if same(nodes, tree, config) else 'NO'}, {nodes.n_nodes} nodes |",
                flush=True,
            )


def same(nodes: Octree, tree: pyoctomap.OcTree, config: VolumeConfig) -> bool:
    """Whether OctoMap writes the bytes that we write."""
    folder = Path(os.environ.get("TMPDIR", "/tmp"))
    path = folder / f"bench-{os.getpid()}.ot"
    try:
        return bool(tree.write(str(path))) and path.read_bytes() == octree_file(nodes, ".ot", config).bytes()
    finally:
        path.unlink(missing_ok=True)


def casting(scan: tuple[np.ndarray, np.ndarray], rounds: int = 3) -> None:
    """Print the processor time of rays from the middle of the hall in that scan's map.

    OctoMap casts one ray a call: what the calls cost by themselves, with rays that begin in an occupied voxel and end
    there, is taken off. The limit is to read the blocks that the rays cross, and the voxels of those that are searched,
    from a list.
    """
    print(f"\n{N_RAYS} rays from 20 places, ms of processor time, best of {rounds}")
    print("| voxels | rays end at | ours | limit | ratio | OctoMap | ratio | hits | ends equal |")
    print("|---|---|---|---|---|---|---|---|---|")
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(N_RAYS, 3)).astype(np.float32)
    origins = np.repeat(rng.uniform([-4, -3, -0.8], [4, 3, 1.8], (20, 3)), N_RAYS // 20, axis=0).astype(np.float32)
    for resolution in (0.1, 0.05):
        config = VolumeConfig(resolution=resolution)
        mapped, tree = ours(scan, config), theirs(scan, config)
        for through in (True, False):
            run = partial(cast, mapped, origins, directions, through_unknown=through, range_max=20.0)
            found = run()
            read = cast_reads(mapped, origins, directions, found, through_unknown=through)
            limit, share = cast_limit(mapped, *read, found)
            check_listed(share)
            walls = np.repeat(found.points[found.ends == HIT][:1], N_RAYS, axis=0)
            took = cpu_ms(
                {
                    "ours": run,
                    "limit": limit,
                    "theirs": partial(peer_casts, tree, origins, directions, through),
                    "calls": partial(peer_casts, tree, walls, directions, through),
                },
                rounds,
            )
            hits, ends = peer_casts(tree, origins, directions, through)
            equal = np.array_equal(found.ends == HIT, hits) and np.array_equal(found.points[hits], ends[hits])
            theirs_ms = took["theirs"] - took["calls"]
            print(
                f"| {100 * resolution:g} cm | {'obstacles' if through else 'obstacles and unknown voxels'} | "
                f"{took['ours']:.1f} | {took['limit']:.2f} | {took['ours'] / took['limit']:.1f} | "
                f"{theirs_ms:.0f} | {theirs_ms / took['ours']:.0f} × | {int(hits.sum())} | "
                f"{'yes' if equal else 'NO'} |",
                flush=True,
            )
    for resolution in (0.1, 0.05):
        print(f"\nhall, {100 * resolution:g} cm:")
        cast_parts(ours(scan, VolumeConfig(resolution=resolution)), origins, directions)


def check_listed(share: float) -> None:
    """Raise :class:`ValueError` where a list of a limit has other voxels than the map; borders at one place may be."""
    if abs(share - 1.0) > LISTED:
        raise ValueError(f"{share:.4f} of the voxels are in the list of the limit")


def peer_casts(
    tree: pyoctomap.OcTree, origins: np.ndarray, directions: np.ndarray, through: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Cast the rays by OctoMap; return which hit, and the ends."""
    ends, hits = np.zeros((len(origins), 3)), np.zeros(len(origins), dtype=np.bool_)
    for i, (start, away) in enumerate(zip(origins.astype(np.float64), directions.astype(np.float64), strict=True)):
        hits[i] = tree.castRay(start, away, ends[i], through, 20.0)
    return hits, ends.astype(np.float32)


def volume() -> None:
    """Print all of the above."""
    scans = {"hall": room_scan()}
    graph = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")) / "octomap" / "spherical_scan.graph"
    if graph.is_file():
        (scan,) = read_scan_graph(graph)
        scans["spherical_scan"] = (scan.points_in_map().astype(np.float32), scan.origin.astype(np.float32))
    else:
        print("octomap: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
    insertion(scans)
    for resolution, discretise in itertools.product((0.1, 0.05), (False, True)):
        config = VolumeConfig(resolution=resolution, discretise=discretise)
        title = f"hall, {100 * resolution:g} cm, beams to {'voxels' if discretise else 'points'}"
        insertion_parts(title, scans["hall"], config)
    casting(scans["hall"])
