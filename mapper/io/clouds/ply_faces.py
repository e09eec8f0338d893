"""Triangles of PLY files, beside the vertices that :mod:`mapper.io.clouds.ply` reads.

Source: Greg Turk's description of the format (1994): a face is a list of numbers of vertices, after its length.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.content import content
from mapper.io.clouds.ply import END, MOST_HEADER_BYTES, PlyFile, ply_file, read_ply
from mapper.io.logs.archives.unpacking import Unpacked, opened

NOT_TRIANGLES = "ply.not_triangles"  #: code of the error for faces that are no plain list of three vertices


def has_faces(path: Path, limits: Limits = DEFAULT_LIMITS) -> bool:
    """Return whether a file, plain or packed, begins as PLY and its header names faces. Raises :class:`ReadError`."""
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
        return False  # the reader of its points says what is wrong
    return faces is not None and faces.count > 0


def read_ply_mesh(
    path: Path, limits: Limits = DEFAULT_LIMITS
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None, NDArray[np.int32]]:
    """Return the vertices (n, 3), their normals (n, 3) or None, and the triangles (m, 3) of a PLY file.

    Raises :class:`ReadError` as :func:`mapper.io.clouds.ply.read_ply`, for a file that ends before its faces do, for
    faces of other numbers of vertices (code :data:`NOT_TRIANGLES`) and of vertices that there are not.
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
