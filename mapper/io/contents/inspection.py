"""One pass over a recording that counts all messages, and collects times of transforms, numbers and log lines."""

from __future__ import annotations

import os
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.carmen_lines import inspect_carmen
from mapper.io.contents.downsampling import min_max
from mapper.io.contents.log_lines import LOGGED, LineReader
from mapper.io.contents.model import CameraContents, Contents, FrameEdge, Series, TopicContents
from mapper.io.contents.series_messages import ODOMETRY, PLOTTED, PlottedType, from_poses, pose_speeds, states_speeds
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress, part_of
from mapper.io.logs.containers.container import Container
from mapper.io.logs.names import printable
from mapper.io.logs.opening import open_robot_log, parts_of
from mapper.io.logs.recording.cutting import CAMERA
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.tf_topics import is_static
from mapper.io.logs.recording.transforms import why_ignored
from mapper.io.logs.ros.cloud_messages import camera_info
from mapper.io.logs.ros.message_fields import BadMessageError, Pose7
from mapper.io.logs.ros.ros_messages import TRANSFORMS, plain_type
from mapper.io.logs.selection import ALL_SENSORS, Selection
from mapper.io.logs.text import carmen
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.streams import CloudStream, ImuStream

MAX_NAME = 200  #: stored characters of a topic's, type's or frame's name
MAX_EDGES = 5000  #: pairs of frames
MAX_POSES = 1 << 19  #: poses of all moving transforms in total; above, every second one of the longest is dropped
MAX_PUBLISHERS = 8  #: nodes listed for one transform
MAX_VALUES = 1 << 26  #: 4-byte numbers of all series in total, while the recording is read
KEPT_ROWS = 1 << 18  #: stored rows of one series; a longer one is reduced to the extremes of this number of buckets
LAST_NS = 1 << 62  #: a later time is invalid
_READ = LOGGED | TRANSFORMS.keys() | {CAMERA}  #: types that are read, in addition to those with numbers for plots


@dataclass(slots=True)
class _Topic:
    name: str
    type: str
    cdr: bool
    plotted: PlottedType | None
    readable: bool
    recorded: bool = False  #: whether the stamps are recording times, because messages have none
    messages: int = 0
    bytes: int = 0
    first_ns: int = 0
    last_ns: int = 0
    bad: int = 0
    stamps: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("f"))  #: float64 if speeds are computed from poses

    @property
    def is_read(self) -> bool:
        """Whether the contents of the messages are read."""
        return self.plotted is not None or (self.readable and self.type in _READ)


@dataclass(slots=True)
class _Edge:
    """The transforms between two frames: all their times, and every ``every``-th pose of a moving one."""

    pose: Pose7
    stamps: array[int] = field(default_factory=lambda: array("q"))
    pose_stamps: array[int] = field(default_factory=lambda: array("q"))
    poses: array[float] = field(default_factory=lambda: array("d"))
    every: int = 1
    publishers: set[str] = field(default_factory=set)

    def keep(self, at_ns: int, pose: Pose7) -> None:
        self.pose_stamps.append(at_ns)
        self.poses.extend(pose)

    def thin(self) -> int:
        """Drop every second pose, and return the number dropped."""
        before = len(self.pose_stamps)
        self.pose_stamps = self.pose_stamps[::2]
        self.poses = array("d", np.frombuffer(self.poses).reshape(-1, 7)[::2].tobytes())
        self.every *= 2
        return before - len(self.pose_stamps)

    def named(self, topic: str, parent: str, child: str) -> FrameEdge:
        stamps = np.frombuffer(self.stamps, dtype=np.int64)
        if self.pose_stamps and (len(stamps) - 1) % self.every:
            self.keep(int(stamps[-1]), self.pose)
        times = np.frombuffer(self.pose_stamps, dtype=np.int64)
        order = np.argsort(times, kind="stable")
        return FrameEdge(
            parent,
            child,
            is_static(topic),
            np.sort(stamps),
            topic,
            self.pose,
            times[order],
            np.frombuffer(self.poses).reshape(-1, 7)[order],
            tuple(sorted(self.publishers)),
        )


