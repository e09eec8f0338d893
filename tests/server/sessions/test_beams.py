"""Positions of beams in the 3D view."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.se2 import transform_points
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan
from server.sessions.view import Pose, RobotState
from server.sources.map_drawings import BEAM_START, MAX_BEAMS, beam_segments


def segments_of(
    ranges: np.ndarray,
    *,
    pose: Pose = (0.0, 0.0, 0.0),
    sensor_pose: Pose = (0.0, 0.0, 0.0),
    angle_increment: float = np.pi / 2,
    config: MappingConfig | None = None,
) -> np.ndarray:
    scan = LaserScan(
        ranges=ranges.astype(np.float32),
        angle_min=0.0,
        angle_increment=angle_increment,
        range_min=0.0,
        range_max=10.0,
        stamp_ns=0,
    )
    return beam_segments(RobotState(pose, sensor_pose, sensor_pose, scan, 0.0), config or MappingConfig())


def test_beams_end_where_they_hit_seen_from_the_robot() -> None:
    # The robot stands at (10, 5) and looks along +y; the sensor sits 1 m ahead of its middle.
    pose = (10.0, 5.0, np.pi / 2)
    segments = segments_of(np.array([2.0, 3.0]), pose=pose, sensor_pose=(10.0, 6.0, np.pi / 2))
    ends = transform_points(pose, segments[:, 1, :2])
    np.testing.assert_allclose(ends, [(10.0, 8.0), (7.0, 6.0)], atol=1e-5)
    starts = transform_points(pose, segments[:, 0, :2])
    np.testing.assert_allclose(starts, [(10.0, 6.0 + BEAM_START), (10.0 - BEAM_START, 6.0)], atol=1e-5)


def test_the_correction_of_the_mount_turns_the_beams() -> None:
    config = MappingConfig(mount_x=0.5, mount_yaw=np.pi / 2)
    segments = segments_of(np.array([2.0]), config=config)
    assert segments[0, 1, :2] == pytest.approx((0.5, 2.0), abs=1e-5)


def test_beams_without_a_hit_are_not_drawn() -> None:
    ranges = np.array([np.nan, np.inf, -np.inf, 0.0, 0.1, 10.1, 9.0], dtype=np.float32)
    assert len(segments_of(ranges)) == 1
    assert segments_of(np.zeros(0)).shape == (0, 2, 3)


def test_a_shorter_range_among_the_parameters_leaves_beams_out() -> None:
    assert len(segments_of(np.array([2.0, 6.0]), config=MappingConfig(range_max=5.0))) == 1


def test_many_beams_are_thinned_evenly() -> None:
    segments = segments_of(np.full(1000, 4.0), angle_increment=0.001)
    assert MAX_BEAMS / 2 < len(segments) <= MAX_BEAMS
    angles = np.arctan2(segments[:, 1, 1], segments[:, 1, 0])
    assert angles[0] == pytest.approx(0.0)
    np.testing.assert_allclose(np.diff(angles), np.diff(angles)[0], atol=1e-5)
