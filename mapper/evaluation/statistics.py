"""Errors over time, and their statistics with evo's names.

Source: evo's ``StatisticsType`` (github.com/MichaelGrupp/evo, evo/core/metrics.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class ErrorStatistics:
    """Statistics of n errors, in their unit; ``sse``, the sum of squared errors, is in its square.

    ``std`` is the standard deviation of the errors around their mean, divided by n, not n − 1.
    """

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    sse: float


@dataclass(frozen=True, slots=True)
class ErrorSeries:
    """Errors over time, for plots: ``errors`` (n,) ≥ 0, metres or radians, at ``stamps_ns`` (n,)."""

    stamps_ns: NDArray[np.int64]
    errors: NDArray[np.float64]

    @property
    def statistics(self) -> ErrorStatistics:
        """The statistics of these errors. Raises :class:`ConfigError` if there are none."""
        return statistics_of(self.errors)


def statistics_of(errors: NDArray[np.float64]) -> ErrorStatistics:
    """Return the statistics of ``errors`` (n,). Raises :class:`ConfigError` for n = 0."""
    if not len(errors):
        raise ConfigError("evaluation.no_errors", "There are no errors to compute statistics from.")
    sse = float(np.sum(errors**2))
    return ErrorStatistics(
        rmse=float(np.sqrt(sse / len(errors))),
        mean=float(errors.mean()),
        median=float(np.median(errors)),
        std=float(errors.std()),
        min=float(errors.min()),
        max=float(errors.max()),
        sse=sse,
    )
