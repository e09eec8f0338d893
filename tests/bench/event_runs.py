"""Simulated drives with odometry, in which a robot is pushed, slips or is lifted, or its clock is set."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import WORLDS, SensorConfig, Simulation
from mapper.simulation.lidar import RANGE_MIN, measure
from mapper.simulation.odometry import ALPHAS, TURN_BIAS, drifting_odometry

RATE_HZ = 5.0
SENSOR = SensorConfig(n_beams=180, range_max=8.0, range_noise=0.01, scan_rate=RATE_HZ)
START_NS = 1_760_000_000_000_000_000
BACK = 60  #: scans in which a displaced robot drives back to its path, which its wheels measure
ROOM_M = 0.2  #: that a displaced robot keeps from walls


@dataclass(frozen=True, slots=True)
class Happening:
    """One thing that happens: ``kind`` as of an event, from scan ``at`` on, for ``lasts`` scans.

    ``moved`` (3,) is by how much the robot is displaced, in its own frame, metres and radians; of a slip what the
    wheels measure meanwhile; of the clock by how many seconds it is set, in the first number.
    """

    kind: str
    at: int
    lasts: int
    moved: tuple[float, float, float]


@lru_cache(maxsize=8)
def explored(world: str, n: int, seed: int) -> Float64Array:
    """Return the true path (n, 3) of a robot that explores a world; it must not be modified."""
    simulation = Simulation(WORLDS[world], SENSOR, seed)
    return np.array([pose for _, pose in simulation.advance((n + 1) / RATE_HZ)[:n]])


def free_scans(world: str, n: int, seed: int, moved: tuple[float, float, float]) -> NDArray[np.int64]:
    """Return the scans at which a robot may be displaced by ``moved`` and drive back to its path, touching nothing."""
    path = explored(world, n, seed)
    back = np.linspace(1.0, 0.0, BACK)[:, np.newaxis] * np.array(moved)
    found = [
        k
        for k in range(40, n - BACK - 40)
        if WORLDS[world].clearance(compose(path[k : k + BACK], back)[:, :2]).min() > ROOM_M
    ]
    return np.array(found, dtype=np.int64)


def drive(
    world: str, n: int, happenings: Sequence[Happening] = (), *, seed: int = 1, drift: float = 0.5, noise: float = 0.01
) -> ScanLog:
    """Return a log of ``n`` scans of a robot that explores a world, with its odometry in a frame ``odom``.

    ``drift`` scales the errors of its wheels, ``noise`` is that of a reading, metres.
    """
    random = np.random.default_rng(seed)
    stands, lifted = np.zeros(n - 1, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    offsets, unmeasured, slipped = np.zeros((n, 3)), np.zeros(n - 1, dtype=np.bool_), np.zeros((n - 1, 3))
    for one in happenings:
        part, end = slice(one.at, one.at + one.lasts), one.at + one.lasts
        if one.kind in ("slipped", "lifted"):
            stands[part] = True
        if one.kind == "slipped":
            slipped[part] = np.array(one.moved) / one.lasts
        elif one.kind in ("pushed", "lifted"):
            unmeasured[part] = True
            rise = np.linspace(0.0, 1.0, one.lasts + 1)[:, np.newaxis] * np.array(one.moved)
            fall = np.linspace(1.0, 0.0, BACK)[:, np.newaxis] * np.array(one.moved)
            whole = np.concatenate([rise, fall[1:]])[: n - one.at]
            offsets[one.at : one.at + len(whole)] = whole
        if one.kind == "lifted":
            lifted[one.at + 1 : end] = True
    progress = np.concatenate([[0], np.cumsum(~stands)])
    path = explored(world, n, seed)[progress]
    true = compose(path, offsets)
    steps = compose(inverse(true[:-1]), true[1:])
    steps[unmeasured] = compose(inverse(path[:-1]), path[1:])[unmeasured]
    steps += slipped
    rolled = np.zeros((n, 3))
    for k in range(n - 1):
        rolled[k + 1] = compose(rolled[k], steps[k])
    alphas = (ALPHAS[0] * drift, ALPHAS[1] * drift, ALPHAS[2] * drift, ALPHAS[3] * drift)
    odometry = drifting_odometry(rolled, random, alphas, TURN_BIAS * drift)
    sensor = SensorConfig(n_beams=SENSOR.n_beams, range_max=SENSOR.range_max, range_noise=noise, scan_rate=RATE_HZ)
    ranges = np.array([measure(WORLDS[world], sensor, pose, random, 0).ranges for pose in true])
    for k in np.flatnonzero(lifted).tolist():  # tilted, it sees the floor at one side, and nothing at the other
        bearing = np.linspace(-math.pi, math.pi, SENSOR.n_beams) - random.uniform(-math.pi, math.pi)
        down = np.sin(bearing) * random.uniform(0.2, 0.6)
        ranges[k] = np.where(down > 0.05, np.minimum(ranges[k], 0.5 / np.maximum(down, 0.05)), np.inf)
    stamps = START_NS + (np.arange(n) * 1e9 / RATE_HZ).astype(np.int64)
    for one in happenings:
        if one.kind == "clock":
            stamps[one.at + 1 :] += round(one.moved[0] * 1e9)
    return ScanLog(
        ranges.astype(np.float32),
        SENSOR.angle_min,
        SENSOR.angle_increment,
        RANGE_MIN,
        SENSOR.range_max,
        stamps,
        {"odom": Trajectory(odometry, frame_id="odom"), "true": Trajectory(true, frame_id="map")},
        name=f"{world} {seed}",
    )
