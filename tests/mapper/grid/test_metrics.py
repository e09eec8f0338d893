"""Entropy and counts."""

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid, log_odds
from mapper.grid.metrics import entropy, map_metrics


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


def test_information_gain_is_the_decrease_of_entropy() -> None:
    prior = np.full((1, 4), np.nan, dtype=np.float32)
    prior[0, 1] = 2.0
    grid = OccupancyGrid(GridGeometry(1.0, 1, 4), prior_map=prior)
    grid.log_odds[0, :3] = [2.0, -0.5, 0.0]
    grid.observed[0, :3] = True
    surer, less_sure = 1 - float(entropy(2.0)), float(entropy(2.0)) - float(entropy(0.5))
    assert map_metrics(grid).information_gain_bits == pytest.approx(surer + less_sure)


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_the_figures_are_those_of_a_plain_loop(seed: int, has_prior_map: bool) -> None:
    random = np.random.default_rng(seed)
    shape = (int(random.integers(1, 40)), int(random.integers(1, 40)))
    # Few distinct values, and many; with both zeros, the infinities, and the thresholds themselves.
    values = random.normal(0, 3, shape).astype(np.float32)
    special = np.array([0.0, -0.0, np.inf, -np.inf, 3.5, -2.0, log_odds(0.65), log_odds(0.25)], dtype=np.float32)
    picked = random.random(shape) < 0.5
    values[picked] = random.choice(special, shape)[picked]
    prior_map = None
    if has_prior_map:
        prior_map = np.where(random.random(shape) < 0.5, random.normal(0, 2, shape), np.nan).astype(np.float32)
    grid = OccupancyGrid(GridGeometry(0.1, *shape), 0.3, prior_map)
    grid.log_odds[:] = values
    grid.observed[:] = random.random(shape) < 0.7

    def bits(value: float) -> float:
        odds = math.exp(-abs(value))
        p, q = 1 / (1 + odds), odds / (1 + odds)
        return -p * math.log2(p) - (q * math.log2(q) if q > 0 else 0)

    left, gained, states = [], [], []
    prior = grid.prior()
    for cell in np.ndindex(shape):
        if not grid.observed[cell]:
            continue
        value = float(grid.log_odds[cell])
        left.append(bits(value))
        gained.append(bits(float(prior[cell])) - bits(value))
        states.append(1 if value > math.log(0.65 / 0.35) else -1 if value < math.log(0.25 / 0.75) else 0)
    found = map_metrics(grid)
    assert found.entropy_bits == pytest.approx(math.fsum(left), rel=1e-12, abs=1e-12)
    assert found.information_gain_bits == pytest.approx(math.fsum(gained), rel=1e-12, abs=1e-10)
    state = grid.classify()
    assert (found.occupied, found.free) == (states.count(1), states.count(-1))
    assert (found.occupied, found.free) == (int((state == 100).sum()), int((state == 0).sum()))
    assert found.unknown == state.size - found.occupied - found.free
    assert found.never_observed == state.size - len(left)


def test_bad_thresholds_are_refused() -> None:
    with pytest.raises(ConfigError, match="Thresholds must satisfy"):
        map_metrics(OccupancyGrid(GridGeometry(1.0, 2, 3)), 0.2, 0.4)


@pytest.mark.parametrize("has_prior_map", [False, True])
def test_the_figures_need_no_array_of_the_maps_size(has_prior_map: bool) -> None:
    geometry = GridGeometry(0.1, 2000, 2000)
    prior_map = np.full(geometry.shape, 0.1, dtype=np.float32) if has_prior_map else None
    grid = OccupancyGrid(geometry, prior_map=prior_map)
    grid.observed[:] = True
    map_metrics(grid)  # compiled, or loaded from the cache
    tracemalloc.start()
    try:
        map_metrics(grid)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < geometry.rows * geometry.cols / 10
