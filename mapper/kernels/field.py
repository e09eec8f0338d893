"""The per-scan update: each cell of the perceptual field once, by the beam whose field it lies in.

Numba twin of :func:`mapper.textbook.update_per_scan`, in two passes. :func:`plan_fields` finds for each reading the
corners of its field and the cell in which it ends; :func:`draw_fields` notes what a scan says on a sheet of bits (see
:mod:`mapper.kernels.sheet`) and adds that to a band of the grid's rows, scan after scan, so that threads that have a
band each never meet. The work goes with the regions' borders and with their areas by 32 cells at a time.
"""

from __future__ import annotations

from math import floor

from mapper.kernels.border import HAIR, _outline, _ring_of, _row_at, _side, _turned
from mapper.kernels.compiled import jit
from mapper.kernels.lattice import cell_of, to_lattice
from mapper.kernels.sectors import _ring, _sector
from mapper.kernels.sheet import FREE, USED_BITS, WORD, WORD_BITS, Place, _mark, _settle, _settle_narrow, _wipe
from mapper.kernels.types import (
    BoolArray,
    Float32Array,
    Float64Array,
    Frame,
    Int8Array,
    Int32Array,
    Int64Array,
    Rule,
    Sight,
)

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

#: What is planned for each reading: radii (n_scans, regions, n_beams) float64 of its field's arcs, cells; corners
#: (n_scans, regions, n_beams, 2) int32, the rows of their right and left ends; sides (n_scans, n_beams) int8, on which
#: side of the sensor they lie; ends (n_scans, n_beams, 2) int32, the row and column in which the beam ends, row −1
#: where that is no cell of the grid. The regions are FREE and, where there are hit windows, OUTER. For each scan: sure
#: (n_scans,) bool, whether every corner keeps clear of every row's middle; views (n_scans, 4) int64, the rows and
#: words [first, stop) that it sees, in the grid or not.
Plan = tuple[Float64Array, Int32Array, Int8Array, Int32Array, BoolArray, Int64Array]


@jit
def plan_fields(
    ranges: Float32Array, sensors: Float64Array, beams: Float64Array, fields: Float64Array, headings: Float64Array,
    frame: Frame, sight: Sight, cols: int, plan: Plan, work: Float64Array,
) -> None:  # fmt: skip
    """Plan what scans will draw.

    ``ranges``, ``sensors``, ``beams``, ``frame`` and ``sight`` are as :func:`mapper.kernels.lines.plan_lines` takes
    them. ``fields`` (n_beams, 4) float64 is each beam's right and left edge (cosine, sine, cosine, sine), ``headings``
    (n_scans, 2) the cosine and sine of the sensor's heading along the lattice. ``plan`` is written; to ``work`` (rows +
    1,) float64, a difference along the rows, is added what each costs.
    """
    range_min, range_max, window, growth, no_return_free = sight
    radii, corners, sides, ends, sure, views = plan
    resolution, rows = frame[4], len(work) - 1
    for t in range(ranges.shape[0]):
        x, y, cos, sin = sensors[t, 0], sensors[t, 1], sensors[t, 2], sensors[t, 3]
        u, v = _to_lattice(x, y, *frame)
        home, clear = _row_at(v)
        farthest = -1.0
        for k in range(ranges.shape[1]):
            z = float(ranges[t, k])
            ends[t, k, 0] = -1
            free, outer = 0.0, 0.0
            if range_min <= z <= range_max:
                half = 0.5 * (window + growth * z)
                free, outer = max(z - half, 0.0), min(z + half, range_max)
                farthest = max(farthest, outer, z)
                px, py = z * beams[k, 0], z * beams[k, 1]
                eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, *frame)
                r, c = int(_cell_of(ev)), int(_cell_of(eu))
                if 0 <= r < rows and 0 <= c < cols:
                    ends[t, k, 0], ends[t, k, 1] = r, c
                    work[min(r, max(home, 0))] += 1.0
                    work[max(r, min(home, rows - 1)) + 1] -= 1.0
            elif z > range_max and no_return_free:
                free, outer = range_max, range_max
                farthest = max(farthest, range_max)
            right_u, right_v = _turned(fields[k, 0], fields[k, 1], headings[t, 0], headings[t, 1])
            left_u, left_v = _turned(fields[k, 2], fields[k, 3], headings[t, 0], headings[t, 1])
            if right_u == left_u and right_v == left_v:  # it sees nothing
                free, outer = 0.0, 0.0
            sides[t, k] = _side(right_u, left_u)
            for region in range(radii.shape[1]):
                radius = (free if region == FREE else outer) / resolution
                radii[t, region, k] = radius
                right_row, right_clear = _row_at(v + radius * right_v)
                left_row, left_clear = _row_at(v + radius * left_v)
                corners[t, region, k, 0], corners[t, region, k, 1] = right_row, left_row
                clear = min(clear, right_clear, left_clear)
        sure[t] = clear > HAIR
        if farthest >= 0.0:
            reach = farthest / resolution + 2.0
            views[t, 0], views[t, 1] = floor(v - reach), floor(v + reach) + 1
            views[t, 2], views[t, 3] = floor(u - reach) >> WORD_BITS, (floor(u + reach) >> WORD_BITS) + 1
        else:
            views[t, :] = 0


