"""The clouds and IMUs of a recording as streams of its log, and their messages as they are asked for.

The readers of containers push their messages, so one runs on a separate thread, which waits while :data:`AHEAD`
messages have not been consumed.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from queue import Full, Queue
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.names import printable
from mapper.io.logs.recording.corrections import Motion, motion_along
from mapper.io.logs.recording.cutting import CAMERA, IMAGE
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.taken import Taken
from mapper.io.logs.recording.timeline import Moments
from mapper.io.logs.ros.camera_topics import camera_info_topic
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS, DepthImage, NotDepthError, camera_info, depth_image
from mapper.io.logs.ros.compressed_depth import COMPRESSED, compressed_depth_image
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.ros_messages import imu, plain_type
from mapper.sensors.camera import Intrinsics
from mapper.sensors.point_cloud import PointCloud
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.streams import CloudStream, ImuSamples, ImuStream

AHEAD = 2  #: messages read ahead
_LOOK_S = 0.2  #: between two checks whether the messages are still needed

Take = Callable[[Source, MessageSink, Limits, Progress | None], None]


@dataclass(frozen=True, slots=True)
class PulledMessage:
    """A message: its type, whether it is CDR, and its recording time."""

    stamp_ns: int
    type: str
    cdr: bool
    data: bytes


class _UnwantedError(Exception):
    """No more messages are needed."""


class _Pulled(MessageSink):
    """Puts the messages of one topic and type into a queue."""

    def __init__(self, topic: str, kind: str, limits: Limits, put: Callable[[PulledMessage], None]) -> None:
        self.notes = []
        self._taken = 0
        self._topic, self._kind, self._limits, self._put = topic, kind, limits, put
        self._known: dict[int, bool | None] = {}  #: key → whether it is CDR, None for other topics

    @property
    def taken(self) -> int:
        return self._taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        is_wanted = readable and printable(topic[:200]) == self._topic and plain_type(kind) == self._kind
        self._known[key] = cdr if is_wanted else None

    def knows(self, key: int) -> bool:
        return key in self._known

    def wants(self, key: int) -> bool:
        return self._known.get(key) is not None

    def pass_over(self, key: int, count: int) -> None:
        pass

    def next_file(self) -> None:
        self._known.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        cdr = self._known.get(key)
        if cdr is None:
            return
        if data[:4] == ZSTD_MAGIC:  # rosbag2 can compress each message by itself
            try:
                data, _ = inflate("zstd", data, self._limits.max_chunk_bytes, "a message")
            except ReadError:
                return
        self._taken += 1
        self._put(PulledMessage(stamp_ns, self._kind, cdr, data))


def pulled(files: Sequence[Source], take: Take, topic: str, kind: str, limits: Limits) -> Iterator[PulledMessage]:
    """Yield the messages of one topic and type of the recording in ``files``.

    For a cut or damaged file, those that can be read. Raises the errors of reading the recording.
    """
    queue: Queue[PulledMessage | None] = Queue(AHEAD)
    closed = threading.Event()
    errors: list[Exception] = []

    def put(message: PulledMessage | None) -> None:
        while not closed.is_set():
            try:
                return queue.put(message, timeout=_LOOK_S)
            except Full:
                continue
        raise _UnwantedError

    def work() -> None:
        sink = _Pulled(topic, kind, limits, put)
        with contextlib.suppress(_UnwantedError):
            try:
                for file in files:
                    take(file, sink, limits, None)
                    sink.next_file()
            except _UnwantedError:
                raise
            except Exception as error:  # noqa: BLE001 - whatever it is, the thread that asks for messages raises it
                errors.append(error)
            put(None)

    thread = threading.Thread(target=work, name="pulled", daemon=True)
    thread.start()
    try:
        while (message := queue.get()) is not None:
            yield message
    finally:
        closed.set()
        thread.join()
    if errors:
        raise errors[0]


IMU = "sensor_msgs/Imu"
IMU_ROWS = 1 << 12  #: messages per part of an IMU's stream
DEPTH_DECODERS: dict[str, Callable[..., DepthImage]] = {IMAGE: depth_image, COMPRESSED: compressed_depth_image}


@dataclass(frozen=True, slots=True)
class _Recorded:
    """A recording: its files in order, the function that reads one, and what was read from all."""

    files: Sequence[Source]
    take: Take
    taken: Taken
    trajectory: str | None = None  #: the trajectory of the clouds, by its name in the log; None: the default
    _motions: dict[tuple[str, str], Motion] = field(default_factory=dict)  #: computed on first use

    @property
    def limits(self) -> Limits:
        return self.taken.limits

    def clouds(self, topic: str, kind: str) -> Iterator[PointCloud]:
        for message in pulled(self.files, self.take, topic, kind, self.limits):
            try:
                cloud = CLOUD_DECODERS[kind](message.data, cdr=message.cdr)
            except BadMessageError:
                continue
            yield cloud.whole(message.stamp_ns)

    def imu(self, topic: str) -> Iterator[ImuSamples]:
        messages = pulled(self.files, self.take, topic, IMU, self.limits)
        while part := list(islice(messages, IMU_ROWS)):
            readings = []
            for message in part:
                try:
                    reading = imu(message.data, cdr=message.cdr)
                except BadMessageError:
                    continue
                readings.append((reading.frame, reading.stamp_ns or message.stamp_ns, reading))
            if readings:
                yield ImuSamples(
                    readings[0][0],
                    np.array([stamp for _, stamp, _ in readings], dtype=np.int64),
                    np.array([message.angular_velocity for *_, message in readings]),
                    np.array([message.linear_acceleration for *_, message in readings]),
                    np.array([message.orientation for *_, message in readings]),
                )

    def mounts(self, topic: str, frame: str, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64] | None:
        """Return ``T_base_frame`` (n, 4, 4) at n stamps; None if tf does not connect the frame to a base."""
        tree, children = self.taken.tf.tree_of(topic, frame), self.taken.children
        base = tree.base_of(frame, children)
        if base == frame and not tree.is_base(frame, children):
            return None
        poses = tree.relative(frame, base, Moments(stamps_ns))
        if poses is None:
            return None
        out = np.tile(np.eye(4), (len(stamps_ns), 1, 1))
        out[:, :3, :3], out[:, :3, 3] = poses.matrices, poses.positions
        return out

    def poses(self, topic: str, frame: str, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64] | None:
        """Return ``T_fixed_frame`` (n, 4, 4) at n stamps, NaN if unknown; None if nothing states it.

        The fixed frame is tf's ``map`` above the frame, else the farthest frame in which it moves, else that of
        odometry or other pose messages for a frame connected to this one; or that of the ``trajectory``. If the clock
        of the recording restarted, a stamp that belongs to several runs has no pose. Raises :class:`ReadError` if the
        recording lacks the trajectory.
        """
        matrices = np.full((len(stamps_ns), 4, 4), np.nan)
        times_known = np.zeros(len(stamps_ns), dtype=np.int64)
        for offset in self.taken.run_offsets:
            poses = self._poses_at(topic, frame, Moments(stamps_ns + offset))
            if poses is None:
                return None
            known = np.isfinite(poses[:, 0, 0])
            matrices[known] = poses[known]
            times_known += known
        matrices[times_known > 1] = np.nan
        return matrices

    def _poses_at(self, topic: str, frame: str, when: Moments) -> NDArray[np.float64] | None:
        tree = self.taken.tf.tree_of(topic, frame)
        worlds, sources = tree.worlds(frame), dict(self.taken.poses)
        if self.trajectory is not None:
            has = [*(f"tf/{path[-1]}" for path in worlds), *(name.lstrip("/") for name in sources)]
            worlds = [path for path in worlds if f"tf/{path[-1]}" == self.trajectory]
            sources = {name: source for name, source in sources.items() if name.lstrip("/") == self.trajectory}
            if not worlds and not sources:
                raise ReadError(
                    "clouds.trajectory",
                    f"The recording has no trajectory {self.trajectory!r:.80} of {frame!r:.100}; it has "
                    f"{', '.join(map(repr, has)) or 'none'}.",
                )
        if worlds:
            if (topic, frame) not in self._motions:
                self._motions[topic, frame] = motion_along(tree, worlds[0])
            motion = self._motions[topic, frame]
            return _matrices(motion.at(when), motion.covers(when.stamps_ns))
        base = tree.base_of(frame, self.taken.children)
        for known in sources.values():
            mount = tree.relative(frame, known.child or base, when) if len(known.timeline) else None
            if mount is not None:
                return _matrices(known.timeline.at(when.stamps_ns) @ mount, known.timeline.covers(when.stamps_ns))
        return None

    def depths(self, topic: str, kind: str) -> Iterator[PointCloud]:
        """Yield the depth images of a topic and type as organised clouds in the optical frame.

        Raises :class:`ReadError` for a topic without a CameraInfo next to it, for images of a different size, and after
        the last depth image for images of another encoding.
        """
        camera = self._camera(topic)
        other = bad = ""
        n = 0
        for message in pulled(self.files, self.take, topic, kind, self.limits):
            try:
                image = DEPTH_DECODERS[kind](message.data, cdr=message.cdr)
            except NotDepthError as error:
                other = str(error)
                continue
            except BadMessageError as error:
                bad = str(error)
                continue
            n += 1
            depth = image.metres()
            depth[~(depth > 0.0)] = np.nan  # 0 is no reading
            try:
                points = camera.points(depth)
            except ConfigError as error:
                raise ReadError("clouds.camera", f"{topic}: {error.message}.") from error
            yield PointCloud(points, image.stamp_ns or message.stamp_ns, image.frame, (camera.height, camera.width))
        if other:
            raise ReadError("clouds.not_depth", f"Images on {topic} hold no depths: their encoding is {other!r:.40}.")
        if bad and not n:
            raise ReadError("clouds.bad_depth", f"No image on {topic} can be read: {bad:.200}.")

    def _camera(self, topic: str) -> Intrinsics:
        info = camera_info_topic(topic)
        for message in pulled(self.files, self.take, info, CAMERA, self.limits):
            try:
                return camera_info(message.data, cdr=message.cdr).intrinsics
            except BadMessageError:
                continue
        raise ReadError("clouds.no_camera", f"The depth images on {topic} have no CameraInfo on {info}.")


def _matrices(poses: Poses3, known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return poses as matrices (n, 4, 4), NaN where ``known`` (n,) is not set."""
    out = np.tile(np.eye(4), (len(known), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = poses.matrices, poses.positions
    out[~known] = np.nan
    return out


def with_streams(log: RobotLog, files: Sequence[Source], take: Take, taken: Taken) -> RobotLog:
    """Return the log of a recording with its clouds and IMUs, which are read from ``files`` on demand."""
    streams = streams_of(files, take, taken)
    return replace(log, clouds=streams.clouds, imus=streams.imus)


class Streams(NamedTuple):
    """The streams of a recording by topic; ``depths`` are depth images as organised clouds in the optical frame."""

    clouds: dict[str, CloudStream]
    imus: dict[str, ImuStream]
    depths: dict[str, CloudStream]


def streams_of(files: Sequence[Source], take: Take, taken: Taken, trajectory: str | None = None) -> Streams:
    """Return the clouds, IMUs and images of a recording, which are read from ``files`` on demand.

    Clouds are along the ``trajectory``, if one is named.
    """
    recorded = _Recorded(files, take, taken, trajectory)
    counts: dict[tuple[str, str], int] = {}
    for stream in taken.streams:
        if stream.kind in (*CLOUD_DECODERS, IMU, *DEPTH_DECODERS):
            counts[stream.topic, stream.kind] = counts.get((stream.topic, stream.kind), 0) + stream.count
    places = {topic: (partial(recorded.mounts, topic), partial(recorded.poses, topic)) for topic, _ in counts}
    clouds = {
        topic: CloudStream(topic, count, partial(recorded.clouds, topic, kind), *places[topic])
        for (topic, kind), count in counts.items()
        if kind in CLOUD_DECODERS
    }
    depths = {
        topic: CloudStream(topic, count, partial(recorded.depths, topic, kind), *places[topic])
        for message_type in DEPTH_DECODERS  # raw images before compressed ones
        for (topic, kind), count in counts.items()
        if kind == message_type
    }
    imus = {
        topic: ImuStream(topic, count, partial(recorded.imu, topic), places[topic][0])
        for (topic, kind), count in counts.items()
        if kind == IMU
    }
    return Streams(clouds, imus, depths)
