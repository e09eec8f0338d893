"""Clouds as people have them, beside what their formats and other readers make of each; one case of each kind.

A test names the report that its situation is known from; those without one are of the same kinds.
"""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pyoctomap
import pytest
from laspy.vlrs.vlr import VLR
from numpy.typing import ArrayLike

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.clouds import read_cloud
from mapper.io.clouds.depth_archive import unpack_depth_archive
from mapper.io.clouds.projection import units_of
from mapper.io.logs import open_log
from mapper.io.maps import load_map
from mapper.volume import Octree, VolumeConfig, octree_file
from mapper.volume.octree.files import octree_of_bytes, read_octree
from tests.server.cli.running import Run

RNG = np.random.default_rng(12)
FAR = np.array([691_000.0, 5_334_000.0, 500.0])  #: a place of UTM
POINTS = np.round(RNG.uniform(-9.0, 9.0, (30, 3)), 3)


def lines(form: str, points: np.ndarray = POINTS, head: str = "") -> bytes:
    """Return a text with a line of this form for each point."""
    return (head + "".join(form.format(*point) + "\n" for point in points)).encode()


def commas(form: str, head: str = "") -> bytes:
    """Return a text whose decimals follow a comma; ``|`` in the form is one that does not."""
    return lines(form, head=head).replace(b",", b"|").replace(b".", b",").replace(b"|", b",")


def read(tmp_path: Path, data: bytes, name: str = "a.xyz") -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the points of a file with these bytes, and the notes on it."""
    path = tmp_path / name
    path.write_bytes(data)
    cloud = read_cloud(path)
    return cloud.points, cloud.notes


THREE = "{:.3f}"
TEXTS: dict[str, bytes] = {
    "a table's index in a column without a name": lines("7,{:.3f},{:.3f},{:.3f}", head=",x,y,z\n"),
    "decimal commas, blanks": commas("{:.3f} {:.3f} {:.3f}"),
    "decimal commas, a tab": commas("{:.3f}\t{:.3f}\t{:.3f}"),
    "decimal commas, semicolons and blanks": commas("{:.3f}; {:.3f}; {:.3f}"),
    "decimal commas, a comma and a blank": lines("{:.3f}; {:.3f}; {:.3f}").replace(b".", b",").replace(b";", b","),
    "decimal commas, quoted": lines('"{:.3f}";"{:.3f}";"{:.3f}"').replace(b".", b","),
    "quoted, with commas between": lines('"{:.3f}";"{:.3f}";"{:.3f}"').replace(b".", b",").replace(b";", b","),
    "decimal commas below names": commas("{:.3f};{:.3f};{:.3f}", head="X;Y;Z\n"),
    "semicolons at the end of each line": lines("{:.3f};{:.3f};{:.3f};"),
    "a byte-order mark": b"\xef\xbb\xbf" + lines("{:.3f},{:.3f},{:.3f}", head="x,y,z\n"),
    "UTF-16": b"\xff\xfe" + lines("{:.3f} {:.3f} {:.3f}").decode().encode("utf-16-le"),
    "carriage returns": lines("{:.3f},{:.3f},{:.3f}").replace(b"\n", b"\r\n"),
    "carriage returns alone": lines("{:.3f} {:.3f} {:.3f}").replace(b"\n", b"\r"),
    "carriage returns alone, below names": lines("{:.3f},{:.3f},{:.3f}", head="x,y,z\n").replace(b"\n", b"\r"),
    "CloudCompare's names": lines("{:.3f} {:.3f} {:.3f}", head="//X Y Z\n30\n"),
    "ParaView's names": lines("{:.3f},{:.3f},{:.3f}", head='"Points:0","Points:1","Points:2"\n'),
    "VeloView's names": lines(
        "{:.3f},{:.3f},{:.3f},7", head='"Points_m_XYZ:0","Points_m_XYZ:1","Points_m_XYZ:2","laser_id"\n'
    ),
    "surveyors' names": lines("{1:.3f},{0:.3f},{2:.3f}", head="Northing,Easting,Height\n"),
    "units in the names": lines("{:.1f};{:.1f};{:.1f}", 1000.0 * POINTS, head="x [mm];y [mm];z [mm]\n"),
    "units below the names": lines("{:.1f},{:.1f},{:.1f}", 1000.0 * POINTS, head="x,y,z\n[mm],[mm],[mm]\n"),
    "units after the names": lines("{:.3f} {:.3f} {:.3f}", 100.0 * POINTS, head="x_cm y_cm z_cm\n"),
    "names with blanks, and a number": lines(
        "7,{:.3f},{:.3f},{:.3f}", head="scan id,X Coordinate,Y Coordinate,Z Coordinate\n"
    ),
    "names of two words": lines("7,{:.3f},{:.3f},{:.3f}", head="Point ID,Point X,Point Y,Point Z\n"),
    "exponents of Fortran": lines("{:.6E} {:.6e} {:.6E}").replace(b"E", b"D").replace(b"e", b"d"),
    "exponents of Fortran below names": lines("{:.6E},{:.6E},{:.6E}", head="x,y,z\n").replace(b"E", b"D"),
    "exponents of Fortran, decimal commas": lines("{:.6E} {:.6E} {:.6E}").replace(b"E", b"D").replace(b".", b","),
    "remarks of MATLAB": lines("{:.3f} {:.3f} {:.3f}", head="% by a program\n% x y z\n"),
    "separators of psql": lines("{:.3f} | {:.3f} | {:.3f}", head=" x | y | z\n---+---+---\n"),
    "a table of Markdown": lines("| {:.3f} | {:.3f} | {:.3f} |", head="| x | y | z |\n|:--|--:|---|\n"),
    "Excel's first line": lines("{:.3f};{:.3f};{:.3f}", head="sep=;\nx;y;z\n"),
    "German names, in Windows' letters": lines("{:.3f};{:.3f};{:.3f}", head="Rechtswert;Hochwert;H\u00f6he\n")
    .decode()
    .encode("cp1252"),
    "units after a stroke": lines("{:.1f},{:.1f},{:.1f}", 1000.0 * POINTS, head="x/mm,y/mm,z/mm\n"),
    "survey feet": lines("{:.6f},{:.6f},{:.6f}", POINTS * 3937 / 1200, head="X [US survey ft],Y [US ft],Z [usft]\n"),
    "names of ROS's tables": lines("7,{:.3f},{:.3f},{:.3f}", head="%time,field.x,field.y,field.z\n"),
    "a table of R": "".join(f'"{k}" {x} {y} {z}\n' for k, (x, y, z) in enumerate(POINTS, 1))
    .join(['"x" "y" "z"\n', ""])
    .encode(),
    "remarks behind the numbers": lines("{:.3f}, {:.3f}, {:.3f}  # a, b"),
    "other lines before the names": lines("{:.3f},{:.3f},{:.3f}", head="Project=hall\nmade 2024-05-01\n\nX,Y,Z\n"),
    "the sign of the end of CP/M": lines("{:.3f} {:.3f} {:.3f}") + b"\x1a",
    "a typographic minus, and blanks that do not break": lines("{:.3f}\u00a0{:.3f} {:.3f}")
    .decode()
    .replace("-", "\u2212")
    .encode(),
    "two scans": lines("{:.3f} {:.3f} {:.3f}", POINTS[:11], "11\n")
    + lines("{:.3f} {:.3f} {:.3f}", POINTS[11:], "19\n"),
}


@pytest.mark.parametrize("case", TEXTS)
def test_texts(tmp_path: Path, case: str) -> None:
    """umap#159, QGIS#52741 (decimal commas); Open3D#913 (two scans); CloudCompare, ParaView, VeloView, R, psql."""
    points, _ = read(tmp_path, TEXTS[case])
    np.testing.assert_allclose(points, POINTS, atol=2e-6)


