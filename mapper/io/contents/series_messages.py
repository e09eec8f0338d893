"""Messages plotted over time, each decoded to a row of numbers.

The speeds of an odometry whose messages state none, as drivers that measure none leave them at zero, are those of its
poses. Source: the definitions of sensor_msgs/Imu, sensor_msgs/BatteryState, nav_msgs/Odometry, whose twist is in the
frame of the base, geometry_msgs/Twist and geometry_msgs/TwistStamped, in ROS 1 and ROS 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.contents.model import Column
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.io.logs.ros.ros_messages import imu

ODOMETRY = "nav_msgs/Odometry"

Row = tuple[int, list[float]]  #: the stamp stated by the message, ns, 0 for none, and its numbers


def _imu(data: bytes, *, cdr: bool) -> Row:
    message = imu(data, cdr=cdr)
    return message.stamp_ns, [*message.angular_velocity, *message.linear_acceleration, _yaw(message.orientation)]


def _odometry(data: bytes, *, cdr: bool) -> Row:
    fields = MessageFields(data, cdr=cdr)
    stamp, _ = fields.header()
    fields.frame()
    x, y, _, *quaternion = fields.pose()
    fields.unpack("36d", 8)
    vx, vy, _, _, _, turning = fields.unpack("6d", 8)
    fields.unpack("36d", 8)
    fields.end()
    return stamp, [vx, vy, turning, x, y, _yaw(tuple(quaternion))]


def _twist(data: bytes, *, cdr: bool) -> Row:
    fields = MessageFields(data, cdr=cdr)
    return 0, _velocities(fields)


def _twist_stamped(data: bytes, *, cdr: bool) -> Row:
    fields = MessageFields(data, cdr=cdr)
    stamp, _ = fields.header()
    return stamp, _velocities(fields)


def _velocities(fields: MessageFields) -> list[float]:
    vx, vy, _, _, _, turning = fields.unpack("6d", 8)
    fields.end()
    return [vx, vy, turning]


def _battery(data: bytes, *, cdr: bool) -> Row:
    try:
        return _battery_of(data, cdr=cdr, has_temperature=True)
    except BadMessageError:
        if cdr:
            raise
        return _battery_of(data, cdr=cdr, has_temperature=False)  # as defined by ROS 1 before Noetic


def _battery_of(data: bytes, *, cdr: bool, has_temperature: bool) -> Row:
    fields = MessageFields(data, cdr=cdr)
    stamp, _ = fields.header()
    (voltage,) = fields.unpack("f", 4)
    temperature = fields.unpack("f", 4)[0] if has_temperature else math.nan
    current, _, _, _, percentage = fields.unpack("5f", 4)
    fields.unpack("4B", 1)  # status, health, technology, present
    fields.floats()
    if has_temperature:
        fields.floats()
    fields.string()
    fields.string()
    fields.end()
    return stamp, [voltage, current, 100.0 * percentage, temperature]


def _yaw(quaternion: tuple[float, ...]) -> float:
    x, y, z, w = quaternion
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


_TWIST = (
    Column("forward", "m/s", "speed"),
    Column("sideways", "m/s", "speed"),
    Column("turning", "rad/s", "turn rate"),
)


@dataclass(frozen=True, slots=True)
class PlottedType:
    """Plotted fields of a message type, and the function that decodes it, which raises :class:`BadMessageError`."""

    columns: tuple[Column, ...]
    decode: Callable[..., Row]


#: Type, without the ``msg`` inserted by ROS 2 → its plotted fields.
PLOTTED: dict[str, PlottedType] = {
    "sensor_msgs/Imu": PlottedType(
        (
            *(Column(axis, "rad/s", "angular velocity") for axis in "xyz"),
            *(Column(axis, "m/s²", "acceleration") for axis in "xyz"),
            Column("yaw", "rad", "orientation"),
        ),
        _imu,
    ),
    ODOMETRY: PlottedType(
        (
            *_TWIST,
            Column("x", "m", "position"),
            Column("y", "m", "position"),
            Column("yaw", "rad", "heading"),
        ),
        _odometry,
    ),
    "geometry_msgs/Twist": PlottedType(_TWIST, _twist),
    "geometry_msgs/TwistStamped": PlottedType(_TWIST, _twist_stamped),
    "sensor_msgs/BatteryState": PlottedType(
        (
            Column("voltage", "V", "voltage"),
            Column("current", "A", "current"),
            Column("charge", "%", "charge"),
            Column("temperature", "°C", "temperature"),
        ),
        _battery,
    ),
}


MOST = 3.0e38  #: larger speeds do not fit into float32
FROM_POSES = "from poses"  #: suffix of the names of such speeds


def states_speeds(rows: Float64Array) -> bool:
    """Return whether odometry states speeds, or never moves.

    ``rows`` (n, 6) are forward and sideways (m/s), turning (rad/s), x and y (m), yaw (rad) of each message.
    """
    speeds, poses = rows[:, :3], rows[:, 3:]
    return bool((np.nan_to_num(speeds) != 0.0).any() or (poses == poses[:1]).all())


def pose_speeds(stamps_ns: NDArray[np.int64], poses: Float64Array) -> Float64Array:
    """Return forward and sideways (m/s) and turning (rad/s) speeds, (n, 3), of poses (n, 3) since the previous one.

    ``stamps_ns`` (n,) ascend. NaN for the first pose, for a pose at the time of the previous one, and for speeds above
    :data:`MOST`.
    """
    seconds = np.diff(stamps_ns) * 1e-9
    moved = compose(inverse(poses[:-1]), poses[1:])
    # On an arc the robot moves along the mean of the two headings.
    half = 0.5 * moved[:, 2]
    cos, sin = np.cos(half), np.sin(half)
    x, y = moved[:, 0], moved[:, 1]
    steps = np.column_stack([cos * x + sin * y, cos * y - sin * x, wrap_angle(moved[:, 2])])
    speeds = np.full((len(poses), 3), np.nan)
    passed = seconds > 0.0
    speeds[1:][passed] = steps[passed] / seconds[passed, None]
    speeds[np.abs(speeds) > MOST] = np.nan
    return speeds


def from_poses(columns: tuple[Column, ...]) -> tuple[Column, ...]:
    """Return the columns of odometry with the names of speeds computed from its poses."""
    return tuple(replace(column, label=f"{column.label} {FROM_POSES}") for column in columns[:3]) + columns[3:]
