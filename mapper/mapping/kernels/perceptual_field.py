"""Per-scan update: each cell of the perceptual field is updated once, by the beam whose field contains it.

Numba twin of :func:`mapper.mapping.textbook.update_per_scan`, in two passes. :func:`plan_fields` finds for each scan
the crossings of its field's border with the rows of the grid (:mod:`mapper.mapping.kernels.field_boundary`) and the
cells in which its beams end. :func:`draw_fields` marks them in a bitmask (:mod:`mapper.mapping.kernels.bitmask_fill`)
and adds it to a band of the grid's rows, scan by scan, so that threads with one band each write to different cells. The
work is proportional to the length of the regions' borders plus a 32nd of their areas.
"""

from __future__ import annotations

from math import floor

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array, UInt32Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.mapping.kernels.bitmask_fill import (
    FREE,
    HITS,
    PLANES,
    USED_BITS,
    WORD,
    WORD_BITS,
    Place,
    _note,
    _packed,
    _settle,
    _settle_narrow,
)
from mapper.mapping.kernels.field_boundary import (
    STRIDE,
    Crossings,
    Pieces,
    Ring,
    Sectors,
    _crossed,
    _list_arcs,
    _list_edges,
    _note_crossings,
    _place_sectors,
    _ring_of,
    _room_for_crossings,
    _room_for_pieces,
    _row_at,
    _traverse_arcs,
    _traverse_edges,
    _turned,
)
from mapper.mapping.kernels.sectors import _ring, _sector
from mapper.mapping.kernels.types import LogOddsUpdate, ReadingFilter, Scans

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)

#: The plan of each scan: starts (n_scans, 4) int64, the first toggles of its planes FREE, OUTER and HITS in the list of
#: all toggles, and their end; sure (n_scans,) bool, whether rounding decided nothing (if not, FREE and OUTER have no
#: toggles); views (n_scans, 4) int64, the rows and words [first, stop) of the grid that it observes.
Plan = tuple[Int64Array, BoolArray, Int64Array]

#: Buffers for a scan's edge and arc pieces (:mod:`mapper.mapping.kernels.field_boundary`) and their row crossings.
_Room = tuple[Pieces, Pieces, Crossings]


@jit
def plan_fields(
    scans: Scans, frame: Frame, reading_filter: ReadingFilter, cols: int, plan: Plan, work: Float64Array
) -> UInt32Array:
    """Plan the drawing of scans; return their toggles (n,), see :func:`mapper.mapping.kernels.bitmask_fill._packed`.

    ``scans`` and ``reading_filter``: see :mod:`mapper.mapping.kernels.types`. ``plan`` is written. The row-to-row
    differences of the drawing cost are added to ``work`` (rows + 1,) float64. The grid has fewer than MAX_SIDE rows and
    columns (:mod:`mapper.mapping.kernels.bitmask_fill`).
    """
    ranges, sensors, beams, fields, headings, _ = scans
    starts, sure, views = plan
    n = ranges.shape[1]
    rows, resolution = len(work) - 1, frame.resolution
    regions = (
        2 if reading_filter.window > 0.0 or reading_filter.growth > 0.0 else 1
    )  # with a hit window also the region up to its end
    ring = _ring_of(fields)
    across = np.ascontiguousarray(fields.T)
    edges, sides, corners = np.empty((4, n)), np.empty(n), np.empty((2, n), dtype=np.int64)
    radii, ends = np.empty((2, n)), np.empty(n, dtype=np.int64)
    room = (_room_for_pieces(2 * n), _room_for_pieces(2 * n), _room_for_crossings(8 * n))
    toggles = np.empty(8 * ranges.size, dtype=np.uint32)
    done = 0
    for t in range(ranges.shape[0]):
        u, v = _to_lattice(sensors[t, 0], sensors[t, 1], frame)
        farthest, n_ends = _read(ranges[t], sensors[t], beams, frame, reading_filter, rows, cols, radii, ends)
        starts[t, :] = done
        _see(views[t], u, v, farthest / resolution, rows, cols)
        low, high, left, right = views[t, 0], views[t, 1], WORD * views[t, 2], WORD * views[t, 3]
        if low == high:
            continue
        home, unsure = _row_at(v)
        sure[t] = not unsure
        for region in range(regions):
            sectors = (edges, sides, radii[region], corners)
            sure[t] &= _place_sectors(across, headings[t, 0], headings[t, 1], v, sectors)
            room, crossed, is_sure = _cross(sectors, ring, int(home), u, v, low, high, room, work)
            toggles = _with_room(toggles, done, crossed + n)
            sure[t] &= is_sure & _note_crossings(room[2], crossed, low, left, right - left, toggles, done)
            done += crossed
            starts[t, region + 1 :] = done
        if not sure[t]:
            done = starts[t, FREE]
            starts[t, :] = done
        toggles = _with_room(toggles, done, n_ends)
        for k in range(n_ends):
            toggles[done + k] = _packed((ends[k] >> 32) - low, (ends[k] & 0xFFFFFFFF) - left)
        done += n_ends
        starts[t, PLANES] = done
    return toggles[:done]


