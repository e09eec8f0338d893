"""Marking of endpoints and clearing along beams.

Numba twins of :func:`mapper.costmap.textbook.mark_and_clear` and :func:`mapper.costmap.textbook.line_cells`.
"""

from __future__ import annotations

from math import ceil, floor, hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.costmap.kernels.marking import Marking, include, marks
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)
_include = jit(include)
_marks = jit(marks)

Values = NDArray[Any]  #: costs uint8, or times of marking float64


@jit
def _clear_line(
    row: int, col: int, end_row: int, end_col: int, least: int, most: int, value: Any, out: Values, box: Int64Array  # noqa: ANN401
) -> None:  # fmt: skip
    """Write ``value`` into the cells of a line of :func:`mapper.costmap.textbook.line_cells`."""
    d_row, d_col = end_row - row, end_col - col
    distance = hypot(float(d_row), float(d_col))
    if distance < least:
        return
    share = 1.0
    if distance > 0.0:
        share = min(1.0, most / distance)
        row, col = int(row + d_row / distance * least), int(col + d_col / distance * least)
    step_row, step_col = (1 if d_row > 0 else -1), (1 if d_col > 0 else -1)
    by_col = abs(d_col) >= abs(d_row)
    major, minor = (abs(d_col), abs(d_row)) if by_col else (abs(d_row), abs(d_col))
    error = major // 2
    _include(box, row, col)
    for _ in range(max(min(int(share * major) - least, major), 0)):
        out[row, col] = value
        error += minor
        over = 0
        if error >= major:
            error -= major
            over = 1
        row += step_row * (over if by_col else 1)
        col += step_col * (1 if by_col else over)
    out[row, col] = value
    _include(box, row, col)


@jit
def clear_lines(
    points: Float64Array, sensor: Float64Array, frame: Frame, least: int, most: int, value: Any, out: Values,  # noqa: ANN401
    box: Int64Array,
) -> None:  # fmt: skip
    """Write ``value`` into the cells between the sensor and each of ``points`` (n, 3), clipped at the border.

    ``least`` and ``most`` are the clearing ranges in cells. ``box`` (row0, row1, col0, col1) is extended to the written
    cells. Nothing is written if the sensor (3,) is outside the grid.
    """
    rows, cols = out.shape
    o_u, o_v = _to_lattice(sensor[0], sensor[1], frame)
    if not (0.0 <= o_u < cols and 0.0 <= o_v < rows):
        return
    row, col = int(_cell_of(o_v)), int(_cell_of(o_u))
    for i in range(points.shape[0]):
        u, v = _to_lattice(points[i, 0], points[i, 1], frame)
        share = 1.0
        if u < 0.0:
            share = min(share, -o_u / (u - o_u))
        elif u >= cols:
            share = min(share, (cols - o_u) / (u - o_u))
        if v < 0.0:
            share = min(share, -o_v / (v - o_v))
        elif v >= rows:
            share = min(share, (rows - o_v) / (v - o_v))
        u, v = o_u + share * (u - o_u), o_v + share * (v - o_v)
        end_row, end_col = min(max(floor(v), 0), rows - 1), min(max(floor(u), 0), cols - 1)
        _clear_line(row, col, end_row, end_col, least, most, value, out, box)


@jit
def mark_cells(
    points: Float64Array, sensor: Float64Array, frame: Frame, marking: Marking, value: Any, out: Values,  # noqa: ANN401
    box: Int64Array,
) -> None:  # fmt: skip
    """Write ``value`` into the cells of those ``points`` (n, 3) that mark; extend ``box`` to them."""
    rows, cols = out.shape
    for i in range(points.shape[0]):
        if not _marks(points[i], sensor, marking):
            continue
        u, v = _to_lattice(points[i, 0], points[i, 1], frame)
        if 0.0 <= u < cols and 0.0 <= v < rows:
            row, col = int(_cell_of(v)), int(_cell_of(u))
            out[row, col] = value
            _include(box, row, col)


@jit
def fill_polygon(vertices: Float64Array, value: Any, out: Values, box: Int64Array) -> None:  # noqa: ANN401
    """Write ``value`` into the cells with centres inside any polygon, (n, 2) lattice coordinates (u, v)."""
    rows, cols = out.shape
    low, high = max(vertices[:, 1].min(), 0.0), min(vertices[:, 1].max(), float(rows))
    crossings = np.empty(vertices.shape[0])
    for row in range(floor(low), min(floor(high) + 1, rows)):
        v = row + 0.5
        n = 0
        for i in range(vertices.shape[0]):
            j = (i + 1) % vertices.shape[0]
            a_v, b_v = vertices[i, 1], vertices[j, 1]
            if (a_v <= v) != (b_v <= v):
                share = (v - a_v) / (b_v - a_v)
                crossings[n] = vertices[i, 0] + share * (vertices[j, 0] - vertices[i, 0])
                n += 1
        ordered = np.sort(crossings[:n])
        for k in range(0, n - 1, 2):
            first = ceil(min(max(ordered[k] - 0.5, 0.0), float(cols)))
            last = floor(min(max(ordered[k + 1] - 0.5, -1.0), cols - 1.0))
            for col in range(first, last + 1):
                out[row, col] = value
                _include(box, row, col)


@jit
def lay_over(layer: NDArray[np.uint8], method: int, master: NDArray[np.uint8]) -> None:
    """Combine a layer (rows, cols) with a master in place: 0 overwrite, 1 max, 2 max of known, 3 overwrite all.

    Numba twin of :func:`mapper.costmap.textbook.combine`.
    """
    for row in range(master.shape[0]):
        old, new = master[row], layer[row]
        for k in range(old.shape[0]):
            known = new[k] != 255
            take = known & (
                (method == 0) | ((method == 1) & ((old[k] == 255) | (old[k] < new[k])))
                | ((method == 2) & (old[k] != 255) & (old[k] < new[k]))
            )  # fmt: skip
            if take or method == 3:
                old[k] = new[k]
