"""Clouds and depth images of recordings along their transforms, beside poses composed by SciPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mapper.core.errors import ReadError
from mapper.io.clouds import PointCloud, open_posed_clouds
from mapper.io.clouds.posed import deskewed
from tests.mapper.io.logs.recorded import SECOND, Said, camera, cloud, image, odometry, transform, written

T0 = 1000 * SECOND
POINTS = np.array([[1.0, 0.0, 0.2], [0.0, 2.0, 0.4], [np.nan, 0.0, 0.0]])


def base_in_map(k: int) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", 0.2 * k).as_matrix()
    pose[:3, 3] = (0.5 * k, 0.1, 0.0)
    return pose


def at(xyz: tuple[float, float, float], rotation: Rotation | None = None) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = xyz
    if rotation is not None:
        pose[:3, :3] = rotation.as_matrix()
    return pose


def drive(*, with_tf: bool) -> list[Said]:
    said = [transform(T0, "base_link", "velodyne", 0.3, 0.0, z=1.0, topic="/tf_static")]
    for k in range(4):
        stamp = T0 + k * SECOND
        moved = transform(stamp, "odom", "base_link", 0.5 * k, 0.1, 0.2 * k)
        said.append(moved if with_tf else odometry(stamp, 0.5 * k, 0.1, 0.2 * k))
        said.append(cloud(stamp, POINTS))
    return said


@pytest.mark.parametrize("with_tf", [True, False])
def test_clouds_lie_where_the_recording_s_poses_put_them(with_tf: bool, tmp_path: Path) -> None:
    clouds = list(open_posed_clouds(written(tmp_path, drive(with_tf=with_tf), "mcap")))
    assert len(clouds) == 4
    for k, one in enumerate(clouds):
        expected = base_in_map(k) @ at((0.3, 0.0, 1.0))
        np.testing.assert_allclose(one.pose, expected, atol=1e-9)
        np.testing.assert_allclose(one.points_in_map()[1], (expected @ [0.0, 2.0, 0.4, 1.0])[:3], atol=1e-6)
        assert one.cloud.finite.tolist() == [True, True, False]


def test_clouds_follow_the_trajectory_and_the_time_offset_that_are_wanted(tmp_path: Path) -> None:
    said = [one for one in drive(with_tf=True) if one.topic != "/odom"]
    said += [odometry(T0 + k * SECOND, 0.5 * k + 7.0, 0.1, 0.2 * k) for k in range(4)]
    path = written(tmp_path, sorted(said, key=lambda one: one.stamp_ns), "mcap")

    def places(**options: Any) -> list[tuple[float, ...]]:
        return [tuple(one.pose[:3, 3].round(6)) for one in open_posed_clouds(path, **options)]

    plain = places()
    assert places(trajectory="tf/odom") == plain
    np.testing.assert_allclose(np.subtract(places(trajectory="odom"), plain), [[7.0, 0.0, 0.0]] * 4, atol=1e-6)
    assert places(time_offset=1.0) == plain[1:], "the last cloud is behind the last pose then"
    with pytest.raises(ReadError, match=r"no trajectory 'gps' of 'velodyne'; it has 'tf/odom', 'odom'\."):
        places(trajectory="gps")


def test_clouds_without_poses_are_told_and_those_outside_left_out(tmp_path: Path) -> None:
    alone = written(tmp_path, [cloud(T0, POINTS)], "mcap")
    with pytest.raises(ReadError, match="Nothing in the recording says where the frame 'velodyne' of /points was"):
        list(open_posed_clouds(alone))
    later = tmp_path / "later"
    later.mkdir()
    said = [*drive(with_tf=True), cloud(T0 + 60 * SECOND, POINTS)]
    assert len(list(open_posed_clouds(written(later, said, "mcap")))) == 4
    with pytest.raises(ReadError, match=r"no clouds on '/front'; it has them on: /points"):
        open_posed_clouds(alone, topic="/front")


def test_depth_images_become_clouds_of_the_optical_frame(tmp_path: Path) -> None:
    depth = np.array([[1000, 0, 2000], [3000, 0, 4000]])
    said = [transform(T0, "odom", "optical", 1.0, 2.0), transform(T0 + SECOND, "odom", "optical", 3.0, 2.0)]
    said += [camera(T0, (3, 2), 5.0), *(image(T0 + k * SECOND, depth) for k in range(2))]
    path = written(tmp_path, said, "mcap")
    first, second = open_posed_clouds(path)
    assert first.cloud.shape == (2, 3)
    assert first.cloud.finite.tolist() == [True, False, True, True, False, True]
    cx, cy = 1.0, 0.5
    np.testing.assert_allclose(first.cloud.points[5], [(2 - cx) / 5 * 4, (1 - cy) / 5 * 4, 4.0], atol=1e-6)
    np.testing.assert_allclose(second.origin, [3.0, 2.0, 0.0])
    without = tmp_path / "without"
    without.mkdir()
    with pytest.raises(ReadError, match="have no CameraInfo on /camera/depth/camera_info"):
        list(open_posed_clouds(written(without, [one for one in said if "Info" not in one.kind], "mcap")))


def test_points_are_put_where_they_are_seen_from_the_pose_at_the_stamp() -> None:
    """A sensor that turns and moves while it sweeps round, in a room whose points stand still."""

    def poses(_: str, stamps_ns: np.ndarray) -> np.ndarray:
        seconds = (np.asarray(stamps_ns) - T0) * 1e-9
        out = np.tile(np.eye(4), (len(seconds), 1, 1))
        out[:, :3, :3] = Rotation.from_euler("z", 2.0 * seconds[:, None]).as_matrix()
        out[:, 0, 3] = 1.5 * seconds
        return out

    rng = np.random.default_rng(3)
    true = rng.uniform(-5, 5, (500, 3))
    times = np.linspace(0.0, 0.1, 500)
    back = np.linalg.inv(poses("", T0 + np.round(times * 1e9).astype(np.int64)))
    seen = np.einsum("nij,nj->ni", back[:, :3, :3], true) + back[:, :3, 3]
    cloud = PointCloud(seen, T0, "velodyne", times=times)
    assert np.abs(seen - true).max() > 0.5
    assert np.abs(deskewed(cloud, poses).points - true).max() < 0.01
    assert deskewed(PointCloud(seen, T0), poses).points is seen
