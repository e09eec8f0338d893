"""Entropy and counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.metrics import entropy, expected_information_gain, information_gain, map_metrics


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


def test_information_gain_is_what_was_open_less_what_is() -> None:
    prior = np.full((1, 4), np.nan, dtype=np.float32)
    prior[0, 1] = 2.0
    grid = OccupancyGrid(GridGeometry(1.0, 1, 4), prior_map=prior)
    grid.log_odds[0, :3] = [2.0, -0.5, 0.0]
    grid.observed[0, :3] = True
    surer, less_sure = 1 - float(entropy(2.0)), float(entropy(2.0)) - float(entropy(0.5))
    np.testing.assert_allclose(information_gain(grid), [[surer, less_sure, 0.0, 0.0]])
    assert map_metrics(grid).information_gain_bits == pytest.approx(surer + less_sure)


@given(st.floats(-6, 6), st.floats(-3, 0), st.floats(0, 3))
def test_expected_gain_is_the_mutual_information_of_cell_and_look(prior: float, miss: float, hit: float) -> None:
    gain = float(expected_information_gain(prior, miss, hit))
    # Independently: the table of joint probabilities of a cell and a look whose posteriors these are.
    p, p_miss, p_hit = (1 / (1 + np.exp(-(prior + step))) for step in (0.0, miss, hit))
    if p_hit - p_miss < 1e-9:
        assert gain == pytest.approx(0.0, abs=1e-9)
        return
    look = (p - p_miss) / (p_hit - p_miss)
    joint = np.array([[look * p_hit, look * (1 - p_hit)], [(1 - look) * p_miss, (1 - look) * (1 - p_miss)]])
    apart = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    assert gain == pytest.approx(
        float(np.sum(joint * np.log2(np.maximum(joint, 1e-300) / np.maximum(apart, 1e-300)))), abs=1e-9
    )
