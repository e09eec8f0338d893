"""The per-scan update: each cell of the perceptual field once, by the beam whose field it lies in.

Numba twin of :func:`mapper.textbook.update_per_scan`, in two passes. :func:`plan_runs` turns scans into runs of cells
along rows; :func:`draw_runs` adds the evidence to a band of the grid's rows, so that threads never meet.

What a scan frees is a star-shaped region, one sector for each beam. Its rows are found from their ends: a toggle, one
bit in a bitmap, stands wherever a row enters or leaves a sector, and a running exclusive or along the row fills it.
Where two neighbours both reach beyond a place on the edge between them their toggles cancel and are not even computed,
so the work goes with the region's outline and not with its area.
"""

from __future__ import annotations

import numpy as np
from numpy import uint64

from mapper.kernels.compiled import jit
from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.sectors import HITS, MARGIN, TOGGLES, USED, _mark, _outline, _ring
from mapper.kernels.types import (
    BoolArray,
    Float32Array,
    Float64Array,
    Frame,
    Int64Array,
    Rule,
    Sight,
    UInt32Array,
)

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

ROW, COL, STOP, KIND = range(4)  #: a run: its row, its first column, the column after its last, miss or hit
MISS, HIT = 0, 1
RUN_FIELDS = 4

_WORD = 0xFFFFFFFF


@jit
def _lowest_bit(word: int) -> int:
    """Return the place of the lowest bit set in a word of 32 that is not 0."""
    place = 0
    if not word & 0xFFFF:
        place, word = place + 16, word >> 16
    if not word & 0xFF:
        place, word = place + 8, word >> 8
    if not word & 0xF:
        place, word = place + 4, word >> 4
    if not word & 0x3:
        place, word = place + 2, word >> 2
    return place if word & 1 else place + 1


