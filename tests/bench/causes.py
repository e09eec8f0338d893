"""What the doctor names first, on simulated logs with one fault each and on logs without any."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mapper.core.errors import MapperError
from mapper.core.se2 import compose
from mapper.diagnosis import diagnose, first_cause
from mapper.io.logs import open_log
from mapper.io.logs.understanding import understood
from mapper.mapping.parameters import RECORDED, MappingConfig
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from mapper.simulation import WORLDS, sample_log
from mapper.simulation.odometry import WORN_ALPHAS, WORN_TURN_BIAS, drifting_odometry
from tests.bench.disturbed_scans import crowded, polished
from tests.bench.event_runs import Happening, drive, free_scans

N = 300
#: world and seed of each simulated log
HALVES = {
    "calibration": (("office", 5), ("loop", 7), ("maze", 8)),
    "check": (("hall", 11), ("room", 12), ("levels", 13), ("office", 14)),
}
NONE = "nothing"

Fault = Callable[[ScanLog], ScanLog]


def clean(world: str, seed: int) -> ScanLog:
    """Return a simulated log along its true poses; its topic is the name of its world."""
    log = sample_log(N, world, seed)
    return replace(log, trajectories={"odom": replace(log.trajectory("true"), frame_id="odom")}, topic=world)


def _along(log: ScanLog, poses: np.ndarray) -> ScanLog:
    return replace(log, trajectories={"odom": Trajectory(poses, frame_id="odom")})


def _late(log: ScanLog, seconds: float) -> ScanLog:
    times, poses = log.stamps_ns * 1e-9, log.trajectory().poses
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    return _along(log, np.stack([np.interp(times - seconds, times, one) for one in columns], axis=-1))


def _stamped(log: ScanLog, late: float, rate: float = 0.0) -> ScanLog:
    """The log as it is read with poses whose stamps are ``late`` seconds too late, and by a clock that is fast."""
    after = 1e-9 * (log.stamps_ns - log.stamps_ns.mean())
    stamps_ns = log.stamps_ns + np.round(1e9 * (late + rate * after)).astype(np.int64)
    timed = TimedPoses(stamps_ns, log.trajectory().poses)
    log = log.take(timed.covers(log.stamps_ns))
    given = replace(log.trajectory(), poses=timed.at(log.stamps_ns), timed=timed)
    return understood(RobotLog.of_one(replace(log, trajectories={"odom": given}))).first


def _every_other(log: ScanLog) -> ScanLog:
    """The log with poses at every other scan, and interpolated between them."""
    timed = TimedPoses(log.stamps_ns[::2], log.trajectory().poses[::2])
    log = log.take(timed.covers(log.stamps_ns))
    given = replace(log.trajectory(), poses=timed.at(log.stamps_ns), timed=timed)
    return replace(log, trajectories={"odom": given})


def _by_distance(log: ScanLog) -> ScanLog:
    """The same scans, recorded after equal ways by a robot that drives at several speeds and stops now and then."""
    random = np.random.default_rng(3)
    fast = np.repeat(random.random(40) < 0.7, 10)[: log.n_scans - 1]
    steps = 0.2 / (np.where(fast, 0.5, 0.25) * random.normal(1.0, 0.03, log.n_scans - 1))
    steps[::50] += 20.0
    return replace(log, stamps_ns=(1e9 * np.concatenate([[0.0], np.cumsum(steps)])).astype(np.int64))


def _back(log: ScanLog) -> ScanLog:
    stamps = log.stamps_ns.copy()
    stamps[N // 2 :] -= 30_000_000_000
    return replace(log, stamps_ns=stamps)


def _itself(log: ScanLog) -> ScanLog:
    ranges = log.ranges.copy()
    ranges[:, 100:110] = 0.31
    return replace(log, ranges=ranges)


def _dropped(log: ScanLog) -> ScanLog:
    gone = np.random.default_rng(4).choice(np.arange(5, N - 5), 20, replace=False)
    return log.take(np.setdiff1d(np.arange(N), gone))


def _turned(log: ScanLog, yaw: float, over: bool) -> ScanLog:
    x, y, heading = compose(log.mount, (0.0, 0.0, yaw)).tolist()
    return replace(log, mount=(x, y, heading), upside_down=over)


#: fault, the name of its finding, and how it is made
FAULTS: Mapping[str, tuple[str, Fault]] = {
    "none": (NONE, lambda log: log),
    "recorded by distance, with pauses": (NONE, _by_distance),
    "noise of 3 cm in the readings": (
        NONE,
        lambda log: replace(
            log,
            ranges=(log.ranges + np.random.default_rng(5).normal(0.0, 0.03, log.ranges.shape)).astype(np.float32),
        ),
    ),
    "polished walls": (NONE, lambda log: polished(log, WORLDS[log.topic])),
    "six people who walk about": (NONE, lambda log: crowded(log, WORLDS[log.topic])),
    "no return written as range_max": (
        "readings.max_range",
        lambda log: replace(log, ranges=np.where(np.isinf(log.ranges), np.float32(log.range_max), log.ranges)),
    ),
    "beams that hit the robot": ("readings.itself", _itself),
    "mount turned by 90°": ("mount.turned", lambda log: _turned(log, np.pi / 2, over=False)),
    "mount upside down": ("mount.turned", lambda log: _turned(log, 0.0, over=True)),
    "mount off by 14 cm and 3°": ("mount.offset", lambda log: replace(log, mount=(-0.1, 0.1, 0.05))),
    "poses late by 0.3 s": ("timing.delay", lambda log: _late(log, 0.3)),
    "poses early by 0.5 s": ("timing.delay", lambda log: _late(log, -0.5)),
    "poses with stamps of their own": (NONE, lambda log: _stamped(log, 0.0)),
    "poses stamped 0.15 s late": ("timing.clock", lambda log: _stamped(log, 0.15)),
    "clock of the poses 0.5 % fast": ("timing.clock", lambda log: _stamped(log, 0.0, 0.005)),
    "poses 0.8 s apart": ("timing.sparse", _every_other),
    "time_increment of scans that are taken at once": (
        "timing.increment",
        lambda log: replace(log, time_increment=0.4 / (log.n_beams - 1)),
    ),
    "clock set back by 30 s": ("clock.backwards", _back),
    "7 % of the scans dropped": ("clock.dropped", _dropped),
    "40 scans not recorded": ("clock.gap", lambda log: log.take(np.r_[:130, 170:N])),
    "poses that stay": ("poses.still", lambda log: _along(log, np.zeros((N, 3)))),
    "worn wheels": (
        "walls.drift",
        lambda log: _along(
            log,
            drifting_odometry(log.trajectory().poses, np.random.default_rng(6), WORN_ALPHAS, WORN_TURN_BIAS),
        ),
    ),
}

#: Of the logs of the test data with corrected poses, and what is true of each besides.
CORRECTED = {
    "carmen/intel-corrected.log.gz": "clock.backwards",
    "carmen/aces-corrected.log.gz": "readings.max_range",
    "carmen/fhw-corrected.log.gz": NONE,
    "carmen/intel-robotlaser.log.gz": "clock.backwards, clock.gap",
    "sonar": "clock.dropped",
}

#: Of the logs of ../reports/logs beside the test data, what is true of those with a fault that a reader cannot settle.
REPORTED = {
    "log_open20_all_inf.csv": "readings.few",
    "multi_robot_same_frames": "timing.clock",  # its scans are stamped 10 ms after they were measured
    "range_fixed_distance": "readings.few",
    "sim_reset": "clock.backwards",
    "time_increment_4x": "timing.increment",
}


def first(log: ScanLog, trajectory: str | None = None) -> tuple[str, int]:
    """Return the name of the doctor's first finding, and how many events it has besides."""
    found = diagnose(log, trajectory)
    return (found.findings[0].check if found.findings else NONE), len(found.events)


