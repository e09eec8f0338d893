"""Likelihood field of a map, in integers, so that sums over beams do not depend on their order."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mapper.core.array_types import BoolArray, Float64Array
from mapper.core.errors import ConfigError
from mapper.grid import OCCUPIED, OccupancyGrid
from mapper.localization.kernels.types import ScoreField
from mapper.localization.parameters import LocalizationConfig

_STEPS = 65_535


@dataclass(frozen=True, slots=True)
class LikelihoodField:
    """The field of one map for one set of parameters.

    ``distances`` (rows, cols) float32 are metres from the nearest occupied cell, at most ``laser_likelihood_max_dist``.
    ``field`` has the scores: a score s stands for the log-likelihood ``floor`` + s · ``unit`` of a reading
    (``likelihood_field_prob``), or for its likelihood cubed (``likelihood_field``).
    """

    distances: NDArray[np.float32]
    field: ScoreField
    floor: float
    unit: float
    is_product: bool

    def log_weights(self, sums: NDArray[np.int64], n_beams: int) -> Float64Array:
        """Return the log-likelihoods (n,) of a scan of ``n_beams`` beams from the sums of their scores (n,)."""
        if self.is_product:
            return np.asarray(n_beams * self.floor + self.unit * sums, dtype=np.float64)
        return np.log1p(n_beams * self.floor + self.unit * sums.astype(np.float64))

    def fit(self, sums: NDArray[np.int64], n_beams: int) -> Float64Array:
        """Return the fit of the scan (n,): 0 if each endpoint is far from all walls, 1 if each is on one."""
        return np.asarray(sums / float(max(n_beams, 1) * _STEPS), dtype=np.float64)


def occupied_cells(grid: OccupancyGrid) -> BoolArray:
    """Return which cells (rows, cols) are occupied, as in map_server."""
    return np.asarray(grid.classify() == OCCUPIED)


def beam_likelihood(distances: NDArray[np.float32], config: LocalizationConfig, range_max: float) -> Float64Array:
    """Return p(z | x, m) of readings whose endpoints are ``distances`` metres from the nearest wall: table 6.3."""
    d = distances.astype(np.float64)
    hit = np.exp(-(d**2) / (2.0 * config.sigma_hit**2))
    return np.asarray(config.z_hit * hit + config.z_rand / range_max, dtype=np.float64)


def likelihood_field(grid: OccupancyGrid, config: LocalizationConfig, range_max: float) -> LikelihoodField:
    """Return the likelihood field of a map; ``range_max``, metres, is that of the sensor.

    Source: Probabilistic Robotics, section 6.4. Raises :class:`ConfigError` for a map without occupied cells.
    """
    occupied = occupied_cells(grid)
    if not occupied.any():
        raise ConfigError("localization.no_walls", "The map has no occupied cells: every pose in it fits equally well.")
    most = config.laser_likelihood_max_dist
    distances = ndimage.distance_transform_edt(~occupied, sampling=grid.geometry.resolution)
    distances = np.minimum(distances, most).astype(np.float32)
    ends = np.array([0.0, most], dtype=np.float32)
    is_product = config.laser_model_type != "likelihood_field"
    p, (top, bottom) = beam_likelihood(distances, config, range_max), beam_likelihood(ends, config, range_max)
    if is_product:
        bottom, top, p = math.log(max(bottom, 1e-12)), math.log(top), np.log(np.maximum(p, 1e-12))
    else:
        bottom, top, p = bottom**3, top**3, p**3
    unit = max(float(top - bottom), 1e-12) / _STEPS
    scores = np.rint((p - bottom) / unit).clip(0, _STEPS).astype(np.uint16)
    field = ScoreField(np.ascontiguousarray(scores), grid.geometry.frame)
    return LikelihoodField(distances, field, float(bottom), unit, is_product)
