"""Costmaps in recordings: reading nav2_msgs/Costmap, and writing it to MCAP together with nav_msgs/OccupancyGrid.

Sources: nav2_msgs, Costmap.msg and CostmapMetaData.msg; nav2_costmap_2d, costmap_2d_publisher.cpp (the costs of an
OccupancyGrid).
"""

from __future__ import annotations

import math
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid.occupancy_grid import GridGeometry
from mapper.io.export import ros2
from mapper.io.export.topics import Topics
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.containers.container import Container
from mapper.io.logs.names import printable
from mapper.io.logs.opening import parts_of
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.io.logs.ros.ros_messages import plain_type

TYPE = "nav2_msgs/Costmap"
MAX_COSTMAPS = 100_000
MAX_KEPT_BYTES = 1 << 29  #: of all costs of a recording, compressed
MAX_NAME = 200  #: characters


@dataclass(frozen=True, slots=True)
class RecordedCostmap:
    """One message: its costs (rows, cols) uint8, row 0 at the smallest y, and where its cells are.

    ``stamp_ns`` is that of its header, ``received_ns`` when it was recorded. ``layer`` is which layer its costs are of.
    """

    stamp_ns: int
    received_ns: int
    frame: str
    layer: str
    geometry: GridGeometry
    costs: UInt8Array


@dataclass(frozen=True, slots=True)
class KeptCostmap:
    """A costmap whose costs are compressed with zlib."""

    stamp_ns: int
    received_ns: int
    frame: str
    layer: str
    geometry: GridGeometry
    packed: bytes


class CostmapStream(Sequence[RecordedCostmap]):
    """The costmaps of one topic, in the order in which they were recorded; costs are unpacked when one is taken."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.bad = 0  #: messages that could not be read
        self._kept: list[KeptCostmap] = []

    @property
    def kept(self) -> Sequence[KeptCostmap]:
        """All of them, compressed."""
        return tuple(self._kept)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._kept)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN204 - of a sequence
        """Return one, or a list of those of a slice."""
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        costmap = self._kept[index]
        costs = np.frombuffer(zlib.decompress(costmap.packed), dtype=np.uint8).reshape(costmap.geometry.shape)
        return RecordedCostmap(
            costmap.stamp_ns, costmap.received_ns, costmap.frame, costmap.layer, costmap.geometry, costs
        )

    def __iter__(self) -> Iterator[RecordedCostmap]:
        """Yield them one after the other."""
        return (self[k] for k in range(len(self)))

    @property
    def received_ns(self) -> NDArray[np.int64]:
        """Time at which each was recorded (n,)."""
        return np.array([costmap.received_ns for costmap in self._kept], dtype=np.int64)

    @property
    def geometries(self) -> list[GridGeometry]:
        """The cells of each."""
        return [costmap.geometry for costmap in self._kept]

    @property
    def frames(self) -> list[str]:
        """The names of their frames, each once."""
        return sorted({costmap.frame for costmap in self._kept})

    def add(self, costmap: RecordedCostmap) -> int:
        """Keep one; return the bytes that it takes."""
        packed = zlib.compress(costmap.costs.tobytes(), 1)
        self.keep(
            KeptCostmap(costmap.stamp_ns, costmap.received_ns, costmap.frame, costmap.layer, costmap.geometry, packed)
        )
        return len(packed)

    def keep(self, costmap: KeptCostmap) -> None:
        """Keep one that is compressed."""
        self._kept.append(costmap)


def costmap_message(
    data: bytes, received_ns: int = 0, *, cdr: bool, limits: Limits = DEFAULT_LIMITS
) -> RecordedCostmap:
    """Return the costmap in one serialised message. Raises :class:`BadMessageError` and says why."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    fields.unpack("4i", 4)  # map_load_time, update_time
    layer = fields.string()
    (resolution,) = fields.unpack("f", 4)
    cols, rows = (int(n) for n in fields.unpack("2I", 4))
    x, y, _, *turn = fields.pose()
    data_bytes = fields.bytes()
    fields.end()
    if len(data_bytes) != rows * cols:
        raise BadMessageError(f"its header says {cols} × {rows} cells, and it has {len(data_bytes)}")
    norm = math.hypot(*turn)
    if not (math.isfinite(norm) and norm > 0.0):
        raise BadMessageError("the rotation of its origin is not a rotation")
    qx, qy, qz, qw = (part / norm for part in turn)
    if abs(qx) > 1e-3 or abs(qy) > 1e-3:
        raise BadMessageError("its origin is tilted")
    # A float32 says 0.05 as 0.0500000007: the resolution that was meant has few digits.
    try:
        geometry = GridGeometry(float(f"{resolution:.6g}"), rows, cols, (x, y, 2.0 * math.atan2(qz, qw)), limits)
    except (ConfigError, LimitError) as error:
        raise BadMessageError(error.message) from error
    costs = np.frombuffer(data_bytes, dtype=np.uint8).reshape(rows, cols)
    return RecordedCostmap(
        stamp, received_ns, printable(frame[:MAX_NAME]), printable(layer[:MAX_NAME]), geometry, costs
    )


