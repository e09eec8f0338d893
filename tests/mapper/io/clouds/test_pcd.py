"""PCD files, read beside a reader in plain Python of the same documentation."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.clouds import read_cloud

FIELDS = "FIELDS x y z rgb normal_x normal_y normal_z label fpfh _"
HEADER = f"""# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
{FIELDS}
SIZE 4 4 4 4 4 4 4 2 4 1
TYPE F F F U F F F U F U
COUNT 1 1 1 1 1 1 1 1 3 2
WIDTH 2
HEIGHT 2
VIEWPOINT 1 2 3 0.7071068 0 0 0.7071068
POINTS 4
"""
ROWS = [
    (0.1 * i, -i, 1e-3 * i, 0x0A0B0C + i, 0.0, 0.6, 0.8, 7 + i, [1.0 + i, 2.0 + i, 3.0 + i], [0, 0]) for i in range(4)
]
TYPE = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("rgb", "<u4"),
        ("n", "<f4", 3),
        ("label", "<u2"),
        ("f", "<f4", 3),
        ("_", "u1", 2),
    ]
)


def table() -> np.ndarray:
    return np.array([(*row[:4], row[4:7], *row[7:]) for row in ROWS], dtype=TYPE)


def literal_lzf(data: bytes) -> bytes:
    """Pack without packing: runs of up to 32 bytes as they are, which every LZF decoder takes."""
    runs = (data[i : i + 32] for i in range(0, len(data), 32))
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


def unpacked_lzf(data: bytes) -> bytes:
    """Unpack LZF as its documentation describes it."""
    out, at = bytearray(), 0
    while at < len(data):
        control = data[at]
        at += 1
        if control < 32:
            out += data[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[at]
            at += 1
        back = ((control & 31) << 8 | data[at]) + 1
        at += 1
        for _ in range(length + 2):
            out.append(out[-back])
    return bytes(out)


def written(kind: str) -> bytes:
    head = f"{HEADER}DATA {kind}\n".encode()
    rows = table()
    if kind == "ascii":
        numbers = [[*row[:8], *row[8], *row[9]] for row in ROWS]
        return head + b"\n".join(" ".join(repr(float(v)) for v in row).encode() for row in numbers)
    if kind == "binary":
        return head + rows.tobytes()
    parts = [rows[name].tobytes() for name in ("x", "y", "z", "rgb")]
    parts += [rows["n"][:, i].tobytes() for i in range(3)] + [rows[name].tobytes() for name in ("label", "f", "_")]
    columns = b"".join(parts)
    packed = literal_lzf(columns)
    return head + struct.pack("<II", len(packed), len(columns)) + packed


@pytest.mark.parametrize("kind", ["ascii", "binary", "binary_compressed"])
def test_every_encoding_gives_the_same_cloud(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(written(kind))
    cloud = read_cloud(path)
    rows = table()
    assert cloud.points.dtype == np.float64
    assert np.array_equal(cloud.points, np.stack([rows[axis] for axis in "xyz"], axis=1).astype(np.float64))
    assert cloud.shape == (2, 2)
    assert set(cloud.fields) == {"rgb", "normals", "class", "fpfh"}  # and no padding
    assert cloud.fields["rgb"].tolist() == [[0x0A, 0x0B, 0x0C + i] for i in range(4)]
    assert cloud.fields["normals"] == pytest.approx(np.tile([0.0, 0.6, 0.8], (4, 1)), abs=1e-7)
    assert cloud.fields["class"].tolist() == [7, 8, 9, 10]
    assert np.array_equal(cloud.fields["fpfh"], rows["f"])
    assert cloud.sensor_pose == pytest.approx(
        np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], dtype=float), abs=1e-6
    )


def test_a_real_compressed_cloud_is_what_a_second_reader_finds(data_file: Callable[[str], Path]) -> None:
    path = data_file("pointclouds/samp24-utm.pcd")
    data = path.read_bytes()
    start = data.index(b"DATA binary_compressed\n") + 23
    packed, size = struct.unpack_from("<II", data, start)
    columns = unpacked_lzf(data[start + 8 : start + 8 + packed])
    expected = np.frombuffer(columns, "<f4").reshape(3, -1).T
    cloud = read_cloud(path)
    assert len(columns) == size
    assert np.array_equal(cloud.points, expected.astype(np.float64))
    (note,) = cloud.notes
    assert note.startswith("The coordinates are 32-bit numbers: at 5403197 m they have steps of 0.5 m.")


@pytest.mark.parametrize(
    ("kind", "old", "new", "sentence"),
    [
        ("binary", "POINTS 4", "POINTS 1000000000", "1000000000 points, more than the limit"),
        ("binary", "COUNT 1 1 1 1", "COUNT 1 1 1", "have different lengths"),
        ("binary", "FIELDS x y z", "FIELDS x y w", "points have no field z"),
        ("binary", "TYPE F F", "TYPE F Q", "header’s TYPE is missing or wrong"),
        ("binary", "SIZE 4", "SIZE 3", "are not types of a PCD file"),
        ("ascii", "0.1", "O.1", "'O.1' near line 13 is not a number"),
        ("binary", "DATA binary", "", "ends before a line DATA"),
    ],
)
def test_a_header_that_lies_is_told(kind: str, old: str, new: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(written(kind).replace(old.encode(), new.encode(), 1))
    with pytest.raises((ReadError, LimitError), match=sentence):
        read_cloud(path)


@pytest.mark.parametrize("kind", ["ascii", "binary"])
def test_of_a_cut_file_the_whole_points_are_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(written(kind))
    whole = read_cloud(path)
    path.write_bytes(written(kind)[:-40])
    cloud = read_cloud(path)
    assert 0 < len(cloud) < 4
    assert np.array_equal(cloud.points, whole.points[: len(cloud)])
    assert (cloud.shape, whole.shape) == ((1, len(cloud)), (2, 2))
    assert cloud.notes[0] == f"The file ends early: 4 points claimed, {len(cloud)} there; these are read."


def test_a_cut_file_of_packed_points_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(written("binary_compressed")[:-40])
    with pytest.raises(ReadError, match=r"ends early: .* packed bytes claimed"):
        read_cloud(path)


def test_packed_points_that_claim_gigabytes_are_not_made_room_for(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    huge = written("binary_compressed").replace(b"WIDTH 2", b"WIDTH 9999999").replace(b"HEIGHT 2", b"HEIGHT 1")
    huge = huge.replace(b"POINTS 4", b"POINTS 9999999")
    start = huge.index(b"binary_compressed\n") + 18
    path.write_bytes(huge[: start + 4] + struct.pack("<I", 9999999 * 44) + huge[start + 8 :])
    with pytest.raises(ReadError, match="do not hold 439999956 bytes of points"):
        read_cloud(path)


def test_places_that_are_none_stay_in_the_file_s_order_and_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    head = "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 4\nHEIGHT 1\nDATA ascii\n"  # an old, short header
    path.write_text(head + "1 2 3\nnan 0 0\n5400000.25 0 0\n1e30 0 0\n")
    cloud = read_cloud(path)
    assert cloud.finite.tolist() == [True, False, True, False]
    assert cloud.points[2, 0] == 5400000.25
    assert cloud.notes == (
        "1 of 4 points are not finite, the first at index 1.",
        "1 of 4 points are more than 1e+08 m from the origin and are left out, the first at index 3: 1e+30, 0, 0.",
    )
    with pytest.raises(LimitError, match="4 points, more than the limit of 3"):
        read_cloud(path, limits=Limits(max_points=3))
    path.write_text(head.replace("4", "0"))
    with pytest.raises(ReadError, match="holds no points"):
        read_cloud(path)
