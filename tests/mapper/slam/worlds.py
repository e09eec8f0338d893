"""Logs of simulated drives with drifting odometry, whose true poses are known."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from mapper.core.se2 import compose, interpolate
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import WORLDS
from mapper.simulation.lidar import RANGE_MIN, SensorConfig, measure
from mapper.simulation.odometry import WORN_ALPHAS, drifting_odometry
from mapper.simulation.worlds import World

SENSOR = SensorConfig(n_beams=90, field_of_view=np.pi, range_max=8.0, range_noise=0.02)


def drive(
    world: World | str,
    path: np.ndarray,
    *,
    sensor: SensorConfig = SENSOR,
    turn_bias: float = 0.05,
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seed: int = 3,
) -> ScanLog:
    """Return the scans along true base poses (n, 3), with the trajectories "odometry", the first, and "true"."""
    place = WORLDS[world] if isinstance(world, str) else world
    rng = np.random.default_rng(seed)
    scans = [measure(place, sensor, compose(pose, mount), rng, k * 100_000_000) for k, pose in enumerate(path)]
    odometry = drifting_odometry(path, rng, WORN_ALPHAS, turn_bias)
    return ScanLog(
        np.stack([scan.ranges for scan in scans]), sensor.angle_min, sensor.angle_increment, RANGE_MIN,
        sensor.range_max, np.array([scan.stamp_ns for scan in scans]),
        {"odometry": Trajectory(odometry, "wheels", "odom"), "true": Trajectory(path)}, mount,
    )  # fmt: skip


def along(corners: list[tuple[float, float]], step: float = 0.25, turn: float = 0.3) -> np.ndarray:
    """Return poses (n, 3) along straight lines between corners, ``step`` metres apart, and turning by ``turn``
    radians at the corners."""
    out: list[tuple[float, float, float]] = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        heading, length = np.arctan2(y1 - y0, x1 - x0), np.hypot(x1 - x0, y1 - y0)
        if out:
            whole = np.mod(heading - out[-1][2] + np.pi, 2 * np.pi) - np.pi
            n = int(abs(whole) / turn)
            out += [(x0, y0, out[-1][2] + whole * k / (n + 1)) for k in range(1, n + 1)]
        out += [(x0 + (x1 - x0) * t, y0 + (y1 - y0) * t, heading) for t in np.arange(0, 1, step / length)]
    return np.array(out)


def without_poses(log: ScanLog) -> ScanLog:
    """Return the log as one without any source of poses."""
    zeros = Trajectory(np.zeros((log.n_scans, 3)), "no poses", is_placeholder=True)
    return replace(log, trajectories={"standing still": zeros})


def sweeping(
    world: str,
    path: np.ndarray,
    *,
    sensor: SensorConfig,
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0),
    period: float = 0.2,
    parts: int = 12,
    seed: int = 3,
) -> ScanLog:
    """Return a drive whose scans take ``period`` seconds each, so that the robot moves meanwhile, along true poses.

    The beams of each of the ``parts`` of a scan are measured at once.
    """
    rng = np.random.default_rng(seed)
    shares = np.arange(parts) / parts
    owner = np.arange(sensor.n_beams) * parts // sensor.n_beams
    ranges = []
    for pose, following in pairwise(path):
        poses = interpolate(np.tile(pose, (parts, 1)), np.tile(following, (parts, 1)), shares)
        scans = [measure(WORLDS[world], sensor, compose(one, mount), rng, 0).ranges for one in poses]
        ranges.append(np.stack(scans)[owner, np.arange(sensor.n_beams)])
    stamps = np.round(np.arange(len(ranges)) * period * 1e9).astype(np.int64)
    odometry = drifting_odometry(path[:-1], rng, WORN_ALPHAS, 0.01)
    return ScanLog(
        np.stack(ranges), sensor.angle_min, sensor.angle_increment, RANGE_MIN, sensor.range_max, stamps,
        {"odometry": Trajectory(odometry, "wheels", "odom"), "true": Trajectory(path[:-1])}, mount,
        time_increment=period / sensor.n_beams,
    )  # fmt: skip
