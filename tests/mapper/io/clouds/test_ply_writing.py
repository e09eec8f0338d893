"""Points as PLY files, as this reader and as trimesh take them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from mapper.io.clouds import read_cloud
from mapper.io.clouds.ply import points_ply


def test_points_with_all_that_is_known_of_them(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(40, 3)).astype(np.float32)
    fields: dict[str, NDArray[Any]] = {
        "rgb": rng.integers(0, 256, (40, 3)).astype(np.uint8),
        "intensity": rng.uniform(size=40).astype(np.float32),
        "class": rng.integers(0, 9, 40),
    }
    data = points_ply(points, fields, np.array([1e5, -2.5, 0.0]))
    read = trimesh.load(io.BytesIO(data), file_type="ply")
    assert isinstance(read, trimesh.PointCloud)
    vertex = read.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(read.vertices.astype(np.float32), points)
    np.testing.assert_array_equal(read.colors[:, :3], fields["rgb"])
    np.testing.assert_array_equal(vertex["classification"], fields["class"])
    np.testing.assert_array_equal(vertex["intensity"], fields["intensity"])
    assert b"comment offset 100000.0 -2.5 0.0\n" in data
    (tmp_path / "points.ply").write_bytes(data)
    np.testing.assert_array_equal(read_cloud(tmp_path / "points.ply").points, points)


def test_no_points_are_a_file_without_any() -> None:
    data = points_ply(np.empty((0, 3), np.float32), {"class": np.empty(0, np.int16)}, np.zeros(3))
    assert b"element vertex 0\n" in data
    assert data.endswith(b"property short classification\nend_header\n")
