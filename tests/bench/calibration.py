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

import numpy as np

from mapper.core.parallel import single_threaded
from mapper.core.se2 import wrap_angle
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.map_model import MapModel, map_model
from mapper.localization.scan_beams import limits_of
from tests.bench.calibration_drives import CASES, DRIVEN, Drive, Name, made, names, plan

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
    log, name = drive.log, drive.name
    model = _model(name.world, name.sensor, log.range_min, log.range_max)
    n = log.n_scans
    sure, deviation, poses = np.zeros(n, dtype=bool), np.empty(n), np.empty((n, 3))

    def watch(i: int, robot: MonteCarloLocalizer) -> None:
        found = robot.estimate
        sure[i], poses[i] = found.is_sure, found.pose
        deviation[i] = math.sqrt(float(np.linalg.eigvalsh(found.covariance[:2, :2])[-1]))

    found = localize_log(log, model, trajectory="odometry", initial_pose=drive.start, seed=name.seed, watch=watch)
    off = poses - log.trajectory("true").poses
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
    return (
        f"| {title} | {len(runs)} | "
        + " | ".join(_share(int((wrong & one).sum()), int(one.sum())) for one in said)
        + f" | {100.0 * (said[1] & right).sum() / max(right.sum(), 1):.0f} %"
        + f" | {100.0 * (said[2] & right).sum() / max(right.sum(), 1):.0f} %"
        + f" | {_share(sum(bool(run.is_wrong[-1]) for run in ends), len(ends))} |"
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
        "right ones that are sure", "in hindsight", "wrong and sure at the end",
    )  # fmt: skip
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for case in CASES:
        print(_row(case, [run for run in runs if run.name.case == case]))
    for world in DRIVEN:
        print(_row(f"in {world}", [run for run in runs if run.name.world == world]))
    print(_row("all", runs))
    _curve(runs)
    for run in runs:
        if count := int((run.is_wrong & run.sure).sum()):
            print(f"{', '.join(run.name.words)}, seed {run.name.seed}: wrong and sure at {count} scans")


def calibration() -> None:
    """Print the tables; GRIDBLOOM_DRIVES says of how many of the drives (all)."""
    every = list(names())
    count = int(os.environ.get("GRIDBLOOM_DRIVES", len(every)))
    # In an order by chance, so that some of them are of all kinds.
    order = np.random.default_rng(0).permutation(len(every))[:count]
    report(_runs([every[k] for k in order.tolist()]))
