"""The per-scan update: each cell of the perceptual field once, by the beam whose field it lies in.

Numba twin of :func:`mapper.textbook.update_per_scan`, in three passes. :func:`plan_fields` finds the cells that are hit
and the part of the grid that is concerned; :func:`note_fields` writes what some scans say to a sheet, one sheet for
each thread; :func:`settle_fields` adds it to a band of the grid's rows, so that threads never meet.

What a scan frees is a star-shaped region, one sector for each beam, and a row of the grid enters and leaves it a few
times. Each such place is a *toggle*: one bit for the scan, in a sheet with a word for each cell, so that a sheet takes
as many scans as a word has bits. A running exclusive or along a row then says for each cell which of these scans see it
as free; the number of ones, how often its miss is to be added; and where it was hit, the order of the bits, what came
before and what after. Between toggles all cells of a row get the same, many at a time. Where two neighbours both reach
beyond a place on the edge between them their toggles cancel and are not even computed, so the work goes with the
regions' outlines and not with their areas.
"""

from __future__ import annotations

from math import ceil, floor

import numpy as np

from mapper.kernels.compiled import jit
from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.sectors import BLOCK, BLOCK_BITS, HITS, TOGGLES, USED, Place, _margin, _mark, _outline, _ring
from mapper.kernels.types import BoolArray, Float32Array, Float64Array, Frame, Int32Array, Int64Array, Rule, Sight

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

SCANS = 62  #: that a sheet takes: the bits of a word that stay clear of its sign


@jit
def plan_fields(ranges: Float32Array, sensors: Float64Array, beams: Float64Array, frame: Frame, sight: Sight, cols: int,
                ends: Int32Array, work: Float64Array, box: Int64Array) -> None:  # fmt: skip
    """Write the cells in which beams end.

    Arguments as those of :func:`mapper.kernels.lines.plan_lines`. ``ends`` (n_scans, n_beams, 2) int32 (row, col) is
    written, −1 where a beam ends in no cell of the grid; to ``work`` (rows,) float64 the number of ends in each row is
    added; ``box`` (4,) int64 (row0, row1, col0, col1) is widened to hold all that is seen, also outside the grid.
    """
    range_min, range_max, window, growth, no_return_free = sight
    resolution, rows = frame[4], len(work)
    top, bottom, left, right = box[0], box[1], box[2], box[3]
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        farthest = -1.0
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            ends[t, k, 0] = -1
            if range_min <= z <= range_max:
                farthest = max(farthest, z)
                px, py = z * beams[k, 0], z * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
                r, c = int(_cell_of(ev)), int(_cell_of(eu))
                if 0 <= r < rows and 0 <= c < cols:
                    ends[t, k, 0], ends[t, k, 1] = r, c
                    work[r] += 1.0
            elif z > range_max and no_return_free:
                farthest = max(farthest, range_max)
        if farthest >= 0.0:
            reach = min(farthest + 0.5 * (window + growth * farthest), range_max) / resolution + 2.0
            top, bottom = min(top, floor(v - reach)), max(bottom, ceil(v + reach))
            left, right = min(left, floor(u - reach)), max(right, ceil(u + reach))
    box[0], box[1], box[2], box[3] = top, bottom, left, right


@jit
def note_fields(
    sheet: Int64Array, place: Place, ranges: Float32Array, sensors: Float64Array, fields: Float64Array,
    headings: Float64Array, frame: Frame, sight: Sight, ends: Int32Array,
) -> None:  # fmt: skip
    """Write the toggles and hits of up to SCANS scans to a sheet.

    ``fields`` (n_beams, 4) float64 is each beam's right and left edge (cosine, sine, cosine, sine), ``headings``
    (n_scans, 2) the cosine and sine of the sensor's heading along the lattice; ``ends`` comes from :func:`plan_fields`.
    ``sheet`` (see :mod:`mapper.kernels.sectors`), all 0 before, begins at ``place`` and holds all that the scans
    see, as far as it lies in the grid.
    """
    edges, limits = np.empty((ranges.shape[1], 4)), np.zeros(ranges.shape[1])
    for t in range(ranges.shape[0]):
        bit = 1 << t
        _note(sheet, place, bit, ranges[t], sensors[t], fields, headings[t], frame, sight, edges, limits)
        for k in range(ranges.shape[1]):
            if ends[t, k, 0] >= 0:
                _mark(sheet, place, bit, int(ends[t, k, 0]), int(ends[t, k, 1]))


@jit
def settle_fields(log_odds: Float32Array, observed: BoolArray, sheet: Int64Array, place: Place, rule: Rule,
                  row_low: int, row_high: int, box: Int64Array) -> int:  # fmt: skip
    """Add what a sheet says to the rows [row_low, row_high) of the grid and clear it; return the number of updates.

    ``log_odds`` and ``observed`` (rows, cols) are the grid. ``box`` (4,) int64 (row0, row1, col0, col1), half-open, is
    widened to hold what was touched.
    """
    count = 0
    for r in range(max(row_low, place[0]), min(row_high, place[0] + sheet.shape[1])):
        count += _settle_row(log_odds[r], observed[r], sheet[:, r - place[0]], place[1], r, rule, box)
    return count