@jit
def draw_fields(
    log_odds: Float32Array, seen: Int64Array, seen_place: Place, ranges: Float32Array, sensors: Float64Array,
    fields: Float64Array, headings: Float64Array, frame: Frame, sight: Sight, plan: Plan, planes: Int64Array,
    used: Int64Array, rule: Rule, row_low: int, row_high: int,
) -> int:  # fmt: skip
    """Add what scans say to the rows [row_low, row_high) of the grid; return the number of updates.

    ``log_odds`` (rows, cols) is the grid; in ``seen`` (rows, words) int64, which lies at ``seen_place`` in it, the bits
    of the cells touched are set. ``planes`` (3, rows, words) and ``used`` (rows,), a sheet, all 0 before and after,
    have as many rows and words as any of the plan's views has within these rows. The other arguments are those of
    :func:`plan_fields`.
    """
    radii, corners, sides, ends, sure, views = plan
    cells, cols = log_odds.reshape(-1), log_odds.shape[1]
    windows = radii.shape[1] > 1
    ring = _ring_of(fields)
    shift = 0
    while planes.shape[2] > USED_BITS << shift:
        shift += 1
    count = 0
    for t in range(ranges.shape[0]):
        low, high = max(views[t, 0], row_low), min(views[t, 1], row_high)
        if low >= high:
            continue
        u, v = _to_lattice(sensors[t, 0], sensors[t, 1], *frame)
        turn_u, turn_v = headings[t, 0], headings[t, 1]
        own = used[: high - low]
        place = (low, views[t, 2], shift)
        clear = 1.0 if sure[t] else 0.0
        if sure[t]:
            post = (u, v, low, high)
            for region in range(radii.shape[1]):
                near = _outline(
                    planes, own, place, region, post, fields, turn_u, turn_v, ring, radii[t, region],
                    corners[t, region], sides[t],
                )  # fmt: skip
                clear = min(clear, near)
        if clear < HAIR:
            _wipe(planes, own)
            _note_exactly(planes, own, place, u, v, turn_u, turn_v, ranges[t], fields, sight, frame[4])
        for k in range(ranges.shape[1]):
            if low <= ends[t, k, 0] < high:
                _mark(planes, own, place, int(ends[t, k, 0]), int(ends[t, k, 1]))
        full = (cells, cols, seen, seen_place, planes, own, place, windows and clear >= HAIR, rule)
        count += _settle(*full) if cols >= WORD else _settle_narrow(*full)
    return count


@jit
def _note_exactly(
    planes: Int64Array, used: Int64Array, place: Place, u: float, v: float, turn_u: float, turn_v: float,
    ranges: Float32Array, fields: Float64Array, sight: Sight, resolution: float,
) -> None:  # fmt: skip
    """Note what one scan says, with the exact test wherever rounding may decide."""
    range_min, range_max, window, growth, no_return_free = sight
    for k in range(len(ranges)):
        z = float(ranges[k])
        right_u, right_v = _turned(fields[k, 0], fields[k, 1], turn_u, turn_v)
        left_u, left_v = _turned(fields[k, 2], fields[k, 3], turn_u, turn_v)
        if right_u == left_u and right_v == left_v:  # it sees nothing
            continue
        if range_min <= z <= range_max:
            half = 0.5 * (window + growth * z)
            if z > half:
                _sector(planes, used, place, u, v, right_u, right_v, left_u, left_v, z - half, resolution)
            if window > 0.0:
                farthest = min(z + half, range_max)
                _ring(planes, used, place, u, v, right_u, right_v, left_u, left_v, z - half, farthest, resolution)
        elif z > range_max and no_return_free:
            _sector(planes, used, place, u, v, right_u, right_v, left_u, left_v, range_max, resolution)
