"""Colours of points and voxels by intensity, time and the difference from another cloud, with their scales."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.drawings import VolumeDrawings
from server.parts.volume.look import COLOURS, HEIGHT_RAMP, Look
from server.parts.volume.point_values import PointValues
from server.sessions.drawings import Points, Voxels
from server.stream.message_parts import ColourScale

NEAR, FAR = 0.5, 2.5  #: x of two rows of points


def rows(*, stamped: bool = True) -> ScanSequence:
    """Two scans, a second and a half apart: a row of 40 points each, 0.1 m apart, the second 2 m behind the first."""
    y = 0.05 + 0.1 * np.arange(40)
    points = np.concatenate([np.column_stack([np.full(40, x), y, np.full(40, 0.05)]) for x in (NEAR, FAR)])
    stamps = np.array([7_000_000_000, 8_500_000_000]) if stamped else np.zeros(2, np.int64)
    return ScanSequence("pcd", points.astype(np.float32), np.array([0, 40, 80]), np.zeros((2, 3)), stamps, np.zeros(3))


def drawn_by(colour: str, scans: ScanSequence, other: ScanSequence | None = None, show: str = "points") -> list[object]:
    """The drawings of a map of all scans."""
    volume = OccupancyVolume(VolumeConfig(resolution=0.1))
    volume.insert_scan(scans.points, np.array([0.0, 2.0, 0.05]))
    low, high = scans.points.min(axis=0).astype(float), scans.points.max(axis=0).astype(float)
    drawings = VolumeDrawings(scans, low, high, PointValues(scans, other))
    look = Look(show=show, colour=colour)
    drawings.note_change(volume, None)
    while drawings.is_stale:
        drawings.work(volume, len(scans), look, has_free=False, is_over=lambda: False)
    return list(drawings.current(volume, look))


@pytest.mark.parametrize(
    ("stamped", "scale"), [(True, ColourScale(0.0, 1.5, "s")), (False, ColourScale(1.0, 2.0, "scan"))]
)
def test_points_are_coloured_by_the_time_of_their_scan(stamped: bool, scale: ColourScale) -> None:
    scans = rows(stamped=stamped)
    values = PointValues(scans)
    assert values.names == ["time"]
    assert values.scale("time") is None, "not computed yet"
    np.testing.assert_array_equal(values.bands("time"), np.repeat([0, COLOURS - 1], 40))
    assert values.scale("time") == scale
    (points,) = (one for one in drawn_by("time", scans) if isinstance(one, Points))
    assert isinstance(points.colors, np.ndarray)
    of_first = points.points[:, 0] < 1.0
    np.testing.assert_array_equal(points.colors[of_first], np.tile(HEIGHT_RAMP[0], (40, 1)))
    np.testing.assert_array_equal(points.colors[~of_first], np.tile(HEIGHT_RAMP[-1], (40, 1)))


def test_voxels_have_the_colour_of_most_of_their_points() -> None:
    (voxels,) = (one for one in drawn_by("time", rows(), show="voxels") if isinstance(one, Voxels))
    quads = np.concatenate(list(voxels.chunks.values()))
    assert set(quads[:, 6].tolist()) == {1, COLOURS}
    assert voxels.palette is HEIGHT_RAMP


def test_a_cloud_is_coloured_by_how_far_the_other_one_is() -> None:
    # The other cloud is the first row, given from 100 m farther on; the second row is 2 m away from it.
    scans = rows()
    other = replace(
        scans, points=scans.points[:40] - np.float32(100.0), starts=np.array([0, 40]), offset=np.full(3, 100.0)
    )
    values = PointValues(scans, other)
    assert values.names == ["time", "difference"]
    bands = values.bands("difference")
    scale = values.scale("difference")
    assert scale is not None
    assert (scale.low, scale.unit) == (0.0, "m")
    assert scale.high == pytest.approx(FAR - NEAR, abs=1e-4)
    np.testing.assert_array_equal(bands, np.repeat([0, COLOURS - 1], 40))


def test_equal_clouds_do_not_differ() -> None:
    values = PointValues(rows(), rows())
    assert not values.bands("difference").any()
    assert values.scale("difference") == ColourScale(0.0, 0.01, "m")


def test_the_scale_of_intensity_leaves_out_a_hundredth_at_either_end() -> None:
    intensity = np.linspace(0.0, 100.0, 80).astype(np.float32)
    intensity[40] = np.nan
    values = PointValues(replace(rows(), fields={"intensity": intensity}))
    bands = values.bands("intensity")
    scale = values.scale("intensity")
    assert scale is not None
    assert [scale.low, scale.high] == pytest.approx([1.0, 99.0], abs=0.1)
    assert scale.unit == ""
    assert bands[[0, 40, 79]].tolist() == [0, 0, COLOURS - 1]
    assert (np.diff(np.delete(bands, 40).astype(int)) >= 0).all()
