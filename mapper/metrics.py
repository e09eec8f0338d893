"""Figures that say how a map stands: its entropy and how many cells are in each state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.grid import FREE, FREE_THRESHOLD, OCCUPIED, OCCUPIED_THRESHOLD, OccupancyGrid


def entropy(log_odds: ArrayLike) -> NDArray[np.float64]:
    """Return each cell's entropy H(p) = −p log₂ p − (1 − p) log₂ (1 − p), bits, for log-odds of any shape.

    With q = the less likely state's probability and ℓ its distance from even odds, H = (ln(1 + e^−|ℓ|) + q |ℓ|) / ln 2,
    which neither overflows nor takes the logarithm of 0. Source: Probabilistic Robotics, section 17.4.2.
    """
    distance = np.abs(np.asarray(log_odds, dtype=np.float64))
    small = np.exp(-distance)
    finite = np.where(np.isinf(distance), 0.0, distance)
    return np.asarray((np.log1p(small) + finite * small / (1.0 + small)) / np.log(2.0), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class MapMetrics:
    """``entropy_bits`` sums over all observed cells; the rest are counts, ``never_observed`` a part of ``unknown``."""

    entropy_bits: float
    free: int
    occupied: int
    unknown: int
    never_observed: int


def map_metrics(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> MapMetrics:
    """Return a grid's figures; the thresholds are those of :meth:`OccupancyGrid.classify`."""
    state = grid.classify(occupied_threshold, free_threshold)
    free, occupied = int(np.count_nonzero(state == FREE)), int(np.count_nonzero(state == OCCUPIED))
    return MapMetrics(
        entropy_bits=float(entropy(grid.log_odds[grid.observed]).sum()),
        free=free,
        occupied=occupied,
        unknown=state.size - free - occupied,
        never_observed=int(state.size - np.count_nonzero(grid.observed)),
    )
