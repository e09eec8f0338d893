"""A log and its map as an MCAP file of ROS 2 messages, which Foxglove, Lichtblick and Rerun open, and ROS 2 plays.

| topic | type | |
|---|---|---|
| ``/map`` | nav_msgs/OccupancyGrid | the map after the first scan, at some scans in between, and after the last |
| ``/tf_static`` | tf2_msgs/TFMessage | base → sensor, the sensor's mount |
| ``/tf`` | tf2_msgs/TFMessage | the trajectory's frame → base at each scan; base → a sensor that moves on it |
| ``/pose`` | geometry_msgs/PoseStamped | the same as a pose |
| ``/scan`` | sensor_msgs/LaserScan | each scan |
| ``/points`` | sensor_msgs/PointCloud2 | where its beams ended, for viewers that draw no LaserScan (Rerun) |
| ``/sonar_0`` … | sensor_msgs/Range | the sonars of a log that has them, each in a frame of its own |

The scans of several sensors are on the topics that they had in the recording, and their points on ``<topic>/points``.

Frames have the names that the log and its trajectory state: poses of odometry are odom → base_link, and the map that
was made with them is in odom. A log without poses gets neither ``/tf`` nor ``/pose``, and its map is in the base's
frame. ``/map`` and ``/tf_static`` are latched (transient local): a late subscriber receives the last one.

Source: mcap.dev/spec, and its registry on the ``ros2`` profile; REP 105 (frames).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import IO

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from mapper.io.export import ros2
from mapper.io.export.exported_sensor import ExportedSensor, exported_sensors
from mapper.io.export.growing_map import GrowingMap
from mapper.io.export.ros2 import Pose
from mapper.io.export.topics import Topics
from mapper.io.logs.ros.cdr_writer import SECOND
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import LaserScan, ScanLog

LAST_STAMP_NS = ros2.LAST_STAMP_NS
BETWEEN_NS = SECOND // 10  #: two scans of a log without times
LATCHED = frozenset({"/map", "/tf_static"})
_OWN = (*LATCHED, "/tf", "/pose")  #: topics that no sensor's scans go to


def export_stamps(stamps_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a time for each scan (n,) that every player takes: rising from 0 or later, and within 32 bits of seconds.

    Times that are so already stay. A step back waits until the clock has caught up; a clock that began elsewhere is
    set to begin at 0; a log without times gets ten scans a second.
    """
    if len(stamps_ns) == 0:
        return stamps_ns
    if (stamps_ns == stamps_ns[0]).all():
        return np.arange(len(stamps_ns), dtype=np.int64) * BETWEEN_NS
    rising = np.maximum.accumulate(stamps_ns)
    if rising[0] < 0 or rising[-1] > LAST_STAMP_NS:
        span = rising.view(np.uint64) - rising[:1].view(np.uint64)  # unsigned: it need not fit a signed number
        rising = np.minimum(span, np.uint64(LAST_STAMP_NS)).astype(np.int64)
    return rising


def write_mcap(
    file: IO[bytes],
    log: ScanLog,
    growing_map: GrowingMap | None = None,
    trajectory: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write ``log``, of one sensor or of several, with one of its trajectories, and the map as it grows, to ``file``.

    ``progress`` is called with the share that is done, 0 … 1; what it raises ends the writing. Raises
    :class:`ConfigError` for a trajectory that the log lacks.
    """
    way = log.trajectory(trajectory)
    frame, base = way.frame_id or "map", way.child_frame_id
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
        if not way.is_placeholder and not (is_joint and written == (stamp, pose)):
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

    Without the edge of a sensor that moves, which is stated at each scan.
    """
    log, frame = sensor.log, sensor.frame
    edges = [] if base == frame or sensor.moves_on(base) else [(base, frame, log.mount, log.upside_down)]
    if log.bearings is not None and log.n_beams > 1:
        named = zip(sensor.sonar_frames, log.bearings, strict=True)
        edges += [(frame, name, (0.0, 0.0, float(bearing)), False) for name, bearing in named]
    return edges


def _send_scan(topics: Topics, sensor: ExportedSensor, index: int, stamp: int) -> None:
    """Write one scan as the sensor took it, an upside-down one's beams are turned by its frame; and its end points."""
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
    measured = (ranges > 0.0) & (ranges >= log.range_min) & (ranges <= log.range_max)
    points = np.zeros((int(np.count_nonzero(measured)), 3), dtype=np.float32)
    points[:, :2] = sensor.ends(index)[measured]
    topics.send(sensor.points, "sensor_msgs/msg/PointCloud2", stamp, ros2.point_cloud(stamp, sensor.frame, points))


def _send_sonars(topics: Topics, sensor: ExportedSensor, index: int, stamp: int) -> None:
    log = sensor.log
    for topic, frame, reading in zip(sensor.sonars, sensor.sonar_frames, log.ranges[index].tolist(), strict=True):
        message = ros2.range_reading(stamp, frame, log.beam_width, log.range_min, log.range_max, reading)
        topics.send(topic, "sensor_msgs/msg/Range", stamp, message)
