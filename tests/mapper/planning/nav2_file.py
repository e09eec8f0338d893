"""Planner and follower of a Nav2 parameter file."""

from __future__ import annotations

from mapper.io.ros_parameters import parse_ros_parameters
from mapper.planning.nav2_parameters import Nav2Path, path_of


def parse_nav2_path(data: bytes) -> Nav2Path:
    """Return what :func:`mapper.planning.nav2_parameters.path_of` reads in a file."""
    return path_of(parse_ros_parameters(data))
