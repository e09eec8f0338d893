"""Scans of rooms made of line segments, by plain geometry."""

from __future__ import annotations

import numpy as np

from mapper.sensors.scan import ScanLog, Trajectory

#: A room of 8 m × 5 m with a pillar, a bench and a niche: no two places in it look alike.
ROOM = np.array(
    [
        *[(0, 0, 8, 0), (8, 0, 8, 3), (8, 3, 7, 3), (7, 3, 7, 5), (7, 5, 0, 5), (0, 5, 0, 0)],
        *[(2, 3.5, 2.6, 3.5), (2.6, 3.5, 2.6, 4.1), (2.6, 4.1, 2, 4.1), (2, 4.1, 2, 3.5)],
        *[(5, 0, 5, 0.8), (5, 0.8, 6.2, 0.8), (6.2, 0.8, 6.2, 0)],
    ],
    dtype=np.float64,
)
CORRIDOR = np.array([(-60, -1, 60, -1), (-60, 1, 60, 1)], dtype=np.float64)


def readings(segments: np.ndarray, pose: np.ndarray, bearings: np.ndarray, range_max: float) -> np.ndarray:
    """The distance (n,) to the nearest segment (m, 4) along each bearing (n,); inf beyond ``range_max``."""
    directions = np.stack([np.cos(pose[2] + bearings), np.sin(pose[2] + bearings)], axis=-1)[:, np.newaxis]
    along = segments[:, 2:] - segments[:, :2]
    off = segments[:, :2] - pose[:2]
    cross = directions[..., 0] * along[:, 1] - directions[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / cross
        u = (off[:, 0] * directions[..., 1] - off[:, 1] * directions[..., 0]) / cross
    t = np.where((t > 0) & (u >= 0) & (u <= 1), t, np.inf).min(axis=1)
    return np.where(t <= range_max, t, np.inf)


def scan_log(
    segments: np.ndarray, poses: np.ndarray, n_beams: int = 180, noise: float = 0.01, seed: int = 1
) -> ScanLog:
    """A log of scans over 270° at ``poses`` (n, 3), with a mount, and readings with Gaussian noise."""
    mount, random = np.array([0.2, 0.05, 0.1]), np.random.default_rng(seed)
    step = np.deg2rad(270.0) / n_beams
    first = -np.deg2rad(135.0)
    bearings = first + step * np.arange(n_beams)
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x = poses[:, 0] + c * mount[0] - s * mount[1]
    y = poses[:, 1] + s * mount[0] + c * mount[1]
    sensors = np.column_stack([x, y, poses[:, 2] + mount[2]])
    ranges = np.stack([readings(segments, sensor, bearings, 20.0) for sensor in sensors])
    ranges += noise * random.standard_normal(ranges.shape)
    stamps = np.arange(len(poses), dtype=np.int64) * 100_000_000
    return ScanLog(
        ranges.astype(np.float32), first, step, 0.05, 20.0, stamps, {"true": Trajectory(poses)}, (0.2, 0.05, 0.1)
    )
