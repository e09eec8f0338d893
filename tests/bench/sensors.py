"""``python -m tests.bench sensors``: clouds cut to scans, several sensors in one map, a late moment of a large bag.

Each beside what it is compared with, in one run: a plain NumPy cut, each sensor mapped alone, a pass over the bag.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.contents import bag_index, seeking
from mapper.io.logs.containers.ros1_bag import ROS1_BAG
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.planar.cloud import Placement, add_points, empty_scan
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from tests.mapper.io.logs import camera_recordings
from tests.mapper.io.logs.camera_recordings import CameraRun

ROUNDS = 7
POINTS = 130_000  #: of one cloud: those of a 64-beam lidar at 10 Hz
UPDATES: dict[str, dict[str, object]] = {
    "per beam": {},
    "per scan": {"update": "per_scan"},
    "per scan, smooth ramp": {"update": "per_scan", "model": "smooth_ramp", "range_max": 10.0},
    "hit counting, per scan": {"update": "per_scan", "model": "hit_counting"},
}


def best_s(works: Sequence[Callable[[], object]], rounds: int = ROUNDS) -> list[float]:
    """Return the seconds that each work takes, the best of some rounds in which each has its turn."""
    best = [float("inf")] * len(works)
    for _ in range(rounds):
        for index, work in enumerate(works):
            began = time.perf_counter()
            work()
            best[index] = min(best[index], time.perf_counter() - began)
    return best


def plain_cut(points: NDArray[np.float64], placement: Placement, cut: PlanarCut) -> NDArray[np.float32]:
    """Cut a cloud to a scan as one writes it down in NumPy."""
    away = points @ placement.rotation.T
    height = away[:, 2] + placement.translation[2]
    distance, bearing = np.hypot(away[:, 0], away[:, 1]), np.arctan2(away[:, 1], away[:, 0])
    beam = np.minimum((bearing - cut.angle_min) / cut.angle_increment, cut.n_beams - 1).astype(np.int64)
    ranges = np.full(cut.n_beams, np.nan, dtype=np.float32)
    ranges[beam] = np.inf
    inside = (height >= cut.min_height) & (height <= cut.max_height)
    np.minimum.at(ranges, beam[inside], distance[inside].astype(np.float32))
    return ranges


def cutting() -> None:
    """Print how many points a second are cut to scans."""
    rng = np.random.default_rng(7)
    points = rng.uniform([-40.0, -40.0, -2.0], [40.0, 40.0, 4.0], (POINTS, 3))
    placement = Placement(np.eye(3), np.array([0.2, 0.0, 1.8]))
    print("\n| clouds of 130,000 points to scans | points a second | plain NumPy | ratio |\n|---|---|---|---|")
    for degrees in (1.0, 0.25):
        cut = PlanarCut(min_height=0.2, max_height=1.5, angle_increment=np.radians(degrees))

        def ours(cut: PlanarCut = cut) -> NDArray[np.float32]:
            ranges = empty_scan(cut)
            add_points(points, placement, cut, ranges)
            return ranges

        theirs = partial(plain_cut, points, placement, cut)
        np.testing.assert_allclose(ours(), theirs(), rtol=1e-6)
        one, other = best_s([ours, theirs])
        print(
            f"| {cut.n_beams} beams | {1e-6 * POINTS / one:.1f} M | {1e-6 * POINTS / other:.1f} M | "
            f"{other / one:.2f} × |"
        )


def _mapped(log: ScanLog, config: MappingConfig) -> Callable[[], object]:
    grid = grid_for(log, config)
    return lambda: integrate_log(grid.emptied(), log, config)


def together(log: ScanLog) -> None:
    """Print what two sensors as one log cost beside each by itself: of the same beams, and of half as many."""
    stamps = np.arange(log.n_scans) * 1_000_000
    front = replace(log, stamps_ns=stamps, topic="/front")
    same = replace(front, stamps_ns=stamps + 500_000, topic="/rear")
    half = replace(same, ranges=same.ranges[:, ::2].copy(), angle_increment=2.0 * same.angle_increment)
    columns = ("two sensors as one log", "each alone, together", "as one log", "ratio")
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for rear, beams in ((same, "the same beams"), (half, "half the beams")):
        for name, values in UPDATES.items():
            config = MappingConfig(range_max=30.0).with_values(values)
            joint = JointLog.of([front, rear])
            works = [_mapped(one, config) for one in (front, rear, joint)]
            first, second, both = best_s(works, 3)
            print(
                f"| {beams}, {name} | {1e3 * (first + second):.0f} ms | {1e3 * both:.0f} ms | "
                f"{both / (first + second):.2f} × |"
            )


def late_moment(folder: Path, size: int = 1_000_000_000) -> None:
    """Print how long the last picture of a bag takes by its index and by a pass over the bag."""
    print("\n| the last picture of a bag of 1 GB | by its index | by reading up to it | ratio |\n|---|---|---|---|")
    topic, at = "/camera/image_raw", 1 << 62
    for compression in ("none", "lz4"):
        path = camera_recordings.write(folder / "run.bag", "bag", CameraRun(4000).for_bytes(size), compression)
        found = bag_index.indexed_message(path, topic, at, DEFAULT_LIMITS)
        assert found is not None
        by_index, through = best_s(
            [
                partial(bag_index.indexed_message, path, topic, at, DEFAULT_LIMITS),
                partial(seeking.read_up_to, path, ROS1_BAG, topic, at, DEFAULT_LIMITS),
            ],
            3,
        )
        print(f"| {compression} | {1e3 * by_index:.0f} ms | {1e3 * through:.0f} ms | {through / by_index:.0f} × |")
        path.unlink()


def sensors(log: ScanLog) -> None:
    """Print the tables."""
    cutting()
    together(log)
    with tempfile.TemporaryDirectory(prefix="sensors-") as folder:
        late_moment(Path(folder))
