"""What a click into a 3D view means while its page measures: exact places on voxels, points and the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.mesh.faces import FaceRule, face_rule
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.voxel_questions import place_met
from server.sessions.commands import on_floor

SIDE = 0.1
WALL = np.array([[2.05, y, z] for y in np.arange(-0.95, 1.0, SIDE) for z in np.arange(0.05, 1.0, SIDE)])


@dataclass
class Mapped:
    """A wall of voxels whose sides towards −x are at x = 2 m, seen from the origin."""

    volume: OccupancyVolume
    config: VolumeConfig
    index: int = 1

    def placed_scans(self) -> tuple[PlacedScan, ...]:
        return ()


@pytest.fixture
def wall() -> Mapped:
    volume = OccupancyVolume(VolumeConfig(resolution=SIDE))
    volume.insert_scan(WALL.astype(np.float32), np.array([0.0, 0.0, 0.5]))
    return Mapped(volume, volume.config)


def rule_of(wall: Mapped) -> FaceRule:
    return face_rule(wall.volume, -np.inf, np.inf, base=0.0, band=1e6, colours=1)


@pytest.mark.parametrize("towards", [(1.0, 0.0, 0.0), (1.0, 0.2, 0.1), (3.0, -0.6, 0.2)])
def test_a_line_of_sight_ends_on_the_side_of_a_voxel(wall: Mapped, towards: tuple[float, float, float]) -> None:
    start, away = np.array([0.0, 0.02, 0.52]), np.array(towards)
    found = place_met(wall, rule_of(wall), (start, away), None)
    assert found is not None
    np.testing.assert_allclose(found[0], start + 2.0 / away[0] * away, atol=1e-4)
    assert found[1] == SIDE


def test_where_points_are_drawn_the_nearest_of_the_voxel_is_meant(wall: Mapped) -> None:
    points = np.array([[2.02, 0.03, 0.52], [2.08, 0.08, 0.58]], np.float32)
    scans = ScanSequence("pcd", points, np.array([0, 2]), np.zeros((1, 3)), np.zeros(1, np.int64), np.zeros(3))
    line = np.array([0.0, 0.02, 0.52]), np.array([1.0, 0.0, 0.0])
    found = place_met(wall, rule_of(wall), line, scans)
    assert found is not None
    assert found[0] == pytest.approx(points[0].tolist(), abs=1e-4)
    assert found[1] == 0.0
    # Beside the points the voxel has none: it is its side that is meant.
    beside = place_met(wall, rule_of(wall), (np.array([0.0, 0.22, 0.52]), np.array([1.0, 0.0, 0.0])), scans)
    assert beside is not None
    assert beside[0] == pytest.approx((2.0, 0.22, 0.52))
    assert beside[1] == SIDE


def test_the_sky_means_nothing(wall: Mapped) -> None:
    line = np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, 1.0])
    assert place_met(wall, rule_of(wall), line, None) is None
    assert on_floor((0.0, 0.0, 1.0), (1.0, 0.0, 0.5)) is None


def test_the_floor_is_met_from_above_and_from_below() -> None:
    for height in (2.0, -2.0):
        place = on_floor((1.0, 1.0, height), (0.5, 0.25, -math.copysign(1.0, height)))
        assert place == pytest.approx((2.0, 1.5))
