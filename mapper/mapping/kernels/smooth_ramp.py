"""Smooth ramp along Bresenham's lines: like :mod:`mapper.mapping.kernels.bresenham`, but evidence varies in the window.

Numba twin of :func:`mapper.mapping.textbook.evidence_along_beam` for :class:`mapper.mapping.sensor_model.SmoothRamp`.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, to_lattice
from mapper.mapping.kernels.bresenham import (
    AT,
    COL,
    END_COL,
    END_ROW,
    FAR,
    HIT_COL,
    HIT_ROW,
    NEAR,
    ROW,
    _clip,
    _crossing,
)
from mapper.mapping.kernels.negative_zero import _without_minus_zero
from mapper.mapping.kernels.types import Cells, Evidence, LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)


@jit
def _ramp(s: float, z: float, half: float, miss: float, hit: float) -> float:
    """Return the evidence at distance ``s`` of a reading ``z``, metres; ``half`` is 2σ."""
    t = (s - z) / half
    if t <= -1.0:
        return miss
    if t <= 0.0:
        t += 1.0
        return miss + (hit - miss) * (t * t * (3.0 - 2.0 * t))
    t = max(1.0 - t, 0.0)
    return hit * (t * t * (3.0 - 2.0 * t))


@jit
def draw_ramps(
    cells: Cells,
    lines: Int32Array,
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    evidence: Evidence,
    log_odds_update: LogOddsUpdate,
    row_low: int,
    row_high: int,
    box: Int64Array,
    mark: bool,
) -> int:
    """Add the evidence of ``lines`` (9, n_scans · n_beams) to the rows [row_low, row_high); return the number of
    updates.

    ``scans`` are those from which the lines were planned. The ramp rises from the miss of ``evidence`` to its hit. The
    other arguments are those of :func:`mapper.mapping.kernels.bresenham.draw_lines`.
    """
    log_odds, observed, cols = cells
    ranges, sensors = scans.ranges, scans.sensors
    miss, hit, low, high = _without_minus_zero(log_odds_update)
    window, growth = reading_filter.window, reading_filter.growth
    resolution, n_beams = frame.resolution, ranges.shape[1]
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    chosen = _crossing(lines, row_low, row_high)
    for number in range(len(chosen)):
        j = chosen[number]
        row, col = int(lines[ROW, j]), int(lines[COL, j])
        end_row, end_col = int(lines[END_ROW, j]), int(lines[END_COL, j])
        d_row, d_col = abs(end_row - row), abs(end_col - col)
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        steep = d_row > d_col
        major, minor = (d_row, d_col) if steep else (d_col, d_row)
        twice = max(2 * major, 1)
        first, stop = _clip(row, s_row, row_low, row_high, major, minor, steep, 0, min(int(lines[FAR, j]), major + 1))
        first, stop = _clip(col, s_col, 0, cols, major, minor, not steep, first, stop)
        if first < stop:
            near, at = int(lines[NEAR, j]), int(lines[AT, j])
            x, y = sensors[j // n_beams, 0], sensors[j // n_beams, 1]
            u, v = _to_lattice(x, y, frame)
            z = float(ranges[j // n_beams, j % n_beams])
            half = 0.5 * (window + growth * z)
            for i in range(first, stop):
                if i == at:  # the endpoint's cell is drawn last
                    continue
                n = (2 * i * minor + major) // twice
                r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
                increment = miss
                if i >= near:
                    d_u, d_v = c + 0.5 - u, r + 0.5 - v
                    s = sqrt(d_u * d_u + d_v * d_v) * resolution
                    increment = np.float32(_ramp(s, z, half, evidence.miss, evidence.hit) + 0.0)  # never −0
                cell = r * cols + c
                log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
                if mark:
                    observed[cell] = True
                count += 1
            for i in (first, stop - 1):
                n = (2 * i * minor + major) // twice
                r, c = row + s_row * (i if steep else n), col + s_col * (n if steep else i)
                top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
        r, c = int(lines[HIT_ROW, j]), int(lines[HIT_COL, j])
        if row_low <= r < row_high and 0 <= c < cols:
            cell = r * cols + c
            log_odds[cell] = min(max(log_odds[cell] + hit, low), high)
            if mark:
                observed[cell] = True
            top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
            count += 1
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count
