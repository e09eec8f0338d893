"""Point clouds in PCL's format PCD: ascii, binary and binary_compressed.

Source: "The PCD (Point Cloud Data) file format" of PCL's documentation; the columns of compressed data are those of
``pcl::PCDWriter::writeBinaryCompressed``. The header and the packed data are read by pypcd4, after a check that the
file has the bytes that its header claims: pypcd4 reserves memory for what is claimed.
"""

from __future__ import annotations

import io
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.core.se3 import from_quaternion
from mapper.io.clouds.content import check_count, made_cloud
from mapper.io.clouds.numbers import table
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

if TYPE_CHECKING:
    from pypcd4.pypcd4 import MetaData

MOST_HEADER_BYTES = 1 << 16
MOST_NUMBERS = 4096  #: of one point
LZF_EXPANSION = 132  #: LZF writes at most 264 bytes for two: a run of 264 takes three, one of 8 two
COMPRESSED = ("binary_compressed", "binaryscompressed")


def read_pcd(data: bytes, limits: Limits) -> PointCloud:
    """Return the cloud in the bytes of a PCD file, ``sensor_pose`` from its VIEWPOINT.

    Raises :class:`ReadError` for an invalid header or one that claims missing data, and :class:`LimitError`.
    """
    lines, start = _header_lines(data)
    meta = _header(lines)
    n = meta.points
    check_count(n, limits)
    if len({len(meta.fields), len(meta.size), len(meta.type), len(meta.count)}) != 1:
        raise ReadError("cloud.header", "The header's FIELDS, SIZE, TYPE and COUNT have different lengths.")
    if sum(meta.count) > MOST_NUMBERS:
        raise ReadError(
            "cloud.header", f"A point of {sum(meta.count)} numbers is none of a sensor; {MOST_NUMBERS} are the most."
        )
    if meta.width * meta.height != n:
        raise ReadError(
            "cloud.header", f"The header says {n} points, but its width and height {meta.width} × {meta.height}."
        )
    columns = _columns(data, start, meta, limits) if n else {}
    missing = [axis for axis in "xyz" if n and (axis not in columns or columns[axis].ndim != 1)]
    if missing:
        raise ReadError("cloud.header", f"The cloud's points have no field {missing[0]}.")
    points = np.stack([columns.pop(axis) for axis in "xyz"], axis=1) if n else np.zeros((0, 3))
    return made_cloud(points, columns, limits, (meta.height, meta.width), _viewpoint(meta))


def _header_lines(data: bytes) -> tuple[list[str], int]:
    """Return the lines up to DATA, without remarks, and where the data begins."""
    at, lines = 0, []
    while at < min(len(data), MOST_HEADER_BYTES):
        end = data.find(b"\n", at, MOST_HEADER_BYTES)
        if end < 0:
            break
        line = data[at:end].decode("latin-1").strip()
        at = end + 1
        if line and not line.startswith("#"):
            lines.append(line)
        if line.startswith("DATA"):
            return lines, at
    raise ReadError("cloud.header", "The file ends before a line DATA, the last of a PCD header.")


def _header(lines: list[str]) -> MetaData:
    from pydantic import ValidationError  # noqa: PLC0415
    from pypcd4.pypcd4 import MetaData  # noqa: PLC0415 # only who reads this format pays for it

    words = [line.split()[0].lower() for line in lines]
    if "points" not in words:  # version .6 and before
        sides = {word: line.split()[1] for word, line in zip(words, lines, strict=True) if len(line.split()) > 1}
        lines = [*lines, f"POINTS {_product(sides)}"]
    if "count" not in words:  # "if not given, 1 for all"
        fields = next((line.split()[1:] for line in lines if line.lower().startswith("fields")), [])
        lines = [*lines, "COUNT " + " ".join("1" for _ in fields)]
    lines = ["VERSION 0.7" if line.lower().startswith("version") else line for line in lines]
    try:
        return MetaData.parse_header(lines)
    except ValidationError as error:
        first = error.errors()[0]
        where = " ".join(str(part) for part in first["loc"][:1]).upper()
        raise ReadError("cloud.header", f"The PCD header's {where} is missing or wrong: {first['msg']}.") from error
    except (ValueError, IndexError, TypeError, KeyError) as error:
        raise ReadError("cloud.header", f"The PCD header is damaged: {printable(str(error)[:100])}.") from error


