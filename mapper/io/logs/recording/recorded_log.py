"""Log of a robot assembled from a recording's messages: sensors with mounts and poses, and frames.

Each sensor gets one trajectory from each source of poses: tf, odometry, a localiser's estimate.
"""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from dataclasses import replace

import numpy as np

from mapper.core.errors import MapperError, ReadError
from mapper.io.logs.grouping.scan_groups import ScanGroup, scan_groups
from mapper.io.logs.recording.cutting import FLOOR_M, IMAGE
from mapper.io.logs.recording.mounting import Mounting, is_assumed, mounting_of
from mapper.io.logs.recording.pose_sources import StatedPoses, odometry_among, trajectories_at
from mapper.io.logs.recording.robot_poses import RobotPoses
from mapper.io.logs.recording.sensor_scans import SensorScans
from mapper.io.logs.recording.taken import MAX_FRAME_NAME, SONAR, Taken
from mapper.io.logs.recording.tf_topics import in_tf
from mapper.io.logs.recording.transforms import FrameTree
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS
from mapper.io.logs.ros.ros_messages import POSES, TRANSFORMS
from mapper.io.logs.selection import Selection
from mapper.io.logs.text.packing import notes_on_time
from mapper.sensors.joint_log import JointLog, ascending_times, with_notes
from mapper.sensors.planar.cloud import cut_tilted, first_beam
from mapper.sensors.planar.options import PlanarCut, is_cut
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic

#: The sensor mapped by default is the first of these types.
PREFERENCE = ("sensor_msgs/LaserScan", "sensor_msgs/MultiEchoLaserScan", *CLOUD_DECODERS, IMAGE, SONAR)
FLOOR_SHARE = 0.1  #: of a cloud's beams: if more end at low points, there is a note
_RANK = {kind: max(0, number - 1) for number, kind in enumerate(PREFERENCE)}  #: the first two are equivalent lidars


