"""Messages plotted over time, each decoded to a row of numbers.

Source: the definitions of sensor_msgs/Imu, sensor_msgs/BatteryState, nav_msgs/Odometry, geometry_msgs/Twist and
geometry_msgs/TwistStamped, in ROS 1 and ROS 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

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
