"""Entropy and counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.metrics import entropy, map_metrics


@given(st.floats(-20, 20))
def test_entropy_is_the_definition(value: float) -> None:
    p = 1 / (1 + np.exp(-value))
    q = 1 / (1 + np.exp(value))
    assert entropy(value) == pytest.approx(-p * np.log2(p) - q * np.log2(q), abs=1e-12)


def test_entropy_at_the_ends() -> None:
    assert entropy([0.0, np.inf, -np.inf, 1000.0]).tolist() == [1.0, 0.0, 0.0, 0.0]


def test_a_map_in_figures() -> None:
    grid = OccupancyGrid(GridGeometry(1.0, 2, 3))
    grid.log_odds[0] = [3.0, -3.0, 0.0]
    grid.observed[0] = True
    metrics = map_metrics(grid)
    assert (metrics.occupied, metrics.free, metrics.unknown, metrics.never_observed) == (1, 1, 4, 3)
    assert metrics.entropy_bits == pytest.approx(1 + 2 * float(entropy(3.0)))
