"""Small files whose headers claim much: what cannot fit into a file is refused without going through it.

All are read by one process with a limit of processor time, far above what they take and far below what going through
the claims would; the file that was being read when it ended is the one that fails.
"""

from __future__ import annotations

import resource
import sqlite3
import struct
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import laspy
import numpy as np
import pytest

from tests.hostile.archives import tarred
from tests.hostile.corpus import bag_record, mcap_with_chunk, recording
from tests.mapper.io.clouds import test_formats, test_pcd

MOST = 2**32 - 1
CPU_S = 90  #: of all of them and of the imports, some ten seconds
MEMORY = 12 << 30  #: of address space: claims are no reason to reserve memory

READER = """
import sys
from pathlib import Path
from mapper.core.errors import MapperError
from mapper.io.clouds import read_cloud
from mapper.io.logs import open_log
from mapper.io.maps import load_map
from mapper.volume.octree.files import read_octree
readers = {"cloud": read_cloud, "log": open_log, "map": load_map, "octree": read_octree}
for path in map(Path, sys.argv[1:]):
    print(path.name, flush=True)
    try:
        readers[path.name.split("-")[0]](path)
    except MapperError as error:
        print("refused:", error.message, flush=True)
    else:
        print("read", flush=True)
"""


def las(end: str, at: int, form: str, *values: int) -> Callable[[Path], bytes]:
    """Return what makes a LAS or LAZ file of version 1.4 with other numbers at a place of its header."""

    def made(folder: Path) -> bytes:
        header = laspy.LasHeader(point_format=6, version="1.4")
        out = laspy.LasData(header)
        out.x, out.y, out.z = np.array(test_formats.POINTS).T * 1e-3
        path = folder / f"plain.{end}"
        out.write(path)
        data = bytearray(path.read_bytes())
        struct.pack_into(form, data, at, *values)
        return bytes(data)

    return made


def chunk_table(folder: Path) -> bytes:
    """A LAZ file whose table of chunks claims four thousand million of them."""
    data = bytearray(las("laz", 247, "<Q", len(test_formats.POINTS))(folder))
    (points_at,) = struct.unpack_from("<I", data, 96)
    (table,) = struct.unpack_from("<q", data, points_at)
    struct.pack_into("<II", data, table, 0, MOST)
    return bytes(data)


def ply(header: str, rows: bytes = b"") -> bytes:
    return f"ply\nformat binary_little_endian 1.0\n{header}end_header\n".encode() + rows


XYZ = "property float x\nproperty float y\nproperty float z\n"


