"""Numbers in the messages of any topic over time, decoded with the recording's definition, and their frames.

To be run in a process with limits, like :mod:`mapper.io.contents.message_tree`, which decodes the messages. Source of
the fields with names of frames: std_msgs/Header, and the definitions of the messages that start with one, in ROS 1 and
ROS 2.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.errors import MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se3 import to_euler
from mapper.io.contents.downsampling import min_max
from mapper.io.contents.message_tree import Decoder, decoder_of
from mapper.io.contents.model import Column, Series
from mapper.io.contents.seeking import first_messages, no_messages, stated_in, unpacked
from mapper.io.contents.tree_values import Tree
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress, part_of
from mapper.io.logs.containers.container import Container
from mapper.io.logs.containers.mcap_file import ENCODINGS
from mapper.io.logs.names import printable
from mapper.io.logs.opening import parts_of
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.io.logs.ros.ros_messages import plain_type

_AXES = {
    "position": "m", "translation": "m", "linear": "m/s", "angular": "rad/s", "angular_velocity": "rad/s",
    "linear_acceleration": "m/s²", "force": "N", "torque": "N·m",
}  # fmt: skip
_NAMES = {
    "roll": "rad", "pitch": "rad", "yaw": "rad", "voltage": "V", "current": "A", "temperature": "°C",
    "latitude": "°", "longitude": "°", "altitude": "m",
}  # fmt: skip


def unit_of(field: str) -> str:
    """Return the unit of a field, from its path in the message; empty if unknown."""
    rest, _, name = field.rpartition(".")
    return _AXES.get(rest.rpartition(".")[2], "") if name in ("x", "y", "z") else _NAMES.get(name, "")


MAX_COLUMNS = 400  #: numbers stored per message
MAX_VALUES = 1 << 22  #: numbers of all messages in total, above which neighbours are reduced to their extremes
WHOLE, FIRST = 36, 8  #: arrays of up to WHOLE elements, such as covariances, are kept; of longer ones the FIRST
LAST_NS = 1 << 62  #: a later time is invalid
_NUMBERS = {".nan": math.nan, ".inf": math.inf, "-.inf": -math.inf}
_QUATERNION = frozenset("xyzw")
#: Field names of a stamp in ROS 2, ROS 1, Foxglove's JSON and Protocol Buffers.
_SECONDS, _NANOSECONDS = ("sec", "secs", "seconds"), ("nanosec", "nsecs", "nsec", "nanos")


def numbers_in(tree: Tree) -> dict[str, float]:
    """Return the numbers of a message by field path, such as ``pose.position.x`` and ``ranges[0]``.

    A quaternion is followed by ``roll``, ``pitch`` and ``yaw``, in rad, by REP 103; NaN for an invalid rotation.
    """
    return dict(zip(*zip(*_numbers(tree, ""), strict=True), strict=True)) if tree else {}


def _numbers(value: object, path: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _numbers(part, f"{path}.{name}" if path else str(name))
        if value.keys() == _QUATERNION:
            yield from zip((f"{path}.{name}" for name in ("roll", "pitch", "yaw")), _angles(value), strict=True)
    elif isinstance(value, list):
        for n, part in enumerate(value if len(value) <= WHOLE else value[:FIRST]):
            yield from _numbers(part, f"{path}[{n}]")
    elif isinstance(value, bool | int | float):
        yield path, float(value)
    elif isinstance(value, str) and value in _NUMBERS:
        yield path, _NUMBERS[value]


def _angles(quaternion: dict[str, Any]) -> tuple[float, float, float]:
    x, y, z, w = (float(value) if isinstance(value, int | float) else math.nan for value in map(quaternion.get, "xyzw"))
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not 0.5 < length < 2.0:  # also for NaN
        return math.nan, math.nan, math.nan
    return to_euler(x / length, y / length, z / length, w / length)


def stated_ns(tree: Tree) -> int:
    """Return the stamp stated by a message, ns; 0 for none."""
    header = tree.get("header")
    stamp = header.get("stamp") if isinstance(header, dict) else tree.get("stamp", tree.get("timestamp"))
    if not isinstance(stamp, dict):
        return 0
    seconds = next((stamp[name] for name in _SECONDS if name in stamp), None)
    rest = next((stamp[name] for name in _NANOSECONDS if name in stamp), None)
    return seconds * 1_000_000_000 + rest if isinstance(seconds, int) and isinstance(rest, int) else 0


@dataclass(frozen=True, slots=True)
class TopicFields:
    """The paths of the numbers in the first message of a topic; ``why`` is a sentence if there are none, else empty.

    ``frames`` are the coordinate frames named in the message.
    """

    topic: str
    type: str
    fields: tuple[str, ...]
    why: str = ""
    frames: tuple[str, ...] = ()


def fields_of(
    path: Path,
    topics: Iterable[tuple[str, str]],
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> list[TopicFields]:
    """Return fields and frames of each of ``topics``, given by name and type, from its first message, in one pass.

    Raises the errors of reading the recording.
    """
    all_topics = list(topics)
    names_of_all = {topic for topic, _ in all_topics}
    stated = stated_in(path, names_of_all, limits)
    firsts = first_messages(path, names_of_all, limits, progress)
    fields = []
    for topic, kind in all_topics:
        frames: tuple[str, ...] = ()
        try:
            first = firsts.get(topic)
            if first is None:
                raise no_messages(topic)
            first = unpacked(first, limits)
            definition = stated.get(topic)
            if definition is None or definition.message_encoding in ENCODINGS:
                frames = frames_of_type(first.type, first.data, cdr=first.cdr)
            tree = decoder_of(topic, definition)(first.data)
            names = tuple(numbers_in(tree))[:MAX_COLUMNS]
            why = "" if names else "Its messages have no numbers."
            fields.append(TopicFields(topic, kind, names, why, frames_in(tree)))
        except MapperError as error:
            fields.append(TopicFields(topic, kind, (), error.message, frames))
    return fields


class _Rows(MessageSink):
    """Collects the messages of one topic as rows of numbers."""

    as_recorded = True

    def __init__(self, topic: str, kind: str, decode: Decoder, limits: Limits) -> None:
        self.notes = []
        self.stamps = array("q")
        self.columns: dict[str, array[float]] = {}
        self.recorded = False  #: whether a message had no stamp of its own
        self.bad = 0
        self._topic, self._kind, self._decode, self._limits = topic, kind, decode, limits
        self._wanted: set[int] = set()
        self._known: set[int] = set()

    @property
    def taken(self) -> int:
        return len(self.stamps)

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:  # noqa: ARG002
        self._known.add(key)
        if readable and printable(topic) == self._topic and plain_type(kind) == self._kind:
            self._wanted.add(key)

    def wants(self, key: int) -> bool:
        return key in self._wanted

    def knows(self, key: int) -> bool:
        return key in self._known

    def pass_over(self, key: int, count: int) -> None:
        """Count nothing."""

    def next_file(self) -> None:
        self._wanted.clear()
        self._known.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        if key not in self._wanted:
            return
        try:
            if data[:4] == ZSTD_MAGIC:
                data, _ = inflate("zstd", data, self._limits.max_chunk_bytes, "a message")
            tree = self._decode(data)
        except ReadError:
            self.bad += 1
            return
        stated = stated_ns(tree)
        is_stated = 0 < stated < LAST_NS
        at = stated if is_stated else stamp_ns
        if not 0 <= at < LAST_NS:
            return
        self.recorded |= not is_stated
        row = numbers_in(tree)
        for name in row:
            if name not in self.columns and len(self.columns) < MAX_COLUMNS:
                self.columns[name] = array("d", [math.nan]) * len(self.stamps)
        for name, values in self.columns.items():
            values.append(row.get(name, math.nan))
        self.stamps.append(at)
        if len(self.stamps) * len(self.columns) > MAX_VALUES:
            self._join()

    def series(self) -> Series:
        """Return the rows so far, in time order."""
        stamps = np.array(self.stamps, dtype=np.int64)
        values = np.stack([np.array(column) for column in self.columns.values()], axis=-1)
        order = np.argsort(stamps, kind="stable")
        columns = tuple(Column(name, unit_of(name), "") for name in self.columns)
        return Series(self._topic, self._kind, columns, stamps[order], values[order], recorded=self.recorded)

    def _join(self) -> None:
        whole = self.series()
        stamps, values = min_max(whole.stamps_ns, whole.values, len(self.stamps) // 4)
        self.stamps = array("q", stamps.tobytes())
        self.columns = {name: array("d", values[:, n].tobytes()) for n, name in enumerate(self.columns)}


def field_series(
    path: Path, topic: str, message_type: str, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Series:
    """Return all numbers of a topic's messages of a type over time, float64, at their stated stamps.

    A message without a stamp has its recording time. The recording is read once. If there are more than
    :data:`MAX_VALUES`, rows are the extremes of intervals, as in :func:`min_max`. Raises the :class:`ReadError` and
    :class:`LimitError` of reading and decoding.
    """
    files, kind = parts_of(path, limits)
    if not isinstance(kind, Container):
        raise ReadError("contents.no_fields", "Only recordings (MCAP, bag, db3) have messages with fields.")
    stated = stated_in(path, (topic,), limits).get(topic)
    decode = decoder_of(topic, stated)
    rows = _Rows(topic, plain_type(stated.type if stated else ""), decode, limits)
    for done, file in enumerate(files):
        kind.take(file, rows, limits, part_of(progress, done, len(files)))
        rows.next_file()
    if not rows.stamps or not rows.columns:
        raise ReadError("contents.no_numbers", f"The messages on {topic!r:.200} have no numbers that could be read.")
    return replace(rows.series(), type=message_type)


MAX_FRAMES = 50  #: names of one message
MAX_NAME = 200  #: characters of a name
_FRAME_FIELDS = frozenset(("frame_id", "child_frame_id", "parent_frame_id"))  #: the last of Foxglove

#: Types that start with a Header, for recordings without definitions.
HEADED = frozenset(
    f"{package}/{name}"
    for package, names in {
        "sensor_msgs": "BatteryState CameraInfo CompressedImage FluidPressure Illuminance Image Imu JointState Joy "
        "LaserScan MagneticField MultiDOFJointState MultiEchoLaserScan NavSatFix PointCloud PointCloud2 Range "
        "RelativeHumidity Temperature TimeReference",
        "nav_msgs": "GridCells OccupancyGrid Odometry Path",
        "geometry_msgs": "AccelStamped AccelWithCovarianceStamped InertiaStamped PointStamped PolygonStamped PoseArray "
        "PoseStamped PoseWithCovarianceStamped QuaternionStamped TransformStamped TwistStamped "
        "TwistWithCovarianceStamped Vector3Stamped WrenchStamped",
        "visualization_msgs": "ImageMarker Marker",
    }.items()
    for name in names.split()
)
#: Those followed by the name of a child frame.
_WITH_CHILD = frozenset(("nav_msgs/Odometry", "geometry_msgs/TransformStamped"))


def frames_in(tree: Tree) -> tuple[str, ...]:
    """Return the frames named in a message's fields :data:`_FRAME_FIELDS`, at any depth."""
    return _named(_values(tree))


def frames_of_type(kind: str, data: bytes, *, cdr: bool) -> tuple[str, ...]:
    """Return the frames at the start of a message of a type in :data:`HEADED`; none for other types."""
    if kind not in HEADED:
        return ()
    fields = MessageFields(data, cdr=cdr)
    try:
        _, frame = fields.header()
        return _named(iter((frame, fields.frame() if kind in _WITH_CHILD else "")))
    except BadMessageError:
        return ()


def _named(names: Iterator[str]) -> tuple[str, ...]:
    named: dict[str, None] = {}  # used as an ordered set
    for name in names:
        if len(named) == MAX_FRAMES:
            break
        if frame := printable(name[:MAX_NAME]).lstrip("/"):
            named[frame] = None
    return tuple(named)


def _values(value: object) -> Iterator[str]:
    if isinstance(value, dict):
        for name, part in value.items():
            if name in _FRAME_FIELDS and isinstance(part, str):
                yield part
            else:
                yield from _values(part)
    elif isinstance(value, list):
        for part in value:
            yield from _values(part)
