"""CARMEN logs: FLASER, RLASER, ROBOTLASER1, ROBOTLASER2, ODOM, TRUEPOS and PARAM lines.

Source: the header written by CARMEN's logger, and its log reader (readlog.c). One message per line, in seconds, metres
and radians::

    FLASER n r1 … rn  x y theta  odom_x odom_y odom_theta  stamp host logger_stamp      (x y theta: the laser's pose)
    ROBOTLASER1 type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode
                n r1 … rn  m q1 … qm  laser_x laser_y laser_theta  x y theta
                tv rv forward_safety side_safety turn_axis  stamp host logger_stamp
    RAWLASER1 type start_angle … m q1 … qm  stamp host logger_stamp                 (as ROBOTLASER1, without poses)
    ODOM x y theta tv rv acceleration  stamp host logger_stamp
    TRUEPOS x y theta odom_x odom_y odom_theta  stamp host logger_stamp
    PARAM name value …

LASER lines are read like FLASER lines, which state neither angles nor range
(:func:`mapper.io.logs.text.carmen_beams.front_laser_beams`). The poses of RAWLASER1 to RAWLASER4 come from the ODOM or
TRUEPOS lines at their times. Readings of 80 m or more are the SICK's "no return" (81.83 m: its 13-bit readings from
8183 on are codes). Other lines are ignored and counted in the notes. Lines of one sensor may state different beams and
maximum ranges; each scan is interpreted by its own line (:func:`mapper.io.logs.grouping.scan_groups.scan_groups`).
"""

from __future__ import annotations

import math
import re
from array import array
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.grouping.scan_groups import ScanGroup, scan_groups
from mapper.io.logs.grouping.stated_scans import Beaming, StatedScans
from mapper.io.logs.selection import Selection
from mapper.io.logs.text import fields
from mapper.io.logs.text.carmen_beams import NO_RETURN, Beams, front_laser_beams, robot_laser_beams
from mapper.io.logs.text.interpolation import poses_at_scans, restarts, without_restarts
from mapper.io.logs.text.lines import TextLines, take_lines
from mapper.io.logs.text.packing import ScanStack, note_on_largest_reading
from mapper.sensors.georeference import FARTHEST_M, NO_OFFSET, Offset, note_on_offset, offset_of
from mapper.sensors.joint_log import JointLog, ascending_times
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic, Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

RAW = ("RAWLASER1", "RAWLASER2", "RAWLASER3", "RAWLASER4")  #: scans without poses
#: The sensor used if there are several.
PREFERENCE = ("ROBOTLASER1", "FLASER", "LASER", "RLASER", "ROBOTLASER2", *RAW)
FRONT = ("ROBOTLASER1", "FLASER", "LASER", "RAWLASER1")
REAR = ("RLASER", "ROBOTLASER2", "RAWLASER2")
WORDS = frozenset({*PREFERENCE, "ODOM", "TRUEPOS", "PARAM", "SYNC", "NEFF", "VERTEX2", "EDGE2"})
PLAIN = ("FLASER", "LASER", "RLASER")  #: lines without angles
_PLAIN_LINES = tuple(f"{word} ".encode() for word in PLAIN)
LASERS, ROBOTS, TRUE = "the laser’s", "the robot’s", "the true"  #: owners of stated poses
_MESSAGE_WORD = re.compile(r"[A-Z][A-Z0-9_]*\Z")
_SAME_M, _SAME_RAD = 1e-3, 1e-3  #: poses closer than this are equal, written with few digits
_NEAR_M = 0.2  #: maximum effect of interpolation between the odometry and a scan's own pose


class _Messages:
    """Poses in separate lines: ODOM or TRUEPOS."""

    def __init__(self) -> None:
        self._poses = array("d")
        self._stamps = array("d")

    def add(self, pose: list[float], stamp: float) -> None:
        self._poses.extend(pose)
        self._stamps.append(stamp)

    def __len__(self) -> int:
        return len(self._stamps)

    @property
    def poses(self) -> NDArray[np.float64]:
        return np.frombuffer(self._poses).reshape(-1, 3)

    @property
    def stamps(self) -> NDArray[np.float64]:
        return np.frombuffer(self._stamps)