def _product(sides: dict[str, str]) -> int:
    try:
        return int(sides.get("width", "")) * int(sides.get("height", "1"))
    except ValueError:
        raise ReadError("cloud.header", "The PCD header states no whole number of points.") from None


def _columns(data: bytes, start: int, meta: MetaData, limits: Limits) -> dict[str, NDArray[Any]]:
    """Return each field by name: (n,), or (n, count)."""
    from pypcd4.pypcd4 import PointCloud as Reader  # noqa: PLC0415

    try:
        flat = meta.build_dtype()
    except (KeyError, ValueError) as error:
        raise ReadError(
            "cloud.header", f"The header's types are none of a PCD file: {printable(str(error)[:100])}."
        ) from error
    kind, n = meta.data.value, meta.points
    if kind == "ascii":
        rows = table(data[start:], None, n, len(flat.names or ()), limits, data.count(b"\n", 0, start) + 1)
        values = {name: rows[:, i].astype(flat[i]) for i, name in enumerate(flat.names or ())}
    else:
        _check_bytes(data, start, n * flat.itemsize, kind)
        try:
            read = Reader.from_fileobj(io.BufferedReader(io.BytesIO(data)))
        except (ValueError, RuntimeError, struct.error, OverflowError, MemoryError, UnicodeDecodeError) as error:
            raise ReadError("cloud.damaged", "The packed points are damaged: they do not unpack.") from error
        values = {name: np.ascontiguousarray(read.pc_data[name]) for name in read.pc_data.dtype.names or ()}
    return _joined(values, meta, compressed=kind in COMPRESSED)


def _check_bytes(data: bytes, start: int, needed: int, kind: str) -> None:
    """Raise :class:`ReadError` unless the points' ``needed`` bytes are there, or may be what is packed there."""
    there = len(data) - start
    if kind in COMPRESSED:
        if there < 8:
            raise ReadError("cloud.truncated", "The file ends before its points.")
        packed, unpacked = struct.unpack_from("<II", data, start)
        if packed > there - 8:
            raise ReadError(
                "cloud.truncated", f"The file ends early: {packed} packed bytes claimed, {there - 8} there."
            )
        if unpacked != needed or unpacked > LZF_EXPANSION * packed:
            raise ReadError(
                "cloud.header", f"{packed} packed bytes that unpack to {unpacked} do not hold {needed} bytes of points."
            )
    elif there < needed:
        raise ReadError("cloud.truncated", f"The file ends early: {needed} bytes of points claimed, {there} there.")


def _joined(values: dict[str, NDArray[Any]], meta: MetaData, *, compressed: bool) -> dict[str, NDArray[Any]]:
    """Return the columns with those of a field of several numbers joined, and without padding."""
    columns: dict[str, NDArray[Any]] = {}
    names = iter(values.values())
    for name, count in zip(meta.fields, meta.count, strict=True):
        parts = [next(names) for _ in range(count)]
        if name.startswith(("_", "#$%&~~")):  # padding, and what pypcd4 calls it
            continue
        if count == 1:
            columns[printable(name)] = parts[0]
        elif compressed:  # the numbers of each point are side by side, which pypcd4 takes for one column after another
            columns[printable(name)] = np.concatenate(parts).reshape(-1, count)
        else:
            columns[printable(name)] = np.stack(parts, axis=1)
    return columns


def _viewpoint(meta: MetaData) -> NDArray[np.float64] | None:
    """Return ``T_frame_sensor`` (4, 4); None for the identity, which files have that do not know it."""
    x, y, z, w, qx, qy, qz = meta.viewpoint
    length = float(np.linalg.norm((w, qx, qy, qz)))
    if (x, y, z, qx, qy, qz) == (0.0,) * 6 or not np.isfinite(meta.viewpoint).all() or abs(length - 1.0) > 0.05:
        return None
    return from_quaternion((x, y, z), qx / length, qy / length, qz / length, w / length)
