"""Cells that a line crosses, as in the two papers, step by step in plain Python.

Bresenham, Algorithm for computer control of a digital plotter, IBM Systems Journal 4 (1965); Amanatides & Woo, A fast
voxel traversal algorithm for ray tracing, Eurographics (1987). :mod:`mapper.mapping.kernels.bresenham` and
:mod:`mapper.mapping.kernels.amanatides_woo` are the fast versions.
"""

from __future__ import annotations

from math import inf

from mapper.grid.kernels.lattice import cell_of

Cell = tuple[int, int]  #: row, column
Point = tuple[float, float]  #: column, row, in cells, not floored


def bresenham(start: Cell, end: Cell) -> list[Cell]:
    """Return the cells (row, col) of the line from ``start`` to ``end``, both included, in order.

    Each cell is one step along the longer axis; the sign of ∇ decides whether to step along the shorter one as well.
    Works in all eight octants by stepping with the signs of the differences and by swapping the axes of a steep line.
    """
    (row, col), (d_row, d_col) = start, (end[0] - start[0], end[1] - start[1])
    step_row, step_col = (1 if d_row >= 0 else -1), (1 if d_col >= 0 else -1)
    steep = abs(d_row) > abs(d_col)
    a, b = (abs(d_row), abs(d_col)) if steep else (abs(d_col), abs(d_row))

    cells = [(row, col)]
    nabla = 2 * b - a
    for _ in range(a):
        diagonal = nabla >= 0
        if steep or diagonal:
            row += step_row
        if not steep or diagonal:
            col += step_col
        nabla += 2 * b - 2 * a if diagonal else 2 * b
        cells.append((row, col))
    return cells


def amanatides_woo(start: Point, end: Point) -> list[Cell]:
    """Return every cell (row, col) that the segment from ``start`` to ``end`` crosses, in order.

    The points are lattice coordinates (column, row), in cells. t runs along the segment from 0 to 1. The next border is
    the column's or the row's, whichever has the smaller t; at an exact corner the row's comes first.
    """
    (u, v), (d_u, d_v) = start, (end[0] - start[0], end[1] - start[1])
    (col, row), (end_col, end_row) = (int(cell_of(u)), int(cell_of(v))), (int(cell_of(end[0])), int(cell_of(end[1])))
    step_row, step_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)

    cells = [(row, col)]
    while (row, col) != (end_row, end_col):
        border_row, border_col = (row + 1 if step_row > 0 else row), (col + 1 if step_col > 0 else col)
        t_row = (border_row - v) / d_v if row != end_row else inf
        t_col = (border_col - u) / d_u if col != end_col else inf
        if t_col < t_row:
            col += step_col
        else:
            row += step_row
        cells.append((row, col))
    return cells
