"""Dijkstra's algorithm and A* on a costmap in plain Python: the reference for the compiled functions.

Sources: Dijkstra, A Note on Two Problems in Connexion with Graphs, 1959; Hart, Nilsson & Raphael, A Formal Basis for
the Heuristic Determination of Minimum Cost Paths, 1968.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array

#: (rows, columns) to the eight neighbours; of two equally cheap predecessors the first is used
NEIGHBOURS = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))
Cell = tuple[int, int]


def neighbours(costs: UInt8Array, table: Float64Array, cell: Cell) -> Iterator[tuple[Cell, float]]:
    """Yield each cell reachable by one step from ``cell``, and the step's length in cells.

    ``table`` (256,) has the cost of a step onto each value, infinity for blocked. A diagonal step must not pass between
    two blocked cells.
    """
    rows, cols = costs.shape
    row, col = cell
    for d_row, d_col in NEIGHBOURS:
        to = row + d_row, col + d_col
        if not (0 <= to[0] < rows and 0 <= to[1] < cols) or math.isinf(table[costs[to]]):
            continue
        if d_row and d_col and math.isinf(table[costs[row, to[1]]]) and math.isinf(table[costs[to[0], col]]):
            continue
        yield to, math.sqrt(2.0) if d_row and d_col else 1.0


def dijkstra(costs: UInt8Array, table: Float64Array, start: Cell, goal: Cell | None) -> Float64Array:
    """Return the cost-to-come (rows, cols) from ``start`` of the cells that cost no more than ``goal``; infinity
    elsewhere.

    If the goal is unreachable or absent, it covers all reachable cells.
    """
    potential = np.full(costs.shape, np.inf)
    potential[start] = 0.0
    queue = [(0.0, start)]
    while queue:
        cost, cell = heapq.heappop(queue)
        if cost > potential[cell]:
            continue
        if cell == goal:
            break
        for to, length in neighbours(costs, table, cell):
            new = cost + float(table[costs[to]]) * length
            if new < potential[to]:
                potential[to] = new
                heapq.heappush(queue, (new, to))
    if goal is not None:
        potential[potential > potential[goal]] = np.inf
    return potential


def octile_distance(a: Cell, b: Cell) -> float:
    """Return the length in cells of the shortest path between two cells by straight and diagonal steps."""
    d_row, d_col = abs(a[0] - b[0]), abs(a[1] - b[1])
    return max(d_row, d_col) + (math.sqrt(2.0) - 1.0) * min(d_row, d_col)


def a_star(costs: UInt8Array, table: Float64Array, start: Cell, goal: Cell) -> Float64Array:
    """Return the cost-to-come (rows, cols) of the cells expanded by A*; infinity elsewhere.

    The heuristic is the octile distance times the minimum cost of a step, which is admissible. Cells with equal
    estimates are expanded in row-major order.
    """
    least = float(table.min())
    potential = np.full(costs.shape, np.inf)
    potential[start] = 0.0
    expanded = np.zeros(costs.shape, dtype=np.bool_)
    queue = [(least * octile_distance(start, goal), start)]
    while queue:
        _, cell = heapq.heappop(queue)
        if expanded[cell]:
            continue
        expanded[cell] = True
        if cell == goal:
            break
        for to, length in neighbours(costs, table, cell):
            new = float(potential[cell]) + float(table[costs[to]]) * length
            if not expanded[to] and new < potential[to]:
                potential[to] = new
                heapq.heappush(queue, (new + least * octile_distance(to, goal), to))
    potential[~expanded] = np.inf
    return potential


def path_back(costs: UInt8Array, table: Float64Array, potential: Float64Array, start: Cell, goal: Cell) -> Int64Array:
    """Return the cells (n, 2) of the cheapest path from ``start`` to ``goal``, both of which have a cost-to-come."""
    cells = [goal]
    while cells[-1] != start:
        here = cells[-1]
        best, before = math.inf, here
        for d_row, d_col in NEIGHBOURS:
            cell = here[0] + d_row, here[1] + d_col
            if not (0 <= cell[0] < costs.shape[0] and 0 <= cell[1] < costs.shape[1]):
                continue
            for to, length in neighbours(costs, table, cell):
                cost = float(potential[cell]) + float(table[costs[here]]) * length
                if to == here and cost < best:
                    best, before = cost, cell
        cells.append(before)
    return np.array(cells[::-1], dtype=np.int64)
