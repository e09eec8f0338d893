"""Damaged files for 3D maps: archives of depth images, meshes, claims of 10⁹ points, absurd coordinates."""

from __future__ import annotations

import io
import struct
import tarfile
import tracemalloc
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds import read_cloud
from mapper.io.clouds.depth_archive import unpack_depth_archive
from mapper.io.clouds.ply import has_faces, read_ply_mesh
from mapper.volume.scans.scan_sequence import first_in_cubes, gather
from tests.hostile.damage import ALL, ROUNDS, flipped, mangled
from tests.hostile.test_cloud_files import is_a_sentence
from tests.mapper.io.clouds import test_depth_folder, test_formats
from tests.mapper.io.logs.recorded import SECOND, cloud, mcap_bytes, transform

LIMITS = Limits(max_points=10_000, max_cloud_bytes=1 << 20, max_unpacked_bytes=1 << 20)
CLAIMED = 10**9
PCD = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT 1\nPOINTS %d\n"
MOST_BYTES = 32 << 20  #: that reading a false claim may take, as tracemalloc counts them


def archive(folder: Path, kind: str) -> bytes:
    out = io.BytesIO()
    files = sorted(folder.rglob("*"))
    if kind == "tar":
        with tarfile.open(fileobj=out, mode="w") as packed:
            for file in files:
                packed.add(file, f"room/{file.relative_to(folder)}", recursive=False)
        return out.getvalue()
    method = zipfile.ZIP_STORED if kind == "stored" else zipfile.ZIP_DEFLATED
    with zipfile.ZipFile(out, "w", method) as archived:
        for file in files:
            if file.is_file():
                archived.write(file, f"room/{file.relative_to(folder)}")
    return out.getvalue()


@pytest.mark.sampled
@pytest.mark.parametrize("kind", ["deflated", "stored", "tar"])
@pytest.mark.parametrize("made", [test_depth_folder.seven_scenes, test_depth_folder.tum], ids=["7-Scenes", "TUM"])
def test_damaged_archives_of_depth_images(made, kind: str, tmp_path: Path) -> None:
    (tmp_path / "whole").mkdir()
    whole = archive(made(tmp_path / "whole"), kind)
    rng = np.random.default_rng(4)
    rounds = ROUNDS if ALL else ROUNDS // 5
    step = 1 if ALL else 97
    damaged = [
        whole,
        *(flipped(rng, whole) for _ in range(rounds)),
        *(whole[:end] for end in range(0, len(whole), step)),
    ]
    read = 0
    for k, data in enumerate(damaged):
        path, into = tmp_path / "a.zip", tmp_path / str(k)
        path.write_bytes(data)
        into.mkdir()
        try:
            unpack_depth_archive(path, into, LIMITS)
            read += len(gather(into, limits=LIMITS).points) > 0
        except MapperError as error:
            is_a_sentence(error.message.replace(str(tmp_path), "\n"))
        assert all(into in one.resolve().parents for one in into.rglob("*")), "nothing is written elsewhere"
    assert read >= 1


