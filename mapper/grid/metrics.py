"""Metrics of a map: entropy, number of cells in each state, and agreement of its walls with others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.grid.kernels.map_statistics import sum_map
from mapper.grid.occupancy_grid import (
    FREE_THRESHOLD,
    OCCUPIED_THRESHOLD,
    OccupancyGrid,
    check_thresholds,
    log_odds,
)

TOLERANCE = 0.1  #: metres: two cells of 5 cm


def wall_points(grid: OccupancyGrid) -> NDArray[np.float64]:
    """Return the centres (n, 2), metres, of the observed cells whose p is above :data:`OCCUPIED_THRESHOLD`."""
    occupied = grid.observed & (grid.log_odds > float(log_odds(OCCUPIED_THRESHOLD)))
    return np.asarray(grid.geometry.cell_to_world(np.argwhere(occupied)), dtype=np.float64).reshape(-1, 2)


def wall_agreement(measured: ArrayLike, expected: ArrayLike, tolerance: float = TOLERANCE) -> float:
    """Return the F-score, 0 to 1, of points ``measured`` (n, 2) against ``expected`` (m, 2), metres.

    Precision is the fraction of measured points with an expected point within ``tolerance`` metres, recall the fraction
    of expected points with a measured one. The score is their harmonic mean, 0 if either is 0. Source: Knapitsch et
    al., Tanks and Temples (2017), section 5, there for 3D points. Raises :class:`ConfigError` for a tolerance that is
    not positive.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few callers need

    if not tolerance > 0.0:
        raise ConfigError("agreement.tolerance", f"The tolerance must be above 0 m, not {tolerance!r}.")
    a, b = np.asarray(measured, dtype=np.float64).reshape(-1, 2), np.asarray(expected, dtype=np.float64).reshape(-1, 2)
    if not len(a) or not len(b):
        return 0.0
    limit = tolerance * (1.0 + 1e-9)  # include centres of two lattices at exactly this distance
    precision = float(np.isfinite(cKDTree(b).query(a, distance_upper_bound=limit)[0]).mean())
    recall = float(np.isfinite(cKDTree(a).query(b, distance_upper_bound=limit)[0]).mean())
    return 2.0 * precision * recall / (precision + recall) if precision + recall else 0.0


def entropy(log_odds: ArrayLike) -> NDArray[np.float64]:
    """Return the entropy H(p) = −p log₂ p − (1 − p) log₂ (1 − p), bits, for log-odds of any shape.

    With q the probability of the less likely state and ℓ the log-odds, H = (ln(1 + e^−|ℓ|) + q |ℓ|) / ln 2, which
    neither overflows nor takes the logarithm of 0. Source: Probabilistic Robotics, section 17.4.
    """
    distance = np.abs(np.asarray(log_odds, dtype=np.float64))
    small = np.exp(-distance)
    finite = np.where(np.isinf(distance), 0.0, distance)
    return np.asarray((np.log1p(small) + finite * small / (1.0 + small)) / np.log(2.0), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class MapMetrics:
    """Figures of a map. ``entropy_bits`` and ``information_gain_bits`` are sums over all observed cells.

    A cell's gain is the entropy of its prior minus its current entropy, negative if it is less certain than its prior
    (Probabilistic Robotics, section 17.4). The others are counts; ``never_observed`` is part of ``unknown``.
    """

    entropy_bits: float
    information_gain_bits: float
    free: int
    occupied: int
    unknown: int
    never_observed: int


def map_metrics(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> MapMetrics:
    """Return the metrics of a grid. The thresholds are those of :meth:`OccupancyGrid.classify`.

    They are computed in one pass over the cells, in a small fraction of the time that mapping them took.
    """
    check_thresholds(occupied_threshold, free_threshold)
    thresholds = float(log_odds(free_threshold)), float(log_odds(occupied_threshold))
    counts, bits = _sums(grid.log_odds, grid.observed, grid.log_odds_prior, thresholds)
    observed, free, occupied = (int(count) for count in counts)
    if grid.prior_map is None:
        prior_bits = observed * float(entropy(np.float32(grid.log_odds_prior)))
    else:
        prior_bits = _sums(grid.prior_map, grid.observed, grid.log_odds_prior, thresholds)[1]
    cells = grid.log_odds.size
    return MapMetrics(
        entropy_bits=bits,
        information_gain_bits=prior_bits - bits,
        free=free,
        occupied=occupied,
        unknown=cells - free - occupied,
        never_observed=cells - observed,
    )


def _sums(
    values: NDArray[np.float32], observed: NDArray[np.bool_], prior: float, thresholds: tuple[float, float]
) -> tuple[NDArray[np.int64], float]:
    """Return the numbers of observed, free and occupied cells (3,), and the total entropy of observed cells in bits.

    ``values`` (rows, cols) are log-odds, with NaN for ``prior``.
    """
    counts, sums = np.zeros(3, dtype=np.int64), np.zeros(1)
    flat = np.ascontiguousarray(values).reshape(-1), np.ascontiguousarray(observed).reshape(-1).view(np.uint8)
    sum_map(*flat, float(np.float32(prior)), *thresholds, counts, sums)
    return counts, float(sums[0])
