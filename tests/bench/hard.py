"""SLAM of simulated logs that are made hard: the error of the poses, and what SLAM says of them.

The error is the mean and the greatest distance from the true poses after a rigid alignment. A result whose mean error
is above 0.5 m is wrong; it is silent if SLAM says nothing that it does not say of the log with nothing hard.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mapper.core.se2 import compose, inverse
from mapper.evaluation.alignment import align
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.shapes import outer_walls
from mapper.simulation.worlds import World
from mapper.slam import slam_log
from tests.mapper.localization.rooms import OFFICE_WAY
from tests.mapper.slam.worlds import along, drive, without_poses

WRONG_M = 0.5
SEEDS = (1, 2, 3)
SENSOR = SensorConfig(n_beams=180, field_of_view=1.5 * math.pi, range_max=8.0, range_noise=0.02)
SHORT = replace(SENSOR, range_max=5.0)
PLAIN = World(
    "plain", "A corridor without features", (0.0, 0.0, 60.0, 2.4), tuple(outer_walls(0.0, 0.0, 60.0, 2.4, 0.2)),
    (3.0, 1.2, 0.0),
)  # fmt: skip
CABIN = World("cabin", "A lift", (0.0, 0.0, 2.2, 2.2), tuple(outer_walls(0.0, 0.0, 2.2, 2.2, 0.2)), (1.1, 1.1, 0.0))
ROUND = [*OFFICE_WAY, (2.5, 7.0), (6.2, 7.0), (14.0, 7.0)]


def _office(step: float = 0.25, sensor: SensorConfig = SENSOR, seed: int = 1) -> ScanLog:
    return drive("office", along(ROUND, step), sensor=sensor, turn_bias=0.01, seed=seed)


def _with_wheels(log: ScanLog, change: Callable[[np.ndarray], None]) -> ScanLog:
    """Return a log with its odometry's steps (n - 1, 3) changed."""
    odometry = log.trajectory("odometry").poses
    steps = compose(inverse(odometry[:-1]), odometry[1:])
    change(steps)
    poses = [odometry[0]]
    for step in steps:
        poses.append(compose(poses[-1], step))
    wheels = Trajectory(np.array(poses), "wheels", "odom")
    return replace(log, trajectories={**log.trajectories, "odometry": wheels})


def _joined(first: ScanLog, second: ScanLog) -> ScanLog:
    """Return two logs as one: the odometry goes on from the end of the first as if nothing had happened."""
    stamps = np.concatenate([first.stamps_ns, second.stamps_ns + first.stamps_ns[-1] + 100_000_000])
    before, after = first.trajectory("odometry").poses, second.trajectory("odometry").poses
    wheels = np.concatenate([before, compose(before[-1], compose(inverse(after[0]), after))])
    true = np.concatenate([first.trajectory("true").poses, second.trajectory("true").poses])
    return replace(
        first, ranges=np.concatenate([first.ranges, second.ranges]), stamps_ns=stamps,
        trajectories={"odometry": Trajectory(wheels, "wheels", "odom"), "true": Trajectory(true)},
    )  # fmt: skip


def corridor(seed: int) -> ScanLog:
    """There and back along a plain corridor of 60 m."""
    return drive(PLAIN, along([(3.0, 1.2), (57.0, 1.2), (3.0, 1.2)]), sensor=SENSOR, turn_bias=0.0, seed=seed)


def floors(seed: int) -> ScanLog:
    """The same plan on two floors, of which the second is 40 m aside in the true poses; between them a lift."""
    first, second = _office(seed=seed), _office(seed=100 + seed)
    aside = np.add(second.trajectory("true").poses, [40.0, 0.0, 0.0])
    return _joined(
        _joined(first, _lift(seed)), replace(second, trajectories={**second.trajectories, "true": Trajectory(aside)})
    )


def _lift(seed: int) -> ScanLog:
    return drive(CABIN, np.tile([1.1, 1.1, 0.0], (40, 1)), sensor=SENSOR, turn_bias=0.0, seed=seed)


def lift(seed: int) -> ScanLog:
    """An office, a cabin whose walls are all that is seen, and a hall on another floor."""
    hall = drive(
        "hall", along([(4.0, 4.0), (14.0, 4.0), (14.0, 8.0), (4.0, 8.0), (4.0, 4.0)]), sensor=SENSOR, seed=seed
    )
    end = _office(seed=seed).trajectory("true").poses[-1]
    shifted = compose(compose(end, inverse(hall.trajectory("true").poses[0])), hall.trajectory("true").poses)
    hall = replace(hall, trajectories={**hall.trajectories, "true": Trajectory(shifted)})
    cabin = _lift(seed)
    cabin = replace(cabin, trajectories={**cabin.trajectories, "true": Trajectory(np.tile(end, (40, 1)))})
    return _joined(_joined(_office(seed=seed), cabin), hall)


