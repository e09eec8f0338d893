"""3D poses as positions and unit quaternions.

Positions (n, 3) are metres, orientations (n, 4) unit quaternions x y z w. Source: Shoemake 1985 (slerp).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.io.logs.ros.message_fields import Pose7
from mapper.sensors.georeference import FARTHEST_M

UNIT_TOLERANCE = 10e-3  #: of the squared length of a quaternion, as in tf2's QUATERNION_NORMALIZATION_TOLERANCE


@dataclass(frozen=True, slots=True)
class Poses3:
    """``T_a_b`` at n times."""

    positions: Float64Array
    rotations: Float64Array

    def __getitem__(self, which: NDArray[np.int64] | NDArray[np.bool_] | slice) -> Poses3:
        return Poses3(self.positions[which], self.rotations[which])

    def __matmul__(self, other: Poses3) -> Poses3:
        """Return ``T_a_c`` for ``T_a_b @ T_b_c``; one of them may have n = 1."""
        return Poses3(
            self.positions + rotated(self.rotations, other.positions), _product(self.rotations, other.rotations)
        )

    @property
    def inverse(self) -> Poses3:
        """``T_b_a``."""
        back = self.rotations * np.array([-1.0, -1.0, -1.0, 1.0])
        return Poses3(-rotated(back, self.positions), back)

    @property
    def planar(self) -> Float64Array:
        """The poses projected to the plane (n, 3): x, y and the heading of the x axis."""
        ahead = rotated(self.rotations, np.array([[1.0, 0.0, 0.0]]))
        return np.column_stack([self.positions[:, :2], np.arctan2(ahead[:, 1], ahead[:, 0])])

    @property
    def matrices(self) -> Float64Array:
        """The rotations as matrices (n, 3, 3)."""
        axes = [rotated(self.rotations, axis[np.newaxis]) for axis in np.eye(3)]
        return np.stack(axes, axis=-1)

    @property
    def up(self) -> Float64Array:
        """The z component of the z axis (n,): 1 upright, −1 upside-down."""
        return np.asarray(rotated(self.rotations, np.array([[0.0, 0.0, 1.0]]))[:, 2])


def identity() -> Poses3:
    """Return the pose of a frame in itself, n = 1."""
    return Poses3(np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]))


def poses_of(values: Float64Array) -> Poses3:
    """Return rows (n, 7), position and quaternion, as poses."""
    return Poses3(values[:, :3], values[:, 3:] / np.linalg.norm(values[:, 3:], axis=1, keepdims=True))


def why_no_pose(pose: Pose7) -> str:
    """Return what is wrong with a stated pose, by tf2's rules for transforms; empty for a valid one."""
    norm = sum(q * q for q in pose[3:])
    if norm - norm != 0.0:  # true for nan and inf
        return "its quaternion is not finite"
    if norm == 0.0:
        return "its quaternion is 0, 0, 0, 0, which is no rotation"
    if not abs(norm - 1.0) < UNIT_TOLERANCE:
        return f"its quaternion has the length {norm**0.5:.3g}, not 1"
    # Written such that NaN also fails.
    if not (abs(pose[0]) <= FARTHEST_M and abs(pose[1]) <= FARTHEST_M and abs(pose[2]) <= FARTHEST_M):
        finite = all(value - value == 0.0 for value in pose[:3])
        return f"its position is beyond {FARTHEST_M:g} m" if finite else "its position is not finite"
    return ""


def interpolated(a: Poses3, b: Poses3, weights: Float64Array) -> Poses3:
    """Interpolate the poses (n,) between ``a`` and ``b`` by ``weights`` (n,): linear in position, the shorter arc."""
    w = weights[:, np.newaxis]
    return Poses3(a.positions + w * (b.positions - a.positions), _slerp(a.rotations, b.rotations, w))


def _product(a: Float64Array, b: Float64Array) -> Float64Array:
    ax, ay, az, aw = a.T
    bx, by, bz, bw = b.T
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def angles_between(a: Poses3, b: Poses3) -> Float64Array:
    """Return the angles (n,) between the orientations of ``a`` and ``b``, radians."""
    dots = np.abs(np.sum(a.rotations * b.rotations, axis=1))
    return np.asarray(2.0 * np.arccos(np.minimum(dots, 1.0)))


def rotated(q: Float64Array, v: Float64Array) -> Float64Array:
    """Rotate vectors (n, 3) by unit quaternions (n, 4); one of them may have n = 1."""
    u, w = q[:, :3], q[:, 3:]
    t = 2.0 * np.cross(u, v)
    return np.asarray(v + w * t + np.cross(u, t))


def _slerp(a: Float64Array, b: Float64Array, w: Float64Array) -> Float64Array:
    dot = np.sum(a * b, axis=1, keepdims=True)
    b = np.where(dot < 0.0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0))
    sin = np.sin(angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.where(sin > 1e-6, np.sin((1.0 - w) * angle) / sin, 1.0 - w)
        right = np.where(sin > 1e-6, np.sin(w * angle) / sin, w)
    mixed = left * a + right * b
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))
