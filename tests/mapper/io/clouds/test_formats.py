"""PLY, VTK, LAS, LAZ and text: small files by hand, and real ones beside parsers in plain NumPy."""

from __future__ import annotations

import gzip
import struct
from collections.abc import Callable, Sequence
from pathlib import Path

import laspy
import numpy as np
import pytest

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.clouds import read_cloud
from mapper.io.clouds.reading import cloud_format

POINTS = [(1.0, 2.0, 3.0), (-1.5, 0.25, 1e-3), (5400000.5, 0.0, -7.0)]
PLY_PROPERTIES = """property double x
property double y
property double z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property float scalar_Intensity
"""


def ply(form: str, n: int = 3) -> bytes:
    faces = "element face 1\nproperty list uchar int vertex_indices\n"
    head = f"ply\nformat {form} 1.0\ncomment by hand\nelement vertex {n}\n{PLY_PROPERTIES}{faces}end_header\n".encode()
    rows = [(*point, 0.0, 0.6, 0.8, 10, 20, 30 + k, 0.5) for k, point in enumerate(POINTS)]
    if form == "ascii":
        return head + "\n".join(" ".join(map(repr, row)) for row in rows).encode() + b"\n3 0 1 2\n"
    order = "<" if "little" in form else ">"
    return head + b"".join(struct.pack(f"{order}3d3f3Bf", *row) for row in rows) + bytes(13)


VTK_HEAD = "# vtk DataFile Version 3.0\nFile created by libpointmatcher\n{}\nDATASET POLYDATA\n"


def vtk(kind: str) -> bytes:
    """A file as libpointmatcher writes it, with cells, normals, colours, a scalar and a time of 64 bits."""
    head = VTK_HEAD.format(kind).encode()
    colours = ("u1", [[10, 20, 30]] * 3) if kind == "BINARY" else ("f4", [[0.1, 0.2, 1.0]] * 3)
    sections: list[tuple[str, str, Sequence[Sequence[float]]]] = [
        ("POINTS 3 double", "f8", [list(point) for point in POINTS]),
        ("VERTICES 3 6", "i4", [[1, 0], [1, 1], [1, 2]]),
        ("POINT_DATA 3", "", []),
        ("NORMALS normals float", "f4", [[0.0, 0.6, 0.8]] * 3),
        ("COLOR_SCALARS color 3", *colours),
        ("SCALARS intensity float 1\nLOOKUP_TABLE default", "f4", [[0.5], [float("nan")], [0.25]]),
        ("SCALARS t_splitTime_high32 unsigned_int\nLOOKUP_TABLE default", "u4", [[366075277]] * 3),
        ("SCALARS t_splitTime_low32 unsigned_int\nLOOKUP_TABLE default", "u4", [[0], [7], [4294967295]]),
    ]
    out = head
    for line, code, rows in sections:
        out += line.encode() + b"\n"
        if kind == "BINARY":
            out += np.array(rows, dtype=">" + code).tobytes() + b"\n" if rows else b""
        else:
            out += "".join(" ".join(f"{value:.17g}" for value in row) + "\n" for row in rows).encode()
    return out


