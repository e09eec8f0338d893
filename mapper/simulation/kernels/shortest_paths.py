"""Shortest paths on a lattice of cells with a cost each."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.jit import jit


@jit
def shortest_paths(
    cost: NDArray[np.float64],
    start_row: int,
    start_col: int,
    distance: NDArray[np.float64],
    parent: NDArray[np.int64],
) -> None:
    """Write the cost of the cheapest 8-connected path from the start to every cell, and the cell before it.

    ``cost`` (rows, cols) is the cost of a metre (any unit) in each cell, +inf where nothing may pass; a step costs the
    mean of its two cells times its length in cells. ``distance`` (rows, cols) is +inf where no path leads; ``parent``
    (rows, cols) holds flat indices, −1 at the start and where no path leads. A diagonal step needs both cells
    next to it to be passable. Dijkstra's algorithm with a binary heap (Cormen et al., chapter 22.3).
    """
    rows, cols = cost.shape
    distance[:, :] = np.inf
    parent[:, :] = -1
    if not (0 <= start_row < rows and 0 <= start_col < cols):
        return
    # Each cell is pushed at most once for each of its neighbours.
    keys = np.empty(8 * rows * cols + 1)
    cells = np.empty(8 * rows * cols + 1, dtype=np.int64)
    size = 1
    keys[0] = 0.0
    cells[0] = start_row * cols + start_col
    distance[start_row, start_col] = 0.0
    while size > 0:
        key, cell = keys[0], cells[0]
        size -= 1
        last_key, last_cell = keys[size], cells[size]
        hole = 0
        while True:  # sift the last entry down from the root
            child = 2 * hole + 1
            if child >= size:
                break
            if child + 1 < size and keys[child + 1] < keys[child]:
                child += 1
            if keys[child] >= last_key:
                break
            keys[hole], cells[hole] = keys[child], cells[child]
            hole = child
        keys[hole], cells[hole] = last_key, last_cell
        row, col = cell // cols, cell % cols
        if key > distance[row, col]:
            continue  # an older, dearer entry of this cell
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                r, c = row + dr, col + dc
                if (dr == 0 and dc == 0) or not (0 <= r < rows and 0 <= c < cols) or not np.isfinite(cost[r, c]):
                    continue
                if dr != 0 and dc != 0 and not (np.isfinite(cost[row, c]) and np.isfinite(cost[r, col])):
                    continue
                # The start itself may be impassable: only the cell that is entered counts then.
                here = cost[row, col] if np.isfinite(cost[row, col]) else cost[r, c]
                new = key + 0.5 * (here + cost[r, c]) * math.sqrt(dr * dr + dc * dc)
                if new < distance[r, c]:
                    distance[r, c] = new
                    parent[r, c] = cell
                    hole = size
                    size += 1
                    while hole > 0 and keys[(hole - 1) // 2] > new:  # sift up
                        keys[hole], cells[hole] = keys[(hole - 1) // 2], cells[(hole - 1) // 2]
                        hole = (hole - 1) // 2
                    keys[hole], cells[hole] = new, r * cols + c