@jit
def _cross(
    sectors: Sectors, ring: Ring, home: int, u: float, v: float, low: int, high: int, room: _Room, work: Float64Array
) -> tuple[_Room, int, bool]:
    """Find the crossings of the border of a scan's field with the rows [low, high).

    Return the buffers, which may have been enlarged, the number of crossings, and whether all roots are certain.
    """
    edges, arcs, crossings = room
    n_edges = _list_edges(sectors, ring, home, u, v, low, high, edges)
    n_arcs, arcs_sure = _list_arcs(sectors, v, low, high, arcs)
    n = _crossed(edges, n_edges, work) + _crossed(arcs, n_arcs, work)
    if n + STRIDE > len(crossings[0]):
        crossings = _room_for_crossings(2 * n)
    done = _traverse_edges(edges, n_edges, crossings, 0)
    done, roots_sure = _traverse_arcs(arcs, n_arcs, u, v, crossings, done)
    return (edges, arcs, crossings), done, arcs_sure & roots_sure


@jit
def _with_room(toggles: UInt32Array, done: int, room: int) -> UInt32Array:
    """Return a list with room for ``room`` more toggles after the first ``done``."""
    if done + room <= len(toggles):
        return toggles
    longer = np.empty(2 * (done + room), dtype=np.uint32)
    longer[:done] = toggles[:done]
    return longer


@jit
def _read(
    ranges: Float32Array, sensor: Float64Array, beams: Float64Array, frame: Frame, reading_filter: ReadingFilter, rows:
    int, cols: int, radii: Float64Array, ends: Int64Array,
) -> tuple[float, int]:  # fmt: skip
    """Read a scan: the radii (2, n_beams), in cells, of its free space and of its hit windows.

    ``ends`` receives the cells of the grid in which beams end, row << 32 | column. Return the scan's reach in metres,
    −1 for none, and the number of ends.
    """
    range_min, range_max, window, growth, no_return_free = reading_filter
    x, y, cos, sin = sensor[0], sensor[1], sensor[2], sensor[3]
    resolution = frame.resolution
    farthest, n_ends = -1.0, 0
    for i in range(len(ranges)):
        k = np.uint64(i)
        z = float(ranges[k])
        free, outer = 0.0, 0.0
        if range_min <= z <= range_max:
            half = 0.5 * (window + growth * z)
            free, outer = max(z - half, 0.0), min(z + half, range_max)
            farthest = max(farthest, outer, z)
            px, py = z * beams[k, 0], z * beams[k, 1]
            eu, ev = _to_lattice(x + cos * px - sin * py, y + sin * px + cos * py, frame)
            r, c = int(_cell_of(ev)), int(_cell_of(eu))
            if 0 <= r < rows and 0 <= c < cols:
                ends[np.uint64(n_ends)] = (r << 32) | c
                n_ends += 1
        elif z > range_max and no_return_free:
            free, outer = range_max, range_max
            farthest = max(farthest, range_max)
        radii[0, k], radii[1, k] = free / resolution, outer / resolution
    return farthest, n_ends