def las(path: Path) -> Path:
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.offsets = np.full(3, 0.01), np.array([2700000.0, 0.0, 0.0])
    out = laspy.LasData(header)
    out.x, out.y, out.z = np.array(POINTS).T
    out.intensity, out.classification = np.array([1, 2, 3]), np.array([2, 6, 2])
    out.red, out.green, out.blue = (np.array([257 * value] * 3) for value in (10, 20, 30))
    out.gps_time = np.array([1.0, 2.0, 3.0])
    out.write(path)
    return path


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_the_vertices_of_ply(form: str, tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(ply(form))
    cloud = read_cloud(path)
    assert cloud.points.tolist() == [list(point) for point in POINTS]
    assert set(cloud.fields) == {"normals", "rgb", "intensity"}
    assert cloud.fields["rgb"].tolist() == [[10, 20, 30], [10, 20, 31], [10, 20, 32]]
    assert cloud.fields["normals"][1] == pytest.approx([0.0, 0.6, 0.8])
    assert cloud.fields["intensity"].tolist() == [0.5] * 3


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
def test_vtk_as_libpointmatcher_writes_it(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.vtk.gz"
    path.write_bytes(gzip.compress(vtk(kind)))
    cloud = read_cloud(path)
    assert cloud.points.tolist() == [list(point) for point in POINTS]
    assert cloud.fields["normals"][2] == pytest.approx([0.0, 0.6, 0.8])
    assert cloud.fields["rgb"][0].tolist() == ([10, 20, 30] if kind == "BINARY" else [26, 51, 255])
    assert cloud.fields["intensity"].tolist() == pytest.approx([0.5, np.nan, 0.25], nan_ok=True)
    assert cloud.fields["t"].tolist() == [(366075277 << 32) + low for low in (0, 7, 4294967295)]
    assert cloud.times is not None
    assert cloud.times == pytest.approx(cloud.fields["t"] * 1e-9)


@pytest.mark.parametrize("end", ["las", "laz"])
def test_las_and_laz(end: str, tmp_path: Path) -> None:
    cloud = read_cloud(las(tmp_path / f"a.{end}"))
    assert cloud.points == pytest.approx(np.array(POINTS), abs=5e-3 + 1e-9)
    assert cloud.fields["class"].tolist() == [2, 6, 2]
    assert cloud.fields["intensity"].tolist() == [1, 2, 3]
    assert cloud.fields["rgb"].tolist() == [[10, 20, 30]] * 3


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("1 2 3\n-1.5 0.25 1e-3\n5400000.5 0 -7\n", {}),
        ("x,y,z,nx,ny,nz\n1 , 2 , 3 , 0,0,1\n-1.5,0.25,1e-3,0,0,1\n5400000.5,0,-7,0,0,1\n", {"normals": [0, 0, 1]}),
        ("3\n1 2 3 9 1 2 255\n-1.5 .25 1e-3 9 1 2 255\n5400000.5 0 -7 9 1 2 255", {"intensity": 9, "rgb": [1, 2, 255]}),
        ("# a remark\n1;2;3;0.5\n-1.5;0.25;1e-3;0.5\n5400000.5;0;-7;0.5\n", {"intensity": 0.5}),
        ("//z y x label\n3 2 1 4\n1e-3 .25 -1.5 4\n-7 0 5400000.5 4\n", {"class": 4}),
    ],
)
def test_text_with_names_and_without(text: str, fields: dict[str, object], tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text(text)
    cloud = read_cloud(path)
    assert cloud.points.tolist() == [list(point) for point in POINTS]
    assert {name: values[1].tolist() for name, values in cloud.fields.items()} == fields


def test_real_files_are_what_plain_parsers_find(data_file: Callable[[str], Path]) -> None:
    raw = gzip.decompress(data_file("pointclouds/pointmatcher-cloud.00002.vtk.gz").read_bytes()).decode()
    lines = raw.splitlines()[5 : 5 + 24154]
    expected = np.array([[float(word) for word in line.split()] for line in lines], dtype=np.float32)
    found = read_cloud(data_file("pointclouds/pointmatcher-cloud.00002.vtk.gz"))
    assert np.array_equal(found.points, expected.astype(np.float64))
    rows = gzip.decompress(data_file("pointclouds/pointmatcher-car_cloud400.csv.gz").read_bytes()).decode().splitlines()
    cloud = read_cloud(data_file("pointclouds/pointmatcher-car_cloud400.csv.gz"))
    table = np.array([[float(word) for word in row.split(",")] for row in rows[1:2000]])
    assert len(cloud) == len(rows) - 1
    assert np.array_equal(cloud.points[:1999], table[:, :3])
    assert np.array_equal(cloud.fields["normals"][:1999], table[:, 3:])
    data = data_file("pointclouds/source.ply").read_bytes()
    values = np.frombuffer(data[data.index(b"end_header\n") + 11 :], "<f4").reshape(-1, 4)
    source = read_cloud(data_file("pointclouds/source.ply"))
    assert np.array_equal(source.points, values[:, :3].astype(np.float64))
    assert np.array_equal(source.fields["intensity"], values[:, 3])


def test_the_trajectory_of_libpointmatcher_states_its_times(data_file: Callable[[str], Path]) -> None:
    cloud = read_cloud(data_file("pointclouds/pointmatcher-trajectory.vtk.gz"))
    assert (len(cloud), cloud.fields["orientationX"].shape) == (525, (525, 3))
    assert cloud.times is not None
    assert (np.diff(cloud.times) > 0).all()


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (ply("binary_little_endian", 10**9), "1000000000 points, more than the limit"),
        (ply("ascii", 5), "number of values changes"),
        (ply("ascii", 0), "holds no points"),
        (ply("ascii").replace(b"double z", b"double w"), "no property z"),
        (ply("ascii").replace(b"double z", b"list uchar int z"), "no property z"),
        (ply("ascii").replace(b"double z", b"quad z"), "is of the type 'quad', which PLY lacks"),
        (ply("ascii").replace(b"format ascii", b"format utf-8"), "states no format"),
        (ply("ascii").replace(b"end_header", b"end"), "before the line end_header"),
        (ply("ascii").replace(b"-1.5", b"-1.5.5"), "'-1.5.5' near line 19 is not a number"),
        (vtk("ASCII").replace(b"POINTS 3", b"POINTS 1000000000"), "1000000000 points, more than the limit"),
        (vtk("ASCII").replace(b"POINTS 3", b"POINTS 4"), "the points must be 12 numbers, not 9"),
        (vtk("ASCII").replace(b"POINT_DATA 3", b"POINT_DATA 7"), "POINT_DATA is of 7 points, but the file has 3"),
        (vtk("ASCII").replace(b"POINTS 3 double", b"POINTS 3 quad"), "of the type 'quad', which VTK does not have"),
        (vtk("ASCII").replace(b"0.25", b"0,25"), "Something in the points is not a number"),
        (vtk("ASCII").replace(b"366075277", b"nan", 1), "has a number that does not fit its type"),
        (vtk("ASCII").replace(b"366075277", b"1e10", 1), "has a number that does not fit its type"),
        (vtk("BINARY")[:150], "ends early, within the points"),
        (b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n", "no section POINTS"),
        (b"LASF" + bytes(100), "ends within its LAS header"),
        (b"LASF" + bytes(400), "LAS file is damaged"),
        (b"1 2 3\n1 2\n", "number of values changes near line"),
        (b"x,y,z,label\n1,2,3\n", "3 numbers, but 4 column names"),
        (b"hello\nworld\n", "none of the known formats"),
    ],
)
def test_what_is_wrong_is_told_in_one_sentence(data: bytes, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "a.file"
    path.write_bytes(data)
    with pytest.raises((ReadError, LimitError), match=sentence):
        read_cloud(path)


def test_limits_hold_for_formats_that_state_no_number_of_points(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("1 2 3\n" * 20)
    with pytest.raises(LimitError, match="more lines than the limit of 10 points"):
        read_cloud(path, limits=Limits(max_points=10))
    with pytest.raises(LimitError, match="more than 100 bytes"):
        read_cloud(path, limits=Limits(max_cloud_bytes=100))
    packed = las(tmp_path / "a.laz")
    with pytest.raises(LimitError, match="3 points, more than the limit of 2"):
        read_cloud(packed, limits=Limits(max_points=2))
    whole = packed.read_bytes()
    packed.write_bytes(whole[:-40])
    assert read_cloud(packed).points.tolist() == [list(POINTS[0])]
    packed.write_bytes(whole[:-60])
    with pytest.raises(ReadError, match="within their first chunk, so none can be read"):
        read_cloud(packed)


def test_a_trajectory_in_the_format_tum_is_no_cloud() -> None:
    poses = b"# timestamp tx ty tz qx qy qz qw\n0.0 1 2 0 0 0 0.6 0.8\n0.1 1 2 0 0 0 0 1\n"
    assert cloud_format(poses) is None
    assert cloud_format(poses.replace(b"0.6 0.8", b"20 30")) == "text"
    assert cloud_format(poses.replace(b" ", b",")) is None
    assert cloud_format(poses.removeprefix(b"# ").replace(b" ", b", ")) is None
    # Points with an intensity, a normal and a curvature of 0: their first column does not ascend.
    assert cloud_format(b"2.5,1,2,7,0,0,1,0\n1.5,1,2,7,0,0.6,0.8,0\n") == "text"
