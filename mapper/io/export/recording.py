"""A log and its map as an MCAP file of ROS 2 messages, for Foxglove, Lichtblick, Rerun and ROS 2.

| topic | type | |
|---|---|---|
| ``/map`` | nav_msgs/OccupancyGrid | the map after the first scan, at some scans in between, and after the last |
| ``/tf_static`` | tf2_msgs/TFMessage | base → sensor, the sensor's mount |
| ``/tf`` | tf2_msgs/TFMessage | the trajectory's frame → base at each scan; base → a sensor that moves on it |
| ``/pose`` | geometry_msgs/PoseStamped | the same as a pose |
| ``/scan`` | sensor_msgs/LaserScan | each scan |
| ``/points`` | sensor_msgs/PointCloud2 | where its beams ended, for viewers that draw no LaserScan (Rerun) |
| ``/sonar_0`` … | sensor_msgs/Range | the sonars of a log that has them, each in a frame of its own |

The scans of several sensors are on the topics of the recording, and their points on ``<topic>/points``.

Frames have the names stated by the log and its trajectory: odometry poses are odom → base_link, and the map made with
them is in odom. A log without poses has neither ``/tf`` nor ``/pose``, and its map is in the base frame. ``/map`` and
``/tf_static`` are latched (transient local): a late subscriber receives the last message.

Source: mcap.dev/spec, and its registry on the ``ros2`` profile; REP 105 (frames).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import IO

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from mapper.io.export import ros2
from mapper.io.export.growing_map import GrowingMap
from mapper.io.export.ros2 import Pose
from mapper.io.export.topics import Topics
from mapper.io.logs.ros.cdr_writer import SECOND
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import base_poses, deskewed_beams, is_deskewed, without_mount_correction
from mapper.mapping.update_plan import UpdatePlan, plan_update
from mapper.sensors.joint_log import JointLog, by_sensor
from mapper.sensors.scan import LaserScan, ScanLog

_NO_PART_OF_A_NAME = re.compile(r"[^A-Za-z0-9_/]")


@dataclass(frozen=True, slots=True)
class ExportedSensor:
    """One planar sensor: ``poses`` (n_scans, 3) are ``T_map_base`` at its scans.

    ``scan`` and ``points`` name the topics of a lidar, ``sonars`` and ``sonar_frames`` (n_beams,) the topics and frames
    of sonars. ``plan`` is that of the map, None if no beams are deskewed; ``rays`` (n_beams, 2) are the directions of
    the beams in the sensor's frame.
    """

    log: ScanLog
    poses: NDArray[np.float64]
    plan: UpdatePlan | None
    trajectory: str | None
    frame: str
    scan: str
    points: str
    sonars: tuple[str, ...]
    sonar_frames: tuple[str, ...]
    rays: NDArray[np.float64]

    def moves_on(self, base: str) -> bool:
        """Return whether the sensor moves on the robot, whose base frame is ``base``."""
        return self.log.mounts is not None and self.frame != base

    def ends(self, index: int) -> NDArray[np.float64]:
        """Return the endpoints of a scan's beams (n_beams, 2), metres in the sensor's frame at the scan's stamp.

        For readings that are not distances it is the sensor's position.
        """
        ranges, rays = self.log.ranges[index], self.rays
        if self.plan is not None:
            ranges, bearings = deskewed_beams(self.log, self.plan, self.trajectory, index)
            sign = -1.0 if self.log.upside_down else 1.0
            rays = np.stack([np.cos(bearings), sign * np.sin(bearings)], axis=1)
        return np.asarray(np.where(np.isfinite(ranges), ranges, 0.0)[:, None] * rays)


def exported_sensors(
    log: ScanLog, trajectory: str | None, config: MappingConfig | None, taken: Collection[str]
) -> list[ExportedSensor]:
    """Return the sensors of a log with unique names.

    The topics of a single sensor are ``/scan`` and ``/points``, or ``/sonar_0`` …; those of several are named as in the
    recording, except for characters not allowed in a name and for names already ``taken``. The parts of one switched
    lidar, which are in the log's order, share its names. ``config`` is that of the map in which the scans are to be
    placed, if there is one.
    """
    if not isinstance(log, JointLog):
        names = [f"/sonar_{i}" for i in range(log.n_beams)]
        return [_sensor(log, trajectory, config, log.frame_id, "/scan", "/points", names)]
    sensors, topics, frames = by_sensor(log), set(taken), set[str]()
    exported: dict[int, ExportedSensor] = {}
    for number, (sensor, scans) in enumerate(sensors):
        plain = _NO_PART_OF_A_NAME.sub("_", sensor.topic).strip("/") or f"scan_{number}"
        topic = _unused(f"/{plain}", number, topics) if len(sensors) > 1 else "/scan"
        frame = _unused(sensor.frame_id, number, frames)
        points = _unused(f"{topic}/points", number, topics) if len(sensors) > 1 else "/points"
        for index in np.unique(log.part_of_scan[scans]).tolist():  # of a switched lidar
            part = log.parts[index]
            sonars = [f"{topic}_{i}" for i in range(part.n_beams)] if part.n_beams > 1 else [topic]
            exported[index] = _sensor(part, trajectory, config, frame, topic, points, sonars)
    return [exported[index] for index in range(len(log.parts)) if index in exported]


def _unused(name: str, number: int, used: set[str]) -> str:
    """Return a name not yet ``used``, and add it to those."""
    while name in used:
        name = f"{name}_{number}"
    used.add(name)
    return name


def _sensor(
    log: ScanLog,
    trajectory: str | None,
    config: MappingConfig | None,
    frame: str,
    scan: str,
    points: str,
    sonars: Sequence[str],
) -> ExportedSensor:
    poses, plan = log.trajectory(trajectory).poses, None
    if config is not None:  # place the scans as in that map
        plan = without_mount_correction(plan_update(config, log.range_min, log.range_max))
        poses = base_poses(log, plan, trajectory)
        plan = plan if is_deskewed(log, plan, trajectory) else None
    of_sonars: tuple[str, ...] = ()
    if log.bearings is not None:
        own = [name.rsplit("/", 1)[-1] for name in sonars]
        of_sonars = tuple(own) if log.n_beams > 1 else (frame,)
    angles = log.angle_min + log.angle_increment * np.arange(log.n_beams)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return ExportedSensor(log, poses, plan, trajectory, frame, scan, points, tuple(sonars), of_sonars, rays)


LAST_STAMP_NS = ros2.LAST_STAMP_NS
BETWEEN_NS = SECOND // 10  #: between two scans of a log without times
LATCHED = frozenset({"/map", "/tf_static"})
_OWN = (*LATCHED, "/tf", "/pose")  #: topics not used for sensors


def export_stamps(stamps_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a time for each scan (n,) that every player accepts: ascending from 0 or later, within 32 bits of seconds.

    Valid times are kept. A step back waits until the clock has caught up; a clock with another epoch is shifted to
    start at 0; a log without times gets ten scans per second.
    """
    if len(stamps_ns) == 0:
        return stamps_ns
    if (stamps_ns == stamps_ns[0]).all():
        return np.arange(len(stamps_ns), dtype=np.int64) * BETWEEN_NS
    rising = np.maximum.accumulate(stamps_ns)
    if rising[0] < 0 or rising[-1] > LAST_STAMP_NS:
        span = rising.view(np.uint64) - rising[:1].view(np.uint64)  # unsigned: it may not fit into a signed integer
        rising = np.minimum(span, np.uint64(LAST_STAMP_NS)).astype(np.int64)
    return rising