def glass(seed: int) -> ScanLog:
    """Half of the readings of a room's pillars and of one of its walls go through."""
    rng = np.random.default_rng(seed)
    path = along(ROUND)
    whole = drive("office", path, sensor=SENSOR, turn_bias=0.01, seed=seed)
    office = WORLDS["office"]
    solids = [solid for k, solid in enumerate(office.solids) if k < 4 or k % 3]
    through = drive(replace(office, solids=tuple(solids)), path, sensor=SENSOR, turn_bias=0.01, seed=seed)
    goes = rng.random(whole.ranges.shape) < 0.7
    return replace(whole, ranges=np.where(goes, through.ranges, whole.ranges))


def crowd(seed: int) -> ScanLog:
    """People stand in the way of 30 % of the beams, six neighbouring beams each, elsewhere in each scan."""
    rng, log = np.random.default_rng(seed), _office(seed=seed)
    ranges = log.ranges.copy()
    for scan in ranges:
        for first in rng.choice(len(scan) - 6, size=int(0.3 * len(scan) / 6), replace=False):
            scan[first : first + 6] = np.minimum(scan[first : first + 6], rng.uniform(0.5, 3.0))
    return replace(log, ranges=ranges)


def slip(seed: int) -> ScanLog:
    """Wheels slip six times: the robot stands while they turn for 1.2 m."""
    rng = np.random.default_rng(seed)

    def change(steps: np.ndarray) -> None:
        for at in rng.choice(len(steps), size=6, replace=False):
            steps[at, 0] += 1.2

    return _with_wheels(_office(seed=seed), change)


def kidnapped(seed: int) -> ScanLog:
    """The robot is carried away in the middle; the wheels do not notice."""
    log = _office(seed=seed)
    half = log.n_scans // 2
    elsewhere = half + 40

    def change(steps: np.ndarray) -> None:
        steps[half - 1] = 0.0

    kept = np.r_[0:half, elsewhere : log.n_scans]
    cut = log.take(kept)
    return _with_wheels(cut, change)


def gap(seed: int) -> ScanLog:
    """Forty scans in the middle are missing; the wheels went on."""
    log = _office(seed=seed)
    half = log.n_scans // 2
    return log.take(np.r_[0:half, half + 40 : log.n_scans])


def often(seed: int) -> ScanLog:
    """40 scans a second at 0.5 m/s."""
    log = drive("office", along(OFFICE_WAY, 0.0125, 0.02), sensor=SENSOR, turn_bias=0.01, seed=seed)
    return replace(log, stamps_ns=np.arange(log.n_scans) * 25_000_000)


def seldom(seed: int) -> ScanLog:
    """A scan each 3.3 s at 0.5 m/s."""
    log = drive("office", along(ROUND, 1.65, 1.0), sensor=SENSOR, turn_bias=0.01, seed=seed)
    return replace(log, stamps_ns=np.arange(log.n_scans) * 3_300_000_000)


CASES: dict[str, Callable[[int], ScanLog]] = {
    "an office, nothing hard": lambda seed: _office(seed=seed),
    "corridor without features, 60 m": corridor,
    "two floors alike": floors,
    "glass: 70 % of its readings go through": glass,
    "crowd: 30 % of the beams": crowd,
    "wheels slip by 1.2 m, six times": slip,
    "kidnapped in the middle": kidnapped,
    "a lift to another floor": lift,
    "5 m range": lambda seed: _office(sensor=SHORT, seed=seed),
    "40 Hz": often,
    "0.3 Hz": seldom,
    "40 scans missing in the middle": gap,
    "without poses": lambda seed: without_truth_lost(_office(seed=seed)),
}


def without_truth_lost(log: ScanLog) -> ScanLog:
    """Return a log without odometry, which keeps its true poses under another name."""
    bare = without_poses(log)
    return replace(bare, trajectories={**bare.trajectories, "true": log.trajectory("true")})


def hard() -> None:
    """Print a row for each case."""
    columns = "log", "scans", "error, mean of each seed", "greatest", "wrong", "wrong and silent", "notes"
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    usual = set[str]()
    for name, make in CASES.items():
        means, most, wrong, silent, said = [], 0.0, 0, 0, set[str]()
        for seed in SEEDS:
            log = make(seed)
            odometry = next(one for one in log.trajectories if one != "true")
            found = slam_log(log, trajectory=odometry if odometry == "odometry" else None)
            true = log.trajectory("true").poses
            aligned = align(true, found.poses).apply(found.poses)
            off = np.hypot(*(aligned - true)[:, :2].T)
            means.append(float(off.mean()))
            most = max(most, float(off.max()))
            is_wrong = means[-1] > WRONG_M
            wrong += is_wrong
            notes = {re.sub("[0-9.]+", "#", note) for note in found.notes}
            if name == next(iter(CASES)):
                usual |= notes
            silent += is_wrong and not notes - usual
            said |= {note for note in found.notes if re.sub("[0-9.]+", "#", note) not in usual}
        figures = ", ".join(f"{mean:.2f}" for mean in means)
        print(
            f"| {name} | {log.n_scans} | {figures} m | {most:.2f} m | {wrong} of {len(SEEDS)} | {silent} | "
            f"{' '.join(sorted(said)[:2]) or '–'} |",
            flush=True,
        )
