"""Reading of nav2_msgs/Costmap messages from a recording.

Source: nav2_msgs, Costmap.msg and CostmapMetaData.msg.
"""

from __future__ import annotations

import math
import os
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid.occupancy_grid import GridGeometry
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
    """One message: its costs (rows, cols) uint8, row 0 at the smallest y, and the geometry of its cells.

    ``stamp_ns`` is its header's stamp, ``received_ns`` the recording time. ``layer`` is the layer of its costs.
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
    """The costmaps of one topic in recording order; costs are decompressed on access."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.bad = 0  #: messages that could not be read
        self._kept: list[KeptCostmap] = []

    @property
    def kept(self) -> Sequence[KeptCostmap]:
        """All costmaps, compressed."""
        return tuple(self._kept)

    def __len__(self) -> int:
        """Return the number of costmaps."""
        return len(self._kept)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN204 - of a sequence
        """Return one costmap, or a list for a slice."""
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        costmap = self._kept[index]
        costs = np.frombuffer(zlib.decompress(costmap.packed), dtype=np.uint8).reshape(costmap.geometry.shape)
        return RecordedCostmap(
            costmap.stamp_ns, costmap.received_ns, costmap.frame, costmap.layer, costmap.geometry, costs
        )

    def __iter__(self) -> Iterator[RecordedCostmap]:
        """Yield the costmaps in order."""
        return (self[k] for k in range(len(self)))

    @property
    def received_ns(self) -> NDArray[np.int64]:
        """Recording time of each (n,)."""
        return np.array([costmap.received_ns for costmap in self._kept], dtype=np.int64)

    @property
    def geometries(self) -> list[GridGeometry]:
        """The geometry of each."""
        return [costmap.geometry for costmap in self._kept]

    @property
    def frames(self) -> list[str]:
        """The distinct frame names."""
        return sorted({costmap.frame for costmap in self._kept})

    def add(self, costmap: RecordedCostmap) -> int:
        """Add a costmap; return its size in bytes."""
        packed = zlib.compress(costmap.costs.tobytes(), 1)
        self.keep(
            KeptCostmap(costmap.stamp_ns, costmap.received_ns, costmap.frame, costmap.layer, costmap.geometry, packed)
        )
        return len(packed)

    def keep(self, costmap: KeptCostmap) -> None:
        """Add a compressed costmap."""
        self._kept.append(costmap)


def costmap_message(
    data: bytes, received_ns: int = 0, *, cdr: bool, limits: Limits = DEFAULT_LIMITS
) -> RecordedCostmap:
    """Return the costmap in a serialised message. Raises :class:`BadMessageError` with the reason."""
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
    # As float32, 0.05 is 0.0500000007; the intended resolution has few digits.
    try:
        geometry = GridGeometry(float(f"{resolution:.6g}"), rows, cols, (x, y, 2.0 * math.atan2(qz, qw)), limits)
    except (ConfigError, LimitError) as error:
        raise BadMessageError(error.message) from error
    costs = np.frombuffer(data_bytes, dtype=np.uint8).reshape(rows, cols)
    return RecordedCostmap(
        stamp, received_ns, printable(frame[:MAX_NAME]), printable(layer[:MAX_NAME]), geometry, costs
    )


class _Costmaps(MessageSink):
    """Collects the costmaps of a recording, and nothing else."""

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

    Unreadable messages are counted in ``bad`` of their stream. Raises :class:`ReadError` for a file that is not a
    recording or has no readable costmap, :class:`LimitError`, and the errors of :func:`mapper.io.logs.open_log`.
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
