"""OctoMap's scan graphs, beside their fields taken apart by hand."""

from __future__ import annotations

import gzip
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.clouds import read_cloud, read_scan_graph

POINTS = [(1.0, 0.0, 0.5), (0.0, 2.0, -0.5)]


def node(place: tuple[float, ...], u_x_y_z: tuple[float, ...], number: int) -> bytes:
    points = b"".join(struct.pack("<i3d", 3, *point) for point in POINTS)
    pose = struct.pack("<i3d", 3, *place) + struct.pack("<i4d", 4, *u_x_y_z)
    return struct.pack("<I", len(POINTS)) + points + pose + struct.pack("<I", number)


def graph(*nodes: bytes) -> bytes:
    return struct.pack("<I", len(nodes)) + b"".join(nodes) + struct.pack("<I", 0)


STILL, TURNED = node((0, 0, 0), (1, 0, 0, 0), 0), node((10, 0, 1), (2**-0.5, 0, 0, 2**-0.5), 1)
TEXT = b"# a remark\nNODE 0 0 0 0 0 0\n1 0 0.5\n0 2 -0.5\nNODE 10 0 1 0 0 1.5707963267948966\n1 0 0.5\n0 2 -0.5\n"
IN_MAP = [[1, 0, 0.5], [0, 2, -0.5], [10, 1, 1.5], [8, 0, 0.5]]


@pytest.mark.parametrize(
    "data",
    [graph(STILL, TURNED), gzip.compress(graph(STILL, TURNED), mtime=0), TEXT],
    ids=["plain", "gzip", "text"],  # the bytes are no name: gzip's have the time in them
)
def test_the_scans_of_a_graph_lie_where_their_poses_put_them(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.graph"
    path.write_bytes(data)
    scans = list(read_scan_graph(path))
    assert [scan.cloud.points.tolist() for scan in scans] == [[list(point) for point in POINTS]] * 2
    assert scans[1].origin.tolist() == [10, 0, 1]
    assert np.concatenate([scan.points_in_map() for scan in scans]) == pytest.approx(np.array(IN_MAP), abs=1e-12)


def test_a_graph_as_one_cloud_is_in_the_map_s_frame(tmp_path: Path) -> None:
    path = tmp_path / "a.graph"
    path.write_bytes(graph(STILL, TURNED))
    assert read_cloud(path).points == pytest.approx(np.array(IN_MAP), abs=1e-12)


def test_octomap_s_own_scan(data_file: Callable[[str], Path]) -> None:
    path = data_file("octomap/spherical_scan.graph")
    data = path.read_bytes()
    (scan,) = read_scan_graph(path)
    expected = np.array([struct.unpack_from("<3d", data, 12 + 28 * i) for i in range(10201)])
    assert np.array_equal(scan.cloud.points, expected)
    assert scan.pose.tolist() == [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, -0.5], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (graph(STILL, TURNED)[:-20], "2 nodes claimed, 1 whole ones there"),
        (graph(STILL)[:4] + struct.pack("<I", 10**9) + graph(STILL)[8:], "1 nodes claimed, 0 whole ones there"),
        (graph(node((0, 0, 0), (1, 1, 0, 0), 0)), "node 0 of the scan graph is not a rotation"),
        (
            graph(node((0, 0, float("nan")), (1, 0, 0, 0), 0)),
            "Node 0 of the scan graph: The cloud’s pose is not finite",
        ),
        (graph(STILL[:32] + b"\7" + STILL[33:]), "the sizes of its vectors are missing"),
        (b"NODE 0 0 0 0 0\n1 2 3\n", "must have six numbers"),
        (b"NODE 0 0 0 0 0 inf\n1 2 3\n", "angles of node 0 are not finite"),
        (b"NODE 0 0 0 0 0 0\n1 2 3\n1 2\n", "number of values changes near line"),
        (b"NODE 0 0 0 0 0 0\n1 2 x\n", "'x' near line 2 is not a number"),
        (b"VERSION 0.7\n", "is not a scan graph"),
    ],
)
def test_a_damaged_graph_is_told(data: bytes, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "a.graph"
    path.write_bytes(data)
    with pytest.raises(ReadError, match=sentence):
        list(read_scan_graph(path))