class CarmenReader:
    """Processes a log line by line; :meth:`log` packs the result."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.sensors: dict[str, ScanStack] = {}
        self.odometry = _Messages()
        self.truth = _Messages()
        self.parameters: dict[str, float] = {}
        self._not_stated: dict[str, str] = {}  #: parameters with an implausible value → a note
        self.ignored: Counter[str] = Counter()
        self._offset = NO_OFFSET  #: of georeferenced poses
        self._is_far: dict[str, bool] = {}  #: owner of the poses → whether they are far from the origin
        self._take: dict[str, Callable[[list[str], int], None]] = {
            **dict.fromkeys(PLAIN, self._take_laser),
            "ROBOTLASER1": self._take_robot_laser,
            "ROBOTLASER2": self._take_robot_laser,
            **dict.fromkeys(RAW, self._take_robot_laser),
            "ODOM": self._take_odometry,
            "TRUEPOS": self._take_truth,
            "PARAM": self._take_parameter,
        }

    @property
    def n_scans(self) -> int:
        """Number of scans so far, of all sensors."""
        return sum(sensor.n_scans for sensor in self.sensors.values())

    def take(self, line: int, text: bytes) -> None:
        """Process one line. Raises :class:`ReadError` or :class:`LimitError` naming it."""
        if text.startswith(_PLAIN_LINES) and self._take_plain_laser(text, line):
            return
        tokens = text.decode("latin-1").split()
        if not tokens or tokens[0].startswith("#"):
            return
        take = self._take.get(tokens[0])
        if take is not None:
            take(tokens, line)
        elif _MESSAGE_WORD.match(tokens[0]) and len(tokens[0]) <= 40:
            self.ignored[tokens[0] if tokens[0] in self.ignored or len(self.ignored) < 20 else "other words"] += 1
        else:
            raise ReadError(
                "log.garbage", f"Line {line} is not a CARMEN message: it starts with {text[:30].decode('latin-1')!r}."
            )

    def _stack(self, word: str) -> ScanStack:
        if word not in self.sensors:
            self.sensors[word] = ScanStack(word, self.limits, vary=True)
        return self.sensors[word]

    def _pose(self, tokens: list[str], line: int, word: str, whose: str) -> list[float]:
        """Return the pose of a line, minus the log's offset if poses of this kind are georeferenced.

        All lines have one offset, so that poses of several kinds stay together.
        """
        is_far = self._is_far.get(whose)
        pose = fields.pose(tokens, line, word, whose, self.limits, None if is_far is False else FARTHEST_M)
        if is_far is None:
            offset = offset_of(np.array([pose]))
            is_far = self._is_far[whose] = offset != NO_OFFSET
            self._offset = self._offset if self._offset != NO_OFFSET else offset
        if not is_far:
            return pose
        near = [pose[0] - self._offset[0], pose[1] - self._offset[1], pose[2]]
        if max(abs(near[0]), abs(near[1])) > self.limits.max_pose:
            raise ReadError(
                "log.pose",
                f"Line {line}: {whose} pose in this {word} line, {pose[0]:g}, {pose[1]:g}, {pose[2]:g}, is impossible: "
                f"it is more than {self.limits.max_pose:g} m from the first.",
            )
        return near

    @property
    def _messages_before(self) -> tuple[int, int]:
        return (len(self.odometry), len(self.truth))

    def _take_plain_laser(self, text: bytes, line: int) -> bool:
        """Process a complete laser line as written by CARMEN, faster; return False, without effect, for any other
        line.
        """
        head, *tail = text.rsplit(b" ", 9)
        word, stated, readings = [*head.split(b" ", 2), b"", b""][:3]
        rest = b" ".join(tail).decode("latin-1").split()
        values = (
            fields.listed(readings) if len(rest) == len(tail) == 9 and len(stated) < 9 and stated.isdigit() else None
        )
        if not values or len(values) != int(stated) or len(values) > self.limits.max_beams:
            return False
        self._add_laser(word.decode(), values, rest, line)
        return True

    def _add_laser(self, word: str, readings: list[float], rest: list[str], line: int) -> None:
        """Add a scan; ``rest`` is what follows its readings: poses and stamp."""
        laser = self._pose(rest[0:3], line, word, LASERS)
        robot = self._pose(rest[3:6], line, word, ROBOTS)
        stamp = fields.stamp(rest[6], line, word)
        self._stack(word).add(line, readings, (laser, robot), stamp, self._messages_before)

    def _take_laser(self, tokens: list[str], line: int) -> None:
        word = tokens[0]
        if len(tokens) < 2:
            raise ReadError("log.truncated_line", f"Line {line}: this {word} line ends after its first word.")
        n = fields.count(tokens[1], line, word, "beams", self.limits.max_beams)
        fields.require_fields(tokens, (n + 9, n + 11), line, word, f"{n} beams")
        readings = fields.numbers(tokens[2 : n + 2], line, word)
        self._add_laser(word, readings, tokens[n + 2 : n + 9], line)

    def _take_robot_laser(self, tokens: list[str], line: int) -> None:
        word = tokens[0]
        if len(tokens) < 9:
            raise ReadError("log.truncated_line", f"Line {line}: this {word} line ends before its number of beams.")
        n = fields.count(tokens[8], line, word, "beams", self.limits.max_beams)
        # After the remissions come the laser's and the robot's pose and five numbers, except in raw lines.
        more = 0 if word in RAW else 11
        if len(tokens) < n + 10:
            fields.require_fields(tokens, (n + more + 11, n + more + 13), line, word, f"{n} beams")
        m = fields.count(tokens[n + 9], line, word, "remissions", self.limits.max_beams, least=0)
        shortest = n + m + more + 11
        fields.require_fields(tokens, (shortest, shortest + 2), line, word, f"{n} beams and {m} remissions")
        readings = fields.numbers(tokens[9 : n + 9], line, word)
        rest = tokens[n + m + 10 :]
        laser = robot = [0.0, 0.0, 0.0]
        if more:
            laser = self._pose(rest[0:3], line, word, LASERS)
            robot = self._pose(rest[3:6], line, word, ROBOTS)
        stamp = fields.stamp(rest[more], line, word)
        beams = robot_laser_beams(n, fields.numbers(tokens[2:6], line, word), line, word)
        self._stack(word).add(line, readings, (laser, robot), stamp, self._messages_before, beams)

    def _take_odometry(self, tokens: list[str], line: int) -> None:
        if len(tokens) < 8:
            raise ReadError(
                "log.truncated_line", f"Line {line}: this ODOM line ends early: {len(tokens)} fields of 10."
            )
        pose = self._pose(tokens[1:4], line, "ODOM", ROBOTS)
        (stamp,) = fields.numbers(tokens[7:8], line, "ODOM")
        # Corrected logs have stamps that were never set; they are only interpolation weights, so they are not errors.
        self.odometry.add(pose, stamp if abs(stamp) < fields.MAX_STAMP else 0.0)

    def _take_truth(self, tokens: list[str], line: int) -> None:
        if len(tokens) < 8:
            raise ReadError(
                "log.truncated_line", f"Line {line}: this TRUEPOS line ends early: {len(tokens)} fields of 10."
            )
        pose = self._pose(tokens[1:4], line, "TRUEPOS", TRUE)
        self.truth.add(pose, fields.stamp(tokens[7], line, "TRUEPOS"))

    def _take_parameter(self, tokens: list[str], line: int) -> None:
        """Keep the few parameters of the lasers; others may contain any text."""
        if len(tokens) < 3 or tokens[1] not in _PARAMETERS:
            return
        (value,) = fields.numbers(tokens[2:3], line, "PARAM")
        name, unit = _PARAMETERS[tokens[1]]
        if name.endswith(("_max", "_fov", "_resolution")) and value <= 0.0:
            # Values of robots without such a laser, and of simulators without a limit.
            self._not_stated[name] = (
                f"PARAM {tokens[1]} is {value:g} {unit}, which no laser has: it counts as not stated."
            )
            return
        if not abs(value) <= 1000.0:
            raise ReadError("log.parameter", f"Line {line}: PARAM {tokens[1]} cannot be {tokens[2]!r:.40} {unit}.")
        self.parameters[name] = value

    def log(self, name: str, notes: list[str], topic: str | None = None) -> ScanLog:
        """Return the scans of one sensor, the preferred one if ``topic`` names none.

        Raises :class:`ReadError` if there is none.
        """
        word = self._chosen(topic)
        sensor = self.sensors[word]
        notes += [note for parameter, note in self._not_stated.items() if parameter.startswith(_side_of(word))]
        for other, stack in self.sensors.items():
            if other != word:
                notes.append(f"Took the {sensor.n_scans} {word} scans and left out {stack.n_scans} {other} scans.")
        of_kinds = [self._beams(word, kind) for kind in range(len(sensor.kinds))]
        greatest = [NO_RETURN if beams.range_max is None else beams.range_max for beams in of_kinds]
        counts = np.array([n for n, _ in sensor.kinds])[sensor.kind_of_scan]
        readings, notes_on_ranges = sensor.clean_readings(np.repeat(np.array(greatest)[sensor.kind_of_scan], counts))
        notes += notes_on_ranges
        if of_kinds[0].range_max is None:
            notes += note_on_largest_reading(readings)
        usual = sensor.usual_kind
        notes += of_kinds[usual].notes
        notes += sensor.notes_on_time()
        sensor.check_headings()
        is_even = len(of_kinds) == 1
        groups: list[ScanGroup] = []
        if not is_even:
            beamings = [
                Beaming(stated_.angle_min, stated_.angle_increment, 0.0, limit, n)
                for stated_, limit, (n, _) in zip(of_kinds, greatest, sensor.kinds, strict=True)
            ]
            times = np.zeros(sensor.n_scans, dtype=np.float32)
            stated = StatedScans(f"of {word} lines", beamings, sensor.kind_of_scan, readings, times)
            groups, notes_on_groups = scan_groups(stated, self.limits)
            notes += notes_on_groups
        mount = self._mount(sensor, notes)
        trajectories = self._trajectories(sensor, mount)
        notes += [trajectory.placeholder_note for trajectory in trajectories.values() if trajectory.is_placeholder]
        if any(trajectory.offset != NO_OFFSET for trajectory in trajectories.values()):
            notes.append(note_on_offset("The poses", self._offset))
        if self.ignored:
            notes.append("Ignored " + ", ".join(f"{n} {other}" for other, n in self.ignored.most_common()) + " lines.")
        whole = ScanLog(
            ranges=readings.reshape(sensor.n_scans, -1) if is_even else np.empty((sensor.n_scans, 0), np.float32),
            angle_min=of_kinds[usual].angle_min,
            angle_increment=of_kinds[usual].angle_increment,
            range_min=0.0,
            range_max=greatest[usual],
            stamps_ns=sensor.stamps_ns,
            order_ns=ascending_times(sensor.stamps_ns),
            trajectories=trajectories,
            mount=mount,
            name=name,
            format=f"CARMEN {word}",
            topic=word,
            topics=self._topics(word, mount),
            notes=tuple(notes),
            odometry=self._odometry(sensor, trajectories),
            angles_assumed=any(beams.is_assumed for beams in of_kinds),
            mount_assumed=word in RAW and self._parameter(word, "offset") is None,
            limits=self.limits,
        )
        if is_even:
            return whole
        parts = [
            replace(
                whole.take(group.scans),
                ranges=group.ranges,
                angle_min=group.angle_min,
                angle_increment=group.angle_increment,
                range_max=group.range_max,
            )
            for group in groups
        ]
        return parts[0] if len(parts) == 1 else JointLog.of(parts)

    def _odometry(self, sensor: ScanStack, trajectories: Mapping[str, Trajectory]) -> OdometryRecords | None:
        """Return the ODOM messages around the scans of a sensor, in log order; None if there are none.

        Messages that only restart the odometry are excluded (:func:`mapper.io.logs.text.interpolation.restarts`).
        """
        if not len(self.odometry):
            return None
        poses, stamps, before = self.odometry.poses, self.odometry.stamps, sensor.odometry_before
        restart = restarts(poses, stamps, before, sensor.laser_poses, sensor.stamps)
        if restart.any():
            poses = without_restarts(poses, restart)
        kept_before = np.concatenate([[0], np.cumsum(~restart)])
        messages = TimedPoses(np.round(stamps[~restart] * 1e9).astype(np.int64), poses[~restart])
        # The poses of the scan lines, if they are odometry, which need no stamps (those may run backwards).
        stated = (trajectories[name] for name in ("odom", "scan", "wheel") if name in trajectories)
        at_scans = next((trajectory.poses for trajectory in stated if trajectory.frame_id == "odom"), None)
        return OdometryRecords(messages, kept_before[before] - 1, at_scans)

    def _chosen(self, topic: str | None) -> str:
        """Return the word of the selected sensor's lines. Raises :class:`ReadError` if there is none."""
        if not self.sensors:
            raise ReadError(
                "log.no_scans", "The log holds no scans: it has no FLASER, LASER, RLASER, ROBOTLASER or RAWLASER line."
            )
        if topic is not None and topic not in self.sensors:
            raise ReadError("log.topic", f"The log has no {topic!r:.80} scans; it has {', '.join(self.sensors)}.")
        return topic or next(word for word in PREFERENCE if word in self.sensors)

    def _topics(self, chosen: str, mount: tuple[float, float, float]) -> tuple[Topic, ...]:
        """Return the sensors, and the other messages read."""
        topics = []
        for word, stack in sorted(self.sensors.items(), key=lambda item: -item[1].n_scans):
            step = float(np.median(np.diff(np.sort(stack.stamps)))) if stack.n_scans > 1 else 0.0
            view = math.degrees(abs(self._beams(word, stack.usual_kind).angle_increment)) * (stack.n_beams - 1)
            topics.append(
                Topic(
                    word,
                    "laser scan",
                    stack.n_scans,
                    beams=stack.n_beams,
                    field_of_view_deg=view,
                    rate_hz=1.0 / step if step > 0.0 else None,
                    mount=mount if word == chosen else None,
                    chosen=word == chosen,
                )
            )
        poses = {"ODOM": ("odometry", len(self.odometry)), "TRUEPOS": ("true pose", len(self.truth))}
        return (*topics, *(Topic(word, kind, count) for word, (kind, count) in poses.items() if count))

    def _parameter(self, word: str, which: str) -> float | None:
        return self.parameters.get(f"{_side_of(word)}_{which}")

    def _beams(self, word: str, kind: int) -> Beams:
        """Return the beams of some of a sensor's scans: as stated, or else from their number and the parameters.

        ``kind`` is an index into the sensor's :attr:`ScanStack.kinds`.
        """
        n_beams, stated = self.sensors[word].kinds[kind]
        if isinstance(stated, Beams):
            return stated
        fov, resolution = self._parameter(word, "fov"), self._parameter(word, "resolution")
        # Programs write the field of view in degrees or radians; the interpretation below one turn is used.
        in_radians = None if fov is None else fov if fov <= 2.0 * math.pi + 0.01 else math.radians(fov)
        step = None if resolution is None else math.radians(resolution)
        beams = front_laser_beams(n_beams, word, in_radians, step)
        return replace(beams, range_max=self._parameter(word, "max"))

    def _mount(self, sensor: ScanStack, notes: list[str]) -> tuple[float, float, float]:
        """Return ``T_base_laser``: from PARAM, else the difference of a line's two poses if it is constant."""
        yaw = math.pi if sensor.word in REAR else 0.0
        ahead, aside, turned = (
            self._parameter(sensor.word, which) for which in ("offset", "side_offset", "angular_offset")
        )
        if ahead is not None:
            return (ahead, aside or 0.0, yaw if turned is None else turned)
        if sensor.word in RAW:
            notes.append(
                f"{sensor.word} lines do not say where the laser is on the robot, and no PARAM does: it is taken to be "
                f"at its centre, looking {'back' if yaw else 'ahead'}. If it is not, set mount_x, mount_y, mount_yaw."
            )
            return (0.0, 0.0, yaw)
        relative = compose(inverse(sensor.robot_poses), sensor.laser_poses)
        away = np.abs(relative - relative[0])
        away[:, 2] = np.abs(wrap_angle(relative[:, 2] - relative[0, 2]))
        if (away[:, :2] > 5 * _SAME_M).any() or (away[:, 2] > 5 * _SAME_RAD).any():
            return (0.0, 0.0, yaw)
        first = relative[0]
        if _same_pose(first, np.zeros(3)):
            # A log reduced to one pose per scan does not determine the mount.
            return (0.0, 0.0, yaw)
        notes.append(
            f"The laser’s mount is taken from the scan lines’ two poses: {first[0]:.3f} m, {first[1]:.3f} m, "
            f"{math.degrees(first[2]):.1f}°."
        )
        return (float(first[0]), float(first[1]), float(first[2]))

    def _trajectories(self, sensor: ScanStack, mount: tuple[float, float, float]) -> dict[str, Trajectory]:
        if sensor.word in RAW:
            return self._trajectories_of_raw(sensor)
        scan = compose(sensor.laser_poses, inverse(np.array(mount)))
        trajectories = {
            "scan": Trajectory(scan, f"the pose in each {sensor.word} line", offset=self._offset_of(LASERS))
        }
        if not _same_pose(scan, sensor.robot_poses):
            text = f"the odometry pose in each {sensor.word} line"
            trajectories["odom"] = Trajectory(sensor.robot_poses, text, "odom", offset=self._offset_of(ROBOTS))
        if len(self.odometry):
            poses, stamps, before = self.odometry.poses, self.odometry.stamps, sensor.odometry_before
            restart = restarts(poses, stamps, before, sensor.laser_poses, sensor.stamps)
            text = "the ODOM messages at the time of each scan"
            if restart.any():
                poses = without_restarts(poses, restart)
                text += ", chained where the log starts them again from a corrected pose"
            at_scans = poses_at_scans(poses, stamps, before, sensor.stamps)
            trajectories["wheel"] = Trajectory(at_scans, text, "odom", offset=self._offset_of(ROBOTS))
            if _is_near(scan, trajectories["wheel"].poses):
                # The scans' poses are uncorrected odometry.
                trajectories["scan"] = replace(trajectories["scan"], frame_id="odom")
        return trajectories | self._true_trajectory(sensor)

    def _offset_of(self, whose: str) -> Offset:
        return self._offset if self._is_far.get(whose) else NO_OFFSET

    def _true_trajectory(self, sensor: ScanStack) -> dict[str, Trajectory]:
        if not len(self.truth):
            return {}
        poses = poses_at_scans(self.truth.poses, self.truth.stamps, sensor.truth_before, sensor.stamps)
        text = "the simulator’s true pose at the time of each scan"
        return {"truepos": Trajectory(poses, text, "map", offset=self._offset_of(TRUE))}

    def _trajectories_of_raw(self, sensor: ScanStack) -> dict[str, Trajectory]:
        """Return the poses at scans without poses in their lines: those of other lines, or zeros."""
        trajectories = {}
        if len(self.odometry):
            poses = poses_at_scans(self.odometry.poses, self.odometry.stamps, sensor.odometry_before, sensor.stamps)
            text = "the ODOM messages at the time of each scan"
            trajectories["wheel"] = Trajectory(poses, text, "odom", offset=self._offset_of(ROBOTS))
        trajectories |= self._true_trajectory(sensor)
        if trajectories:
            return trajectories
        text = f"the {sensor.word} lines state no poses, and the log has no ODOM or TRUEPOS lines"
        note = (
            f"{text[0].upper()}{text[1:]}, so the map shows all scans as from one place: add poses, as a TUM file, or "
            "estimate them with gridbloom slam."
        )
        still = Trajectory(np.zeros((sensor.n_scans, 3)), text, is_placeholder=True, placeholder_note=note)
        return {"standing still": still}


