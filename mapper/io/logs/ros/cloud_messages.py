"""Decoding of serialised point clouds, depth images and camera infos.

Source: the message definitions of sensor_msgs/PointCloud2, PointField, Image and CameraInfo, and of livox_ros_driver's
CustomMsg; the wiki of depthimage_to_laserscan (16UC1 is millimetres, 0 no reading; 32FC1 metres).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.io.logs.names import printable
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.sensors.camera import Intrinsics, Lens
from mapper.sensors.point_cloud import PointCloud

MOST_FIELDS = 256  #: of one point
MOST_MODEL = 100  #: stored characters of a distortion model's name
UNTURNED = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)  #: R of a camera that states none
MOST_SIDE = 1 << 16  #: pixels
PART_POINTS = 1 << 17  #: processed at once: each takes some hundred bytes including derived values
MOST_NAME = 100  #: stored characters of a field's name
TIME_FIELDS = ("t", "time", "offset_time", "timestamp", "time_stamp")
SINCE_1970_S, SINCE_1970_NS = 1e8, 1e17  #: larger values are times since 1970, in seconds or nanoseconds
DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
LIVOX_POINT = np.dtype(
    {
        "names": ["offset_time", "x", "y", "z", "reflectivity", "tag", "line"],
        "formats": ["<u4", "<f4", "<f4", "<f4", "u1", "u1", "u1"],
        "offsets": [0, 4, 8, 12, 16, 17, 18],
        "itemsize": 19,
    }
)
DEPTHS = {"16UC1": ("u2", 0.001), "mono16": ("u2", 0.001), "32FC1": ("f4", 1.0)}  #: encoding → type, metres


@dataclass(frozen=True, slots=True)
class Cloud:
    """One sensor_msgs/PointCloud2: ``axes`` are x, y and z (height, width), views of the message's bytes.

    ``others`` are its other fields, (height, width) or, for fields of several numbers, (height, width, count).
    """

    stamp_ns: int
    frame: str
    axes: tuple[NDArray[np.generic], NDArray[np.generic], NDArray[np.generic]]
    others: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        """Size in bytes of the point data."""
        return int(sum(axis.nbytes for axis in self.axes))

    def whole(self, recorded_ns: int = 0) -> PointCloud:
        """Return the cloud with all fields; ``recorded_ns`` is its stamp if it states none."""
        double = any(axis.dtype.kind != "f" or axis.dtype.itemsize > 4 for axis in self.axes)
        kind = np.float64 if double else np.float32
        points = np.stack([axis.astype(kind).reshape(-1) for axis in self.axes], axis=-1)
        fields = {
            name: values.astype(values.dtype.newbyteorder("=")).reshape(len(points), *values.shape[2:])
            for name, values in self.others.items()
        }
        stamp_ns = self.stamp_ns or recorded_ns
        height, width = self.axes[0].shape
        return PointCloud(points, stamp_ns, self.frame, (height, width), fields, times_of(fields, stamp_ns))

    def timed_sample(self, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Return about ``n`` points (m, 3) spread over the cloud, and their times (m,): see :func:`times_of`.

        None where no field says when points were measured.
        """
        name = next((name for name in TIME_FIELDS if name in self.others and self.others[name].ndim == 2), None)
        height, width = self.axes[0].shape
        if name is None or not height or not width:
            return None
        part = np.s_[:: max(1, height // 32), :: max(1, min(height, 32) * width // n)]
        times = times_of({name: self.others[name][part].reshape(-1)}, self.stamp_ns)
        points = np.stack([axis[part].astype(np.float64).reshape(-1) for axis in self.axes], axis=-1)
        return None if times is None else (points, times)

    def parts(self) -> Iterator[NDArray[np.float64]]:
        """Yield the points (n, 3), row by row, in parts of bounded memory."""
        height, width = self.axes[0].shape
        if not height or not width:
            return
        rows, cols = max(1, PART_POINTS // width), min(width, PART_POINTS)
        for row in range(0, height, rows):
            for col in range(0, width, cols):
                part = np.s_[row : row + rows, col : col + cols]
                yield np.stack([axis[part].astype(np.float64).reshape(-1) for axis in self.axes], axis=-1)


def point_cloud(data: bytes, *, cdr: bool) -> Cloud:
    """Decode a sensor_msgs/PointCloud2 of any layout: fields in any order and type, padded rows and points."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    height, width = (int(n) for n in fields.unpack("2I", 4))
    n = fields.count(13)
    if n > MOST_FIELDS:
        raise BadMessageError(f"its points have {n} fields")
    layout: dict[str, tuple[int, str, int]] = {}
    for _ in range(n):
        name = fields.string()
        (offset,) = fields.unpack("I", 4)
        (datatype,) = fields.unpack("B", 1)
        (count,) = fields.unpack("I", 4)
        layout.setdefault(name, (int(offset), DATATYPES.get(int(datatype), ""), int(count)))
    (is_bigendian,) = fields.unpack("B", 1)
    point_step, row_step = (int(n) for n in fields.unpack("2I", 4))
    values = fields.bytes()
    fields.unpack("B", 1)  # is_dense: non-finite points are searched for anyway
    fields.end()
    if height <= 1 or width == 0:
        row_step = point_step * width  # some drivers leave it 0
    needed = (height - 1) * row_step + width * point_step if height and width else 0
    if row_step < width * point_step or needed > len(values):
        raise BadMessageError(
            f"{width} × {height} points of {point_step} bytes, in rows of {row_step}, do not fit its {len(values)} "
            "bytes of data"
        )
    order = ">" if is_bigendian else "<"
    shape = (height, width) if needed else (0, 0)
    axes = []
    for name in "xyz":
        offset, code, _ = layout.pop(name, (0, "", 0))  # some drivers leave the count 0
        if not code:
            raise BadMessageError(f"its points have no field {name}")
        kind = np.dtype(order + code)
        if offset + kind.itemsize > point_step:
            raise BadMessageError(f"the field {name} reaches beyond a point’s {point_step} bytes")
        axes.append(np.ndarray(shape, kind, values, offset if needed else 0, (row_step, point_step)))
    others: dict[str, NDArray[np.generic]] = {}
    room = point_step  # overlapping fields could make a small message need gigabytes
    for name, (offset, code, count) in layout.items():
        kind = np.dtype(order + (code or "u1"))
        size = max(1, count) * kind.itemsize
        if not code or offset + size > point_step or size > room:
            continue
        room -= size
        more = ((), ()) if count <= 1 else ((count,), (kind.itemsize,))
        whole, strides = (*shape, *more[0]), (row_step, point_step, *more[1])
        others[printable(name[:MOST_NAME])] = np.ndarray(whole, kind, values, offset if needed else 0, strides)
    return Cloud(stamp, frame, (axes[0], axes[1], axes[2]), others)


def livox_cloud(data: bytes, *, cdr: bool) -> Cloud:
    """Decode a CustomMsg of livox_ros_driver or livox_ros_driver2: points of 19 bytes, aligned to 20 in CDR."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    fields.unpack("Q", 8)  # the time of the first point
    fields.unpack("I", 4)  # the number of points, repeated before them
    fields.unpack("4B", 1)  # the lidar's id, and three reserved bytes
    n = fields.count(LIVOX_POINT.itemsize)
    values = data[fields.pos : fields.pos + n * (step := 20 if cdr else LIVOX_POINT.itemsize)]
    if len(values) < n * step - (step - LIVOX_POINT.itemsize):
        raise BadMessageError(f"{n} points of {step} bytes do not fit its {len(values)} bytes of points")
    fields.pos += len(values)
    fields.end()
    columns: dict[str, NDArray[np.generic]] = {}
    for name, stated in (LIVOX_POINT.fields or {}).items():
        kind, offset = stated[:2]
        number = kind.newbyteorder("<" if fields.order == "<" else ">")
        columns[name] = (
            np.ndarray((1, n), number, values, offset if n else 0, (n * step, step)) if n else np.zeros((0, 0))
        )
    x, y, z = (columns.pop(axis) for axis in "xyz")
    return Cloud(stamp, frame, (x, y, z), columns)


CLOUD = "sensor_msgs/PointCloud2"
#: Types of clouds → their decoders.
CLOUD_DECODERS: dict[str, Callable[..., Cloud]] = {
    CLOUD: point_cloud,
    "livox_ros_driver/CustomMsg": livox_cloud,
    "livox_ros_driver2/CustomMsg": livox_cloud,
    "livox_interfaces/CustomMsg": livox_cloud,
}


def times_of(fields: Mapping[str, NDArray[np.generic]], stamp_ns: int) -> NDArray[np.float64] | None:
    """Return the time of each point (n,), seconds after the stamp; None without a scalar time field.

    Drivers differ: ``t`` (Ouster) and ``offset_time`` (Livox) are integer nanoseconds after the stamp, ``time``
    (Velodyne) seconds after it, and ``timestamp`` (Hesai, RoboSense, Livox) seconds or nanoseconds since 1970.
    """
    name = next((name for name in TIME_FIELDS if name in fields and fields[name].ndim == 1), None)
    if name is None:
        return None
    stated = fields[name]
    times = stated.astype(np.float64)
    usual = float(np.nanmedian(np.abs(times))) if np.isfinite(times).any() else 0.0
    if usual > SINCE_1970_NS:
        return np.asarray((times - float(stamp_ns)) * 1e-9)
    if usual > SINCE_1970_S and stated.dtype.kind == "f":
        return np.asarray(times - stamp_ns * 1e-9)
    return times * 1e-9 if stated.dtype.kind in "iu" else times


@dataclass(frozen=True, slots=True)
class DepthImage:
    """One sensor_msgs/Image of depths: ``raw`` (height, width) as stored, in ``unit`` metres."""

    stamp_ns: int
    frame: str
    raw: NDArray[np.generic]
    unit: float

    def metres(self) -> NDArray[np.float32]:
        """Return the depths (height, width), metres; NaN, +Inf and 0 as stored."""
        return (self.raw.astype(np.float32) * np.float32(self.unit)).astype(np.float32)


class NotDepthError(Exception):
    """The image's encoding is not that of a depth image."""


def depth_image(data: bytes, *, cdr: bool) -> DepthImage:
    """Decode a sensor_msgs/Image with an encoding in :data:`DEPTHS`. Raises :class:`NotDepthError` for any other."""
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    height, width = (int(n) for n in fields.unpack("2I", 4))
    encoding = fields.string()
    if encoding not in DEPTHS:
        raise NotDepthError(encoding)
    (is_bigendian,) = fields.unpack("B", 1)
    (step,) = (int(n) for n in fields.unpack("I", 4))
    values = fields.bytes()
    fields.end()
    code, unit = DEPTHS[encoding]
    kind = np.dtype((">" if is_bigendian else "<") + code)
    if not 0 < width <= MOST_SIDE or not 0 < height <= MOST_SIDE:
        raise BadMessageError(f"an image of {width} × {height} pixels")
    if step < width * kind.itemsize or (height - 1) * step + width * kind.itemsize > len(values):
        raise BadMessageError(
            f"{width} × {height} pixels of {kind.itemsize} bytes, in rows of {step}, do not fit its {len(values)} "
            "bytes of data"
        )
    return DepthImage(stamp, frame, np.ndarray((height, width), kind, values, 0, (step, kind.itemsize)), unit)


@dataclass(frozen=True, slots=True)
class CameraInfo:
    """A sensor_msgs/CameraInfo: its frame, the intrinsics of the rectified image, and the lens of the raw image.

    The intrinsics are those of the projection matrix P or, if that is zero, of K; for the lens it is the other way
    round.
    """

    frame: str
    intrinsics: Intrinsics
    lens: Lens


def camera_info(data: bytes, *, cdr: bool) -> CameraInfo:
    """Decode a sensor_msgs/CameraInfo."""
    fields = MessageFields(data, cdr=cdr)
    _, frame = fields.header()
    height, width = (int(n) for n in fields.unpack("2I", 4))
    model = printable(fields.string()[:MOST_MODEL])
    n = fields.count(8)
    d = fields.unpack(f"{n}d", 8)
    k = fields.unpack("9d", 8)
    r = fields.unpack("9d", 8)
    p = fields.unpack("12d", 8)
    fields.unpack("2I", 4)  # binning
    fields.unpack("4I", 4)  # region of interest
    fields.unpack("B", 1)
    fields.end()
    of_p, of_k = (p[0], p[5], p[2], p[6]), (k[0], k[4], k[2], k[5])
    try:
        rectified = Intrinsics(width, height, *(of_p if p[0] > 0.0 else of_k))
        raw = Intrinsics(width, height, *(of_k if k[0] > 0.0 else of_p))
        return CameraInfo(frame, rectified, Lens(raw, r if any(r) else UNTURNED, model, d))
    except ConfigError as error:
        raise BadMessageError(error.message) from None
