"""Models whose map is no sum of log-odds: they keep two numbers for each cell and compute the log-odds from them.

``tallies[0]`` is what speaks for occupied and ``tallies[1]`` what speaks for empty: the hits and misses of
:class:`mapper.sensor_model.HitCounting`, the certainties of :class:`mapper.sensor_model.MoravecElfes`. Numbers of
visits are exact up to 2²⁴ in each cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.errors import ConfigError
from mapper.grid import OccupancyGrid, probability
from mapper.parameters import MappingConfig
from mapper.sensor_model import HitCounting, MoravecElfes

TALLIED = ("moravec_elfes", "hit_counting")  #: values of ``model``


def begin(grid: OccupancyGrid, config: MappingConfig) -> None:
    """Make a grid ready for ``config.model``.

    Raises :class:`ConfigError` for a grid into which a model of the other kind has put something: the two do not mix.
    """
    tallied = config.model in TALLIED
    if tallied and grid.tallies is None:
        known = False if grid.prior_map is None else ~np.isnan(grid.prior_map)
        if np.any(grid.observed & ~known):
            raise _mixed(config)
        grid.tallies = np.zeros((2, *grid.geometry.shape), dtype=np.float32)
        if config.model == "moravec_elfes":
            _begin_certainties(grid.tallies, grid.prior())
            sure = 2.0 * float(probability(grid.log_odds_prior)) - 1.0
            grid.tally_prior = (max(sure, 0.0), max(-sure, 0.0))
    elif not tallied and grid.tallies is not None:
        raise _mixed(config)


def _begin_certainties(certainties: NDArray[np.float32], prior: NDArray[np.float32]) -> None:
    """Let certainties (2, rows, cols) say what the log-odds ``prior`` (rows, cols) does."""
    value = 2.0 * probability(prior) - 1.0
    certainties[0], certainties[1] = np.maximum(value, 0.0), np.maximum(-value, 0.0)


def forget(grid: OccupancyGrid, config: MappingConfig, part: tuple[slice, slice]) -> None:
    """Bring some rows and columns back to what they were when :func:`begin` had made the grid ready."""
    prior = grid.prior(part)
    grid.log_odds[part] = prior
    grid.observed[part] = False if grid.prior_map is None else ~np.isnan(grid.prior_map[part])
    if grid.tallies is not None:
        grid.tallies[:, *part] = 0.0
        if config.model == "moravec_elfes":
            _begin_certainties(grid.tallies[:, *part], prior)


def _mixed(config: MappingConfig) -> ConfigError:
    return ConfigError("grid.model", f"The grid was made with another kind of model than {config.model}; make it anew.")


def show(grid: OccupancyGrid, config: MappingConfig, box: NDArray[np.int64]) -> None:
    """Compute the log-odds of the observed cells in a box (row0, row1, col0, col1) from their tallies, clamped."""
    if grid.tallies is None or box[1] <= box[0]:
        return
    part = np.s_[box[0] : box[1], box[2] : box[3]]
    prior = grid.log_odds_prior if grid.prior_map is None else grid.prior(part)
    speaks, against = grid.tallies[(0, *part)], grid.tallies[(1, *part)]
    grid.log_odds[part] = np.where(grid.observed[part], shown(config, speaks, against, prior), grid.log_odds[part])


def shown(
    config: MappingConfig,
    speaks: NDArray[np.float32],
    against: NDArray[np.float32],
    log_odds_prior: float | NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the clamped log-odds (any shape) of two tallies; ``log_odds_prior`` is ℓ₀ of the same cells."""
    model = config.beam_model()
    if isinstance(model, HitCounting):
        weight = model.prior_weight * probability(log_odds_prior)
        log_odds = np.log(speaks + weight) - np.log(against + (model.prior_weight - weight))
    elif isinstance(model, MoravecElfes):
        log_odds = model.log_odds(against, speaks)
    else:
        raise TypeError(f"{config.model} keeps no tallies")
    return np.asarray(np.clip(log_odds, *config.clamp_limits), dtype=np.float32)
