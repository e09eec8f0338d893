"""One cell after many readings, against closed forms and the Bayes filter in probabilities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_log, integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory

HERE = (0.5, 0.5, 0.0)


def reading(z: float) -> LaserScan:
    return LaserScan(np.array([z], dtype=np.float32), 0.0, 0.01, 0.0, 80.0)


def grid_of(config: MappingConfig) -> OccupancyGrid:
    return OccupancyGrid(GridGeometry(1.0, 1, 10), config.log_odds_prior)


#: Cell (0, 3) is hit by a reading of 3 m and passed by one of 5 m.
CELL, HIT, MISS = (0, 3), reading(3.0), reading(5.0)


@given(st.lists(st.booleans(), max_size=40), st.floats(0.05, 0.45), st.floats(0.55, 0.95), st.floats(-1, 1))
def test_sequence_of_readings_is_the_bayes_filter(hits: list[bool], p_free: float, p_occ: float, prior: float) -> None:
    p_prior = 1 / (1 + np.exp(-prior))
    config = MappingConfig(
        model="step_window",
        p_free=min(p_free, 0.99 * p_prior),
        p_occ=max(p_occ, 1.01 * p_prior),
        clamp=False,
        log_odds_prior=prior,
        resolution=1.0,
    )
    grid = grid_of(config)
    p = p_prior
    for hit in hits:
        integrate_scan(grid, HIT if hit else MISS, HERE, config)
        # Bayes with the inverse model: p(z|m) ∝ p(m|z) / p(m), Probabilistic Robotics, section 4.2.
        p_given_z = config.p_occ if hit else config.p_free
        occupied, free = p * p_given_z / p_prior, (1 - p) * (1 - p_given_z) / (1 - p_prior)
        p = occupied / (occupied + free)
    assert grid.p_occ[CELL] == pytest.approx(p, rel=1e-4, abs=1e-6)


@given(st.integers(0, 50), st.integers(0, 50))
def test_hits_then_misses_in_closed_form(n_hits: int, n_misses: int) -> None:
    config = MappingConfig(resolution=1.0)
    grid = grid_of(config)
    for scan in [HIT] * n_hits + [MISS] * n_misses:
        integrate_scan(grid, scan, HERE, config)
    after_hits = min(0.85 * n_hits, 3.5)
    assert grid.log_odds[CELL] == pytest.approx(max(after_hits - 0.4 * n_misses, -2.0), abs=1e-5)
    assert grid.observed[CELL] == (n_hits + n_misses > 0)


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
def test_a_million_hits_stay_clamped_and_can_be_cleared(update: str) -> None:
    n = 500_000
    config = MappingConfig(update=update, resolution=1.0)
    log = ScanLog(
        np.full((n, 1), 3.0, dtype=np.float32),
        0.0,
        0.01,
        0.0,
        80.0,
        np.zeros(n, dtype=np.int64),
        {"still": Trajectory(np.tile(HERE, (n, 1)))},
    )
    grid = grid_of(config)
    for _ in range(2):
        integrate_log(grid, log, config)
    assert grid.log_odds[CELL] == np.float32(3.5)
    for _ in range(14):
        integrate_scan(grid, MISS, HERE, config)
    assert grid.log_odds[CELL] == np.float32(-2.0)


def test_without_the_clamp_evidence_only_adds() -> None:
    config = MappingConfig(clamp=False, resolution=1.0)
    grid = grid_of(config)
    for _ in range(100):
        integrate_scan(grid, HIT, HERE, config)
    assert grid.log_odds[CELL] == pytest.approx(85.0, rel=1e-5)
    assert grid.log_odds[0, 1] == pytest.approx(-40.0, rel=1e-5)