def test_numbers_of_points_before_the_coordinates_are_no_coordinates(tmp_path: Path) -> None:
    """Surveyors' lists: were the first column x, the points would lie on a line of some metres, without a word."""
    text = "".join(f"{k} {x:.3f} {y:.3f} {z:.3f}\n" for k, (x, y, z) in enumerate(POINTS, 101))
    points, notes = read(tmp_path, text.encode())
    np.testing.assert_allclose(points, POINTS, atol=1e-6)
    assert notes == ("The first column counts the points, so the next three are x, y, z here.",)
    ramp = "".join(f"{k} {y:.3f} {z:.3f}\n" for k, (_, y, z) in enumerate(POINTS, 1))
    points, notes = read(tmp_path, ramp.encode())
    np.testing.assert_allclose(points[:, 0], np.arange(1, len(POINTS) + 1))
    assert notes == ()


WORDS = {
    "a class": ("{:.3f},{:.3f},{:.3f},wall,7", "x,y,z,kind,n\n", "kind"),
    "a time": ("2024-01-01 10:00:00.5,{:.3f},{:.3f},{:.3f},7", "time,x,y,z,n\n", "time"),
    "a colour": ("{:.3f};{:.3f};#ff0000;{:.3f};7", "x;y;colour;z;n\n", "colour"),
    "decimal commas": ("{:.3f};{:.3f};a wall, a;{:.3f};7", "x;y;kind;z;n\n", "kind"),
    "in quotes, with a separator": ('"a, b",{:.3f},{:.3f},{:.3f},7', "kind,x,y,z,n\n", "kind"),
    "two": ("wall\t{:.3f}\t{:.3f}\t{:.3f}\t7\tno", "kind\tx\ty\tz\tn\tis it\n", "kind, is it"),
}


@pytest.mark.parametrize("case", WORDS)
def test_columns_of_words_are_left_out(tmp_path: Path, case: str) -> None:
    form, head, names = WORDS[case]
    text = lines(form, head=head)
    if case == "decimal commas":
        text = text.replace(b".", b",")
    (tmp_path / "a.csv").write_bytes(text.replace(b"\n", b"\n\n# a remark\n"))
    cloud = read_cloud(tmp_path / "a.csv")
    np.testing.assert_allclose(cloud.points, POINTS, atol=2e-6)
    assert cloud.notes == (f"Columns with other things than numbers are left out: {names}.",)
    assert {name: set(column) for name, column in cloud.fields.items()} == {"n": {7.0}}


@pytest.mark.parametrize("word", ["-nan(ind)", "NA", "#N/A", "NULL", "None", ""])
@pytest.mark.parametrize("last", [False, True])
def test_words_for_no_number_are_none(tmp_path: Path, word: str, last: bool) -> None:
    """Of C on Windows, R, spreadsheets, databases and Python; pandas writes nothing."""
    rows = lines("{:.3f},{:.3f},{:.3f}", head="x,y,z\n").decode().split("\n")
    rows[8] = ",".join([*rows[8].split(",")[:2], word] if last else [word, *rows[8].split(",")[1:]])
    points, notes = read(tmp_path, "\n".join(rows).encode())
    expected = POINTS.copy()
    expected[7, 2 if last else 0] = np.nan
    np.testing.assert_allclose(points, expected, atol=2e-6)
    assert notes == ("1 of 30 points are not finite, the first at index 7.",)


COLOURS = RNG.integers(2, 256, (30, 3))
NORMALS = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
COLUMNS = {
    "a colour": (COLOURS,),
    "shares of 1": (COLOURS / 255,),
    "a normal": (NORMALS,),
    "an intensity and a colour": (np.arange(30)[:, None] - 9, COLOURS),
    "a colour and a number": (COLOURS, np.linspace(-0.5, 0.5, 30)[:, None]),
    "a normal and a curvature": (NORMALS, np.linspace(0.0, 0.5, 30)[:, None]),
    "a colour and a normal": (COLOURS, NORMALS),
    "a normal and a colour": (NORMALS, COLOURS),
}


@pytest.mark.parametrize("case", COLUMNS)
def test_columns_without_names_are_colours_and_normals_by_what_they_hold(tmp_path: Path, case: str) -> None:
    with (tmp_path / "a.xyz").open("wb") as file:
        np.savetxt(file, np.column_stack([POINTS, *COLUMNS[case]]), "%.6f")
    cloud = read_cloud(tmp_path / "a.xyz")
    np.testing.assert_allclose(cloud.points, POINTS, atol=2e-6)
    said = {"rgb": case.replace("shares of 1", "colour"), "normals": case}
    assert ("rgb" in cloud.fields, "normals" in cloud.fields) == ("colour" in said["rgb"], "normal" in said["normals"])
    if "rgb" in cloud.fields:
        np.testing.assert_array_equal(cloud.fields["rgb"], COLOURS)
    if "normals" in cloud.fields:
        np.testing.assert_allclose(cloud.fields["normals"], NORMALS, atol=2e-6)