class _Costmaps(MessageSink):
    """Takes the costmaps of a recording, and nothing else."""

    def __init__(self, limits: Limits) -> None:
        self.notes = []
        self.limits = limits
        self.streams: dict[str, CostmapStream] = {}
        self._by_key: dict[int, tuple[CostmapStream, bool]] = {}
        self._announced: set[int] = set()
        self._n = self._bytes = 0
        self.reason = ""

    @property
    def taken(self) -> int:
        return self._n

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        self._announced.add(key)
        if plain_type(kind) == TYPE and readable:
            name = printable(topic[:MAX_NAME])
            if name not in self.streams and len(self.streams) >= self.limits.max_topics:
                raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} topics.")
            self._by_key[key] = self.streams.setdefault(name, CostmapStream(name)), cdr

    def knows(self, key: int) -> bool:
        return key in self._announced

    def wants(self, key: int) -> bool:
        return key in self._by_key

    def pass_over(self, key: int, count: int) -> None:
        pass

    def next_file(self) -> None:
        self._by_key.clear()
        self._announced.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        if key not in self._by_key:
            return
        stream, cdr = self._by_key[key]
        try:
            if data[:4] == ZSTD_MAGIC:
                data, _ = inflate("zstd", data, self.limits.max_chunk_bytes, "a message")
            costmap = costmap_message(data, stamp_ns, cdr=cdr, limits=self.limits)
        except (BadMessageError, ReadError) as error:
            stream.bad += 1
            self.reason = self.reason or str(error)
            return
        self._n += 1
        self._bytes += stream.add(costmap)
        if self._n > MAX_COSTMAPS or self._bytes > MAX_KEPT_BYTES:
            raise LimitError(
                "costmaps.too_many",
                f"The recording has more than {MAX_COSTMAPS} costmaps, or {MAX_KEPT_BYTES >> 20} MiB of them.",
            )


def open_costmaps(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> dict[str, CostmapStream]:
    """Return the costmaps of the recording at ``path`` by topic.

    Messages that cannot be read are counted in ``bad`` of their stream. Raises :class:`ReadError` for a file that is no
    recording or has no costmap that can be read, :class:`LimitError`, and as :func:`mapper.io.logs.open_log`.
    """
    files, kind = parts_of(Path(path), limits)
    sink = _Costmaps(limits)
    if isinstance(kind, Container):
        for file in files:
            kind.take(file, sink, limits, progress)
            sink.next_file()
    streams = {topic: stream for topic, stream in sink.streams.items() if len(stream)}
    if not streams:
        why = f": {sink.reason}" if sink.reason else ""
        raise ReadError("costmaps.none", f"The file holds no costmaps ({TYPE} in a bag or an MCAP){why}.")
    return streams


def occupancy_of_costs(costs: UInt8Array) -> Int8Array:
    """Convert costs to nav_msgs/OccupancyGrid values: 0 free, 1 … 98, 99 inscribed, 100 lethal, −1 unknown."""
    table = np.zeros(256, dtype=np.int8)
    table[1:253] = 1 + 97 * np.arange(252) // 251
    table[253], table[254], table[255] = 99, 100, -1
    return table[costs]


def write_costmaps(file: IO[bytes], costmaps: Iterable[RecordedCostmap], topic: str = "/costmap") -> int:
    """Write each costmap to ``topic``_raw as nav2_msgs/Costmap and to ``topic`` as OccupancyGrid, named as in Nav2.

    Return the number written. Raises :class:`ConfigError` for a time before 0 or beyond 32 bits of seconds.
    """
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start("ros2", "gridbloom")
    topics = Topics(writer, frozenset({topic, f"{topic}_raw"}))
    n = 0
    for costmap in costmaps:
        stamp, geometry = costmap.stamp_ns, costmap.geometry
        if not 0 <= stamp <= ros2.LAST_STAMP_NS:
            raise ConfigError("costmap.stamp", f"A costmap’s time must be 0 … 2^31 s, not {stamp} ns.")
        message = ros2.costmap(stamp, costmap.frame, costmap.layer, geometry.resolution, geometry.origin, costmap.costs)
        topics.send(f"{topic}_raw", "nav2_msgs/msg/Costmap", stamp, message)
        values = occupancy_of_costs(costmap.costs)
        message = ros2.occupancy_grid(stamp, costmap.frame, geometry.resolution, geometry.origin, values)
        topics.send(topic, "nav_msgs/msg/OccupancyGrid", stamp, message)
        n += 1
    writer.finish()  # type: ignore[no-untyped-call]
    return n
