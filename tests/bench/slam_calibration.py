"""How often SLAM is wrong and does not say so: a table over simulated drives, and a curve.

Poses are wrong whose mean distance from the true ones is above 0.5 m after a rigid alignment. SLAM doubts a map where a
note says that it may be wrong, that the scans do not determine how far the robot moved, or that scans fit nowhere. The
curve compares the drift of the walls, which the page and the command state of the map, with the error that there was.
"""

from __future__ import annotations

import itertools
import math
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from mapper.core.parallel import single_threaded
from mapper.core.se2 import compose, inverse
from mapper.diagnosis.figures import map_figures
from mapper.evaluation.alignment import align
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.lidar import RANGE_MIN
from mapper.simulation.odometry import drifting_odometry
from mapper.slam import slam_log
from tests.bench.calibration_drives import DRIVEN, ODOMETRY, SENSORS, Name, simulated
from tests.bench.disturbed_scans import crowded
from tests.bench.hard import WRONG_M

SCANS = 240  #: of a drive, 96 s
CASES = ("plain", "people", "kidnapped", "without wheels")
DOUBTS = ("may be wrong", "do not determine how far", "none of the scans before")  #: in SLAM's notes
DRIFTS = (0.0, 0.15, 0.2, 0.3, 0.5)  #: m: borders of the curve's rows


@dataclass(frozen=True)
class Told:
    """The error of the poses of a drive, metres, whether SLAM doubted them, and the drift that is stated, metres."""

    name: Name
    off: float
    doubts: bool
    drift: float | None

    @property
    def is_wrong(self) -> bool:
        return self.off > WRONG_M


def names(before: int = 0) -> Iterator[Name]:
    """Yield all combinations, those without wheels once. Their seeds are those after ``before``."""
    combinations = itertools.product(DRIVEN, SENSORS, CASES, ODOMETRY)
    for seed, (world, sensor, case, odometry) in enumerate(combinations, before + 1):
        if (case, odometry) != ("without wheels", "worn"):
            yield Name(world, sensor, odometry, case, seed)


def made(name: Name) -> ScanLog:
    """Return one drive with the trajectories "odometry", but for those without wheels, and "true"."""
    config, middle = SENSORS[name.sensor], SCANS // 2
    carried = [middle] if name.case == "kidnapped" else []
    poses, ranges, stamps = simulated(DRIVEN[name.world], config, name.seed, SCANS, carried=carried)
    wheels = drifting_odometry(poses, np.random.default_rng(name.seed), *ODOMETRY[name.odometry])
    for at in carried:  # the wheels do not notice
        wheels[at:] = compose(compose(wheels[at - 1], inverse(wheels[at])), wheels[at:])
    moved = {"odometry": Trajectory(wheels, "wheels", "odom"), "true": Trajectory(poses)}
    if name.case == "without wheels":
        moved = {"none": Trajectory(np.zeros_like(poses), is_placeholder=True), "true": Trajectory(poses)}
    log = ScanLog(ranges, config.angle_min, config.angle_increment, RANGE_MIN, config.range_max, stamps, moved)
    if name.case != "people":
        return log
    seen = crowded(replace(log, trajectories={"true": moved["true"]}), DRIVEN[name.world])
    return replace(log, ranges=seen.ranges)


def told(name: Name) -> Told:
    """Have SLAM find the poses of one drive."""
    with single_threaded():
        log = made(name)
        true = log.trajectory("true").poses
        given = {own: one for own, one in log.trajectories.items() if own != "true"}
        found = slam_log(replace(log, trajectories=given))
        off = np.hypot(*(align(true, found.poses).apply(found.poses) - true)[:, :2].T)
        healed = replace(log, trajectories={"SLAM": Trajectory(found.poses, from_scans=True)})
        drift = map_figures(healed, "SLAM", MappingConfig()).drift_m
    return Told(name, float(off.mean()), any(doubt in note for note in found.notes for doubt in DOUBTS), drift)


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100.0 * part / whole:.1f} %)" if whole else "–"


def _row(title: str, runs: list[Told]) -> str:
    wrong, sure = [run for run in runs if run.is_wrong], [run for run in runs if not run.doubts]
    right = [run for run in runs if not run.is_wrong]
    silent, doubted = sum(run.is_wrong for run in sure), sum(run.doubts for run in right)
    shares = _share(len(wrong), len(runs)), _share(silent, len(sure)), _share(doubted, len(right))
    return f"| {title} | {len(runs)} | {' | '.join(shares)} |"


def slam_calibration() -> None:
    """Print the tables; GRIDBLOOM_DRIVES says of how many drives (all), GRIDBLOOM_SEED the seed before the first's."""
    every = list(names(int(os.environ.get("GRIDBLOOM_SEED", "0"))))
    count = int(os.environ.get("GRIDBLOOM_DRIVES", len(every)))
    # In an order by chance, so that some of them are of all kinds.
    chosen = [every[k] for k in np.random.default_rng(0).permutation(len(every))[:count].tolist()]
    runs: list[Told] = []
    with ProcessPoolExecutor(os.cpu_count() or 1) as pool:
        for run in pool.map(told, chosen):
            runs.append(run)
            print(f"\r{len(runs)} of {len(chosen)}", end="", file=sys.stderr, flush=True)
    print("\n\n| | drives | wrong | wrong, of those not doubted | doubted, of the right ones |\n|---|---|---|---|---|")
    parts = {case: [run for run in runs if run.name.case == case] for case in CASES}
    parts |= {f"in {world}": [run for run in runs if run.name.world == world] for world in DRIVEN}
    parts |= {f"by {sensor}": [run for run in runs if run.name.sensor == sensor] for sensor in SENSORS}
    parts |= {"all but the kidnapped": [run for run in runs if run.name.case != "kidnapped"], "all": runs}
    for title, part in parts.items():
        if part:
            print(_row(title, part))
    print("\n| drift of the walls that is stated | drives | error, median | 95 % | wrong |\n|---|---|---|---|---|")
    for low, high in itertools.pairwise((*DRIFTS, math.inf)):
        here = [run for run in runs if run.drift is not None and low <= run.drift < high]
        if here:
            off = [run.off for run in here]
            title = f"{low:g} to {high:g} m" if math.isfinite(high) else f"over {low:g} m"
            print(
                f"| {title} | {len(here)} | {np.median(off):.2f} m | {np.quantile(off, 0.95):.2f} m | "
                f"{_share(sum(run.is_wrong for run in here), len(here))} |"
            )
    for run in runs:
        if run.is_wrong and not run.doubts:
            drift = "not measured" if run.drift is None else f"{run.drift:.2f} m"
            print(f"{', '.join(run.name.words)}, seed {run.name.seed}: {run.off:.2f} m off, drift {drift}, not doubted")
