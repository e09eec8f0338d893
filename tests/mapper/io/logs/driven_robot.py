"""The messages of a robot that drives, as recordings hold them."""

from __future__ import annotations

import numpy as np

from mapper.core.se2 import wrap_angle
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, estimate, odometry, scan, transform

T0 = 1_700_000_000 * SECOND
MOUNT = (0.3, -0.1, 0.5)


def truth(seconds: float) -> tuple[float, float, float]:
    """Pose of the robot in the odometry frame: straight ahead at 1 m/s, turning at 0.2 rad/s."""
    return (seconds, 2.0, float(wrap_angle(3.0 + 0.2 * seconds)))


def run(n: int = 10) -> list[recorded.Said]:
    """Scans at odd tenths of a second, poses at even ones; the map's frame lies 5 m beside the odometry's."""
    said = [transform(T0, "base_link", "laser", *MOUNT, topic="/tf_static"), transform(T0, "map", "odom", 0.0, 5.0)]
    for i in range(n + 1):
        at = T0 + i * SECOND // 5
        said.append(transform(at, "odom", "base_link", *truth(i / 5)))
        said.append(odometry(at, *truth(i / 5)))
        said.append(estimate(at, i / 5, 7.0, 3.0 + i / 25))
        if i < n:
            said.append(scan(at + SECOND // 10, [1.0 + i, np.nan, 31.0, -np.inf, 0.0]))
    said.append(transform(T0 + (n + 1) * SECOND // 5, "map", "odom", 0.0, 5.0))
    return said
