"""Point clouds in PLY files: ascii, and binary of either byte order.

Source: Greg Turk's description of the format (1994). Vertices are read where they come first; elements after them,
such as faces, are skipped.
"""

from __future__ import annotations

import io
import re
from itertools import islice

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import check_count, made_cloud
from mapper.io.clouds.numbers import table
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

MOST_HEADER_BYTES = 1 << 16
END = re.compile(rb"end_header[ \t]*\r?\n")
ELEMENT = re.compile(rb"^element[ \t]+(\S+)[ \t]+(-?\d{1,18})[ \t]*\r?$", re.MULTILINE)
PROPERTY = re.compile(rb"^property[ \t]+(\S+)[ \t]+(.*?)\r?$", re.MULTILINE)
TYPES = {
    b"char": "i1", b"int8": "i1", b"uchar": "u1", b"uint8": "u1", b"short": "i2", b"int16": "i2", b"ushort": "u2",
    b"uint16": "u2", b"int": "i4", b"int32": "i4", b"uint": "u4", b"uint32": "u4", b"float": "f4", b"float32": "f4",
    b"double": "f8", b"float64": "f8",
}  # fmt: skip
ORDERS = {b"binary_little_endian": "<", b"binary_big_endian": ">"}
FORMAT = re.compile(rb"^format[ \t]+(\S+)", re.MULTILINE)


def read_ply(data: bytes, limits: Limits) -> PointCloud:
    """Return the vertices of a PLY file. Raises :class:`ReadError` for a header that lies, and :class:`LimitError`."""
    end = END.search(data, 0, MOST_HEADER_BYTES)
    if end is None:
        raise ReadError("cloud.header", "The file ends before the line end_header of a PLY file.")
    header = data[: end.start()]
    elements = [(found[1], int(found[2]), found.start()) for found in ELEMENT.finditer(header)]
    place = next((k for k, (name, _, _) in enumerate(elements) if name == b"vertex"), None)
    if place is None:
        raise ReadError("cloud.header", "The PLY file has no element vertex: it holds no points.")
    if place > 0:
        raise ReadError(
            "cloud.header",
            f"The PLY file has {printable(elements[0][0].decode('latin-1')[:40])!r} before its vertices, which is not "
            "read: write the vertices first.",
        )
    n = elements[0][1]
    check_count(n, limits)
    stop = elements[1][2] if len(elements) > 1 else len(header)
    properties = _properties(header[:stop])
    form = FORMAT.search(header)
    order = None if form is None else ORDERS.get(form[1])
    if form is None or (order is None and form[1] != b"ascii"):
        raise ReadError("cloud.header", "The PLY file states no format: ascii, or binary of one byte order.")
    if order is None:
        kept = _lines(data, end.end(), n)
        rows = table(kept, None, n, len(properties), limits, header.count(b"\n") + 2)
        columns = {name: rows[:, k].astype(kind) for k, (name, kind) in enumerate(properties)}
    else:
        kind = np.dtype([(name, order + code) for name, code in properties])
        there = len(data) - end.end()
        if there < n * kind.itemsize:
            raise ReadError(
                "cloud.truncated", f"The file ends early: {n * kind.itemsize} bytes of points claimed, {there} there."
            )
        values = np.frombuffer(data, kind, n, end.end())
        columns = {name: values[name].astype(code) for name, code in properties}
    missing = [axis for axis in "xyz" if axis not in columns]
    if missing:
        raise ReadError("cloud.header", f"The vertices of the PLY file have no property {missing[0]}.")
    points = np.stack([columns.pop(axis) for axis in "xyz"], axis=1)
    return made_cloud(points, columns, limits)


def _properties(vertices: bytes) -> list[tuple[str, str]]:
    """Return the names and types of the vertices' properties. Raises :class:`ReadError` for what PLY lacks."""
    found: list[tuple[str, str]] = []
    for one in PROPERTY.finditer(vertices):
        if one[1] not in TYPES:
            kind = printable(one[1].decode("latin-1")[:40])
            raise ReadError("cloud.header", f"A property of the vertices is of the type {kind!r}, which is no number.")
        found.append((printable(one[2].decode("latin-1").strip()[:100]), TYPES[one[1]]))
    if not found:
        raise ReadError("cloud.header", "The vertices of the PLY file have no properties.")
    if len({name for name, _ in found}) != len(found):
        raise ReadError("cloud.header", "Two properties of the vertices of the PLY file have one name.")
    return found


def _lines(data: bytes, at: int, n: int) -> bytes:
    """Return ``n`` lines from a place on, fewer at the end of the file; what follows is of other elements."""
    lines = io.BytesIO(data)
    lines.seek(at)
    return b"".join(islice(lines, n))
