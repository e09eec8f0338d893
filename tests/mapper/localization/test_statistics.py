"""The random parts of the filter against closed forms, with fixed seeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from mapper.core.se2 import wrap_angle
from mapper.localization import LocalizationConfig, textbook
from mapper.localization.motion import anywhere, key_of, motion_between, move
from mapper.localization.resample import drawn, resampled
from mapper.localization.weighing import logarithm_of_mean
from tests.mapper.localization.rooms import model_of, two_rooms

N = 40_000


@pytest.mark.parametrize(
    ("weights", "values"),
    [([0.25, 0.75], [-900.0, -901.0]), ([0.0, 1.0], [0.0, -900.0]), ([0.0, 1e-300, 1.0], [5.0, -3.0, -2000.0])],
)
def test_the_logarithm_of_a_mean_heeds_weights_of_0_whose_likelihood_is_the_greatest(
    weights: list[float], values: list[float]
) -> None:
    found = logarithm_of_mean(np.array(weights), np.array(values))
    assert found == pytest.approx(logsumexp(values, b=weights), rel=1e-12)


def test_errors_of_the_motion_model_have_the_variances_of_table_5_6():
    config = LocalizationConfig(alpha1=0.05, alpha2=0.01, alpha3=0.02, alpha4=0.03)
    before, after = np.zeros(3), np.array([0.8, 0.3, 0.9])
    particles = np.zeros((N, 3))
    move(particles, motion_between(before, after, config), key_of(4, 1, 0))
    # Turn, distance and turn of each particle, from where it came out.
    turn_1 = np.arctan2(particles[:, 1], particles[:, 0])
    distance = np.hypot(particles[:, 0], particles[:, 1])
    turn_2 = wrap_angle(particles[:, 2] - turn_1)
    r1, d = math.atan2(0.3, 0.8), math.hypot(0.8, 0.3)
    r2 = 0.9 - r1
    for found, mean, variance in (
        (turn_1, r1, 0.05 * r1**2 + 0.01 * d**2),
        (distance, d, 0.02 * d**2 + 0.03 * (r1**2 + r2**2)),
        (turn_2, r2, 0.05 * r2**2 + 0.01 * d**2),
    ):
        assert stats.kstest((found - mean) / math.sqrt(variance), "norm").pvalue > 0.01
    assert abs(np.corrcoef(turn_1, turn_2)[0, 1]) < 0.02
    assert abs(np.corrcoef(turn_1, distance)[0, 1]) < 0.02


def test_density_of_table_5_5_is_that_of_the_samples_of_table_5_6():
    config = LocalizationConfig(alpha1=0.05, alpha2=0.01, alpha3=0.02, alpha4=0.03)
    before, after = np.zeros(3), np.array([0.8, 0.3, 0.9])
    alphas = (0.05, 0.01, 0.02, 0.03)
    control = textbook.odometry_control(before, after)
    particles = np.zeros((10 * N, 3))
    move(particles, motion_between(before, after, config), key_of(5, 1, 0))
    # The share of samples in a box around a pose, and the density there. In turn, distance and turn a volume is
    # dx dy dθ / distance. Table 5.5 takes the spreads of the pose that it judges, table 5.6 those of the odometry:
    # at the odometry's own pose they are the same.
    side = np.array([0.06, 0.06, 0.1])
    inside = (np.abs(particles - after) < side / 2).all(axis=1).mean()
    density = textbook.motion_model_odometry(after, control, before, alphas) / math.hypot(0.8, 0.3)
    assert inside / np.prod(side) == pytest.approx(density, rel=0.08)


def test_low_variance_draws_each_particle_as_often_as_its_weight_says_within_one():
    weights = np.random.default_rng(1).dirichlet(np.full(50, 0.3))
    for u in (0.0, 0.37, 0.999):
        counts = np.bincount(drawn(weights, 1000, u), minlength=50)
        assert (np.abs(counts - 1000 * weights) < 1.0).all()


def test_low_variance_draws_in_the_mean_what_the_weights_say():
    weights = np.array([0.5, 0.3, 0.15, 0.05])
    uniforms = (np.arange(400) + 0.5) / 400
    counts = np.mean([np.bincount(drawn(weights, 7, u), minlength=4) for u in uniforms], axis=0)
    np.testing.assert_allclose(counts, 7 * weights, atol=0.02)


def test_the_number_of_particles_is_that_of_fox_2003():
    # k − 1 degrees of freedom: the quantile of χ² that the bound approximates (Wilson and Hilferty).
    for k in (5, 50, 500):
        exact = stats.chi2.ppf(stats.norm.cdf(2.3263), k - 1) / (2 * 0.05)
        assert textbook.kld_number(k, 0.05, 2.3263) == pytest.approx(exact, rel=0.01)


def test_few_particles_stand_for_a_narrow_belief_and_many_for_a_wide_one():
    config = LocalizationConfig()
    rng = np.random.default_rng(2)
    narrow = np.column_stack([rng.normal(2.0, 0.02, (5000, 2)), rng.normal(0.5, 0.01, 5000)])
    wide = rng.uniform(-10, 10, (5000, 3))
    flat = np.full(5000, 1 / 5000)
    assert len(resampled(narrow, flat, 100_000, 0.3, config)) == config.min_particles
    assert len(resampled(wide, flat, 100_000, 0.3, config)) > 20_000
    assert len(resampled(wide, flat, 2000, 0.3, config)) == 2000


def test_particles_anywhere_are_uniform_over_free_cells_and_headings():
    model = model_of(two_rooms())
    particles = anywhere(model, N, key_of(7, 0, 1))
    cells = model.geometry.world_to_cell(particles[:, :2])
    flat = cells[:, 0] * model.geometry.cols + cells[:, 1]
    assert np.isin(flat, model.free_cells).all()
    assert stats.kstest(particles[:, 2], "uniform", (-math.pi, 2 * math.pi)).pvalue > 0.01
    counts = np.bincount(np.searchsorted(model.free_cells, flat), minlength=len(model.free_cells))
    expected = N / len(model.free_cells)
    assert counts.var() < expected + 1.0  # stratified: not more than independent draws would have


def test_random_numbers_do_not_repeat_between_steps_and_purposes():
    keys = {key_of(seed, step, purpose) for seed in range(10) for step in range(100) for purpose in range(5)}
    assert len(keys) == 5000


def test_mcl_of_table_8_2_and_the_filter_have_the_same_belief():
    """One motion and one measurement in a corridor: the mean of the compiled filter is that of the textbook's."""
    rng = np.random.default_rng(3)
    start = np.column_stack([rng.uniform(0, 10, 4000), np.zeros(4000), np.zeros(4000)])
    book = textbook.mcl(
        start,
        lambda p: textbook.sample_motion_model_odometry(
            (0.0, 1.0, 0.0), np.array([0.0, 0.1, 0.0]), p, rng.standard_normal(3)
        ),
        lambda p: math.exp(-0.5 * ((p[0] - 5.0) / 0.5) ** 2),
        0.5 / 4000,
    )
    # Closed form: a uniform belief, moved, times a normal likelihood is that normal density.
    assert book[:, 0].mean() == pytest.approx(5.0, abs=0.05)
    assert book[:, 0].std() == pytest.approx(0.5, abs=0.03)


