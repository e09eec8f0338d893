"""Positions of a trajectory that are altered, and those that a conversion to cells by truncation gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses

Positions = NDArray[np.float64]
Altering = Callable[[NDArray[np.int64], Positions], Positions]
"""Given stamps (n,), nanoseconds, and positions (n, 2), metres, returns the altered positions (n, 2)."""


def with_positions(log: ScanLog, name: str, alter: Altering) -> Trajectory:
    """Return the trajectory ``name`` of a log with altered positions, at the scans and between them; headings stay."""
    trajectory = log.trajectory(name)
    timed = trajectory.timed
    return replace(
        trajectory,
        poses=_altered(log.stamps_ns, trajectory.poses, alter),
        timed=None if timed is None else TimedPoses(timed.stamps_ns, _altered(timed.stamps_ns, timed.poses, alter)),
    )


def _altered(stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], alter: Altering) -> NDArray[np.float64]:
    return np.column_stack([alter(stamps_ns, poses[:, :2]), poses[:, 2]])


def truncated_positions(xy: Positions, side: float) -> Positions:
    """Return positions that went through the index of a cell, converted by truncation, and a place within the cell.

    ``xy`` are metres, any shape, and ``side`` is that of a cell, metres. The index is ``trunc(x / side)``, which is
    ``floor(x / side)`` above zero and one more below it; the place is the remainder ``x mod side``, at least 0. So
    what is above zero stays, and what is below is moved by one cell: −0.1 m in cells of 0.25 m becomes 0.15 m.
    """
    result: Positions = side * np.trunc(xy / side) + np.mod(xy, side)
    return result
