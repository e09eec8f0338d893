"""Monte Carlo localization: the time of an update beside plain NumPy, and how often the robot is found.

Maps of real logs are made along corrected poses; what is localized is the raw log with its raw odometry. Each seed
begins at another scan: without a hint in the first half of the log, to its end; or kidnapped, which is 40 scans from
somewhere in the first third and then 150 from somewhere in the second, with odometry that does not notice. In the
lab's worlds each seed is another drive. A robot is found if over the last ten scans the filter has converged and the
median error is below 1 m and 15°. Wean Hall has no corrected poses: there the errors are those to the median of all
seeds at the log's end.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from mapper.core.parallel import single_threaded
from mapper.core.se2 import between_one, compose, inverse, wrap_angle
from mapper.grid import OccupancyGrid
from mapper.io.logs import open_log
from mapper.io.maps import load_map
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.estimate import find_clusters
from mapper.localization.map_model import MapModel, map_model
from mapper.localization.motion import anywhere, motion_between, move
from mapper.localization.resample import resampled
from mapper.localization.scan_beams import ScanBeams, limits_of, scan_beams
from mapper.localization.weighing import log_likelihoods, normalised, scan_sums
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from mapper.simulation.sample import sample_log
from tests.bench.peer import PeerAbsentError, build_mrpt_localizer

LOGS = ("intel", "fhw", "aces")
WORLDS = ("room", "office", "loop", "hall", "maze")
FOUND_M, FOUND_RAD, LAST = 1.0, math.radians(15.0), 10


@dataclass(frozen=True)
class Run:
    """One run: errors (n, 2) of the estimates in m and rad, and where the filter had converged (n,)."""

    errors: np.ndarray
    is_converged: np.ndarray

    @property
    def is_found(self) -> bool:
        off, turned = np.median(self.errors[-LAST:], axis=0)
        return bool(off < FOUND_M and turned < FOUND_RAD and self.is_converged[-LAST:].mean() > 0.5)

    @property
    def first_found(self) -> int:
        """The first scan of five in a row that are right."""
        right = (self.errors[:, 0] < FOUND_M) & (self.errors[:, 1] < FOUND_RAD)
        rows = np.flatnonzero(np.convolve(right, np.ones(5), "valid") > 4.5)
        return int(rows[0]) if len(rows) else len(right)


def follow(robot: MonteCarloLocalizer, log: ScanLog, scans: range, odometry: np.ndarray, true: np.ndarray) -> Run:
    errors, converged = np.empty((len(scans), 2)), np.zeros(len(scans), dtype=bool)
    for k, i in enumerate(scans):
        found = robot.update(odometry[i], log.scan(i))
        off = found.pose - true[i]
        errors[k] = math.hypot(off[0], off[1]), abs(float(wrap_angle(off[2])))
        converged[k] = found.is_converged
    return Run(errors, converged)


def globally(log: ScanLog, model: MapModel, odometry: np.ndarray, true: np.ndarray, seed: int) -> Run:
    start = int(np.random.default_rng(seed).integers(0, log.n_scans // 2))
    robot = MonteCarloLocalizer(model, range_min=log.range_min, range_max=log.range_max, mount=log.mount, seed=seed)
    return follow(robot, log, range(start, log.n_scans), odometry, true)


def kidnapped(log: ScanLog, model: MapModel, odometry: np.ndarray, true: np.ndarray, seed: int) -> Run:
    n, rng = log.n_scans, np.random.default_rng(1000 + seed)
    first, second = int(rng.integers(0, n // 3 - 40)), int(rng.integers(n // 3, 2 * n // 3))
    robot = MonteCarloLocalizer(
        model, range_min=log.range_min, range_max=log.range_max, mount=log.mount, seed=seed, initial_pose=true[first]
    )
    follow(robot, log, range(first, first + 40), odometry, true)
    unnoticed = compose(compose(odometry[first + 39], inverse(odometry[second])), odometry)
    return follow(robot, log, range(second, min(second + 150, n)), unnoticed, true)


def table_row(name: str, runs: list[Run]) -> str:
    found = [run for run in runs if run.is_found]
    firsts = [run.first_found for run in found]
    errors = np.concatenate([run.errors[run.first_found :] for run in found]) if found else np.full((1, 2), np.nan)
    lost = [str(seed) for seed, run in enumerate(runs) if not run.is_found]
    return (
        f"| {name} | {len(found)} of {len(runs)} | {np.median(firsts) if firsts else math.nan:.0f}, "
        f"{np.quantile(firsts, 0.95) if firsts else math.nan:.0f} | {np.median(errors[:, 0]):.3f} m, "
        f"{math.degrees(np.median(errors[:, 1])):.2f}° | {', '.join(lost) or '–'} |"
    )


def mapped(log: ScanLog, trajectory: str | None = None) -> OccupancyGrid:
    config = MappingConfig()
    grid = grid_for(log, config, trajectory)
    integrate_log(grid, log, config, trajectory)
    return grid


def model_for(grid: OccupancyGrid, log: ScanLog) -> MapModel:
    config = LocalizationConfig()
    return map_model(grid, config, limits_of(config, log.range_min, log.range_max)[1])


def success(folder: Path, seeds: int) -> None:
    """Print a row for each map, without a hint and kidnapped."""
    columns = "place", "found", "scans until found (median, 95 %)", "error from then (median)", "seeds not found"
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for name in LOGS:
        paths = [folder / "carmen" / f"{name}{ending}.log.gz" for ending in ("", "-corrected")]
        if not all(path.is_file() for path in paths):
            print(f"{name}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
            continue
        raw, corrected = (open_log(path) for path in paths)
        model, odometry, true = model_for(mapped(corrected), raw), raw.trajectory().poses, corrected.trajectory().poses
        for what, one in (("without a hint", globally), ("kidnapped", kidnapped)):
            print(table_row(f"{name}, {what}", [one(raw, model, odometry, true, k) for k in range(seeds)]), flush=True)
    for name in WORLDS:
        first_drive = sample_log(300, name, 0)
        model = model_for(mapped(sample_log(600, name, 1_000_000), "true"), first_drive)
        runs: dict[str, list[Run]] = {"without a hint": [], "kidnapped": []}
        for seed in range(seeds):
            drive = sample_log(300, name, seed)
            poses = drive.trajectory("odometry").poses, drive.trajectory("true").poses
            runs["without a hint"].append(globally(drive, model, *poses, seed))
            runs["kidnapped"].append(kidnapped(drive, model, *poses, seed))
        for what, these in runs.items():
            print(table_row(f"the lab's {name}, {what}", these), flush=True)
    wean(folder / "mcl", seeds)


def wean(folder: Path, seeds: int) -> None:
    paths = folder / "robotdata1.log.gz", folder / "wean.dat.gz"
    if not all(path.is_file() for path in paths):
        print("mcl: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
        return
    log, grid = open_log(paths[0]), load_map(paths[1]).grid
    model = model_for(grid, log)
    found = [localize_log(log, model, seed=seed) for seed in range(seeds)]
    middle = np.median(np.stack([one.poses for one in found]), axis=0)
    heading = np.stack([np.exp(1j * one.poses[:, 2]) for one in found])
    middle[:, 2] = np.angle(np.median(heading.real, axis=0) + 1j * np.median(heading.imag, axis=0))
    runs = []
    for one in found:
        off = one.poses - middle
        errors = np.column_stack([np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))])
        runs.append(Run(errors, one.is_converged))
    fit = float(np.median([one.fit[-100:].mean() for one in found]))
    print(table_row(f"Wean Hall, without a hint (fit {fit:.2f})", runs), flush=True)


def plain_update(
    model: MapModel, scan: ScanBeams, particles: np.ndarray, motion: tuple[float, ...], rng: np.random.Generator
) -> np.ndarray:
    """The same update in plain NumPy: motion, likelihood field, low-variance resampling."""
    turn_1, distance, turn_2, s1, sd, s2 = motion[:6]
    n = len(particles)
    a, d, b = (rng.normal(mean, sigma, n) for mean, sigma in ((turn_1, s1), (distance, sd), (turn_2, s2)))
    x = particles[:, 0] + d * np.cos(particles[:, 2] + a)
    y = particles[:, 1] + d * np.sin(particles[:, 2] + a)
    theta = particles[:, 2] + a + b
    c, s = np.cos(theta)[:, np.newaxis], np.sin(theta)[:, np.newaxis]
    ends_x = x[:, np.newaxis] + c * scan.points[:, 0] - s * scan.points[:, 1]
    ends_y = y[:, np.newaxis] + s * scan.points[:, 0] + c * scan.points[:, 1]
    u = np.floor((ends_x - model.geometry.origin[0]) / model.geometry.resolution).astype(np.int64)
    v = np.floor((ends_y - model.geometry.origin[1]) / model.geometry.resolution).astype(np.int64)
    inside = (u >= 0) & (u < model.geometry.cols) & (v >= 0) & (v < model.geometry.rows)
    scores = np.where(inside, model.field.field.scores[v * inside, u * inside], 0).sum(axis=1, dtype=np.int64)
    logs = model.field.log_weights(scores, len(scan.points))
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    drawn = np.searchsorted(np.cumsum(weights), (rng.random() + np.arange(n)) / n).clip(max=n - 1)
    out: np.ndarray = np.column_stack([x, y, theta])[drawn]
    return out


def best_ms(work: Callable[[], object], repeats: int) -> float:
    best = math.inf
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return 1e3 * best


def speed(folder: Path, rounds: int = 30) -> None:
    """Print the times of one update with 60 beams, ours and plain NumPy's in turns."""
    path = folder / "carmen" / "intel-corrected.log.gz"
    if path.is_file():
        log = open_log(path)
        grid, name = mapped(log), "Intel"
    else:
        log = sample_log(300)
        grid, name = mapped(log, "true"), "the lab's office"
    config = LocalizationConfig(resample_interval=1)
    model, pose = model_for(grid, log), log.trajectory().poses[100]
    scan = scan_beams(log.scan(100), log.mount, config)
    motion = motion_between(pose, np.add(pose, [0.2, 0.1, 0.05]), config)
    print(f"\n{name}, {len(scan.points)} end points a scan")
    columns = (
        "particles", "motion", "weights", "resampling", "whole update", "one thread", "plain NumPy", "ratio", "MRPT",
        "ratio of one thread", "clusters besides",
    )  # fmt: skip
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    rng = np.random.default_rng(1)
    for n, spread in ((2000, "near"), (100_000, "near"), (100_000, "everywhere")):
        particles = pose + rng.normal(0, [0.3, 0.3, 0.1], (n, 3)) if spread == "near" else anywhere(model, n, 5)
        flat = np.full(n, 1.0 / n)

        def moved(particles: np.ndarray = particles) -> np.ndarray:
            out = particles.copy()
            move(out, motion, 77)
            return out

        def weighed(particles: np.ndarray) -> np.ndarray:
            logs = log_likelihoods(model, scan, particles, scan_sums(model, scan, particles), config)
            return normalised(logs)

        fixed = LocalizationConfig(min_particles=n, max_particles=n)

        def whole(n: int = n, fixed: LocalizationConfig = fixed) -> np.ndarray:
            now = moved()
            return resampled(now, weighed(now), n, 0.4, fixed)

        weights = weighed(particles)
        steps: dict[str, Callable[[], object]] = {
            "motion": moved,
            "weights": partial(weighed, particles),
            "resampling": partial(resampled, particles, weights, n, 0.4, fixed),
            "whole": whole,
            "plain": partial(plain_update, model, scan, particles, tuple(motion), rng),
            "clusters": partial(find_clusters, particles, flat),
        }
        times = dict.fromkeys((*steps, "one thread", "mrpt"), math.inf)
        mrpt = mrpt_update(log, grid, scan, pose, particles)
        for _ in range(rounds):
            for step, work in steps.items():
                times[step] = min(times[step], best_ms(work, 3 if n < 10_000 else 1))
            with single_threaded():
                times["one thread"] = min(times["one thread"], best_ms(whole, 3 if n < 10_000 else 1))
            times["mrpt"] = min(times["mrpt"], mrpt())
        print(
            f"| {n:,} {spread} | {times['motion']:.3f} ms | {times['weights']:.3f} ms | {times['resampling']:.3f} ms | "
            f"{times['whole']:.3f} ms | {times['one thread']:.3f} ms | {times['plain']:.1f} ms | "
            f"{times['plain'] / times['whole']:.1f} × | {times['mrpt']:.1f} ms | "
            f"{times['mrpt'] / times['one thread']:.1f} × | {times['clusters']:.3f} ms |",
            flush=True,
        )


