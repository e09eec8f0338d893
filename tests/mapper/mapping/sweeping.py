"""A simulated lidar whose beams are measured one after another while the robot drives in a circle."""

from __future__ import annotations

import numpy as np

from mapper.grid import OCCUPIED_THRESHOLD, OccupancyGrid
from mapper.sensors.scan import ScanLog, Trajectory

HALF = np.array([4.0, 3.0])  #: metres from the middle of the room to its walls
BEAMS, RATE, TURN = 360, 10.0, 2.5  #: beams in a turn, scans a second, rad/s
STEP = 1.0 / RATE / BEAMS  #: seconds from beam to beam


def true_poses(times: np.ndarray) -> np.ndarray:
    """Poses of the robot: it drives in a circle of 0.8 m, now faster and now slower, so that a delay shows."""
    angle = TURN * times + 0.8 * np.sin(1.5 * times)
    return np.stack([0.8 * np.sin(angle), -0.8 * np.cos(angle), angle], axis=-1)


def to_the_walls(poses: np.ndarray) -> np.ndarray:
    """The distance along the heading of each pose (..., 3) to the wall of the room."""
    heading = np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], axis=-1)
    with np.errstate(divide="ignore"):
        return np.asarray(np.min((np.sign(heading) * HALF - poses[..., :2]) / heading, axis=-1))


def swept(n_scans: int = 40, rate: float = RATE, *, delay: float = 0.0) -> ScanLog:
    """Readings of the lidar; its stamps are those of its first beams, ``delay`` seconds early."""
    first = 100.0 + np.arange(n_scans) / rate
    bearings = -np.pi + 2 * np.pi / BEAMS * np.arange(BEAMS)
    poses = true_poses(first[:, np.newaxis] + STEP * np.arange(BEAMS))
    poses[..., 2] += bearings
    stamps = first - delay
    return ScanLog(
        to_the_walls(poses).astype(np.float32),
        -np.pi,
        2 * np.pi / BEAMS,
        0.1,
        20.0,
        np.round(stamps * 1e9).astype(np.int64),
        {"true": Trajectory(true_poses(stamps))},
        time_increment=STEP,
    )


def off_the_walls(grid: OccupancyGrid) -> np.ndarray:
    """Distances of the centres of the occupied cells from the nearest wall, metres."""
    rows, cols = np.nonzero(grid.p_occ > OCCUPIED_THRESHOLD)
    points = grid.geometry.cell_to_world(np.stack([rows, cols], axis=-1))
    return np.asarray(np.abs(np.abs(points) - HALF).min(axis=-1))
