"""Sonar cones: the evidence of a cell depends on its distance and its angle from the axis.

Numba twin of :func:`mapper.mapping.textbook.evidence_in_cone` and of :func:`mapper.mapping.textbook.update_per_scan`
for models whose evidence differs from cell to cell. A cone is between two edges, unit vectors of the lattice (u along
columns, v along rows): to the left of its right edge, the edge included, and to the right of its left edge. The
candidate rows and columns are found approximately; each cell in them is tested exactly, as in the textbook.
"""

from __future__ import annotations

from math import atan2, exp, floor, sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels.smooth_ramp import _ramp
from mapper.mapping.kernels.types import Cells, Cone, Evidence, LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

FLAT, GAUSSIAN, RAMP = range(3)  #: profiles
NOTHING, RETURN, NO_RETURN = range(3)  #: kinds of readings

_NEAR_ZERO = 1e-9


@jit
def _kind_of(z: float, reading_filter: ReadingFilter) -> int:
    """Classify a reading: nothing, a range, or no return with free space."""
    range_min, range_max, _, _, no_return_free = reading_filter
    if range_min <= z <= range_max:
        return RETURN
    return NO_RETURN if z > range_max and no_return_free else NOTHING


@jit
def _edges_of(fields: Float64Array, k: int, turn_u: float, turn_v: float) -> tuple[float, float, float, float]:
    """Return the right and left edge of beam ``k`` in the lattice: ``fields`` rotated by the sensor's heading."""
    return (
        turn_u * fields[k, 0] - turn_v * fields[k, 1],
        turn_v * fields[k, 0] + turn_u * fields[k, 1],
        turn_u * fields[k, 2] - turn_v * fields[k, 3],
        turn_v * fields[k, 2] + turn_u * fields[k, 3],
    )


@jit
def _rows_of(v: float, edges: tuple[float, float, float, float], radius: float, low: int, high: int) -> tuple[int, int]:
    """Return the rows [first, stop) within [low, high) that a cone of ``radius`` cells may reach, with a margin of
    one.
    """
    right_u, right_v, left_u, left_v = edges
    least, most = min(0.0, right_v, left_v), max(0.0, right_v, left_v)
    if right_u >= -_NEAR_ZERO and left_u <= _NEAR_ZERO:  # the cone contains the +v direction
        most = 1.0
    if right_u <= _NEAR_ZERO and left_u >= -_NEAR_ZERO:  # the cone contains the −v direction
        least = -1.0
    return max(floor(v + least * radius) - 1, low), min(floor(v + most * radius) + 2, high)


@jit
def _columns_of(
    d_v: float, u: float, edges: tuple[float, float, float, float], radius: float, cols: int
) -> tuple[int, int]:
    """Return the columns [first, stop) of a row that a cone may reach, with a margin of one."""
    right_u, right_v, left_u, left_v = edges
    reach = radius + 1.0
    square = reach * reach - d_v * d_v
    half = sqrt(square) if square > 0.0 else 0.0
    low, high = -half, half
    if right_v > _NEAR_ZERO:
        high = min(high, right_u * d_v / right_v)
    elif right_v < -_NEAR_ZERO:
        low = max(low, right_u * d_v / right_v)
    if left_v > _NEAR_ZERO:
        low = max(low, left_u * d_v / left_v)
    elif left_v < -_NEAR_ZERO:
        high = min(high, left_u * d_v / left_v)
    return max(floor(u + low) - 1, 0), min(floor(u + high) + 2, cols)


@jit
def _lies_in(d_u: float, d_v: float, edges: tuple[float, float, float, float]) -> bool:
    """Return whether a cell's centre, (d_u, d_v) cells from the sensor, is between the edges."""
    right_u, right_v, left_u, left_v = edges
    return right_u * d_v - right_v * d_u >= 0.0 and left_u * d_v - left_v * d_u < 0.0


@jit
def _angle_off(d_u: float, d_v: float, axis_u: float, axis_v: float) -> float:
    """Return the angle between a cell's centre and a beam's axis, radians."""
    return atan2(axis_u * d_v - axis_v * d_u, axis_u * d_u + axis_v * d_v)


@jit
def _cone_evidence(s: float, z: float, half: float, theta: float, cone: Cone, evidence: Evidence) -> float:
    """Return the evidence of a reading ``z`` for s ≤ z + ``half``; metres and radians."""
    miss, hit = evidence
    if cone.profile == RAMP:
        return _ramp(s, z, half, miss, hit)
    if s < z - half:
        weight = 1.0 - (s / (z - half)) ** 2
        value = miss
    else:
        weight = 1.0 - ((s - z) / half) ** 2
        value = hit
    if cone.profile == GAUSSIAN:
        off = theta / cone.opening
        return value * weight * exp(-8.0 * off * off)
    return value