def test_degrees_that_nothing_names_are_told_by_their_steps(tmp_path: Path) -> None:
    """0.00001° of latitude are 1.11 m; a cloud of a plane in metres, however finely written, is none."""
    degrees = np.column_stack([11.5 + 1e-5 * POINTS[:, 0], 48.1 + 1e-5 * POINTS[:, 1], 500.0 + POINTS[:, 2]])
    points, notes = read(tmp_path, lines("{:.9f} {:.9f} {:.2f}", degrees))
    np.testing.assert_allclose(np.ptp(points, axis=0), np.ptp(POINTS, axis=0) * (0.7447, 1.1120, 1.0), rtol=2e-3)
    assert "steps of 1e-09 and the third of 0.01, as longitude, latitude and a height have" in notes[0]
    flat, notes = read(tmp_path, lines("{0:.9f} {1:.9f} 0", 0.03 * POINTS))
    np.testing.assert_allclose(flat[:, :2], 0.03 * POINTS[:, :2], atol=2e-6)
    assert notes == ()


def test_names_of_degrees_above_metres_are_no_degrees(tmp_path: Path) -> None:
    far = POINTS + FAR
    points, notes = read(tmp_path, lines("{:.3f},{:.3f},{:.3f}", far, "lon,lat,alt\n"))
    np.testing.assert_allclose(points, far, atol=2e-6)
    assert "which no degrees are: they are taken as metres" in notes[0]


@pytest.mark.parametrize("word", ["1.#QNAN", "-1.#IND", "1.#INF00", "-1.#IND000"])
@pytest.mark.parametrize("row", [0, 7])
def test_what_c_wrote_for_no_number_on_windows_is_no_comment(tmp_path: Path, word: str, row: int) -> None:
    """A comment begins with the same sign: z was 1 or -1 there, without a word."""
    rows = lines("{:.3f} {:.3f} {:.3f}").split(b"\n")
    rows[row] = rows[row].rsplit(b" ", 1)[0] + b" " + word.encode()
    points, notes = read(tmp_path, b"\n".join(rows))
    assert np.isnan(points[row, 2])
    np.testing.assert_allclose(np.delete(points, row, 0), np.delete(POINTS, row, 0), atol=2e-6)
    assert notes == (f"1 of 30 points are not finite, the first at index {row}.",)


PLY = b"ply\nformat ascii 1.0\nelement vertex 30\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    "text",
    [
        lines("{:.3f} {:.3f} {:.3f}\n"),
        b"\xef\xbb\xbf" + lines("{:.3f} {:.3f} {:.3f}"),
        lines("{:.3f} {:.3f} {:.3f}", head="\r\n \n"),
    ],
)
def test_empty_lines_and_a_mark_before_the_vertices_are_no_vertices(tmp_path: Path, text: bytes) -> None:
    """plyfile issue 32: numbers that were pasted into a PLY file. Its faces are found behind them."""
    head = PLY + b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    points, notes = read(tmp_path, head + text + b"3 0 1 2\n", "a.ply")
    np.testing.assert_allclose(points, POINTS, atol=2e-6)
    assert notes == ()


def test_points_that_the_first_line_does_not_count_are_named(tmp_path: Path) -> None:
    points, notes = read(tmp_path, lines("{:.3f} {:.3f} {:.3f} 9", head="20\n"), "a.pts")
    np.testing.assert_allclose(points, POINTS[:20], atol=2e-6)
    assert notes == ("10 more lines than the header says, 20, are left out.",)


def test_a_las_version_that_is_not_known_is_named(tmp_path: Path) -> None:
    data = bytearray(las(tmp_path / "a.las", POINTS, {}).read_bytes())
    data[25] = 9
    with pytest.raises(ReadError, match=r"The file is LAS 1\.9; versions up to 1\.4 are read"):
        read(tmp_path, bytes(data), "b.las")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (lines("{:.3f};{:.3f};{:.3f}").replace(b".", b",").replace(b";", b","), "decimal commas, and commas stand"),
        (
            lines("{:.3f};{:.3f};{:.3f}").replace(b".", b",").replace(b";", b",").replace(b"\n", b",7\n"),
            "decimal commas",
        ),
        (b"1.5 2,5 3.5\n4.5 5,5 6.5\n", "some numbers have decimal commas, others decimal points"),
        (b"1,234.5 2,345.5 678.5\n" * 3, "between their thousands"),
        (b"x;y;z\n1,234.5;2,345.5;678.5\n", "between their thousands"),
        (b"1.234,5;2.345,5;678,5\n" * 3, "between their thousands"),
        (b"1 234.5;2 345.5;678.5\n" * 3, "between their thousands"),
        (b"x\ty\tz\n1 234,5\t2 345,5\t678,5\n", "between their thousands"),
        (b"1 234.5,2 345.5,678.5\n" * 3, "between their thousands"),
        (b"1'234.5 2'345.5 678.5\n" * 3, "between their thousands"),
        (b"1,234;2,345;678\n1,235;678;-9\n567;2,345;8\n", "between their thousands"),
        (b'"1,234","2,345","678"\n"567","2,345","8"\n', "between their thousands"),
        (b"1.234.567;2.345.678;8\n" * 3, "between their thousands"),
        (b"x,y\n1,2\n3,4\n", "columns are named x, y; a cloud needs x, y, z"),
        (b"id,distance,angle\n1,2.5,3\n1,2.5,3\n", "columns are named id, distance, angle; a cloud needs x, y, z"),
    ],
)
def test_texts_that_could_be_two_things_are_refused(tmp_path: Path, data: bytes, said: str) -> None:
    """umap#159, QGIS#52741. They were other points before, without a word."""
    with pytest.raises(ReadError, match=said):
        read(tmp_path, data)


PTX = "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n4 5 6 0.5\n"
OTHER_FORMATS = {
    "E57": b"ASTM-E57" + bytes(40),
    "OBJ": b"# by a program\nmtllib a.mtl\no room\nv 1.0 2.0 3.0\nv 1.0 2.0 4.0\nf 1 2 1\n",
    "STL": b"solid room\n facet normal 0 0 1\n",
    "PTX": PTX.encode(),
    "glTF": b"glTF" + struct.pack("<II", 2, 20) + bytes(8),
    "VTK in XML": b'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0">\n',
    "ESRI": b"ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n",
}


@pytest.mark.parametrize("name", OTHER_FORMATS)
def test_files_of_other_formats_are_named_with_what_converts_them(tmp_path: Path, name: str) -> None:
    """Of clouds and of logs alike: which of them a file was meant to be, nobody knows."""
    said = rf"\b{name}\b.*save its points as PLY, LAS or PCD"
    with pytest.raises(ReadError, match=said):
        read(tmp_path, OTHER_FORMATS[name])
    with pytest.raises(ReadError, match=said):
        open_log(tmp_path / "a.xyz")