@jit
def _note(
    sheet: Int64Array, place: Place, bit: int, ranges: Float32Array, sensor: Float64Array, fields: Float64Array,
    heading: Float64Array, frame: Frame, sight: Sight, edges: Float64Array, limits: Float64Array,
) -> None:  # fmt: skip
    """Write one scan's toggles, and its hits within a window; ``edges`` (n, 4) and ``limits`` (n,) are scratch."""
    range_min, range_max, window, growth, no_return_free = sight
    resolution, n_beams = frame[4], len(ranges)
    u, v = _to_lattice(sensor[0], sensor[1], *frame)
    turn_u, turn_v = heading[0], heading[1]
    # Sectors are taken counter-clockwise, so that each one's left edge is its successor's right.
    clockwise = n_beams > 1 and fields[0, 0] == fields[1, 2] and fields[0, 1] == fields[1, 3]
    for j in range(n_beams):
        k = n_beams - 1 - j if clockwise else j
        z = float(ranges[k])
        limit = 0.0
        if range_min <= z <= range_max:
            limit = max(z - 0.5 * (window + growth * z), 0.0)
        elif z > range_max and no_return_free:
            limit = range_max
        right_u, right_v = turn_u * fields[k, 0] - turn_v * fields[k, 1], turn_v * fields[k, 0] + turn_u * fields[k, 1]
        left_u, left_v = turn_u * fields[k, 2] - turn_v * fields[k, 3], turn_v * fields[k, 2] + turn_u * fields[k, 3]
        if right_u == left_u and right_v == left_v:  # it sees nothing
            limit = 0.0
        edges[j, 0], edges[j, 1], edges[j, 2], edges[j, 3] = right_u, right_v, left_u, left_v
        limits[j] = limit
    left_inner = 0.0
    for j in range(n_beams):
        right_u, right_v, left_u, left_v = edges[j, 0], edges[j, 1], edges[j, 2], edges[j, 3]
        right_inner, left_inner = left_inner, 0.0
        if j + 1 < n_beams and edges[j + 1, 0] == left_u and edges[j + 1, 1] == left_v:
            shared = min(limits[j], limits[j + 1]) / resolution
            left_inner = max(shared - _margin(left_u, left_v, shared), 0.0)
        if limits[j] > 0.0:
            _outline(sheet, place, bit, u, v, right_u, right_v, left_u, left_v, limits[j], right_inner, left_inner,
                    resolution)  # fmt: skip
        if window > 0.0 and (right_u != left_u or right_v != left_v):
            z = float(ranges[n_beams - 1 - j if clockwise else j])
            half = 0.5 * (window + growth * z)
            if range_min <= z <= range_max:
                _ring(sheet, place, bit, u, v, right_u, right_v, left_u, left_v, z - half, min(z + half, range_max),
                     resolution)  # fmt: skip


@jit
def _ones(word: int) -> int:
    """Return how many bits of a word are set, in the form that compilers know as one instruction."""
    count = 0
    while word:
        word &= word - 1
        count += 1
    return count


@jit
def _lowest_bit(word: int) -> int:
    """Return the place of the lowest bit set in a word that is not 0."""
    return _ones((word & -word) - 1)


@jit
def _miss_run(cells: Float32Array, observed: BoolArray, times: int, rule: Rule) -> None:
    """Add a miss ``times`` times to some cells of a row, in the form that compilers turn into vector instructions."""
    miss, _, low, high = rule
    for _ in range(times):
        changed = np.int32(0)
        for c in range(len(cells)):
            before = cells[c]
            value = min(max(before + miss, low), high)
            changed |= np.int32(value != before)
            cells[c] = value
        if changed == 0:  # nor will they change in the next turn
            break
    for c in range(len(observed)):
        observed[c] = True


@jit
def _missed(value: np.float32, times: int, miss: np.float32, low: np.float32, high: np.float32) -> np.float32:
    """Return a cell's value after so many misses."""
    for _ in range(times):
        before = value
        value = min(max(value + miss, low), high)
        if value == before:
            break
    return value


@jit
def _settle_row(
    cells: Float32Array, observed: BoolArray, sheet: Int64Array, col0: int, row: int, rule: Rule, box: Int64Array
) -> int:  # fmt: skip
    """Add what a row of the sheet (3, cols) says to a row of the grid and clear it; return the number of updates."""
    miss, hit, low, high = rule
    width = min(sheet.shape[1], len(cells) - col0)
    left, right = len(cells), 0
    count = 0
    seeing = 0  # a bit for each scan that sees the present cell as free
    done = 0  # columns of the sheet
    for q in range(-(-sheet.shape[1] // (32 * BLOCK))):
        blocks = sheet[USED, q]
        sheet[USED, q] = 0
        while blocks:
            first = ((q << 5) + _lowest_bit(blocks)) << BLOCK_BITS
            blocks &= blocks - 1
            if seeing and done < first:
                times = _ones(seeing)
                _miss_run(cells[col0 + done : col0 + first], observed[col0 + done : col0 + first], times, rule)
                left, right = min(left, col0 + done), max(right, col0 + first)
                count += times * (first - done)
            done = min(first + BLOCK, width)
            for c in range(first, done):
                seeing ^= sheet[TOGGLES, c]
                here = sheet[HITS, c]
                sheet[TOGGLES, c], sheet[HITS, c] = 0, 0
                misses = seeing & ~here
                if misses | here == 0:
                    continue
                left, right = min(left, col0 + c), max(right, col0 + c + 1)
                value = cells[col0 + c]
                while here:
                    now = here & -here
                    earlier = misses & (now - 1)
                    times = _ones(earlier)
                    count += times + 1
                    value = _missed(value, times, miss, low, high)
                    value = min(max(value + hit, low), high)
                    misses ^= earlier
                    here ^= now
                times = _ones(misses)
                count += times
                cells[col0 + c] = _missed(value, times, miss, low, high)
                observed[col0 + c] = True
    if seeing and done < width:
        times = _ones(seeing)
        _miss_run(cells[col0 + done : col0 + width], observed[col0 + done : col0 + width], times, rule)
        left, right = min(left, col0 + done), max(right, col0 + width)
        count += times * (width - done)
    if left < right:
        box[0], box[1] = min(box[0], row), max(box[1], row + 1)
        box[2], box[3] = min(box[2], left), max(box[3], right)
    return count
