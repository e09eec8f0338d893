"""Cloud files that are damaged in every way: each is read, or refused with one of our own errors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.core.limits import Limits
from mapper.io.clouds import read_cloud, read_depth_folder
from tests.hostile.damage import ALL, ROUNDS, flipped, mangled
from tests.mapper.io.clouds import test_depth_folder, test_formats, test_graph, test_pcd

LIMITS = Limits(max_points=10_000, max_cloud_bytes=1 << 20, max_unpacked_bytes=1 << 20)
KINDS: dict[str, Callable[[], bytes]] = {
    "pcd ascii": lambda: test_pcd.written("ascii"),
    "pcd binary": lambda: test_pcd.written("binary"),
    "pcd compressed": lambda: test_pcd.written("binary_compressed"),
    "ply ascii": lambda: test_formats.ply("ascii"),
    "ply binary": lambda: test_formats.ply("binary_big_endian"),
    "vtk ascii": lambda: test_formats.vtk("ASCII"),
    "vtk binary": lambda: test_formats.vtk("BINARY"),
    "graph": lambda: test_graph.graph(test_graph.STILL, test_graph.TURNED),
    "graph text": lambda: test_graph.TEXT,
    "xyz": lambda: b"x,y,z,intensity\n1,2,3,4\n5,6,7,8\n",
}


def is_a_sentence(message: str) -> None:
    assert message.endswith("."), message
    assert message.isprintable(), message


def is_read_or_refused(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    try:
        cloud = read_cloud(path, limits=LIMITS)
    except MapperError as error:
        is_a_sentence(error.message)
        return
    assert cloud.points.dtype == np.float64
    assert cloud.finite.any()
    assert np.abs(cloud.points[cloud.finite]).max() <= LIMITS.max_coordinate


@pytest.mark.sampled
@pytest.mark.parametrize("kind", [*KINDS, "las", "laz"])
def test_damaged_files_are_read_or_refused(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.cloud"
    data = KINDS[kind]() if kind in KINDS else test_formats.las(tmp_path / f"a.{kind}").read_bytes()
    rng = np.random.default_rng(1)
    for _ in range(ROUNDS // (1 if ALL else 3)):
        is_read_or_refused(path, flipped(rng, data))
    if "ascii" in kind or kind in ("xyz", "graph text"):
        for _ in range(ROUNDS // (1 if ALL else 3)):
            is_read_or_refused(path, mangled(rng, data.decode(), "," if kind == "xyz" else " "))
    for end in range(0, len(data), 1 if ALL else 13):
        is_read_or_refused(path, data[:end])


@pytest.mark.sampled
def test_damaged_depth_folders_are_read_or_refused(tmp_path: Path) -> None:
    folder = test_depth_folder.seven_scenes(tmp_path)
    rng = np.random.default_rng(2)
    for file in sorted(folder.iterdir()):
        whole = file.read_bytes()
        for _ in range(ROUNDS // (1 if ALL else 5)):
            file.write_bytes(flipped(rng, whole))
            try:
                for cloud in read_depth_folder(folder, limits=LIMITS).clouds():
                    assert cloud.cloud.shape == (2, 3)
            except MapperError as error:
                is_a_sentence(error.message)
        file.write_bytes(whole)
