"""Samples of a cloud in rows, 16 rings of a lidar in turn: every 16th point of it is of one ring."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume import cloud_points, drawings, point_values, start
from server.parts.volume.cloud_points import CloudPoints
from server.parts.volume.drawings import VolumeDrawings
from server.parts.volume.look import Look
from server.parts.volume.point_values import PointValues
from server.parts.volume.start import bounds_of, first_resolution
from server.sessions.drawings import Points

RINGS, COLUMNS = 16, 10_000
SIZE = RINGS * COLUMNS
HEIGHTS = np.linspace(0.0, 3.0, RINGS, dtype=np.float32)
LOW, HIGH = np.array([-5.0, -5.0, 0.0]), np.array([5.0, 5.0, 3.0])


def cloud(points: NDArray[np.float32]) -> ScanSequence:
    nowhere = np.full((1, 3), np.nan)
    classes = {"class": np.rint(points[:, 2] / HEIGHTS[1]).astype(np.int64) // 2}  # of two rings each, from 0 on
    return ScanSequence("pcd", points, np.array([0, len(points)]), nowhere, np.zeros(1, np.int64), np.zeros(3), classes)


def in_rows(radius: float = 5.0) -> ScanSequence:
    azimuths = np.repeat(np.linspace(0.0, 2.0 * np.pi, COLUMNS, endpoint=False), RINGS)
    points = np.column_stack([radius * np.cos(azimuths), radius * np.sin(azimuths), np.tile(HEIGHTS, COLUMNS)])
    return cloud(points.astype(np.float32))


def rings(points: NDArray[np.floating]) -> int:
    return len(np.unique(points[:, 2]))


def test_bounds_and_resolution_are_those_of_the_cloud_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(start, "MOST_LOOKED_AT", COLUMNS)
    monkeypatch.setattr(start, "MOST_COUNTED", COLUMNS // 2)
    scans = in_rows(radius=2.0)
    shuffled = cloud(np.random.default_rng(1).permutation(scans.points))
    low, high = bounds_of(scans)
    np.testing.assert_allclose([low, high], [[-2.0, -2.0, 0.0], [2.0, 2.0, 3.0]], atol=0.01)
    assert first_resolution(scans, low, high) == first_resolution(shuffled, low, high) == 0.05


def test_terrain_is_of_all_rings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cloud_points, "MOST_POINTS", COLUMNS)
    points, _, ground = CloudPoints(in_rows(), LOW, HIGH).read()
    assert ground is not None
    assert rings(points) == RINGS
    assert (ground == np.isin(points[:, 2], HEIGHTS[4:6])).all()  # the class of ground is 2


def test_the_difference_is_that_of_near_points_of_all_rings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_values, "MOST_COMPARED", COLUMNS)
    scans = in_rows()
    values = PointValues(scans, cloud(scans.points * np.array([1.0, 1.0, 1.1], dtype=np.float32)))
    assert len(values.bands("difference")) == SIZE
    scale = values.scale("difference")
    assert scale is not None
    assert scale.high > 0.05  # that of the lowest ring is 0


@pytest.mark.parametrize("index", [0, 1])
def test_points_are_drawn_of_all_rings(monkeypatch: pytest.MonkeyPatch, index: int) -> None:
    monkeypatch.setattr(drawings, "MOST_MOVING" if index == 0 else "MOST_POINTS", COLUMNS)
    scans, look, volume = in_rows(), Look(show="points", cut_high=10.0), OccupancyVolume(VolumeConfig(resolution=0.1))
    drawn = VolumeDrawings(scans, LOW, HIGH, PointValues(scans))
    if index == 0:
        drawn.show_newest(1, look)
    else:
        drawn.note_change(volume, None)
        drawn.work(volume, 1, look, has_free=False, is_over=lambda: False)
    points = [one.points for one in drawn.current(volume, look) if isinstance(one, Points)]
    assert sum(map(len, points)) == COLUMNS
    assert rings(np.concatenate(points)) == RINGS


def test_voxels_have_the_classes_of_all_rings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawings, "MOST_CLASSED", COLUMNS)
    scans, look, volume = in_rows(), Look(colour="class"), OccupancyVolume(VolumeConfig(resolution=0.1))
    volume.insert_scan(scans.points, np.array([0.0, 0.0, 1.0]))
    drawn = VolumeDrawings(scans, LOW, HIGH, PointValues(scans))
    drawn.note_change(volume, None)
    drawn.work(volume, 1, look, has_free=True, is_over=lambda: False)
    colours = np.concatenate([faces[:, -1] for faces in drawn.faces.chunks.values()])
    assert set(range(1, 1 + RINGS // 2)) <= set(colours.tolist())
