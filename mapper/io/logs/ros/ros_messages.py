"""Decoding of the few ROS message types used for maps.

There is one fixed decoder for each message type below, for both serialisations: ROS 1's, and CDR (ROS 2). A library
that decodes any message uses the definition in the file. Here no definition is ever read from a file, so none can
redefine a type, refer to itself or claim ``string[1000000]``, and every length is checked against the available bytes
before it is used. The tests compare it with rosbags' decoder.

Source: the message definitions of sensor_msgs, nav_msgs, tf2_msgs and geometry_msgs; the ROS wiki's technical overview
(serialisation of ROS 1); OMG DDSI-RTPS, 10 (CDR and its encapsulation header); REP 117.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields, Pose7

MOST_ECHOES = 1 << 21  #: of one message, including intensities; more would not be a scan, and need gigabytes
MOST_TRANSFORMS = 1 << 14  #: of one message


@dataclass(frozen=True, slots=True)
class Beams:
    """One reading of a range sensor: ``ranges`` (n_beams,) float32 metres, beam i at ``angle_min + i · increment``.

    ``beam_width`` is the opening of a sonar's cone in radians, 0 for a lidar. ``time_increment`` (s/beam) and
    ``scan_time`` (s) are as stated, possibly NaN, as is ``angle_max``, which may contradict the others. ``mount`` is
    ``T_base_scan`` (m, m, rad) of a scan extracted from a cloud; for all others it comes from tf.
    """

    stamp_ns: int
    frame: str
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]
    beam_width: float = 0.0
    time_increment: float = 0.0
    scan_time: float = 0.0
    mount: tuple[float, float, float] | None = None
    angle_max: float = math.nan


@dataclass(frozen=True, slots=True)
class StampedPose:
    """``T_frame_child`` at a time, and the stated speed, m/s, 0 if not stated."""

    stamp_ns: int
    frame: str
    child: str
    pose: Pose7
    speed: float = 0.0


def laser_scan(data: bytes, *, cdr: bool) -> Beams:
    """Decode a sensor_msgs/LaserScan."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    angle_min, angle_max, increment, time_increment, scan_time, range_min, range_max = fields.unpack("7f", 4)
    ranges = fields.floats()
    fields.floats()  # intensities
    fields.end()
    return Beams(
        stamp,
        frame,
        angle_min,
        increment,
        range_min,
        range_max,
        ranges.astype(np.float32),
        time_increment=time_increment,
        scan_time=scan_time,
        angle_max=angle_max,
    )


def multi_echo_scan(data: bytes, *, cdr: bool) -> Beams:
    """Decode a sensor_msgs/MultiEchoLaserScan: each beam's first echo; a beam without echoes is no return, +inf."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    angle_min, angle_max, increment, time_increment, scan_time, range_min, range_max = fields.unpack("7f", 4)
    return Beams(
        stamp,
        frame,
        angle_min,
        increment,
        range_min,
        range_max,
        _first_echoes(fields),
        time_increment=time_increment,
        scan_time=scan_time,
        angle_max=angle_max,
    )


def _first_echoes(fields: MessageFields) -> NDArray[np.float32]:
    n = fields.count(4)
    rest = (len(fields.data) - fields.pos) // 4
    if rest >= MOST_ECHOES:
        raise BadMessageError
    readings = np.frombuffer(fields.data, fields.order + "f4", rest, fields.pos)
    lengths = np.frombuffer(fields.data, fields.order + "u4", rest, fields.pos).tolist()
    firsts = np.zeros(n, dtype=np.int64)  #: index of each beam's first echo, after the number of its echoes
    at = 0
    for beam in range(n):
        if at >= rest:
            raise BadMessageError
        firsts[beam] = at + 1 if lengths[at] else -1
        at += 1 + lengths[at]
    if at > rest:
        raise BadMessageError
    ranges = np.full(n, np.inf, dtype=np.float32)
    ranges[firsts >= 0] = readings[firsts[firsts >= 0]]
    return ranges


def range_reading(data: bytes, *, cdr: bool) -> Beams:
    """Decode a sensor_msgs/Range: one beam straight ahead, as wide as its field of view."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    fields.unpack("B", 1)  # ultrasound or infrared
    width, range_min, range_max, reading = fields.unpack("4f", 4)
    fields.end(at_most=4)  # newer ones have a variance
    return Beams(stamp, frame, 0.0, 0.0, range_min, range_max, np.array([reading], dtype=np.float32), width)


