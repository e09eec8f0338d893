"""A small valid file of every format that is read, to be damaged: text logs, recordings, map images."""

from __future__ import annotations

import gzip
import io
import struct
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from PIL import Image

from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, odometry, scan, sonar, transform

# -- text ---------------------------------------------------------------------------------------------------------

_POSES = [(0.1 * i, 0.02 * i, 0.05 * i) for i in range(5)]


def _carmen_raw() -> str:
    lines = ["# CARMEN Logfile", "PARAM robot_frontlaser_offset 0.2 nohost 0", "PARAM robot_frontlaser_max 30 nohost 0"]
    for i, (x, y, theta) in enumerate(_POSES):
        robot, laser = f"{x:.3f} {y:.3f} {theta:.3f}", f"{x + 0.2:.3f} {y:.3f} {theta:.3f}"
        lines += [
            f"ODOM {robot} 0.1 0 0 {12.4 + i} host {0.4 + i}",
            f"FLASER 4 {1 + i}.0 2.0 3.0 81.83 {laser} {robot} {12.5 + i} host {0.5 + i}",
            f"RLASER 4 1.0 2.0 3.0 4.0 {laser} {robot} {12.5 + i} host {0.5 + i}",
            f"TRUEPOS {robot} {robot} {12.5 + i} host {0.5 + i}",
        ]
    return "\n".join([*lines, ""])


def _carmen_corrected() -> str:
    lines = ["PARAM robot_frontlaser_offset 0.2 nohost 0"]
    for i, (x, y, theta) in enumerate(_POSES):
        better = f"{x + 0.01 * i:.3f} {y - 0.01 * i:.3f} {theta:.3f}"
        lines += [
            f"ODOM {x:.3f} {y:.3f} {theta:.3f} 0.1 0 0 {12.4 + i} host {0.4 + i}",
            f"FLASER 4 {1 + i}.0 2.0 3.0 4.0 {better} {x:.3f} {y:.3f} {theta:.3f} {12.5 + i} host {0.5 + i}",
            f"ODOM {better} 0 0 0 3.1 host 0",  # gmapping's restart from the corrected pose
            "NEFF 12.5",
        ]
    return "\n".join([*lines, ""])


def _carmen_robot_laser() -> str:
    lines = []
    for i, (x, y, theta) in enumerate(_POSES):
        pose = f"{x:.3f} {y:.3f} {theta:.3f}"
        lines.append(
            f"ROBOTLASER1 0 -1.57 3.14 0.785 50 0.1 0 4 {1 + i} 2 3 50 2 9 9 {pose} {pose} 0 0 0 0 0 "
            f"{12.5 + i} host {0.5 + i}"
        )
    return "\n".join([*lines, ""])


def _csv() -> str:
    head = "# a remark\nangle_min,-1\nangle_increment,0.5\nrange_min,0.1\nrange_max,9\nmount_x,0.2\nmount_yaw,0.1\n"
    rows = (f"{i},{x:.3f},{y:.3f},{theta:.3f},{1 + i}.5,2.5,,inf\n" for i, (x, y, theta) in enumerate(_POSES))
    return head + "stamp,x,y,theta,ranges\n" + "".join(rows)


def _breezyslam() -> str:
    return "".join(f"{1000 + i} 0 {5 * i} {6 * i} {'1 ' * 20}{100 + i} 200 0 300 1\n" for i in range(5))


def _dpslam() -> str:
    poses = (f"Odometry {x:.3f} {y:.3f} {theta:.3f}\nLaser 4 1.5 2.5 8.183 3.5\n" for x, y, theta in _POSES)
    return "".join(poses)


def _cmu() -> str:
    lines = []
    for i, (x, y, theta) in enumerate(_POSES):
        robot, laser = f"{100 * x:.2f} {100 * y:.2f} {theta:.3f}", f"{100 * x + 25:.2f} {100 * y:.2f} {theta:.3f}"
        readings = f"{100 + i} 8183 " + "7 " * 178
        lines += [f"O {robot} {0.4 + i:.2f}", f"L {robot} {laser} {readings}{0.5 + i:.2f}"]
    return "\n".join([*lines, ""])


#: Format → a small log, as text.
TEXTS = {
    "carmen raw": _carmen_raw(),
    "carmen corrected": _carmen_corrected(),
    "carmen robot laser": _carmen_robot_laser(),
    "csv": _csv(),
    "breezyslam": _breezyslam(),
    "dpslam": _dpslam(),
    "cmu": _cmu(),
}

#: The two files of a sonar ring.
SONAR_READINGS = "".join(f"{1000 + i} {5110 - i} 1000 2500 9999 700\n" for i in range(5))
SONAR_POSES = "".join(f"{1000 + i} {100 * i} {-50 * i} {90 * i}\n" for i in range(5))

PACKINGS = {"gzip": lambda data: gzip.compress(data, mtime=0), "zstd": zstandard.compress}

