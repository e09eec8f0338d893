"""Pure pursuit: the curvature of circles, Nav2's regulation of the speed, and drives along paths."""

import math

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.planning import PursuitConfig, follow_path

PLAIN = PursuitConfig(use_regulated_linear_velocity_scaling=False, use_rotate_to_heading=False)


@pytest.mark.parametrize("radius", [0.7, 2.0, -1.5])
@pytest.mark.parametrize("yaw", [0.0, 2.5])
def test_on_a_circle_the_robot_drives_that_circle(radius: float, yaw: float) -> None:
    """A robot on a circle, along its tangent: every point ahead lies on the arc of curvature 1 / radius."""
    angles = np.linspace(0.0, 0.5 * math.pi, 2000)
    along, across = abs(radius) * np.sin(angles), radius * (1.0 - np.cos(angles))
    c, s = math.cos(yaw), math.sin(yaw)
    path = np.column_stack([3.0 + c * along - s * across, -1.0 + s * along + c * across])
    told = follow_path(path, (3.0, -1.0, yaw), PLAIN)
    assert told.linear == 0.5
    assert told.angular / told.linear == pytest.approx(1.0 / radius, rel=1e-4)
    assert math.hypot(told.carrot[0] - 3.0, told.carrot[1] + 1.0) == pytest.approx(0.6)


def test_the_point_ahead_is_between_two_points_of_a_coarse_path() -> None:
    told = follow_path(np.array([[0.0, 0.0], [10.0, 0.0]]), (2.0, 0.3, 0.0), PLAIN)
    assert told.carrot == pytest.approx((2.0 + math.sqrt(0.6**2 - 0.3**2), 0.0))
    assert told.angular / told.linear == pytest.approx(2.0 * -0.3 / 0.6**2)


def test_the_speed_is_regulated_as_nav2_does() -> None:
    path = np.array([[0.0, 0.0], [10.0, 0.0]])
    curve = follow_path(path, (2.0, 0.3, 0.0), PursuitConfig())
    radius = 0.6**2 / (2.0 * 0.3)  # 0.6 m, less than 0.9 m
    assert curve.linear == pytest.approx(0.5 * (1.0 - (0.9 - radius) / 0.9))
    assert follow_path(path, (2.0, 0.3, 0.0), PursuitConfig(regulated_linear_scaling_min_speed=0.4)).linear == 0.4
    assert follow_path(path, (9.7, 0.0, 0.0), PursuitConfig()).linear == pytest.approx(0.5 * 0.3 / 0.6)
    assert follow_path(path, (9.99, 0.0, 0.0), PursuitConfig()).linear == 0.05
    turning = follow_path(path, (2.0, 0.0, -2.0), PursuitConfig())
    assert (turning.linear, turning.angular) == (0.0, 1.8)
    assert follow_path(path, (10.0, 0.0, 1.0), PursuitConfig())[:2] == (0.0, 0.0)


def test_a_drive_along_a_corner_ends_at_its_end() -> None:
    path = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]])
    x, y, yaw = 0.0, 0.4, -2.5
    farthest = 0.0
    for k in range(1000):
        told = follow_path(path, (x, y, yaw))
        yaw += told.angular * 0.05
        x, y = x + told.linear * math.cos(yaw) * 0.05, y + told.linear * math.sin(yaw) * 0.05
        if k > 40:
            off = min(math.hypot(max(x - 3.0, 0.0), y), math.hypot(x - 3.0, min(y, 0.0)))
            farthest = max(farthest, off)
        if math.hypot(x - 3.0, y - 3.0) < 0.05:
            break
    assert math.hypot(x - 3.0, y - 3.0) < 0.05
    assert farthest < 0.4


@pytest.mark.parametrize(
    ("points", "pose", "said"),
    [
        (np.zeros((0, 2)), (0.0, 0.0, 0.0), "at least one"),
        (np.array([[0.0, math.nan]]), (0.0, 0.0, 0.0), "must be finite points"),
        (np.zeros((1, 2)), (0.0, math.nan, 0.0), "pose must be three finite numbers"),
    ],
)
def test_what_is_refused(points: np.ndarray, pose: tuple[float, ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        follow_path(points, pose)
