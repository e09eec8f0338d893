"""A scan in stages: the particles stand for the posterior that very many weighted samples of the prior have."""

import numpy as np
import pytest

from mapper.localization import LocalizationConfig, MonteCarloLocalizer
from mapper.localization.motion import around
from mapper.localization.scan_beams import ScanBeams
from mapper.localization.textbook import bandwidth
from mapper.localization.weighing import log_likelihoods, normalised, scan_sums
from tests.mapper.localization.rooms import model_of, two_rooms

TRUE = np.array([1.4, 1.0, 0.3])
PRIOR = np.diag([0.3, 0.3, 0.3]) ** 2


def scan_at(pose: np.ndarray) -> ScanBeams:
    """The walls of the left one of the two rooms, as 12 beams from ``pose`` see them."""
    bearings = np.linspace(-np.pi, np.pi, 12, endpoint=False)
    c, s = np.cos(bearings + pose[2]), np.sin(bearings + pose[2])
    with np.errstate(divide="ignore"):
        x = np.where(c > 0, (3.15 - pose[0]) / c, (0.05 - pose[0]) / c)
        y = np.where(s > 0, (2.15 - pose[1]) / s, (0.05 - pose[1]) / s)
    ranges = np.minimum(np.where(c == 0, np.inf, x), np.where(s == 0, np.inf, y))
    points = np.column_stack([ranges * np.cos(bearings), ranges * np.sin(bearings)])
    return ScanBeams(points, np.column_stack([ranges, bearings]), np.zeros(2), 8.0)


def posterior() -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviations of it, by importance sampling from the prior, without any stage."""
    model, scan = model_of(two_rooms()), scan_at(TRUE)
    samples = around(TRUE, PRIOR, 400_000, 5)
    logs = log_likelihoods(model, scan, samples, scan_sums(model, scan, samples), LocalizationConfig())
    w = normalised(logs)
    assert 1.0 / (w @ w) > 300
    mean = w @ samples
    return mean, np.sqrt(w @ (samples - mean) ** 2)


def deviations(stages: int) -> tuple[np.ndarray, np.ndarray]:
    config = LocalizationConfig(annealing_stages=stages, max_particles=4000)
    robot = MonteCarloLocalizer(model_of(two_rooms()), config, range_max=8.0, initial_pose=TRUE, seed=7)
    robot.set_particles(around(TRUE, PRIOR, 4000, 9))
    robot.correct(scan_at(TRUE))
    return robot.estimate.pose, np.sqrt(np.diag(robot.estimate.covariance))


def test_stages_reach_the_posterior_that_one_stage_misses():
    mean, expected = posterior()
    pose, staged = deviations(12)
    np.testing.assert_allclose(pose, mean, atol=0.02)
    np.testing.assert_allclose(staged, expected, rtol=0.6)
    _, single = deviations(1)
    assert (single > 2.0 * expected).all()


@pytest.mark.parametrize(("n", "expected"), [(1000, 0.36106), (50_000, 0.20648)])
def test_bandwidth_is_silverman_s_rule(n: int, expected: float):
    assert bandwidth(n) == pytest.approx((4 / (5 * n)) ** (1 / 7), rel=1e-12) == pytest.approx(expected, abs=1e-5)
