"""Models that keep two statistics for each cell and compute its log-odds from them.

``cell_statistics[0]`` is evidence for occupied and ``cell_statistics[1]`` for empty: the hits and misses of
:class:`mapper.mapping.sensor_model.HitCounting`, the certainties of
:class:`mapper.mapping.sensor_model.MoravecElfes`. Counts are exact up to 2²⁴ in each cell.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid, probability
from mapper.mapping.parameters import ModelStrategy, Statistics
from mapper.mapping.sensor_model import HitCounting, MoravecElfes
from mapper.mapping.update_plan import UpdatePlan


def begin(grid: OccupancyGrid, strategy: ModelStrategy) -> None:
    """Allocate the statistics that the model keeps, if it keeps any and the grid has none yet.

    Raises :class:`ConfigError` for a grid that was updated by a model of another kind, because the two cannot be mixed.
    """
    keeps = strategy.statistics != "none"
    if keeps and grid.cell_statistics is None:
        updated = grid.observed if grid.prior_map is None else grid.observed & np.isnan(grid.prior_map)
        if updated.any():
            raise _mixed(strategy)
        initial = _INITIAL[strategy.statistics]
        grid.cell_statistics = initial(grid.prior())
        occupied, empty = initial(np.full(1, grid.log_odds_prior, dtype=np.float32))[:, 0].tolist()
        grid.statistics_prior = (occupied, empty)
    elif not keeps and grid.cell_statistics is not None:
        raise _mixed(strategy)


def _no_counts(prior: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.zeros((2, *prior.shape), dtype=np.float32)


def _certainties_of(prior: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the certainties (2, ...) that are equivalent to a prior (...) in log-odds."""
    value = 2.0 * probability(prior) - 1.0
    return np.stack([np.maximum(value, 0.0), np.maximum(-value, 0.0)]).astype(np.float32)


#: The statistics (2, ...) of cells without readings, computed from their prior (...) in log-odds.
_INITIAL: Mapping[Statistics, Callable[[NDArray[np.float32]], NDArray[np.float32]]] = {
    "counts": _no_counts,
    "certainties": _certainties_of,
}


def forget(grid: OccupancyGrid, strategy: ModelStrategy, part: tuple[slice, slice]) -> None:
    """Reset some rows and columns to their state after :func:`begin`."""
    prior = grid.prior(part)
    grid.log_odds[part] = prior
    grid.observed[part] = False if grid.prior_map is None else ~np.isnan(grid.prior_map[part])
    if grid.cell_statistics is not None:
        grid.cell_statistics[:, *part] = _INITIAL[strategy.statistics](prior)


def _mixed(strategy: ModelStrategy) -> ConfigError:
    return ConfigError(
        "grid.model", f"The grid was made with another kind of model than {strategy.name}; make it again."
    )


def show(grid: OccupancyGrid, plan: UpdatePlan, box: NDArray[np.int64]) -> None:
    """Compute the log-odds of the cells in a box (row0, row1, col0, col1) from their statistics, clamped.

    A cell with its initial statistics keeps its prior, even if a prior map sets it beyond the clamp, because no reading
    has contributed to it.
    """
    if grid.cell_statistics is None or box[1] <= box[0]:
        return
    part = np.s_[box[0] : box[1], box[2] : box[3]]
    occupied, empty = grid.cell_statistics[(0, *part)], grid.cell_statistics[(1, *part)]
    log_odds_prior: float | NDArray[np.float32] = grid.log_odds_prior
    initial: Sequence[float] | NDArray[np.float32] = grid.statistics_prior
    if grid.prior_map is not None:
        log_odds_prior = grid.prior(part)
        initial = _INITIAL[plan.strategy.statistics](log_odds_prior)
    changed = (occupied != initial[0]) | (empty != initial[1])
    if isinstance(log_odds_prior, np.ndarray):
        log_odds_prior = log_odds_prior[changed]
    grid.log_odds[part][changed] = shown(plan, occupied[changed], empty[changed], log_odds_prior)


def shown(
    plan: UpdatePlan,
    occupied: NDArray[np.float32],
    empty: NDArray[np.float32],
    log_odds_prior: float | NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the clamped log-odds (any shape) for two statistics. ``log_odds_prior`` is ℓ₀ of the same cells."""
    log_odds = _LOG_ODDS[plan.strategy.statistics](plan, occupied, empty, log_odds_prior)
    return np.asarray(np.clip(log_odds, *plan.clamp), dtype=np.float32)


def _log_odds_of_counts(
    plan: UpdatePlan,
    hits: NDArray[np.float32],
    misses: NDArray[np.float32],
    log_odds_prior: float | NDArray[np.float32],
) -> NDArray[np.float64]:
    """Return the log-odds of the posterior mean for a Beta prior with the model's weight and each cell's own ℓ₀."""
    weight = cast("HitCounting", plan.model).prior_weight
    prior_hits = weight * probability(log_odds_prior)
    return np.asarray(np.log(hits + prior_hits) - np.log(misses + (weight - prior_hits)))


def _log_odds_of_certainties(
    plan: UpdatePlan,  # noqa: ARG001 - the prior is part of the certainties
    occupied: NDArray[np.float32],
    empty: NDArray[np.float32],
    log_odds_prior: float | NDArray[np.float32],  # noqa: ARG001 - as above
) -> NDArray[np.float64]:
    return MoravecElfes.log_odds(empty, occupied)


_LOG_ODDS: Mapping[Statistics, Callable[..., NDArray[np.float64]]] = {
    "counts": _log_odds_of_counts,
    "certainties": _log_odds_of_certainties,
}