# -- recordings ---------------------------------------------------------------------------------------------------

T0 = 1_700_000_000 * SECOND
BAGS = ("bag-none", "bag-bz2", "bag-lz4")
MCAPS = ("mcap-none", "mcap-none-flat", "mcap-lz4", "mcap-zstd")
CLOUDS = ("bag-none-clouds", "mcap-none-clouds")  #: without a lidar: scans are cut out of what there is
RECORDINGS = (*BAGS, *MCAPS, "db3", *CLOUDS)


def said(n: int = 6) -> list[recorded.Said]:
    """A bit of everything that is decoded."""
    messages = [transform(T0, "base_link", "laser", 0.2, topic="/tf_static")]
    for i in range(n):
        at = T0 + i * SECOND // 10
        messages += [
            transform(at, "odom", "base_link", i / 10),
            odometry(at, i / 10, 0.0, 0.0),
            scan(at, [1.0, 2.0, 3.0]),
            recorded.echoes(at, [[1.0], [], [2.0, 3.0]]),
            sonar(at, 1.0),
        ]
    return messages


def said_of_clouds(n: int = 5) -> list[recorded.Said]:
    """Clouds and depth images."""
    messages = [transform(T0, "base_link", "velodyne", 0.2, z=0.5, topic="/tf_static")]
    messages.append(recorded.camera(T0, (6, 4), 5.0))
    points = np.random.default_rng(0).uniform(-4, 4, (12, 3))
    for i in range(n):
        at = T0 + i * SECOND // 10
        messages += [
            odometry(at, i / 10, 0.0, 0.0),
            recorded.cloud(at, points, rows=3, padding=(3, 5)),
            recorded.image(at, np.full((4, 6), 2000 + i)),
        ]
    return messages


@cache
def recording(kind: str) -> bytes:
    """A small whole recording of one of :data:`RECORDINGS`."""
    if kind == "bag-none-clouds":
        with tempfile.TemporaryDirectory() as folder:
            return recorded.write_bag(Path(folder) / "a.bag", said_of_clouds()).read_bytes()
    if kind == "mcap-none-clouds":
        return recorded.mcap_bytes(said_of_clouds(), "none", use_chunking=False)
    if kind.startswith("mcap"):
        _, compression, *flat = kind.split("-")
        return recorded.mcap_bytes(said(), compression, use_chunking=not flat, chunk_size=800)
    with tempfile.TemporaryDirectory() as folder:
        if kind == "db3":
            return recorded.written(Path(folder), said(), "db3").read_bytes()
        return recorded.write_bag(Path(folder) / "a.bag", said(), kind.split("-")[1]).read_bytes()


def ended(builder: RecordBuilder) -> bytes:
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def bag_record(fields: dict[str, bytes], data: bytes) -> bytes:
    header = b"".join(struct.pack("<I", len(n) + 1 + len(v)) + n.encode() + b"=" + v for n, v in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def bag_with_chunk(compression: str, data: bytes) -> bytes:
    chunk = bag_record({"op": b"\x05", "compression": compression.encode(), "size": b"\xff\xff\xff\xff"}, data)
    return b"#ROSBAG V2.0\n" + chunk


def mcap_with_chunk(compression: str, data: bytes, size: int, crc: int = 0) -> bytes:
    builder = RecordBuilder()
    Chunk(
        compression=compression,
        data=data,
        message_end_time=0,
        message_start_time=0,
        uncompressed_crc=crc,
        uncompressed_size=size,
    ).write(builder)
    return b"\x89MCAP0\r\n" + ended(builder)


# -- maps ---------------------------------------------------------------------------------------------------------

MAP_YAML = (
    "image: m.pgm\nresolution: 0.05\norigin: [-1.5, 2.25, 0.5]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.196\nmode: trinary\n"
)
PGM = b"P5\n# a remark\n4 3\n255\n" + bytes(range(0, 240, 20))


@cache
def images() -> dict[str, bytes]:
    """A small map image of each kind that is read."""
    pixels = Image.fromarray(np.arange(240, dtype=np.uint8).reshape(6, 10, 4))
    deep = Image.fromarray((np.arange(60, dtype=np.uint16) * 1000).reshape(6, 10))
    found = {
        "pgm": PGM,
        "pgm of 16 bits": b"P5\n4 3\n65535\n" + bytes(24),
        "pgm as text": b"P2\n2 2\n255\n0 9 99 255\n",
    }
    for name, image, form in (
        ("png rgba", pixels, "PNG"),
        ("png palette", pixels.convert("P"), "PNG"),
        ("png grey", pixels.convert("L"), "PNG"),
        ("png of 16 bits", deep, "PNG"),
        ("bmp", pixels.convert("RGB"), "BMP"),
        ("bmp palette", pixels.convert("P"), "BMP"),
    ):
        out = io.BytesIO()
        image.save(out, form)
        found[name] = out.getvalue()
    return found
