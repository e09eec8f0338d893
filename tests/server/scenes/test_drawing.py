"""Beams and paths lie where the numbers say."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest

from mapper.core.se2 import transform_points
from mapper.mapping.parameters import MappingConfig
from server.scenes.drawing import BEAM_START, MAX_BEAMS, MAX_PATH, beam_segments, path_segments
from server.sessions import SessionView


@dataclass
class View:
    ranges: np.ndarray
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sensor_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angle_increment: float = np.pi / 2
    range_max: float = 10.0
    config: MappingConfig = field(default_factory=MappingConfig)

    @property
    def angles(self) -> np.ndarray:
        return self.angle_increment * np.arange(len(self.ranges))


def segments_of(view: View) -> np.ndarray:
    return beam_segments(cast("SessionView", view))


def test_beams_end_where_they_hit_seen_from_the_robot() -> None:
    # The robot stands at (10, 5) and looks along +y; the sensor sits 1 m ahead of its middle.
    view = View(np.array([2.0, 3.0]), pose=(10.0, 5.0, np.pi / 2), sensor_pose=(10.0, 6.0, np.pi / 2))
    segments = segments_of(view)
    ends = transform_points(view.pose, segments[:, 1, :2])
    np.testing.assert_allclose(ends, [(10.0, 8.0), (7.0, 6.0)], atol=1e-5)
    starts = transform_points(view.pose, segments[:, 0, :2])
    np.testing.assert_allclose(starts, [(10.0, 6.0 + BEAM_START), (10.0 - BEAM_START, 6.0)], atol=1e-5)


def test_the_correction_of_the_mount_turns_the_beams() -> None:
    config = MappingConfig(mount_x=0.5, mount_yaw=np.pi / 2)
    segments = segments_of(View(np.array([2.0]), config=config))
    assert segments[0, 1, :2] == pytest.approx((0.5, 2.0), abs=1e-5)


def test_what_hit_nothing_is_not_drawn() -> None:
    ranges = np.array([np.nan, np.inf, -np.inf, 0.0, 0.1, 10.1, 9.0], dtype=np.float32)
    assert len(segments_of(View(ranges))) == 1
    assert segments_of(View(np.zeros(0))).shape == (0, 2, 3)


def test_many_beams_are_thinned_evenly() -> None:
    view = View(np.full(1000, 4.0), angle_increment=0.001)
    segments = segments_of(view)
    assert MAX_BEAMS / 2 < len(segments) <= MAX_BEAMS
    angles = np.arctan2(segments[:, 1, 1], segments[:, 1, 0])
    assert angles[0] == pytest.approx(0.0)
    np.testing.assert_allclose(np.diff(angles), np.diff(angles)[0], atol=1e-5)


@pytest.mark.parametrize("n", [1, 2, 50, 3 * MAX_PATH])
def test_a_path_is_one_line(n: int) -> None:
    poses = np.column_stack([np.linspace(0, 9, n), np.linspace(0, 3, n), np.zeros(n)])
    segments = path_segments(poses)
    assert len(segments) <= MAX_PATH
    assert segments.shape[1:] == (2, 3)
    np.testing.assert_array_equal(segments[1:, 0], segments[:-1, 1])
    if n > 1:
        assert segments[0, 0, :2] == pytest.approx((0.0, 0.0))