#: Name in a log → our name and the unit.
_PARAMETERS = {
    **{
        f"robot_{side}laser_{which}": (f"{side}_{which}", "m")
        for side in ("front", "rear")
        for which in ("offset", "side_offset", "angular_offset", "max")
    },
    **{f"robot_{side}_laser_max": (f"{side}_max", "m") for side in ("front", "rear")},
    **{
        f"laser_{side}_laser_{which}": (f"{side}_{which}", "degrees")
        for side in ("front", "rear")
        for which in ("fov", "resolution")
    },
    # In later versions of CARMEN the first laser is at the front.
    **{
        f"laser_laser{number}_{which}": (f"{side}_{which}", "degrees")
        for number, side in ((1, "front"), (2, "rear"))
        for which in ("fov", "resolution")
    },
}


def _side_of(word: str) -> str:
    """Return the position of the laser of lines ``word`` in the names of its parameters."""
    return "front" if word in FRONT else "rear" if word in REAR else "other"


def _same_pose(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    position = np.abs(a[..., :2] - b[..., :2]).max()
    return bool(position < _SAME_M and np.abs(wrap_angle(a[..., 2] - b[..., 2])).max() < _SAME_RAD)


def _is_near(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Return whether nine tenths of the poses (n, 3) are within :data:`_NEAR_M` of each other."""
    return bool(len(a)) and float(np.quantile(np.hypot(*(a - b)[:, :2].T), 0.9)) < _NEAR_M


def read_carmen(
    path: Source, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None, topic: str | None = None
) -> ScanLog:
    """Return the CARMEN log at ``path``, plain or compressed; ``topic`` is the word of the sensor's lines.

    Raises :class:`ReadError`, naming the line, and :class:`LimitError`.
    """
    reader, notes = _read(path, limits, progress)
    return reader.log(path.name, notes, topic)


def read_carmen_sensors(path: Source, limits: Limits, progress: Progress | None, selection: Selection) -> RobotLog:
    """Return the selected sensors of the CARMEN log at ``path``, the preferred one first.

    Raises the errors of :func:`read_carmen`.
    """
    reader, notes = _read(path, limits, progress)
    words: Sequence[str | None] = selection.topics or [None]
    if selection.topics is None:
        words = [None, *[word for word in PREFERENCE if word in reader.sensors][1:]]
    logs = [reader.log(path.name, list(notes), word) for word in dict.fromkeys(words)]
    odometry = logs[0].odometry
    return RobotLog({log.topic: log for log in logs}, {} if odometry is None else {"wheel": odometry.messages})


def _read(path: Source, limits: Limits, progress: Progress | None) -> tuple[CarmenReader, list[str]]:
    reader = CarmenReader(limits)
    notes: list[str] = []
    take_lines(TextLines(path, limits, progress), reader.take, lambda: reader.n_scans, notes)
    return reader, notes
