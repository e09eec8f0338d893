"""Readings that updated one cell, recomputed from the scans; no per-cell history is kept.

Each kernel tests one cell against what :mod:`mapper.mapping.kernels.bresenham`,
:mod:`~mapper.mapping.kernels.amanatides_woo` or :mod:`~mapper.mapping.kernels.perceptual_field` would draw. It writes,
in the order in which the map was built, the number of each reading (scan · n_beams + beam) and whether it was a hit (1)
or a miss (0), and returns the number of readings.
"""

from __future__ import annotations

from math import inf, isnan, sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels import amanatides_woo
from mapper.mapping.kernels import bresenham as lines
from mapper.mapping.kernels.amanatides_woo import _crosses
from mapper.mapping.kernels.bresenham import _step_at
from mapper.mapping.kernels.types import ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

MISS, HIT = 0, 1


@jit
def filter_readings_near_cell(
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    row: int,
    col: int,
    sifted: Float32Array,
    near: BoolArray,
) -> None:
    """Write the readings whose beams may touch a cell, NaN for all others, and mark the scans with such a beam.

    ``sifted`` (n_scans, n_beams) float32 and ``near`` (n_scans,) bool are written; the other arguments are those of
    :func:`mapper.mapping.kernels.bresenham.plan_lines`.
    """
    ranges, sensors, beams = scans.ranges, scans.sensors, scans.beams
    _, range_max, window, growth, _ = reading_filter
    origin_x, origin_y, cos_yaw, sin_yaw, resolution = frame
    spare = 3.0 * resolution  # every cell of a traversal is closer to its beam than this
    d_u, d_v = (col + 0.5) * resolution, (row + 0.5) * resolution
    cell_x, cell_y = origin_x + cos_yaw * d_u - sin_yaw * d_v, origin_y + sin_yaw * d_u + cos_yaw * d_v
    for t in range(ranges.shape[0]):
        d_x, d_y = cell_x - sensors[t, 0], cell_y - sensors[t, 1]
        cos, sin = sensors[t, 2], sensors[t, 3]
        ahead, aside = cos * d_x + sin * d_y, cos * d_y - sin * d_x  # relative to the sensor
        count = 0
        for k in range(ranges.shape[1]):
            z = ranges[t, k]
            along, across = beams[k, 0] * ahead + beams[k, 1] * aside, beams[k, 0] * aside - beams[k, 1] * ahead
            reach = min(z, range_max) * (1.0 + 0.5 * growth) + 0.5 * window + spare
            close = (abs(across) <= spare) & (along >= -spare) & (along <= reach)
            sifted[t, k] = z if close else np.float32(np.nan)
            count |= close
        near[t] = count


@jit
def contributions_of_lines(planned: Int32Array, row: int, col: int, out: Int64Array) -> int:
    """Test a cell against planned lines (9, n). Writes ``out`` (≥ n, 2) int64."""
    count = 0
    for j in range(planned.shape[1]):
        kind = -1
        if row == planned[lines.HIT_ROW, j] and col == planned[lines.HIT_COL, j]:
            kind = HIT
        elif planned[lines.FAR, j] > 0:  # an ignored beam has no line
            start_row, start_col = int(planned[lines.ROW, j]), int(planned[lines.COL, j])
            end_row, end_col = int(planned[lines.END_ROW, j]), int(planned[lines.END_COL, j])
            i = _step_at(start_row, start_col, end_row, end_col, row, col)
            if 0 <= i < planned[lines.FAR, j]:
                kind = MISS if i < planned[lines.NEAR, j] else HIT
        if kind >= 0:
            out[count, 0], out[count, 1] = j, kind
            count += 1
    return count


@jit
def contributions_of_rays(planned: Float64Array, resolution: float, row: int, col: int, out: Int64Array) -> int:
    """Test a cell against planned rays (n, 8). Writes ``out`` (≥ n, 2) int64; ``resolution`` is in metres per cell."""
    count = 0
    for j in range(planned.shape[0]):
        ray = planned[j]
        u, v, z, half = ray[amanatides_woo.U], ray[amanatides_woo.V], ray[amanatides_woo.Z], ray[amanatides_woo.HALF]
        end_u, end_v = ray[amanatides_woo.END_U], ray[amanatides_woo.END_V]
        if isnan(z):
            continue
        hit_row, hit_col = int(_cell_of(ray[amanatides_woo.HIT_V])), int(_cell_of(ray[amanatides_woo.HIT_U]))
        kind = -1
        if z < inf and row == hit_row and col == hit_col:
            kind = HIT
        elif _crosses(u, v, end_u, end_v, row, col):
            kind = MISS
            if half > 0.0 and z < inf:
                c_u, c_v = col + 0.5 - u, row + 0.5 - v
                s = sqrt(c_u * c_u + c_v * c_v) * resolution
                if s >= z - half:
                    kind = HIT if s <= z + half else -1
        if kind >= 0:
            out[count, 0], out[count, 1] = j, kind
            count += 1
    return count


@jit
def contributions_of_fields(
    scans: Scans, frame: Frame, reading_filter: ReadingFilter, row: int, col: int, out: Int64Array
) -> int:
    """Test a cell against scans, at most one touch each. Writes ``out`` (≥ n_scans, 2) int64.

    A scan that hits the cell is attributed to the first beam that ends in it, otherwise to the beam whose field
    contains it. The other arguments are those of :func:`mapper.mapping.kernels.perceptual_field.plan_fields`.
    """
    ranges, sensors, beams, fields, headings, _ = scans
    range_min, range_max, window, growth, no_return_free = reading_filter
    resolution = frame.resolution
    n_beams = ranges.shape[1]
    count = 0
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        d_u, d_v = col + 0.5 - u, row + 0.5 - v
        s = sqrt(d_u * d_u + d_v * d_v) * resolution
        beam, kind = -1, -1
        for k in range(n_beams):
            z = float(ranges[t, k])
            if not range_min <= z <= range_max or abs(s - z) > 2.0 * resolution:  # the endpoint is in another cell
                continue
            px, py = z * beams[k, 0], z * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
            if int(_cell_of(ev)) == row and int(_cell_of(eu)) == col:
                beam, kind = k, HIT
                break
        if beam < 0:
            for k in range(n_beams):
                right_u = turn_u * fields[k, 0] - turn_v * fields[k, 1]
                right_v = turn_v * fields[k, 0] + turn_u * fields[k, 1]
                left_u = turn_u * fields[k, 2] - turn_v * fields[k, 3]
                left_v = turn_v * fields[k, 2] + turn_u * fields[k, 3]
                if right_u * d_v - right_v * d_u >= 0.0 and left_u * d_v - left_v * d_u < 0.0:
                    z = float(ranges[t, k])
                    half = 0.5 * (window + growth * z)
                    if range_min <= z <= range_max:
                        if s < z - half:
                            beam, kind = k, MISS
                        elif s <= min(range_max, z + half) and half > 0.0:
                            beam, kind = k, HIT
                    elif z > range_max and no_return_free and s < range_max:
                        beam, kind = k, MISS
                    break
        if beam >= 0:
            out[count, 0], out[count, 1] = t * n_beams + beam, kind
            count += 1
    return count


@jit
def running_sum(increments: Float32Array, start: np.float32, low: np.float32, high: np.float32,
                out: Float32Array) -> None:  # fmt: skip
    """Write the clamped sum after each increment, starting at ``start``; all (n,) float32 log-odds."""
    value = start
    for j in range(len(increments)):
        value = min(max(value + increments[j], low), high)
        out[j] = value