class RecordedLog:
    """The messages read from the recording ``name``, of the format ``form``, as the log of a robot."""

    def __init__(self, taken: Taken, name: str, form: str) -> None:
        self._taken, self._name, self._form = taken, name, form
        self._limits = taken.limits
        self._cut = PlanarCut()
        self._bad = [
            f"{stream.bad} of {stream.count} on {stream.topic}: {stream.refused.sentence}"
            for stream in taken.streams
            if stream.bad
        ]
        #: All sensors, the default one first: the lidar with most scans, or else a cloud's …
        self._sensors = sorted(taken.sensors.values(), key=lambda sensor: (_RANK[sensor.kind], -sensor.n_scans))
        #: The same sensors with their frames looked up in other topics of transforms; a person may select one of them.
        self._in_other_tf = [other for sensor in self._sensors for other in self._looked_up_otherwise(sensor)]
        #: Separately stamped poses, by the topic of transforms and the source.
        self._stated: dict[str, dict[tuple[str, ...], StatedPoses | None]] = {}

    def robot_log(self, selection: Selection) -> RobotLog:
        """Return the log with the selected sensors, the preferred one first.

        If all sensors are selected, those without a usable log are dropped, except the first. Raises :class:`ReadError`
        if there are no scans, or none on a named topic, and :class:`LimitError`.
        """
        self._cut = selection.cut
        chosen = self._chosen(selection)
        log = self._scan_log(chosen[0], () if selection.topics else self._notes_on_others(chosen))
        sensors = {chosen[0].topic: log}
        left_out = []
        for sensor in chosen[1:]:
            try:
                sensors[sensor.topic] = self._scan_log(sensor)
            except MapperError as error:
                if selection.topics is not None:
                    raise
                left_out.append(f"{sensor.topic} is left out: {error.message}")
        if left_out:
            sensors[chosen[0].topic] = with_notes(log, left_out)
        timed = {
            name: trajectory.timed for name, trajectory in log.trajectories.items() if trajectory.timed is not None
        }
        tree = self._taken.tf.tree_of(chosen[0].topic, chosen[0].frame)
        return RobotLog(sensors, timed, tree.transforms())

    def _chosen(self, selection: Selection) -> list[SensorScans]:
        if not self._sensors:
            raise self._without_scans(selection)
        if selection.topics is None:
            return [*self._sensors, *(sensor for sensor in self._in_other_tf if not is_cut(sensor.kind))]
        if not selection.topics:
            return self._sensors if self._sensors[0].kind == SONAR else self._sensors[:1]
        known = {sensor.topic: sensor for sensor in (*self._sensors, *self._in_other_tf)}
        chosen = []
        for topic in selection.topics:
            name = next((name for name in known if name.lstrip("/") == topic.lstrip("/")), None)
            if name is None:
                raise self._without_topic(topic)
            if known[name] not in chosen:
                chosen.append(known[name])
        return chosen

    def _looked_up_otherwise(self, sensor: SensorScans) -> list[SensorScans]:
        """Return a sensor once for each other topic of transforms that may be its own, named in its topic's name.

        Those extracted from clouds are read again for each, because extraction uses the transforms of one topic.
        """
        if self._taken.tf.is_chosen:
            return []
        sensors = []
        for topic in self._taken.tf.choice(sensor.topic, sensor.frame).others:
            sensors.append(copy(sensor))
            sensors[-1].topic = in_tf(sensor.topic, topic)
        return sensors

    def _without_topic(self, topic: str) -> ReadError:
        streams = (stream.topic for stream in self._taken.streams if stream.kind in PREFERENCE and stream.count)
        known = dict.fromkeys([*(sensor.topic for sensor in self._sensors), *streams])
        return ReadError("log.topic", f"The log has no scans on {topic!r:.80}; it has {listed(list(known))}.")

    def _without_scans(self, selection: Selection) -> ReadError:
        streams, notes = self._taken.streams, self._taken.notes
        if selection.topics and any(
            stream.kind in PREFERENCE and stream.count and not selection.wants(stream.topic) for stream in streams
        ):
            return self._without_topic(selection.topics[0])
        content = "it holds no messages"
        if self._bad:
            content = f"messages that could not be read: {listed(self._bad)}"
        elif streams and not any(stream.count for stream in streams):
            topics = listed(sorted({f"{stream.kind} on {stream.topic}" for stream in streams}))
            content = f"its topics have no messages ({topics})"
        elif streams:
            other = " (serialised in a way that is not read)"
            kinds = {
                f"{stream.kind or 'messages without a type'}{'' if stream.readable else other}" for stream in streams
            }
            content = f"it has {listed(sorted(kinds))}"
        damage = "".join(f"; {note[:1].lower()}{note[1:].rstrip('.')}" for note in notes[:1])
        return ReadError(
            "log.no_scans",
            "The log holds no scans that can be read (sensor_msgs LaserScan, MultiEchoLaserScan, Range, PointCloud2, "
            f"or Image with depths): {content}{damage}.",
        )

    def _notes_on_others(self, chosen: list[SensorScans]) -> tuple[str, ...]:
        """Return a note on the sonars that make one map with the chosen one, and one on all other sensors."""
        first = chosen[0]
        mapped = [first.topic]
        notes = []
        if first.kind == SONAR:
            mapped = [sensor.topic for sensor in self._sensors if sensor.kind == SONAR]
        if len(mapped) > 1:
            notes.append(f"{first.topic} is one of {len(mapped)} sonars, which make one map: {listed(mapped)}.")
        others = [sensor.topic for sensor in self._sensors if sensor.topic not in mapped]
        if others:
            more = f"{len(others)} more sensors" if len(others) > 1 else "another sensor"
            notes.append(f"Only {first.topic} is mapped; the log has {more} to choose: {listed(others)}.")
        return tuple(notes)

    def _scan_log(self, sensor: SensorScans, more_notes: Iterable[str] = ()) -> ScanLog:
        notes = list(self._taken.notes)
        if self._bad:
            notes.append(f"Messages that could not be read: {listed(self._bad)}.")
        notes += [
            f"Left out of messages on {stream.topic}: {stream.left_out.sentence}."
            for stream in self._taken.streams
            if stream.left_out.total
        ]
        notes += more_notes
        groups, more = scan_groups(sensor.stated, self._limits)
        notes += more
        notes += sensor.notes_on_angles
        if sensor.kind == "sensor_msgs/MultiEchoLaserScan":
            notes.append("The first echo of each beam is used.")
        stamps = np.frombuffer(sensor.stamps, dtype=np.int64)
        notes += self._notes_on_time(sensor)
        tree = self._taken.tf.tree_of(sensor.topic, sensor.frame)
        base = tree.base_of(sensor.frame, self._taken.children)
        notes += self._note_on_tf(sensor)
        mounting = mounting_of(self._taken, tree, base, sensor)
        notes += mounting.notes
        notes += self._note_on_floor(sensor)
        notes += self._note_on_heights(sensor)
        robot = self._base_that_moves(tree, base)
        choice = self._taken.tf.choice(sensor.topic, sensor.frame)
        others = {topic: self._taken.tf.tree_with(topic, choice.static) for topic in choice.others}
        stated = self._stated.setdefault(choice.moving, {})
        robot_poses = RobotPoses(self._taken, tree, others, robot, sensor, notes, stated)
        sources = robot_poses.sources()
        poses = trajectories_at(
            sensor.moments,
            sources,
            robot[:MAX_FRAME_NAME],
            self._limits,
            self._refused_poses(),
            listed(robot_poses.unused(), 3),
        )
        notes += poses.notes
        whole = ScanLog(
            ranges=np.empty((len(stamps), 0), dtype=np.float32),
            angle_min=0.0,
            angle_increment=0.0,
            range_min=0.0,
            range_max=np.inf,
            stamps_ns=stamps,
            order_ns=ascending_times(stamps, sensor.moments.stamps_ns),
            trajectories=poses.trajectories,
            mount=mounting.mount,
            mounts=mounting.mounts,
            upside_down=mounting.upside_down,
            beam_width=min(sensor.beam_width, np.pi / 2.0),
            topic=sensor.topic,
            frame_id=sensor.frame[:MAX_FRAME_NAME],
            scan_time=sensor.scan_time,
            name=self._name,
            format=f"{self._form}, {sensor.topic}",
            topics=self._topics(sensor),
            notes=tuple(notes),
            odometry=odometry_among(sources, poses.trajectories, sensor.moments),
            mount_assumed=is_assumed(self._taken, tree, base, sensor),
            limits=self._limits,
        )
        if _has_runs(sensor):  # otherwise a time within a scan would belong to poses of several runs
            groups = [replace(group, time_increment=0.0) for group in groups]
        parts = [self._with_beams(whole, group, mounting, sensor.beam_width) for group in groups]
        if not poses.kept.all():
            own = [poses.kept[group.scans] for group in groups]
            parts = [part.take(rows) for part, rows in zip(parts, own, strict=True) if rows.any()]
        return parts[0] if len(parts) == 1 else JointLog.of(parts)

    def _with_beams(self, whole: ScanLog, group: ScanGroup, mounting: Mounting, beam_width: float) -> ScanLog:
        """Return the scans of a group of a log, with their readings."""
        ranges = group.ranges if group.ranges.flags.writeable else group.ranges.copy()
        ranges[ranges <= 0.0] = np.nan  # REP 117: −inf is too close to measure; many drivers use 0 instead
        angle_min, increment, least, time_increment = (
            group.angle_min, group.angle_increment, group.range_min, group.time_increment,
        )  # fmt: skip
        if mounting.tilting is not None:
            bearings = angle_min + increment * np.arange(ranges.shape[1], dtype=np.float64)
            poses = mounting.tilting
            ranges = cut_tilted(
                ranges,
                bearings,
                (least, group.range_max),
                poses.matrices[group.scans],
                poses.positions[group.scans],
                self._cut,
            )
            angle_min, increment = first_beam(self._cut), self._cut.angle_increment
            least = time_increment = 0.0
        own = whole if len(group.scans) == whole.n_scans else whole.take(group.scans)
        return replace(
            own,
            ranges=ranges,
            angle_min=angle_min,
            angle_increment=increment,
            range_min=least,
            range_max=group.range_max,
            time_increment=time_increment,
            bearings=np.zeros(ranges.shape[1]) if beam_width > 0.0 else None,
        )

    def _note_on_floor(self, sensor: SensorScans) -> list[str]:
        share = self._taken.low.get(sensor.topic, 0.0)
        if share < FLOOR_SHARE:
            return []
        lowest = self._cut.min_height
        seen = f"{100.0 * share:.0f} % of the beams end at points less than {FLOOR_M:g} m above the lowest height"
        advice = f"it is mapped as walls: raise min_height, for example to {lowest + FLOOR_M:g} m."
        return [f"{seen} (min_height), {lowest:g} m, and have others behind. Where that is the floor, {advice}"]

    def _note_on_heights(self, sensor: SensorScans) -> list[str]:
        low, high = self._taken.heights.get(sensor.topic, (np.inf, -np.inf))
        cut = self._cut
        if low > high or (low <= cut.max_height and high >= cut.min_height):
            return []
        note = (
            f"No point of the clouds on {sensor.topic} is between {cut.min_height:g} and {cut.max_height:g} m above "
            f"the robot’s base frame, so the map has no walls: they are at {low:.3g} to {high:.3g} m. Set min_height "
            "and max_height to where the walls are, or correct the height of the sensor’s mount."
        )
        return [note]

    def _notes_on_time(self, sensor: SensorScans) -> list[str]:
        notes = notes_on_time(sensor.moments.stamps_ns if sensor.offsets is not None else np.array(sensor.stamps))
        if sensor.offsets is None or not _has_runs(sensor):
            return notes
        stamps = np.array(sensor.stamps)
        begins = np.flatnonzero(np.diff(sensor.offsets)) + 1
        steps = [f"scan {at + 1} ({(int(stamps[at - 1]) - int(stamps[at])) / 1e9:,.1f} s back)" for at in begins[:4]]
        more = f" and {len(begins) - 4} more" if len(begins) > 4 else ""
        note = f"The clock of the recording begins again at {' and '.join(steps)}{more}, as where a simulation is reset"
        return [*notes, f"{note}: as in tf2, each scan has the poses of its own run."]

    def _base_that_moves(self, tree: FrameTree, base: str) -> str:
        """Return ``base``, or the robot's base if tf lacks the sensor's mount, so that nothing moves.

        Recorders that start late miss /tf_static, but the robot's poses are still useful.
        """
        if tree.worlds(base) or tree.is_base(base, self._taken.children):
            return base
        return tree.base_apart(base, self._taken.children) or base

    def _refused_poses(self) -> str:
        """Return which messages with poses could not be read, and why; nothing if all could be."""
        poses = (*POSES, *TRANSFORMS)
        refused = [
            f"{stream.topic}: {why.sentence}"
            for stream in self._taken.streams
            if stream.kind in poses
            for why in (stream.refused, stream.left_out)
            if why.total
        ]
        return listed(refused, 3)

    def _note_on_tf(self, sensor: SensorScans) -> list[str]:
        """Return a note on which topic's transforms are used if there are several candidates."""
        choice = self._taken.tf.choice(sensor.topic, sensor.frame)
        if not choice.others:
            return []
        others = listed(list(choice.others))
        note = f"Frames are looked up in {choice.moving}. The log has other transforms, {others}"
        if sensor in self._in_other_tf or self._taken.tf.is_chosen:
            return [f"{note}."]
        first = in_tf(sensor.topic, choice.others[0])
        where = "under Contents in the list of logs, or name their topic with --tf on the command line"
        return [f"{note}: to look all frames up in one of them, open a sensor such as {first} {where}."]

    def _topics(self, chosen: SensorScans) -> tuple[Topic, ...]:
        listed_sensors = [*self._taken.sensors.values(), *self._in_other_tf]
        sensors = [self._described(sensor, sensor is chosen) for sensor in listed_sensors]
        rest: dict[tuple[str, str], Topic] = {}
        for stream in self._taken.streams:
            if stream.topic not in self._taken.sensors:
                key = (stream.topic, stream.kind)
                known = rest.get(key, Topic(*key, 0))
                rest[key] = replace(known, count=known.count + stream.count)
        # Unselected sensors are listed among the others.
        sensors += [stream for (_, kind), stream in rest.items() if kind in PREFERENCE and stream.count]
        others = [stream for _, stream in sorted(rest.items()) if stream not in sensors]
        return (*sorted(sensors, key=lambda stream: -stream.count), *others)

    def _described(self, sensor: SensorScans, chosen: bool) -> Topic:
        _, increment, _, _, n = sensor.stated.usual
        stamps = np.sort(np.frombuffer(sensor.stamps, dtype=np.int64))
        step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
        tree = self._taken.tf.tree_of(sensor.topic, sensor.frame)
        base = tree.base_of(sensor.frame, self._taken.children)
        mount = None
        poses = None if base == sensor.frame else tree.relative(sensor.frame, base, sensor.moments[:1])
        if poses is not None:
            x, y, yaw = (float(v) for v in poses.planar[0])
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


def _has_runs(sensor: SensorScans) -> bool:
    return sensor.offsets is not None and bool(np.diff(sensor.offsets).any())


def listed(names: list[str], most: int = 6) -> str:
    """Return the first of ``names``, separated by commas."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(name[:400] for name in names[:most]) + more
