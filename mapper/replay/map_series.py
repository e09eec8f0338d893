"""Effect of each scan of a log on the map, as a series for plots: entropy, changed cells, contradicted readings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mapper.core.errors import WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid import FREE, OCCUPIED, TILE, UNKNOWN, GridGeometry
from mapper.grid.metrics import map_metrics
from mapper.io.contents.model import Column, Series
from mapper.io.contents.scan_series import plot_stamps
from mapper.mapping.custom_model import crossed_cells
from mapper.mapping.integrate import grid_for, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import PosedScan, placed_scan, scan_batch_of_scan
from mapper.mapping.update_plan import plan_update
from mapper.sensors.scan import ScanLog, SonarScan

ROWS = 2000  #: maximum rows of a series; in longer logs each row covers several scans
TOLERANCE = 2  #: cells: an occupied cell this near to a reading's end does not contradict it

ENTROPY = Column("entropy", "bit", "entropy")
CHANGED = Column("cells changed", "cells", "cells changed")
CONTRADICTED = Column("contradicted", "%", "contradicted")
COLUMNS = (ENTROPY, CHANGED, CONTRADICTED)


def map_series(
    log: ScanLog,
    config: MappingConfig,
    trajectory: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[float], None] = lambda _: None,
    may_continue: Callable[[], bool] = lambda: True,
) -> Series:
    """Return the effect of a log's scans on its map with ``config`` along ``trajectory`` (None: the default).

    There is a row for at most :data:`ROWS` evenly spaced scans, including the last. The columns are the entropy of the
    observed cells after the scan, bits, see :func:`mapper.grid.metrics.map_metrics`; the number of cells that changed
    between unknown, free and occupied since the row before; and the percentage of the scan's readings that the final
    map contradicts: those that end in a free cell or pass an occupied one, more than :data:`TOLERANCE` cells away from
    their end or from an occupied cell. The last is NaN for sonar cones and for scans without readings. ``progress`` is
    called with the fraction done. Raises the errors of :func:`grid_for`, and :class:`WorkCancelledError` if
    ``may_continue`` returns False.
    """
    step = max(1, -(-log.n_scans // ROWS))
    newest = np.append(np.arange(step - 1, log.n_scans - 1, step), log.n_scans - 1)
    values = np.full((len(newest), 3), np.nan)
    done = 0

    def note() -> None:
        nonlocal done
        done += 1
        progress(done / (2 * len(newest)))
        if not may_continue():
            raise WorkCancelledError("series.unwanted", "The series is not wanted any more.")

    grid = grid_for(log, config, trajectory, limits)
    states = np.full(grid.geometry.shape, UNKNOWN, dtype=np.int8)
    bits = np.zeros(-(-len(states) // TILE))  #: per row of tiles
    start = 0
    for row, scan in enumerate(newest.tolist()):
        box = integrate_scans(grid, log, config, trajectory, start, scan + 1).box
        changed = 0
        for tiles in range(0 if box is None else box.row0 // TILE, 0 if box is None else -(-box.row1 // TILE)):
            rows = slice(tiles * TILE, min((tiles + 1) * TILE, len(states)))
            band = grid.band(rows)
            classes = band.classify()
            bits[tiles] = map_metrics(band).entropy_bits
            changed += int(np.count_nonzero(classes != states[rows]))
            states[rows] = classes
        values[row, :2] = bits.sum(), changed
        start = scan + 1
        note()
    walls = ndimage.binary_dilation(states == OCCUPIED, iterations=TOLERANCE)
    for row, scan in enumerate(newest.tolist()):
        values[row, 2] = _contradicted(states, walls, grid.geometry, placed_scan(log, config, trajectory, scan), config)
        note()
    stamps = plot_stamps(log)[newest]
    order = np.argsort(stamps, kind="stable")
    return Series("map", "scan", COLUMNS, stamps[order], values[order])


def _contradicted(
    states: NDArray[np.int8],
    walls: NDArray[np.bool_],
    geometry: GridGeometry,
    placed: PosedScan,
    config: MappingConfig,
) -> float:
    """Return the percentage of a scan's readings that the map of ``states`` contradicts; NaN without readings."""
    scan = placed.scan
    if isinstance(scan, SonarScan) and scan.beam_width > 0.0:
        return float("nan")
    plan = plan_update(config, scan.range_min, scan.range_max)
    batch = scan_batch_of_scan(scan, placed.sensor_pose, plan)
    crossed = crossed_cells(
        geometry, batch, plan.reading_filter._replace(window=0.0, growth=0.0), exact_rays=plan.exact_rays
    )
    if not len(crossed.cells):
        return float("nan")
    state, is_near = states.ravel()[crossed.cells], walls.ravel()[crossed.cells]
    before = crossed.z - crossed.r
    passes = (state == OCCUPIED) & (before > TOLERANCE * geometry.resolution)
    ends_in_free = (before == 0.0) & (state == FREE) & ~is_near
    contradicted = np.unique(crossed.beams[passes | ends_in_free])
    return 100.0 * len(contradicted) / len(np.unique(crossed.beams))
