"""Point clouds and triangles in PLY files: ascii, and binary of either byte order.

Source: Greg Turk's description of the format (1994). Elements may be in any order and have list properties; list
properties of vertices are skipped.

We do not use plyfile: this parser reads the complete points of a file that ends early, checks the header's claims
against the available bytes before allocating memory, and creates no Python object per list.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array
from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.content import check_count, content, ended_early, made_cloud
from mapper.io.clouds.numbers import table
from mapper.io.logs.archives.unpacking import Unpacked, opened
from mapper.io.logs.names import printable
from mapper.io.logs.text.lines import BOM
from mapper.sensors.point_cloud import PointCloud

#: Names in the file of known point fields; others are kept.
_NAMES = {"rgb": ("red", "green", "blue"), "class": ("classification",)}
_TYPES = {"u1": "uchar", "i1": "char", "u2": "ushort", "i2": "short", "u4": "uint", "i4": "int", "f4": "float"}


def points_ply(points: Float32Array, fields: Mapping[str, NDArray[Any]], offset: Float64Array) -> bytes:
    """Return points (n, 3), metres, with their ``fields`` (n,) or (n, k) as a binary PLY file.

    ``offset`` (3,) is written as a comment; adding it to the points yields the coordinates of the mapped file. A field
    of a type that PLY lacks, such as 64 bits, is written as float.
    """
    columns: dict[str, NDArray[Any]] = {name: points[:, n] for n, name in enumerate("xyz")}
    for name, values in fields.items():
        parts = values if values.ndim == 2 else values[:, None]
        names = _NAMES.get(name, (name,))
        columns |= {names[n] if n < len(names) else f"{name}_{n}": parts[:, n] for n in range(parts.shape[1])}
    kinds = {name: values.dtype.str[1:] if values.dtype.str[1:] in _TYPES else "f4" for name, values in columns.items()}
    rows = np.empty(len(points), dtype=[(name, f"<{kind}") for name, kind in kinds.items()])
    for name, values in columns.items():
        rows[name] = values
    moved = f"comment offset {' '.join(map(repr, offset.tolist()))}\n" if offset.any() else ""
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment metres, z up\n{moved}element vertex {len(points)}\n"
        + "".join(f"property {_TYPES[kind]} {name}\n" for name, kind in kinds.items())
        + "end_header\n"
    )
    return header.encode() + rows.tobytes()


MOST_HEADER_BYTES = 1 << 16
MOST_UNEVEN = 2_000_000  #: rows whose lists differ in length, which are processed individually
END = re.compile(rb"end_header[ \t]*\r?\n")
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, slots=True)
class Property:
    """A property: its name, the NumPy type of its numbers, and that of its length if it is a list."""

    name: str
    kind: str
    length_kind: str | None = None


@dataclass(frozen=True, slots=True)
class Element:
    """An element of the header: its number of rows, and its properties."""

    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True, slots=True)
class Rows:
    """The rows of an element in the file, ``n`` of them; the next element starts at byte ``end``.

    ``columns`` are those of its numbers (n,); ``lists`` those of its lists (n, length) with one common length.
    """

    n: int
    end: int
    columns: dict[str, NDArray[Any]] = field(default_factory=dict)
    lists: dict[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PlyFile:
    """The bytes of a file, and the contents of its header. ``order`` is a NumPy byte order, or "" for ascii."""

    data: bytes
    order: str
    elements: tuple[Element, ...]
    begin: int

    def element(self, name: str) -> Element | None:
        """Return the first element of a name."""
        return next((element for element in self.elements if element.name == name), None)

    def rows(self, name: str, limits: Limits) -> Rows:
        """Return the rows of the first element with a name; earlier elements are skipped.

        Raises :class:`ReadError` if the file ends before them, or a number is invalid, and :class:`LimitError`.
        """
        at = self.begin
        for element in self.elements:
            check_count(element.count, limits)
            rows_read = (_text_rows if self.order == "" else _binary_rows)(
                self, element, at, limits, keep=element.name == name
            )
            if element.name == name:
                return rows_read
            if rows_read.n < element.count:
                raise ReadError(
                    "cloud.truncated", f"The file ends early, within its element {printable(element.name[:40])!r}."
                )
            at = rows_read.end
        raise ReadError("cloud.header", f"The PLY file has no element {name}.")


def read_ply(data: bytes, limits: Limits) -> PointCloud:
    """Return the vertices of a PLY file. Raises :class:`ReadError` for an inconsistent header, and
    :class:`LimitError`.
    """
    file = ply_file(data)
    vertices = file.element("vertex") or next((element for element in file.elements if _has_axes(element)), None)
    if vertices is None:
        raise ReadError("cloud.header", "The PLY file has no element vertex: it holds no points.")
    axes = {
        property_.name.lower(): property_.name
        for property_ in reversed(vertices.properties)
        if property_.length_kind is None
    }
    missing = [axis for axis in "xyz" if axis not in axes]
    if missing:
        raise ReadError("cloud.header", f"The vertices of the PLY file have no property {missing[0]}.")
    rows = file.rows(vertices.name, limits)
    notes = ended_early(vertices.count, rows.n)
    columns = dict(rows.columns)
    points = np.stack([columns.pop(axes[axis]) for axis in "xyz"], axis=1)
    return made_cloud(points, columns, limits, notes=notes)


def _has_axes(element: Element) -> bool:
    return {"x", "y", "z"} <= {
        property_.name.lower() for property_ in element.properties if property_.length_kind is None
    }


def ply_file(data: bytes) -> PlyFile:
    """Return a file with its parsed header. Raises :class:`ReadError` for a header that is not PLY."""
    end = END.search(data, 0, MOST_HEADER_BYTES)
    if end is None:
        raise ReadError("cloud.header", "The file ends before the line end_header of a PLY file.")
    order: str | None = None
    elements: list[Element] = []
    for line in data[: end.start()].decode("latin-1").split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            order = ORDERS.get(words[1]) if len(words) > 1 else None
        elif words[:1] == ["element"]:
            if len(words) != 3 or not re.fullmatch(r"-?\d{1,18}", words[2], re.ASCII):
                raise ReadError(
                    "cloud.header", f"The line {printable(line.strip()[:60])!r} does not name an element of PLY."
                )
            elements.append(Element(words[1], int(words[2]), ()))
        elif words[:1] == ["property"] and elements:
            last = elements[-1]
            elements[-1] = Element(last.name, last.count, (*last.properties, _property(line, last)))
    if order is None:
        raise ReadError("cloud.header", "The PLY file states no format: ascii, or binary of one byte order.")
    return PlyFile(data, order, tuple(elements), end.end())


def _property(line: str, element: Element) -> Property:
    words = line.split(None, 4)
    is_list = words[1:2] == ["list"]
    kinds, name = (words[2:4], words[4:]) if is_list else (words[1:2], line.split(None, 2)[2:])
    kinds = [kind.lower() for kind in kinds]
    wrong = next((kind for kind in kinds if kind not in TYPES), None)
    if wrong is not None or not name or (is_list and TYPES[kinds[0]][0] == "f"):
        text = printable((wrong or line.strip())[:40])
        raise ReadError(
            "cloud.header", f"A property of the element {printable(element.name[:40])} is of the type {text!r}, which "
            "PLY lacks.",
        )  # fmt: skip
    label = printable(name[0].strip()[:100])
    if any(property_.name == label for property_ in element.properties):
        raise ReadError(
            "cloud.header", f"Two properties of the element {printable(element.name[:40])} have the same name."
        )
    if is_list:
        return Property(label, TYPES[kinds[1]], TYPES[kinds[0]])
    return Property(label, TYPES[kinds[0]])


def _binary_rows(file: PlyFile, element: Element, at: int, limits: Limits, *, keep: bool) -> Rows:
    data, order = file.data, file.order
    lengths = _first_lengths(file, element, at)
    if lengths is None:
        return Rows(0, at)
    parts: list[Any] = []
    for k, property_ in enumerate(element.properties):
        if property_.length_kind is not None:
            parts += [(f"n{k}", order + property_.length_kind), (f"p{k}", order + property_.kind, (lengths[k],))]
        else:
            parts.append((f"p{k}", order + property_.kind))
    row = np.dtype(parts)
    n = min(element.count, (len(data) - at) // row.itemsize) if row.itemsize else element.count
    values = np.frombuffer(data, row, n, at) if row.itemsize else np.zeros(n, row)
    lists = {k: property_ for k, property_ in enumerate(element.properties) if property_.length_kind is not None}
    if any((values[f"n{k}"] != lengths[k]).any() for k in lists):
        return _uneven_rows(file, element, at, limits, keep=keep)
    end = at + n * row.itemsize
    if not keep:
        return Rows(n, end)
    kinds = enumerate(element.properties)
    columns = {property_.name: values[f"p{k}"].astype(property_.kind) for k, property_ in kinds if k not in lists}
    return Rows(
        n, end, columns, {property_.name: values[f"p{k}"].astype(property_.kind) for k, property_ in lists.items()}
    )


def _first_lengths(file: PlyFile, element: Element, at: int) -> dict[int, int] | None:
    """Return the lengths of the lists in the first row; None if the file ends within it, or there is none."""
    lengths: dict[int, int] = {}
    for k, property_ in enumerate(element.properties if element.count else ()):
        size = np.dtype(property_.kind).itemsize
        if property_.length_kind is not None:
            kind = np.dtype(file.order + property_.length_kind)
            if at + kind.itemsize > len(file.data):
                return None
            lengths[k] = int(np.frombuffer(file.data, kind, 1, at)[0])
            at += kind.itemsize
            size *= max(lengths[k], 0)
        if lengths.get(k, 0) < 0 or at + size > len(file.data):
            return None
        at += size
    return dict.fromkeys(range(len(element.properties)), 0) | lengths


def _uneven_rows(file: PlyFile, element: Element, at: int, limits: Limits, *, keep: bool) -> Rows:
    """Process rows whose lists differ in length, and return their non-list numbers."""
    if element.count > min(MOST_UNEVEN, limits.max_points):
        raise LimitError(
            "cloud.too_many_lists",
            f"The element {printable(element.name[:40])} has {element.count} rows with lists of different lengths, "
            f"more than the limit of {MOST_UNEVEN}.",
        )
    data, size = file.data, len(file.data)
    order: Any = "little" if file.order == "<" else "big"
    steps = [
        (
            0 if property_.length_kind is None else int(property_.length_kind[1]),
            int(property_.kind[1]),
            (property_.length_kind or "")[:1] == "i",
        )
        for property_ in element.properties
    ]
    least = sum(length or size for length, size, _ in steps)  # size of a row
    starts = np.zeros((min(element.count, (size - at) // least), len(steps)), dtype=np.int64)
    n, end = 0, at
    while n < len(starts):
        place = end
        for k, (length_bytes, bytes_each, is_signed) in enumerate(steps):
            starts[n, k] = place
            if length_bytes:
                if place + length_bytes > size:
                    break
                length = int.from_bytes(data[place : place + length_bytes], order, signed=is_signed)
                place += length_bytes + max(length, 0) * bytes_each
            else:
                place += bytes_each
            if place > size:
                break
        else:
            n, end = n + 1, place
            continue
        break
    if not keep:
        return Rows(n, end)
    raw = np.frombuffer(data, np.uint8)
    columns = {}
    for k, property_ in enumerate(element.properties):
        if property_.length_kind is None:
            places = starts[:n, k, np.newaxis] + np.arange(steps[k][1])
            columns[property_.name] = (
                np.ascontiguousarray(raw[places]).view(file.order + property_.kind)[:, 0].astype(property_.kind)
            )
    return Rows(n, end, columns)


def _text_rows(file: PlyFile, element: Element, at: int, limits: Limits, *, keep: bool) -> Rows:
    n_lines, width = _line_count(file.data, at, element), len(element.properties)
    text, end = _lines(file.data, at, n_lines)
    if n_lines < element.count:
        words = text.split()
        text = b"".join(b" ".join(words[k : k + width]) + b"\n" for k in range(0, len(words), width))
    if not keep:
        return Rows(text.count(b"\n") + (not text.endswith(b"\n") and bool(text)), end)
    first_line = file.data.count(b"\n", 0, at) + 1
    is_list = [property_.length_kind is not None for property_ in element.properties]
    if is_list == [True]:
        return _text_lists(text, element, end, limits, first_line)
    if any(is_list):
        text = b"".join(_without_lists(text, is_list, first_line))
        width -= sum(is_list)
    rows = table(text, None, element.count, width, limits, first_line)
    scalars = [property_ for property_ in element.properties if property_.length_kind is None]
    columns = (
        {property_.name: rows[:, k].astype(property_.kind) for k, property_ in enumerate(scalars)} if len(rows) else {}
    )
    columns = columns or {property_.name: np.zeros(0, property_.kind) for property_ in scalars}
    return Rows(len(rows), end, columns)


def _text_lists(text: bytes, element: Element, end: int, limits: Limits, first_line: int) -> Rows:
    """Return the rows of an element that is a single list, with the lists only if they have one common length."""
    (property_,) = element.properties
    lengths = {line.split(None, 1)[0] for line in text.splitlines() if line.strip()}
    if len(lengths) != 1 or not (length := lengths.pop()).isdigit() or len(length) > 9:
        return Rows(len(text.splitlines()), end)
    rows = table(text, None, element.count, 1 + int(length), limits, first_line)
    whole = rows if property_.kind[0] == "f" else np.trunc(rows)
    if not np.array_equal(rows, whole):
        raise ReadError("cloud.numbers", f"A number of {property_.name!r:.40} is not whole.")
    return Rows(
        len(rows), end, {}, {property_.name: rows[:, 1:].astype(property_.kind if property_.kind[0] == "f" else "i8")}
    )


def _without_lists(text: bytes, is_list: list[bool], first_line: int) -> Iterator[bytes]:
    """Yield the lines of an element without the numbers of its lists."""
    for number, line in enumerate(text.splitlines(keepends=True), first_line):
        words, scalars, at = line.split(), [], 0
        for is_one in is_list:
            if is_one:
                length = words[at] if at < len(words) else b""
                if not length.isdigit() or len(length) > 9:
                    if not line.endswith(b"\n"):
                        return  # the file ends within its last line
                    raise ReadError("cloud.numbers", f"A list near line {number} does not begin with its length.")
                at += 1 + int(length)
            else:
                scalars += words[at : at + 1]
                at += 1
        if at > len(words) and not line.endswith(b"\n"):
            return
        yield b" ".join(scalars) + b"\n"


def _line_count(data: bytes, at: int, element: Element) -> int:
    """Return the number of lines of an element's rows: one per row, or fewer with several rows on each.

    Blanks and line ends are equivalent in rply, which Open3D uses to read PLY. If lines of the same length continue
    after the last row, each line is a row with more numbers than stated in the header.
    """
    n, width = element.count, len(element.properties)
    if n < 2 or any(property_.length_kind is not None for property_ in element.properties):
        return n
    in_first = len(_lines(data, at, 1)[0].split())
    if in_first <= width or in_first % width:
        return n
    lines = -(-n * width // in_first)
    text, end = _lines(data, at, lines)
    goes_on = len(_lines(data, end, 1)[0].split()) == in_first
    return n if goes_on or len(text.split()) != n * width else lines


def _lines(data: bytes, at: int, n: int) -> tuple[bytes, int]:
    """Return ``n`` lines from an offset on, fewer at the end of the file, and their end, where other elements follow.

    Empty lines in between are not counted. A byte-order mark at the start, as from numbers pasted from another file, is
    removed.
    """
    lines = io.BytesIO(data)
    lines.seek(at + (len(BOM) if data.startswith(BOM, at) else 0))
    rows: list[bytes] = []
    while len(rows) < n and (more := list(islice(lines, n - len(rows)))):
        rows += [line for line in more if not line.isspace()]
    return b"".join(rows), lines.tell()


NOT_TRIANGLES = "ply.not_triangles"  #: code of the error for faces that are not plain lists of three vertices


def has_faces(path: Path, limits: Limits = DEFAULT_LIMITS) -> bool:
    """Return whether a file, plain or compressed, starts like PLY and its header has faces. Raises
    :class:`ReadError`.
    """
    head = b""
    with opened(path) as file:
        for piece in Unpacked(file, lambda: "at its beginning", limits):
            head += piece
            if not head.startswith((b"ply\n", b"ply\r\n")) or len(head) >= MOST_HEADER_BYTES or END.search(head):
                break
    if not head.startswith(b"ply") or END.search(head) is None:
        return False
    try:
        faces = ply_file(head).element("face")
    except ReadError:
        return False  # the reader of its points reports the error
    return faces is not None and faces.count > 0


def read_ply_mesh(
    path: Path, limits: Limits = DEFAULT_LIMITS
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None, NDArray[np.int32]]:
    """Return the vertices (n, 3), their normals (n, 3) or None, and the triangles (m, 3) of a PLY file.

    Raises the :class:`ReadError` of :func:`mapper.io.clouds.ply.read_ply`, for a file that ends before its last face,
    for faces that are not triangles (code :data:`NOT_TRIANGLES`) and for missing vertices.
    """
    data = content(path, limits)
    cloud = read_ply(data, limits)
    faces = _triangles(ply_file(data), limits)
    if len(faces) and (faces.min() < 0 or faces.max() >= len(cloud)):
        raise ReadError("ply.vertex", f"A face of the PLY file names a vertex that is not among its {len(cloud)}.")
    normals = cloud.fields.get("normals")
    return (
        cloud.points.astype(np.float32),
        None if normals is None else normals.astype(np.float32),
        faces.astype(np.int32),
    )


def _triangles(file: PlyFile, limits: Limits) -> NDArray[np.int64]:
    element = file.element("face")
    if element is None:
        raise ReadError(NOT_TRIANGLES, "The PLY file has no faces.")
    if len(element.properties) != 1 or element.properties[0].length_kind is None:
        raise ReadError(NOT_TRIANGLES, "The faces of the PLY file have other properties than a list of vertices.")
    rows = file.rows("face", limits)
    if rows.n < element.count:
        raise ReadError(
            "cloud.truncated", f"The file ends early: its header says {element.count} faces, and it has {rows.n}."
        )
    vertices = rows.lists.get(element.properties[0].name)
    if vertices is None or vertices.shape[1:] != (3,):
        raise ReadError(NOT_TRIANGLES, "The faces of the PLY file are not all triangles.")
    return vertices.astype(np.int64)
