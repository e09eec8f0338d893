"""Per-beam update along exact rays: every cell crossed by the segment from the sensor to the reading.

Numba twin of :func:`mapper.mapping.textbook.update_per_beam` with Amanatides and Woo's traversal, in the two passes of
:mod:`mapper.mapping.kernels.bresenham`. A ray is always traversed from its start, because its next cell depends on the
borders crossed before.
"""

from __future__ import annotations

from math import inf, isnan, nan, sqrt

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels.hits_first import _add_hits, _put_back
from mapper.mapping.kernels.negative_zero import _without_minus_zero
from mapper.mapping.kernels.smooth_ramp import _ramp
from mapper.mapping.kernels.types import Cells, Evidence, LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

#: A planned ray, in lattice coordinates and metres: the sensor, the last point, the endpoint, the reading z, and the
#: half width around z in which a centre counts as hit. z is +inf for a beam without return and NaN for an ignored beam.
U, V, END_U, END_V, HIT_U, HIT_V, Z, HALF = range(8)
RAY_FIELDS = 8


@jit
def plan_rays(
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    first: int,
    rays: Float64Array,
    work: Float64Array,
    box: Int64Array,
) -> None:
    """Write the ray of each beam, scan by scan.

    Like :func:`mapper.mapping.kernels.bresenham.plan_lines`, but writes the rows of ``rays`` (n, 8) float64 from
    ``first`` on.
    """
    ranges, sensors, beams = scans.ranges, scans.sensors, scans.beams
    range_min, range_max, window, growth, no_return_free = reading_filter
    rows = len(work) - 1
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, frame)
        for k in range(ranges.shape[1]):
            ray = rays[first + t * ranges.shape[1] + k]
            ray[Z] = nan
            z = float(ranges[t, k])
            no_return = z > range_max
            if no_return:
                if not no_return_free:
                    continue
                z = range_max
            elif not z >= range_min:  # too near, NaN or −Inf
                continue
            half = 0.5 * (window + growth * z)
            px, py = z * beams[k, 0], z * beams[k, 1]
            hit_u, hit_v = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
            end_u, end_v = hit_u, hit_v
            if half > 0.0 and not no_return:
                px, py = (z + half) * beams[k, 0], (z + half) * beams[k, 1]
                end_u, end_v = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
            ray[U], ray[V], ray[END_U], ray[END_V], ray[HIT_U], ray[HIT_V] = u, v, end_u, end_v, hit_u, hit_v
            ray[Z], ray[HALF] = inf if no_return else z, half
            row, end_row = int(_cell_of(v)), int(_cell_of(end_v))
            low, high = max(min(row, end_row), 0), min(max(row, end_row), rows - 1)
            if low <= high:
                cells = (abs(end_u - u) + abs(end_v - v) + 1.0) / (abs(end_row - row) + 1.0)
                work[low] += cells
                work[high + 1] -= cells
            col, end_col = int(_cell_of(u)), int(_cell_of(end_u))
            top, bottom = min(top, row, end_row), max(bottom, row + 1, end_row + 1)
            left, right = min(left, col, end_col), max(right, col + 1, end_col + 1)
    box[0], box[1], box[2], box[3] = top, bottom, left, right


