"""Folders of depth images: real ones of 7-Scenes, and small ones of both kinds."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ReadError
from mapper.io.clouds import read_depth_folder

DEPTHS = np.array([[1000, 0, 2000], [65535, 4000, 5000]], dtype=np.uint16)
STILL = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def seven_scenes(folder: Path, depths: np.ndarray = DEPTHS, pose: str = STILL) -> Path:
    Image.fromarray(depths).save(folder / "frame-000000.depth.png")
    (folder / "frame-000000.pose.txt").write_text(pose)
    (folder / "camera-intrinsics.txt").write_text("2 0 1\n0 4 0.5\n0 0 1\n")
    return folder


def tum(folder: Path, depths: np.ndarray = DEPTHS) -> Path:
    (folder / "depth").mkdir()
    (folder / "intrinsics.txt").write_text("2 4 1 0.5\n")
    lines = ["# depth maps"]
    for stamp in ("100.000000", "100.050000", "100.100000", "200.000000"):
        Image.fromarray(depths).save(folder / "depth" / f"{stamp}.png")
        lines.append(f"{stamp} depth/{stamp}.png")
    (folder / "depth.txt").write_text("\n".join(lines))
    half = math.sqrt(0.5)
    (folder / "groundtruth.txt").write_text(f"100 0 0 0 0 0 0 1\n100.1 2 0 0 0 0 {half} {half}\n")
    return folder


def test_real_frames_are_what_their_files_say(data_dir: Path) -> None:
    folder = read_depth_folder(data_dir / "depth")
    assert len(folder) == 13
    assert folder.notes == ()
    assert (folder.camera.width, folder.camera.height) == (640, 480)
    frame = folder.frames[3]
    assert frame.name == "frame-000120.depth.png"
    assert np.array_equal(frame.pose, np.loadtxt(data_dir / "depth" / "frame-000120.pose.txt"))
    raw = np.asarray(Image.open(data_dir / "depth" / "frame-000120.depth.png"))
    depth = frame.read()
    assert np.array_equal(np.isnan(depth), (raw == 0) | (raw == 65535))
    v, u = 200, 311
    z = raw[v, u] / 1000.0
    (cloud,) = list(type(folder)(folder.camera, (frame,)).clouds())
    point = cloud.cloud.points[v * 640 + u]
    assert point == pytest.approx([(u - 320) * z / 585, (v - 240) * z / 585, z], rel=1e-6)
    assert cloud.points_in_map()[v * 640 + u] == pytest.approx((frame.pose @ [*point, 1.0])[:3], rel=1e-9)


def test_two_real_frames_see_the_same_room(data_dir: Path) -> None:
    """Poses and pixels agree: most points of one frame lie within 5 cm of another frame taken nearby."""
    folder = read_depth_folder(data_dir / "depth")
    first, second = folder.frames[0], folder.frames[1]
    clouds = list(type(folder)(folder.camera, (first, second)).clouds())
    points = clouds[0].points_in_map()[::97]
    back = np.linalg.inv(second.pose)
    seen = points[np.isfinite(points).all(axis=1)] @ back[:3, :3].T + back[:3, 3]
    u = np.round(585 * seen[:, 0] / seen[:, 2] + 320).astype(int)
    v = np.round(585 * seen[:, 1] / seen[:, 2] + 240).astype(int)
    inside = (u >= 0) & (u < 640) & (v >= 0) & (v < 480)
    off = np.abs(second.read()[v[inside], u[inside]] - seen[inside, 2])
    off = off[np.isfinite(off)]
    assert len(off) > 1000
    assert np.mean(off < 0.05) > 0.9


def test_a_folder_of_tum_has_poses_between_those_of_its_ground_truth(tmp_path: Path) -> None:
    folder = read_depth_folder(tum(tmp_path))
    assert [frame.stamp_ns for frame in folder.frames] == [100_000_000_000, 100_050_000_000, 100_100_000_000]
    middle = folder.frames[1].pose
    half = math.sqrt(0.5)  # 45°
    assert middle == pytest.approx(np.array([[half, -half, 0, 1], [half, half, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]))
    assert folder.notes == ("1 of 4 depth images have no pose and are left out, the first 200.000000.png.",)
    expected = np.array([[0.2, np.nan, 0.4], [np.nan, 0.8, 1.0]])
    assert folder.frames[0].read() == pytest.approx(expected, nan_ok=True)


def test_pixels_become_points_through_both_focal_lengths(tmp_path: Path) -> None:
    (cloud,) = read_depth_folder(seven_scenes(tmp_path)).clouds()
    assert cloud.cloud.shape == (2, 3)
    assert cloud.cloud.points[5] == pytest.approx([(2 - 1) / 2 * 5.0, (1 - 0.5) / 4 * 5.0, 5.0])
    assert cloud.cloud.finite.tolist() == [True, False, True, False, True, True]


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("frame-000000.pose.txt", STILL.replace("1 0 0 0", "2 0 0 0"), "frame-000000.depth.png is not a rotation"),
        ("frame-000000.pose.txt", STILL.replace("1 0 0 0", "-1 0 0 0"), "a reflection, not a rotation"),
        ("frame-000000.pose.txt", STILL.replace("1 0 0 0", "nan 0 0 0"), "is not finite"),
        ("frame-000000.pose.txt", "1 0 0\n", "holds 1 × 3 numbers, not 4 × 4"),
        ("frame-000000.pose.txt", "\n", "holds 0 × 0 numbers"),
        ("camera-intrinsics.txt", "0 0 1\n0 4 0\n0 0 1\n", "focal lengths must be positive"),
        ("camera-intrinsics.txt", "500 0 320\n0 500 240\n0 0 1\n", "is of images of another size"),
        ("camera-intrinsics.txt", "1 2\n", "neither a matrix of 3 × 3"),
        ("frame-000000.depth.png", "no image", "frame-000000.depth.png is not a PNG image"),
    ],
)
def test_a_folder_of_wrong_files_is_told(name: str, text: str, sentence: str, tmp_path: Path) -> None:
    seven_scenes(tmp_path)
    (tmp_path / name).write_text(text)
    with pytest.raises(ReadError, match=sentence):
        list(read_depth_folder(tmp_path).clouds())


def test_a_frame_of_another_size_or_kind_is_told_with_its_name(tmp_path: Path) -> None:
    seven_scenes(tmp_path)
    (tmp_path / "frame-000001.pose.txt").write_text(STILL)
    other = tmp_path / "frame-000001.depth.png"
    Image.fromarray(DEPTHS[:, :2]).save(other)
    folder = read_depth_folder(tmp_path)
    with pytest.raises(ReadError, match=r"frame-000001.depth.png: an image of 2 × 2 pixels has intrinsics for 3 × 2"):
        folder.frames[1].read()
    Image.fromarray(DEPTHS.astype(np.uint8)).save(other)
    with pytest.raises(ReadError, match="it must be grey with 16 bits a pixel, not L"):
        folder.frames[1].read()
    Image.fromarray(DEPTHS).save(other)
    other.write_bytes(other.read_bytes()[:-30])
    with pytest.raises(ReadError, match="is damaged"):
        folder.frames[1].read()


def test_a_folder_without_what_it_needs_is_told(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="no depth images"):
        read_depth_folder(tmp_path)
    seven_scenes(tmp_path)
    (tmp_path / "camera-intrinsics.txt").unlink()
    with pytest.raises(ReadError, match="for images of 3 × 2 pixels none are known"):
        read_depth_folder(tmp_path)
    (tmp_path / "frame-000000.pose.txt").unlink()
    with pytest.raises(ReadError, match="None of the folder’s 1 depth images has a pose"):
        read_depth_folder(tmp_path)
    listed = tmp_path / "tum"
    listed.mkdir()
    tum(listed)
    (listed / "depth.txt").write_text("100.0 ../../secret.png\n")
    with pytest.raises(ReadError, match="outside of the folder"):
        read_depth_folder(listed)


def test_a_real_folder_needs_no_file_of_intrinsics(data_file: Callable[[str], Path], tmp_path: Path) -> None:
    for name in ("frame-000000.depth.png", "frame-000000.pose.txt"):
        (tmp_path / name).write_bytes(data_file(f"depth/{name}").read_bytes())
    folder = read_depth_folder(tmp_path)
    assert folder.notes == (
        "The folder has no camera-intrinsics.txt: the data set’s own are taken, fx fy cx cy = 585, 585, 320, 240.",
    )