def test_kld_sampling_of_table_8_4_stops_where_its_bound_says():
    rng = np.random.default_rng(4)
    found = textbook.kld_sampling_mcl(lambda: rng.normal(0, 0.3, 3), 10, 5000, 0.05, 0.99, 0.5, 0.5)
    bins = {textbook.bin_of(p, 0.5, 0.5) for p in found}
    assert len(found) >= textbook.kld_number(len(bins), 0.05, 0.99)
    before = {textbook.bin_of(p, 0.5, 0.5) for p in found[:-1]}
    assert len(found) - 1 < textbook.kld_number(len(before), 0.05, 0.99)


def test_random_particles_of_table_8_3_come_where_the_weights_fall():
    slow = fast = 1.0
    for _ in range(20):
        slow, fast, share = textbook.augmented_share(1.0, slow, fast, 0.001, 0.1)
    assert share == pytest.approx(0.0, abs=1e-12)
    for _ in range(10):
        slow, fast, share = textbook.augmented_share(0.2, slow, fast, 0.001, 0.1)
    # w_fast = 0.2 + 0.8 · 0.9¹⁰, w_slow = 0.2 + 0.8 · 0.999¹⁰
    assert share == pytest.approx(1 - (0.2 + 0.8 * 0.9**10) / (0.2 + 0.8 * 0.999**10))
