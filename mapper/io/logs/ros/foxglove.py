"""Foxglove messages with scans, clouds, transforms and poses, in JSON, Protocol Buffers or as ROS messages, to ROS 2.

If a scan or a cloud states a pose of its origin in its frame, that becomes a transform to a separate frame. Source: the
schemas of foxglove-sdk (LaserScan, PointCloud, FrameTransform, FrameTransforms, PoseInFrame).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np

from mapper.io.logs.ros.cdr_writer import SECOND, CdrWriter
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.io.logs.ros.protobuf import Field, Table, decoded
from mapper.io.logs.ros.ros_messages import plain_type

ENCODINGS = ("json", "protobuf", "cdr", "ros1")
PACKAGES = ("foxglove", "foxglove_msgs")  #: of the schemas, in MCAP files and in ROS
SCAN, CLOUD = "sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"
TF, POSE = "tf2_msgs/TFMessage", "geometry_msgs/PoseStamped"
#: Number types of foxglove.PackedElementField → those of sensor_msgs/PointField.
NUMBERS = {1: 2, 2: 1, 3: 4, 4: 3, 5: 6, 6: 5, 7: 7, 8: 8}
MOST_FIELDS, MOST_TRANSFORMS = 256, 1 << 14
LEAST_OF_A_PART = 9  #: minimum size in bytes of an element of an array of messages
_IN_ROS = {"double": ("d", 8), "fixed32": ("I", 4), "int": ("B", 1)}  #: in a ROS message: code and bytes
LAST_SECOND = 2**31 - 1  #: ROS 2 counts seconds in 32 bits
_XYZ = {1: Field("x", "double"), 2: Field("y", "double"), 3: Field("z", "double")}
_QUATERNION = {**_XYZ, 4: Field("w", "double")}
_TIME = {1: Field("sec", "int"), 2: Field("nsec", "int")}
_POSE = {1: Field("position", _XYZ), 2: Field("orientation", _QUATERNION)}
_HEAD = {1: Field("timestamp", _TIME), 2: Field("frame_id", "string"), 3: Field("pose", _POSE)}
_TRANSFORM = {
    1: Field("timestamp", _TIME),
    2: Field("parent_frame_id", "string"),
    3: Field("child_frame_id", "string"),
    4: Field("translation", _XYZ),
    5: Field("rotation", _QUATERNION),
}
_ELEMENT = {1: Field("name", "string"), 2: Field("offset", "fixed32"), 3: Field("type", "int")}

_USEFUL = frozenset(
    {"LaserScan", "PointCloud2", "PointCloud", "TFMessage", "FrameTransform", "FrameTransforms", "Odometry", "Range"}
)

Values = Mapping[str, Any]
Written = tuple[bytes | None, bytes]  #: a preceding transform, and the message


@dataclass(frozen=True, slots=True)
class Transcoder:
    """Converts a topic's messages of one schema to ROS messages; ``encoding`` is one of :data:`ENCODINGS`."""

    topic: str
    kind: str
    encoding: str
    table: Table
    write: Callable[[str, Values], Written]

    def messages(self, data: bytes) -> Iterator[tuple[bool, bytes]]:
        """Yield the messages in CDR: whether it is an additional transform, and its bytes.

        Raises :class:`BadMessageError`.
        """
        try:
            values = self._values(data)
            beside, message = self.write(self.topic, values)
        except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError, struct.error):
            raise BadMessageError from None
        if beside is not None:
            yield True, beside
        yield False, message

    def _values(self, data: bytes) -> Values:
        if self.encoding == "protobuf":
            return decoded(data, self.table)
        values = json.loads(data) if self.encoding == "json" else _of_ros(data, self.table, cdr=self.encoding == "cdr")
        if not isinstance(values, dict):
            raise BadMessageError
        return values


def transcoder(topic: str, schema: str, encoding: str) -> Transcoder | None:
    """Return a transcoder for a topic's messages; None for an unsupported schema or encoding.

    ``schema`` is a name such as ``foxglove.LaserScan`` or, for ROS, ``foxglove_msgs/msg/LaserScan``.
    """
    package, _, name = plain_type(schema.replace(".", "/")).partition("/")
    known = _SCHEMAS.get(name) if package in PACKAGES else None
    if known is None or encoding not in ENCODINGS:
        return None
    kind, table, write = known
    return Transcoder(topic, kind, encoding, table, write)


def is_of_use(kind: str) -> bool:
    """Return whether messages of a type, such as ``sensor_msgs/LaserScan``, would be read in another serialisation."""
    return kind.rpartition("/")[2].rpartition(".")[2] in _USEFUL


def _of_ros(data: bytes, table: Table, *, cdr: bool) -> dict[str, Any]:
    """Return the values of a foxglove_msgs message; fields appended by newer releases are skipped."""
    return _fields_of_ros(MessageFields(data, cdr=cdr), table)


def _fields_of_ros(fields: MessageFields, table: Table) -> dict[str, Any]:
    """Return the next fields of a ROS message in the order of the table."""
    values: dict[str, Any] = {}
    for number in sorted(table):
        field = table[number]
        kind = field.kind
        if kind is _TIME:
            seconds, nanoseconds = fields.unpack("iI" if fields.cdr else "II", 4)
            values[field.name] = {"sec": int(seconds), "nsec": int(nanoseconds)}
        elif not isinstance(kind, str):
            if not field.repeated:
                values[field.name] = _fields_of_ros(fields, kind)
                continue
            n = fields.count(LEAST_OF_A_PART)
            values[field.name] = [_fields_of_ros(fields, kind) for _ in range(n)]
        elif kind == "string":
            values[field.name] = fields.string()
        elif kind == "bytes":
            values[field.name] = bytes(fields.bytes())
        elif field.repeated:
            n = fields.count(8)
            values[field.name] = fields.unpack(f"{n}d", 8) if n else ()
        else:
            code, size = _IN_ROS[kind]
            values[field.name] = fields.unpack(code, size)[0]
    return values