def test_archives_of_clouds_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_bytes(lines("{:.3f} {:.3f} {:.3f}"))
    for form, what in (("zip", "zip"), ("tar", "tar"), ("gztar", "tar")):
        packed = Path(shutil.make_archive(str(tmp_path / "packed"), form, tmp_path, "a.xyz"))
        with pytest.raises(ReadError, match=rf"is a {what} archive \(unpack it, and open the file in it\)"):
            read_cloud(packed)


def test_a_las_file_whose_points_would_all_be_one_is_refused(tmp_path: Path) -> None:
    path = las(tmp_path / "a.las", POINTS, {})
    data = bytearray(path.read_bytes())
    struct.pack_into("<3d", data, 131, 0.0, 0.0, 0.0)
    with pytest.raises(ReadError, match="scale factors of 0, 0, 0"):
        read(tmp_path, bytes(data), "a.las")


def test_whole_numbers_between_commas_are_no_decimals(tmp_path: Path) -> None:
    rows = np.column_stack(
        [np.arange(-20, 20), np.arange(40) * 7, np.arange(40), np.arange(40) * 6, np.full((40, 2), 9)]
    )
    points, _ = read(tmp_path, b"\n".join(b",".join(b"%d" % v for v in row) for row in rows))
    assert np.array_equal(points, rows[:, :3])


def test_longitude_and_latitude_by_their_names_are_metres(tmp_path: Path) -> None:
    """A degree of latitude is 110.9 km at 30°, one of longitude 96.5 km there."""
    text = b"latitude,longitude,altitude\n30.000,-95.000,10\n30.001,-95.000,10\n30.000,-95.001,12\n"
    points, notes = read(tmp_path, text)
    sides = points - points[0]
    assert sides[1] == pytest.approx([0.0, 110.85, 0.0], abs=0.02)
    assert sides[2] == pytest.approx([-96.49, 0.0, 2.0], abs=0.02)
    assert "metres east and north of -95.000500°, 30.000500° here (WGS 84)" in notes[0]


# -- LAS -----------------------------------------------------------------------------------------------------------

FEET = "US survey foot"
WKT = (
    'COMPD_CS["a",PROJCS["b",GEOGCS["c",DATUM["d",SPHEROID["e",6378137,298.257]],PRIMEM["Greenwich",0],'
    'UNIT["degree",0.0174532925199433]],PROJECTION["f"],PARAMETER["scale_factor",1],'
    'UNIT["US survey foot",0.304800609601219],AXIS["X",EAST]],VERT_CS["g",VERT_DATUM["h",2005],UNIT["metre",1]]]'
)
WKT2 = (
    'PROJCRS["b",BASEGEOGCRS["c",ANGLEUNIT["degree",0.0174532925199433]],CONVERSION["f",PARAMETER["x",1,'
    'LENGTHUNIT["metre",1]]],CS[Cartesian,2],AXIS["easting (X)",east,LENGTHUNIT["foot",0.3048]]]'
)


def keys(*entries: tuple[int, int]) -> bytes:
    """Return a GeoTIFF key directory with these keys and values."""
    return struct.pack(
        f"<{4 + 4 * len(entries)}H", 1, 1, 0, len(entries), *(v for k, value in entries for v in (k, 0, 1, value))
    )


def titled(*entries: tuple[int, int], text: str) -> dict[int, bytes]:
    """Return such a directory whose system has a title."""
    rows = [(k, 0, 1, value) for k, value in entries] + [(3073, 34737, len(text), 0)]
    return {
        34735: struct.pack(f"<{4 + 4 * len(rows)}H", 1, 1, 0, len(rows), *(v for row in rows for v in row)),
        34737: text.encode(),
    }


def las(
    path: Path, points: np.ndarray, records: dict[int, bytes], steps: tuple[float, float, float] = (1e-3,) * 3
) -> Path:
    header = laspy.LasHeader(point_format=1, version="1.2")
    header.scales, header.offsets = np.array(steps), np.floor(points[0])
    header.vlrs.extend(VLR("LASF_Projection", number, "", data) for number, data in records.items())
    out = laspy.LasData(header)
    out.x, out.y, out.z = points.T
    out.write(path)
    return path


UNITS: dict[str, tuple[dict[int, bytes], tuple[float, float, float], str | None]] = {
    "none stated": ({}, (1.0, 1.0, 1.0), None),
    "UTM by its number": ({34735: keys((1024, 1), (3072, 32632))}, (1.0, 1.0, 1.0), None),
    "US survey feet": ({34735: keys((1024, 1), (3076, 9003))}, (1200 / 3937,) * 3, FEET),
    "feet, heights in metres": ({34735: keys((1024, 1), (3076, 9002), (4099, 9001))}, (0.3048, 0.3048, 1.0), "'foot'"),
    "metres, heights in feet": ({34735: keys((1024, 1), (3076, 9001), (4099, 9002))}, (1.0, 1.0, 0.3048), "z is in"),
    "WKT": ({2112: WKT.encode() + b"\0"}, (1200 / 3937, 1200 / 3937, 1.0), FEET),
    "WKT 2": ({2112: WKT2.encode()}, (0.3048,) * 3, "'foot'"),
    "a state's plane by its number": ({34735: keys((1024, 1), (3072, 2277))}, (1200 / 3937,) * 3, FEET),
    "a number without a model": ({34735: keys((3072, 2269))}, (0.3048,) * 3, "'foot'"),
    "a number in metres": ({34735: keys((1024, 1), (3072, 31468))}, (1.0, 1.0, 1.0), None),
    "NAD83(2011), Oregon North, international feet": ({34735: keys((1024, 1), (3072, 6559))}, (0.3048,) * 3, "'foot'"),
    "NAD83, Illinois East, survey feet": ({34735: keys((1024, 1), (3072, 3435))}, (1200 / 3937,) * 3, FEET),
    "a compound system by its number": ({34735: keys((1024, 1), (3072, 5972))}, (1.0, 1.0, 1.0), None),
    "a title": (titled((1024, 1), (3072, 32767), text="Oregon South (ft)|"), (0.3048,) * 3, "'foot'"),
    "a title in survey feet": (titled((1024, 1), (3072, 32767), text="Texas (ftUS)|"), (1200 / 3937,) * 3, FEET),
    "a title in metres": (titled((1024, 1), (3072, 32767), text="Oregon South (m)|"), (1.0, 1.0, 1.0), None),
    "heights by their number, NAVD88 in survey feet": (
        {34735: keys((1024, 1), (3072, 32617), (4096, 6360))}, (1.0, 1.0, 1200 / 3937), "z is in",
    ),
    "heights by their number, NAVD88 in metres": (
        {34735: keys((1024, 1), (3072, 2277), (3076, 9003), (4096, 5703))}, (1200 / 3937, 1200 / 3937, 1.0), FEET,
    ),
    "WKT of ESRI, the heights beside": (
        {2112: ("PROJCS" + WKT.partition("PROJCS")[2].replace("VERT_CS", "VERTCS")[:-1]).encode()},
        (1200 / 3937, 1200 / 3937, 1.0), FEET,
    ),
    "WKT of a site": ({2112: b'LOCAL_CS["site",LOCAL_DATUM["x",0],UNIT["foot",0.3048]]'}, (0.3048,) * 3, "'foot'"),
    "WKT 2 of a site": (
        {2112: b'ENGCRS["site",EDATUM["x"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],LENGTHUNIT["foot",0.3048]]'},
        (0.3048,) * 3, "'foot'",
    ),
    "WKT 2 of three axes": (
        {2112: (WKT2[:-1] + ',AXIS["h",up,LENGTHUNIT["metre",1]]]').encode()}, (0.3048, 0.3048, 1.0), "'foot'",
    ),
    "WKT by its number": (
        {2112: b'COMPD_CS["a",PROJCS["b",AUTHORITY["EPSG","2277"]],VERT_CS["c",AUTHORITY["EPSG","5703"]]]'},
        (1200 / 3937, 1200 / 3937, 1.0), FEET,
    ),
}  # fmt: skip


