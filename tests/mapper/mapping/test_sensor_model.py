"""The profile along a beam, against the books' tables and against the map of one reading."""

from math import lgamma

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid, log_odds, probability
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.sensor_model import (
    FixedIncrements,
    HitCounting,
    MoravecElfes,
    SmoothRamp,
    SonarCone,
    StepWindow,
    beam_profile,
)
from mapper.sensors.scan import LaserScan


def test_fixed_increments_have_octomaps_values() -> None:
    model = FixedIncrements()
    assert (model.log_odds_miss, model.log_odds_hit, model.window) == (-0.4, 0.85, 0.0)


def test_step_window_is_table_9_2_in_log_odds() -> None:
    model = StepWindow(p_free=0.3, p_prior=0.5, p_occ=0.9, window=0.4)
    s = [0.0, 1.0, 1.79, 1.81, 2.0, 2.19, 2.21, 5.0]
    expected = [np.log(0.3 / 0.7)] * 3 + [np.log(9)] * 3 + [0.0] * 2
    np.testing.assert_allclose(beam_profile(model, 2.0, s), expected)


def test_evidence_is_counted_from_the_prior() -> None:
    model = StepWindow(p_free=0.3, p_prior=0.4, p_occ=0.9)
    assert model.log_odds_miss == pytest.approx(log_odds(0.3) - log_odds(0.4))
    assert model.log_odds_hit == pytest.approx(log_odds(0.9) - log_odds(0.4))


def test_no_return_adds_nothing_or_free_evidence() -> None:
    model, s = FixedIncrements(), [0.0, 5.0, 10.0, 10.1]
    for z in (np.inf, 12.0):
        assert beam_profile(model, z, s, 10.0).tolist() == [0.0] * 4
        assert beam_profile(model, z, s, 10.0, no_return="free").tolist() == [-0.4, -0.4, -0.4, 0.0]


@pytest.mark.parametrize("z", [np.nan, -np.inf, -1.0])
def test_an_invalid_reading_adds_nothing(z: float) -> None:
    assert not beam_profile(FixedIncrements(), z, np.linspace(0, 10, 50), 10.0, no_return="free").any()


@given(st.floats(0.5, 9.0), st.floats(0.05, 2.0), st.sampled_from(["per_beam", "per_scan"]))
def test_the_profile_equals_the_update_of_the_map(z: float, window: float, update: str) -> None:
    config = MappingConfig(update=update, window=window, clamp=False, resolution=0.1)
    z = float(np.float32(z))
    grid = OccupancyGrid(GridGeometry(0.1, 1, 130))
    integrate_scan(grid, LaserScan(np.array([z], dtype=np.float32), 0.0, 0.5, 0.0, 80.0), (0.0, 0.05, 0.0), config)
    s = np.arange(130) * 0.1 + 0.05
    expected = beam_profile(config.beam_model(), z, s)
    # The cell that holds the endpoint is a hit in any case; a centre on a zone's border goes either way.
    sure = (np.abs(np.abs(s - z) - window / 2) > 1e-6) & (np.arange(130) != int(z / 0.1))
    row = grid.geometry.world_to_cell((0.0, 0.05))[0]
    np.testing.assert_allclose(grid.log_odds[row, : len(s)][sure], expected[sure].astype(np.float32))


def test_a_no_return_taken_for_a_hit_is_a_reading_of_the_max_range() -> None:
    s = np.linspace(0, 12, 100)
    mistaken = beam_profile(FixedIncrements(window=0.5), np.inf, s, 10.0, no_return="hit")
    np.testing.assert_array_equal(mistaken, beam_profile(FixedIncrements(window=0.5), 10.0, s, 10.0))


@given(st.floats(0.0, 20.0), st.floats(0.01, 0.5), st.floats(0.0, 0.2))
def test_the_ramp_has_no_step_and_widens_with_the_range(z: float, sigma: float, growth: float) -> None:
    model = SmoothRamp(-0.4, 0.85, sigma, growth)
    spread = sigma + growth * z
    s = z + spread * np.array([-2.0, -1.0, 0.0, 1.0, 2.0, 2.1])
    # The cubic passes half of its way in the middle.
    np.testing.assert_allclose(model.increment(s, z), [-0.4, 0.225, 0.85, 0.425, 0.0, 0.0], atol=1e-9)
    fine = z + spread * np.linspace(-2.5, 2.5, 5001)
    steps = np.abs(np.diff(model.increment(fine, z)))
    assert steps.max() < 1.6 * 1.25 * 5.0 / 5000  # the cubic is steepest in its middle: 1.5 × its mean slope


def test_a_flat_cone_is_table_9_2_with_its_opening_angle() -> None:
    model = SonarCone(-0.4, 0.85, window=0.4, opening=0.5)
    s, theta = np.array([[1.0], [2.0], [3.0]]), np.array([-0.26, -0.25, 0.0, 0.25, 0.26])
    expected = np.zeros((3, 5))
    expected[:2, 1:4] = [[-0.4], [0.85]]
    np.testing.assert_array_equal(model.increment(s, 2.0, theta), expected)