def write_mcap(
    file: IO[bytes],
    log: ScanLog,
    growing_map: GrowingMap | None = None,
    trajectory: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write ``log``, of one or several sensors, with one of its trajectories, and the growing map, to ``file``.

    ``progress`` is called with the fraction done, 0 to 1, and may raise to cancel writing. Raises :class:`ConfigError`
    for a trajectory that the log lacks.
    """
    exported = log.trajectory(trajectory)
    frame, base = exported.frame_id or "map", exported.child_frame_id
    stamps = export_stamps(log.stamps_ns)
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start("ros2", "gridbloom")
    topics = Topics(writer, LATCHED)
    config = None if growing_map is None else growing_map.config
    sensors = exported_sensors(log, trajectory, config, _OWN)
    first = int(stamps[0]) if len(stamps) else 0
    edges = list(dict.fromkeys(edge for sensor in sensors for edge in _mounts(sensor, base)))
    if edges:
        topics.send("/tf_static", "tf2_msgs/msg/TFMessage", first, ros2.transforms(first, edges))
    maps = iter(()) if growing_map is None else growing_map.maps(log, trajectory)
    coming = next(maps, None)
    is_joint = isinstance(log, JointLog)
    written: tuple[int, Pose] | None = None
    for index, stamp in enumerate(stamps.tolist()):
        sensor = sensors[int(log.part_of_scan[index])] if isinstance(log, JointLog) else sensors[0]
        own = int(log.scan_of_part[index]) if isinstance(log, JointLog) else index
        x, y, yaw = (float(value) for value in sensor.poses[own])
        pose = (x, y, yaw)
        if not exported.is_placeholder and not (is_joint and written == (stamp, pose)):
            written = (stamp, pose)
            edge = (frame, base, pose, False)
            topics.send("/tf", "tf2_msgs/msg/TFMessage", stamp, ros2.transforms(stamp, [edge]))
            topics.send("/pose", "geometry_msgs/msg/PoseStamped", stamp, ros2.pose_stamped(stamp, frame, pose))
        if sensor.moves_on(base):
            x, y, yaw = (float(value) for value in sensor.log.mounts_at(own))
            edge = (base, sensor.frame, (x, y, yaw), sensor.log.upside_down)
            topics.send("/tf", "tf2_msgs/msg/TFMessage", stamp, ros2.transforms(stamp, [edge]))
        if sensor.log.bearings is None:
            _send_scan(topics, sensor, own, stamp)
        else:
            _send_sonars(topics, sensor, own, stamp)
        if coming is not None and growing_map is not None and coming[0] == index:
            geometry = growing_map.grid.geometry
            message = ros2.occupancy_grid(stamp, frame, geometry.resolution, geometry.origin, coming[1])
            topics.send("/map", "nav_msgs/msg/OccupancyGrid", stamp, message)
            coming = next(maps, None)
        if progress is not None and index % 256 == 0:
            progress(index / len(stamps))
    writer.finish()  # type: ignore[no-untyped-call] # mcap's writer has no types there


def _mounts(sensor: ExportedSensor, base: str) -> list[tuple[str, str, Pose, bool]]:
    """Return the edges (parent, child, ``T_parent_child``, upside-down) from the base to a sensor and to its sonars.

    The edge of a moving sensor is omitted, because it is written at each scan.
    """
    log, frame = sensor.log, sensor.frame
    edges = [] if base == frame or sensor.moves_on(base) else [(base, frame, log.mount, log.upside_down)]
    if log.bearings is not None and log.n_beams > 1:
        named = zip(sensor.sonar_frames, log.bearings, strict=True)
        edges += [(frame, name, (0.0, 0.0, float(bearing)), False) for name, bearing in named]
    return edges


def _send_scan(topics: Topics, sensor: ExportedSensor, index: int, stamp: int) -> None:
    """Write one scan as measured (the frame flips that of an upside-down sensor), and its endpoints."""
    log = sensor.log
    ranges = log.ranges[index]
    scan = LaserScan(
        ranges,
        log.angle_min,
        log.angle_increment,
        log.range_min,
        log.range_max,
        time_increment=log.time_increment,
        scan_time=log.scan_time,
    )
    topics.send(sensor.scan, "sensor_msgs/msg/LaserScan", stamp, ros2.laser_scan(stamp, sensor.frame, scan))
    measured = (ranges > 0.0) & (ranges >= log.range_min) & (ranges <= log.range_max) & np.isfinite(ranges)
    points = np.zeros((int(np.count_nonzero(measured)), 3), dtype=np.float32)
    points[:, :2] = sensor.ends(index)[measured]
    topics.send(sensor.points, "sensor_msgs/msg/PointCloud2", stamp, ros2.point_cloud(stamp, sensor.frame, points))


def _send_sonars(topics: Topics, sensor: ExportedSensor, index: int, stamp: int) -> None:
    log = sensor.log
    for topic, frame, reading in zip(sensor.sonars, sensor.sonar_frames, log.ranges[index].tolist(), strict=True):
        message = ros2.range_reading(stamp, frame, log.beam_width, log.range_min, log.range_max, reading)
        topics.send(topic, "sensor_msgs/msg/Range", stamp, message)