def mrpt_update(
    log: ScanLog, grid: OccupancyGrid, scan: ScanBeams, pose: np.ndarray, particles: np.ndarray
) -> Callable[[], float]:
    """Return a function that returns the milliseconds of the same update by MRPT; without MRPT it returns infinity.

    Its scan has the same end points, as beams at whole multiples of the log's step of bearings.
    """
    folder = Path(tempfile.mkdtemp())
    try:
        program = build_mrpt_localizer(folder)
    except PeerAbsentError as absent:
        print(f"MRPT: {absent}", file=sys.stderr)
        return lambda: math.inf
    bearings = scan.beams[:, 1] - log.mount[2]
    rows = np.rint((bearings - log.angle_min) / log.angle_increment).astype(int)
    ranges = np.where(scan.beams[:, 0] < scan.range_max, scan.beams[:, 0], 0.0)
    step = int(np.gcd.reduce(np.diff(rows)))
    beams = np.zeros((rows[-1] - rows[0]) // step + 1, dtype="<f4")
    beams[(rows - rows[0]) // step] = ranges
    geometry, moved = grid.geometry, tuple(np.add(pose, [0.2, 0.1, 0.05]).tolist())
    packed = folder / "update.bin"
    with packed.open("wb") as file:
        for values, kind in (
            (geometry.shape, "<i4"), ((geometry.resolution, *geometry.origin[:2]), "<f8"),
            (1.0 - grid.p_occ, "<f4"), (len(beams), "<i4"),
            ((log.angle_min + rows[0] * log.angle_increment, step * log.angle_increment, scan.range_max), "<f8"),
            (beams, "<f4"), (log.mount, "<f8"), (between_one(tuple(pose), moved), "<f8"),
            (len(particles), "<i4"), (particles, "<f8"), (3, "<i4"),
        ):  # fmt: skip
            file.write(np.asarray(values, dtype=kind).tobytes())

    def run() -> float:
        done = subprocess.run([str(program), str(packed)], capture_output=True, text=True, check=True)
        return float(done.stdout)

    return run


def localization() -> None:
    """Print the times of an update, and the table of success; GRIDBLOOM_SEEDS says of how many seeds (100)."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    speed(folder)
    success(folder, int(os.environ.get("GRIDBLOOM_SEEDS", "100")))