def odometry(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a nav_msgs/Odometry."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    child = fields.frame()
    pose = fields.pose()
    x, y = fields.unpack("78d", 8)[36:38]  # after its covariance; then the twist's covariance
    fields.end()
    return [StampedPose(stamp, frame, child, pose, math.hypot(x, y))]


def pose_with_covariance(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a geometry_msgs/PoseWithCovarianceStamped."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    pose = fields.pose()
    fields.unpack("36d", 8)
    fields.end()
    return [StampedPose(stamp, frame, "", pose)]


def pose_stamped(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a geometry_msgs/PoseStamped."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    pose = fields.pose()
    fields.end()
    return [StampedPose(stamp, frame, "", pose)]


def transform_stamped(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a geometry_msgs/TransformStamped."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    child = fields.frame()
    pose = fields.pose()
    fields.end()
    return [StampedPose(stamp, frame, child, pose)]


def pose(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a geometry_msgs/Pose, which has neither a time nor a frame."""
    fields = MessageFields(data, cdr=cdr)
    stamped = fields.pose()
    fields.end()
    return [StampedPose(0, "", "", stamped)]


def pose_2d(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a geometry_msgs/Pose2D, x, y and theta, which has neither a time nor a frame."""
    fields = MessageFields(data, cdr=cdr)
    x, y, theta = fields.unpack("3d", 8)
    fields.end()
    return [StampedPose(0, "", "", (x, y, 0.0, 0.0, 0.0, math.sin(theta / 2.0), math.cos(theta / 2.0)))]


def path(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a nav_msgs/Path: its poses, in the frame of the path."""
    fields = MessageFields(data, cdr=cdr)
    _, frame = fields.header()
    stamped = []
    for _ in range(fields.count(68)):
        stamp, _ = fields.header()
        stamped.append(StampedPose(stamp, frame, "", fields.pose()))
    fields.end()
    return stamped


@dataclass(frozen=True, slots=True)
class ImuReading:
    """One sensor_msgs/Imu: rad/s, m/s², and the quaternion x y z w, NaN without orientation."""

    stamp_ns: int
    frame: str
    orientation: tuple[float, ...]
    angular_velocity: tuple[float, ...]
    linear_acceleration: tuple[float, ...]


def imu(data: bytes, *, cdr: bool) -> ImuReading:
    """Decode a sensor_msgs/Imu."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    orientation = fields.unpack("4d", 8)
    covariance = fields.unpack("9d", 8)
    rates = fields.unpack("3d", 8)
    fields.unpack("9d", 8)
    accelerations = fields.unpack("3d", 8)
    fields.unpack("9d", 8)
    fields.end()
    # A covariance that starts with −1 means no orientation.
    return ImuReading(stamp, frame, (math.nan,) * 4 if covariance[0] == -1.0 else orientation, rates, accelerations)


def transforms(data: bytes, *, cdr: bool) -> list[StampedPose]:
    """Decode a tf2_msgs/TFMessage, or tf/tfMessage of ROS 1."""
    fields = MessageFields(data, cdr=cdr)
    stamped = []
    n = fields.count(72)
    if n > MOST_TRANSFORMS:
        raise BadMessageError
    for _ in range(n):
        stamp, frame = fields.header()
        child = fields.frame()
        stamped.append(StampedPose(stamp, frame, child, fields.pose()))
    fields.end()
    return stamped


PATH = "nav_msgs/Path"
WITHOUT_HEADER = ("geometry_msgs/Pose", "geometry_msgs/Pose2D")  #: types of poses without time and frame
#: Type, without the ``msg`` inserted by ROS 2 → decoder.
SENSORS = {
    "sensor_msgs/LaserScan": laser_scan,
    "sensor_msgs/MultiEchoLaserScan": multi_echo_scan,
    "sensor_msgs/Range": range_reading,
}
POSES = {
    "nav_msgs/Odometry": odometry,
    "geometry_msgs/PoseWithCovarianceStamped": pose_with_covariance,
    "geometry_msgs/PoseStamped": pose_stamped,
    "geometry_msgs/TransformStamped": transform_stamped,
    PATH: path,
    "geometry_msgs/Pose": pose,
    "geometry_msgs/Pose2D": pose_2d,
}
TRANSFORMS = {"tf2_msgs/TFMessage": transforms, "tf/tfMessage": transforms}


def plain_type(name: str) -> str:
    """Return ``sensor_msgs/LaserScan`` for ``sensor_msgs/msg/LaserScan`` and ``sensor_msgs::msg::dds_::LaserScan_``."""
    if "::" in name:
        name = name.replace("::", "/").removesuffix("_")
    package, _, rest = name.partition("/")
    return f"{package}/{rest.rsplit('/', 1)[-1]}" if rest else name
