"""Speeds computed from the poses of odometry whose messages state none.

Source: the definition of nav_msgs/Odometry, whose twist is in the base frame. Drivers that do not measure it leave it
at zero.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.contents.model import Column

MOST = 3.0e38  #: larger speeds do not fit into float32
FROM_POSES = "from poses"  #: suffix of the names of such speeds


def states_speeds(rows: Float64Array) -> bool:
    """Return whether odometry states speeds, or never moves.

    ``rows`` (n, 6) are forward and sideways (m/s), turning (rad/s), x and y (m), yaw (rad) of each message.
    """
    speeds, poses = rows[:, :3], rows[:, 3:]
    return bool((np.nan_to_num(speeds) != 0.0).any() or (poses == poses[:1]).all())


def pose_speeds(stamps_ns: NDArray[np.int64], poses: Float64Array) -> Float64Array:
    """Return forward and sideways (m/s) and turning (rad/s) speeds, (n, 3), of poses (n, 3) since the previous one.

    ``stamps_ns`` (n,) ascend. NaN for the first pose, for a pose at the time of the previous one, and for speeds above
    :data:`MOST`.
    """
    seconds = np.diff(stamps_ns) * 1e-9
    moved = compose(inverse(poses[:-1]), poses[1:])
    # On an arc the robot moves along the mean of the two headings.
    half = 0.5 * moved[:, 2]
    cos, sin = np.cos(half), np.sin(half)
    x, y = moved[:, 0], moved[:, 1]
    steps = np.column_stack([cos * x + sin * y, cos * y - sin * x, wrap_angle(moved[:, 2])])
    speeds = np.full((len(poses), 3), np.nan)
    passed = seconds > 0.0
    speeds[1:][passed] = steps[passed] / seconds[passed, None]
    speeds[np.abs(speeds) > MOST] = np.nan
    return speeds


def from_poses(columns: tuple[Column, ...]) -> tuple[Column, ...]:
    """Return the columns of odometry with the names of speeds computed from its poses."""
    return tuple(replace(column, label=f"{column.label} {FROM_POSES}") for column in columns[:3]) + columns[3:]