@jit
def draw_cones(
    cells: Cells,
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    cone: Cone,
    evidence: Evidence,
    marked: BoolArray,
    log_odds_update: LogOddsUpdate,
    row_low: int,
    row_high: int,
    box: Int64Array,
) -> int:
    """Add the evidence of the cones of all beams to the rows [row_low, row_high); return the number of cell updates.

    For the tuples see :mod:`mapper.mapping.kernels.types`. With ``cone.mark_endpoints`` the cells that hold endpoints
    get only the hit increment of ``log_odds_update``, once per scan. ``marked`` (rows · cols,), used only then, is
    scratch memory, false before and after. ``box`` as in :func:`mapper.mapping.kernels.bresenham.draw_lines`.
    """
    log_odds, observed, cols = cells
    ranges, sensors, beams, fields, headings, _ = scans
    _, hit, low, high = log_odds_update
    _, range_max, window, growth, _ = reading_filter
    resolution, n_beams, mark_endpoints = frame.resolution, ranges.shape[1], cone.mark_endpoints
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    ends = np.full(n_beams if mark_endpoints else 0, -1, dtype=np.int64)
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        for k in range(len(ends)):
            ends[k] = -1
            z = float(ranges[t, k])
            if _kind_of(z, reading_filter) != RETURN:
                continue
            px, py = z * beams[k, 0], z * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
            r, c = int(_cell_of(ev)), int(_cell_of(eu))
            if row_low <= r < row_high and 0 <= c < cols:
                ends[k] = r * cols + c
                marked[ends[k]] = True
        for k in range(n_beams):
            z = float(ranges[t, k])
            kind = _kind_of(z, reading_filter)
            edges = _edges_of(fields, k, turn_u, turn_v)
            if kind == NOTHING or (edges[0] == edges[2] and edges[1] == edges[3]):
                continue
            half = 0.5 * (window + growth * z) if kind == RETURN else 0.0
            limit = min(z + half, range_max)
            radius = limit / resolution
            axis_u, axis_v = turn_u * beams[k, 0] - turn_v * beams[k, 1], turn_v * beams[k, 0] + turn_u * beams[k, 1]
            first_row, stop_row = _rows_of(v, edges, radius, row_low, row_high)
            for r in range(first_row, stop_row):
                d_v = r + 0.5 - v
                first, stop = _columns_of(d_v, u, edges, radius, cols)
                for c in range(first, stop):
                    d_u = c + 0.5 - u
                    s = sqrt(d_u * d_u + d_v * d_v) * resolution
                    cell = r * cols + c
                    if not _lies_in(d_u, d_v, edges) or (mark_endpoints and marked[cell]):
                        continue
                    if kind == RETURN:
                        if s > limit:
                            continue
                        increment = _cone_evidence(s, z, half, _angle_off(d_u, d_v, axis_u, axis_v), cone, evidence)
                    else:
                        if s >= range_max:
                            continue
                        increment = evidence.miss
                    log_odds[cell] = min(max(log_odds[cell] + np.float32(increment), low), high)
                    observed[cell] = True
                    top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
                    count += 1
        for k in range(len(ends)):
            cell = ends[k]
            if cell >= 0 and marked[cell]:
                marked[cell] = False
                log_odds[cell] = min(max(log_odds[cell] + hit, low), high)
                observed[cell] = True
                r, c = cell // cols, cell % cols
                top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
                count += 1
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count


@jit
def contributions_of_cones(
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    cone: Cone,
    evidence: Evidence,
    row: int,
    col: int,
    out: Int64Array,
    increments: Float32Array,
) -> int:
    """Test a cell against cones. Writes ``out`` (≥ n, 2) int64 and ``increments`` (≥ n,), the touches in order.

    The format is that of :mod:`mapper.mapping.kernels.contributions`. With ``cone.mark_endpoints`` a scan that ends in
    the cell is attributed to the first beam that does.
    """
    ranges, sensors, beams, fields, headings, _ = scans
    _, range_max, window, growth, _ = reading_filter
    resolution, n_beams = frame.resolution, ranges.shape[1]
    count = 0
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        d_u, d_v = col + 0.5 - u, row + 0.5 - v
        s = sqrt(d_u * d_u + d_v * d_v) * resolution
        ended = -1
        if cone.mark_endpoints:
            for k in range(n_beams):
                z = float(ranges[t, k])
                if _kind_of(z, reading_filter) != RETURN or abs(s - z) > 2.0 * resolution:
                    continue
                px, py = z * beams[k, 0], z * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
                if int(_cell_of(ev)) == row and int(_cell_of(eu)) == col:
                    ended = k
                    break
        if ended >= 0:
            out[count, 0], out[count, 1], increments[count] = t * n_beams + ended, 1, evidence.hit
            count += 1
            continue
        for k in range(n_beams):
            z = float(ranges[t, k])
            kind = _kind_of(z, reading_filter)
            edges = _edges_of(fields, k, turn_u, turn_v)
            if kind == NOTHING or not _lies_in(d_u, d_v, edges):
                continue
            increment = evidence.miss
            hit = False
            if kind == RETURN:
                half = 0.5 * (window + growth * z)
                if s > min(z + half, range_max):
                    continue
                axis_u = turn_u * beams[k, 0] - turn_v * beams[k, 1]
                axis_v = turn_v * beams[k, 0] + turn_u * beams[k, 1]
                increment = _cone_evidence(s, z, half, _angle_off(d_u, d_v, axis_u, axis_v), cone, evidence)
                hit = s >= z - half
            elif s >= range_max:
                continue
            out[count, 0], out[count, 1], increments[count] = t * n_beams + k, hit, increment
            count += 1
    return count
