"""Integration of a scan with a user-defined sensor model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.kernels.amanatides_woo import END_U, END_V, RAY_FIELDS, U, V, Z, plan_rays
from mapper.mapping.kernels.beam_cells import add_increments, cells_of_lines, cells_of_rays
from mapper.mapping.kernels.bresenham import FAR, LINE_FIELDS, plan_lines, reach
from mapper.mapping.kernels.types import ReadingFilter
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.sensor_model import InverseSensorModel
from mapper.mapping.update_plan import UpdatePlan, check_beam_length


@dataclass(frozen=True, slots=True)
class CrossedCells:
    """The cells that beams cross, beam by beam; each array is (m,).

    ``cells`` int64 are row · cols + col, ``beams`` int64 the beam indices. ``r`` is the distance in metres from the
    sensor to the cell's centre, or z for the cell that holds the endpoint. ``z`` is the beam's reading in metres, +inf
    for no return.
    """

    cells: NDArray[np.int64]
    beams: NDArray[np.int64]
    r: NDArray[np.float64]
    z: NDArray[np.float64]


def add_with_model(
    grid: OccupancyGrid, batch: ScanBatch, plan: UpdatePlan, model: InverseSensorModel
) -> tuple[int, tuple[int, int, int, int], bool]:
    """Integrate one scan with ``model``. The grid first grows if the scan reaches beyond it.

    Return the number of cell updates, the touched box (row0, row1, col0, col1), half-open and possibly empty, and
    whether the grid grew. Raises :class:`ConfigError` for a model or plan that does not fit; the grid is then
    unchanged.
    """
    if plan.update != "per_beam":
        raise ConfigError("model.update", "A sensor model of your own updates per beam; set update to per_beam.")
    if grid.cell_statistics is not None:
        raise ConfigError(
            "model.cell_statistics",
            "The grid holds counts for another model; start a new grid for a model of your own.",
        )
    behind = _checked_reach(model)
    check_beam_length(batch.range_max + behind, grid.geometry.resolution)
    reading_filter = plan.reading_filter._replace(window=2.0 * behind, growth=0.0)
    out = np.array([np.inf, np.inf, -np.inf, -np.inf])
    reach(batch.ranges, batch.sensors, batch.beams, reading_filter, out)
    # The model is evaluated on the geometry after growth. The grid changes only after the result has been validated.
    geometry, _, _ = grid.geometry.grown_to_include(out[:2], out[2:])
    crossed = crossed_cells(geometry, batch, reading_filter, exact_rays=plan.exact_rays)
    increments = _checked_increments(model, crossed, batch.range_max)
    grown = grid.grow_to_include(out[:2], out[2:])
    low, high = plan.log_odds_update.low, plan.log_odds_update.high
    add_increments(grid.log_odds.reshape(-1), grid.observed.reshape(-1), crossed.cells, increments, low, high)
    if not len(crossed.cells):
        return 0, (0, 0, 0, 0), grown
    rows, cols = np.divmod(crossed.cells, geometry.cols)
    box = (int(rows.min()), int(rows.max()) + 1, int(cols.min()), int(cols.max()) + 1)
    return len(crossed.cells), box, grown


def crossed_cells(
    geometry: GridGeometry, batch: ScanBatch, reading_filter: ReadingFilter, *, exact_rays: bool
) -> CrossedCells:
    """Return the cells that the beams of one scan cross, up to the reading plus half the window of
    ``reading_filter``.
    """
    n = batch.ranges.size
    work, box = np.zeros(geometry.rows + 1), np.zeros(4, dtype=np.int64)
    beams = (batch.scans_on(geometry), geometry.frame, reading_filter, 0)
    z = batch.ranges[0].astype(np.float64)
    z[z > batch.range_max] = np.inf
    if exact_rays:
        rays = np.empty((n, RAY_FIELDS))
        plan_rays(*beams, rays, work, box)
        spoken = rays[~np.isnan(rays[:, Z])]
        most = int(np.abs(spoken[:, [END_U, END_V]] - spoken[:, [U, V]]).sum() + 4 * len(spoken))
    else:
        lines = np.empty((LINE_FIELDS, n), dtype=np.int32)
        plan_lines(*beams, lines, work, box)
        most = int(lines[FAR].sum(dtype=np.int64)) + n
    cells, beam, r = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(most)
    if exact_rays:
        count = cells_of_rays(rays, geometry.resolution, geometry.shape, cells, beam, r)
    else:
        u, v = geometry.to_lattice(batch.sensor_poses[0, :2]).tolist()
        count = cells_of_lines(lines, z, u, v, geometry.resolution, geometry.shape, cells, beam, r)
    z, r = z[beam[:count]], r[:count]
    if reading_filter.window == 0.0:
        # Without a window, a cell before the endpoint's counts as before the reading even if its centre is not.
        ends = np.append(np.diff(beam[:count]) != 0, True) & np.isfinite(z)
        r = np.where(ends, r, np.minimum(r, np.nextafter(z, 0.0)))
    return CrossedCells(cells[:count], beam[:count], r, z)


def _checked_reach(model: InverseSensorModel) -> float:
    value: object = model.reach
    if isinstance(value, bool) or not isinstance(value, int | float) or not (0.0 <= value < np.inf):
        raise ConfigError(
            "model.reach", f"The model’s reach must be a finite number of metres, at least 0, not {value!r:.80}."
        )
    return float(value)


def _checked_increments(model: InverseSensorModel, crossed: CrossedCells, range_max: float) -> NDArray[np.float32]:
    answer = model.increments(crossed.r, crossed.z, range_max)
    try:
        increments = np.asarray(answer, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ConfigError(
            "model.increments", f"The model’s increments are not an array of numbers: {error}."
        ) from error
    if increments.shape != crossed.r.shape:
        raise ConfigError(
            "model.increments",
            f"The model’s increments must have the shape of r, {crossed.r.shape}, not {increments.shape}.",
        )
    with np.errstate(over="ignore"):
        rounded = increments.astype(np.float32)
    bad = np.flatnonzero(~np.isfinite(rounded))
    if len(bad):
        first = bad[0]
        raise ConfigError(
            "model.increments",
            f"The model’s increments must be finite log-odds; at r = {crossed.r[first]:g} m of a reading "
            f"z = {crossed.z[first]:g} m it says {increments[first]:g}.",
        )
    return rounded
