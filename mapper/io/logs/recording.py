"""The messages of a recording, whatever container they came in, put together to a log.

A container's reader announces each stream of messages (:meth:`Recording.channel`) and hands its messages over
(:meth:`Recording.take`); :meth:`Recording.robot_log` makes the log of a robot out of them
(:mod:`mapper.io.logs.recorded_log`).
"""

from __future__ import annotations

from collections.abc import Callable

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.clocks import Clock
from mapper.io.logs.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.names import printable
from mapper.io.logs.pose_sources import STAMP_LIMIT_NS
from mapper.io.logs.recorded_log import RecordedLog
from mapper.io.logs.ros_messages import POSES, SENSORS, TRANSFORMS, BadMessageError, StampedPose, plain_type
from mapper.io.logs.selection import Selection
from mapper.io.logs.sensor_scans import SensorScans
from mapper.io.logs.stream import Stream
from mapper.io.logs.taken import MAX_FRAME_NAME, PoseTopic, Taken
from mapper.io.logs.transforms import FrameTree, Timeline
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import is_angle_step

STATIC = "tf_static"  #: last part of the topic of transforms that never change

Take = Callable[[Stream, int, bytes], None]


class Recording:
    """Takes a recording message by message; :meth:`robot_log` makes a log of what it took.

    Of the scans only those of the sensors in ``selection`` are taken.
    """

    def __init__(self, limits: Limits, selection: Selection | None = None) -> None:
        self.limits = limits
        self.selection = selection or Selection()
        self.notes: list[str] = []  #: one sentence each on what was noticed; a container's reader adds its own
        self._taken = Taken(limits, FrameTree(limits), self.notes)
        self._channels: dict[int, tuple[Stream, Take | None]] = {}  #: of the file that is read
        self._streams: dict[tuple[str, str, bool, bool], tuple[Stream, Take | None]] = {}
        self._messages = 0
        self._scans = 0
        self._readings = 0

    @property
    def n_scans(self) -> int:
        """Scans taken so far, of all sensors."""
        return self._scans

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages: ``kind`` is their type, ``cdr`` whether they are serialised as ROS 2 does.

        Messages of a type that no map is made of, or that are not ``readable``, are only counted.
        """
        name, kind = printable(topic[:200]), printable(plain_type(kind)[:200])
        stream = (name, kind, cdr, readable)
        is_known = key in self._channels and stream in self._streams
        if max(len(self._channels), len(self._streams)) >= self.limits.max_topics and not is_known:
            raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} topics.")
        if stream not in self._streams:
            take: Take | None = None
            if readable and kind in SENSORS:
                take = self._take_scan if self.selection.wants(name) else None
            elif readable and kind in POSES:
                take = self._take_pose
            elif readable and kind in TRANSFORMS:
                take = self._take_transforms
            known = Stream(name, kind, cdr)
            self._taken.streams.append(known)
            self._streams[stream] = (known, take)
        self._channels[key] = self._streams[stream]

    def next_file(self) -> None:
        """Go on with another file of the same recording, in which streams have keys of their own."""
        self._channels.clear()

    def wants(self, key: int) -> bool:
        """Return whether anything is made of this stream's messages."""
        _, take = self._channels.get(key, (None, None))
        return take is not None

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return key in self._channels

    def pass_over(self, key: int, count: int) -> None:
        """Count messages of a stream of which nothing is made, and which were not read."""
        if key in self._channels:
            self._channels[key][0].count += count

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Take one message, recorded at ``stamp_ns``; one of a stream that was not announced is passed over.

        Of a stream that is not wanted, ``data`` may be left out and ``size`` say how many bytes there are. Raises
        :class:`LimitError`.
        """
        if key not in self._channels:
            return
        stream, take = self._channels[key]
        stream.note(_stamp(stamp_ns, 0), len(data) if size is None else size)
        if take is None:
            return
        self._messages += 1
        if self._messages > self.limits.max_messages:
            raise LimitError(
                "log.too_many_messages",
                f"The log has more than the limit of {self.limits.max_messages} messages of scans and poses.",
            )
        try:
            if data[:4] == ZSTD_MAGIC:  # rosbag2 can compress each message by itself
                data, _ = inflate("zstd", data, self.limits.max_chunk_bytes, "a message")
            take(stream, stamp_ns, data)
        except (BadMessageError, ReadError):
            stream.bad += 1

    def _take_scan(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        beams = SENSORS[stream.kind](data, cdr=stream.cdr)
        n = len(beams.ranges)
        if not is_angle_step(beams.angle_increment, n):
            stream.why = stream.why or (
                f"message {stream.count} states an angle_increment of {beams.angle_increment:g} rad for its {n} beams"
            )
            raise BadMessageError
        angles = (beams.angle_min, beams.angle_increment, beams.beam_width)
        # Written so that nan fails, too.
        if not (max(map(abs, angles)) < 100.0 and sum(angles) == sum(angles)) or not beams.range_max > 0.0 or n == 0:
            raise BadMessageError
        if n > self.limits.max_beams:
            raise LimitError(
                "log.too_many_beams",
                f"A scan on {stream.topic} has {n} beams; the limit is {self.limits.max_beams}.",
            )
        self._scans += 1
        self._readings += n
        if self._scans > self.limits.max_scans or self._readings > self.limits.max_readings:
            raise LimitError(
                "log.too_many_scans",
                f"The log has more than {self._scans - 1} scans; the limits are {self.limits.max_scans} scans "
                f"(max_scans) and {self.limits.max_readings} readings (max_readings).",
            )
        sensor = self._sensor_of(stream, printable(beams.frame), beams.beam_width)
        at = _stamp(beams.stamp_ns, stamp_ns)
        sensor.add(at, beams)
        sensor.clock.add(at, _stamp(stamp_ns, 0))

    def _sensor_of(self, stream: Stream, frame: str, beam_width: float) -> SensorScans:
        """Return the sensor that a message is of: several may share a topic, by their frames or their types."""
        sensors = self._taken.sensors
        name, *longer = stream.topic, f"{stream.topic}#{frame[:100]}", f"{stream.topic}#{stream.kind}#{frame[:100]}"
        while longer and name in sensors and (sensors[name].kind, sensors[name].frame) != (stream.kind, frame):
            name, *longer = longer
        if name not in sensors:
            if len(sensors) >= self.limits.max_topics:
                raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} sensors.")
            sensors[name] = SensorScans(name, stream, frame, beam_width)
        return sensors[name]

    def _take_pose(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        taken = self._taken
        for one in POSES[stream.kind](data, cdr=stream.cdr):
            child = printable(one.child[:MAX_FRAME_NAME])
            if stream.topic not in taken.poses:
                frame = printable(one.frame[:MAX_FRAME_NAME])
                taken.poses[stream.topic] = PoseTopic(stream.kind, frame, child, Timeline(self.limits), Clock())
            known = taken.poses[stream.topic]
            at = _stamp(one.stamp_ns, stamp_ns)
            known.timeline.add(at, one.pose)
            known.clock.add(at, _stamp(stamp_ns, 0))
            if child and len(taken.children) < 100:
                taken.children.add(child)

    def _take_transforms(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        is_static = stream.topic.rsplit("/", 1)[-1] == STATIC
        for one in TRANSFORMS[stream.kind](data, cdr=stream.cdr):
            at = _stamp(one.stamp_ns, stamp_ns)
            self._taken.tf_clock.add(at, _stamp(stamp_ns, 0))
            pose = StampedPose(at, printable(one.frame), printable(one.child), one.pose)
            self._taken.tf.add(pose, is_static=is_static)

    def robot_log(self, name: str, form: str) -> RobotLog:
        """Return the log of a recording's name and format, as :meth:`RecordedLog.robot_log`."""
        return RecordedLog(self._taken, name, form).robot_log(self.selection)


def _stamp(stated_ns: int, recorded_ns: int) -> int:
    """Return the time that a message states, or else when it was recorded, or else 0."""
    return next((t for t in (stated_ns, recorded_ns) if t and abs(t) < STAMP_LIMIT_NS), 0)
