"""Sources of poses of the robot that carries a sensor: tf, odometry, estimates of localisers and trackers.

A message states the pose of a frame of the robot that need not be its base, but for example a tracking camera or a body
with markers. tf provides the rest: ``T_odom_base = T_odom_child · T_child_base``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mapper.io.logs.recording.clocks import AHEAD_NS
from mapper.io.logs.recording.corrections import DENSER, Leap, Motion, leaps_of, motion_along, shared_out
from mapper.io.logs.recording.levelling import levelled
from mapper.io.logs.recording.pose_sources import PoseSource, StatedPoses
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.restarts import counted_on, restarts_of, sees_the_same
from mapper.io.logs.recording.sensor_scans import SensorScans
from mapper.io.logs.recording.taken import MAX_FRAME_NAME, ODOMETRY, PoseTopic, Taken
from mapper.io.logs.recording.tf_topics import SECOND, namespaces
from mapper.io.logs.recording.timeline import Moments
from mapper.io.logs.recording.transforms import FrameTree, Path, is_fixed_name
from mapper.io.logs.ros.ros_messages import PATH, WITHOUT_HEADER

#: Types of poses, in descending likelihood of being the robot's own motion.
KINDS = (
    ODOMETRY,
    "geometry_msgs/PoseWithCovarianceStamped",
    "geometry_msgs/PoseStamped",
    "geometry_msgs/TransformStamped",
    PATH,
    *WITHOUT_HEADER,
)
#: Types of messages that state positions or motions but are not a source, with the reason.
NO_SOURCES = {
    "geometry_msgs/PoseArray": "many poses at one time",
    PATH: "poses whose stamps do not ascend",
    "geometry_msgs/PointStamped": "positions without a heading",
    "sensor_msgs/NavSatFix": "positions without a heading",
    "geometry_msgs/Twist": "velocities",
    "geometry_msgs/TwistStamped": "velocities",
}
#: Words in the names of goal topics.
WANTED = frozenset(("goal", "target", "setpoint", "waypoint", "initialpose", "initial", "desired", "reference", "plan"))
LEAST_SPEED = 0.02  #: m/s of a driving robot
MOST_BETWEEN_S = 5.0  #: usual interval of poses that follow a motion


@dataclass(slots=True)
class RobotPoses:
    """The sources of poses of a robot's ``base``, from the transforms of ``tree``, for the scans of ``sensor``.

    ``others`` are the transforms of other topics that may belong to this robot, by topic. ``notes`` are filled by
    :meth:`sources`. ``stated`` keeps the sources' poses with their own stamps.
    """

    taken: Taken
    tree: FrameTree
    others: dict[str, FrameTree]
    base: str
    sensor: SensorScans
    notes: list[str]
    stated: dict[tuple[str, ...], StatedPoses | None]

    def sources(self) -> list[PoseSource]:
        """Return the sources: each fixed frame in which the base moves in tf, then each topic of poses.

        The last ones are those of other topics of tf.
        """
        worlds = self.tree.worlds(self.base, self.taken.children)
        pose_sources = self._by_tf("tf", self.tree, self.base, worlds)
        several = {child: counts for path in worlds for child, counts in self.tree.several_parents(path)}
        for child, counts in several.items():
            if len({parent.removesuffix(SECOND) for parent in counts}) == 1:
                continue  # of two senders, which have a note
            listed = " and ".join(f"{parent!r:.100} ({n} transforms)" for parent, n in list(counts.items())[:4])
            self.notes.append(
                f"tf states {len(counts)} parents of the frame {child!r:.100}, {listed}, where a frame has one: what "
                "follows from each is a trajectory of its own."
            )
        others = {path[-1] for path in worlds}
        pose_sources += [
            source for topic in self._own_topics() if (source := self._by_topic(topic, others)) is not None
        ]
        for topic, tree in self.others.items():
            base = self.base if tree.knows(self.base) else tree.base_apart(self.base, self.taken.children)
            if base is not None:
                pose_sources += self._by_tf(topic.lstrip("/"), tree, base, tree.worlds(base, only_moving=True))
        pose_sources = [self._levelled(source) for source in pose_sources]
        pose_sources = [self._counted_on(source) if source.is_odometry else source for source in pose_sources]
        odometry = [source for source in pose_sources if source.is_odometry]
        return [source if source.is_odometry else self._carried(source, odometry) for source in pose_sources]

    def _levelled(self, source: PoseSource) -> PoseSource:
        """Return a source in a level frame, with a note if it was changed."""
        level = levelled(source)
        if level is None:
            return source
        self.notes.append(
            f"In the frame of {source.name} the robot is tilted by {np.degrees(level[1]):.0f}°, as where a camera that "
            "tracks began tilted: the frame is turned until the robot stands upright in it."
        )
        return level[0]

    def _counted_on(self, source: PoseSource) -> PoseSource:
        """Return odometry continued across restarts at 0, with a note."""
        stated = source.stated()
        restarts = np.zeros(0, dtype=np.int64) if stated is None else restarts_of(stated)
        if stated is None or not len(restarts) or len(self.taken.run_offsets) > 1:
            return source
        for k in restarts.tolist():
            scans = self.sensor.readings_around(int(stated.counted_ns[k - 1]), int(stated.counted_ns[k]))
            if scans is None or not sees_the_same(*scans):
                return source
        first = self._scans_after(stated.counted_ns[restarts].tolist())
        self.notes.append(
            f"The odometry of {source.name} begins again at 0 before scan {first}, as where its driver is restarted: "
            "it is counted on from where it was."
        )
        return counted_on(source, stated, restarts)

    def _scans_after(self, stamps_ns: Sequence[int]) -> str:
        """Return the indices of the first scans after some times, for the first three of them."""
        stamps = self.sensor.moments.stamps_ns
        first = [str(int(np.count_nonzero(stamps < stamp_ns)) + 1) for stamp_ns in stamps_ns[:3]]
        return ", ".join(first) + (f" and {len(stamps_ns) - 3} more times" if len(stamps_ns) > 3 else "")

    def _carried(self, source: PoseSource, odometry: list[PoseSource]) -> PoseSource:
        """Return a source that moves like ``odometry`` between its poses, if that has more of them.

        A localiser publishes a pose after a certain motion, at corners and after rests. If its corrections exceed
        drift, its poses are interpolated in time.
        """
        sparse = source.stated()
        if sparse is None or len(self.taken.run_offsets) > 1:
            return source
        for other in odometry:
            dense = other.stated()
            has_one_clock = abs(other.ahead_ns - source.ahead_ns) < AHEAD_NS
            is_alike = has_one_clock and other.child_frame_id == source.child_frame_id
            if dense is None or not is_alike or not np.ptp(dense.poses, axis=0).any():
                continue
            if len(dense.stamps_ns) <= DENSER * len(sparse.stamps_ns):
                continue
            made = Moments(sparse.counted_ns)
            made = made[other.covers(made.stamps_ns)]
            if len(made) > 1:
                return self._along(source, made, other, Moments(dense.counted_ns))
        return source

    def _along(self, source: PoseSource, made: Moments, odometry: PoseSource, known: Moments) -> PoseSource:
        """Return a source, whose poses were ``made`` at some times, that moves like ``odometry`` in between.

        The odometry is ``known`` at its own times.
        """
        between = source.at(made) @ odometry.at(made).inverse
        are_leaps, leaps = leaps_of(made.stamps_ns, between, odometry.at, known)
        if leaps:
            self.notes.append(self._said_of(source.name, leaps))
        nowhere = np.zeros_like(are_leaps)
        corrections = shared_out(made.stamps_ns, between, odometry.at, known.stamps_ns, nowhere)

        def at(when: Moments) -> Poses3:
            placed = source.at(when)
            step = np.searchsorted(made.stamps_ns, when.stamps_ns, side="right") - 1
            is_leap = np.append(are_leaps, False)[np.clip(step, -1, len(are_leaps))]
            inside = odometry.covers(when.stamps_ns) & ~is_leap
            carried = corrections.at(when.stamps_ns[inside]) @ odometry.at(when[inside])
            placed.positions[inside], placed.rotations[inside] = carried.positions, carried.rotations
            return placed

        def stated() -> StatedPoses:
            first, last = made.stamps_ns[[0, -1]]
            inside = (known.stamps_ns >= first) & (known.stamps_ns <= last)
            stamps = np.union1d(made.stamps_ns, known.stamps_ns[inside])
            return StatedPoses(stamps, stamps, at(Moments(stamps)).planar)

        sentence = f"{source.sentence}, between its poses as {odometry.name} moves"
        return replace(source, at=at, stated=stated, sentence=sentence)

    def _by_tf(self, topic: str, tree: FrameTree, base: str, worlds: list[Path]) -> list[PoseSource]:
        by_name: dict[str, PoseSource] = {}
        for path in worlds:
            world = path[-1]
            name = f"{topic}/{world}"
            if name in by_name:
                name = f"{name} via {path[-2]}"
            motion = motion_along(tree, path)
            if motion.ahead_ns:
                self.notes.append(
                    f"{topic} states where {path[-2]!r:.100} is in {world!r:.100} {motion.ahead_ns / 1e9:.2g} s ahead "
                    "of the odometry recorded with it, as AMCL does by its transform_tolerance: each counts from that "
                    "odometry’s time."
                )
            if motion.leaps:
                self.notes.append(self._said_of(name, motion.leaps))
            by_name[name] = PoseSource(
                name=name,
                frame_id=world[:MAX_FRAME_NAME],
                child_frame_id=base[:MAX_FRAME_NAME],
                sentence=f"{topic} from {world} to {base}, at the time of each scan",
                at=motion.at,
                covers=motion.covers,
                stated=partial(self._stated_by_tf, (topic, *path), tree, path, motion),
                ahead_ns=self.taken.tf_clock.ahead_of(self.sensor.clock),
                is_odometry=world.rsplit("/", 1)[-1].startswith("odom"),
                is_scans_clock_own=self.sensor.clock.is_own,
            )
        return list(by_name.values())

    def _said_of(self, name: str, leaps: Sequence[Leap]) -> str:
        """Return a note on jumps of a robot in poses of some name."""
        by = f"{max(leap.metres for leap in leaps):.2f} m and {np.degrees(max(leap.radians for leap in leaps)):.0f}°"
        scans = f"before scan {self._scans_after([leap.stamp_ns for leap in leaps])}"
        return (
            f"By {name} the robot leaps by up to {by} {scans}, where its odometry goes on, as where somebody sets its "
            "pose or a loop is closed: what it saw before is drawn at another place."
        )

    def _own_topics(self) -> list[str]:
        """Return the topics of poses that may belong to this robot, nearest namespace first.

        A topic belongs to another robot if its namespace has its own sensors or transforms.
        """
        own = namespaces(self.sensor.topic)
        root = own[-2] if len(own) > 1 else ""
        streams = [*self.taken.sensors, *self.taken.tf.moving]
        robots = {namespaces(topic)[-2] for topic in streams if len(namespaces(topic)) > 1} - {root}
        poses = self.taken.poses
        topics = [
            topic
            for topic, known in poses.items()
            if len(known.timeline) and namespaces(known.topic)[-2:][0] not in (robots if root else set())
        ]
        near = {space: rank for rank, space in enumerate(own)}
        return sorted(
            topics,
            key=lambda topic: (KINDS.index(poses[topic].kind), near.get(namespaces(poses[topic].topic)[0], len(near))),
        )

    def _by_topic(self, topic: str, fixed: set[str]) -> PoseSource | None:
        known = self.taken.poses[topic]
        if self._is_no_motion(topic, known):
            return None
        base = self.base[:MAX_FRAME_NAME]
        if base == self.sensor.frame[:MAX_FRAME_NAME] and base not in self.taken.children and not self.tree.knows(base):
            # tf does not name the base, but an odometry message may.
            base = min(self.taken.children, default="base_link")
        frame, child = known.frame, known.child or base
        # Stated the other way round, as some state the transform: the fixed frame in the robot's.
        is_inverted = bool(frame) and is_fixed_name(child) and not is_fixed_name(frame)
        if is_inverted:
            frame, child = child, frame
        if known.kind in WITHOUT_HEADER:
            self.notes.append(
                f"The poses on {known.topic} ({known.kind}) state no time: each has that at which it was recorded."
            )
        if known.fastest > LEAST_SPEED and not known.timeline.moves:
            self.notes.append(
                f"The poses on {known.topic} never change, although its messages state velocities up to "
                f"{known.fastest:.2g} m/s, of which no poses are made here."
            )
        sentence = f"the {known.kind.split('/')[-1]} messages on {known.topic}, at the time of each scan"
        path: Path | None = None
        if child not in (base, self.base):
            path = self.tree.path(self.base, child)
            robots = self.base.rpartition("/")[0], child.rpartition("/")[0]
            if (path is not None and fixed & set(path)) or (path is None and all(robots) and robots[0] != robots[1]):
                self.notes.append(
                    f"The poses on {known.topic} are of {child!r:.100}, which is not fixed to {base!r:.100}: they are "
                    "left out."
                )
                return None
            if path is not None:
                sentence += f", carried from {child} to {base} by tf"
                child = base
            elif self.tree.is_base(self.base, set()):
                self.notes.append(
                    f"tf does not say where {child!r:.100}, of which {known.topic} states the poses, is on the robot: "
                    f"they are taken to be those of {base!r:.100}."
                )
        return PoseSource(
            name=topic.lstrip("/"),
            frame_id=frame or ("odom" if known.kind == ODOMETRY else "map"),
            child_frame_id=child,
            sentence=sentence,
            at=partial(self._at, known, path, is_inverted),
            covers=known.timeline.covers,
            stated=partial(self._stated_by_topic, topic, path, is_inverted),
            ahead_ns=known.clock.ahead_of(self.sensor.clock),
            is_odometry=known.kind == ODOMETRY,
            repeats=KINDS.index(known.kind) > 1,
            is_scans_clock_own=self.sensor.clock.is_own,
        )

    def unused(self) -> list[str]:
        """Return the topics that state positions but are not a source, each with its type and the reason."""
        notes = []
        for stream in self.taken.streams:
            why = None if stream.topic in self.taken.poses else NO_SOURCES.get(stream.kind)
            if stream.kind in KINDS and _is_wanted(stream.topic):
                why = "where the robot is to go"
            if why is not None and stream.count:
                notes.append(f"{stream.topic}: {stream.kind}, {why}")
        return notes

    def _is_no_motion(self, topic: str, known: PoseTopic) -> bool:
        """Return whether poses are goals, or too far apart in time to describe a motion, which is noted."""
        if known.kind == ODOMETRY:
            return False
        if _is_wanted(known.topic):
            return True
        if known.kind == KINDS[1] or len(known.timeline) < 2:
            return False
        between = float(np.median(np.diff(known.timeline.in_order[0].stamps_ns))) * 1e-9
        if between <= MOST_BETWEEN_S:
            return False
        self.notes.append(
            f"The poses on {topic} are usually {between:.0f} s apart, too far to follow a motion: they are left out."
        )
        return True

    def _at(self, known: PoseTopic, path: Path | None, is_inverted: bool, when: Moments) -> Poses3:
        poses = known.timeline.at(when.stamps_ns)
        poses = poses.inverse if is_inverted else poses
        return poses if path is None else poses @ self.tree.lookup(path, when)

    def _stated_by_tf(
        self,
        key: tuple[str, ...],
        tree: FrameTree,
        path: Path,
        motion: Motion,
    ) -> StatedPoses | None:
        """Return the pose of a path's first frame in its last, at all times at which a part of it was stated."""
        if key not in self.stated:
            when, stamps = tree.stated(path)
            known = motion.covers(when.stamps_ns)
            when, stamps = when[known], stamps[known]
            poses = motion.at(when).planar if len(when) else None
            self.stated[key] = None if poses is None else StatedPoses(stamps, when.stamps_ns, poses)
        return self.stated[key]

    def _stated_by_topic(self, topic: str, path: Path | None, is_inverted: bool) -> StatedPoses | None:
        key = ("", topic, *(path or ()))
        if key not in self.stated:
            timeline = self.taken.poses[topic].timeline
            when, poses = timeline.in_order
            poses = poses.inverse if is_inverted else poses
            if path is not None:
                poses = poses @ self.tree.lookup(path, when)
            self.stated[key] = StatedPoses(timeline.as_stated, when.stamps_ns, poses.planar)
        return self.stated[key]


def _is_wanted(topic: str) -> bool:
    """Return whether poses on a topic are goals, by its name."""
    return bool(WANTED & set(re.split(r"[^a-z]+", topic.lower())))
