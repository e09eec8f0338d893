"""Maps of files: a scan graph, depth images, a cloud without a sensor's place, a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, ReadError, WorkCancelledError
from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.scans.sources import Insertion, insert_all, open_source
from tests.mapper.io.logs.recorded import cloud, odometry, transform, written
from tests.mapper.volume.voxel_values import log_odds_at

CONFIG = VolumeConfig(resolution=0.1)


def mapped(path: Path, **options) -> tuple[OccupancyVolume, Insertion, list[str]]:
    volume, did = OccupancyVolume(CONFIG), Insertion()
    source = open_source(path, **options)
    insert_all(volume, source, did)
    return volume, did, source.notes


def pcd(folder: Path, points: list[list[float]], viewpoint: str = "") -> Path:
    lines = ["# .PCD v0.7", "VERSION 0.7", "FIELDS x y z", "SIZE 8 8 8", "TYPE F F F", "COUNT 1 1 1"]
    lines += [f"WIDTH {len(points)}", "HEIGHT 1", *([f"VIEWPOINT {viewpoint}"] if viewpoint else [])]
    lines += [f"POINTS {len(points)}", "DATA ascii", *(" ".join(map(str, point)) for point in points)]
    path = folder / "cloud.pcd"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_scans_of_a_graph_begin_at_their_poses(tmp_path: Path) -> None:
    path = tmp_path / "two.graph"
    path.write_text("NODE 0.05 0.05 0.05 0 0 0\n1.0 0 0\nNODE 0.05 1.05 0.05 0 0 1.5707963267948966\n1.0 0 0\n")
    volume, did, _ = mapped(path)
    assert (did.scans, did.points, did.left_out) == (2, 2, 0)
    values = log_odds_at(volume, [[1.05, 0.05, 0.05], [0.55, 0.05, 0.05], [0.05, 2.05, 0.05], [0.05, 1.55, 0.05]])
    assert (values > 0.0).tolist() == [True, False, True, False]
    assert np.isfinite(values).all()


def test_a_cloud_without_a_sensor_frees_nothing(tmp_path: Path) -> None:
    path = pcd(tmp_path, [[1.05, 0.05, 0.05], [float("nan"), 0.0, 0.0]])
    volume, _, notes = mapped(path)
    assert volume.n_known == 1
    assert any("does not say where the sensor was" in note for note in notes)
    placed, _, _ = mapped(path, sensor=np.array([0.05, 0.05, 0.05]))
    assert placed.n_known == 11


def test_points_that_are_all_too_far_are_an_error(tmp_path: Path) -> None:
    path = pcd(tmp_path, [[512_000.0, 5_400_000.0, 300.0]])
    with pytest.raises(ConfigError, match=r"within 3276\.8 m of 0 along each axis"):
        mapped(path)


def test_a_log_of_planar_scans_is_no_cloud(data_file) -> None:
    with pytest.raises(ReadError, match="not a recording"):
        open_source(data_file("carmen/loop5.log.gz"))


def test_real_depth_images_fill_a_room(data_file) -> None:
    volume, source = OccupancyVolume(CONFIG), open_source(data_file("depth/camera-intrinsics.txt").parent)
    assert source.count == 13
    source.scans = iter([next(source.scans) for _ in range(2)])
    insert_all(volume, source, Insertion())
    first = next(open_source(data_file("depth/camera-intrinsics.txt").parent).scans)
    values = log_odds_at(volume, first.points[::977])
    assert (values > 0.0).mean() > 0.9
    assert first.origin is not None
    middle = (first.origin + first.points[::977]) / 2.0
    assert (log_odds_at(volume, middle) < 0.0).mean() > 0.9


def test_a_map_can_be_cancelled(tmp_path: Path) -> None:
    path = pcd(tmp_path, [[1.0, 0.0, 0.0]])
    with pytest.raises(WorkCancelledError, match="after 0 scans"):
        insert_all(OccupancyVolume(CONFIG), open_source(path), Insertion(), is_cancelled=lambda: True)


def test_clouds_of_a_recording_are_placed_by_mount_and_odometry(tmp_path: Path) -> None:
    """A sensor that hangs upside down at a height of 1 m, on a robot that moves 2 m in between."""
    second = 10**9
    ahead = [[1.0, 0.0, 0.3]]
    said = [
        transform(second, "base_link", "velodyne", 0.05, 0.05, 0.0, np.pi, z=1.05, topic="/tf_static"),
        odometry(second, 0.0, 0.0, 0.0),
        cloud(second, np.array(ahead)),
        odometry(2 * second, 2.0, 0.0, np.pi / 2),
        cloud(2 * second, np.array(ahead)),
        cloud(3 * second, np.array(ahead)),
    ]
    volume, did, notes = mapped(written(tmp_path, said, "mcap"))
    assert did.scans == 2
    hits, _ = volume.voxels(0.0)
    np.testing.assert_array_equal(np.sort((hits - 32768) // 1, axis=0), [[10, 0, 7], [19, 10, 7]])
    assert "1 of 3 clouds have no pose and are left out." in notes


def test_a_topic_that_is_not_there_is_named(tmp_path: Path) -> None:
    said = [transform(1, "base_link", "velodyne"), cloud(1, np.ones((1, 3)))]
    with pytest.raises(ReadError, match="no clouds on '/other'; it has them on: /points"):
        open_source(written(tmp_path, said, "bag"), topic="/other")