@pytest.mark.sampled
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_damaged_meshes(form: str, tmp_path: Path) -> None:
    whole = test_formats.ply(form)
    if form != "ascii":
        whole = whole[:-13] + struct.pack("<B3i" if "little" in form else ">B3i", 3, 0, 1, 2)
    path, rng = tmp_path / "a.ply", np.random.default_rng(6)
    path.write_bytes(whole)
    assert has_faces(path)
    assert read_ply_mesh(path)[2].tolist() == [[0, 1, 2]]
    damaged = [flipped(rng, whole) for _ in range(ROUNDS if ALL else ROUNDS // 3)]
    damaged += [whole[:end] for end in range(0, len(whole), 1 if ALL else 11)]
    if form == "ascii":
        damaged += [mangled(rng, whole.decode()) for _ in range(ROUNDS if ALL else ROUNDS // 3)]
    for data in damaged:
        path.write_bytes(data)
        try:
            if has_faces(path, LIMITS):
                vertices, _, faces = read_ply_mesh(path, LIMITS)
                assert not len(faces) or 0 <= faces.min() <= faces.max() < len(vertices)
        except MapperError as error:
            is_a_sentence(error.message)


def claims(tmp_path: Path) -> dict[str, bytes]:
    """Small files that state 10⁹ points."""
    las = bytearray(test_formats.las(tmp_path / "a.las").read_bytes())
    struct.pack_into("<I", las, 107, CLAIMED)  # the number of point records of LAS 1.2
    laz = bytearray(test_formats.las(tmp_path / "a.laz").read_bytes())
    struct.pack_into("<I", laz, 107, CLAIMED)
    graph = struct.pack("<II", 1, CLAIMED) + bytes(100)
    pcd = PCD % (CLAIMED, CLAIMED)
    ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\n" + b"".join(
        b"property float %c\n" % axis for axis in b"xyz"
    )
    mesh = test_formats.ply("binary_little_endian").replace(b"element face 1\n", b"element face 1000000000\n")
    vtk = test_formats.VTK_HEAD.format("BINARY").encode() + b"POINTS 1000000000 float\n" + bytes(120)
    return {
        "las": bytes(las), "laz": bytes(laz), "graph": graph, "pcd binary": pcd + b"DATA binary\n" + bytes(120),
        "pcd compressed": pcd + b"DATA binary_compressed\n" + struct.pack("<2I", 100, 2**32 - 1) + bytes(100),
        "pcd ascii": pcd + b"DATA ascii\n1 2 3\n", "ply": ply + b"end_header\n" + bytes(120), "mesh": mesh, "vtk": vtk,
    }  # fmt: skip


READERS: dict[str, Callable[[Path], object]] = {"mesh": read_ply_mesh, "graph": gather}


def test_a_billion_points_that_are_only_claimed_take_no_memory(tmp_path: Path) -> None:
    for name, data in claims(tmp_path).items():
        path = tmp_path / name.split()[0]
        path.write_bytes(data)
        tracemalloc.start()
        try:
            with pytest.raises((ReadError, LimitError)) as caught:
                READERS.get(name, read_cloud)(path)
            assert tracemalloc.get_traced_memory()[1] < MOST_BYTES, name
        finally:
            tracemalloc.stop()
        is_a_sentence(caught.value.message)


def test_cubes_of_any_point_or_a_sentence() -> None:
    """Points so far apart that a cube has no number of 64 bits, and one so far away that it has no whole number."""
    points = np.array([[0.0, 0.0, 0.0], [9e7, -9e7, 9e7], [0.001, 0.002, 0.003], [9e7, -9e7, 9e7]])
    assert first_in_cubes(points, 0.01).tolist() == [0, 1]
    for far in (1e30, np.inf, np.nan):
        with pytest.raises(ConfigError, match=r"m from the origin is too far away for cubes of 0\.01 m"):
            first_in_cubes(np.array([[0.0, far, 0.0]]), 0.01)


def test_points_of_a_recording_that_are_nowhere_are_left_out_with_a_note(tmp_path: Path) -> None:
    near = np.random.default_rng(0).uniform(-2.0, 2.0, (60_000, 3))
    bad = np.array([[1e30, 0, 0], [0, -1e300, 0], [np.nan, 0, 0], [0, 0, np.inf]])
    layout = [(name, "f8") for name in "xyz"]
    said = [transform(SECOND, "odom", "velodyne"), transform(2 * SECOND, "odom", "velodyne")]
    said.append(cloud(SECOND, np.concatenate([near, bad]), layout=layout))
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap_bytes(said))
    scans = gather(path, limits=replace(DEFAULT_LIMITS, max_points=100_000))
    assert np.abs(scans.points).max() <= 2.0
    assert 50_000 < len(scans.points) <= 60_000
    assert any("2 points are farther than 1e+08 m from the origin and are left out." in note for note in scans.notes)