@pytest.mark.parametrize("number", [1999, 6349])  # the latter is in degrees, between two systems in metres
def test_a_system_whose_unit_the_file_does_not_tell_is_refused(tmp_path: Path, number: int) -> None:
    path = las(tmp_path / "a.las", POINTS, {34735: keys((1024, 1), (3072, number))})
    with pytest.raises(ReadError, match=rf"names EPSG:{number} and no unit.*state it in the record"):
        read_cloud(path)


def test_angles_in_grads_are_metres(tmp_path: Path) -> None:
    """0.0001 gon of latitude at the equator are 9.95 m."""
    grads = np.array([[8.0, 0.0, 5.0], [8.0, 0.0001, 6.0]])
    records = {34735: keys((1024, 2), (2048, 4807), (2054, 9105))}
    cloud = read_cloud(las(tmp_path / "a.las", grads, records, (1e-7, 1e-7, 0.01)))
    assert cloud.points[1] - cloud.points[0] == pytest.approx([0.0, 9.951, 1.0], abs=0.02)


@pytest.mark.parametrize("end", ["las", "laz"])
@pytest.mark.parametrize("case", UNITS)
def test_units_of_the_projection_record(tmp_path: Path, case: str, end: str) -> None:
    """entwine#305 (feet); GeoTIFF 1.8.2, OGC 01-009 and 18-010, and epsg.org for units of systems."""
    records, sizes, said = UNITS[case]
    cloud = read_cloud(las(tmp_path / f"a.{end}", POINTS, records))
    np.testing.assert_allclose(cloud.points, POINTS * sizes, atol=1e-6)
    assert said in " ".join(cloud.notes) if said else cloud.notes == ()


@pytest.mark.parametrize("records", [{}, {34735: keys((1024, 2), (2048, 4326))}], ids=["not stated", "stated"])
def test_degrees_of_las_are_metres_with_a_note(tmp_path: Path, records: dict[int, bytes]) -> None:
    """Helios#71. 0.0001° of longitude at the equator are 11.13 m."""
    degrees = np.array([[8.0, 0.0, 5.0], [8.0001, 0.0, 6.0], [8.0, 0.0001, 7.0]])
    cloud = read_cloud(las(tmp_path / "a.las", degrees, records, (1e-7, 1e-7, 0.01)))
    assert cloud.points[1] - cloud.points[0] == pytest.approx([11.132, 0.0, 1.0], abs=0.02)
    assert cloud.points[2] - cloud.points[0] == pytest.approx([0.0, 11.057, 2.0], abs=0.02)
    assert "metres east and north of 8.000050°, 0.000050°" in cloud.notes[0]


def test_what_a_projection_record_says_is_compared_with_the_coordinates(tmp_path: Path) -> None:
    degrees = np.array([[8.0, 0.0, 5.0], [8.0001, 0.0, 6.0]])
    path = las(tmp_path / "a.las", degrees, {34735: keys((1024, 1), (3072, 32632))}, (1e-7, 1e-7, 0.01))
    cloud = read_cloud(path)
    assert cloud.points[1] - cloud.points[0] == pytest.approx([11.132, 0.0, 1.0], abs=0.02)
    assert cloud.notes[0].startswith("The file states the unit 'metre', but x and y have steps of 1e-07 and z of 0.01")
    for records in ({34735: keys((1024, 2), (2048, 4326))}, {34735: keys((2048, 4807), (2054, 9105))}):
        far = POINTS + FAR
        cloud = read_cloud(las(tmp_path / "a.las", far, records))
        np.testing.assert_allclose(cloud.points, far, atol=1e-6)
        assert "which no degrees are: they are taken as metres" in cloud.notes[0]


@pytest.mark.parametrize("text", ["", "PROJCS", "PROJCS[" * 100, 'A["b"', "]][[", 'GEOGCS["x"]', "UNIT[,,]"])
def test_odd_records_state_no_length(text: str) -> None:
    found = units_of({2112: text.encode(), 34735: b"\1\0"})
    assert found is None or found.model == "geographic"


# -- what ends early, and what stands in other orders -----------------------------------------------------------------


