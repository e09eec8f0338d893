"""Example logs for visitors without logs, as the files that a robot would have recorded in simulated runs."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from mapper import simulation
from mapper.core.array_types import Float64Array, UInt8Array
from mapper.io import export
from mapper.sensors.scan import LaserScan

ExampleName: TypeAlias = Literal["drift", "mount", "camera"]

#: File name of each.
FILES: dict[ExampleName, str] = {
    "drift": "simulated-drift.mcap",
    "mount": "simulated-wrong-mount.mcap",
    "camera": "simulated-camera-and-3d-lidar.mcap",
}
STATED_YAW = math.radians(6.0)  #: of the lidar of "mount", which is actually aligned with the robot
SCANS = 160  #: of "camera", with a cloud and an image at every second scan
_LIDAR, _CAMERA = "lidar_3d", "camera"
_FLOOR_M = 0.03  #: anything lower is drawn as floor
_STRIPE_M = 0.5  #: width of the stripes on walls, which make the robot's motion visible


def example_bytes(name: ExampleName) -> bytes:
    """Return the file of an example, which is always the same."""
    makers: dict[ExampleName, Callable[[], bytes]] = {"drift": _drift, "mount": _mount, "camera": _camera}
    return makers[name]()


def _drift() -> bytes:
    """Return a log whose only poses are those measured by the wheels, which drift."""
    file = io.BytesIO()
    export.write_mcap(file, simulation.sample_log(), trajectory="odometry")
    return file.getvalue()


def _mount() -> bytes:
    """Return a log with true poses, whose stated mount is rotated by :data:`STATED_YAW`."""
    file = io.BytesIO()
    export.write_mcap(file, replace(simulation.sample_log(), mount=(0.0, 0.0, STATED_YAW)), trajectory="true")
    return file.getvalue()


def _camera() -> bytes:
    """Return a log with true poses, a planar lidar, and at every second scan a 3D lidar's cloud and an image."""
    from mcap.writer import CompressionType, Writer  # noqa: PLC0415 - as above

    from mapper.io.export import ros2  # noqa: PLC0415
    from mapper.io.export.topics import Topics  # noqa: PLC0415
    from mapper.simulation.sensors_3d import Scan3D, Sensor3D, measure_3d  # noqa: PLC0415

    log, world, rng = simulation.sample_log(SCANS), simulation.WORLDS["office"], np.random.default_rng(3)
    lidar = Sensor3D(beams=240)
    camera = Sensor3D(sensor="depth_camera", columns=160, tilt=0.1, noise=0.0, reach=20.0)
    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start("ros2", "gridbloom")
    topics = Topics(writer, frozenset({"/tf_static"}))
    first = int(log.stamps_ns[0])
    for sensor, frame in ((lidar, _LIDAR), (camera, _CAMERA)):
        raised = ros2.raised(first, "base_link", frame, sensor.mount_height)
        topics.send("/tf_static", "tf2_msgs/msg/TFMessage", first, raised)
    edges = [("base_link", "laser", (0.0, 0.0, 0.0), False)]
    topics.send("/tf_static", "tf2_msgs/msg/TFMessage", first, ros2.transforms(first, edges))
    for index, (stamp, pose) in enumerate(zip(log.stamps_ns.tolist(), log.trajectory("true").poses, strict=True)):
        x, y, yaw = pose.tolist()
        moved = ros2.transforms(stamp, [("odom", "base_link", (x, y, yaw), False)])
        topics.send("/tf", "tf2_msgs/msg/TFMessage", stamp, moved)
        scan = log.scan(index)
        assert isinstance(scan, LaserScan)  # noqa: S101 - for the type checker
        topics.send("/scan", "sensor_msgs/msg/LaserScan", stamp, ros2.laser_scan(stamp, "laser", scan))
        if index % 2:
            continue
        ranges = measure_3d(world, lidar, pose, rng)
        returned = np.isfinite(ranges)
        points = (lidar.directions[returned] * ranges[returned, None]).astype(np.float32)
        topics.send("/lidar/points", "sensor_msgs/msg/PointCloud2", stamp, ros2.point_cloud(stamp, _LIDAR, points))
        seen = Scan3D(camera, measure_3d(world, camera, pose, rng), (x, y, yaw), stamp * 1e-9)
        pixels = _picture(seen.ends()[0], seen.ranges.astype(np.float64)).reshape(-1, camera.columns, 3)
        topics.send("/camera/image", "sensor_msgs/msg/Image", stamp, ros2.image(stamp, _CAMERA, pixels))
    writer.finish()  # type: ignore[no-untyped-call] # mcap's writer has no types there
    return file.getvalue()


def _picture(ends: Float64Array, ranges: Float64Array) -> UInt8Array:
    """Return the colours (n, 3) of pixels that see ``ends`` (n, 3), metres, at ``ranges`` (n,), +inf for none.

    Floors are brown, walls have stripes, and both are darker farther away.
    """
    stripe = np.floor((ends[:, 0] + ends[:, 1]) / _STRIPE_M) % 2.0
    walls = np.array([150.0, 165.0, 180.0]) + 45.0 * stripe[:, None]
    colours = np.where(ends[:, 2:] < _FLOOR_M, np.array([150.0, 120.0, 90.0]), walls)
    near = 1.0 / (1.0 + 0.15 * np.where(np.isfinite(ranges), ranges, np.inf))
    return np.round(colours * near[:, None]).astype(np.uint8)
