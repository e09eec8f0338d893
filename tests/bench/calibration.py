"""How often a localization is wrong and says that it is sure: a table over simulated drives, and a curve.

A pose is wrong that is off by more than 1 m or 15°. "Converged" is that the particles agree on one place, "sure" that
other places were ruled out too; "in hindsight" is what the localization of a log says after its end. The curve compares
the stated standard deviation of the place with the error that there was.
"""

from __future__ import annotations

import itertools
import math
import os
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from mapper.core.parallel import single_threaded
from mapper.core.se2 import wrap_angle
from mapper.io.logs import open_log
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.map_model import MapModel, map_model
from mapper.localization.scan_beams import limits_of
from mapper.sensors.scan import ScanLog
from tests.bench.calibration_drives import CASES, DRIVEN, Drive, Name, made, names, plan
from tests.bench.localization import LOGS, mapped, model_for

WRONG_M, WRONG_RAD = 1.0, math.radians(15.0)
DEVIATIONS = (0.0, 0.1, 0.15, 0.25, 0.5, 1.0)  #: m: borders of the curve's rows


@dataclass(frozen=True)
class Told:
    """Of each scan of a drive (n,): errors in m and rad, what the filter said, and the deviation that it stated, m."""

    name: Name
    off: np.ndarray
    turned: np.ndarray
    converged: np.ndarray
    sure: np.ndarray
    in_hindsight: np.ndarray
    deviation: np.ndarray

    @property
    def is_wrong(self) -> np.ndarray:
        wrong: np.ndarray = (self.off > WRONG_M) | (self.turned > WRONG_RAD)
        return wrong


@cache
def _model(world: str, sensor: str, range_min: float, range_max: float) -> MapModel:
    config = LocalizationConfig()
    return map_model(plan(world, sensor), config, limits_of(config, range_min, range_max)[1])


def told(name: Name) -> Told:
    """Localize one drive."""
    with single_threaded():
        return _told(made(name))


def _told(drive: Drive) -> Told:
    name, log = drive.name, drive.log
    model = _model(name.world, name.sensor, log.range_min, log.range_max)
    return _of_log(name, log, model, "odometry", log.trajectory("true").poses, drive.start)


def _of_log(
    name: Name, log: ScanLog, model: MapModel, odometry: str | None, true: np.ndarray, start: np.ndarray | None
) -> Told:
    n = log.n_scans
    sure, deviation, poses = np.zeros(n, dtype=bool), np.empty(n), np.empty((n, 3))

    def watch(i: int, robot: MonteCarloLocalizer) -> None:
        found = robot.estimate
        sure[i], poses[i] = found.is_sure, found.pose
        deviation[i] = math.sqrt(float(np.linalg.eigvalsh(found.covariance[:2, :2])[-1]))

    found = localize_log(log, model, trajectory=odometry, initial_pose=start, seed=name.seed, watch=watch)
    off = poses - true
    return Told(
        name, np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2])), found.is_converged, sure, found.is_sure,
        deviation,
    )  # fmt: skip


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100.0 * part / whole:.1f} %)" if whole else "–"


def _row(title: str, runs: list[Told]) -> str:
    wrong = np.concatenate([run.is_wrong for run in runs])
    said = [np.concatenate([getattr(run, what) for run in runs]) for what in ("converged", "sure", "in_hindsight")]
    right = said[0] & ~wrong
    ends = [run for run in runs if run.sure[-1]]
    first = np.median([int(run.sure.argmax()) if run.sure.any() else len(run.sure) for run in runs])
    return (
        f"| {title} | {len(runs)} | "
        + " | ".join(_share(int((wrong & one).sum()), int(one.sum())) for one in said)
        + f" | {100.0 * (said[1] & right).sum() / max(right.sum(), 1):.0f} %"
        + f" | {100.0 * (said[2] & right).sum() / max(right.sum(), 1):.0f} %"
        + f" | {_share(sum(bool(run.is_wrong[-1]) for run in ends), len(ends))} | {first:g} |"
    )


