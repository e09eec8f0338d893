"""Triangles of PLY files, behind the vertices that :mod:`mapper.io.clouds.ply` reads.

Source: Greg Turk's description of the format (1994): a face is a list of numbers of vertices, after its length.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.content import check_count, content
from mapper.io.clouds.ply import ELEMENT, END, FORMAT, MOST_HEADER_BYTES, ORDERS, PROPERTY, TYPES, read_ply
from mapper.io.logs.unpacking import Unpacked, opened

NOT_TRIANGLES = "ply.not_triangles"  #: code of the error for faces that are no plain list of three vertices


def has_faces(path: Path, limits: Limits = DEFAULT_LIMITS) -> bool:
    """Return whether a file, plain or packed, begins as PLY and its header names faces. Raises :class:`ReadError`."""
    head = b""
    with opened(path) as file:
        for piece in Unpacked(file, lambda: "at its beginning", limits):
            head += piece
            if not head.startswith((b"ply\n", b"ply\r\n")) or len(head) >= MOST_HEADER_BYTES or END.search(head):
                break
    end = END.search(head)
    header = head[: end.start()] if end else b""
    return head.startswith(b"ply") and any(one[1] == b"face" and int(one[2]) > 0 for one in ELEMENT.finditer(header))


def read_ply_mesh(
    path: Path, limits: Limits = DEFAULT_LIMITS
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None, NDArray[np.int32]]:
    """Return the vertices (n, 3), their normals (n, 3) or None, and the triangles (m, 3) of a PLY file.

    Raises :class:`ReadError` as :func:`mapper.io.clouds.ply.read_ply`, for a file that ends before its faces do, for
    faces of other numbers of vertices (code :data:`NOT_TRIANGLES`) and of vertices that there are not.
    """
    data = content(path, limits)
    cloud = read_ply(data, limits)
    end = END.search(data, 0, MOST_HEADER_BYTES)
    header = data[: end.start()] if end else b""
    begin = end.end() if end else 0
    elements = list(ELEMENT.finditer(header))
    form = FORMAT.search(header)
    if len(elements) < 2 or elements[1][1] != b"face" or form is None:
        raise ReadError(NOT_TRIANGLES, "The faces of the PLY file do not follow its vertices.")
    stop = elements[2].start() if len(elements) > 2 else len(header)
    found = PROPERTY.findall(header[elements[1].start() : stop])
    kinds = found[0][1].split() if len(found) == 1 and found[0][0] == b"list" else []
    if len(kinds) != 3 or kinds[0] not in TYPES or kinds[1] not in TYPES:
        raise ReadError(NOT_TRIANGLES, "The faces of the PLY file have other properties than a list of vertices.")
    m = int(elements[1][2])
    check_count(m, limits)
    if form[1] == b"ascii":
        lines = data[begin:].split(b"\n")[len(cloud) : len(cloud) + m]
        rows = [line.split() for line in lines]
        if any(len(row) != 4 or row[0] != b"3" for row in rows):
            raise ReadError(NOT_TRIANGLES, "The faces of the PLY file are not all triangles.")
        try:
            faces = np.array([row[1:] for row in rows], dtype=np.int64).reshape(-1, 3)
        except (ValueError, OverflowError) as error:
            raise ReadError("cloud.numbers", "A face of the PLY file is not made of whole numbers.") from error
    else:
        order = ORDERS[form[1]]
        vertex = sum(np.dtype(TYPES[kind]).itemsize for kind, _ in PROPERTY.findall(header[: elements[1].start()]))
        record = np.dtype([("n", order + TYPES[kinds[0]]), ("of", order + TYPES[kinds[1]], 3)])
        at = begin + vertex * len(cloud)
        values = np.frombuffer(data, record, min(m, (len(data) - at) // record.itemsize), at)
        if (values["n"] != 3).any():
            raise ReadError(NOT_TRIANGLES, "The faces of the PLY file are not all triangles.")
        faces = values["of"].astype(np.int64)
    if len(faces) < m:
        raise ReadError("cloud.truncated", f"The file ends early: {m} faces claimed, {len(faces)} there.")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(cloud)):
        raise ReadError("ply.vertex", f"A face of the PLY file names a vertex that is not among its {len(cloud)}.")
    normals = cloud.fields.get("normals")
    return (
        cloud.points.astype(np.float32),
        None if normals is None else normals.astype(np.float32),
        faces.astype(np.int32),
    )
