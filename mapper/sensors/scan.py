"""Readings of a range sensor: one scan, and a whole log of scans packed into arrays.

Readings follow REP 117: +Inf is "no return", −Inf "too close to measure", NaN an invalid reading; a reading r is a
measured range when ``range_min <= r <= range_max``. Source: sensor_msgs/LaserScan, REP 117.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import check_poses, compose
from mapper.sensors.beam_fields import beam_fields, uneven_fields
from mapper.sensors.georeference import NO_OFFSET, Offset, note_on_offset, offset_of
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

MAX_STATED_S = 3600.0  #: seconds: no sensor has a longer time between its beams or scans
MOST_DEGREES = 361.0  #: of a whole turn, whose last beam may be its first one
LEAST_ANGLE_STEP = 1e-6  #: radians: no sensor has a smaller angle between its beams


def is_angle_step(angle_increment: float, n_beams: int) -> bool:
    """Return whether ``angle_increment`` radians is possible for a scan of ``n_beams`` evenly spaced beams."""
    return n_beams < 2 or LEAST_ANGLE_STEP <= abs(angle_increment) <= 2.0 * np.pi


def are_degrees(angle_min: float, angle_increment: float, n_beams: int) -> bool:
    """Return whether angles that should be radians are degrees.

    As radians the beams would go round twice or more, and as degrees they go round once at most.
    """
    whole = abs(angle_increment) * (n_beams - 1)
    return n_beams > 2 and 4.0 * np.pi <= whole <= MOST_DEGREES and abs(angle_min) <= MOST_DEGREES


def _check_angle_step(angle_increment: float, n_beams: int) -> None:
    if not is_angle_step(angle_increment, n_beams):
        raise ConfigError(
            "scan.angle_increment",
            f"The angle_increment of a scan of {n_beams} beams must be {LEAST_ANGLE_STEP:g} … 2π rad, either way, not "
            f"{angle_increment:g}.",
        )


def _check_beams(angle_min: float, angle_increment: float, range_min: float, range_max: float) -> None:
    if not (math.isfinite(angle_min) and math.isfinite(angle_increment)):
        raise ConfigError(
            "scan.angles",
            f"angle_min and angle_increment must be finite, not {angle_min!r} and {angle_increment!r}.",
        )
    if not 0.0 <= range_min < range_max:
        raise ConfigError(
            "scan.range_limits",
            f"Range limits must satisfy 0 ≤ range_min < range_max, not {range_min!r}, {range_max!r}.",
        )


@dataclass(frozen=True, slots=True)
class LaserScan:
    """One revolution or sweep of a range finder.

    ``ranges`` (n_beams,) float32, metres, REP 117. Beam i points at ``angle_min + i · angle_increment`` radians in
    the laser frame, counter-clockwise; a negative increment is a clockwise sweep. Ranges outside
    [``range_min``, ``range_max``] metres are not measurements. ``beam_width`` is 0 for a lidar's thin beams and for a
    ring of sonars, evenly spread, the angle of their cones, radians. ``time_increment`` is the time between two beams
    and ``scan_time`` between two scans, seconds, 0 where unknown (sensor_msgs/LaserScan).
    """

    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    stamp_ns: int = 0
    beam_width: float = 0.0
    time_increment: float = 0.0
    scan_time: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "ranges", np.ascontiguousarray(self.ranges, dtype=np.float32))
        if self.ranges.ndim != 1:
            raise ConfigError("scan.shape", f"A scan’s ranges are one row, not an array of shape {self.ranges.shape}.")
        _check_beams(self.angle_min, self.angle_increment, self.range_min, self.range_max)
        _check_angle_step(self.angle_increment, len(self.ranges))
        _check_width(self.beam_width)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Bearing of each beam (n_beams,) in the laser frame, radians."""
        return np.asarray(self.angle_min + self.angle_increment * np.arange(len(self.ranges)), dtype=np.float64)

    def fields(self, widest: float = np.pi / 4.0, *, turned_over: bool = False) -> NDArray[np.float64]:
        """Return :func:`beam_fields` of the scan, or of :meth:`turned_over`."""
        sign = -1.0 if turned_over else 1.0
        return beam_fields(sign * self.angle_min, sign * self.angle_increment, len(self.ranges), widest)

    def turned_over(self) -> LaserScan:
        """Return the scan as a sensor that hangs upside down took it."""
        return replace(self, angle_min=-self.angle_min, angle_increment=-self.angle_increment)


@dataclass(frozen=True, slots=True)
class SonarScan:
    """One reading from each sonar of a robot, at bearings that need not be even.

    ``ranges`` (n_beams,) float32, metres, REP 117; ``bearings`` (n_beams,) float64, radians in the sensor frame,
    counter-clockwise; ``beam_width`` is the angle of the cone, from edge to edge, in which an echo may arise, radians.
    Source: sensor_msgs/Range (field_of_view), one message for each sonar.
    """

    ranges: NDArray[np.float32]
    bearings: NDArray[np.float64]
    beam_width: float
    range_min: float
    range_max: float
    stamp_ns: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "ranges", np.ascontiguousarray(self.ranges, dtype=np.float32))
        object.__setattr__(self, "bearings", checked_bearings(self.bearings, self.ranges.shape))
        _check_width(self.beam_width)
        _check_beams(0.0, 0.0, self.range_min, self.range_max)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Bearing of each beam (n_beams,) in the sensor frame, radians."""
        return self.bearings

    def fields(self, widest: float = np.pi / 4.0, *, turned_over: bool = False) -> NDArray[np.float64]:
        """Return :func:`uneven_fields` of the scan, or of :meth:`turned_over`."""
        return uneven_fields(-self.bearings if turned_over else self.bearings, widest)

    def turned_over(self) -> SonarScan:
        """Return the scan as a sensor that hangs upside down took it."""
        return replace(self, bearings=-self.bearings)


RangeScan = LaserScan | SonarScan


def checked_bearings(bearings: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return bearings as an array of this shape. Raises :class:`ConfigError` where they are none."""
    array = np.ascontiguousarray(bearings, dtype=np.float64)
    if array.shape != shape or len(shape) != 1 or not np.isfinite(array).all():
        raise ConfigError("scan.bearings", f"Bearings must be finite and of shape {shape}, not {array.shape}.")
    return array


def _check_width(width: float) -> None:
    if not 0.0 <= width <= np.pi / 2.0:
        raise ConfigError("scan.beam_width", f"A beam’s width must be 0 to π/2 radians, not {width!r}.")


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Pose of the robot's base at each scan: ``poses`` (n_scans, 3) float64, ``T_frame_child``, metres and radians.

    ``description`` is one sentence on where the poses come from. ``frame_id`` is the fixed frame that the poses are
    stated in, as ``map`` or ``odom`` (None: the log does not state it), and ``child_frame_id`` the frame of the base
    (REP 105). ``is_placeholder`` marks poses that no source stated: zeros, so that the scans of a log without poses
    can be mapped; ``placeholder_note`` is the note on the log that says so, and holds no longer once the log has poses.
    ``timed`` are the poses as their source states them, with stamps of their own on the scans' clock,
    where it states them by itself, as tf and odometry messages do; between them the motion during a scan is known
    better than between the poses at the scans. ``offset`` (x, y), metres, has been subtracted from what the source
    states, of projected coordinates: a position in ``frame_id`` is a map's plus the offset. ``from_scans`` marks poses
    that were found from the scans, as by SLAM: they are at the times at which the scans were taken, whatever the clocks
    of scans and odometry are apart, so that a time offset between the two does not concern them. ``is_known``
    (n_scans,) is False where the pose is not known, as before a robot is found in a map: no map has such scans. None:
    all are known.
    """

    poses: NDArray[np.float64]
    description: str = ""
    frame_id: str | None = None
    child_frame_id: str = "base_link"
    is_placeholder: bool = False
    timed: TimedPoses | None = None
    offset: Offset = NO_OFFSET
    from_scans: bool = False
    placeholder_note: str = ""
    is_known: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", np.ascontiguousarray(self.poses, dtype=np.float64))
        check_poses(self.poses, (len(self.poses), 3))
        if self.is_known is not None and self.is_known.shape != (len(self.poses),):
            raise ConfigError(
                "trajectory.known", f"{len(self.poses)} poses cannot be known as an array of {self.is_known.shape}."
            )

    @property
    def known_poses(self) -> NDArray[np.float64]:
        """The poses (n_scans, 3), NaN where they are not known."""
        return self.poses if self.is_known is None else np.where(self.is_known[:, np.newaxis], self.poses, np.nan)

    def take(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice) -> Trajectory:
        """Return the trajectory at some of the scans: a mask (n_scans,), their indices, or a slice."""
        known = None if self.is_known is None else self.is_known[scans]
        return replace(self, poses=self.poses[scans], is_known=known)

    def offset_of_stamps(self, time_offset: float) -> float:
        """Return the seconds that are added to the scans' stamps to find their poses: ``time_offset``, or 0.

        It is 0 for poses that were found from the scans.
        """
        return 0.0 if self.from_scans else time_offset


def georeferenced(
    poses: NDArray[np.float64], whose: str, description: str, limits: Limits
) -> tuple[Trajectory, list[str]]:
    """Return the trajectory of ``poses`` (n, 3), which may be far from the origin of their frame, and notes on that.

    Raises :class:`ConfigError` where they are farther than ``max_pose`` from each other.
    """
    offset = offset_of(poses)
    near = poses - np.array([*offset, 0.0])
    check_poses(near, near.shape, limits)
    notes = [note_on_offset(whose, offset)] if offset != NO_OFFSET else []
    return Trajectory(near, description, offset=offset), notes


@dataclass(frozen=True, slots=True)
class Topic:
    """One stream of messages in the file that a log was read from.

    ``frame`` to ``mount`` are those of a range sensor, None of anything else: ``frame`` is the one that its scans are
    stated in, ``mount`` ``T_base_frame`` (m, m, rad) where the file says it; ``chosen`` marks the sensor whose scans
    the log holds. When its messages were recorded and how large they are, :mod:`mapper.io.contents` finds out.
    """

    name: str
    type: str
    count: int
    frame: str | None = None
    beams: int | None = None
    field_of_view_deg: float | None = None
    rate_hz: float | None = None
    mount: tuple[float, float, float] | None = None
    chosen: bool = False


@dataclass(frozen=True, slots=True)
class ScanLog:
    """A whole log of one sensor, packed once, so that it can be mapped again and again in milliseconds.

    ``ranges`` (n_scans, n_beams) float32; ``stamps_ns`` (n_scans,) int64, as recorded (they may jump backwards);
    ``trajectories`` name → :class:`Trajectory`, the first being the default; ``mount`` (3,) is ``T_base_laser``, of a
    sensor that moves on the robot at its first scan, and ``mounts`` (n_scans, 3) float64 at each (None: it is fixed);
    ``upside_down`` says that the laser hangs with its z axis down, so its beams run clockwise seen from above.
    A log of sonars has ``bearings`` (n_beams,) in the sensor frame, radians, where theirs are not even (``angle_min``
    and ``angle_increment`` say nothing then), and a ``beam_width``, the angle of their cones; it is 0 for a lidar.
    ``topic`` is the sensor's name in its file, empty for formats of one stream, and ``frame_id`` its frame.
    ``time_increment`` is the time from one beam to the next and ``scan_time`` from one scan to the next, seconds, 0
    where the file does not state them; where scans state different ones, the median. ``angles_assumed`` says that the
    file states no angles, and that they are a guess: its beams are as many as those of no lidar that is known;
    ``mount_assumed`` that a recording does not state where the sensor is on the robot. ``wrong_sweep`` is a sentence on
    the stated times between beams, where they cannot be, or the readings contradict them: the log is as they say.
    ``wrong_clock`` is one on a source of poses whose stamps the readings contradict: the log has its poses by the
    scans' clock.
    ``odometry`` has the odometry as recorded, where there is any: its messages, and where the scans stand among them.
    ``order_ns`` (n_scans,) int64 are times that ascend in the order of the scans, where the stamps do not (None): by
    them scans of several sensors follow one another, and those of one sensor with different beams.
    """

    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    stamps_ns: NDArray[np.int64]
    trajectories: Mapping[str, Trajectory]
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    upside_down: bool = False
    bearings: NDArray[np.float64] | None = None
    beam_width: float = 0.0
    name: str = ""
    format: str = ""
    topic: str = ""
    topics: tuple[Topic, ...] = ()  #: all that the file holds, the sensors first; empty for formats of one stream
    frame_id: str = "laser"
    time_increment: float = 0.0
    scan_time: float = 0.0
    notes: tuple[str, ...] = ()  #: one sentence each on what the reader noticed: skipped lines, jumps in time
    odometry: OdometryRecords | None = None
    mounts: NDArray[np.float64] | None = None
    order_ns: NDArray[np.int64] | None = None
    angles_assumed: bool = False
    mount_assumed: bool = False
    wrong_sweep: str = ""
    wrong_clock: str = ""
    limits: Limits = field(default=DEFAULT_LIMITS, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ranges", np.ascontiguousarray(self.ranges, dtype=np.float32))
        object.__setattr__(self, "stamps_ns", np.ascontiguousarray(self.stamps_ns, dtype=np.int64))
        if self.ranges.ndim != 2:
            raise ConfigError(
                "log.shape", f"A log’s ranges are scans × beams, not an array of shape {self.ranges.shape}."
            )
        if len(self.ranges) > self.limits.max_scans or self.ranges.shape[1] > self.limits.max_beams:
            raise LimitError(
                "log.too_large",
                f"The log has {self.ranges.shape[0]} scans × {self.ranges.shape[1]} beams; the limits are "
                f"{self.limits.max_scans} and {self.limits.max_beams}.",
            )
        if self.stamps_ns.shape != (len(self.ranges),):
            raise ConfigError(
                "log.stamps", f"{len(self.ranges)} scans need as many stamps, not {self.stamps_ns.shape}."
            )
        if self.order_ns is not None and self.order_ns.shape != self.stamps_ns.shape:
            raise ConfigError(
                "log.stamps", f"{len(self.ranges)} scans need as many times of their order, not {self.order_ns.shape}."
            )
        if not self.trajectories:
            raise ConfigError("log.no_trajectory", "A log needs at least one trajectory.")
        for trajectory in self.trajectories.values():
            check_poses(trajectory.poses, (len(self.ranges), 3), self.limits)
        if self.odometry is not None and len(self.odometry.before_scan) != len(self.ranges):
            raise ConfigError(
                "log.odometry",
                f"The odometry has poses for {len(self.odometry.before_scan)} scans, and the log has "
                f"{len(self.ranges)}.",
            )
        _check_beams(self.angle_min, self.angle_increment, self.range_min, self.range_max)
        _check_width(self.beam_width)
        if not np.isfinite([self.time_increment, self.scan_time]).all():
            raise ConfigError(
                "log.times",
                "The time increment and the scan time must be finite numbers of seconds, not "
                f"{self.time_increment!r} and {self.scan_time!r}.",
            )
        if self.bearings is None:
            _check_angle_step(self.angle_increment, self.ranges.shape[1])
        else:
            object.__setattr__(self, "bearings", checked_bearings(self.bearings, self.ranges.shape[1:]))
        if np.shape(self.mount) != (3,) or not np.isfinite(self.mount).all():
            raise ConfigError("log.mount", f"The sensor mount must be three finite numbers, not {self.mount!r}.")
        if self.mounts is not None:
            object.__setattr__(self, "mounts", np.ascontiguousarray(self.mounts, dtype=np.float64))
            if self.mounts.shape != (len(self.ranges), 3) or not np.isfinite(self.mounts).all():
                raise ConfigError(
                    "log.mount", f"The mounts of {len(self.ranges)} scans must be as many rows of three finite numbers."
                )

    @property
    def n_scans(self) -> int:
        """Number of scans."""
        return int(self.ranges.shape[0])

    @property
    def n_beams(self) -> int:
        """Beams in each scan."""
        return int(self.ranges.shape[1])

    @property
    def sweep(self) -> tuple[float, float]:
        """Bearing of the first beam and from one beam to the next, radians, counter-clockwise seen from above."""
        return (-self.angle_min, -self.angle_increment) if self.upside_down else (self.angle_min, self.angle_increment)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Bearing of each beam (n_beams,) around the sensor's heading, radians, counter-clockwise seen from above."""
        if self.bearings is not None:
            return -self.bearings if self.upside_down else self.bearings
        angle_min, angle_increment = self.sweep
        return np.asarray(angle_min + angle_increment * np.arange(self.n_beams), dtype=np.float64)

    def fields(self, widest: float = np.pi / 4.0, *, turned_over: bool = False) -> NDArray[np.float64]:
        """Return the perceptual fields of the beams (n_beams, 4), as :func:`beam_fields`, seen from above.

        With ``turned_over``, those of the sensor mounted the other way up.
        """
        if self.bearings is not None:
            return uneven_fields(-self.angles if turned_over else self.angles, widest)
        angle_min, angle_increment = self.sweep
        sign = -1.0 if turned_over else 1.0
        return beam_fields(sign * angle_min, sign * angle_increment, self.n_beams, widest)

    @property
    def default_trajectory(self) -> str:
        """Name of the trajectory that is used where none is named."""
        return next(iter(self.trajectories))

    def trajectory(self, name: str | None = None) -> Trajectory:
        """Return the trajectory ``name`` (None: the default). Raises :class:`ConfigError` for a name the log lacks."""
        key = self.default_trajectory if name is None else name
        if key not in self.trajectories:
            raise ConfigError(
                "log.trajectory",
                f"The log has no trajectory {key!r:.80}; it has {', '.join(map(repr, self.trajectories))}.",
            )
        return self.trajectories[key]

    def can_deskew(self, trajectory: str | None = None) -> bool:
        """Return whether the beams of a scan were measured at times that are known, while the robot's poses are.

        Of several sensors, whether those of any were.
        """
        stated = 0.0 < abs(self.time_increment) <= MAX_STATED_S
        if not stated or self.n_beams < 2 or self.trajectory(trajectory).is_placeholder:
            return False
        return bool((self.stamps_ns != self.stamps_ns[:1]).any())

    def sensor_poses(self, trajectory: str | None = None) -> NDArray[np.float64]:
        """Return ``T_map_laser`` of every scan (n_scans, 3): the base's pose composed with the mount."""
        return compose(self.trajectory(trajectory).poses, self.mounts_at(slice(None)))

    def mounts_at(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice | int) -> NDArray[np.float64]:
        """Return ``T_base_laser`` at some scans: (n, 3) of a sensor that moves on the robot, else (3,) for all."""
        return np.array(self.mount) if self.mounts is None else self.mounts[scans]

    def mount_of(self, index: int) -> NDArray[np.float64]:
        """Return ``T_base_laser`` (3,) at scan ``index``."""
        return np.array(self.mount) if self.mounts is None else self.mounts[index]

    def take(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice) -> ScanLog:
        """Return the log of some of its scans: a mask (n_scans,), their indices, or a slice."""
        return replace(
            self,
            ranges=self.ranges[scans],
            stamps_ns=self.stamps_ns[scans],
            trajectories={name: trajectory.take(scans) for name, trajectory in self.trajectories.items()},
            odometry=None if self.odometry is None else self.odometry.take(scans),
            mounts=None if self.mounts is None else self.mounts[scans],
            order_ns=None if self.order_ns is None else self.order_ns[scans],
        )

    def scan(self, index: int) -> RangeScan:
        """Return scan ``index``, negative from the end; bearings as seen from above, also of an upside-down laser."""
        if self.bearings is not None:
            limits = (self.range_min, self.range_max, int(self.stamps_ns[index]))
            return SonarScan(self.ranges[index], self.angles, self.beam_width, *limits)
        return LaserScan(
            self.ranges[index],
            *self.sweep,
            self.range_min,
            self.range_max,
            int(self.stamps_ns[index]),
            self.beam_width,
            self.time_increment,
            self.scan_time,
        )