@jit
def _see(view: Int64Array, u: float, v: float, reach: float, rows: int, cols: int) -> None:
    """Write the rows and words [first, stop) of the grid within ``reach`` cells of the sensor; less than 0: none."""
    words = (cols + WORD - 1) >> WORD_BITS
    view[0], view[1] = max(floor(v - reach - 2.0), 0), min(floor(v + reach + 2.0) + 1, rows)
    view[2], view[3] = (
        max(floor(u - reach - 2.0) >> WORD_BITS, 0),
        min((floor(u + reach + 2.0) >> WORD_BITS) + 1, words),
    )
    if reach < 0.0 or view[0] >= view[1] or view[2] >= view[3]:
        view[:] = 0


@jit
def draw_fields(
    log_odds: Float32Array,
    seen: Int64Array,
    seen_place: Place,
    scans: Scans,
    frame: Frame,
    reading_filter: ReadingFilter,
    plan: Plan,
    toggles: UInt32Array,
    planes: Int64Array,
    used: Int64Array,
    log_odds_update: LogOddsUpdate,
    row_low: int,
    row_high: int,
) -> int:
    """Add the evidence of scans to the rows [row_low, row_high) of the grid; return the number of updates.

    ``log_odds`` (rows, cols) is the grid. In ``seen`` (rows, words) int64, which starts at ``seen_place`` in it, the
    bits of touched cells are set. ``planes`` (3, rows, words + 1) and ``used`` (rows,) are a bitmask, 0 before and
    after, with as many rows and words as the largest view of ``plan`` within these rows. The other arguments are those
    of :func:`plan_fields` and its results.
    """
    ranges, sensors, fields, headings = scans.ranges, scans.sensors, scans.fields, scans.headings
    starts, sure, views = plan
    cells, cols = log_odds.reshape(-1), log_odds.shape[1]
    windows = reading_filter.window > 0.0 or reading_filter.growth > 0.0
    shift = 0
    while planes.shape[2] > USED_BITS << shift:
        shift += 1
    count = 0
    for t in range(ranges.shape[0]):
        low, high = max(views[t, 0], row_low), min(views[t, 1], row_high)
        if low >= high:
            continue
        own = used[: high - low]
        place = (low, views[t, 2], views[t, 3] - views[t, 2], shift)
        first_row = low - views[t, 0]
        for plane in range(PLANES):
            a, b = starts[t, plane], starts[t, plane + 1]
            _note(planes[plane], own, shift, plane == HITS, toggles[a:b], first_row)
        if not sure[t]:
            u, v = _to_lattice(sensors[t, 0], sensors[t, 1], frame)
            turn_u, turn_v = headings[t, 0], headings[t, 1]
            _note_exactly(planes, own, place, u, v, turn_u, turn_v, ranges[t], fields, reading_filter, frame.resolution)
        bordered = windows and sure[t]
        full = (cells, cols, seen, seen_place, planes, own, place, bordered, log_odds_update)
        count += _settle(*full) if cols >= WORD else _settle_narrow(*full)
    return count


@jit
def _note_exactly(
    planes: Int64Array, used: Int64Array, place: Place, u: float, v: float, turn_u: float, turn_v: float,
    ranges: Float32Array, fields: Float64Array, reading_filter: ReadingFilter, resolution: float,
) -> None:  # fmt: skip
    """Write the toggles of one scan, with the exact test wherever rounding may decide."""
    range_min, range_max, window, growth, no_return_free = reading_filter
    for k in range(len(ranges)):
        z = float(ranges[k])
        right_u, right_v = _turned(fields[k, 0], fields[k, 1], turn_u, turn_v)
        left_u, left_v = _turned(fields[k, 2], fields[k, 3], turn_u, turn_v)
        if right_u == left_u and right_v == left_v:  # the field is empty
            continue
        if range_min <= z <= range_max:
            half = 0.5 * (window + growth * z)
            if z > half:
                _sector(planes, used, place, u, v, right_u, right_v, left_u, left_v, z - half, resolution)
            if half > 0.0:
                farthest = min(z + half, range_max)
                _ring(planes, used, place, u, v, right_u, right_v, left_u, left_v, z - half, farthest, resolution)
        elif z > range_max and no_return_free:
            _sector(planes, used, place, u, v, right_u, right_v, left_u, left_v, range_max, resolution)
