"""Why a cell is what it is: every beam that touched it, in order, with what it added.

Found anew from the log and the parameters whenever it is asked for, so the map keeps no history.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.cell_statistics import STATISTICS_MODELS, begin, shown
from mapper.mapping.integrate import scan_batch_of_log, scans_at_once
from mapper.mapping.kernels.contributions import running_sum
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import ScanBatch, log_odds_update_of
from mapper.sensors.scan import ScanLog

_FIRST_READINGS = 1 << 11  # of the first part, before it is known how long it takes to look through a scan


@dataclass(frozen=True, slots=True)
class Provenance:
    """The touches of one cell, one entry each, in the order in which the map was made.

    ``scans`` and ``beams`` (n,) int64 say which reading it was and ``ranges`` (n,) float32 what it read, in metres
    (beyond the max range: no return); ``hits`` (n,) bool whether it argued for occupied; ``increments`` (n,) float32
    is its evidence (for models that keep tallies: what it changed) and ``log_odds`` (n,) float32 what the cell held
    after it. Before the first of them the cell held ``before``, and before all logs ``prior``; ``cell_statistics`` is
    what such a model goes on from.
    """

    scans: NDArray[np.int64]
    beams: NDArray[np.int64]
    ranges: NDArray[np.float32]
    hits: NDArray[np.bool_]
    increments: NDArray[np.float32]
    log_odds: NDArray[np.float32]
    before: float
    prior: float
    cell_statistics: NDArray[np.float32] | None = field(default=None, repr=False)

    @property
    def after(self) -> float:
        """The log-odds that the cell held in the end."""
        return float(self.log_odds[-1]) if len(self.log_odds) else self.before


def provenance(
    geometry: GridGeometry,
    log: ScanLog,
    config: MappingConfig,
    cell: tuple[int, int],
    trajectory: str | None = None,
    stop: int | None = None,
    before: Provenance | None = None,
    prior: float | None = None,
    pause: Callable[[], object] = lambda: None,
) -> Provenance:
    """Return what the first ``stop`` scans of ``log`` (None: all) did to ``cell`` (row, col) of a map.

    A map of several logs is told log by log, ``before`` being what the log before it did; ``prior`` is ℓ₀ of the cell
    where a prior map says another than ``config``. A per-scan update that hits a cell is credited to the first beam
    that ended in it. ``pause`` is called between parts of the log, a few hundredths of a second each. Raises
    :class:`ConfigError` for a cell outside the grid or for scans that the log does not have.
    """
    stop = log.n_scans if stop is None else stop
    row, col = (int(n) for n in cell)
    if not geometry.contains((row, col)):
        raise ConfigError(
            "provenance.cell", f"Cell ({row}, {col}) lies outside the grid of {geometry.rows} × {geometry.cols}."
        )
    if not 0 <= stop <= log.n_scans:
        raise ConfigError("log.scans", f"The log has no scans 0 to {stop}; it has {log.n_scans}.")
    batches = _Batches(log, config, trajectory, stop, pause)
    if before is None:
        before = _nothing(config.log_odds_prior if prior is None else prior)
    if config.model in STATISTICS_MODELS:
        contributions, log_odds, cell_statistics = _tallied(batches, geometry, config, (row, col), before)
        increments = np.diff(log_odds, prepend=np.float32(before.after))
    else:
        contributions, increments = batches.joined(lambda batch: batch.contributions(geometry, config, row, col))
        log_odds, cell_statistics = np.empty_like(increments), None
        _, _, low, high = log_odds_update_of(config)
        running_sum(increments, np.float32(before.after), low, high, log_odds)
    scans, beams = np.divmod(contributions[:, 0], max(1, log.n_beams))
    ranges, hits = log.ranges[scans, beams], contributions[:, 1] == 1
    return Provenance(scans, beams, ranges, hits, increments, log_odds, before.after, before.prior, cell_statistics)


def _nothing(prior: float) -> Provenance:
    """Return the provenance of a cell that nothing has touched."""
    none, values = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.float32)
    return Provenance(none, none, values, np.empty(0, dtype=np.bool_), values, values, prior, prior)


@dataclass(frozen=True, slots=True)
class _Batches:
    """The first ``stop`` scans of a log, in parts; ``pause`` is called after each."""

    log: ScanLog
    config: MappingConfig
    trajectory: str | None
    stop: int
    pause: Callable[[], object]

    def joined(
        self, look: Callable[[ScanBatch], tuple[NDArray[np.int64], NDArray[np.float32]]]
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return what ``look`` returns of each part, touches and a value for each, as of the whole log."""
        contributions: list[NDArray[np.int64]] = []
        values: list[NDArray[np.float32]] = []
        start, count = 0, max(1, _FIRST_READINGS // max(1, self.log.n_beams))
        while start < self.stop or not contributions:  # of a log without scans one part, to have the right shapes
            last = min(start + count, self.stop)
            began = time.thread_time()
            part, value = look(scan_batch_of_log(self.log, self.config, self.trajectory, start, last))
            count = scans_at_once(max(1, last - start), time.thread_time() - began)
            part[:, 0] += start * self.log.n_beams
            contributions.append(part)
            values.append(value)
            start = last
            self.pause()
        return np.concatenate(contributions), np.concatenate(values)


def _tallied(
    batches: _Batches, geometry: GridGeometry, config: MappingConfig, cell: tuple[int, int], before: Provenance
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Return touches, log-odds after each, and the tallies at the end, of a model whose evidence does not add up."""
    if config.model == "moravec_elfes":
        # What an arc says of a cell depends on the whole arc, so the map is made again and the cell watched.
        grid = OccupancyGrid(geometry, before.prior)
        begin(grid, config)
        if before.cell_statistics is not None:
            grid.cell_statistics = before.cell_statistics.copy()
        box, number = np.zeros(4, dtype=np.int64), geometry.cols * cell[0] + cell[1]
        contributions, certainties = batches.joined(
            lambda batch: batch.watch_certainties(grid, config, box, number)[1:]
        )
        assert grid.cell_statistics is not None  # noqa: S101 - begun above
        return contributions, shown(config, certainties[:, 0], certainties[:, 1], before.prior), grid.cell_statistics
    contributions, _ = batches.joined(lambda batch: batch.contributions(geometry, config, *cell))
    counted = np.zeros(2, dtype=np.float32) if before.cell_statistics is None else before.cell_statistics
    counts = counted[:, np.newaxis] + np.array(
        [np.cumsum(contributions[:, 1] == kind) for kind in (1, 0)], dtype=np.float32
    )
    return (
        contributions,
        shown(config, counts[0], counts[1], before.prior),
        counts[:, -1] if len(contributions) else counted,
    )
