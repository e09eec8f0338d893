"""Recordings written by other tools' writers (rosbags for bags and db3, mcap for MCAP), and the messages in them."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import mcap.writer
import numpy as np
from mcap.writer import CompressionType
from numpy.typing import ArrayLike
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

SECOND = 1_000_000_000
KINDS = ("bag", "db3", "mcap")


@cache
def store(ros: int) -> Typestore:
    if ros == 2:
        return get_typestore(Stores.ROS2_HUMBLE)
    noetic = get_typestore(Stores.ROS1_NOETIC)  # which knows tf, but not tf2
    noetic.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    return noetic


@dataclass
class Said:
    """One message: where, of what type, when recorded, and the message as rosbags' class of ROS 1 or 2."""

    topic: str
    kind: str
    stamp_ns: int
    fields: dict[str, Any]


def _time(stamp_ns: int) -> dict[str, Any]:
    return {"sec": stamp_ns // SECOND, "nanosec": stamp_ns % SECOND}


def header(stamp_ns: int, frame: str) -> dict[str, Any]:
    return {"stamp": _time(stamp_ns), "frame_id": frame}


def scan(
    stamp_ns: int,
    ranges: ArrayLike,
    topic: str = "/scan",
    frame: str = "laser",
    angles: tuple[float, float] = (-1.5, 0.1),
    limits: tuple[float, float] = (0.1, 30.0),
) -> Said:
    readings = np.asarray(ranges, dtype=np.float32)
    fields = {
        "header": header(stamp_ns, frame),
        "angle_min": angles[0],
        "angle_max": angles[0] + angles[1] * (len(readings) - 1),
        "angle_increment": angles[1],
        "time_increment": 0.0,
        "scan_time": 0.1,
        "range_min": limits[0],
        "range_max": limits[1],
        "ranges": readings,
        "intensities": np.zeros(0, dtype=np.float32),
    }
    return Said(topic, "sensor_msgs/msg/LaserScan", stamp_ns, fields)


def echoes(stamp_ns: int, beams: Sequence[Sequence[float]], topic: str = "/echoes", frame: str = "laser") -> Said:
    said = scan(stamp_ns, np.zeros(len(beams)), topic, frame)
    rows = [{"echoes": np.array(row, dtype=np.float32)} for row in beams]
    return Said(
        topic, "sensor_msgs/msg/MultiEchoLaserScan", stamp_ns, said.fields | {"ranges": rows, "intensities": rows}
    )


def sonar(stamp_ns: int, reading: float, topic: str = "/sonar", frame: str = "sonar", width: float = 0.5) -> Said:
    fields = {
        "header": header(stamp_ns, frame),
        "radiation_type": 0,
        "field_of_view": width,
        "min_range": 0.02,
        "max_range": 4.0,
        "range": reading,
    }
    return Said(topic, "sensor_msgs/msg/Range", stamp_ns, fields)


def quaternion(yaw: float = 0.0, roll: float = 0.0) -> dict[str, float]:
    """The rotation that first rolls about x, then yaws about z."""
    cy, sy, cr, sr = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(roll / 2), np.sin(roll / 2)
    return {"x": cy * sr, "y": sy * sr, "z": sy * cr, "w": cy * cr}


def _pose(x: float, y: float, yaw: float) -> dict[str, Any]:
    return {"position": {"x": x, "y": y, "z": 0.0}, "orientation": quaternion(yaw)}


def odometry(
    stamp_ns: int,
    x: float,
    y: float,
    yaw: float,
    topic: str = "/odom",
    *,
    frame: str = "odom",
    child: str = "base_link",
) -> Said:
    zeros = np.zeros(36)
    nothing = {"x": 0.0, "y": 0.0, "z": 0.0}
    fields = {
        "header": header(stamp_ns, frame),
        "child_frame_id": child,
        "pose": {"pose": _pose(x, y, yaw), "covariance": zeros},
        "twist": {"twist": {"linear": nothing, "angular": nothing}, "covariance": zeros},
    }
    return Said(topic, "nav_msgs/msg/Odometry", stamp_ns, fields)


def estimate(stamp_ns: int, x: float, y: float, yaw: float, topic: str = "/amcl_pose") -> Said:
    fields = {"header": header(stamp_ns, "map"), "pose": {"pose": _pose(x, y, yaw), "covariance": np.zeros(36)}}
    return Said(topic, "geometry_msgs/msg/PoseWithCovarianceStamped", stamp_ns, fields)


def pose_stamped(stamp_ns: int, x: float, y: float, yaw: float, topic: str = "/pose", frame: str = "map") -> Said:
    fields = {"header": header(stamp_ns, frame), "pose": _pose(x, y, yaw)}
    return Said(topic, "geometry_msgs/msg/PoseStamped", stamp_ns, fields)


def bare_pose(stamp_ns: int, x: float, y: float, yaw: float, topic: str = "/robot_pose") -> Said:
    return Said(topic, "geometry_msgs/msg/Pose", stamp_ns, _pose(x, y, yaw))


def pose_2d(stamp_ns: int, x: float, y: float, yaw: float, topic: str = "/pose2D") -> Said:
    return Said(topic, "geometry_msgs/msg/Pose2D", stamp_ns, {"x": x, "y": y, "theta": yaw})


def pose_array(stamp_ns: int, poses: Iterable[tuple[float, float, float]], topic: str = "/particlecloud") -> Said:
    fields = {"header": header(stamp_ns, "map"), "poses": [_pose(*one) for one in poses]}
    return Said(topic, "geometry_msgs/msg/PoseArray", stamp_ns, fields)


def transform_stamped(
    stamp_ns: int, x: float, y: float, yaw: float, topic: str = "/vicon/robot", child: str = "robot"
) -> Said:
    place = {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": quaternion(yaw)}
    fields = {"header": header(stamp_ns, "world"), "child_frame_id": child, "transform": place}
    return Said(topic, "geometry_msgs/msg/TransformStamped", stamp_ns, fields)


def path(stamp_ns: int, poses: Iterable[Said], topic: str = "/trajectory", frame: str = "map") -> Said:
    """The nav_msgs/Path of poses as :func:`pose_stamped` makes them."""
    fields = {"header": header(stamp_ns, frame), "poses": [one.fields for one in poses]}
    return Said(topic, "nav_msgs/msg/Path", stamp_ns, fields)


def transform(
    stamp_ns: int,
    parent: str,
    child: str,
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    roll: float = 0.0,
    *,
    z: float = 0.0,
    topic: str = "/tf",
) -> Said:
    one = {
        "header": header(stamp_ns, parent),
        "child_frame_id": child,
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": quaternion(yaw, roll)},
    }
    return Said(topic, "tf2_msgs/msg/TFMessage", stamp_ns, {"transforms": [one]})


def text(stamp_ns: int, words: str, topic: str = "/chatter") -> Said:
    return Said(topic, "std_msgs/msg/String", stamp_ns, {"data": words})


DATATYPES = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}


def log_line(stamp_ns: int, level: int, words: str, node: str = "base", *, ros: int = 2) -> Said:
    """A message of /rosout, of ``level`` as that version of ROS has it."""
    fields: dict[str, Any] = {"level": level, "name": node, "msg": words, "file": "a.cpp", "function": "f", "line": 7}
    if ros == 2:
        return Said("/rosout", "rcl_interfaces/msg/Log", stamp_ns, fields | {"stamp": _time(stamp_ns)})
    fields |= {"header": header(stamp_ns, ""), "topics": []}
    return Said("/rosout", "rosgraph_msgs/msg/Log", stamp_ns, fields)


def diagnostics(stamp_ns: int, states: Mapping[str, tuple[int, str]]) -> Said:
    """A message of /diagnostics: a level and a text for each name."""
    status = [
        {"level": level, "name": name, "message": words, "hardware_id": "1", "values": [{"key": "a", "value": "b"}]}
        for name, (level, words) in states.items()
    ]
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    return Said("/diagnostics", kind, stamp_ns, {"header": header(stamp_ns, ""), "status": status})


def cloud(
    stamp_ns: int,
    points: ArrayLike,
    topic: str = "/points",
    frame: str = "velodyne",
    *,
    layout: Sequence[tuple[str, str]] = (("x", "f4"), ("y", "f4"), ("z", "f4")),
    order: str = "<",
    rows: int = 1,
    padding: tuple[int, int] = (0, 0),
    others: Mapping[str, ArrayLike] | None = None,
) -> Said:
    """A cloud of points (n, 3) with fields of these names and types, and bytes of padding after points and rows.

    Fields that are not in ``others``, each (n,), are 1.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(rows, -1, 3)
    width = xyz.shape[1]
    offsets = np.cumsum([0, *(np.dtype(code).itemsize for _, code in layout)]).tolist()
    point_step = offsets[-1] + padding[0]
    data = np.full((rows, width * point_step + padding[1]), 0xAB, dtype=np.uint8)
    for (name, code), offset in zip(layout, offsets, strict=False):
        stated_one = np.asarray((others or {}).get(name, np.ones(rows * width))).reshape(rows, width)
        values = xyz[:, :, "xyz".index(name)] if name in "xyz" else stated_one
        raw = values.astype(np.dtype(order + code))
        view = data[:, : width * point_step].reshape(rows, width, point_step)
        view[:, :, offset : offset + raw.itemsize] = raw.view(np.uint8).reshape(rows, width, raw.itemsize)
    stated = [
        {"name": name, "offset": offset, "datatype": DATATYPES[code], "count": 1}
        for (name, code), offset in zip(layout, offsets, strict=False)
    ]
    fields = {
        "header": header(stamp_ns, frame),
        "height": rows,
        "width": width,
        "fields": stated,
        "is_bigendian": order == ">",
        "point_step": point_step,
        "row_step": data.shape[1],
        "data": data.reshape(-1),
        "is_dense": False,
    }
    return Said(topic, "sensor_msgs/msg/PointCloud2", stamp_ns, fields)


def image(
    stamp_ns: int,
    pixels: ArrayLike,
    encoding: str = "16UC1",
    topic: str = "/camera/depth/image_raw",
    frame: str = "optical",
    *,
    order: str = "<",
    padding: int = 0,
) -> Said:
    """An image of pixels (height, width), in millimetres or metres as the encoding has it."""
    code = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4", "mono8": "u1"}[encoding]
    raw = np.asarray(pixels).astype(np.dtype(order + code))
    height, width = raw.shape
    data = np.zeros((height, width * raw.itemsize + padding), dtype=np.uint8)
    data[:, : width * raw.itemsize] = raw.view(np.uint8)
    fields = {
        "header": header(stamp_ns, frame),
        "height": height,
        "width": width,
        "encoding": encoding,
        "is_bigendian": int(order == ">"),
        "step": data.shape[1],
        "data": data.reshape(-1),
    }
    return Said(topic, "sensor_msgs/msg/Image", stamp_ns, fields)


def camera(
    stamp_ns: int, size: tuple[int, int], focal: float, topic: str = "/camera/depth/camera_info", frame: str = "optical"
) -> Said:
    """The CameraInfo of images of ``size`` (width, height), their centre in the middle."""
    cx, cy = (size[0] - 1) / 2.0, (size[1] - 1) / 2.0
    k = np.array([focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0])
    fields = {
        "header": header(stamp_ns, frame),
        "height": size[1],
        "width": size[0],
        "distortion_model": "plumb_bob",
        "d": np.zeros(5),
        "k": k,
        "r": np.eye(3).reshape(-1),
        "p": np.insert(k, [3, 6, 9], 0.0),
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }
    return Said(topic, "sensor_msgs/msg/CameraInfo", stamp_ns, fields)


_PLAIN = {
    "fields": "sensor_msgs/msg/PointField",
    "roi": "sensor_msgs/msg/RegionOfInterest",
    "header": "std_msgs/msg/Header",
    "stamp": "builtin_interfaces/msg/Time",
    "position": "geometry_msgs/msg/Point",
    "orientation": "geometry_msgs/msg/Quaternion",
    "rotation": "geometry_msgs/msg/Quaternion",
    "translation": "geometry_msgs/msg/Vector3",
    "linear": "geometry_msgs/msg/Vector3",
    "angular": "geometry_msgs/msg/Vector3",
    "angular_velocity": "geometry_msgs/msg/Vector3",
    "linear_acceleration": "geometry_msgs/msg/Vector3",
    "transform": "geometry_msgs/msg/Transform",
    "transforms": "geometry_msgs/msg/TransformStamped",
    "poses": "geometry_msgs/msg/PoseStamped",
    "status": "diagnostic_msgs/msg/DiagnosticStatus",
    "values": "diagnostic_msgs/msg/KeyValue",
}


_FOXGLOVE = {
    "timestamp": "builtin_interfaces/msg/Time",
    "transforms": "foxglove_msgs/msg/FrameTransform",
    "fields": "foxglove_msgs/msg/PackedElementField",
}


def _made(ros: int, kind: str, fields: dict[str, Any]) -> Any:
    """rosbags' message object of ``kind``, its parts made by name."""
    values: dict[str, Any] = {}
    for name, value in fields.items():
        part = (_PLAIN | _FOXGLOVE if kind.startswith("foxglove_msgs/") else _PLAIN).get(name)
        if ros == 1 and kind.endswith("CameraInfo") and len(name) == 1:
            values[name.upper()] = value
            continue
        if name == "pose":
            part = "geometry_msgs/msg/PoseWithCovariance" if "pose" in value else "geometry_msgs/msg/Pose"
        elif name == "twist":
            part = "geometry_msgs/msg/TwistWithCovariance" if "twist" in value else "geometry_msgs/msg/Twist"
        elif isinstance(value, list):
            if kind.endswith("PoseArray"):
                part = "geometry_msgs/msg/Pose"
            part = part or {"points": kind.replace("CustomMsg", "CustomPoint")}.get(name, "sensor_msgs/msg/LaserEcho")
            values[name] = [_made(ros, part, one) for one in value]
            continue
        values[name] = value if part is None else _made(ros, part, value)
    if kind == "std_msgs/msg/Header" and ros == 1:
        values["seq"] = 7
    return store(ros).types[kind](**values)


def serialised(said: Said, ros: int, *, little_endian: bool = True) -> bytes:
    message = _made(ros, said.kind, said.fields)
    if ros == 1:
        return bytes(store(1).serialize_ros1(message, said.kind))
    return bytes(store(2).serialize_cdr(message, said.kind, little_endian=little_endian))


def write_bag(path: Path, messages: Iterable[Said], compression: str = "none") -> Path:
    writer = rosbag1.Writer(path)
    if compression != "none":
        writer.set_compression(rosbag1.Writer.CompressionFormat[compression.upper()])
    with writer:
        known: dict[tuple[str, str], Any] = {}
        for said in messages:
            key = (said.topic, said.kind)
            if key not in known:
                known[key] = writer.add_connection(said.topic, said.kind, typestore=store(1))
            writer.write(known[key], said.stamp_ns, serialised(said, 1))
    return path


def write_rosbag2(
    folder: Path, messages: Iterable[Said], plugin: rosbag2.StoragePlugin, suffix: str, compression: str = "none"
) -> Path:
    """Return the file in the bag's folder that holds the messages; what is compressed is "none", "file", "message" …"""
    writer = rosbag2.Writer(folder, version=9, storage_plugin=plugin)
    if compression != "none":
        writer.set_compression(rosbag2.CompressionMode[compression.upper()], rosbag2.CompressionFormat.ZSTD)
    with writer:
        known: dict[tuple[str, str], Any] = {}
        for said in messages:
            key = (said.topic, said.kind)
            if key not in known:
                known[key] = writer.add_connection(said.topic, said.kind, typestore=store(2))
            writer.write(known[key], said.stamp_ns, serialised(said, 2))
    return next(folder.glob(f"*.{suffix}"))


def mcap_bytes(messages: Iterable[Said], compression: str = "zstd", ros: int = 2, **options: Any) -> bytes:
    out = io.BytesIO()
    writer = mcap.writer.Writer(out, compression=CompressionType[compression.upper()], **options)
    writer.start("ros2" if ros == 2 else "ros1")
    channels: dict[tuple[str, str], int] = {}
    for said in messages:
        key = (said.topic, said.kind)
        if key not in channels:
            definition, _ = store(ros).generate_msgdef(said.kind, ros_version=ros)
            name = said.kind if ros == 2 else said.kind.replace("/msg/", "/")
            schema = writer.register_schema(name, f"ros{ros}msg", definition.encode())
            channels[key] = writer.register_channel(said.topic, "cdr" if ros == 2 else "ros1", schema)
        writer.add_message(channels[key], said.stamp_ns, serialised(said, ros), said.stamp_ns)
    writer.finish()  # type: ignore[no-untyped-call]
    return out.getvalue()


def written(folder: Path, messages: Sequence[Said], kind: str) -> Path:
    """The messages in a file of one of :data:`KINDS`."""
    if kind == "bag":
        return write_bag(folder / "run.bag", messages)
    if kind == "db3":
        return write_rosbag2(folder / "run", messages, rosbag2.StoragePlugin.SQLITE3, "db3")
    path = folder / "run.mcap"
    path.write_bytes(mcap_bytes(messages))
    return path
