"""Point clouds as text: XYZ, PTS and CSV, with a line of names or without one.

Names are those of libpointmatcher and CloudCompare: x, y, z, nx, ny, nz, intensity, r, g, b. Without names the columns
are x, y, z and what programs usually write next: an intensity (4), a normal or a colour (6), both (7: intensity first).
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import made_cloud
from mapper.io.clouds.numbers import table
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

SEPARATORS = re.compile(rb"[,;\t]")
MOST_LINE_BYTES = 1 << 14
AXES = ("x", "y", "z")
COLOURS, NORMALS = ("r", "g", "b"), ("nx", "ny", "nz")


def names_of(line: bytes) -> list[str] | None:
    """Return the names of the columns in a line; None for a line of numbers."""
    words = [word.strip(b" \"'#/\r") for word in SEPARATORS.sub(b" ", line).split()]
    if not words or any(_is_number(word) for word in words):
        return None
    return [word.decode("latin-1") for word in words]


def looks_like_text(data: bytes) -> bool:
    """Return whether a file that begins with ``data`` is a cloud as text: names with x, y, z, or a line of numbers."""
    for line in data[:MOST_LINE_BYTES].split(b"\n")[:-1] or [data[:MOST_LINE_BYTES]]:
        if not line.strip():
            continue
        names = names_of(line)
        if names is not None:
            found = {name.lower() for name in names}
            if set(AXES) <= found:
                return True
            if line.lstrip().startswith((b"#", b"//")):
                continue  # a remark
            return False
        words = SEPARATORS.sub(b" ", line).split()
        if len(words) == 1 and words[0].isdigit():
            continue  # the number of points of a PTS file
        return len(words) >= 3 and all(_is_number(word) for word in words)
    return False


def read_text(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a text file. Raises :class:`ReadError`, naming the line, and :class:`LimitError`."""
    at, line_number, names, claimed = 0, 1, None, None
    while at < len(data):
        end = data.find(b"\n", at)
        end = len(data) if end < 0 else end
        line = data[at : min(end, at + MOST_LINE_BYTES)]
        found = names_of(line)
        words = line.split()
        if found is not None and {name.lower() for name in found} >= set(AXES):
            names = found
        elif len(words) == 1 and words[0].isdigit() and claimed is None:
            claimed = int(words[0][:18])
        elif line.strip() and not line.lstrip().startswith((b"#", b"//")):
            break
        at, line_number = end + 1, line_number + 1
    rows = table(SEPARATORS.sub(b" ", data[at:]), None, None, None, limits, line_number)
    if claimed is not None and len(rows) < claimed:
        raise ReadError("cloud.truncated", f"The file ends early: {claimed} points claimed, {len(rows)} there.")
    if len(rows) == 0:
        return made_cloud(np.zeros((0, 3)), {}, limits)
    if rows.shape[1] < len(AXES):
        raise ReadError("cloud.columns", f"A point needs three numbers, and the lines have {rows.shape[1]}.")
    if names is None:
        _refuse_matrix(rows)
        names = _usual_names(rows)
    elif len(names) != rows.shape[1]:
        raise ReadError("cloud.columns", f"The lines have {rows.shape[1]} numbers, but {len(names)} names stand above.")
    lower = [name.lower() for name in names]
    points = rows[:, [lower.index(axis) for axis in AXES]]
    columns = {printable(name): rows[:, k] for k, name in enumerate(names) if lower[k] not in AXES}
    return made_cloud(points, columns, limits)


def _refuse_matrix(rows: NDArray[np.float64]) -> None:
    """Raise :class:`ReadError` for the matrix of a camera's intrinsics (3, 3) or of a pose (4, 4).

    Folders of depth images have files of both, whose lines could be points.
    """
    size = len(rows)
    if rows.shape != (size, size) or size not in (3, 4) or rows[-1].tolist() != [0.0] * (size - 1) + [1.0]:
        return
    if size == 3 and rows[1, 0] == 0.0 and (rows[[0, 1], [0, 1]] > 0.0).all():
        raise ReadError(
            "cloud.intrinsics",
            "The file holds the 3 × 3 matrix of a camera's intrinsics, no points; open the folder of depth images that "
            "it belongs to.",
        )
    if size == 4 and np.allclose(rows[:3, :3] @ rows[:3, :3].T, np.eye(3), atol=1e-3):
        raise ReadError(
            "cloud.pose",
            "The file holds the 4 × 4 matrix of a pose, no points; open the folder of images that it belongs to.",
        )


def _usual_names(rows: NDArray[np.float64]) -> list[str]:
    more = rows.shape[1] - 3
    if more == 1:
        return [*AXES, "intensity"]
    if more in (3, 4):
        last = rows[:, -3:]
        is_colour = bool(((last == np.round(last)) & (last >= 0) & (last <= 255)).all()) and last.max(initial=0.0) > 1.0
        intensity = ["intensity"] if more == 4 else []
        return [*AXES, *intensity, *(COLOURS if is_colour else NORMALS)]
    return [*AXES, *(f"column {k + 4}" for k in range(more))]


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
