"""Shortest paths of the explorer, against SciPy's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from mapper.simulation.kernels.shortest_paths import shortest_paths


def expected(cost: NDArray[np.float64], start: tuple[int, int]) -> NDArray[np.float64]:
    """Distances (rows, cols) by SciPy on the graph of all steps."""
    rows, cols = cost.shape
    passes = np.isfinite(cost)
    tails, heads, weights = [], [], []
    for r, c in np.ndindex(rows, cols):
        for dr, dc in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
            a, b = r + dr, c + dc
            if not (0 <= a < rows and 0 <= b < cols and passes[a, b] and (passes[r, c] or (r, c) == start)):
                continue
            if dr and dc and not (passes[r, b] and passes[a, c]):
                continue
            here = cost[r, c] if passes[r, c] else cost[a, b]
            tails.append(r * cols + c)
            heads.append(a * cols + b)
            weights.append(0.5 * (here + cost[a, b]) * math.hypot(dr, dc))
    graph = coo_array((weights, (tails, heads)), shape=(cost.size, cost.size)).tocsr()
    found: NDArray[np.float64] = dijkstra(graph, indices=start[0] * cols + start[1])
    return found.reshape(cost.shape)


# A greatest cost of 1e9 needs more buckets than there are.
@pytest.mark.parametrize(("greatest", "blocked"), [(1.0, 0.0), (7.0, 0.3), (1e4, 0.2), (1e9, 0.2)])
def test_distances_are_those_of_scipy_and_parents_lead_to_the_start(greatest: float, blocked: float) -> None:
    rng = np.random.default_rng(7)
    for shape in ((1, 1), (17, 23), (30, 9)):
        cost = greatest ** rng.random(shape)
        cost[rng.random(shape) < blocked] = np.inf
        start = (int(rng.integers(shape[0])), int(rng.integers(shape[1])))
        distance, parent = np.empty(shape), np.empty(shape, dtype=np.int64)
        shortest_paths(cost, *start, distance, parent)
        np.testing.assert_allclose(distance, expected(cost, start), rtol=1e-12)
        assert parent[start] == -1
        assert np.array_equal(parent >= 0, np.isfinite(distance) & (distance > 0.0))
        before = distance.ravel()[parent[parent >= 0]]
        assert np.all(before < distance[parent >= 0])


def test_a_start_outside_the_lattice_reaches_nothing() -> None:
    distance, parent = np.empty((3, 4)), np.empty((3, 4), dtype=np.int64)
    shortest_paths(np.ones((3, 4)), 3, 0, distance, parent)
    assert np.isinf(distance).all()
    assert (parent == -1).all()
