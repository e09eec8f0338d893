"""Two trajectories in closed form, which other programs can be given too."""

from __future__ import annotations

import numpy as np

from mapper.core.se2 import compose
from mapper.sensors.timed_poses import TimedPoses


def reference() -> TimedPoses:
    """300 poses, ten a second, along a figure of eight."""
    t = np.arange(300) * 0.1
    x, y = 6.0 * np.sin(0.4 * t), 4.0 * np.sin(0.8 * t)
    theta = np.arctan2(3.2 * np.cos(0.8 * t), 2.4 * np.cos(0.4 * t))
    return TimedPoses(np.arange(300) * 100_000_000 + 1_000_000_000_000, np.column_stack([x, y, theta]))


def estimate() -> TimedPoses:
    """Every second of them, with errors, 3 % larger, in another frame and with stamps that are up to 4 ms off."""
    true = reference()
    k = np.arange(0, 300, 2)
    off = np.column_stack([0.05 * np.sin(0.7 * k), 0.04 * np.cos(1.1 * k), 0.03 * np.sin(1.7 * k + 0.5)])
    poses = compose(true.poses[k], off)
    poses[:, :2] *= 1.03
    stamps = true.stamps_ns[k] + np.round(4e6 * np.sin(2.3 * k)).astype(np.int64)
    return TimedPoses(stamps, compose([2.0, -1.0, 0.6], poses))
