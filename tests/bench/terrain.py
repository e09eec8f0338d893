"""Terrain: moments, planes of all windows beside ``lstsq`` per patch, ground of ISPRS samples and simulated clouds."""

from __future__ import annotations

import itertools
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray
from mapper.io.clouds import read_cloud
from mapper.terrain import GroundConfig, Patches, agreement, find_ground, ground
from tests.airborne import SCENES, labelled_cloud

SIDE, N_POINTS, N_LSTSQ = 400, 2_000_000, 2_000
#: SMRF with the values of its paper, and two passes
SMRF = GroundConfig(slope=0.15, height=0.5, local_slope=0.0, extensions=0.0)
#: Values between which the samples chose, and neighbours of those chosen
VALUES = [
    GroundConfig(slope=slope, local_slope=local_slope, height=height)
    for slope, local_slope, height in itertools.product((0.09, 0.12, 0.15), (0.25, 0.5, 0.75), (0.2, 0.3, 0.4, 0.5))
]


def cpu_s(work: Callable[[], object], rounds: int) -> float:
    """Return the least processor time of a call, over all threads."""
    best = math.inf
    work()
    for _ in range(rounds):
        began = time.process_time()
        work()
        best = min(best, time.process_time() - began)
    return best


def patches(rounds: int = 5) -> None:
    """Print the times of a square of 400² patches; points come in rows, as a sensor measures them."""
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, float(SIDE), (N_POINTS, 3))
    points[:, 2] = 0.1 * points[:, 0] + rng.normal(0.0, 0.05, N_POINTS)
    scanned = points[np.argsort(np.floor(points[:, 1]), kind="stable")]
    grid = Patches.of(points, 1.0)
    print(f"{N_POINTS} points, {SIDE} × {SIDE} patches; processor time, best of {rounds}")
    for name, some in (("points row by row", scanned), ("points in any order", points)):
        took = cpu_s(lambda some=some: grid.emptied().with_points(some), rounds)  # type: ignore[misc]
        print(f"moments, {name}: {N_POINTS / took / 1e6:.0f} M points/s")
    print(f"summed-area table: {1e3 * cpu_s(grid.summed_areas, rounds):.1f} ms")
    table = grid.summed_areas()
    inside = [points[(np.abs(points[:, :2] - i - 0.5) <= 0.5).all(axis=1)] for i in range(20)]
    columns = [(np.column_stack([np.ones(len(some)), some[:, :2]]), some[:, 2]) for some in inside]

    def peer() -> None:
        for k in range(N_LSTSQ):
            np.linalg.lstsq(*columns[k % 20], rcond=None)

    theirs = cpu_s(peer, rounds) / N_LSTSQ
    for reach in (0, 1, 5, 20):
        ours = cpu_s(lambda reach=reach: grid.planes(reach, table=table), rounds) / SIDE**2  # type: ignore[misc]
        print(
            f"planes of windows of {2 * reach + 1}²: {1e9 * ours:.1f} ns a fit; {theirs / ours:.0f} × lstsq per patch"
        )
    print(f"lstsq per patch: {1e6 * theirs:.1f} µs")


def smrf_alone(points: NDArray[Any]) -> BoolArray:
    """Return which points (n,) are ground by SMRF that continues the borders, without the steps after it."""
    with patch.object(ground, "given_back", lambda _, taken, *__: (np.zeros_like(taken), np.zeros_like(taken))):
        return find_ground(points, SMRF).is_ground


def samples(rounds: int = 5) -> None:
    """Print how the ground of the ISPRS samples agrees with that found by hand, and how long it takes."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")) / "pointclouds"
    names = sorted(path.name[:6] for path in folder.glob("samp??-utm.pcd"))
    if not names:
        print("samp*-utm.pcd: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
        return
    clouds = []
    for name in names:
        cloud, truth = (read_cloud(folder / f"{name}-utm{end}.pcd").points for end in ("", "-ground"))
        places = set(map(tuple, truth.tolist()))
        clouds.append((name, cloud, np.array([tuple(place) in places for place in cloud.tolist()])))
    _print_agreement(clouds, rounds)
    left_out(clouds)


def left_out(clouds: Sequence[tuple[str, NDArray[Any], BoolArray]]) -> None:
    """Print the kappa of each sample with the values that the others choose by their mean, beside the first values'."""
    kappas = np.array(
        [
            [agreement(find_ground(cloud, config).is_ground, truth)["kappa"] for _, cloud, truth in clouds]
            for config in VALUES
        ]
    )
    first = kappas[VALUES.index(GroundConfig())]
    print("\n| left out | slope | local slope | height | kappa with them | with the first values |")
    print(f"|{'---|' * 6}")
    found = []
    for k, (name, _, _) in enumerate(clouds):
        chosen = int(np.delete(kappas, k, axis=1).mean(axis=1).argmax())
        found.append(kappas[chosen, k])
        of = VALUES[chosen]
        print(f"| {name} | {of.slope} | {of.local_slope} | {of.height} | {found[-1]:.1f} | {first[k]:.1f} |")
    best = kappas.mean(axis=1).max()
    print(f"mean {np.mean(found):.1f}, with the first values {first.mean():.1f}, chosen by all {best:.1f}")


def simulated(seeds: int = 3, rounds: int = 2) -> None:
    """Print how the ground of simulated clouds agrees with what they were made of: ``seeds`` clouds of each scene."""
    _print_agreement(
        ((f"{name}, {seed}", *labelled_cloud(name, seed)) for name in SCENES for seed in range(seeds)), rounds
    )


def _print_agreement(samples: Iterable[tuple[str, NDArray[Any], BoolArray]], rounds: int) -> None:
    """Print a table of clouds: name, points (n, 3), which of them are ground."""
    columns = (
        "cloud", "points", "kappa of SMRF alone", "kappa", "total error", "type I", "type II", "unsure",
        "wrong of unsure", "wrong of sure", "ms",
    )  # fmt: skip
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    kappas, alone = [], []
    for name, cloud, truth in samples:
        found = find_ground(cloud)
        right = agreement(found.is_ground, truth)
        kappas.append(right["kappa"])
        alone.append(agreement(smrf_alone(cloud), truth)["kappa"])
        took = cpu_s(lambda cloud=cloud: find_ground(cloud), rounds)  # type: ignore[misc]
        values = " | ".join(f"{right[key]:.1f}" for key in ("kappa", "total_error", "type_1", "type_2"))
        is_wrong, unsure = found.is_ground != truth, found.is_unsure
        shares = " | ".join(f"{100 * some.mean():.1f}" for some in (unsure, is_wrong[unsure], is_wrong[~unsure]))
        print(f"| {name} | {len(cloud)} | {alone[-1]:.1f} | {values} | {shares} | {1e3 * took:.1f} |", flush=True)
    for what, some in (("SMRF alone", alone), ("with all steps", kappas)):
        print(f"{what}: mean kappa {np.mean(some):.1f}, least {min(some):.1f}")
    print("shares in percent, ms of processor time")


def terrain() -> None:
    """Print all of the above."""
    patches()
    samples()
    simulated()