def repeated_cell() -> bytes:
    """A recording in SQLite whose one page of messages names one cell 681 times: of a message of 1.6 MB."""
    size = 489 + 400 * 4092 - 40
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute("PRAGMA page_size=4096")
        connection.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)")
        connection.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        connection.execute("INSERT INTO topics VALUES(1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')")
        connection.execute("INSERT INTO messages VALUES(1, 1, 1700000000000000000, zeroblob(?))", (size,))
        connection.commit()
        (page,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'").fetchone()
        data = bytearray(connection.serialize())
    at = (page - 1) * 4096
    (cell,) = struct.unpack_from(">H", data, at + 8)
    n = (4096 - 8) // 6  # as many cells as SQLite takes for possible
    struct.pack_into(">H", data, at + 3, n)
    struct.pack_into(f">{n}H", data, at + 8, *[cell] * n)
    return bytes(data)


def bag_index(count: int) -> bytes:
    index = {"op": b"\x04", "ver": struct.pack("<I", 1), "conn": bytes(4), "count": struct.pack("<I", count)}
    return b"#ROSBAG V2.0\n" + bag_record(index, bytes(24)) * 3


def bag_header() -> bytes:
    much = struct.pack("<I", MOST)
    header = {"op": b"\x03", "index_pos": bytes(8), "conn_count": much, "chunk_count": much}
    return b"#ROSBAG V2.0\n" + bag_record(header, b" " * 4000)


def mapped(image: bytes) -> Callable[[Path], bytes]:
    def made(folder: Path) -> bytes:
        (folder / "claims.pgm").write_bytes(image)
        thresholds = b"negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
        return b"image: claims.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n" + thresholds

    return made


def png(width: int, height: int) -> bytes:
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBBI", 13, b"IHDR", width, height, 8, 0, 0, 0, 0, 0)


def vtk(text: str) -> bytes:
    return f"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\n{text}\n".encode()


CASES: dict[str, Callable[[Path], bytes]] = {
    "cloud-records.las": las("las", 100, "<I", MOST),
    "cloud-records.laz": las("laz", 100, "<I", MOST),
    "cloud-extended.las": las("las", 235, "<QI", 375, MOST),
    "cloud-extended-far.las": las("las", 235, "<QI", 2**62, MOST),
    "cloud-points.las": las("las", 247, "<Q", 49_000_000),
    "cloud-points.laz": las("laz", 247, "<Q", 49_000_000),
    "cloud-most-points.laz": las("laz", 247, "<Q", 2**63),
    "cloud-start.las": las("las", 96, "<I", MOST),
    "cloud-chunks.laz": chunk_table,
    "cloud-vertices.ply": lambda _: ply(f"element vertex 49000000\n{XYZ}", bytes(24)),
    "cloud-before.ply": lambda _: ply(f"element a 49000000\nelement b 49000000\nproperty list uchar char l\n"
                                      f"element vertex 1\n{XYZ}", bytes(2000)),
    "cloud-list.ply": lambda _: ply(f"element a 3\nproperty list uint double l\nelement vertex 1\n{XYZ}", b"\xff" * 99),
    "cloud-uneven.ply": lambda _: ply(f"element a 49000000\nproperty list uchar char l\nelement vertex 1\n{XYZ}",
                                      b"\0\1\0" * 999),
    "cloud-ascii.ply": lambda _: b"ply\nformat ascii 1.0\nelement vertex 49000000\n" + XYZ.encode()
    + b"end_header\n1 2 3\n",
    "cloud-binary.pcd": lambda _: test_pcd.written("binary").replace(b"POINTS 4", b"POINTS 49000000"),
    "cloud-ascii.pcd": lambda _: test_pcd.written("ascii").replace(b"POINTS 4", b"POINTS 49000000"),
    "cloud-packed.pcd": lambda _: test_pcd.written("binary_compressed").replace(b"POINTS 4", b"POINTS 49000000"),
    "cloud-wide.pcd": lambda _: test_pcd.written("binary").replace(b"COUNT 1", b"COUNT 999999999"),
    "cloud-points.vtk": lambda _: vtk("POINTS 49000000 double"),
    "cloud-fields.vtk": lambda _: vtk(f"POINTS 0 float\nPOINT_DATA 0\nFIELD f {2**47}"),
    "cloud-cells.vtk": lambda _: vtk(f"VERTICES 1 {2**47}\nPOINTS 1 float"),
    "cloud-graph.graph": lambda _: struct.pack("<IIi", 2**24 - 1, 2**30 - 1, 3) + bytes(200),
    "cloud-nodes.graph": lambda _: struct.pack("<IIi3d", 2**24 - 1, 1, 3, 0, 0, 0) + bytes(200),
    "cloud-scans.pts": lambda _: b"49000000\n1 2 3\n" * 200,
    "octree-size.bt": lambda _: b"# Octomap OcTree binary file\nid OcTree\nsize 4000000000\nres 1\ndata\n" + bytes(40),
    "octree-nodes.ot": lambda _: b"# Octomap OcTree file\nid OcTree\nsize 4000000000\nres 0.1\ndata\n" + b"\xff" * 400,
    "octree-colour.ot": lambda _: b"# Octomap OcTree file\nid ColorOcTree\nsize 9\nres 0.1\ndata\n" + b"\xff" * 400,
    "map-pgm.yaml": mapped(b"P5\n40000 40000\n255\n" + bytes(900)),
    "map-plain.yaml": mapped(b"P2\n30000 30000\n255\n1 2 3"),
    "map-png.yaml": mapped(png(2**31 - 1, 2**31 - 1)),
    "map-wide-png.yaml": mapped(png(40_000, 1)),
    "log-index.bag": lambda _: bag_index(MOST),
    "log-header.bag": lambda _: bag_header(),
    "log-chunk.mcap": lambda _: mcap_with_chunk("zstd", bytes(40), MOST << 16),
    "log-cut.mcap": lambda _: recording("mcap-none").replace(struct.pack("<I", 1), struct.pack("<I", MOST)),
    "log-cells.db3": lambda _: repeated_cell(),
    "log-pages.db3": lambda _: recording("db3")[:28] + struct.pack(">I", MOST) + recording("db3")[32:],
    "log-member.tar": lambda _: tarred({"a.log": b"x" * 100}).replace(b"00000000144", b"77777777777"),
}  # fmt: skip


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the reader said of each file that it came to."""
    folder = tmp_path_factory.mktemp("claims")
    paths = []
    for name, made in CASES.items():
        own = folder / name.replace(".", "-")
        own.mkdir()
        (own / name).write_bytes(made(own))
        paths.append(own / name)

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    command = [sys.executable, "-c", READER, *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, preexec_fn=limited)
    said = done.stdout.splitlines()
    return dict(zip(said[::2], [*said[1::2], f"ended by {done.returncode}: {done.stderr[-300:]}"], strict=False))


@pytest.mark.parametrize("name", CASES)
def test_what_cannot_fit_is_refused_from_its_header(output: dict[str, str], name: str) -> None:
    assert name in output, f"The reader ended before, at {list(output.items())[-1]}."
    assert output[name].startswith(("refused: ", "read")), output[name]


def test_a_recording_is_not_read_beyond_the_bytes_that_it_has(output: dict[str, str]) -> None:
    assert "its messages have more than the 1650688 bytes of the file" in output["log-cells.db3"]
