"""Pure pursuit: path following by steering towards a lookahead point on the path.

Sources: Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992; names, defaults
and the regulation of the speed: Macenski et al., Regulated Pure Pursuit for Robot Path Tracking, 2023.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.planning.parameters import PursuitConfig


class Command(NamedTuple):
    """Velocity command: ``linear`` m/s and ``angular`` rad/s, with the ``carrot`` (x, y), the target point in m."""

    linear: float
    angular: float
    carrot: tuple[float, float]


def follow_path(
    points: Float64Array, pose: Sequence[float] | Float64Array, config: PursuitConfig | None = None
) -> Command:
    """Return the command for a robot at ``pose`` (x, y, yaw) that follows the path ``points`` (n, 2), map metres.

    The target is the point of the path at the lookahead distance, beyond the path's nearest point, or the path's end if
    that is nearer. The curvature is 2 y / L², for the point (x, y) at distance L in the robot's frame. Raises
    :class:`ConfigError` for a path without points and numbers that are not finite.
    """
    config = config or PursuitConfig()
    path, here = np.asarray(points, dtype=np.float64), np.asarray(pose, dtype=np.float64)
    if path.ndim != 2 or path.shape[1] != 2 or not len(path) or not np.isfinite(path).all():
        raise ConfigError("pursuit.path", f"The path must be finite points (n, 2), at least one, not {path.shape}.")
    if here.shape != (3,) or not np.isfinite(here).all():
        raise ConfigError("pursuit.pose", f"The pose must be three finite numbers, not {here.tolist()}.")
    left = _rest(path, here[:2])
    carrot = _ahead(left, here[:2], config.lookahead_dist)
    dx, dy = carrot - here[:2]
    x = math.cos(here[2]) * dx + math.sin(here[2]) * dy
    y = -math.sin(here[2]) * dx + math.cos(here[2]) * dy
    squared = x * x + y * y
    aim = (float(carrot[0]), float(carrot[1]))
    if squared < 1e-12:
        return Command(0.0, 0.0, aim)
    angle = math.atan2(y, x)
    if config.use_rotate_to_heading and abs(angle) > config.rotate_to_heading_min_angle:
        return Command(0.0, math.copysign(config.rotate_to_heading_angular_vel, angle), aim)
    curvature = 2.0 * y / squared
    speed = _regulated(config.desired_linear_vel, curvature, left, here[:2], config)
    return Command(speed, speed * curvature, aim)


def _rest(path: Float64Array, here: Float64Array) -> Float64Array:
    """Return the path from its point nearest to ``here``, which may be between two of its points, to its end."""
    if len(path) == 1:
        return path
    begin, step = path[:-1], np.diff(path, axis=0)
    squared = np.maximum((step**2).sum(axis=1), 1e-18)
    share = np.clip(((here - begin) * step).sum(axis=1) / squared, 0.0, 1.0)
    nearest = begin + share[:, np.newaxis] * step
    k = int(np.argmin(((nearest - here) ** 2).sum(axis=1)))
    return np.vstack([nearest[k], path[k + 1 :]])


def _ahead(path: Float64Array, here: Float64Array, distance: float) -> Float64Array:
    """Return the first point of the path at ``distance`` m from ``here``, interpolated if necessary.

    It is the path's first point if that is already farther, and its last one if all are nearer.
    """
    far = np.hypot(*(path - here).T) >= distance
    if not far.any():
        return np.asarray(path[-1])
    k = int(np.argmax(far))
    if k == 0:
        return np.asarray(path[0])
    begin, step = path[k - 1] - here, path[k] - path[k - 1]
    a, b, c = float(step @ step), float(begin @ step), float(begin @ begin) - distance**2
    return np.asarray(path[k - 1] + (-b + math.sqrt(max(b * b - a * c, 0.0))) / a * step)


def _regulated(speed: float, curvature: float, left: Float64Array, here: Float64Array, config: PursuitConfig) -> float:
    """Return the speed, reduced in tight curves and near the end of the path."""
    if config.use_regulated_linear_velocity_scaling and curvature != 0.0:
        radius = abs(1.0 / curvature)
        least = config.regulated_linear_scaling_min_radius
        slower = speed * radius / least if radius < least else speed
        speed = min(speed, max(slower, config.regulated_linear_scaling_min_speed))
    if float(np.hypot(*np.diff(left, axis=0).T).sum()) < config.approach_velocity_scaling_dist:
        share = math.hypot(*(left[-1] - here)) / config.approach_velocity_scaling_dist
        speed = min(speed, max(speed * share, config.min_approach_linear_velocity))
    return speed
