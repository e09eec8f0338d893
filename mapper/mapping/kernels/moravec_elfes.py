"""Grids of Moravec and Elfes, 1985: for each cell the certainty that it is empty, and that it is occupied.

Numba twin of :func:`mapper.mapping.textbook.update_moravec_elfes`. A reading's certainty of "occupied" is distributed
over its whole arc, which may be anywhere in the grid, so scans are added sequentially by one thread.
"""

from __future__ import annotations

from math import sqrt

from mapper.core.array_types import BoolArray, Float32Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, to_lattice
from mapper.mapping.kernels.cones import (
    NO_RETURN,
    NOTHING,
    RETURN,
    _angle_off,
    _columns_of,
    _edges_of,
    _kind_of,
    _lies_in,
    _rows_of,
)
from mapper.mapping.kernels.types import ReadingFilter, Scans

_to_lattice = jit(to_lattice)

_EMPTY, _SUM, _OCCUPIED = range(3)  # operations on the cells of a cone


@jit
def _cone(
    what: int, occupied: Float32Array, empty: Float32Array, observed: BoolArray, cols: int, z: float, half: float,
    limit: float, opening: float, u: float, v: float, axis_u: float, axis_v: float,
    edges: tuple[float, float, float, float], resolution: float, share: float, box: Int64Array,
) -> tuple[float, int]:  # fmt: skip
    """Process a cone's cells; return the sum over its arc and the number of changed cells."""
    rows = occupied.shape[0] // cols
    radius = limit / resolution
    total, count = 0.0, 0
    first_row, stop_row = _rows_of(v, edges, radius, 0, rows)
    for r in range(first_row, stop_row):
        d_v = r + 0.5 - v
        first, stop = _columns_of(d_v, u, edges, radius, cols)
        for c in range(first, stop):
            d_u = c + 0.5 - u
            s = sqrt(d_u * d_u + d_v * d_v) * resolution
            before = s < z - half
            if s > limit or before != (what == _EMPTY) or not _lies_in(d_u, d_v, edges):
                continue
            off = _angle_off(d_u, d_v, axis_u, axis_v) / (0.5 * opening)
            weight = max(1.0 - off * off, 0.0)
            cell = r * cols + c
            if what == _EMPTY:
                weight *= 1.0 - (s / (z - half)) ** 2
                empty[cell] += weight * (1.0 - empty[cell])
            else:
                # Reduced where the cell is known to be empty, then normalised so that the whole arc holds one obstacle.
                weight *= (1.0 - ((s - z) / half) ** 2) * (1.0 - empty[cell])
                total += weight
                if what == _SUM:
                    continue
                occupied[cell] += weight / share * (1.0 - occupied[cell])
            observed[cell] = True
            box[0], box[1] = min(box[0], r), max(box[1], r + 1)
            box[2], box[3] = min(box[2], c), max(box[3], c + 1)
            count += 1
    return total, count


@jit
def add_certainties(
    occupied: Float32Array,
    empty: Float32Array,
    observed: BoolArray,
    cols: int,
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    opening: float,
    box: Int64Array,
    watched: int,
    contributions: Int64Array,
    certainties: Float32Array,
) -> tuple[int, int]:
    """Add scans in order; return the number of cell updates and of touches of the cell ``watched``.

    ``occupied``, ``empty`` float32 and ``observed`` bool, each (rows · cols,), are the grid's cells, row by row;
    ``opening`` is the cone's angle in radians. Each update of cell number ``watched`` (−1: none) is written to
    ``contributions`` (≥ n, 2) int64, the reading's number and 1 for occupied or 0 for empty, and its values after the
    update, occupied and empty, to ``certainties`` (≥ n, 2).
    """
    ranges, sensors, beams, fields, headings, _ = scans
    range_max, half = reading_filter.range_max, 0.5 * reading_filter.window
    resolution, n_beams = frame.resolution, ranges.shape[1]
    count, noted = 0, 0
    for t in range(ranges.shape[0]):
        u, v = _to_lattice(sensors[t, 0], sensors[t, 1], frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        for what in (_EMPTY, _OCCUPIED):  # all empty evidence comes first, as in 1985
            for k in range(n_beams):
                z = float(ranges[t, k])
                kind = _kind_of(z, reading_filter)
                if kind == NOTHING or (what == _OCCUPIED and kind == NO_RETURN):
                    continue
                edges = _edges_of(fields, k, turn_u, turn_v)
                axis_u = turn_u * beams[k, 0] - turn_v * beams[k, 1]
                axis_v = turn_v * beams[k, 0] + turn_u * beams[k, 1]
                # A beam without return has no arc: all cells up to the max range are before it.
                nearer = half if kind == RETURN else 0.0
                z = z if kind == RETURN else range_max
                limit = min(z + nearer, range_max)
                share = 1.0
                if what == _OCCUPIED:
                    share, _ = _cone(_SUM, occupied, empty, observed, cols, z, nearer, limit, opening, u, v, axis_u,
                                     axis_v, edges, resolution, 1.0, box)  # fmt: skip
                    if share <= 0.0:
                        continue
                old_occupied, old_empty = float(occupied[watched]), float(empty[watched])
                _, changed = _cone(what, occupied, empty, observed, cols, z, nearer, limit, opening, u, v, axis_u,
                                   axis_v, edges, resolution, share, box)  # fmt: skip
                count += changed
                if watched >= 0 and (old_occupied != occupied[watched] or old_empty != empty[watched]):
                    contributions[noted, 0], contributions[noted, 1] = t * n_beams + k, what == _OCCUPIED
                    certainties[noted, 0], certainties[noted, 1] = occupied[watched], empty[watched]
                    noted += 1
    return count, noted
