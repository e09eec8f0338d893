"""Why a cell is what it is: every beam that touched it, in order, with what it added.

Found anew from the log and the parameters whenever it is asked for, so the map keeps no history.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.errors import ConfigError
from mapper.grid import GridGeometry
from mapper.integrate import sweep_of_log
from mapper.kernels.provenance import running_sum
from mapper.parameters import MappingConfig
from mapper.scan import ScanLog
from mapper.sweep import rule_of


@dataclass(frozen=True, slots=True)
class Provenance:
    """The touches of one cell, one entry each, in the order in which the map was made.

    ``scans`` and ``beams`` (n,) int64 say which reading it was and ``ranges`` (n,) float32 what it read, in metres
    (beyond the max range: no return); ``hits`` (n,) bool whether it argued for occupied; ``increments`` (n,) float32
    is its evidence and ``log_odds`` (n,) float32 what the cell held after it.
    """

    scans: NDArray[np.int64]
    beams: NDArray[np.int64]
    ranges: NDArray[np.float32]
    hits: NDArray[np.bool_]
    increments: NDArray[np.float32]
    log_odds: NDArray[np.float32]


def provenance(
    geometry: GridGeometry,
    log: ScanLog,
    config: MappingConfig,
    cell: tuple[int, int],
    trajectory: str | None = None,
    stop: int | None = None,
    before: float | None = None,
) -> Provenance:
    """Return what the first ``stop`` scans of ``log`` (None: all) did to ``cell`` (row, col) of a map.

    ``before`` is the log-odds that the cell held before them, None for the prior: a map of several logs is told log by
    log.
    A per-scan update that hits a cell is credited to the first beam that ended in it. Raises :class:`ConfigError` for
    a cell outside the grid or for scans that the log does not have.
    """
    stop = log.n_scans if stop is None else stop
    row, col = (int(n) for n in cell)
    if not geometry.contains((row, col)):
        raise ConfigError(
            "provenance.cell", f"Cell ({row}, {col}) lies outside the grid of {geometry.rows} × {geometry.cols}."
        )
    if not 0 <= stop <= log.n_scans:
        raise ConfigError("log.scans", f"The log has no scans 0 to {stop}; it has {log.n_scans}.")
    touches = sweep_of_log(log, config, trajectory, 0, stop).touches(geometry, config, row, col)
    miss, hit, low, high = rule_of(config)
    readings, hits = touches[:, 0], touches[:, 1] == 1
    increments = np.where(hits, hit, miss).astype(np.float32)
    log_odds = np.empty_like(increments)
    running_sum(increments, np.float32(config.log_odds_prior if before is None else before), low, high, log_odds)
    scans, beams = np.divmod(readings, max(1, log.n_beams))
    return Provenance(scans, beams, log.ranges[scans, beams], hits, increments, log_odds)
