"""Recordings of any size with a camera in them, written message by message by the libraries' own writers.

The robot drives round a hall with a planar lidar, states its pose in tf with each scan, and films noise, which no
compression makes smaller.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import mcap.writer
import numpy as np
from mcap.writer import CompressionType
from numpy.typing import NDArray
from rosbags import rosbag1, rosbag2

from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND

T0 = 1_700_000_000 * SECOND
HALL = (40.0, 25.0)  #: metres, with a corner at the origin
ROUND = 1000  #: scans of one round; then the robot goes over the same places again
SCAN_NS = SECOND // 40
RANGE_MAX = 30.0
SCAN, TF, IMAGE = "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/Image"
TOPICS = {"/scan": SCAN, "/tf": TF, "/camera/image_raw": IMAGE}

Send = Callable[[str, int, bytes], None]


@dataclass(frozen=True, slots=True)
class CameraRun:
    """Contents of the recording: one image of ``image_bytes`` of noise after every ``scans_per_image`` scans."""

    n_scans: int
    n_beams: int = 1080
    image_bytes: int = 640 * 480 * 3
    scans_per_image: int = 10

    @property
    def scan_bytes(self) -> int:
        """Bytes of the readings alone."""
        return 4 * self.n_scans * self.n_beams

    def for_bytes(self, size: int) -> CameraRun:
        """Return the same run with as many images as make the file about ``size`` bytes."""
        images = max(1, (size - self.scan_bytes) // self.image_bytes)
        return CameraRun(self.n_scans, self.n_beams, self.image_bytes, max(1, self.n_scans // images))


def poses(run: CameraRun) -> NDArray[np.float64]:
    """Return where the robot is at the scans of one round (ROUND, 3), metres and radians."""
    turn = np.linspace(0.0, 2.0 * np.pi, min(run.n_scans, ROUND), endpoint=False)
    return np.column_stack([20.0 + 12.0 * np.cos(turn), 12.5 + 6.0 * np.sin(turn), turn + np.pi / 2])


def ranges(run: CameraRun) -> NDArray[np.float32]:
    """Return what the lidar of 270° measures in the hall at these poses (ROUND, n_beams), metres."""
    where = poses(run)
    bearing = where[:, 2:] + np.linspace(-0.75 * np.pi, 0.75 * np.pi, run.n_beams)
    cos, sin = np.cos(bearing), np.sin(bearing)
    with np.errstate(divide="ignore"):
        along_x = (np.where(cos > 0.0, HALL[0], 0.0) - where[:, :1]) / cos
        along_y = (np.where(sin > 0.0, HALL[1], 0.0) - where[:, 1:2]) / sin
    noise = np.random.default_rng(7).normal(0.0, 0.01, bearing.shape)
    return np.asarray(np.minimum(np.abs(along_x), np.abs(along_y)) + noise, dtype=np.float32)


def write(path: Path, kind: str, run: CameraRun, compression: str = "none") -> Path:
    """Write ``run`` as a "mcap", "bag" or "db3"; return the file, which is ``path`` or, of a db3, in that folder."""
    writers = {"mcap": _mcap, "bag": _bag, "db3": _db3}
    ros = 1 if kind == "bag" else 2
    with writers[kind](path, compression) as send:
        for topic, stamp, data in _messages(run, ros):
            send(topic, stamp, data)
    return next(path.glob("*.db3")) if kind == "db3" else path


def _messages(run: CameraRun, ros: int) -> Iterator[tuple[str, int, bytes]]:
    where, measured = poses(run), ranges(run)
    step = 1.5 * np.pi / (run.n_beams - 1)
    marked = np.arange(1.0, 1.0 + run.n_beams, dtype=np.float32)  # to find the readings in the serialised message
    template = recorded.scan(T0, marked, angles=(-0.75 * np.pi, step), limits=(0.05, RANGE_MAX))
    scan = bytearray(recorded.serialised(template, ros))
    at = bytes(scan).index(marked.tobytes())
    stamp_at = bytes(scan).index(struct.pack("<II", T0 // SECOND, 0))
    image = _image(run, ros)
    noise = np.random.default_rng(3).integers(0, 256, 16 * run.image_bytes, dtype=np.uint8).tobytes()
    offsets = np.random.default_rng(4).integers(0, 15 * run.image_bytes, run.n_scans)
    mount = recorded.transform(T0, "base_link", "laser", 0.2)
    yield "/tf", T0, recorded.serialised(mount, ros)
    for i in range(run.n_scans):
        stamp = T0 + i * SCAN_NS
        x, y, yaw = where[i % len(where)]
        moved = recorded.transform(stamp, "odom", "base_link", x - 0.2 * np.cos(yaw), y - 0.2 * np.sin(yaw), yaw)
        yield "/tf", stamp, recorded.serialised(moved, ros)
        struct.pack_into("<II", scan, stamp_at, stamp // SECOND, stamp % SECOND)
        scan[at : at + 4 * run.n_beams] = measured[i % len(measured)].tobytes()
        yield "/scan", stamp, bytes(scan)
        if i % run.scans_per_image == 0:
            yield "/camera/image_raw", stamp, image + noise[offsets[i] : offsets[i] + run.image_bytes]


def _image(run: CameraRun, ros: int) -> bytes:
    """Return a sensor_msgs/Image of one row up to its pixels."""
    pixels = bytes(run.image_bytes)
    fields = {
        "header": recorded.header(T0, "camera"),
        "height": 1,
        "width": run.image_bytes,
        "encoding": "mono8",
        "is_bigendian": 0,
        "step": run.image_bytes,
        "data": np.frombuffer(pixels, dtype=np.uint8),
    }
    message = recorded.serialised(recorded.Said("/camera/image_raw", IMAGE, T0, fields), ros)
    return message[: message.index(pixels)]


@contextmanager
def _mcap(path: Path, compression: str) -> Iterator[Send]:
    with path.open("wb") as file:
        writer = mcap.writer.Writer(file, compression=CompressionType[compression.upper()])
        writer.start("ros2")
        channels = {}
        for topic, kind in TOPICS.items():
            definition, _ = recorded.store(2).generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(kind, "ros2msg", definition.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        yield lambda topic, stamp, data: writer.add_message(channels[topic], stamp, data, stamp)
        writer.finish()  # type: ignore[no-untyped-call]


@contextmanager
def _bag(path: Path, compression: str) -> Iterator[Send]:
    writer = rosbag1.Writer(path)
    if compression != "none":
        writer.set_compression(rosbag1.Writer.CompressionFormat[compression.upper()])
    with writer:
        connections = {
            topic: writer.add_connection(topic, kind, typestore=recorded.store(1)) for topic, kind in TOPICS.items()
        }
        yield lambda topic, stamp, data: writer.write(connections[topic], stamp, data)


@contextmanager
def _db3(path: Path, compression: str) -> Iterator[Send]:
    assert compression == "none"
    with ExitStack() as stack:
        writer = stack.enter_context(rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3))
        connections = {
            topic: writer.add_connection(topic, kind, typestore=recorded.store(2)) for topic, kind in TOPICS.items()
        }
        yield lambda topic, stamp, data: writer.write(connections[topic], stamp, data)
