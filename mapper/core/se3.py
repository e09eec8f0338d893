"""Rigid motions in space, SE(3), as (4, 4) matrices. ``T_a_b`` transforms coordinates from frame b to frame a.

Source: Barfoot, State Estimation for Robotics, chapter 7; REP 103 (roll, pitch and yaw about fixed axes x, y, z).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Float64Array


def from_quaternion(translation: Sequence[float], x: float, y: float, z: float, w: float) -> Float64Array:
    """Return the motion (4, 4) of a translation (3,), metres, and a unit quaternion."""
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = translation
    return pose


def from_euler(translation: Sequence[float], roll: float, pitch: float, yaw: float) -> Float64Array:
    """Return the motion (4, 4) of a translation (3,), metres, and finite angles, radians: roll first, yaw last."""
    sr, sp, sy = math.sin(roll), math.sin(pitch), math.sin(yaw)
    cr, cp, cy = math.cos(roll), math.cos(pitch), math.cos(yaw)
    pose = np.eye(4)
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = translation
    return pose


def to_euler(x: float, y: float, z: float, w: float) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a unit quaternion, in radians, as used by :func:`from_euler`."""
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )
