"""Readings of a range sensor: single scans, and logs of scans packed into arrays.

Readings follow REP 117: +Inf is "no return", −Inf "too close to measure", NaN an invalid reading; a reading r is a
measured range if ``range_min <= r <= range_max``. Source: sensor_msgs/LaserScan, REP 117.
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
MOST_DEGREES = 361.0  #: a full turn plus one, because the last beam may coincide with the first
LEAST_ANGLE_STEP = 1e-6  #: radians: no sensor has a smaller angle between its beams


def is_angle_step(angle_increment: float, n_beams: int) -> bool:
    """Return whether ``angle_increment`` radians is possible for a scan of ``n_beams`` evenly spaced beams."""
    return n_beams < 2 or LEAST_ANGLE_STEP <= abs(angle_increment) <= 2.0 * np.pi


def are_degrees(angle_min: float, angle_increment: float, n_beams: int) -> bool:
    """Return whether angles that should be radians are degrees.

    That is, whether the beams span two turns or more as radians, and at most one turn as degrees.
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

    ``ranges`` (n_beams,) float32, metres, REP 117. Beam i points at ``angle_min + i · angle_increment`` radians in the
    laser frame, counter-clockwise; a negative increment is a clockwise sweep. Ranges outside [``range_min``,
    ``range_max``] metres are not measurements. ``beam_width`` is 0 for the thin beams of a lidar, and the angle of the
    cones, radians, for an evenly spaced ring of sonars. ``time_increment`` is the time between two beams and
    ``scan_time`` between two scans, seconds, 0 if unknown (sensor_msgs/LaserScan).
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
        """Return the scan as measured by the sensor mounted upside down."""
        return replace(self, angle_min=-self.angle_min, angle_increment=-self.angle_increment)


@dataclass(frozen=True, slots=True)
class SonarScan:
    """One reading from each sonar of a robot, at bearings that may be uneven.

    ``ranges`` (n_beams,) float32, metres, REP 117; ``bearings`` (n_beams,) float64, radians in the sensor frame,
    counter-clockwise; ``beam_width`` is the angle of the cone from which an echo may come, edge to edge, radians.
    Source: sensor_msgs/Range (field_of_view), one message per sonar.
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
        """Return the scan as measured by the sensor mounted upside down."""
        return replace(self, bearings=-self.bearings)


RangeScan = LaserScan | SonarScan


def checked_bearings(bearings: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return bearings as an array of this shape. Raises :class:`ConfigError` for invalid ones."""
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

    ``description`` is one sentence on the source of the poses. ``frame_id`` is the fixed frame of the poses, such as
    ``map`` or ``odom`` (None: not stated by the log), and ``child_frame_id`` the frame of the base (REP 105).
    ``is_placeholder`` marks poses without a source: zeros, so that a log without poses can be mapped;
    ``placeholder_note`` is the corresponding note, which is removed once the log has poses. ``timed`` are the poses
    with their own stamps on the scans' clock, from sources that publish them separately, such as tf and odometry
    messages; they describe the motion during a scan better than the poses at the scans. ``offset`` (x, y), metres, has
    been subtracted from projected coordinates: a position in ``frame_id`` is the map's plus the offset. ``from_scans``
    marks poses estimated from the scans, as by SLAM: they belong to the times of the scans, so a time offset between
    the clocks of scans and odometry does not apply to them. ``is_known`` (n_scans,) is False if the pose is unknown,
    for example before a robot is localised; such scans are not mapped. None: all are known.
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
        """The poses (n_scans, 3), NaN if unknown."""
        return self.poses if self.is_known is None else np.where(self.is_known[:, np.newaxis], self.poses, np.nan)

    def take(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice) -> Trajectory:
        """Return the trajectory at some of the scans: a mask (n_scans,), their indices, or a slice."""
        known = None if self.is_known is None else self.is_known[scans]
        return replace(self, poses=self.poses[scans], is_known=known)

    def offset_of_stamps(self, time_offset: float) -> float:
        """Return the seconds added to the scans' stamps to look up their poses: ``time_offset``, or 0.

        It is 0 for poses estimated from the scans.
        """
        return 0.0 if self.from_scans else time_offset


def georeferenced(
    poses: NDArray[np.float64], whose: str, description: str, limits: Limits
) -> tuple[Trajectory, list[str]]:
    """Return the trajectory of ``poses`` (n, 3), which may be far from the origin of their frame, with notes on it.

    Raises :class:`ConfigError` if they are farther than ``max_pose`` from each other.
    """
    offset = offset_of(poses)
    near = poses - np.array([*offset, 0.0])
    check_poses(near, near.shape, limits)
    notes = [note_on_offset(whose, offset)] if offset != NO_OFFSET else []
    return Trajectory(near, description, offset=offset), notes


@dataclass(frozen=True, slots=True)
class Topic:
    """One stream of messages in the file of a log.

    ``frame`` to ``mount`` apply to range sensors and are None for others: ``frame`` is the frame of its scans,
    ``mount`` is ``T_base_frame`` (m, m, rad) if the file states it; ``chosen`` marks the sensor whose scans the log
    contains. :mod:`mapper.io.contents` determines the times and sizes of its messages.
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
    """A log of one sensor, packed into arrays once so that it can be mapped repeatedly in milliseconds.

    ``ranges`` (n_scans, n_beams) float32; ``stamps_ns`` (n_scans,) int64, as recorded (they may jump backwards);
    ``trajectories`` name → :class:`Trajectory`, the first being the default. ``mount`` (3,) is ``T_base_laser``, for a
    sensor that moves on the robot that at the first scan, and ``mounts`` (n_scans, 3) float64 at each scan (None: it is
    fixed). ``upside_down`` means that the laser's z axis points down, so its beams run clockwise seen from above. A log
    of sonars has ``bearings`` (n_beams,) in the sensor frame, radians, if they are uneven (``angle_min`` and
    ``angle_increment`` are then unused), and a ``beam_width``, the angle of their cones; it is 0 for a lidar. ``topic``
    is the sensor's name in its file, empty for formats with one stream, and ``frame_id`` its frame.

    ``time_increment`` is the time between beams and ``scan_time`` between scans, seconds, 0 if the file does not state
    them; if they vary, the median. ``angles_assumed`` means that the file states no angles and they are a guess,
    because no known lidar has this number of beams; ``mount_assumed`` that a recording does not state the sensor's
    mount. ``wrong_sweep`` is a sentence on impossible times between beams, or ones that the readings contradict; the
    log keeps them. ``wrong_clock`` is a sentence on a source of poses whose stamps the readings contradict; the log has
    its poses by the scans' clock.

    ``odometry`` has the recorded odometry, if any: its messages and the scans' positions among them. ``order_ns``
    (n_scans,) int64 are ascending times for logs whose stamps do not ascend (otherwise None). They order the scans of
    several sensors, and those of one sensor with different beams.
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
    topics: tuple[Topic, ...] = ()  #: all streams of the file, the sensors first; empty for formats with one stream
    frame_id: str = "laser"
    time_increment: float = 0.0
    scan_time: float = 0.0
    notes: tuple[str, ...] = ()  #: the reader's remarks, one sentence each: skipped lines, jumps in time
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
        """Number of beams in each scan."""
        return int(self.ranges.shape[1])

    @property
    def sweep(self) -> tuple[float, float]:
        """Bearing of the first beam and step between beams, radians, counter-clockwise seen from above."""
        return (-self.angle_min, -self.angle_increment) if self.upside_down else (self.angle_min, self.angle_increment)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Bearing of each beam (n_beams,) around the sensor's heading, radians, counter-clockwise seen from above."""
        if self.bearings is not None:
            return -self.bearings if self.upside_down else self.bearings
        angle_min, angle_increment = self.sweep
        return np.asarray(angle_min + angle_increment * np.arange(self.n_beams), dtype=np.float64)

    def fields(self, widest: float = np.pi / 4.0, *, turned_over: bool = False) -> NDArray[np.float64]:
        """Return the perceptual fields of the beams (n_beams, 4), like :func:`beam_fields`, seen from above.

        With ``turned_over``, those of the sensor flipped upside down.
        """
        if self.bearings is not None:
            return uneven_fields(-self.angles if turned_over else self.angles, widest)
        angle_min, angle_increment = self.sweep
        sign = -1.0 if turned_over else 1.0
        return beam_fields(sign * angle_min, sign * angle_increment, self.n_beams, widest)

    @property
    def default_trajectory(self) -> str:
        """Name of the default trajectory."""
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
        """Return whether the beams of a scan were measured at known times, and the robot's poses are known.

        For several sensors, whether this holds for any of them.
        """
        stated = 0.0 < abs(self.time_increment) <= MAX_STATED_S
        if not stated or self.n_beams < 2 or self.trajectory(trajectory).is_placeholder:
            return False
        return bool((self.stamps_ns != self.stamps_ns[:1]).any())

    def sensor_poses(self, trajectory: str | None = None) -> NDArray[np.float64]:
        """Return ``T_map_laser`` of every scan (n_scans, 3): the base's pose composed with the mount."""
        return compose(self.trajectory(trajectory).poses, self.mounts_at(slice(None)))

    def mounts_at(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice | int) -> NDArray[np.float64]:
        """Return ``T_base_laser`` at some scans: (n, 3) for a sensor that moves on the robot, else (3,) for all."""
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
        """Return scan ``index``, negative from the end; bearings are seen from above, also for an upside-down laser."""
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