class Inspector(MessageSink):
    """Processes a recording into its :class:`Contents`, without making a log."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.notes = []
        self._counted: dict[tuple[str, str, bool, bool], _Topic] = {}
        self._counted_by_key: dict[int, _Topic] = {}
        self._edges: dict[tuple[str, str, str], _Edge] = {}
        self._n_poses = 0
        self._publisher_by_key: dict[int, str] = {}
        self._cameras: dict[str, CameraContents] = {}
        self._lines = LineReader()
        self._n_messages = 0
        self._values_left = MAX_VALUES

    @property
    def taken(self) -> int:
        """Number of messages so far."""
        return self._n_messages

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages."""
        name, kind = printable(topic[:MAX_NAME]), printable(plain_type(kind)[:MAX_NAME])
        stream = (name, kind, cdr, readable)
        if stream not in self._counted:
            if len(self._counted) >= self.limits.max_topics:
                raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} topics.")
            topic_of = _Topic(name, kind, cdr, PLOTTED.get(kind) if readable else None, readable)
            if kind == ODOMETRY:
                topic_of.values = array("d")
            self._counted[stream] = topic_of
        self._counted_by_key[key] = self._counted[stream]

    def published_by(self, key: int, node: str) -> None:
        """Store the name of the node that published a stream."""
        self._publisher_by_key[key] = printable(node[:MAX_NAME])

    def next_file(self) -> None:
        """Continue with another file of the same recording."""
        self._counted_by_key.clear()
        self._publisher_by_key.clear()

    def wants(self, key: int) -> bool:
        """Return whether this stream's messages are read; for others their sizes suffice."""
        topic = self._counted_by_key.get(key)
        return topic is not None and topic.is_read

    def knows(self, key: int) -> bool:  # noqa: ARG002 - as all sinks have it
        """Return False for any stream, because skipping chunks by their index would lose the sizes."""
        return False

    def pass_over(self, key: int, count: int) -> None:
        """Do nothing, because no chunk is skipped."""

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Process one message, recorded at ``stamp_ns``. Raises :class:`LimitError`."""
        self._n_messages += 1
        if self._n_messages > self.limits.max_messages:
            raise LimitError("log.too_many_messages", f"The log has more than {self.limits.max_messages} messages.")
        topic = self._counted_by_key.get(key)
        if topic is None:
            return
        topic.messages += 1
        topic.bytes += len(data) if size is None else size
        if 0 < stamp_ns < LAST_NS:
            topic.first_ns = min(topic.first_ns or stamp_ns, stamp_ns)
            topic.last_ns = max(topic.last_ns, stamp_ns)
        if not topic.is_read:
            return
        try:
            if data[:4] == ZSTD_MAGIC:  # rosbag2 can compress each message separately
                data, _ = inflate("zstd", data, self.limits.max_chunk_bytes, "a message")
            if topic.plotted is not None:
                self._take_row(topic, topic.plotted, stamp_ns, data)
            elif topic.type in TRANSFORMS:
                self._take_transforms_of(topic, self._publisher_by_key.get(key, ""), stamp_ns, data)
            elif topic.type == CAMERA:
                self._take_camera(topic, data)
            else:
                self._lines.take(topic.type, topic.name, stamp_ns, data, cdr=topic.cdr)
        except (BadMessageError, ReadError):
            topic.bad += 1

    def _take_row(self, topic: _Topic, plotted: PlottedType, stamp_ns: int, data: bytes) -> None:
        stated, row = plotted.decode(data, cdr=topic.cdr)
        is_stated = 0 < stated < LAST_NS
        at = stated if is_stated else stamp_ns
        if not 0 <= at < LAST_NS or self._values_left < len(row):
            return
        self._values_left -= len(row) * topic.values.itemsize // 4
        topic.recorded |= not is_stated
        topic.stamps.append(at)
        topic.values.extend(_float32(value) for value in row)

    def _take_transforms_of(self, topic: _Topic, publisher: str, stamp_ns: int, data: bytes) -> None:
        for transform in TRANSFORMS[topic.type](data, cdr=topic.cdr):
            if why_ignored(transform.frame, transform.child, transform.pose):
                continue
            name = (topic.name, printable(transform.frame[:MAX_NAME]), printable(transform.child[:MAX_NAME]))
            edge = self._edges.get(name)
            if edge is None:
                if len(self._edges) >= MAX_EDGES:
                    raise LimitError("log.too_many_frames", f"The log’s tf tree has more than {MAX_EDGES} edges.")
                edge = self._edges[name] = _Edge(transform.pose)
            edge.pose = transform.pose
            if publisher and len(edge.publishers) < MAX_PUBLISHERS:
                edge.publishers.add(publisher)
            at = transform.stamp_ns if 0 < transform.stamp_ns < LAST_NS else stamp_ns
            at = max(0, min(at, LAST_NS))
            if not is_static(topic.name) and len(edge.stamps) % edge.every == 0:
                edge.keep(at, transform.pose)
                self._n_poses += 1
                if self._n_poses > MAX_POSES:
                    self._n_poses -= max(self._edges.values(), key=lambda other: len(other.pose_stamps)).thin()
            edge.stamps.append(at)

    def _take_camera(self, topic: _Topic, data: bytes) -> None:
        if topic.name not in self._cameras:
            info = camera_info(data, cdr=topic.cdr)
            if info.intrinsics.width * info.intrinsics.height == 0:
                raise BadMessageError("it states no size of the images")
            frame = printable(info.frame[:MAX_NAME])
            self._cameras[topic.name] = CameraContents(topic.name, frame, info.intrinsics, info.lens)

    def contents(self) -> Contents:
        """Return the collected contents."""
        counted: dict[tuple[str, str], TopicContents] = {}
        for topic in self._counted.values():
            known = counted.get((topic.name, topic.type))
            counted[topic.name, topic.type] = _joined(known, topic)
        bad = [f"{topic.bad} of {topic.messages} on {topic.name}" for topic in self._counted.values() if topic.bad]
        notes = [*self.notes, *([f"Messages that could not be read: {', '.join(bad[:6])}."] if bad else [])]
        if self._values_left < MAX_VALUES // 1000:
            notes.append(f"The plots hold the first {MAX_VALUES} numbers of the recording only.")
        return Contents(
            topics=tuple(sorted(counted.values(), key=lambda topic: (topic.name, topic.type))),
            edges=tuple(
                edge.named(*name)
                for name, edge in sorted(self._edges.items(), key=lambda item: (*item[0][1:], item[0][0]))
            ),
            series=tuple(
                _series(topic, topic.plotted) for topic in self._counted.values() if topic.plotted and topic.stamps
            ),
            notes=tuple(notes),
            lines=tuple(self._lines.lines),
            lines_left_out=self._lines.left_out,
            cameras=tuple(self._cameras.values()),
        )


def _joined(known: TopicContents | None, topic: _Topic) -> TopicContents:
    """Return the figures of a topic; several streams of one name and type are merged."""
    if known is None:
        return TopicContents(topic.name, topic.type, topic.messages, topic.bytes, topic.first_ns, topic.last_ns)
    firsts = [first for first in (known.first_ns, topic.first_ns) if first]
    return TopicContents(
        topic.name,
        topic.type,
        known.messages + topic.messages,
        known.bytes + topic.bytes,
        min(firsts, default=0),
        max(known.last_ns, topic.last_ns),
    )


def _float32(value: float) -> float:
    """Limit a number to the range of float32, because array("f") rejects larger ones."""
    return value if abs(value) < 3.0e38 else float("nan")


def _series(topic: _Topic, plotted: PlottedType) -> Series:
    stamps = np.frombuffer(topic.stamps, dtype=np.int64)
    rows: NDArray[Any] = np.frombuffer(topic.values, dtype=topic.values.typecode).reshape(-1, len(plotted.columns))
    columns = plotted.columns
    if (np.diff(stamps) < 0).any():
        order = np.argsort(stamps, kind="stable")
        stamps, rows = stamps[order], rows[order]
    if topic.type == ODOMETRY and not states_speeds(rows):
        rows = np.column_stack([pose_speeds(stamps, rows[:, 3:]), rows[:, 3:]])
        columns = from_poses(columns)
    stamps, values = min_max(stamps, rows.astype(np.float32, copy=False), KEPT_ROWS // 2)
    return Series(topic.name, topic.type, columns, stamps, values, recorded=topic.recorded)


def inspect(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Contents:
    """Return the contents of the recording at ``path``, of any kind that :func:`mapper.io.logs.open_log` reads.

    The topics of CARMEN logs are the words of their lines; other text formats contain only scans, and nothing is
    listed. The whole recording is read. Raises the :class:`ReadError` and :class:`LimitError` of ``open_log``.
    """
    files, kind = parts_of(Path(path), limits)
    if not isinstance(kind, Container):
        return inspect_carmen(files[0], limits, progress) if kind is carmen.read_carmen else Contents(())
    inspector = Inspector(limits)
    for done, file in enumerate(files):
        kind.take(file, inspector, limits, part_of(progress, done, len(files)))
        inspector.next_file()
    return inspector.contents()


def open_inspected(
    path: str | os.PathLike[str],
    *,
    selection: Selection = ALL_SENSORS,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> tuple[RobotLog, Contents]:
    """Return the results of :func:`mapper.io.logs.open_robot_log` and :func:`inspect` from one pass over a recording.

    A text log is read twice. Raises the errors of both.
    """
    inspector = Inspector(limits)
    robot = open_robot_log(path, selection=selection, limits=limits, progress=progress, also=inspector)
    return robot, inspector.contents() if inspector.taken else inspect(path, limits=limits)


@dataclass(frozen=True, slots=True)
class Held:
    """A recording, possibly without scans: the name of its format, its contents, clouds and IMUs.

    ``no_scans`` is the reason why no log can be made from it, if that was tried.
    """

    format: str
    contents: Contents
    clouds: Mapping[str, CloudStream]
    imus: Mapping[str, ImuStream]
    no_scans: str = ""


def open_held(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Held | None:
    """Return the contents of the recording at ``path``, possibly without scans; None for a file that is not a
    recording.

    It is read once. Raises the :class:`ReadError` and :class:`LimitError` of :func:`inspect`.
    """
    files, kind = parts_of(Path(path), limits)
    if not isinstance(kind, Container):
        return None
    inspector = Inspector(limits)
    streams = kind.streams(files, limits, progress, also=inspector)
    return Held(kind.form, inspector.contents(), streams.clouds, streams.imus)
