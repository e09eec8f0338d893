"""Readings of a batch that contribute to one cell, with their evidence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from mapper.mapping.kernels.cones import contributions_of_cones
from mapper.mapping.kernels.contributions import (
    contributions_of_fields,
    contributions_of_lines,
    contributions_of_rays,
    filter_readings_near_cell,
)
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.thin_update import plan_beams
from mapper.mapping.update_plan import UpdatePlan

OUTWEIGHED = 2  #: a miss in a cell that its scan hits, where only the hits count


def contributions(
    batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the readings that touch ``cell`` (row, col) and the evidence of each (n,), log-odds.

    The readings (n, 2) int64 are scan · n_beams + beam, and 1 for a hit, 0 for a miss, or :data:`OUTWEIGHED`, in the
    order in which they are added.
    """
    if plan.draws_cones:
        return _in_cones(batch, geometry, plan, cell)
    touches = (_in_fields if plan.per_scan else _on_beams)(batch, geometry, plan, cell)
    if plan.strategy.smooth:
        return touches, _ramp_increments(batch, geometry, plan, cell, touches)
    if plan.only_hits:
        touches = _hits_first(touches, batch.numbers[touches[:, 0] // batch.ranges.shape[1]])
    update = plan.log_odds_update
    return touches, np.array([update.miss, update.hit, 0.0], dtype=np.float32)[touches[:, 1]]


def _hits_first(touches: NDArray[np.int64], scans: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return touches (n, 2) of a cell by the ``scans`` (n,) with those misses outweighed whose scan hits the cell.

    They follow the hits of their scan.
    """
    is_miss = touches[:, 1] == 0
    outweighed = is_miss & np.isin(scans, scans[~is_miss])
    kinds = np.where(outweighed, OUTWEIGHED, touches[:, 1])
    return np.column_stack([touches[:, 0], kinds])[np.lexsort((outweighed, scans))]


def _in_cones(
    batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    out, increments = np.empty((batch.ranges.size, 2), np.int64), np.empty(batch.ranges.size, np.float32)
    view = (geometry.frame, plan.reading_filter, plan.cone, plan.evidence)
    n = contributions_of_cones(batch.scans_on(geometry), *view, *cell, out, increments)
    return out[:n], increments[:n]


def _in_fields(batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]) -> NDArray[np.int64]:
    out = np.empty((len(batch.ranges), 2), dtype=np.int64)
    n = contributions_of_fields(batch.scans_on(geometry), geometry.frame, plan.reading_filter, *cell, out)
    return out[:n]


def _on_beams(batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]) -> NDArray[np.int64]:
    """Return the touches (n, 2); only the beams that come near the cell are planned."""
    scans = batch.scans_on(geometry)
    sifted, near = np.empty_like(scans.ranges), np.empty(len(scans.ranges), dtype=np.bool_)
    filter_readings_near_cell(scans, geometry.frame, plan.reading_filter, *cell, sifted, near)
    chosen = scans._replace(
        ranges=sifted[near],
        sensors=scans.sensors[near],
        headings=scans.headings[near],
        numbers=scans.numbers[near],
    )
    planned = plan_beams(chosen, geometry, plan, 1).planned
    out = np.empty((chosen.ranges.size, 2), dtype=np.int64)
    if plan.exact_rays:
        n = contributions_of_rays(planned, geometry.resolution, *cell, out)
    else:
        n = contributions_of_lines(planned, *cell, out)
    n_beams = batch.ranges.shape[1]
    numbers, beams = np.divmod(out[:n, 0], n_beams)
    out[:n, 0] = np.flatnonzero(near)[numbers] * n_beams + beams
    return out[:n]


def _ramp_increments(
    batch: ScanBatch,
    geometry: GridGeometry,
    plan: UpdatePlan,
    cell: tuple[int, int],
    touches: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Return the evidence (n,), log-odds, of each of ``touches`` (n, 2) of a cell by thin beams with a smooth ramp."""
    model = plan.model
    scans, beams = np.divmod(touches[:, 0], batch.ranges.shape[1])
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
    thin = np.where(touches[:, 1] == 1, within, model.log_odds_miss)
    return np.where(ended, model.log_odds_hit, thin).astype(np.float32)
