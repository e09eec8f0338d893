"""The messages of a recording, whatever container they came in, put together to a log.

A container's reader announces each stream of messages (:meth:`Recording.channel`) and hands its messages over
(:meth:`Recording.take`); :meth:`Recording.log` makes the log of one range sensor out of them, with a trajectory from
each source of poses: tf, odometry, a localiser's estimate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.clocks import Clock
from mapper.io.logs.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.names import printable
from mapper.io.logs.packing import notes_on_time
from mapper.io.logs.pose_sources import STAMP_LIMIT_NS, PoseSource, trajectories_at
from mapper.io.logs.ros_messages import POSES, SENSORS, TRANSFORMS, BadMessageError, StampedPose, plain_type
from mapper.io.logs.sensor_scans import SensorScans
from mapper.io.logs.transforms import FrameTree, Timeline
from mapper.sensors.scan import ScanLog, Topic, is_angle_step

Int64Array = NDArray[np.int64]

MAX_FRAME_NAME = 200  #: characters of a frame's name that a log keeps

#: Messages that others make scans of: what one calls them, and the program that does it.
CONVERTERS = {
    "sensor_msgs/PointCloud2": ("A point cloud", "pointcloud_to_laserscan"),
    "sensor_msgs/Image": ("A depth image", "depthimage_to_laserscan"),
}


@dataclass(slots=True)
class _Channel:
    topic: str
    kind: str
    cdr: bool
    take: Callable[[_Channel, int, bytes], None] | None
    count: int = 0
    bad: int = 0
    why: str = ""  #: what is wrong with the first bad one, where it could be decoded


@dataclass(slots=True)
class _PoseTopic:
    """The poses of one topic, ``T_frame_child`` with the frames of its first message."""

    kind: str
    frame: str
    child: str
    timeline: Timeline
    clock: Clock


class Recording:
    """Takes a recording message by message; :meth:`log` packs what it took."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.notes: list[str] = []
        self._channels: dict[int, _Channel] = {}  #: of the file that is read
        self._streams: dict[tuple[str, str, bool, bool], _Channel] = {}  #: of all files: topic, type, cdr, readable
        self._sensors: dict[str, SensorScans] = {}
        self._poses: dict[str, _PoseTopic] = {}
        self._children: set[str] = set()
        self._tf = FrameTree(limits)
        self._tf_clock = Clock()
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
            take = None
            if readable and kind in SENSORS:
                take = self._take_scan
            elif readable and kind in POSES:
                take = self._take_pose
            elif readable and kind in TRANSFORMS:
                take = self._take_transforms
            self._streams[stream] = _Channel(name, kind, cdr, take)
        self._channels[key] = self._streams[stream]

    def next_file(self) -> None:
        """Go on with another file of the same recording, in which streams have keys of their own."""
        self._channels.clear()

    def wants(self, key: int) -> bool:
        """Return whether anything is made of this stream's messages."""
        channel = self._channels.get(key)
        return channel is not None and channel.take is not None

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return key in self._channels

    def pass_over(self, key: int, count: int) -> None:
        """Count messages of a stream of which nothing is made, and which were not read."""
        if key in self._channels:
            self._channels[key].count += count

    def take(self, key: int, stamp_ns: int, data: bytes) -> None:
        """Take one message, recorded at ``stamp_ns``; one of a stream that was not announced is passed over.

        Raises :class:`LimitError`.
        """
        channel = self._channels.get(key)
        if channel is None:
            return
        channel.count += 1
        if channel.take is None:
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
            channel.take(channel, stamp_ns, data)
        except (BadMessageError, ReadError):
            channel.bad += 1

    def _take_scan(self, channel: _Channel, stamp_ns: int, data: bytes) -> None:
        beams = SENSORS[channel.kind](data, cdr=channel.cdr)
        n = len(beams.ranges)
        if not is_angle_step(beams.angle_increment, n):
            channel.why = channel.why or (
                f"message {channel.count} states an angle_increment of {beams.angle_increment:g} rad for its {n} beams"
            )
            raise BadMessageError
        angles = (beams.angle_min, beams.angle_increment, beams.beam_width)
        # Written so that nan fails, too.
        if not (max(map(abs, angles)) < 100.0 and sum(angles) == sum(angles)) or not beams.range_max > 0.0 or n == 0:
            raise BadMessageError
        if n > self.limits.max_beams:
            raise LimitError(
                "log.too_many_beams",
                f"A scan on {channel.topic} has {n} beams; the limit is {self.limits.max_beams}.",
            )
        self._scans += 1
        self._readings += n
        if self._scans > self.limits.max_scans or self._readings > self.limits.max_readings:
            raise LimitError(
                "log.too_many_scans",
                f"The log has more than {self._scans - 1} scans; the limits are {self.limits.max_scans} scans "
                f"(max_scans) and {self.limits.max_readings} readings (max_readings).",
            )
        name = channel.topic
        sensor = self._sensors.get(name)
        frame = printable(beams.frame)
        if sensor is not None and sensor.frame != frame:  # several sonars may share a topic
            name = f"{channel.topic}#{frame[:100]}"
            sensor = self._sensors.get(name)
        if sensor is None:
            if len(self._sensors) >= self.limits.max_topics:
                raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} sensors.")
            sensor = self._sensors[name] = SensorScans(name, channel.kind, frame, beams.beam_width)
        at = _stamp(beams.stamp_ns, stamp_ns)
        sensor.add(at, beams)
        sensor.clock.add(at, _stamp(stamp_ns, 0))

    def _take_pose(self, channel: _Channel, stamp_ns: int, data: bytes) -> None:
        for one in POSES[channel.kind](data, cdr=channel.cdr):
            child = printable(one.child[:MAX_FRAME_NAME])
            if channel.topic not in self._poses:
                frame = printable(one.frame[:MAX_FRAME_NAME])
                self._poses[channel.topic] = _PoseTopic(channel.kind, frame, child, Timeline(self.limits), Clock())
            known = self._poses[channel.topic]
            at = _stamp(one.stamp_ns, stamp_ns)
            known.timeline.add(at, one.pose)
            known.clock.add(at, _stamp(stamp_ns, 0))
            if child and len(self._children) < 100:
                self._children.add(child)

    def _take_transforms(self, channel: _Channel, stamp_ns: int, data: bytes) -> None:
        for one in TRANSFORMS[channel.kind](data, cdr=channel.cdr):
            at = _stamp(one.stamp_ns, stamp_ns)
            self._tf_clock.add(at, _stamp(stamp_ns, 0))
            self._tf.add(StampedPose(at, printable(one.frame), printable(one.child), one.pose))

    # -- the log ------------------------------------------------------------------------------------------------

    def log(self, name: str, form: str, topic: str | None = None) -> ScanLog:
        """Return the log of the sensor on ``topic``; without one, of the laser with most scans, or else the sonar.

        Raises :class:`ReadError` where there are no scans, or none on that topic.
        """
        bad = [
            f"{channel.bad} of {channel.count} on {channel.topic}" + (f" ({channel.why})" if channel.why else "")
            for channel in self._streams.values()
            if channel.bad
        ]
        sensor = self._sensor(topic, bad)
        notes = list(self.notes)
        if bad:
            notes.append(f"Messages that could not be read: {_listed(bad)}.")
        if topic is None:
            notes += self._note_on_others(sensor)
        ranges, more = sensor.packed(self.limits)
        notes += more
        angle_min, increment, range_min, range_max, _ = sensor.usual
        ranges = ranges.copy() if not ranges.flags.writeable else ranges
        ranges[ranges <= 0.0] = np.nan  # REP 117: −inf is too close to measure; many drivers say 0 instead
        if sensor.kind == "sensor_msgs/MultiEchoLaserScan":
            notes.append("Of each beam's echoes the first is taken.")
        stamps = np.frombuffer(sensor.stamps, dtype=np.int64)
        notes += notes_on_time(stamps)
        chain = self._tf.ancestors(sensor.frame)
        base = self._tf.base_of(chain, self._children)
        mount, upside_down, more = self._mount(chain[: base + 1], stamps)
        notes += more
        sources = self._pose_sources(chain[base:], sensor)
        trajectories, more = trajectories_at(stamps, sources, chain[base][:MAX_FRAME_NAME], self.limits)
        notes += more
        return ScanLog(
            ranges=ranges,
            angle_min=angle_min,
            angle_increment=increment,
            range_min=max(0.0, range_min) if range_min < range_max else 0.0,
            range_max=range_max,
            stamps_ns=stamps,
            trajectories=trajectories,
            mount=mount,
            upside_down=upside_down,
            bearings=np.zeros(1) if sensor.beam_width > 0.0 else None,
            beam_width=min(sensor.beam_width, np.pi / 2.0),
            frame_id=sensor.frame[:MAX_FRAME_NAME],
            time_increment=sensor.time_increment,
            scan_time=sensor.scan_time,
            name=name,
            format=f"{form}, {sensor.topic}",
            topics=self._topics(sensor),
            notes=tuple(notes),
            limits=self.limits,
        )

    def _sensor(self, topic: str | None, bad: list[str]) -> SensorScans:
        if not self._sensors:
            held = "it holds no messages"
            if bad:
                held = f"messages that could not be read: {_listed(bad)}"
            elif self._streams:
                held = f"it has {_listed(sorted({channel.kind for channel in self._streams.values()}))}"
            damage = "".join(f"; {note[:1].lower()}{note[1:].rstrip('.')}" for note in self.notes[:1])
            raise ReadError(
                "log.no_scans",
                "The log holds no scans that can be read (sensor_msgs LaserScan, MultiEchoLaserScan or Range): "
                f"{held}{damage}.{_advice(channel.kind for channel in self._streams.values())}",
            )
        if topic is None:
            return max(self._sensors.values(), key=lambda sensor: (sensor.kind != "sensor_msgs/Range", sensor.n_scans))
        for sensor in self._sensors.values():
            if sensor.topic.lstrip("/") == topic.lstrip("/"):
                return sensor
        raise ReadError("log.topic", f"The log has no scans on {topic!r:.80}; it has {_listed(list(self._sensors))}.")

    def _note_on_others(self, chosen: SensorScans) -> list[str]:
        """Return a note on the sensors that the log is not made of, if there are any."""
        others = [sensor.topic for sensor in self._sensors.values() if sensor is not chosen]
        if not others:
            return []
        more = f"{len(others)} more sensors" if len(others) > 1 else "another sensor"
        apart = " Each sonar makes a map of its own." if chosen.kind == "sensor_msgs/Range" else ""
        return [f"Only {chosen.topic} is mapped; the log has {more} to choose: {_listed(others)}.{apart}"]

    def _mount(self, chain: list[str], stamps: Int64Array) -> tuple[tuple[float, float, float], bool, list[str]]:
        """Return ``T_base_laser`` of a chain of frames from the sensor's up to the base's, at its first stamp."""
        notes = []
        if len(chain) == 1 and self._tf.frames:
            notes.append(
                f"tf does not say where the frame {chain[0]!r} sits on the robot; "
                "the sensor is taken to be at its centre."
            )
        poses = self._tf.lookup(chain, stamps)
        x, y, yaw = (float(v) for v in poses.planar[0])
        if (np.abs(poses.positions - poses.positions[0]).max() > 0.01) or (np.abs(poses.up - poses.up[0]) > 0.01).any():
            notes.append(f"The frame {chain[0]!r} moves on the robot; the place where it was first is taken.")
        up = float(poses.up[0])
        if abs(up) < 0.9:
            notes.append(
                f"The sensor is tilted by {np.degrees(np.arccos(abs(up))):.0f}°; the map takes it to be level."
            )
        return (x, y, yaw), up < 0.0, notes

    def _pose_sources(self, chain: list[str], sensor: SensorScans) -> Iterator[PoseSource]:
        """Yield each world that the base, ``chain[0]``, moves in, then each topic of poses, odometry first."""
        base = chain[0][:MAX_FRAME_NAME]
        for world in self._tf.worlds(chain):
            path = chain[: chain.index(world) + 1]
            sentence = f"tf from {world} to {chain[0]}, at the time of each scan"
            yield PoseSource(
                name=f"tf/{world}",
                frame_id=world[:MAX_FRAME_NAME],
                child_frame_id=base,
                sentence=sentence,
                at=partial(self._tf.lookup, path),
                covers=partial(self._tf.covers, path),
                ahead_ns=self._tf_clock.ahead_of(sensor.clock),
            )
        if base == sensor.frame[:MAX_FRAME_NAME] and base not in self._children:
            # tf does not name the base: an odometry message may.
            base = min(self._children, default="base_link")
        for topic in sorted(self._poses, key=lambda topic: self._poses[topic].kind != "nav_msgs/Odometry"):
            known = self._poses[topic]
            if not len(known.timeline):
                continue
            sentence = f"the {known.kind.split('/')[-1]} messages on {topic}, at the time of each scan"
            yield PoseSource(
                name=topic.lstrip("/"),
                frame_id=known.frame or ("odom" if known.kind == "nav_msgs/Odometry" else "map"),
                child_frame_id=known.child or base,
                sentence=sentence,
                at=known.timeline.at,
                covers=known.timeline.covers,
                ahead_ns=known.clock.ahead_of(sensor.clock),
            )

    def _topics(self, chosen: SensorScans) -> tuple[Topic, ...]:
        sensors = [self._described(sensor, sensor is chosen) for sensor in self._sensors.values()]
        counts: dict[tuple[str, str], int] = {}
        for channel in self._streams.values():
            if channel.topic not in self._sensors:
                key = (channel.topic, channel.kind)
                counts[key] = counts.get(key, 0) + channel.count
        rest = [Topic(name, kind, count) for (name, kind), count in sorted(counts.items())]
        return (*sorted(sensors, key=lambda one: -one.count), *rest)

    def _described(self, sensor: SensorScans, chosen: bool) -> Topic:
        _, increment, _, _, n = sensor.usual
        stamps = np.sort(np.frombuffer(sensor.stamps, dtype=np.int64))
        step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
        chain = self._tf.ancestors(sensor.frame)
        base = self._tf.base_of(chain, self._children)
        mount = None
        if base > 0:
            x, y, yaw = (float(v) for v in self._tf.lookup(chain[: base + 1], stamps[:1]).planar[0])
            mount = (x, y, yaw)
        width = sensor.beam_width if n == 1 else abs(increment) * (n - 1)
        return Topic(
            sensor.topic,
            sensor.kind,
            sensor.n_scans,
            frame=sensor.frame,
            beams=n,
            field_of_view_deg=float(np.degrees(width)),
            rate_hz=1e9 / step if step > 0.0 else None,
            mount=mount,
            chosen=chosen,
        )


def _stamp(stated_ns: int, recorded_ns: int) -> int:
    """Return the time that a message states, or else when it was recorded, or else 0."""
    return next((t for t in (stated_ns, recorded_ns) if t and abs(t) < STAMP_LIMIT_NS), 0)


def _advice(kinds: Iterable[str]) -> str:
    """Return what makes scans of the messages that there are, as a further sentence, or nothing."""
    made = next((CONVERTERS[kind] for kind in kinds if kind in CONVERTERS), None)
    return (
        "" if made is None else f" {made[0]} becomes a LaserScan with the ROS package {made[1]}: record what it says."
    )


def _listed(names: list[str], most: int = 6) -> str:
    """Return the first of ``names`` with commas between them."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(name[:200] for name in names[:most]) + more
