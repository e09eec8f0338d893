"""Agreement of the walls of two maps, which may differ in resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.grid.occupancy_grid import OCCUPIED_THRESHOLD, OccupancyGrid, log_odds

TOLERANCE = 0.1  #: metres: two cells of 5 cm


def wall_points(grid: OccupancyGrid) -> NDArray[np.float64]:
    """Return the centres (n, 2), metres, of the observed cells whose p is above :data:`OCCUPIED_THRESHOLD`."""
    occupied = grid.observed & (grid.log_odds > float(log_odds(OCCUPIED_THRESHOLD)))
    return np.asarray(grid.geometry.cell_to_world(np.argwhere(occupied)), dtype=np.float64).reshape(-1, 2)


def wall_agreement(found: ArrayLike, expected: ArrayLike, tolerance: float = TOLERANCE) -> float:
    """Return the F-score, 0 … 1, of points ``found`` (n, 2) against ``expected`` (m, 2), metres.

    Precision is the share of found points that have an expected one within ``tolerance`` metres, recall the share of
    expected points that have a found one; the score is their harmonic mean, 0 where either is 0. Source: Knapitsch et
    al., Tanks and Temples (2017), section 5, there for points in 3D. Raises :class:`ConfigError` for a tolerance that
    is not positive.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few callers need

    if not tolerance > 0.0:
        raise ConfigError("agreement.tolerance", f"The tolerance must be above 0 m, not {tolerance!r}.")
    a, b = np.asarray(found, dtype=np.float64).reshape(-1, 2), np.asarray(expected, dtype=np.float64).reshape(-1, 2)
    if not len(a) or not len(b):
        return 0.0
    limit = tolerance * (1.0 + 1e-9)  # centres of two lattices that are exactly so far apart
    precision = float(np.isfinite(cKDTree(b).query(a, distance_upper_bound=limit)[0]).mean())
    recall = float(np.isfinite(cKDTree(a).query(b, distance_upper_bound=limit)[0]).mean())
    return 2.0 * precision * recall / (precision + recall) if precision + recall else 0.0