@jit
def _draw(
    cells: Cells, rays: Float64Array, resolution: float, smooth: bool, evidence: Evidence,
    log_odds_update: LogOddsUpdate, row_low: int, row_high: int, box: Int64Array, mark: bool, hits: Int64Array,
) -> tuple[int, int]:  # fmt: skip
    """Add the evidence of rays, as in :func:`draw_rays`, or list the cells that they hit if ``hits`` has room.

    Return the number of cell updates and the number of cells written to ``hits``.
    """
    log_odds, observed, cols = cells
    lists = len(hits) > 0
    n_hits = 0
    miss, hit, low, high = _without_minus_zero(log_odds_update)
    # Local copies, because the boxes of two threads may share a cache line (false sharing).
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    for j in range(rays.shape[0]):
        ray = rays[j]
        if isnan(ray[Z]):
            continue
        u, v, d_u, d_v, z, half = ray[U], ray[V], ray[END_U] - ray[U], ray[END_V] - ray[V], ray[Z], ray[HALF]
        row, col = int(_cell_of(v)), int(_cell_of(u))
        end_row, end_col = int(_cell_of(ray[END_V])), int(_cell_of(ray[END_U]))
        hit_row, hit_col = int(_cell_of(ray[HIT_V])), int(_cell_of(ray[HIT_U]))
        s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
        ahead_row, ahead_col = (1 if s_row > 0 else 0), (1 if s_col > 0 else 0)
        t_row = (row + ahead_row - v) / d_v if row != end_row else inf
        t_col = (col + ahead_col - u) / d_u if col != end_col else inf
        inside = max(row, end_row) >= row_low and min(row, end_row) < row_high and not (lists and half == 0.0)
        while inside:
            if row_low <= row < row_high and 0 <= col < cols and (z == inf or row != hit_row or col != hit_col):
                increment = miss
                counts = True
                if half > 0.0 and z < inf:
                    c_u, c_v = col + 0.5 - u, row + 0.5 - v
                    s = sqrt(c_u * c_u + c_v * c_v) * resolution
                    if s >= z - half:
                        increment = np.float32(_ramp(s, z, half, evidence.miss, evidence.hit) + 0.0) if smooth else hit
                        counts = s <= z + half
                        if lists and counts:
                            hits[n_hits] = row * cols + col
                            n_hits += 1
                if counts and not lists:
                    cell = row * cols + col
                    log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
                    if mark:
                        observed[cell] = True
                    top, bottom = min(top, row), max(bottom, row + 1)
                    left, right = min(left, col), max(right, col + 1)
                    count += 1
            if row == end_row and col == end_col:
                break
            if t_col < t_row:
                col += s_col
                t_col = (col + ahead_col - u) / d_u if col != end_col else inf
            else:
                row += s_row
                t_row = (row + ahead_row - v) / d_v if row != end_row else inf
        if z < inf and row_low <= hit_row < row_high and 0 <= hit_col < cols:
            cell = hit_row * cols + hit_col
            if lists:
                hits[n_hits] = cell
                n_hits += 1
                continue
            log_odds[cell] = min(max(log_odds[cell] + hit, low), high)
            if mark:
                observed[cell] = True
            top, bottom = min(top, hit_row), max(bottom, hit_row + 1)
            left, right = min(left, hit_col), max(right, hit_col + 1)
            count += 1
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count, n_hits


@jit
def draw_rays(
    cells: Cells,
    rays: Float64Array,
    resolution: float,
    smooth: bool,
    evidence: Evidence,
    log_odds_update: LogOddsUpdate,
    scan_ends: Int64Array,
    row_low: int,
    row_high: int,
    box: Int64Array,
    mark: bool,
) -> int:
    """Add the evidence of ``rays`` (n, 8) to the rows [row_low, row_high) of the grid; return the number of cell
    updates.

    The other arguments are those of :func:`mapper.mapping.kernels.bresenham.draw_lines`; ``resolution`` is in metres
    per cell. With ``smooth`` the evidence in the window is a ramp from ``evidence``'s miss to its hit.
    """
    none = np.empty(0, dtype=np.int64)
    if len(scan_ends) == 0:
        count, _ = _draw(
            cells, rays, resolution, smooth, evidence, log_odds_update, row_low, row_high, box, mark, none
        )  # fmt: skip
        return count
    own = box.copy()  # a copy, because the boxes of two threads may share a cache line (false sharing)
    first, count = 0, 0
    for end in scan_ends:
        part = rays[first:end]
        room = len(part)
        for j in range(len(part)):
            if not isnan(part[j, Z]):
                room += int(4.0 * part[j, HALF] / resolution) + 8  # more than the cells in the window
        hits = np.empty(room, dtype=np.int64)
        _, n = _draw(cells, part, resolution, smooth, evidence, log_odds_update, row_low, row_high, own, mark, hits)
        held = _add_hits(cells.log_odds, hits[:n], log_odds_update)
        added, _ = _draw(cells, part, resolution, smooth, evidence, log_odds_update, row_low, row_high, own, mark, none)
        _put_back(cells.log_odds, hits[:n], held)
        first, count = end, count + added
    box[:] = own
    return count


@jit
def _crosses(u: float, v: float, end_u: float, end_v: float, at_row: int, at_col: int) -> bool:
    """Return whether the traversal from (u, v) to (end_u, end_v), lattice coordinates, visits a cell."""
    d_u, d_v = end_u - u, end_v - v
    row, col, end_row, end_col = int(_cell_of(v)), int(_cell_of(u)), int(_cell_of(end_v)), int(_cell_of(end_u))
    if not (min(row, end_row) <= at_row <= max(row, end_row) and min(col, end_col) <= at_col <= max(col, end_col)):
        return False
    s_row, s_col = (1 if end_row >= row else -1), (1 if end_col >= col else -1)
    ahead_row, ahead_col = (1 if s_row > 0 else 0), (1 if s_col > 0 else 0)
    # The ray enters the row before it leaves the column, and vice versa. At equal t the row's border is crossed first.
    enter_row = (at_row - s_row + ahead_row - v) / d_v if at_row != row else -inf
    leave_row = (at_row + ahead_row - v) / d_v if at_row != end_row else inf
    enter_col = (at_col - s_col + ahead_col - u) / d_u if at_col != col else -inf
    leave_col = (at_col + ahead_col - u) / d_u if at_col != end_col else inf
    return enter_row <= leave_col and enter_col < leave_row