def _laser_scan(topic: str, values: Values) -> Written:
    stamp, frame, beside = _placed(topic, values)
    ranges = np.array([_number(value) for value in values.get("ranges") or ()], dtype=np.float64).astype(np.float32)
    first, last = _number(values.get("start_angle", 0.0)), _number(values.get("end_angle", 0.0))
    step = (last - first) / (len(ranges) - 1) if len(ranges) > 1 else 0.0
    out = CdrWriter().header(stamp, frame).pack("f", 4, first, last, step, 0.0, 0.0, 0.0, np.inf)
    return beside, out.array(ranges).pack("I", 4, 0).message


def _point_cloud(topic: str, values: Values) -> Written:
    stamp, frame, beside = _placed(topic, values)
    data = values.get("data") or b""
    if isinstance(data, str):
        try:
            data = base64.b64decode(data, validate=True)
        except binascii.Error:
            raise BadMessageError from None
    step, fields = int(values.get("point_stride", 0)), list(values.get("fields") or ())
    if not 0 < step < 1 << 16 or len(fields) > MOST_FIELDS:
        raise BadMessageError(f"its points have {len(fields)} fields in {step} bytes")
    n = len(data) // step
    out = CdrWriter().header(stamp, frame).pack("I", 4, 1, n, len(fields))
    for field in fields:
        kind = NUMBERS.get(int(field.get("type", 0)), 0)
        out.string(str(field.get("name", ""))).pack("I", 4, int(field.get("offset", 0)))
        out.pack("B", 1, kind).pack("I", 4, 1)
    out.pack("B", 1, 0).pack("I", 4, step, step * n)
    return beside, out.array(np.frombuffer(data, np.uint8, n * step)).pack("B", 1, 0).message


def _frame_transform(_: str, values: Values) -> Written:
    return None, _transforms([values])


def _frame_transforms(_: str, values: Values) -> Written:
    return None, _transforms(list(values.get("transforms") or ()))


def _pose_in_frame(_: str, values: Values) -> Written:
    position, turn = _pose_of(values.get("pose") or {})
    out = CdrWriter().header(_stamp(values.get("timestamp")), str(values.get("frame_id", "")))
    return None, out.pack("d", 8, *position, *turn).message


def _transforms(items: list[Values]) -> bytes:
    if len(items) > MOST_TRANSFORMS:
        raise BadMessageError
    out = CdrWriter().pack("I", 4, len(items))
    for item in items:
        position, turn = _pose_of({"position": item.get("translation"), "orientation": item.get("rotation")})
        out.header(_stamp(item.get("timestamp")), str(item.get("parent_frame_id", "")))
        out.string(str(item.get("child_frame_id", ""))).pack("d", 8, *position, *turn)
    return out.message


def _placed(topic: str, values: Values) -> tuple[int, str, bytes | None]:
    """Return the stamp, the frame of the message's origin, and the transform to it if it is a separate frame."""
    stamp, frame = _stamp(values.get("timestamp")), str(values.get("frame_id", ""))
    position, turn = _pose_of(values.get("pose") or {})
    if not any(position) and not any(turn[:3]):
        return stamp, frame, None
    own = f"{frame}{'' if topic.startswith('/') else '/'}{topic}"
    out = CdrWriter().pack("I", 4, 1).header(stamp, frame).string(own).pack("d", 8, *position, *turn)
    return stamp, own, out.message


def _pose_of(values: Values) -> tuple[list[float], list[float]]:
    """Return x, y, z, and the quaternion x, y, z, w; the identity if not stated."""
    position, turn = values.get("position") or {}, values.get("orientation") or {"w": 1.0}
    return (
        [_number(position.get(axis, 0.0)) for axis in "xyz"],
        [_number(turn.get(axis, 0.0)) for axis in "xyzw"],
    )


def _number(value: float | str | None) -> float:
    """Return a JSON number; JSON has no infinity, so writers use a name or null instead."""
    return float("nan") if value is None else float(value)


def _stamp(value: str | dict[str, int] | None) -> int:
    """Return a time in nanoseconds, 0 if none is stated that ROS can represent."""
    if isinstance(value, str):
        moment = datetime.fromisoformat(value)
        seconds, nanoseconds = int(moment.timestamp() // 1), moment.microsecond * 1000
    elif isinstance(value, dict):
        seconds = int(value.get("sec", value.get("seconds", 0)))
        nanoseconds = int(value.get("nsec", value.get("nanos", 0)))
    else:
        return 0
    return seconds * SECOND + nanoseconds if 0 <= seconds <= LAST_SECOND and 0 <= nanoseconds < SECOND else 0


_SCHEMAS: dict[str, tuple[str, Table, Callable[[str, Values], Written]]] = {
    "LaserScan": (
        SCAN,
        {
            **_HEAD,
            4: Field("start_angle", "double"),
            5: Field("end_angle", "double"),
            6: Field("ranges", "double", repeated=True),
        },
        _laser_scan,
    ),
    "PointCloud": (
        CLOUD,
        {
            **_HEAD,
            4: Field("point_stride", "fixed32"),
            5: Field("fields", _ELEMENT, repeated=True),
            6: Field("data", "bytes"),
        },
        _point_cloud,
    ),
    "FrameTransform": (TF, _TRANSFORM, _frame_transform),
    "FrameTransforms": (TF, {1: Field("transforms", _TRANSFORM, repeated=True)}, _frame_transforms),
    "PoseInFrame": (POSE, _HEAD, _pose_in_frame),
}
