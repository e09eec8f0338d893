"""The log of a robot made of a recording's messages: its sensors, each with its mount and poses, and its frames.

Each sensor gets a trajectory from each source of poses: tf, odometry, a localiser's estimate.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import MapperError, ReadError
from mapper.io.logs.cloud_messages import CLOUD_DECODERS
from mapper.io.logs.cutting import FLOOR_M, IMAGE
from mapper.io.logs.mounting import Mounting, mounting_of
from mapper.io.logs.packing import notes_on_time
from mapper.io.logs.pose_sources import PoseSource, odometry_among, trajectories_at
from mapper.io.logs.scan_groups import ScanGroup, scan_groups
from mapper.io.logs.selection import Selection
from mapper.io.logs.sensor_scans import SensorScans
from mapper.io.logs.taken import MAX_FRAME_NAME, ODOMETRY, SONAR, Taken
from mapper.sensors.joint_log import JointLog, with_notes
from mapper.sensors.planar.cloud import first_beam
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.planar.tilted import cut_tilted
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic
from mapper.sensors.timed_poses import TimedPoses

Int64Array = NDArray[np.int64]

#: Which sensor is mapped where none is named: the first of these types.
PREFERENCE = ("sensor_msgs/LaserScan", "sensor_msgs/MultiEchoLaserScan", *CLOUD_DECODERS, IMAGE, SONAR)
FLOOR_SHARE = 0.1  #: of a cloud's beams: where more end at low points, a note says so
_RANK = {kind: max(0, number - 1) for number, kind in enumerate(PREFERENCE)}  #: the first two are lidars alike


class RecordedLog:
    """The messages taken from the recording ``name``, of the format ``form``, as the log of a robot."""

    def __init__(self, taken: Taken, name: str, form: str) -> None:
        self._taken, self._name, self._form = taken, name, form
        self._tf, self._limits = taken.tf, taken.limits
        self._cut = PlanarCut()
        self._bad = [
            f"{stream.bad} of {stream.count} on {stream.topic}: {stream.refused.sentence}"
            for stream in taken.streams
            if stream.bad
        ]
        #: All sensors, the one to map where none is named first: the lidar with most scans, or else a cloud's …
        self._sensors = sorted(taken.sensors.values(), key=lambda one: (_RANK[one.kind], -one.n_scans))
        self._timed: dict[tuple[str, ...], TimedPoses | None] = {}  #: poses with stamps of their own, by source

    def robot_log(self, selection: Selection) -> RobotLog:
        """Return the log with the sensors that are selected, the preferred one first.

        Where all sensors are wanted, those of which no log can be made are left out, except the first. Raises
        :class:`ReadError` where there are no scans, or none on a topic that is named, and :class:`LimitError`.
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
        timed = {name: one.timed for name, one in log.trajectories.items() if one.timed is not None}
        return RobotLog(sensors, timed, self._tf.transforms())

    def _chosen(self, selection: Selection) -> list[SensorScans]:
        if not self._sensors:
            raise self._without_scans(selection)
        if selection.topics is None:
            return self._sensors
        if not selection.topics:
            return self._sensors if self._sensors[0].kind == SONAR else self._sensors[:1]
        known = {sensor.topic: sensor for sensor in self._sensors}
        found = []
        for topic in selection.topics:
            name = next((name for name in known if name.lstrip("/") == topic.lstrip("/")), None)
            if name is None:
                raise self._without_topic(topic)
            if known[name] not in found:
                found.append(known[name])
        return found

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
        held = "it holds no messages"
        if self._bad:
            held = f"messages that could not be read: {listed(self._bad)}"
        elif streams:
            other = " (serialised in a way that is not read)"
            kinds = {f"{one.kind or 'messages without a type'}{'' if one.readable else other}" for one in streams}
            held = f"it has {listed(sorted(kinds))}"
        damage = "".join(f"; {note[:1].lower()}{note[1:].rstrip('.')}" for note in notes[:1])
        return ReadError(
            "log.no_scans",
            "The log holds no scans that can be read (sensor_msgs LaserScan, MultiEchoLaserScan, Range, PointCloud2, "
            f"or Image with depths): {held}{damage}.",
        )

    def _notes_on_others(self, chosen: list[SensorScans]) -> tuple[str, ...]:
        """Return a note on the sonars that make one map with the one that is chosen, and one on all other sensors."""
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
        groups, more = scan_groups(sensor, self._limits)
        notes += more
        if sensor.kind == "sensor_msgs/MultiEchoLaserScan":
            notes.append("Of each beam's echoes the first is taken.")
        stamps = np.frombuffer(sensor.stamps, dtype=np.int64)
        notes += notes_on_time(stamps)
        chain = self._tf.ancestors(sensor.frame)
        base = self._tf.base_of(chain, self._taken.children)
        mounting = mounting_of(self._taken, chain[: base + 1], stamps, sensor)
        notes += mounting.notes
        notes += self._note_on_floor(sensor)
        robot = self._chain_of_robot(chain[base:])
        sources = list(self._pose_sources(robot, sensor))
        trajectories, more = trajectories_at(stamps, sources, robot[0][:MAX_FRAME_NAME], self._limits)
        notes += more
        whole = ScanLog(
            ranges=np.empty((len(stamps), 0), dtype=np.float32),
            angle_min=0.0,
            angle_increment=0.0,
            range_min=0.0,
            range_max=np.inf,
            stamps_ns=stamps,
            trajectories=trajectories,
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
            odometry=odometry_among(sources, trajectories, stamps),
            limits=self._limits,
        )
        parts = [self._with_beams(whole, group, mounting, sensor.beam_width) for group in groups]
        return parts[0] if len(parts) == 1 else JointLog.of(parts)

    def _with_beams(self, whole: ScanLog, group: ScanGroup, mounting: Mounting, beam_width: float) -> ScanLog:
        """Return the scans of a group of a log, with their readings."""
        ranges = group.ranges if group.ranges.flags.writeable else group.ranges.copy()
        ranges[ranges <= 0.0] = np.nan  # REP 117: −inf is too close to measure; many drivers say 0 instead
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

    def _chain_of_robot(self, chain: list[str]) -> list[str]:
        """Return ``chain``, or the one of the robot's base where tf lacks the sensor's mount, so that nothing moves.

        Recorders that start late miss /tf_static; the robot's poses are of use all the same.
        """
        if self._tf.worlds(chain) or self._tf.is_base(chain[0], self._taken.children):
            return chain
        base = self._tf.base_apart(chain[0], self._taken.children)
        return chain if base is None else self._tf.ancestors(base)

    def _pose_sources(self, chain: list[str], sensor: SensorScans) -> Iterator[PoseSource]:
        """Yield each world that the base, ``chain[0]``, moves in, then each topic of poses, odometry first."""
        base = chain[0][:MAX_FRAME_NAME]
        taken = self._taken
        for world in self._tf.worlds(chain):
            path = chain[: chain.index(world) + 1]
            yield PoseSource(
                name=f"tf/{world}",
                frame_id=world[:MAX_FRAME_NAME],
                child_frame_id=base,
                sentence=f"tf from {world} to {chain[0]}, at the time of each scan",
                at=partial(self._tf.lookup, path),
                covers=partial(self._tf.covers, path),
                timed=partial(self._timed_of_path, path),
                ahead_ns=taken.tf_clock.ahead_of(sensor.clock),
                is_odometry=world.rsplit("/", 1)[-1].startswith("odom"),
            )
        if base == sensor.frame[:MAX_FRAME_NAME] and base not in taken.children:
            # tf does not name the base: an odometry message may.
            base = min(taken.children, default="base_link")
        for topic in sorted(taken.poses, key=lambda topic: taken.poses[topic].kind != ODOMETRY):
            known = taken.poses[topic]
            if not len(known.timeline):
                continue
            yield PoseSource(
                name=topic.lstrip("/"),
                frame_id=known.frame or ("odom" if known.kind == ODOMETRY else "map"),
                child_frame_id=known.child or base,
                sentence=f"the {known.kind.split('/')[-1]} messages on {topic}, at the time of each scan",
                at=known.timeline.at,
                covers=known.timeline.covers,
                timed=partial(self._timed_of_topic, topic),
                ahead_ns=known.clock.ahead_of(sensor.clock),
                is_odometry=known.kind == ODOMETRY,
            )

    def _timed_of_path(self, path: list[str]) -> TimedPoses | None:
        """Return where the first frame of a path was in the last, at all times at which a part of it was stated."""
        key = tuple(path)
        if key not in self._timed:
            stamps = self._tf.stamps(path)
            stamps = stamps[self._tf.covers(path, stamps)]
            self._timed[key] = self._timed_poses(stamps, self._tf.lookup(path, stamps).planar) if len(stamps) else None
        return self._timed[key]

    def _timed_of_topic(self, topic: str) -> TimedPoses | None:
        key = ("", topic)
        if key not in self._timed:
            timeline = self._taken.poses[topic].timeline
            stamps, poses = timeline.stated
            self._timed[key] = self._timed_poses(stamps, poses.planar)
        return self._timed[key]

    def _timed_poses(self, stamps: Int64Array, poses: NDArray[np.float64]) -> TimedPoses | None:
        """Return poses with stamps; None where they are beyond the limit of coordinates."""
        if np.abs(poses[:, :2]).max() > self._limits.max_pose:
            return None
        return TimedPoses(stamps, poses)

    def _topics(self, chosen: SensorScans) -> tuple[Topic, ...]:
        sensors = [self._described(sensor, sensor is chosen) for sensor in self._taken.sensors.values()]
        rest: dict[tuple[str, str], Topic] = {}
        for stream in self._taken.streams:
            if stream.topic not in self._taken.sensors:
                key = (stream.topic, stream.kind)
                known = rest.get(key, Topic(*key, 0))
                rest[key] = replace(known, count=known.count + stream.count)
        # Sensors whose scans were not asked for are listed among the others.
        sensors += [one for (_, kind), one in rest.items() if kind in PREFERENCE and one.count]
        others = [one for _, one in sorted(rest.items()) if one not in sensors]
        return (*sorted(sensors, key=lambda one: -one.count), *others)

    def _described(self, sensor: SensorScans, chosen: bool) -> Topic:
        _, increment, _, _, n = sensor.usual
        stamps = np.sort(np.frombuffer(sensor.stamps, dtype=np.int64))
        step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
        chain = self._tf.ancestors(sensor.frame)
        base = self._tf.base_of(chain, self._taken.children)
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


def listed(names: list[str], most: int = 6) -> str:
    """Return the first of ``names`` with commas between them."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(name[:400] for name in names[:most]) + more
