"""Assembly of a recording's messages, from any container, into a log.

A container's reader announces each stream of messages (:meth:`Recording.channel`) and passes on its messages
(:meth:`Recording.take`); :meth:`Recording.robot_log` makes the log of a robot out of them
(:mod:`mapper.io.logs.recording.recorded_log`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.names import printable
from mapper.io.logs.recording.clocks import Clock
from mapper.io.logs.recording.cutting import CAMERA, IMAGE, Cutter
from mapper.io.logs.recording.pose_sources import STAMP_LIMIT_NS
from mapper.io.logs.recording.recorded_log import RecordedLog
from mapper.io.logs.recording.runs import Track, are_parts_of_one, is_in_disorder, is_out_of_order, offsets_of_runs
from mapper.io.logs.recording.sensor_scans import SensorScans
from mapper.io.logs.recording.set_clocks import as_never_set, own_settings
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.stream import Stream
from mapper.io.logs.recording.taken import MAX_FRAME_NAME, SONAR, PoseTopic, Taken
from mapper.io.logs.recording.tf_topics import TfTopics
from mapper.io.logs.recording.timeline import SAME_STAMP, Timeline
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS, NotDepthError
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.ros_messages import PATH, POSES, SENSORS, TRANSFORMS, Beams, StampedPose, plain_type
from mapper.io.logs.selection import Selection
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import are_degrees, is_angle_step

MAX_CHILDREN = 100  #: frames whose poses are stated by messages

MOST_ANGLE = 100.0  #: radians: larger values are not angles

Take = Callable[[Stream, int, bytes], None]


class Recording(MessageSink):
    """Processes a recording message by message; :meth:`robot_log` creates a log from the result.

    Only scans of the sensors in ``selection`` are used.
    """

    def __init__(self, limits: Limits, selection: Selection | None = None) -> None:
        self.limits = limits
        self.selection = selection or Selection()
        self.notes = []
        self._taken = Taken(limits, TfTopics(limits, self.selection.tf), self.notes)
        self._channels: dict[int, tuple[Stream, Take | None]] = {}  #: of the current file
        self._streams: dict[tuple[str, str, bool, bool], tuple[Stream, Take | None]] = {}
        self._cutter = Cutter(self.selection, self._taken.tf, self._taken.children, self._take_beams)
        self._pictures: set[str] = set()  #: topics of images that are not depth images
        self._has_lidar = False
        self._paths: dict[str, tuple[Stream, int, bytes]] = {}  #: the last message of each path topic
        self._position = 0  #: index of the current message
        self._messages = 0
        self._scans = 0
        self._readings = 0

    @property
    def taken(self) -> int:
        """Number of scans so far, of all sensors."""
        return self._scans

    @property
    def parts(self) -> Taken:
        """The messages from which the log is made."""
        return self._taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages: ``kind`` is their type, ``cdr`` whether they use the serialisation of ROS 2.

        Messages of types not used for maps, or that are not ``readable``, are only counted.
        """
        name, kind = printable(topic[:200]), printable(plain_type(kind)[:200])
        stream = (name, kind, cdr, readable)
        is_known = key in self._channels and stream in self._streams
        if max(len(self._channels), len(self._streams)) >= self.limits.max_topics and not is_known:
            raise LimitError("log.too_many_topics", f"The log has more than {self.limits.max_topics} topics.")
        if stream not in self._streams:
            take = self._taker_of(name, kind) if readable else None
            self._has_lidar |= take == self._take_scan and kind != SONAR
            known = Stream(name, kind, cdr, readable)
            self._taken.streams.append(known)
            self._streams[stream] = (known, take)
        self._channels[key] = self._streams[stream]

    def _taker_of(self, topic: str, kind: str) -> Take | None:
        """Return the handler of a stream's messages, None if they are not used."""
        if kind in SENSORS:
            return self._take_scan if self.selection.wants(topic) else None
        if kind == PATH:
            return self._keep_path
        if kind in POSES:
            return self._take_pose
        if kind in TRANSFORMS:
            return self._take_transforms
        if kind in CLOUD_DECODERS:
            return self._cutter.take_cloud if self.selection.wants(topic) else None
        if kind == IMAGE:
            return self._cutter.take_image if self.selection.wants(topic) else None
        return self._cutter.take_camera if kind == CAMERA else None

    def _is_passed_over(self, stream: Stream) -> bool:
        """Return whether a stream is not used for scans: pictures and, unless named, any if there is a lidar."""
        if stream.kind != IMAGE and stream.kind not in CLOUD_DECODERS:
            return False
        return stream.topic in self._pictures or (self._has_lidar and not self.selection.names(stream.topic))

    @property
    def topics_of_file(self) -> set[str]:
        """Topics of the current file."""
        return {stream.topic for stream, _ in self._channels.values()}

    def next_file(self) -> None:
        """Continue with another file of the same recording, with its own stream keys."""
        self._channels.clear()

    def wants(self, key: int) -> bool:
        """Return whether this stream's messages are used."""
        if key not in self._channels:
            return False
        stream, take = self._channels[key]
        return take is not None and not self._is_passed_over(stream)

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return key in self._channels

    def pass_over(self, key: int, count: int) -> None:
        """Count unused messages of a stream, which were not read."""
        if key in self._channels:
            self._channels[key][0].count += count

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002 - as sinks
        """Process one message, recorded at ``stamp_ns``; one of an unannounced stream is skipped.

        For an unused stream, ``data`` may be omitted and ``size`` is its size in bytes. Raises :class:`LimitError`.
        """
        if key not in self._channels:
            return
        stream, take = self._channels[key]
        stream.count += 1
        self._position += 1
        self._cutter.position = self._position
        if take is None or self._is_passed_over(stream):
            return
        self._messages += 1
        if self._messages > self.limits.max_messages:
            raise LimitError(
                "log.too_many_messages",
                f"The log has more than the limit of {self.limits.max_messages} messages of scans and poses.",
            )
        try:
            if data[:4] == ZSTD_MAGIC:  # rosbag2 can compress each message separately
                data, _ = inflate("zstd", data, self.limits.max_chunk_bytes, "a message")
            take(stream, stamp_ns, data)
        except NotDepthError:
            self._pictures.add(stream.topic)
        except BadMessageError as error:
            stream.refuse(str(error))
        except ReadError as error:
            stream.refuse(error.message)

    def _take_scan(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        self._take_beams(stream, stamp_ns, SENSORS[stream.kind](data, cdr=stream.cdr), self._position)

    def _take_beams(self, stream: Stream, stamp_ns: int, beams: Beams, position: int) -> None:
        n = len(beams.ranges)
        in_degrees = are_degrees(beams.angle_min, beams.angle_increment, n)
        if in_degrees:
            angles = np.radians([beams.angle_min, beams.angle_increment, beams.angle_max]).tolist()
            beams = replace(beams, **dict(zip(("angle_min", "angle_increment", "angle_max"), angles, strict=True)))
        why = _what_is_wrong(beams)
        if why:
            raise BadMessageError(why)
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
        sensor.in_degrees += in_degrees
        sensor.positions.append(position)
        sensor.clock.add(at, _stamp(stamp_ns, 0))

    def _sensor_of(self, stream: Stream, frame: str, beam_width: float) -> SensorScans:
        """Return the sensor of a message: several may share a topic, distinguished by frame or type."""
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
        for pose in POSES[stream.kind](data, cdr=stream.cdr):
            self._add_pose(stream, stamp_ns, pose)

    def _add_pose(self, stream: Stream, stamp_ns: int, pose: StampedPose) -> None:
        taken = self._taken
        frame, child = printable(pose.frame[:MAX_FRAME_NAME]), printable(pose.child[:MAX_FRAME_NAME])
        known = self._poses_of(stream, frame, child)
        at = _stamp(pose.stamp_ns, stamp_ns)
        known.timeline.add(at, pose.pose, self._position, _stamp(stamp_ns, 0))
        known.clock.add(at, _stamp(stamp_ns, 0))
        if math.isfinite(pose.speed):
            known.fastest = max(known.fastest, pose.speed)
        if child and len(taken.children) < MAX_CHILDREN:
            taken.children.add(child)

    def _poses_of(self, stream: Stream, frame: str, child: str) -> PoseTopic:
        """Return the poses of a pair of frames on a topic: several bodies may share one."""
        poses = self._taken.poses
        name, *longer = stream.topic, f"{stream.topic}#{child[:100]}", f"{stream.topic}#{frame[:100]}#{child[:100]}"
        while longer and name in poses and (poses[name].frame, poses[name].child) != (frame, child):
            name, *longer = longer
        if name not in poses:
            if len(poses) >= self.limits.max_topics:
                raise LimitError("log.too_many_topics", f"The log has poses of more than {len(poses)} frames.")
            poses[name] = PoseTopic(stream.topic, stream.kind, frame, child, Timeline(self.limits), Clock())
        return poses[name]

    def _keep_path(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        """Keep the last path of a topic, because a growing path contains all earlier poses."""
        self._paths[stream.topic] = (stream, stamp_ns, data)

    def _take_paths(self) -> None:
        """Use the paths that are trajectories, with ascending stamps; all poses of plans have the same stamp."""
        for stream, stamp_ns, data in self._paths.values():
            try:
                poses = POSES[PATH](data, cdr=stream.cdr)
                stamps = [pose.stamp_ns for pose in poses]
                if len(poses) > 1 and stamps[0] > 0 and all(a < b for a, b in pairwise(stamps)):
                    for pose in poses:
                        self._add_pose(stream, stamp_ns, pose)
            except BadMessageError as error:
                stream.refuse(str(error))

    def _take_transforms(self, stream: Stream, stamp_ns: int, data: bytes) -> None:
        for transform in TRANSFORMS[stream.kind](data, cdr=stream.cdr):
            at = _stamp(transform.stamp_ns, stamp_ns)
            self._taken.tf_clock.add(at, _stamp(stamp_ns, 0))
            pose = StampedPose(at, printable(transform.frame), printable(transform.child), transform.pose)
            ignored = self._taken.tf.add(stream.topic, pose, self._position, _stamp(stamp_ns, 0))
            if ignored:
                stream.leave_out(ignored)

    def _count_on(self) -> None:
        """Continue the stamps across restarts of the recording's clock, so that each run has its own times."""
        taken = self._taken
        lines = [*taken.tf.timelines, *((known.topic, known.timeline) for known in taken.poses.values())]
        lines = [(topic, line) for topic, line in lines if len(line)]
        sensors = [sensor for sensor in taken.sensors.values() if sensor.n_scans]
        for sensor in sensors:
            sensor.set_stamps()
        for _, line in lines:
            line.set_stamps()
        self._take_recorded_times(sensors)
        senders: list[tuple[str, Timeline | SensorScans]] = [*lines, *((sensor.topic, sensor) for sensor in sensors)]
        tracks = self._by_clocks_never_set(senders)
        disordered = is_in_disorder(tracks)
        offsets = None if disordered else offsets_of_runs(tracks)
        if offsets is not None and are_parts_of_one(tracks, offsets):
            disordered, offsets = True, None
        if disordered:
            self.notes.append(
                "Messages were not stored in the order in which they were recorded; they were sorted by recording time."
            )
        if offsets is None:
            by_recording = is_out_of_order([*tracks, *taken.tf.static_tracks])
            for sensor in sensors:
                sensor.put_in_order(by_recording=by_recording)
            for _, line in lines:
                line.put_in_order(by_recording=by_recording)
            if by_recording:
                taken.tf.put_statics_in_order()
            return
        taken.run_offsets = tuple(int(offset) for offset in np.unique(np.concatenate(offsets)))
        for (_, line), own in zip(lines, offsets, strict=False):
            line.count_on(own)
        for sensor, own in zip(sensors, offsets[len(lines) :], strict=True):
            sensor.offsets = own

    def _by_clocks_never_set(self, senders: Sequence[tuple[str, Timeline | SensorScans]]) -> list[Track]:
        """Return the tracks of senders, with individual clock steps removed from the stamps."""

        def track_of(topic: str, sender: Timeline | SensorScans) -> Track:
            return sender.track if isinstance(sender, SensorScans) else Track(topic, *sender.track)

        tracks = [track_of(topic, sender) for topic, sender in senders]
        settings = own_settings(tracks)
        for (_, sender), track, own in zip(senders, tracks, settings, strict=True):
            if not own or track.recorded_ns is None:
                continue
            sender.set_to(as_never_set(track.stamps_ns, track.recorded_ns, own))
            steps = ", ".join(f"by {step * 1e-9:+,.1f} s before message {at + 1}" for at, step in own[:3])
            more = f" and {len(own) - 3} more times" if len(own) > 3 else ""
            self.notes.append(
                f"The clock of {track.topic} was set {steps}{more}, while others went on: its stamps count as if it "
                "had not been."
            )
        if any(settings):
            self._take_clocks_anew()
        return [track_of(topic, sender) for topic, sender in senders]

    def _take_clocks_anew(self) -> None:
        """Compare the stamps of poses and transforms with their recording times again."""
        taken = self._taken
        for pose in taken.poses.values():
            stamps, _, recorded = pose.timeline.track
            pose.clock.set_to(stamps, recorded)
        of_tf = [line.track for _, line in taken.tf.timelines]
        if of_tf:
            taken.tf_clock.set_to(*(np.concatenate([track[k] for track in of_tf]) for k in (0, 2)))

    def _take_recorded_times(self, sensors: Iterable[SensorScans]) -> None:
        """Replace the stamps of messages that the stamps do not distinguish by their recording times.

        tf2 keeps one transform per stamp, and refuses a look-up at any other time.
        """
        taken = self._taken
        counted = [(f"{sensor.n_scans} scans on {sensor.topic}", sensor.take_recorded_times()) for sensor in sensors]
        for pose in taken.poses.values():
            counted.append((f"{len(pose.timeline)} poses on {pose.topic}", pose.timeline.take_recorded_times()))
            if counted[-1][1]:
                pose.clock.reset()
        of_tf = [
            (f"{len(line)} transforms between two frames on {topic}", line.take_recorded_times())
            for topic, line in taken.tf.timelines
        ]
        if any(why for _, why in of_tf):
            taken.tf_clock.reset()
        for what, why in (*counted, *of_tf):
            if why:
                who = "All" if why == SAME_STAMP else "The"
                self.notes.append(f"{who} {what} {why}: each gets the time at which it was recorded.")

    def finish(self) -> None:
        """Process the messages held until the end. Raises :class:`ReadError` if the requested tf topic does not
        exist.
        """
        self._taken.tf.check()
        self._cutter.finish()
        self.notes += self._taken.tf.part_senders()
        self._take_paths()
        self._count_on()
        self._taken.unplaced = self._cutter.unplaced
        self._taken.low = {topic: low.share for topic, low in self._cutter.low.items()}
        self._taken.heights = self._cutter.heights

    def robot_log(self, name: str, form: str) -> RobotLog:
        """Return the log of a recording with this name and format, see :meth:`RecordedLog.robot_log`."""
        self.finish()
        return RecordedLog(self._taken, name, form).robot_log(self.selection)


def _what_is_wrong(beams: Beams) -> str:
    """Return why no beam of a message has a direction; nothing if they do. Its range limits are checked later."""
    n = len(beams.ranges)
    if n == 0:
        return "they have no readings"
    for name in ("angle_min", "angle_increment", "beam_width"):
        value = getattr(beams, name)
        if not abs(value) < MOST_ANGLE:  # also NaN
            return f"the {'field_of_view' if name == 'beam_width' else name} is {value:g} rad"
    if not is_angle_step(beams.angle_increment, n):
        return f"the angle_increment is {beams.angle_increment:g} rad for {n} beams"
    return ""


def _stamp(stated_ns: int, recorded_ns: int) -> int:
    """Return the time stated by a message, or else its recording time, or else 0."""
    return next((t for t in (stated_ns, recorded_ns) if t and abs(t) < STAMP_LIMIT_NS), 0)
