"""Resampling of particles by weight, with a number that depends on their spread."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.localization.estimate import BINS
from mapper.localization.kernels.resampling import fill_bins, low_variance
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.weighing import effective_number


def drawn(weights: Float64Array, count: int, u: float) -> NDArray[np.int64]:
    """Return the indices (count,) of particles drawn by ``weights`` (n,), Σ = 1, for a random 0 ≤ ``u`` < 1."""
    out = np.empty(count, dtype=np.int64)
    low_variance(weights, u / count, out)
    return out


def number_of_bins(particles: Float64Array, chosen: NDArray[np.int64]) -> int:
    """Return the number of pose bins that the ``chosen`` (m,) of ``particles`` (n, 3) fill."""
    size = 1 << (2 * len(chosen) - 1).bit_length()
    table, numbers = np.empty(size, dtype=np.int64), np.empty(size, dtype=np.int64)
    return fill_bins(particles, chosen, BINS, table, numbers, np.empty(len(chosen), dtype=np.int64))


def kld_number(k: int, error: float, quantile: float) -> float:
    """Return the number of particles that ``k`` bins need for a KL distance of ``error``, at a normal quantile. Eq.
    (8.11).
    """
    if k < 2:
        return 0.0
    a = 2.0 / (9.0 * (k - 1))
    return (k - 1) / (2.0 * error) * (1.0 - a + math.sqrt(a) * quantile) ** 3


def resampled(
    particles: Float64Array,
    weights: Float64Array,
    most: int,
    u: float,
    config: LocalizationConfig,
    kept_share: float = 1.0,
) -> Float64Array:
    """Return particles (m, 3) drawn from ``particles`` (n, 3) with ``weights`` (n,), by low variance.

    m is the KLD bound for the number of bins filled by n draws, at least ``min_particles``, divided by the fraction of
    effective particles, and at most ``most``: copies of few particles represent a belief as badly as those few (Straka
    and Šimandl 2006, Particle filter adaptation based on efficient sample size). ``kept_share`` is the fraction left by
    earlier stages of the same scan. Table 8.4 counts the bins while drawing; here they are counted over one
    low-variance draw.
    """
    chosen = drawn(weights, len(weights), u)
    needed = kld_number(number_of_bins(particles, chosen), config.pf_err, config.pf_z)
    share = kept_share * effective_number(weights) / len(weights)
    count = int(min(max(needed, config.min_particles) / share, most))
    if count != len(chosen):
        chosen = drawn(weights, count, u)
    return particles[chosen]
