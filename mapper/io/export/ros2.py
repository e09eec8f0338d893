"""ROS 2 messages for exported logs, maps and costmaps: definitions, and serialisation (CDR, little-endian).

Source: the message definitions of ROS 2 (nav_msgs, nav2_msgs, sensor_msgs, geometry_msgs, tf2_msgs, std_msgs,
builtin_interfaces); OMG DDSI-RTPS, 10. A definition embedded in a file contains the definitions it uses, each after a
line of 80 ``=``: mcap.dev/spec/registry, ros2msg.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.io.logs.ros.cdr_writer import SECOND, CdrWriter
from mapper.sensors.scan import LaserScan

LAST_STAMP_NS = (2**31 - 1) * SECOND  #: ROS 2 counts seconds in 32 bits
Pose = tuple[float, float, float]  #: x, y, yaw
_FLOAT32 = 7  #: number type of sensor_msgs/PointField

_PARTS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "sensor_msgs/PointField": (
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
        "uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count"
    ),
    "nav_msgs/MapMetaData": (
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
        "geometry_msgs/Pose origin"
    ),
    "nav2_msgs/CostmapMetaData": (
        "builtin_interfaces/Time map_load_time\nbuiltin_interfaces/Time update_time\nstring layer\n"
        "float32 resolution\nuint32 size_x\nuint32 size_y\ngeometry_msgs/Pose origin"
    ),
}
_MESSAGES = {
    "nav_msgs/msg/OccupancyGrid": "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data",
    "nav2_msgs/msg/Costmap": "std_msgs/Header header\nnav2_msgs/CostmapMetaData metadata\nuint8[] data",
    "geometry_msgs/msg/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "sensor_msgs/msg/LaserScan": (
        "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
        "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
        "float32[] ranges\nfloat32[] intensities"
    ),
    "sensor_msgs/msg/PointCloud2": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
        "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense"
    ),
    "sensor_msgs/msg/Image": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n"
        "uint8[] data"
    ),
    "sensor_msgs/msg/Range": (
        "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\n"
        "float32 min_range\nfloat32 max_range\nfloat32 range"
    ),
}


def definition(kind: str) -> str:
    """Return the definition of a message type, including all definitions it uses."""
    text = _MESSAGES[kind]
    named: list[str] = []
    lines = text.splitlines()
    while lines:
        part = lines.pop(0).split()[0].removesuffix("[]")
        if part in _PARTS and part not in named:
            named.append(part)
            lines += _PARTS[part].splitlines()
    return text + "".join(f"\n{'=' * 80}\nMSG: {part}\n{_PARTS[part]}" for part in named) + "\n"


class _Bytes(CdrWriter):
    """A message with planar poses."""

    def pose(self, pose: Pose, *, z: float = 0.0, upside_down: bool = False) -> _Bytes:
        x, y, yaw = pose
        sin, cos = float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0))
        # First flipped about its x axis, then rotated about z.
        turn = (cos, sin, 0.0, 0.0) if upside_down else (0.0, 0.0, sin, cos)
        return self.pack("d", 8, x, y, z, *turn)


def occupancy_grid(stamp_ns: int, frame: str, resolution: float, origin: Pose, values: NDArray[np.int8]) -> bytes:
    """Return a nav_msgs/OccupancyGrid of ``values`` (rows, cols), row 0 at the smallest y: 0 … 100, −1 unknown."""
    rows, cols = values.shape
    seconds, nanoseconds = divmod(stamp_ns, SECOND)
    out = _Bytes().header(stamp_ns, frame).pack("i", 4, seconds).pack("I", 4, nanoseconds)
    return out.pack("f", 4, resolution).pack("I", 4, cols, rows).pose(origin).array(values.ravel()).message


def costmap(stamp_ns: int, frame: str, layer: str, resolution: float, origin: Pose, costs: NDArray[np.uint8]) -> bytes:
    """Return a nav2_msgs/Costmap of ``costs`` (rows, cols), row 0 at the smallest y: 0 … 255."""
    rows, cols = costs.shape
    seconds, nanoseconds = divmod(stamp_ns, SECOND)
    out = _Bytes().header(stamp_ns, frame)
    for _ in range(2):
        out.pack("i", 4, seconds).pack("I", 4, nanoseconds)
    out.string(layer).pack("f", 4, resolution).pack("I", 4, cols, rows).pose(origin)
    return out.array(costs.ravel()).message


def pose_stamped(stamp_ns: int, frame: str, pose: Pose) -> bytes:
    """Return a geometry_msgs/PoseStamped."""
    return _Bytes().header(stamp_ns, frame).pose(pose).message


def transforms(stamp_ns: int, edges: Sequence[tuple[str, str, Pose, bool]]) -> bytes:
    """Return a tf2_msgs/TFMessage of edges (parent, child, ``T_parent_child``, whether the child is upside-down)."""
    out = _Bytes().pack("I", 4, len(edges))
    for parent, child, pose, upside_down in edges:
        out.header(stamp_ns, parent).string(child).pose(pose, upside_down=upside_down)
    return out.message


def raised(stamp_ns: int, parent: str, child: str, z: float) -> bytes:
    """Return a tf2_msgs/TFMessage of one edge: ``child`` is ``z`` metres above ``parent``."""
    return _Bytes().pack("I", 4, 1).header(stamp_ns, parent).string(child).pose((0.0, 0.0, 0.0), z=z).message


def laser_scan(stamp_ns: int, frame: str, scan: LaserScan) -> bytes:
    """Return a sensor_msgs/LaserScan."""
    last = scan.angle_min + scan.angle_increment * max(0, len(scan.ranges) - 1)
    out = _Bytes().header(stamp_ns, frame)
    out.pack("f", 4, scan.angle_min, last, scan.angle_increment, scan.time_increment, scan.scan_time)
    out.pack("f", 4, scan.range_min, scan.range_max)
    return out.array(scan.ranges).pack("I", 4, 0).message


def point_cloud(stamp_ns: int, frame: str, points: NDArray[np.float32]) -> bytes:
    """Return a sensor_msgs/PointCloud2 of ``points`` (n, 3): x, y, z in metres, in one row."""
    out = _Bytes().header(stamp_ns, frame).pack("I", 4, 1, len(points), 3)
    for axis, name in enumerate("xyz"):
        out.string(name).pack("I", 4, 4 * axis).pack("B", 1, _FLOAT32).pack("I", 4, 1)
    out.pack("B", 1, 0).pack("I", 4, 12, 12 * len(points))
    return out.array(points.ravel().view(np.uint8)).pack("B", 1, 1).message


def image(stamp_ns: int, frame: str, pixels: NDArray[np.uint8]) -> bytes:
    """Return a sensor_msgs/Image of ``pixels`` (rows, cols, 3): red, green, blue, row 0 at the top."""
    rows, cols, _ = pixels.shape
    out = _Bytes().header(stamp_ns, frame).pack("I", 4, rows, cols).string("rgb8").pack("B", 1, 0)
    return out.pack("I", 4, 3 * cols).array(pixels.ravel()).message


def range_reading(stamp_ns: int, frame: str, width: float, range_min: float, range_max: float, reading: float) -> bytes:
    """Return a sensor_msgs/Range of an ultrasound sensor."""
    out = _Bytes().header(stamp_ns, frame).pack("B", 1, 0)
    return out.pack("f", 4, width, range_min, range_max, reading).message