def test_the_gaussian_cone_fades_off_axis_and_along_the_range() -> None:
    model = SonarCone(-0.4, 0.85, window=0.4, opening=0.5, profile="gaussian")
    half = np.exp(-0.5)  # at one σ, a quarter of the opening angle
    assert model.increment(0.0, 2.0) == pytest.approx(-0.4)
    assert model.increment(0.9, 2.0) == pytest.approx(-0.4 * 0.75)
    assert model.increment(2.0, 2.0, 0.125) == pytest.approx(0.85 * half)
    assert model.increment(2.1, 2.0) == pytest.approx(0.85 * 0.75)
    assert model.increment(1.8, 2.0) == pytest.approx(0.0, abs=1e-9)


def test_certainties_of_1985() -> None:
    model = MoravecElfes(window=0.4, opening=0.5)
    assert model.empty(0.0, 2.0) == 1.0
    assert model.empty(0.9, 2.0, 0.125) == pytest.approx(0.75 * 0.75)
    assert model.occupied(2.0, 2.0) == 1.0
    assert model.occupied(1.9, 2.0, -0.125) == pytest.approx(0.75 * 0.75)
    assert not model.occupied([1.7, 2.3], 2.0).any()
    assert not model.empty([1.9, 2.0], 2.0).any()
    # The greater certainty is shown, that of "empty" as a probability below one half.
    shown = 1 / (1 + np.exp(-model.log_odds([0.0, 0.6, 0.6], [0.0, 0.2, 0.8])))
    np.testing.assert_allclose(shown, [0.5, 0.2, 0.9])


@given(st.integers(0, 500), st.integers(0, 500), st.floats(0.1, 50.0), st.floats(0.05, 0.95))
def test_counting_gives_the_mean_of_the_beta_posterior(hits: int, misses: int, weight: float, prior: float) -> None:
    model = HitCounting(weight, prior)
    a, b = hits + weight * prior, misses + weight * (1 - prior)
    # ∫ θ · θ^(a−1) (1−θ)^(b−1) dθ over the same without θ: two values of the beta function, by their gammas.
    mean = np.exp(lgamma(a + 1) - lgamma(a) + lgamma(a + b) - lgamma(a + b + 1))
    assert float(probability(model.log_odds(hits, misses))) == pytest.approx(mean, rel=1e-9)


def test_counting_gives_one_half_for_a_cell_that_reflects_half_of_its_beams() -> None:
    counted, believed = (
        OccupancyGrid(GridGeometry(1.0, 1, 10)),
        OccupancyGrid(GridGeometry(1.0, 1, 10)),
    )
    for z in (5.5, 8.5) * 50:
        scan = LaserScan(np.array([z], dtype=np.float32), 0.0, 0.5, 0.0, 80.0)
        integrate_scan(counted, scan, (0.5, 0.5, 0.0), MappingConfig(model="hit_counting", resolution=1.0))
        integrate_scan(believed, scan, (0.5, 0.5, 0.0), MappingConfig(resolution=1.0))
    assert counted.p_occ[0, 6] == pytest.approx(0.5)
    assert believed.p_occ[0, 6] > 0.9
    assert counted.cell_statistics is not None
    assert counted.cell_statistics[:, 0, 6].tolist() == [50.0, 50.0]


@pytest.mark.parametrize("model", ["hit_counting", "moravec_elfes"])
def test_models_of_two_kinds_do_not_mix_in_one_grid(model: str) -> None:
    scan = LaserScan(np.array([5.5], dtype=np.float32), 0.0, 0.5, 0.0, 80.0)
    for first, second in ((model, "fixed_increments"), ("fixed_increments", model)):
        grid = OccupancyGrid(GridGeometry(1.0, 1, 10))
        integrate_scan(grid, scan, (0.5, 0.5, 0.0), MappingConfig(model=first, resolution=1.0))
        with pytest.raises(ConfigError, match="another kind of model"):
            integrate_scan(grid, scan, (0.5, 0.5, 0.0), MappingConfig(model=second, resolution=1.0))


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda: FixedIncrements(log_odds_miss=0.1), "model.miss"),
        (lambda: FixedIncrements(log_odds_miss=-np.inf), "model.miss"),
        (lambda: FixedIncrements(log_odds_hit=-0.1), "model.hit"),
        (lambda: FixedIncrements(log_odds_hit=np.nan), "model.hit"),
        (lambda: FixedIncrements(window=-1.0), "model.window"),
        (lambda: StepWindow(window=np.inf), "model.window"),
        (lambda: StepWindow(p_free=0.0), "model.probabilities"),
        (lambda: StepWindow(p_free=0.6), "model.probabilities"),
        (lambda: StepWindow(p_occ=1.0), "model.probabilities"),
        (lambda: StepWindow(p_occ=0.4, p_free=0.3), "model.probabilities"),
        (lambda: SmoothRamp(sigma=0.0), "model.sigma"),
        (lambda: SmoothRamp(sigma_growth=-0.1), "model.sigma_growth"),
        (lambda: SonarCone(opening=0.0), "model.opening"),
        (lambda: SonarCone(opening=4.0), "model.opening"),
        (lambda: SonarCone(profile="square"), "model.profile"),  # type: ignore[arg-type]
        (lambda: MoravecElfes(window=np.nan), "model.window"),
        (lambda: HitCounting(prior_weight=0.0), "model.prior_weight"),
        (lambda: HitCounting(p_prior=1.0), "model.prior"),
    ],
)
def test_an_impossible_model_is_refused(make, code: str) -> None:
    with pytest.raises(ConfigError) as refused:
        make()
    assert refused.value.code == code
