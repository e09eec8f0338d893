"""Lists of the cells that beams cross, with distances, for sensor models evaluated outside the kernels.

Cells and order are those of :func:`mapper.mapping.kernels.bresenham.draw_lines` and
:func:`mapper.mapping.kernels.amanatides_woo.draw_rays`: beam by beam, the cell with the beam's endpoint last.
"""

from __future__ import annotations

from math import inf, isnan, sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import cell_of
from mapper.mapping.kernels.amanatides_woo import END_U, END_V, HALF, HIT_U, HIT_V, U, V, Z
from mapper.mapping.kernels.bresenham import AT, COL, END_COL, END_ROW, FAR, HIT_COL, HIT_ROW, ROW

_cell_of = jit(cell_of)


@jit
def cells_of_lines(
    lines: Int32Array,
    z: Float64Array,
    u: float,
    v: float,
    resolution: float,
    shape: tuple[int, int],
    cells: Int64Array,
    beams: Int64Array,
    s: Float64Array,
) -> int:
    """List the cells of ``lines`` (9, n_beams) written by :func:`mapper.mapping.kernels.bresenham.plan_lines`.

    Return the number of cells. ``z`` (n_beams,) metres are the readings, +inf for no return; (u, v) is the sensor in
    lattice coordinates. Cells outside the grid of ``shape`` (rows, cols) are omitted. Written, each (m,): ``cells``,
    row · cols + col; ``beams``, the beam index; ``s``, metres from the sensor to the cell's centre, or z for the cell
    that holds the endpoint.
    """
    rows, cols = shape
    count = 0
    for j in range(lines.shape[1]):
        row, col = int(lines[ROW, j]), int(lines[COL, j])
        end_row, end_col = int(lines[END_ROW, j]), int(lines[END_COL, j])
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        twice = max(2 * major, 1)
        at = int(lines[AT, j])
        for i in range(min(int(lines[FAR, j]), major + 1)):
            n = (2 * i * minor + major) // twice
            r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
            if i == at or not (0 <= r < rows and 0 <= c < cols):
                continue
            d_u, d_v = c + 0.5 - u, r + 0.5 - v
            cells[count], beams[count], s[count] = r * cols + c, j, sqrt(d_u * d_u + d_v * d_v) * resolution
            count += 1
        r, c = int(lines[HIT_ROW, j]), int(lines[HIT_COL, j])
        if z[j] < inf and 0 <= r < rows and 0 <= c < cols:
            cells[count], beams[count], s[count] = r * cols + c, j, z[j]
            count += 1
    return count


@jit
def cells_of_rays(
    rays: Float64Array,
    resolution: float,
    shape: tuple[int, int],
    cells: Int64Array,
    beams: Int64Array,
    s: Float64Array,
) -> int:
    """List the cells of ``rays`` (n_beams, 8) written by :func:`mapper.mapping.kernels.amanatides_woo.plan_rays`.

    Otherwise like :func:`cells_of_lines`.
    """
    rows, cols = shape
    count = 0
    for j in range(rays.shape[0]):
        ray = rays[j]
        if isnan(ray[Z]):
            continue
        u, v, d_u, d_v, z, half = ray[U], ray[V], ray[END_U] - ray[U], ray[END_V] - ray[V], ray[Z], ray[HALF]
        row, col = int(_cell_of(v)), int(_cell_of(u))
        end_row, end_col = int(_cell_of(ray[END_V])), int(_cell_of(ray[END_U]))
        hit_row, hit_col = int(_cell_of(ray[HIT_V])), int(_cell_of(ray[HIT_U]))
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        ahead_row, ahead_col = (1 if s_row > 0 else 0), (1 if s_col > 0 else 0)
        t_row = (row + ahead_row - v) / d_v if row != end_row else inf
        t_col = (col + ahead_col - u) / d_u if col != end_col else inf
        while True:
            is_hit = z < inf and row == hit_row and col == hit_col
            if not is_hit and 0 <= row < rows and 0 <= col < cols:
                c_u, c_v = col + 0.5 - u, row + 0.5 - v
                distance = sqrt(c_u * c_u + c_v * c_v) * resolution
                if half == 0.0 or distance <= z + half:
                    cells[count], beams[count], s[count] = row * cols + col, j, distance
                    count += 1
            if row == end_row and col == end_col:
                break
            if t_col < t_row:
                col += s_col
                t_col = (col + ahead_col - u) / d_u if col != end_col else inf
            else:
                row += s_row
                t_row = (row + ahead_row - v) / d_v if row != end_row else inf
        if z < inf and 0 <= hit_row < rows and 0 <= hit_col < cols:
            cells[count], beams[count], s[count] = hit_row * cols + hit_col, j, z
            count += 1
    return count


@jit
def add_increments(
    log_odds: Float32Array,
    observed: BoolArray,
    cells: Int64Array,
    increments: Float32Array,
    low: np.float32,
    high: np.float32,
) -> None:
    """Add ``increments`` (m,) to ``cells`` (m,) of the flat arrays in order, clamping after each, in float32."""
    for i in range(len(cells)):
        cell = cells[i]
        log_odds[cell] = min(max(log_odds[cell] + increments[i], low), high)
        observed[cell] = True
