"""Models whose map is no sum of log-odds: they keep two numbers for each cell and compute the log-odds from them.

``cell_statistics[0]`` is what speaks for occupied and ``cell_statistics[1]`` what speaks for empty: the hits and misses
of :class:`mapper.mapping.sensor_model.HitCounting`, the certainties of
:class:`mapper.mapping.sensor_model.MoravecElfes`. Numbers of visits are exact up to 2²⁴ in each cell.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid, probability
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.sensor_model import HitCounting, MoravecElfes

STATISTICS_MODELS = ("moravec_elfes", "hit_counting")  #: values of ``model``


def begin(grid: OccupancyGrid, config: MappingConfig) -> None:
    """Make a grid ready for ``config.model``.

    Raises :class:`ConfigError` for a grid into which a model of the other kind has put something: the two do not mix.
    """
    has_statistics = config.model in STATISTICS_MODELS
    if has_statistics and grid.cell_statistics is None:
        known = False if grid.prior_map is None else ~np.isnan(grid.prior_map)
        if np.any(grid.observed & ~known):
            raise _mixed(config)
        grid.cell_statistics = np.zeros((2, *grid.geometry.shape), dtype=np.float32)
        if config.model == "moravec_elfes":
            grid.cell_statistics[:] = _certainties_of(grid.prior())
            speaks, against = _certainties_of(np.full(1, grid.log_odds_prior, dtype=np.float32))[:, 0].tolist()
            grid.statistics_prior = (speaks, against)
    elif not has_statistics and grid.cell_statistics is not None:
        raise _mixed(config)


def _certainties_of(prior: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the certainties (2, ...) that say what log-odds of a prior (...) do."""
    value = 2.0 * probability(prior) - 1.0
    return np.stack([np.maximum(value, 0.0), np.maximum(-value, 0.0)]).astype(np.float32)


def forget(grid: OccupancyGrid, config: MappingConfig, part: tuple[slice, slice]) -> None:
    """Bring some rows and columns back to what they were when :func:`begin` had made the grid ready."""
    prior = grid.prior(part)
    grid.log_odds[part] = prior
    grid.observed[part] = False if grid.prior_map is None else ~np.isnan(grid.prior_map[part])
    if grid.cell_statistics is not None:
        grid.cell_statistics[:, *part] = 0.0
        if config.model == "moravec_elfes":
            grid.cell_statistics[:, *part] = _certainties_of(prior)


def _mixed(config: MappingConfig) -> ConfigError:
    return ConfigError("grid.model", f"The grid was made with another kind of model than {config.model}; make it anew.")


def show(grid: OccupancyGrid, config: MappingConfig, box: NDArray[np.int64]) -> None:
    """Compute the log-odds of the cells in a box (row0, row1, col0, col1) from their tallies, clamped.

    A cell whose tallies are what they were at first keeps its prior as it is, also one that a prior map states beyond
    the clamp: no reading has said anything of it.
    """
    if grid.cell_statistics is None or box[1] <= box[0]:
        return
    part = np.s_[box[0] : box[1], box[2] : box[3]]
    speaks, against = grid.cell_statistics[(0, *part)], grid.cell_statistics[(1, *part)]
    log_odds_prior: float | NDArray[np.float32] = grid.log_odds_prior
    at_first: Sequence[float] | NDArray[np.float32] = grid.statistics_prior
    if grid.prior_map is not None:
        log_odds_prior = grid.prior(part)
        if config.model == "moravec_elfes":
            at_first = _certainties_of(log_odds_prior)
    changed = (speaks != at_first[0]) | (against != at_first[1])
    grid.log_odds[part] = np.where(changed, shown(config, speaks, against, log_odds_prior), grid.log_odds[part])


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
