"""Benchmark of mapping a log in this process, without reading, start-up and compilation."""

from __future__ import annotations

import time
from dataclasses import replace

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


def bench_map(
    log: ScanLog, config: MappingConfig | None = None, repeats: int = 5, trajectory: str | None = None
) -> dict[str, float | int]:
    """Map the whole log ``repeats`` times with each kind of update; return the best times.

    ``per_beam_ms`` and ``per_scan_ms`` are milliseconds for all scans into an empty grid that contains everything;
    ``cells`` and ``per_scan_cells`` are the numbers of cell updates of one such pass.
    """
    if repeats < 1:
        raise ConfigError("bench.repeats", f"A measurement needs at least one repetition, not {repeats}.")
    config = MappingConfig() if config is None else config
    times: dict[str, float] = {}
    cells: dict[str, int] = {}
    for update in ("per_beam", "per_scan"):
        kind = replace(config, update=update)
        geometry = geometry_for(log, kind, trajectory)
        # Map one scan first, so that compiling or loading the kernels is not timed.
        integrate_log(OccupancyGrid(geometry, kind.log_odds_prior), log, kind, trajectory, 0, 1)
        best = float("inf")
        for _ in range(repeats):
            grid = OccupancyGrid(geometry, kind.log_odds_prior)
            began = time.perf_counter()
            cells[update] = integrate_log(grid, log, kind, trajectory)
            best = min(best, time.perf_counter() - began)
        times[update] = round(1e3 * best, 3)
    return {
        "per_beam_ms": times["per_beam"],
        "per_scan_ms": times["per_scan"],
        "cells": cells["per_beam"],
        "per_scan_cells": cells["per_scan"],
    }