def pushed() -> Iterator[str]:
    """Yield the first finding on drives in which the robot was pushed once, where drift names the push."""
    for world, seed in (("office", 4), ("loop", 2), ("hall", 3)):
        moved = (0.0, 0.4, 0.4)
        free = free_scans(world, 500, seed, moved)
        if len(free):
            log = drive(world, 500, [Happening("pushed", int(free[len(free) // 2]), 2, moved)], seed=seed, drift=0.0)
            found = diagnose(log)
            named = found.findings and "did not measure" in found.findings[0].sentence
            yield "walls.drift that names the push" if named else (found.findings[0].check if found.findings else NONE)


def reported(folder: Path) -> None:
    """Print the findings on the logs of a folder that can be examined, and what was found of how many."""
    print("\n| reported log | true of it | findings | cause that `map` says |\n|---|---|---|---|")
    examined, none = 0, []
    for path in sorted(folder.iterdir()):
        try:
            log = open_log(path)
            found = diagnose(log).findings
        except MapperError as error:
            print(f"| {path.name} | – | {error.code} | – |")
            continue
        examined += 1
        true, checks = REPORTED.get(path.name, NONE), ", ".join(one.check for one in found) or NONE
        cause = first_cause(log, None, MappingConfig().with_values(RECORDED))
        if true == checks == NONE and cause is None:
            none.append(path.name)
        else:
            print(f"| {path.name} | {true} | {checks} | {NONE if cause is None else cause.check} |", flush=True)
    print(f"\n{examined} examined; nothing true of, found in or said of: {', '.join(none)}")


def causes() -> None:
    """Print the tables of docs/figures.md: the first finding on each fault, and on logs without one."""
    print("| fault | its finding | half | logs | first | nothing | another one first | events |")
    print("|---|---|---|---|---|---|---|---|")
    for fault, (name, make) in FAULTS.items():
        for half, drives in HALVES.items():
            results = [first(make(clean(*one))) for one in drives]
            named = Counter(check for check, _ in results)
            others = ", ".join(f"{n} {check}" for check, n in named.items() if check not in (name, NONE)) or "–"
            row = [fault, name, half, len(results), named[name], named[NONE], others, sum(n for _, n in results)]
            print(f"| {' | '.join(map(str, row))} |", flush=True)
    for said, n in Counter(pushed()).items():
        print(f"\npushed by 0.4 m and turned by 23°: {said} ({n})")
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    if not folder.is_dir():
        print("The real logs are left out: GRIDBLOOM_TEST_DATA names no folder.", file=sys.stderr)
        return
    print("\n| corrected log | true of it | findings | events |\n|---|---|---|---|")
    for path, true in CORRECTED.items():
        found = diagnose(open_log(folder / path))
        checks = ", ".join(one.check for one in found.findings) or NONE
        print(f"| {path} | {true} | {checks} | {len(found.events)} |", flush=True)
    reports = folder.parent / "reports" / "logs"
    if reports.is_dir():
        reported(reports)
