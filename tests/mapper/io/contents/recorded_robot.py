"""A recording of a robot with a lidar, an IMU, odometry, a battery and commands, as rosbags writes them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said

T0 = 1_700_000_000 * SECOND


def imu(stamp_ns: int, rate: float, ahead: float, yaw: float, *, oriented: bool = True) -> Said:
    covariance = np.zeros(9) if oriented else np.array([-1.0, *np.zeros(8)])
    fields = {
        "header": recorded.header(stamp_ns, "imu"),
        "orientation": recorded.quaternion(yaw),
        "orientation_covariance": covariance,
        "angular_velocity": {"x": 0.0, "y": 0.0, "z": rate},
        "angular_velocity_covariance": np.zeros(9),
        "linear_acceleration": {"x": ahead, "y": 0.0, "z": 9.81},
        "linear_acceleration_covariance": np.zeros(9),
    }
    return Said("/imu", "sensor_msgs/msg/Imu", stamp_ns, fields)


def battery(stamp_ns: int, voltage: float, charge: float) -> Said:
    fields = {
        "header": recorded.header(stamp_ns, "base_link"),
        "voltage": voltage,
        "temperature": 30.5,
        "current": -1.5,
        "charge": math.nan,
        "capacity": math.nan,
        "design_capacity": math.nan,
        "percentage": charge,
        "power_supply_status": 2,
        "power_supply_health": 1,
        "power_supply_technology": 3,
        "present": True,
        "cell_voltage": np.array([3.7, 3.8, 3.9], dtype=np.float32),
        "cell_temperature": np.zeros(0, dtype=np.float32),
        "location": "slot 1",
        "serial_number": "B7",
    }
    return Said("/battery", "sensor_msgs/msg/BatteryState", stamp_ns, fields)


def command(stamp_ns: int, ahead: float, turning: float) -> Said:
    fields = {"linear": {"x": ahead, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": turning}}
    return Said("/cmd_vel", "geometry_msgs/msg/Twist", stamp_ns, fields)


def robot(seconds: int = 4) -> Iterator[Said]:
    """Scans at 10 Hz, IMU at 20 Hz, odometry and tf at 10 Hz, a battery and commands at 1 Hz, one static transform."""
    yield recorded.transform(T0, "base_link", "laser", 0.2, topic="/tf_static")
    for step in range(20 * seconds):
        at = T0 + step * SECOND // 20
        yield imu(at, 0.1 * math.sin(step), 0.5, 0.01 * step)
        if step % 2 == 0:
            yield recorded.scan(at, np.full(20, 2.0))
            yield recorded.odometry(at, 0.05 * step, 0.0, 0.0)
            yield recorded.transform(at, "odom", "base_link", 0.05 * step)
        if step % 20 == 0:
            yield battery(at, 12.0 - 0.01 * step, 0.9)
            yield command(at, 0.5, -0.25)
