"""The doctor's drift finding on logs of which it is known whether their walls are double: true and false positives.

Known are: the logs of the test data with raw odometry and with poses that a SLAM program has corrected, simulated logs
with their true poses, and both with drift added, where the true poses say by how much walls are displaced.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.diagnosis import drift_finding
from mapper.diagnosis.finding import POSSIBLE
from mapper.io.logs import open_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import WORLDS, Simulation, World, sample_log
from mapper.simulation.lidar import RANGE_MIN
from mapper.simulation.odometry import ALPHAS, TURN_BIAS, drifting_odometry
from mapper.simulation.sample import SAMPLE_SENSOR
from tests.bench.disturbed_scans import crowded, polished

DOUBLE_M, SINGLE_M = 0.3, 0.15  #: walls that are farther apart than the one are double, nearer than the other single
REVISIT_M = 5.0  #: two scans from places nearer than this see the same walls
SCALES = (0.25, 0.5, 1.0, 2.0, 4.0)  #: of the drift that is added
SEEDS = (1, 2, 3)
REAL = {  # log, trajectory, are walls double
    ("carmen/intel-corrected.log.gz", "scan"): False,
    ("carmen/aces-corrected.log.gz", "scan"): False,
    ("carmen/fhw-corrected.log.gz", "scan"): False,
    ("carmen/intel-robotlaser.log.gz", "scan"): False,
    ("sonar", "exact"): False,
    ("carmen/intel.log.gz", "scan"): True,
    ("carmen/intel_merged.log.gz", "scan"): True,
    ("carmen/intel-corrected.log.gz", "wheel"): True,
    ("carmen/aces.log.gz", "scan"): True,
    ("carmen/aces-corrected.log.gz", "wheel"): True,
    ("carmen/fhw.log.gz", "scan"): True,
    ("carmen/fhw-corrected.log.gz", "wheel"): True,
    ("carmen/loop5.log.gz", "scan"): True,
    ("breezyslam/exp1.dat.gz", "wheel"): True,
}


@dataclass(frozen=True, slots=True)
class Case:
    """A log with one trajectory of which it is known whether its walls are ``double``."""

    group: str
    name: str
    log: ScanLog
    trajectory: str
    double: bool


@dataclass(frozen=True, slots=True)
class Judged:
    """Verdict of the doctor: ``sure`` is None where it found no drift."""

    case: Case
    sure: float | None


def displaced(true: NDArray[np.float64], poses: NDArray[np.float64]) -> bool | None:
    """Return whether ``poses`` (n, 3) draw walls double where ``true`` (n, 3) draws them once.

    At each revisit, two scans at least an eighth of the log apart, the errors of the two poses put one point into two
    places. Double: a quarter of the revisits by more than :data:`DOUBLE_M`; single: at most one in fifty by more than
    :data:`SINGLE_M`; None for what lies between, and without revisits.
    """
    n = len(true)
    chosen = np.unique(np.linspace(0, n - 1, min(n, 400)).astype(int))
    error = compose(poses[chosen], inverse(true[chosen]))
    at = true[chosen]
    i, j = np.triu_indices(len(chosen), len(chosen) // 8)
    close = np.hypot(*(at[i, :2] - at[j, :2]).T) < REVISIT_M
    i, j = i[close], j[close]
    if len(i) < 20:
        return None
    place = np.concatenate([at[j, :2], np.zeros((len(j), 1))], axis=1)
    apart = np.hypot(*(compose(error[i], place) - compose(error[j], place))[:, :2].T)
    if np.mean(apart > DOUBLE_M) >= 0.25:
        return True
    return False if np.mean(apart > SINGLE_M) <= 0.02 else None


def part(log: ScanLog, trajectory: str, start: int, stop: int) -> ScanLog:
    """Return some scans of a log with one trajectory."""
    some = log.take(slice(start, stop))
    return replace(some, trajectories={trajectory: Trajectory(some.trajectory(trajectory).poses)})


def drifted(group: str, log: ScanLog, trajectory: str) -> Iterator[Case]:
    """Yield a log of which the poses are right with drift added to them."""
    true = log.trajectory(trajectory).poses
    for scale in SCALES:
        for seed in SEEDS:
            alphas = (ALPHAS[0] * scale, ALPHAS[1] * scale, ALPHAS[2] * scale, ALPHAS[3] * scale)
            poses = drifting_odometry(true, np.random.default_rng(seed), alphas, TURN_BIAS * scale)
            double = displaced(true, poses)
            if double is not None:
                bad = replace(log, trajectories={"drifted": Trajectory(poses)})
                yield Case(group, f"{log.name}, drift × {scale:g}, seed {seed}", bad, "drifted", double)


def disturbed(log: ScanLog, trajectory: str) -> Iterator[Case]:
    """Yield a log of which the poses are right with people before the sensor, and with poses that tremble."""
    random = np.random.default_rng(8)
    group = "single walls, disturbed"
    short = random.random(log.ranges.shape) < 0.1
    nearer = np.where(short, np.minimum(log.ranges, 20.0) * random.uniform(0.2, 0.95, short.shape), log.ranges)
    people = replace(log, ranges=nearer.astype(np.float32))
    yield Case(group, f"{log.name}, 10 % of the readings short", people, trajectory, double=False)
    true = log.trajectory(trajectory).poses
    trembling = compose(true, random.normal(0.0, (0.03, 0.03, np.radians(0.3)), true.shape))
    shaken = replace(log, trajectories={"trembling": Trajectory(trembling)})
    yield Case(group, f"{log.name}, poses that tremble", shaken, "trembling", double=False)


def refurnished(world: World, seed: int) -> Case:
    """Return a simulated log with true poses in which four tables change their places half-way."""
    random = np.random.default_rng(seed)
    simulation = Simulation(world, SAMPLE_SENSOR, seed)
    taken = []
    for _ in range(2):
        now = world
        while len(now.solids) < len(world.solids) + 4:
            x, y = random.uniform(world.bounds[:2], world.bounds[2:])
            if now.clearance(np.array([[x, y]]))[0] > 0.8:
                table = np.array([[x, y], [x + 0.8, y], [x + 0.8, y + 0.5], [x, y + 0.5]]) - (0.4, 0.25)
                now = World(world.name, world.title, world.bounds, (*now.solids, table), world.start)
        simulation.alter_world(now)
        taken += simulation.advance(120.0)
    log = ScanLog(
        np.array([scan.ranges for scan, _ in taken]),
        SAMPLE_SENSOR.angle_min,
        SAMPLE_SENSOR.angle_increment,
        RANGE_MIN,
        SAMPLE_SENSOR.range_max,
        np.array([scan.stamp_ns for scan, _ in taken]),
        {"true": Trajectory(np.array([pose for _, pose in taken]))},
    )
    return Case("single walls, disturbed", f"{world.name}, four tables moved", log, "true", double=False)


def real_cases(data: Path) -> Iterator[Case]:
    """Yield the logs of the test data; the halves of the corrected ones; and these with drift added."""
    for (name, trajectory), double in REAL.items():
        log = open_log(data / name)
        yield Case("real logs", f"{name} {trajectory}", log, trajectory, double)
        if double or log.beam_width:
            continue
        middle = log.n_scans // 2
        for half in (part(log, trajectory, 0, middle), part(log, trajectory, middle, log.n_scans)):
            yield Case("halves of real logs", f"half of {name}", half, trajectory, double=False)
        yield from drifted("real logs with drift added", log, trajectory)
        yield from disturbed(log, trajectory)


def simulated_cases() -> Iterator[Case]:
    """Yield logs of every world with true poses, and with drift added."""
    for world in sorted(WORLDS):
        yield refurnished(WORLDS[world], 3)
        for n, seed in ((300, 5), (900, 6)):
            log = replace(sample_log(n, world, seed), name=f"{world}, {n} scans")
            yield Case("simulated logs", log.name, log, "true", double=False)
            yield from drifted("simulated logs with drift added", log, "true")
            yield from disturbed(log, "true")
            for what, change in (("polished walls", polished), ("people who walk about", crowded)):
                changed = change(log, WORLDS[world])
                yield Case("single walls, disturbed", f"{log.name}, {what}", changed, "true", double=False)


def judged(case: Case) -> Judged:
    """Have the doctor look at a case."""
    finding = drift_finding(case.log, case.trajectory, MappingConfig())
    return Judged(case, None if finding is None else finding.sure)


def table(results: Sequence[Judged]) -> str:
    """Return the confusion table in Markdown: for each group of logs what was found, and how surely."""
    columns = (
        "logs", "double walls", "found", "of these possible", "missed", "single walls", "found in error",
        "of these possible",
    )  # fmt: skip
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    groups = list(dict.fromkeys(one.case.group for one in results))
    for group in [*groups, "all"]:
        numbers: list[int] = []
        for double in (True, False):
            those = [one for one in results if one.case.double == double and group in (one.case.group, "all")]
            found = [one.sure for one in those if one.sure is not None]
            numbers += [len(those), len(found), sum(sure < POSSIBLE for sure in found)]
            numbers += [len(those) - len(found)] if double else []
        lines.append(f"| {group} | {' | '.join(map(str, numbers))} |")
    return "\n".join(lines)


def calibration(results: Sequence[Judged]) -> str:
    """Return in Markdown how often drift that was stated with some confidence was there."""
    lines = ["| stated confidence | findings | true |", "|---|---|---|"]
    for low, high in pairwise((0.0, 0.35, 0.5, POSSIBLE, 0.9, 1.0)):
        those = [one for one in results if one.sure is not None and low <= one.sure < high]
        if those:
            true = sum(one.case.double for one in those)
            lines.append(f"| {100 * low:.0f} … {100 * high:.0f} % | {len(those)} | {true} |")
    return "\n".join(lines)


def single_logs(results: Sequence[Judged]) -> str:
    """Return in Markdown what was found in each real log as it was recorded or corrected."""
    lines = ["| log | walls | drift found |", "|---|---|---|"]
    for one in results:
        if one.case.group == "real logs":
            said = "–" if one.sure is None else f"{100 * one.sure:.0f} %"
            lines.append(f"| {one.case.name} | {'double' if one.case.double else 'single'} | {said} |")
    return "\n".join(lines)


def doctor() -> None:
    """Print the tables of docs/doctor.md."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    real: Iterable[Case] = ()
    if folder.is_dir():
        real = real_cases(folder)
    else:
        print("The real logs are left out: GRIDBLOOM_TEST_DATA names no folder.", file=sys.stderr)
    results = [judged(case) for case in chain(real, simulated_cases())]
    print(table(results), calibration(results), single_logs(results), sep="\n\n")