def _curve(runs: list[Told]) -> None:
    """Print the stated standard deviations beside the errors of the sure estimates."""
    sure, off, deviation = (
        np.concatenate([getattr(run, what) for run in runs]) for what in ("sure", "off", "deviation")
    )
    print("\n| stated standard deviation | scans | error, root mean square | median | 95 % | within 1 m |")
    print("|---|---|---|---|---|---|")
    for low, high in itertools.pairwise((*DEVIATIONS, math.inf)):
        here = off[sure & (deviation >= low) & (deviation < high)]
        if len(here):
            title = f"{low:g} to {high:g} m" if math.isfinite(high) else f"over {low:g} m"
            print(
                f"| {title} | {len(here)} | {math.sqrt(float(np.mean(here**2))):.2f} m | {np.median(here):.2f} m | "
                f"{np.quantile(here, 0.95):.2f} m | {100.0 * (here < WRONG_M).mean():.1f} % |"
            )


def _runs(chosen: list[Name]) -> Iterator[Told]:
    processes = os.cpu_count() or 1
    with ProcessPoolExecutor(processes) as pool:
        for count, one in enumerate(pool.map(told, chosen), 1):
            print(f"\r{count} of {len(chosen)}", end="", file=sys.stderr, flush=True)
            yield one
    print(file=sys.stderr)


def report(runs: Iterable[Told]) -> None:
    """Print the tables."""
    runs = list(runs)
    columns = (
        "", "drives", "wrong, of converged scans", "wrong, of sure scans", "wrong, of those sure in hindsight",
        "right ones that are sure", "in hindsight", "wrong and sure at the end", "median of the first sure scan",
    )  # fmt: skip
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    parts = {case: [run for run in runs if run.name.case == case] for case in CASES}
    parts |= {f"in {world}": [run for run in runs if run.name.world == world] for world in DRIVEN}
    parts |= {"all but the changed": [run for run in runs if run.name.case != "changed"], "all": runs}
    for title, part in parts.items():
        if part:
            print(_row(title, part))
    _curve(runs)
    for run in runs:
        if count := int((run.is_wrong & run.sure).sum()):
            print(f"{', '.join(run.name.words)}, seed {run.name.seed}: wrong and sure at {count} scans")


def _real_logs(seeds: int) -> Iterator[list[Told]]:
    """Yield, for each real log that is there, runs without a hint that begin somewhere in its first half."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")) / "carmen"
    for name in LOGS if seeds else ():
        paths = [folder / f"{name}{ending}.log.gz" for ending in ("", "-corrected")]
        if not all(path.is_file() for path in paths):
            print(f"{name}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
            continue
        raw, corrected = (open_log(path) for path in paths)
        model, true, runs = model_for(mapped(corrected), raw), corrected.trajectory().poses, []
        for seed in range(seeds):
            start = int(np.random.default_rng(seed).integers(0, raw.n_scans // 2))
            part = raw.take(slice(start, raw.n_scans))
            runs.append(_of_log(Name(name, "", "", "anywhere", seed), part, model, None, true[start:], None))
        yield runs


def calibration() -> None:
    """Print the tables; GRIDBLOOM_DRIVES says of how many drives (all), GRIDBLOOM_SEEDS how often each real log (5).

    GRIDBLOOM_SEED is that before the first drive's (0): with another one all drives are others.
    """
    every = list(names(int(os.environ.get("GRIDBLOOM_SEED", "0"))))
    count = int(os.environ.get("GRIDBLOOM_DRIVES", len(every)))
    # In an order by chance, so that some of them are of all kinds.
    order = np.random.default_rng(0).permutation(len(every))[:count]
    if len(order):
        report(_runs([every[k] for k in order.tolist()]))
    for runs in _real_logs(int(os.environ.get("GRIDBLOOM_SEEDS", "5"))):
        print(_row(runs[0].name.world, runs), flush=True)
