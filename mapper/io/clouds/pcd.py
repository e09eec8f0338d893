"""Point clouds in PCL's format PCD: ascii, binary and binary_compressed.

Source: "The PCD (Point Cloud Data) file format" of PCL's documentation; the columns of compressed data are those of
``pcl::PCDWriter::writeBinaryCompressed``. pypcd4 decompresses points, after a check that the file has the bytes that
its header claims, because pypcd4 allocates memory for the claimed size. Uncompressed points are read here, as far as
the file goes.
"""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.core.se3 import from_quaternion
from mapper.io.clouds.content import check_count, ended_early, made_cloud
from mapper.io.clouds.numbers import table
from mapper.io.clouds.pcd_header import PcdHeader, pcd_header
from mapper.sensors.point_cloud import PointCloud

LZF_EXPANSION = 132  #: LZF outputs at most 264 bytes for two input bytes: a run of 264 takes three, one of 8 two


def read_pcd(data: bytes, limits: Limits) -> PointCloud:
    """Return the cloud in the bytes of a PCD file, with ``sensor_pose`` from its VIEWPOINT.

    For a file that ends early these are the available points, with a note. Raises :class:`ReadError` for an invalid
    header and incomplete compressed points, and :class:`LimitError`.
    """
    header = pcd_header(data)
    check_count(header.points, limits)
    if header.points == 0:
        return made_cloud(np.zeros((0, 3)), {}, limits)
    names = [field.name for field in header.fields]
    single = {field.name.lower(): k for k, field in reversed([*enumerate(header.fields)]) if field.count == 1}
    single |= {
        field.name: k for k, field in reversed([*enumerate(header.fields)]) if field.count == 1 and field.name in "xyz"
    }
    missing = [axis for axis in "xyz" if axis not in single]
    if missing:
        raise ReadError("cloud.header", f"The cloud’s points have no field {missing[0]}.")
    values = _values(data, header, limits)
    n = len(values[0])
    notes = (*header.notes, *ended_early(header.points, n))
    points = np.stack([values[single[axis]] for axis in "xyz"], axis=1)
    axes = {single[axis] for axis in "xyz"}
    columns: dict[str, NDArray[Any]] = {}
    for k, field_ in enumerate(header.fields):
        if not field_.is_padding and k not in axes:
            columns[
                field_.name if field_.name not in columns else f"{field_.name} {names[:k].count(field_.name) + 1}"
            ] = values[k]
    return made_cloud(points, columns, limits, header.shape if n == header.points else None, _viewpoint(header), notes)


def _values(data: bytes, header: PcdHeader, limits: Limits) -> list[NDArray[Any]]:
    """Return the numbers of each field: (n,), or (n, count)."""
    row = header.dtype()
    if header.kind == "ascii":
        width = sum(field.count for field in header.fields)
        first_line = data.count(b"\n", 0, header.begin) + 1
        rows = table(data[header.begin :], None, header.points, width, limits, first_line)
        ends = np.cumsum([field.count for field in header.fields])
        of_fields = [
            rows[:, end - field.count : end].astype(field.kind) for field, end in zip(header.fields, ends, strict=True)
        ]
    elif header.kind == "binary":
        n = min(header.points, (len(data) - header.begin) // row.itemsize)
        values = np.frombuffer(data, row, n, header.begin)
        of_fields = [np.ascontiguousarray(values[name]) for name in row.names or ()]
    else:
        of_fields = _unpacked(data, header, row)
    return [
        column[:, 0] if field.count == 1 else column for column, field in zip(of_fields, header.fields, strict=True)
    ]


def _unpacked(data: bytes, header: PcdHeader, row: np.dtype[np.void]) -> list[NDArray[Any]]:
    """Return the numbers (n, count) of each field of compressed points."""
    from pypcd4.pypcd4 import PointCloud as Reader  # noqa: PLC0415 # only who reads this format pays for it

    _check_bytes(data, header.begin, header.points * row.itemsize)
    plain = header.written(header.points) + data[header.begin :]
    try:
        read = Reader.from_fileobj(io.BufferedReader(io.BytesIO(plain)))
    except (ValueError, RuntimeError, struct.error, OverflowError, MemoryError, UnicodeDecodeError) as error:
        raise ReadError("cloud.damaged", "The packed points are damaged: they do not unpack.") from error
    columns = iter([np.ascontiguousarray(read.pc_data[name]) for name in read.pc_data.dtype.names or ()])
    # pypcd4 returns the numbers of each point side by side, as if they were consecutive columns.
    return [
        np.concatenate([next(columns) for _ in range(field.count)]).reshape(-1, field.count) for field in header.fields
    ]


def _check_bytes(data: bytes, begin: int, needed: int) -> None:
    """Raise :class:`ReadError` unless there may be enough bytes for the points' ``needed`` decompressed ones."""
    there = len(data) - begin
    if there < 8:
        raise ReadError("cloud.truncated", "The file ends before its points.")
    packed, unpacked = struct.unpack_from("<II", data, begin)
    if packed > there - 8:
        raise ReadError(
            "cloud.truncated",
            f"The file ends early: {packed} packed bytes claimed, {there - 8} there. Of compressed points no part can "
            "be read: all x come first, then all y.",
        )
    if unpacked != needed or unpacked > LZF_EXPANSION * packed:
        raise ReadError(
            "cloud.header", f"{packed} packed bytes that unpack to {unpacked} do not hold {needed} bytes of points."
        )


def _viewpoint(header: PcdHeader) -> NDArray[np.float64] | None:
    """Return ``T_frame_sensor`` (4, 4); None for the identity, which means unknown in most files."""
    x, y, z, w, qx, qy, qz = header.viewpoint
    length = float(np.linalg.norm((w, qx, qy, qz)))
    if (x, y, z, qx, qy, qz) == (0.0,) * 6 or abs(length - 1.0) > 0.05:
        return None
    return from_quaternion((x, y, z), qx / length, qy / length, qz / length, w / length)