def ply(form: str, lists: tuple[int, ...] = ()) -> bytes:
    """Return a PLY whose vertices stand between a camera with a list and a face; each with a list of these lengths."""
    listed = "property list uchar float extra\n" if lists else ""
    head = (
        f"ply\nformat {form} 1.0\ncomment by hand\nelement camera 1\nproperty list uchar int at\nproperty float f\n"
        f"element vertex {len(POINTS)}\nproperty float X\n{listed}property double Y\nproperty float Z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    rows = []
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(form, "")
    for k, (x, y, z) in enumerate(POINTS):
        extra = [0.5] * lists[k % len(lists)] if lists else None
        if not order:
            rows.append(
                " ".join(map(str, [x, *([] if extra is None else [len(extra), *extra]), y, z])).encode() + b"\n"
            )
        else:
            middle = b"" if extra is None else struct.pack(f"{order}B{len(extra)}f", len(extra), *extra)
            rows.append(struct.pack(f"{order}f", x) + middle + struct.pack(f"{order}df", y, z))
    camera = struct.pack(f"{order}B2if", 2, 5, 6, 0.5) if order else b"2 5 6 0.5\n"
    face = struct.pack(f"{order}B3i", 3, 0, 1, 2) if order else b"3 0 1 2\n"
    return head + camera + b"".join(rows) + face


@pytest.mark.parametrize("lists", [(), (3,), (0, 2, 5)], ids=["no lists", "even", "uneven"])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_with_other_elements_before_and_lists_within(tmp_path: Path, form: str, lists: tuple[int, ...]) -> None:
    """As plyfile and Open3D read them: elements in any order, with lists."""
    points, notes = read(tmp_path, ply(form, lists), "a.ply")
    np.testing.assert_allclose(points, POINTS, atol=1e-6)
    assert notes == ()
    data = ply(form, lists)
    cut, notes = read(tmp_path, data[: int(0.7 * len(data))], "a.ply")
    assert 3 < len(cut) < 30
    np.testing.assert_allclose(cut, POINTS[: len(cut)], atol=1e-6)
    assert notes == (f"The file ends early: 30 points claimed, {len(cut)} there; these are read.",)


def test_ply_with_types_in_capitals_and_vertices_of_another_name(tmp_path: Path) -> None:
    for name in ("Vertex", "point"):
        head = PLY.replace(b"vertex", name.encode()).replace(b"float", b"Float") + b"end_header\n"
        points, notes = read(tmp_path, head + lines("{:.3f} {:.3f} {:.3f}"), "a.ply")
        np.testing.assert_allclose(points, POINTS, atol=1e-6)
        assert notes == ()


@pytest.mark.parametrize("per_line", [2, 3, 30], ids=["2 on a line", "3 on a line", "all on one line"])
def test_an_ascii_ply_with_several_vertices_on_a_line(tmp_path: Path, per_line: int) -> None:
    """Of rply, which Open3D reads PLY with: words of a file are separated by blanks and ends of lines alike."""
    head = (
        b"ply\nformat ascii 1.0\nelement camera 2\nproperty float a\nproperty float b\nelement vertex 30\n"
        b"property float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int i\nend_header\n"
    )
    words = [f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in POINTS]
    body = "\n".join(" ".join(words[k : k + per_line]) for k in range(0, len(words), per_line))
    found, _ = read(tmp_path, head + f"1 2 3 4\n{body}\n3 0 1 2\n".encode())
    np.testing.assert_allclose(found, POINTS, atol=1e-4)


def test_more_numbers_for_a_vertex_than_the_header_says_are_no_vertices(tmp_path: Path) -> None:
    head = (
        b"ply\nformat ascii 1.0\nelement vertex 30\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    with pytest.raises(ReadError, match="6 numbers each, but the header says 3"):
        read(tmp_path, head + lines("{} {} {} {} {} {}", np.hstack([POINTS, POINTS])))


def test_packed_colours_of_a_pcd_that_are_written_as_whole_floats(tmp_path: Path) -> None:
    """Of a field of the type F in text, PCL reads the bits of a float, and other programs write the number itself."""
    packed = COLOURS @ (65536, 256, 1)
    head = PCD.replace("x y z", "x y z rgb").replace("8 8 8", "8 8 8 4").replace("F F F", "F F F F")
    bits = packed.astype(np.uint32).view(np.float32)
    for values in (packed, bits):
        text = "".join(f"{x} {y} {z} {v:.9g}\n" for (x, y, z), v in zip(POINTS, values, strict=True))
        (tmp_path / "a.pcd").write_bytes(head.replace("1 1 1", "1 1 1 1").encode() + text.encode())
        np.testing.assert_array_equal(read_cloud(tmp_path / "a.pcd").fields["rgb"], COLOURS)


PCD = "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 30\nHEIGHT 1\nPOINTS 30\nDATA ascii\n"
ROWS = lines("{:.3f} {:.3f} {:.3f}")
HEADERS: dict[str, tuple[str, bytes]] = {
    "types in lower case": (PCD.replace("F F F", "f f f"), ROWS),
    "names in upper case": (PCD.replace("x y z", "X Y Z"), ROWS),
    "remarks first": ("\n# by a tool\n#\n# .PCD v.7\n" + PCD, ROWS),
    "no version": (PCD.replace("VERSION 0.7\n", ""), ROWS),
    "words in lower case": (PCD.lower(), ROWS),
    "neither width nor height": (PCD.replace("WIDTH 30\nHEIGHT 1\n", ""), ROWS),
    "another width": (PCD.replace("WIDTH 30", "WIDTH 32"), ROWS),
    "POINTS 0": (PCD.replace("POINTS 30", "POINTS 0"), ROWS),
    "no counts, sizes and types": (PCD.replace("SIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n", ""), ROWS),
    "fields without numbers, and padding": (
        PCD.replace("x y z", "x y z gone _ _").replace("8 8 8", "8 8 8 4 1 2").replace("F F F", "F F F F U U")
        .replace("1 1 1", "1 1 1 0 3 1"), lines("{:.3f} {:.3f} {:.3f} 0 0 0 0"),
    ),
    "COLUMNS": (PCD.replace("FIELDS", "COLUMNS").replace("0.7", ".5"), ROWS),
}  # fmt: skip


@pytest.mark.parametrize("case", HEADERS)
def test_headers_of_pcd(tmp_path: Path, case: str) -> None:
    """Open3D#6924 (types in lower case), PDAL#3254 (a count of 0), and pcl::PCDReader::readHeader."""
    head, rows = HEADERS[case]
    points, notes = read(tmp_path, head.encode() + rows, "a.pcd")
    np.testing.assert_allclose(points, POINTS, atol=1e-6)
    said = {
        "another width": "30 points, but its width and height 32 × 1; the former is",
        "POINTS 0": "the latter are taken",
    }
    assert [said[case] in note for note in notes] == [True] * (case in said)


def cut_pcd() -> bytes:
    return PCD.replace("ascii", "binary").encode() + POINTS.astype("<f8").tobytes()


CUT: dict[str, tuple[str, Callable[[Path], bytes], int]] = {
    "las": ("a.las", lambda folder: las(folder / "b.las", POINTS, {}).read_bytes(), 30),
    "pts": ("a.pts", lambda _: b"30\n" + ROWS, 30),
    "pcd ascii": ("a.pcd", lambda _: PCD.encode() + ROWS, 30),
    "pcd binary": ("a.pcd", lambda _: cut_pcd(), 30),
}


@pytest.mark.parametrize("case", CUT)
def test_of_a_cut_cloud_the_whole_points_are_read(tmp_path: Path, case: str) -> None:
    """Of recordings the intact part is read too."""
    name, made, n = CUT[case]
    points, notes = read(tmp_path, made(tmp_path)[:-70], name)
    assert 24 < len(points) < n
    np.testing.assert_allclose(points, POINTS[: len(points)], atol=1e-6)
    assert notes == (f"The file ends early: {n} points claimed, {len(points)} there; these are read.",)


def test_of_a_cut_laz_file_the_whole_chunks_are_read(tmp_path: Path) -> None:
    many = np.round(RNG.uniform(-9.0, 9.0, (120_000, 3)), 3)
    data = las(tmp_path / "a.laz", many, {}).read_bytes()
    points, notes = read(tmp_path, data[: int(0.7 * len(data))], "b.laz")
    assert 40_000 < len(points) < 90_000
    np.testing.assert_allclose(points, many[: len(points)], atol=1e-6)
    assert "120000 points claimed" in notes[0]


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_of_a_laz_file_that_is_cut_within_its_first_chunk_the_points_before_the_cut_are_read(
    tmp_path: Path, share: float
) -> None:
    many = np.round(RNG.uniform(-9.0, 9.0, (1000, 3)), 3)
    data = las(tmp_path / "a.laz", many, {}).read_bytes()
    points, notes = read(tmp_path, data[: int(share * len(data))], "b.laz")
    assert share - 0.15 < len(points) / len(many) <= share + 0.02
    np.testing.assert_allclose(points, many[: len(points)], atol=1e-6)
    assert notes == (f"The file ends early: 1000 points claimed, {len(points)} there; these are read.",)


def test_a_laz_file_whose_first_chunk_is_in_layers_says_why_none_of_its_points_can_be_read(tmp_path: Path) -> None:
    """Point formats from 6 on store each chunk dimension by dimension."""
    cloud = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    cloud.x, cloud.y, cloud.z = RNG.uniform(-9.0, 9.0, (3, 1000))
    cloud.write(str(tmp_path / "a.laz"))
    data = (tmp_path / "a.laz").read_bytes()
    with pytest.raises(ReadError, match="end early, or are damaged, within their first chunk"):
        read(tmp_path, data[: int(0.9 * len(data))], "b.laz")


def test_a_las_header_that_counts_fewer_points_than_follow_is_noted(tmp_path: Path) -> None:
    """PDAL and laspy read as many as it counts; what follows may be points of a writer that was killed."""
    data = bytearray(las(tmp_path / "a.las", POINTS, {}).read_bytes())
    struct.pack_into("<I", data, 107, 20)
    points, notes = read(tmp_path, bytes(data), "b.las")
    np.testing.assert_allclose(points, POINTS[:20], atol=1e-3)
    assert notes == ("The header says 20 points, which are read; bytes of 10 more follow them.",)


@pytest.mark.parametrize("version", ["1.2", "1.3", "1.4"])
def test_extended_records_of_a_las_file_are_no_points(tmp_path: Path, version: str) -> None:
    header = laspy.LasHeader(point_format=1, version=version)
    header.scales = np.full(3, 0.001)
    cloud = laspy.LasData(header)
    cloud.xyz = POINTS
    if version == "1.4":
        cloud.evlrs = laspy.vlrs.vlrlist.VLRList([VLR("somebody", 7, "", bytes(1000))])
    cloud.write(tmp_path / "a.las")
    found = read_cloud(tmp_path / "a.las")
    np.testing.assert_allclose(found.points, POINTS, atol=1e-3)
    assert not found.notes


def test_a_las_file_whose_header_was_not_written_to_the_end(tmp_path: Path) -> None:
    data = bytearray(las(tmp_path / "a.las", POINTS, {}).read_bytes())
    struct.pack_into("<I", data, 107, 0)
    points, notes = read(tmp_path, bytes(data), "a.las")
    np.testing.assert_allclose(points, POINTS, atol=1e-6)
    assert notes == ("The header says 0 points, and 30 are there: it was not written to the end.",)


# -- octrees, and places far from 0 -----------------------------------------------------------------------------------


def test_a_coloured_octree_has_its_occupancy_and_bytes_after_a_tree_are_noted() -> None:
    """octomap#67, octomap#272."""
    masks, values = np.array([0b101, 0, 0], dtype=np.uint8), np.array([0.4, 0.85, -0.4], dtype=np.float32)
    plain = octree_file(Octree(0.1, values, masks), ".ot", VolumeConfig())
    header = plain.header.replace(b"id OcTree", b"id ColorOcTree")
    nodes = b"".join(struct.pack("<f3BB", value, 10, 20, 30, mask) for value, mask in zip(values, masks, strict=True))
    found = octree_of_bytes(header + nodes + b"more", "a.ot")
    assert found.tree.values.tolist() == values.tolist()
    assert found.tree.masks.tolist() == masks.tolist()
    assert found.notes == (
        "a.ot is a ColorOcTree: its occupancy is read, its colours are not.",
        "a.ot has 4 bytes after its tree, which say nothing of it.",
    )
    again = octree_of_bytes(found.bytes(), "b.ot")
    assert (again.notes, again.tree.values.tolist()) == ((), values.tolist())


@pytest.mark.parametrize(("kind", "end"), [("OcTreeStamped", ".ot"), ("ColorOcTree", ".bt")])
def test_octrees_of_other_kinds_are_those_of_octomap(tmp_path: Path, kind: str, end: str) -> None:
    """Binary trees of all kinds are alike (readBinary), and the times of a stamped one are in no file."""
    written = tmp_path / f"a{end}"
    for name, path in ((kind, written), ("OcTree", tmp_path / f"b{end}")):
        tree = getattr(pyoctomap, name)(0.1)
        for point in POINTS:
            tree.updateNode(point, True)
        (tree.writeBinary if end == ".bt" else tree.write)(str(path))
    found, plain = read_octree(written), read_octree(path)
    assert (found.tree.values.tolist(), found.notes) == (plain.tree.values.tolist(), ())
    assert found.bytes() == written.read_bytes()


def test_headers_of_octrees_are_read_word_by_word_as_octomap_does() -> None:
    plain = octree_file(
        Octree(0.1, np.array([0.4, 0.85], np.float32), np.array([4, 0], np.uint8)), ".ot", VolumeConfig()
    )
    head = b"# Octomap OcTree file of 2013\r\n#res 7\r\nid 1 size 2\r\nres 0.1 # metres\r\nframe map\r\ndata \r\n"
    found = octree_of_bytes(head + plain.bytes()[len(plain.header) :], "a.ot")
    assert (found.tree.resolution, found.tree.values.tolist()) == (0.1, plain.tree.values.tolist())


def test_a_georeferenced_cloud_is_mapped_and_its_files_state_where(tmp_path: Path, run: Run) -> None:
    far = POINTS + np.array([523_000.25, 4_812_000.5, 612.0])
    (tmp_path / "far.xyz").write_bytes(lines("{:.3f} {:.3f} {:.3f}", far))
    names = [tmp_path / f"m.{end}" for end in ("bt", "ply", "glb")]
    outs = [word for name in names for word in ("--out", name)]
    assert (
        "its origin at 523,000, 4,812,000, 600 m"
        in json.loads(run("info", tmp_path / "far.xyz", "--json").out)["notes"][0]
    )
    done = run("map3d", tmp_path / "far.xyz", *outs, "--map", tmp_path / "above", "--resolution", "0.5", "--json")
    assert done.status == 0, done.err
    offset = (523_000.0, 4_812_000.0, 600.0)
    assert "The map’s origin is at 523,000, 4,812,000, 600 m of the file" in json.loads(done.out)["notes"][-1]
    tree = octree_of_bytes(names[0].read_bytes(), "m.bt")
    assert tuple(tree.offset) == offset
    assert b"comment offset 523000.0 4812000.0 600.0\n" in names[1].read_bytes()[:200]
    assert json.dumps({"offset": offset}, separators=(",", ":")).encode() in names[2].read_bytes()
    grid = load_map(tmp_path / "above.yaml").grid
    rows, cols = grid.geometry.world_to_cell(far[:, :2]).T
    assert (grid.log_odds[rows, cols] > 0.0).all()
    again = run("map3d", names[0], tmp_path / "far.xyz", "--out", tmp_path / "n.ot", "--json")
    assert json.loads(again.out)["occupied"] == json.loads(done.out)["occupied"]
    told = run("info", tmp_path / "n.ot")
    assert "The map’s origin is at 523,000, 4,812,000, 600 m of the file" in told.out


def rows(*columns: ArrayLike) -> bytes:
    """POINTS twice, each with further numbers, as a file of 32-bit numbers has them."""
    return np.column_stack([np.vstack([POINTS, POINTS]), *columns]).astype("<f4").tobytes()


SHARES, WHOLE, RINGS = np.linspace(0.0, 0.99, 60), np.arange(60) * 4, np.arange(60) % 32
HEADERLESS = {
    "KITTI": (rows(SHARES), ["intensity"]),
    "KITTI, intensities of one byte": (rows(WHOLE), ["intensity"]),
    "nuScenes": (rows(WHOLE, RINGS), ["intensity", "ring"]),
    "a first number like a byte-order mark": (b"\xff\xfe" + rows(SHARES)[2:], ["intensity"]),
}


@pytest.mark.parametrize("case", HEADERLESS)
def test_points_without_a_header_are_known_by_their_numbers(tmp_path: Path, case: str) -> None:
    data, names = HEADERLESS[case]
    (tmp_path / "000000.bin").write_bytes(data)
    cloud = read_cloud(tmp_path / "000000.bin")
    expected = np.frombuffer(data, "<f4").reshape(60, -1)
    np.testing.assert_array_equal(cloud.points, expected[:, :3])
    assert list(cloud.fields) == names
    for column, name in enumerate(names):
        np.testing.assert_array_equal(cloud.fields[name], expected[:, 3 + column])
    assert "has no header" in cloud.notes[0]
    np.testing.assert_array_equal(cloud.sensor_pose, np.eye(4))


@pytest.mark.parametrize(
    "data",
    [
        rows(),
        np.vstack([POINTS] * 4).tobytes(),
        rows(-SHARES),
        rows(WHOLE, SHARES * 90),
        np.random.default_rng(3).random((60, 4)).astype("<f4").tobytes(),
        rows(SHARES)[:160],
        b"0.25 1.25\n" * 100,
        bytes(1600),
    ],
    ids=["x, y, z", "64 bits", "negative", "no rings", "a table of shares", "few", "text", "zeros"],
)
def test_other_numbers_without_a_header_are_no_points(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(ReadError, match=r"none of the known formats|a cloud needs"):
        read(tmp_path, data, "a.bin")


def test_points_without_a_header_that_do_not_go_on_so_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="does not continue with them"):
        read(tmp_path, rows(SHARES) * 5 + rows(SHARES - 3.0), "a.bin")
    with pytest.raises(ReadError, match="does not continue with them"):
        read(tmp_path, rows(SHARES) + b"\0", "a.bin")


def unpacked(path: Path) -> None:
    """Read a dropped archive as the service does."""
    unpack_depth_archive(path, path.parent, DEFAULT_LIMITS)


@pytest.mark.parametrize(
    ("save", "read_it"),
    [(np.save, read_cloud), (np.save, open_log), (np.savez, read_cloud), (np.savez, open_log), (np.savez, unpacked)],
)
def test_arrays_of_numpy_are_named_with_what_converts_them(
    tmp_path: Path, save: Callable[..., None], read_it: Callable[[Path], object]
) -> None:
    with (tmp_path / "a").open("wb") as file:
        save(file, POINTS)
    with pytest.raises(ReadError, match=r"arrays? of NumPy \(save its points as text"):
        read_it(tmp_path / "a")


def test_a_file_of_no_known_kind_is_refused_by_its_first_bytes(tmp_path: Path) -> None:
    """Of a large one the rest is not read; an empty one is named as such."""
    path = tmp_path / "disk.img"
    with path.open("wb") as file:
        file.truncate(DEFAULT_LIMITS.max_cloud_bytes + 1)
    with pytest.raises(ReadError, match="is none of the known formats"):
        read_cloud(path)
    with pytest.raises(ReadError, match="is empty"):
        read(tmp_path, b"")
