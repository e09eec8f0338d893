"""Trajectories that state one path twice."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.evaluation.same_path import first_pair, is_same_path, stated_before
from mapper.sensors.scan import Trajectory


def circle(n: int, radius: float = 2.0) -> np.ndarray:
    angle = np.linspace(0.0, 2.0, n)
    return np.column_stack([radius * np.sin(angle), radius * (1.0 - np.cos(angle)), angle])


def seen_from(poses: np.ndarray, x: float, y: float, theta: float) -> np.ndarray:
    c, s = math.cos(theta), math.sin(theta)
    return np.column_stack([x + poses[:, :2] @ [c, -s], y + poses[:, :2] @ [s, c], poses[:, 2] + theta])


def test_one_path_in_two_frames_is_the_same() -> None:
    path = circle(50)
    assert is_same_path(path, seen_from(path, 300.0, -20.0, 2.9))
    assert not is_same_path(path, circle(50, 2.01))
    assert not is_same_path(path, path[:-1])
    assert is_same_path(path[:0], path[:0])


def test_headings_and_a_single_pose_tell_paths_apart() -> None:
    still = np.zeros((500, 3))
    turning, less = still.copy(), still.copy()
    turning[:, 2], less[:, 2] = np.linspace(0.0, 6.0, 500), np.linspace(0.0, 4.8, 500)
    assert is_same_path(turning, turning + np.array([1.0, 2.0, 0.0]))
    assert not is_same_path(turning, less)
    for at in (1, 250, 499):
        moved = turning.copy()
        moved[at, 0] += 0.01
        assert not is_same_path(turning, moved)


def test_what_was_stated_before_is_named() -> None:
    path, other = circle(20), circle(20, 3.0)
    named = {"odom": path, "tf/odom": seen_from(path, 1.0, 2.0, 0.3), "SLAM": other, "again": path}
    found = stated_before({name: Trajectory(poses) for name, poses in named.items()})
    assert found == {"tf/odom": "odom", "again": "odom"}


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("true odom SLAM*", ("SLAM", "odom")),
        ("odom tf/map SLAM* SLAM-2*", ("SLAM-2", "odom")),
        ("scan SLAM*", ("SLAM", "scan")),
        ("odom better", ("odom", "better")),
        ("odom", None),
    ],
)
def test_slam_is_compared_with_the_wheels_first(names: str, expected: tuple[str, str] | None) -> None:
    """Names with a star are of poses that were found from the scans."""
    found = {
        name.rstrip("*"): Trajectory(circle(20, 2.0 + n), from_scans=name.endswith("*"))
        for n, name in enumerate(names.split())
    }
    assert first_pair(found, {}) == expected


@pytest.mark.parametrize(
    ("names", "same", "expected"),
    [
        ("odom tf/odom better", {"tf/odom": "odom"}, ("odom", "better")),
        ("odom SLAM* gps", {"SLAM": "odom"}, ("odom", "gps")),
        ("odom tf/odom", {"tf/odom": "odom"}, ("odom", "tf/odom")),
    ],
)
def test_one_path_is_not_compared_with_itself_where_there_are_two(
    names: str, same: dict[str, str], expected: tuple[str, str]
) -> None:
    found = {name.rstrip("*"): Trajectory(circle(20), from_scans=name.endswith("*")) for name in names.split()}
    assert first_pair(found, same) == expected
