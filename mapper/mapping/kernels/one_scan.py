"""The per-beam update with Bresenham's lines for one scan of a live robot, in one call."""

from __future__ import annotations

from math import floor

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, to_lattice
from mapper.mapping.kernels.bresenham import LINE_FIELDS, draw_lines, plan_lines, reach
from mapper.mapping.kernels.types import Cells, LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)

BEYOND = -1  #: the scan reaches beyond the grid, which has to grow first


@jit
def add_scan(
    log_odds: Float32Array,
    observed: BoolArray,
    ranges: Float32Array,
    sensor: tuple[float, float, float, float],
    beams: Float64Array,
    frame: Frame,
    reading_filter: ReadingFilter,
    log_odds_update: LogOddsUpdate,
    box: Int64Array,
) -> int:
    """Add one scan to ``log_odds`` and ``observed`` (rows, cols); return the number of cell updates.

    Where the scan reaches beyond the grid, :data:`BEYOND` is returned, and nothing was written. ``ranges`` (n_beams,)
    metres, ``sensor`` (x, y, cos θ, sin θ) of ``T_map_laser``, ``beams`` (n_beams, 2) cosine and sine of the bearings.
    ``box`` (4,) int64 (row0, row1, col0, col1), half-open, is widened to hold what was touched. The same bits as
    :func:`plan_lines` and :func:`draw_lines` give, which it calls; its textbook is theirs.
    """
    rows, cols = log_odds.shape
    readings = ranges.reshape(1, len(ranges))
    sensors = np.empty((1, 4))
    sensors[0, 0], sensors[0, 1], sensors[0, 2], sensors[0, 3] = sensor
    bounds = np.array([np.inf, np.inf, -np.inf, -np.inf])
    reach(readings, sensors, beams, reading_filter, bounds)
    for corner in range(4):
        u, v = _to_lattice(bounds[2 * (corner % 2)], bounds[1 + 2 * (corner // 2)], frame)
        if not (0 <= floor(v) < rows and 0 <= floor(u) < cols):
            return BEYOND
    lines = np.empty((LINE_FIELDS, len(ranges)), dtype=np.int32)
    work = np.zeros(rows + 1)
    reached = np.array([rows, 0, cols, 0])
    # Lines need no fields and no headings: the bearings, which have the right type, are passed for them.
    scans = Scans(readings, sensors, beams, beams, beams)
    plan_lines(scans, frame, reading_filter, 0, lines, work, reached)
    cells = Cells(log_odds.reshape(-1), observed.reshape(-1), cols)
    return draw_lines(cells, lines, log_odds_update, False, 0, rows, box, True)
