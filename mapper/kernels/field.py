"""The per-scan update: each cell of the perceptual field once, by the beam whose field it lies in.

Numba twin of :func:`mapper.textbook.update_per_scan`. Each beam's field is a sector; a row of cells meets it in one
interval, so only that interval's cells are looked at.
"""

from __future__ import annotations

from math import ceil, floor, sqrt

import numpy as np
from numba import njit
from numpy import uint8

from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.types import BoolArray, Float32Array, Float64Array, Frame, Int64Array, Rule, Sight, UInt8Array

_to_lattice = njit(to_lattice, nogil=True, cache=True)
_cell_of = njit(cell_of, nogil=True, cache=True)

MISS, HIT = 1, 2


@njit(nogil=True, cache=True)
def _side_of(edge_u: float, edge_v: float, d_v: float, low: float, high: float, left: bool) -> tuple[float, float]:
    """Narrow the columns' offsets [low, high] at row offset ``d_v`` to one side of an edge, a hair too wide."""
    if edge_v == 0.0:
        return low, high
    at = edge_u * d_v / edge_v
    if (edge_v > 0.0) == left:
        return low, min(high, at + 0.5)
    return max(low, at - 0.5), high


@njit(nogil=True, cache=True)
def _paint_sector(
    paint: UInt8Array,
    box: Int64Array,
    u: float,
    v: float,
    right_u: float,
    right_v: float,
    left_u: float,
    left_v: float,
    free_below: float,
    hit_from: float,
    hit_to: float,
    resolution: float,
) -> None:
    """Paint the cells of one beam's field: miss where s < ``free_below``, hit where ``hit_from`` ≤ s ≤ ``hit_to``.

    Distances in metres, the edges unit vectors along the lattice.
    """
    rows, cols = paint.shape
    radius = max(free_below, hit_to) / resolution
    # The sector lies between its apex and its arc, which bulges out of the chord by less than (1 − cos π/4) radius.
    v_low, v_high = radius * min(0.0, right_v, left_v), radius * max(0.0, right_v, left_v)
    if left_u * right_u <= 0.0:
        v_low, v_high = (
            min(v_low, radius * min(left_v, right_v) * 1.5),
            max(v_high, radius * max(left_v, right_v) * 1.5),
        )
        v_low, v_high = max(v_low, -radius), min(v_high, radius)
    for r in range(max(floor(v + v_low) - 1, 0), min(ceil(v + v_high) + 1, rows)):
        d_v = r + 0.5 - v
        if abs(d_v) > radius:
            continue
        chord = sqrt(radius * radius - d_v * d_v) + 1.0
        low, high = _side_of(right_u, right_v, d_v, -chord, chord, True)
        low, high = _side_of(left_u, left_v, d_v, low, high, False)
        for c in range(max(floor(u + low - 0.5), 0), min(ceil(u + high - 0.5) + 1, cols)):
            d_u = c + 0.5 - u
            if right_u * d_v - right_v * d_u < 0.0 or left_u * d_v - left_v * d_u >= 0.0:
                continue
            s = sqrt(d_u * d_u + d_v * d_v) * resolution
            if s < free_below:
                paint[r, c] = MISS
            elif hit_from <= s <= hit_to:
                paint[r, c] = HIT
            else:
                continue
            box[0], box[1] = min(box[0], r), max(box[1], r + 1)
            box[2], box[3] = min(box[2], c), max(box[3], c + 1)


@njit(nogil=True, cache=True)
def _apply(
    log_odds: Float32Array,
    observed: BoolArray,
    paint: UInt8Array,
    box: Int64Array,
    miss: np.float32,
    hit: np.float32,
    low: np.float32,
    high: np.float32,
) -> int:
    """Add to each painted cell of the box what its paint says, and clean the paint; return their number."""
    count = 0
    for r in range(box[0], box[1]):
        for c in range(box[2], box[3]):
            colour = paint[r, c]
            if colour == 0:
                continue
            value = log_odds[r, c] + (hit if colour == HIT else miss)
            log_odds[r, c] = min(max(value, low), high)
            observed[r, c] = True
            paint[r, c] = uint8(0)
            count += 1
    return count


@njit(nogil=True, cache=True)
def add_fields(
    log_odds: Float32Array,
    observed: BoolArray,
    box: Int64Array,
    paint: UInt8Array,
    ranges: Float32Array,
    sensors: Float64Array,
    beams: Float64Array,
    fields: Float64Array,
    headings: Float64Array,
    frame: Frame,
    sight: Sight,
    rule: Rule,
) -> int:
    """Add every scan to the grid, each cell at most once a scan; return the number of cell updates.

    As :func:`mapper.kernels.rays.add_rays`; besides, ``paint`` (rows, cols) uint8 is scratch, zero before and after;
    ``fields`` (n_beams, 4) float64 holds each beam's right and left edge (cosine, sine, cosine, sine) and
    ``headings`` (n_scans, 2) the cosine and sine of the sensor's heading along the lattice.
    """
    range_min, range_max, window, no_return_free = sight
    miss, hit, low, high = rule
    resolution = frame[4]
    rows, cols = log_odds.shape
    count = 0
    half = 0.5 * window
    here = box.copy()
    for t in range(ranges.shape[0]):
        here[0], here[1], here[2], here[3] = rows, 0, cols, 0
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            free_below, hit_from, hit_to = z - half, z - half, min(z + half, range_max)
            if z > range_max:
                if not no_return_free:
                    continue
                free_below, hit_from, hit_to = range_max, 1.0, 0.0
            elif not z >= range_min:
                continue
            right_u = turn_u * fields[k, 0] - turn_v * fields[k, 1]
            right_v = turn_v * fields[k, 0] + turn_u * fields[k, 1]
            left_u = turn_u * fields[k, 2] - turn_v * fields[k, 3]
            left_v = turn_v * fields[k, 2] + turn_u * fields[k, 3]
            _paint_sector(paint, here, u, v, right_u, right_v, left_u, left_v, free_below, hit_from, hit_to, resolution)
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            if not range_min <= z <= range_max:
                continue
            px, py = z * beams[k, 0], z * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
            r, c = int(_cell_of(ev)), int(_cell_of(eu))
            if 0 <= r < rows and 0 <= c < cols:
                paint[r, c] = HIT
                here[0], here[1] = min(here[0], r), max(here[1], r + 1)
                here[2], here[3] = min(here[2], c), max(here[3], c + 1)
        if here[1] > here[0]:
            count += _apply(log_odds, observed, paint, here, miss, hit, low, high)
            box[0], box[1] = min(box[0], here[0]), max(box[1], here[1])
            box[2], box[3] = min(box[2], here[2]), max(box[3], here[3])
    return count