@jit
def _empty(
    bits: UInt32Array,
    here: Int64Array,
    cols: int,
    runs: Int64Array,
    count: int,
) -> int:
    """Turn the two bitmaps into runs, hits taken out of the misses, and clear them; return the number of runs."""
    for r in range(here[0], here[1]):
        miss_start, hit_start = -1, -1
        inside = 0  # all ones while the last word looked at ended within the region
        for q in range((bits.shape[2] + 31) // 32):
            words = int(bits[USED, r, q])
            bits[USED, r, q] = 0
            while words:
                w = (q << 5) + _lowest_bit(words)
                words &= words - 1
                value, hit = int(bits[TOGGLES, r, w]), int(bits[HITS, r, w])
                bits[TOGGLES, r, w], bits[HITS, r, w] = 0, 0
                value ^= value << 1
                value ^= value << 2
                value ^= value << 4
                value ^= value << 8
                value ^= value << 16
                value = (value ^ inside) & _WORD
                inside = _WORD if value >> 31 else 0
                value &= ~hit
                changes = (value ^ ((value << 1) | (1 if miss_start >= 0 else 0))) & _WORD
                while changes:
                    column = (w << 5) + _lowest_bit(changes)
                    changes &= changes - 1
                    if miss_start < 0:
                        miss_start = column
                    else:
                        runs[count, ROW], runs[count, COL], runs[count, STOP] = r, miss_start, column
                        runs[count, KIND] = MISS
                        count += 1
                        miss_start = -1
                changes = (hit ^ ((hit << 1) | (1 if hit_start >= 0 else 0))) & _WORD
                while changes:
                    column = (w << 5) + _lowest_bit(changes)
                    changes &= changes - 1
                    if hit_start < 0:
                        hit_start = column
                    else:
                        runs[count, ROW], runs[count, COL], runs[count, STOP] = r, hit_start, column
                        runs[count, KIND] = HIT
                        count += 1
                        hit_start = -1
        if miss_start >= 0:
            runs[count, ROW], runs[count, COL], runs[count, STOP], runs[count, KIND] = r, miss_start, cols, MISS
            count += 1
        if hit_start >= 0:
            runs[count, ROW], runs[count, COL], runs[count, STOP], runs[count, KIND] = r, hit_start, cols, HIT
            count += 1
    return count


@jit
def plan_runs(
    ranges: Float32Array,
    sensors: Float64Array,
    beams: Float64Array,
    fields: Float64Array,
    headings: Float64Array,
    frame: Frame,
    sight: Sight,
    cols: int,
    bits: UInt32Array,
    runs: Int64Array,
    counts: Int64Array,
) -> int:
    """Write the runs of as many scans as ``runs`` has room for; return the number of those scans.

    Arguments as those of :func:`mapper.kernels.lines.plan_lines`; besides, ``fields`` (n_beams, 4) float64 holds each
    beam's right and left edge (cosine, sine, cosine, sine), ``headings`` (n_scans, 2) the cosine and sine of the
    sensor's heading along the lattice. ``bits`` (3, rows, ⌈cols / 32⌉) uint32 is scratch, zero
    before and after. ``runs`` (n, 4) int64 and ``counts`` (n_scans,) int64, the number of runs of each scan, are
    written.
    """
    range_min, range_max, window, _, no_return_free = sight
    resolution, half = frame[4], 0.5 * window
    rows, n_beams = bits.shape[1], ranges.shape[1]
    here = np.empty(4, dtype=np.int64)
    edges, limits = np.empty((n_beams, 4)), np.zeros(n_beams)
    # Sectors are taken counter-clockwise, so that each one's left edge is its successor's right.
    clockwise = n_beams > 1 and fields[0, 0] == fields[1, 2] and fields[0, 1] == fields[1, 3]
    written = 0
    for t in range(ranges.shape[0]):
        here[0], here[1], here[2], here[3] = rows, 0, cols, 0
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        for j in range(n_beams):
            k = n_beams - 1 - j if clockwise else j
            z = float(ranges[t, k])
            limits[j] = 0.0
            if range_min <= z <= range_max:
                limits[j] = max(z - half, 0.0)
            elif z > range_max and no_return_free:
                limits[j] = range_max
            edges[j, 0] = turn_u * fields[k, 0] - turn_v * fields[k, 1]
            edges[j, 1] = turn_v * fields[k, 0] + turn_u * fields[k, 1]
            edges[j, 2] = turn_u * fields[k, 2] - turn_v * fields[k, 3]
            edges[j, 3] = turn_v * fields[k, 2] + turn_u * fields[k, 3]
            if edges[j, 0] == edges[j, 2] and edges[j, 1] == edges[j, 3]:  # it sees nothing
                limits[j] = 0.0
        bound = 0
        left_inner = 0.0
        for j in range(n_beams):
            right_u, right_v, left_u, left_v = edges[j, 0], edges[j, 1], edges[j, 2], edges[j, 3]
            right_inner, left_inner = left_inner, 0.0
            if j + 1 < n_beams and edges[j + 1, 0] == left_u and edges[j + 1, 1] == left_v:
                left_inner = max(min(limits[j], limits[j + 1]) / resolution - MARGIN, 0.0)
            if right_u == left_u and right_v == left_v:
                continue
            if limits[j] > 0.0:
                bound += _outline(bits, here, cols, u, v, right_u, right_v, left_u, left_v, limits[j], right_inner,
                                  left_inner, resolution)  # fmt: skip
            z = float(ranges[t, n_beams - 1 - j if clockwise else j])
            if window > 0.0 and range_min <= z <= range_max:
                bound += _ring(bits, here, cols, u, v, right_u, right_v, left_u, left_v, z - half,
                               min(z + half, range_max), resolution)  # fmt: skip
        for k in range(n_beams):
            z = float(ranges[t, k])
            if range_min <= z <= range_max:
                px, py = z * beams[k, 0], z * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
                r, c = int(_cell_of(ev)), int(_cell_of(eu))
                if 0 <= r < rows and 0 <= c < cols:
                    _mark(bits, r, c, c + 1, cols)
                    here[0], here[1] = min(here[0], r), max(here[1], r + 1)
                    here[2], here[3] = min(here[2], c), max(here[3], c + 1)
                    bound += 2
        room = runs.shape[0] - written
        if bound + 2 * (here[1] - here[0]) > room:
            for r in range(here[0], here[1]):
                bits[:, r] = 0
            return t
        before = written
        written = _empty(bits, here, cols, runs, written)
        counts[t] = written - before
    return len(ranges)


@jit
def draw_runs(log_odds: Float32Array, observed: BoolArray, cols: int, runs: Int64Array, rule: Rule, row_low: int,
              row_high: int, box: Int64Array) -> int:  # fmt: skip
    """Add what ``runs`` (n, 4) say to the rows [row_low, row_high) of the grid; return the number of cell updates.

    ``log_odds``, ``observed``, ``cols`` and ``box`` as in :func:`mapper.kernels.lines.draw_lines`.
    """
    miss, hit, low, high = rule
    # Kept in registers: two threads that wrote their boxes side by side would fight for one cache line.
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    count = 0
    for j in range(runs.shape[0]):
        r = runs[j, ROW]
        if not row_low <= r < row_high:
            continue
        first, stop = runs[j, COL], runs[j, STOP]
        increment = hit if runs[j, KIND] == HIT else miss
        for cell in range(uint64(r * cols + first), uint64(r * cols + stop)):
            log_odds[cell] = min(max(log_odds[cell] + increment, low), high)
            observed[cell] = True
        top, bottom = min(top, r), max(bottom, r + 1)
        left, right = min(left, first), max(right, stop)
        count += stop - first
    box[0], box[1], box[2], box[3] = top, bottom, left, right
    return count
