"""Planar rigid motions, SE(2): compose, inverse, interpolate, transform points, wrap angles, check.

A pose is ``(x, y, theta)``: metres, metres, radians counter-clockwise (REP 103). ``T_a_b`` transforms coordinates from
frame b to frame a, so ``compose(T_map_base, T_base_laser)`` is ``T_map_laser``. Source: Barfoot, State Estimation for
Robotics, chapter 7; Siciliano & Khatib, Handbook of Robotics, 2.2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.limits import DEFAULT_LIMITS, Limits


def wrap_angle(angle: ArrayLike) -> Float64Array:
    """Wrap an angle to [−π, π). Any shape; radians."""
    a = np.asarray(angle, dtype=np.float64)
    return np.asarray(np.mod(a + np.pi, 2.0 * np.pi) - np.pi, dtype=np.float64)


def _columns(x: Float64Array, y: Float64Array, theta: Float64Array) -> Float64Array:
    """Stack three arrays of equal shape along a last axis, in a third of the time of :func:`numpy.stack`."""
    out = np.empty((*theta.shape, 3))
    out[..., 0], out[..., 1], out[..., 2] = x, y, theta
    return out


def compose(t_a_b: ArrayLike, t_b_c: ArrayLike) -> Float64Array:
    """Return ``T_a_c``. Both arguments are (..., 3) and broadcast; the angle is wrapped."""
    a = np.asarray(t_a_b, dtype=np.float64)
    b = np.asarray(t_b_c, dtype=np.float64)
    cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    return _columns(
        a[..., 0] + cos * b[..., 0] - sin * b[..., 1],
        a[..., 1] + sin * b[..., 0] + cos * b[..., 1],
        wrap_angle(a[..., 2] + b[..., 2]),
    )


def compose_one(
    a: tuple[float, float, float] | list[float], b: tuple[float, float, float] | list[float]
) -> tuple[float, float, float]:
    """Return :func:`compose` of two single poses in a fifth of the time.

    The result has the same bits, so NumPy's cosine and sine are used; those of :mod:`math` may differ in the last bit.
    """
    is_turn = b[0] == 0.0 and b[1] == 0.0  # for example, a sensor at the robot's origin: neither is needed
    c, s = (1.0, 0.0) if is_turn else (float(np.cos(a[2])), float(np.sin(a[2])))
    turned = a[2] + b[2]
    turned -= 2.0 * math.pi * math.floor((turned + math.pi) / (2.0 * math.pi))
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], turned)


def between_one(
    a: tuple[float, float, float] | list[float], b: tuple[float, float, float] | list[float]
) -> tuple[float, float, float]:
    """Return ``compose(inverse(a), b)`` of two single poses, with the same bits as :func:`compose_one`."""
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy, turned = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    turned -= 2.0 * math.pi * math.floor((turned + math.pi) / (2.0 * math.pi))
    return (c * dx + s * dy, -s * dx + c * dy, turned)


def inverse(t_a_b: ArrayLike) -> Float64Array:
    """Return ``T_b_a`` for ``T_a_b`` of shape (..., 3)."""
    t = np.asarray(t_a_b, dtype=np.float64)
    cos, sin = np.cos(t[..., 2]), np.sin(t[..., 2])
    return _columns(
        -(cos * t[..., 0] + sin * t[..., 1]),
        sin * t[..., 0] - cos * t[..., 1],
        wrap_angle(-t[..., 2]),
    )


def interpolate(first: ArrayLike, second: ArrayLike, weight: ArrayLike) -> Float64Array:
    """Return the pose at the fraction ``weight`` (...), 0 to 1, between ``first`` and ``second``, both (..., 3).

    The position is interpolated linearly and the angle along the shorter arc, then wrapped. Source: tf2's interpolation
    of transforms, in the plane.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    w = np.asarray(weight, dtype=np.float64)
    return np.stack(
        [
            a[..., 0] + w * (b[..., 0] - a[..., 0]),
            a[..., 1] + w * (b[..., 1] - a[..., 1]),
            wrap_angle(a[..., 2] + w * wrap_angle(b[..., 2] - a[..., 2])),
        ],
        axis=-1,
    )


def transform_points(t_a_b: ArrayLike, points_xy: ArrayLike) -> Float64Array:
    """Transform points (..., 2) from frame b to frame a, for one pose ``T_a_b`` of shape (3,)."""
    x, y, theta = np.asarray(t_a_b, dtype=np.float64)
    p = np.asarray(points_xy, dtype=np.float64)
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack([x + cos * p[..., 0] - sin * p[..., 1], y + sin * p[..., 0] + cos * p[..., 1]], axis=-1)


def pose_tuple(pose: Float64Array) -> tuple[float, float, float]:
    """Return a pose (3,) as a tuple of floats."""
    x, y, yaw = (float(value) for value in pose)
    return (x, y, yaw)


def check_poses(poses: NDArray[np.float64], shape: tuple[int, ...], limits: Limits = DEFAULT_LIMITS) -> None:
    """Raise :class:`ConfigError` unless ``poses`` (..., 3) has this shape, is finite and within ``max_pose``."""
    if poses.shape != shape:
        raise ConfigError("scan.pose_shape", f"Poses must have shape {shape}, not {poses.shape}.")
    finite = np.isfinite(poses)
    if not finite.all():
        bad = ~finite.all(axis=-1)
        raise ConfigError(
            "scan.pose",
            f"Pose {int(np.argmax(bad))} is not finite: {poses[np.argmax(bad)].tolist()}.",
        )
    if np.any(np.abs(poses[..., :2]) > limits.max_pose):
        raise ConfigError("scan.pose_far", f"A pose is more than {limits.max_pose:g} m from the origin.")
