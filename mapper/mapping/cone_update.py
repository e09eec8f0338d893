"""Scans whose beams are wide, as the kernels of cones take them: sonars, and the smooth ramp per scan."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.kernels.cones import FLAT, GAUSSIAN, RAMP, contributions_of_cones, draw_cones
from mapper.mapping.kernels.types import Cone, Evidence, LogOddsUpdate
from mapper.mapping.parameters import MappingConfig

if TYPE_CHECKING:
    from mapper.mapping.scan_batch import ScanBatch


def cone_of(config: MappingConfig) -> Cone:
    """Return the profile and the opening angle as the kernels take them."""
    if config.model == "smooth_ramp":
        return (RAMP, config.opening)
    return (GAUSSIAN if config.cone_profile == "gaussian" else FLAT, config.opening)


def evidence_of(config: MappingConfig) -> Evidence:
    """Return the increments for a miss and a hit as the kernels take them, not rounded."""
    model = config.beam_model()
    return (model.log_odds_miss, model.log_odds_hit)


def ends_in_cells(config: MappingConfig) -> bool:
    """Return whether the cells that hold the endpoints are hit in any case: so for beams that are taken to be thin."""
    return config.model == "smooth_ramp"


def drawer_of_cones(
    batch: ScanBatch, grid: OccupancyGrid, config: MappingConfig, log_odds_update: LogOddsUpdate
) -> Callable[[int, int, NDArray[np.int64]], int]:
    """Return what adds all scans to the rows [row_low, row_high) of a grid and widens a box."""
    return partial(
        draw_cones,
        grid.log_odds.reshape(-1),
        grid.observed.reshape(-1),
        grid.geometry.cols,
        *batch.scans_on(grid.geometry),
        grid.geometry.frame,
        batch.reading_filter(config),
        cone_of(config),
        evidence_of(config),
        ends_in_cells(config),
        np.zeros(grid.log_odds.size if ends_in_cells(config) else 0, dtype=np.bool_),
        log_odds_update,
    )


def contributions_in_cones(
    batch: ScanBatch, geometry: GridGeometry, config: MappingConfig, row: int, col: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the readings that touch a cell, as :meth:`mapper.mapping.scan_batch.ScanBatch.contributions`, and the
    evidence of each (n,).
    """
    out, increments = np.empty((batch.ranges.size, 2), np.int64), np.empty(batch.ranges.size, np.float32)
    view = (geometry.frame, batch.reading_filter(config), cone_of(config), evidence_of(config), ends_in_cells(config))
    n = contributions_of_cones(*batch.scans_on(geometry), *view, row, col, out, increments)
    return out[:n], increments[:n]


def ramp_increments(
    batch: ScanBatch,
    geometry: GridGeometry,
    config: MappingConfig,
    cell: tuple[int, int],
    contributions: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Return what each touch (n, 2) of a cell by thin beams with a smooth ramp says of it (n,), log-odds."""
    model = config.beam_model()
    scans, beams = np.divmod(contributions[:, 0], batch.ranges.shape[1])
    z = batch.ranges[scans, beams].astype(np.float64)
    x, y, cos, sin = batch.sensors[scans].T
    column, row = geometry.to_lattice(np.stack([x, y], axis=-1)).T
    d_col, d_row = cell[1] + 0.5 - column, cell[0] + 0.5 - row
    s = np.sqrt(d_col * d_col + d_row * d_row) * geometry.resolution
    returned = (z >= batch.range_min) & (z <= batch.range_max)
    z = np.where(returned, z, 0.0)
    px, py = (z * part for part in batch.beams[beams].T)
    ends = geometry.world_to_cell(np.stack([x + cos * px - sin * py, y + sin * px + cos * py], axis=-1))
    ended = returned & (ends == np.array(cell)).all(axis=-1)
    within = model.increment(s, z)  # type: ignore[arg-type] # a ramp takes a reading for each distance as well
    thin = np.where(contributions[:, 1] == 1, within, model.log_odds_miss)
    return np.where(ended, model.log_odds_hit, thin).astype(np.float32)
