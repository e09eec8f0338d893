"""Particle weights: the likelihood of a scan at each particle."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.parallel import cores, in_parallel, shares
from mapper.localization.kernels.beam_model import weigh_by_beams
from mapper.localization.kernels.scan_at_pose import score_poses
from mapper.localization.kernels.types import Mixture
from mapper.localization.map_model import MapModel
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.scan_beams import ScanBeams

_PART = 1000  #: particles per thread below which another thread is not worthwhile
_SAMPLE = 4096  #: particles used to find the power of tempering


def parts(n: int) -> list[tuple[int, int]]:
    """Split n particles into ranges, one per worthwhile core."""
    return shares(n, max(1, min(cores(), n // _PART)))


def scan_sums(model: MapModel, scan: ScanBeams, particles: Float64Array) -> NDArray[np.int64]:
    """Return the sums of the likelihood field's scores (n,) at a scan's endpoints, for ``particles`` (n, 3)."""
    sums = np.empty(len(particles), dtype=np.int64)
    in_parallel(
        [partial(score_poses, model.field.field, scan.points, particles, a, b, sums) for a, b in parts(len(particles))]
    )
    return sums


def log_likelihoods(
    model: MapModel, scan: ScanBeams, particles: Float64Array, sums: NDArray[np.int64], config: LocalizationConfig
) -> Float64Array:
    """Return log p(z | x, m) (n,) for ``particles`` (n, 3), up to a constant, by the model of ``config``."""
    if config.laser_model_type != "beam":
        n = len(scan.points)
        logs = model.field.log_weights(sums, n)
        return logs * independence(n, config) if model.field.is_product else logs
    out = np.empty(len(particles))
    mixture = Mixture(
        config.z_hit, config.z_short, config.z_max, config.z_rand, config.sigma_hit, config.lambda_short,
        scan.range_max,
    )  # fmt: skip
    in_parallel(
        [
            partial(weigh_by_beams, model.cells, mixture, scan.beams, scan.sensor, particles, a, b, out)
            for a, b in parts(len(particles))
        ]
    )
    return out * independence(len(scan.beams), config)


def independence(n_beams: int, config: LocalizationConfig) -> float:
    """Return the power that reduces the product over ``n_beams`` beams to that of fewer independent ones.

    Source: Probabilistic Robotics, section 6.3.4.
    """
    count = config.independent_beams
    return 1.0 if count == 0.0 else min(1.0, count / max(n_beams, 1))


def normalised(log_weights: Float64Array) -> Float64Array:
    """Return weights (n,), Σ = 1, from their logarithms. Raises :class:`ConfigError` if one is NaN."""
    most = float(log_weights.max())
    if not np.isfinite(most):
        raise ConfigError("localization.weights", "Weights of particles must be numbers, and not all of them 0.")
    weights = np.exp(log_weights - most)
    weights /= weights.sum()
    return weights


def logarithm_of_mean(weights: Float64Array, log_values: Float64Array) -> float:
    """Return log Σ w exp(v) of weights (n,), Σ = 1, and logarithms v (n,)."""
    held = weights > 0.0  # the greatest v may have weight 0, and all others would underflow relative to it
    most = float(log_values[held].max())
    return most + math.log(float(weights[held] @ np.exp(log_values[held] - most)))


def effective_number(weights: Float64Array) -> float:
    """Return N_eff = 1 / Σ w² of weights (n,), Σ = 1. Source: Liu 1996; Grisetti et al. 2005, equation 9."""
    return float(1.0 / np.sum(weights**2))


def effective(weights: Float64Array) -> float:
    """Return N_eff = (Σw)² / Σw² of weights (n,)."""
    total = float(weights.sum())
    return total * total / float(weights @ weights)


def tempering(prior: Float64Array, log_likelihood: Float64Array, least: float) -> float:
    """Return the greatest power β ≤ 1 of the likelihood for which N_eff is at least ``least`` of the particles.

    ``prior`` (n,) are the previous weights. The power is found by bisection, on every k-th particle if there are many.
    Source: Del Moral, Doucet and Jasra 2012, An adaptive sequential Monte Carlo method (the level of N_eff).
    """
    step = max(1, len(prior) // _SAMPLE)
    w, value = prior[::step], log_likelihood[::step]
    value = value - value.max()
    target = least * min(len(w), effective(w))
    if effective(w * np.exp(value)) >= target:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effective(w * np.exp(middle * value)) >= target else (low, middle)
    return low
