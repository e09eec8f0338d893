"""Conversion of log-odds to the int8 picture sent to clients, and lists of the changed tiles and cells."""

from __future__ import annotations

import numpy as np
from numpy import int8, int16, int32, int64, uint16, uint32

from mapper.core.array_types import BoolArray, Float32Array, Int8Array, Int16Array, UInt16Array, UInt32Array
from mapper.core.jit import jit

NEVER_OBSERVED = -128  #: value in the picture of a cell that no beam touched
ROW_SHIFT = 16  #: a listed cell is ``row << ROW_SHIFT | col``
COL_MASK = (1 << ROW_SHIFT) - 1


@jit
def _bounds_of_states(
    low: float, high: float, free_below: float, occupied_above: float
) -> tuple[int32, int32, int32, int32]:
    """Return the last step of a free cell, the first and last of an unknown one, and the first of an occupied one."""
    most_free, least_occupied = -128, 128
    for step in range(-127, 128):
        stands_for = low + (step + 127) / 254.0 * (high - low)
        if stands_for < free_below:
            most_free = step
        if stands_for > occupied_above:
            least_occupied = min(least_occupied, step)
    return int32(most_free), int32(most_free + 1), int32(least_occupied - 1), int32(least_occupied)


@jit
def _step_of(
    value: float,
    low: float,
    scale: float,
    free_below: float,
    occupied_above: float,
    bounds: tuple[int32, int32, int32, int32],
) -> int32:
    """Return the step, -127 to 127, for log-odds.

    Without branches and with 32-bit integers, so that it is compiled to vector instructions.
    """
    free, first, last, occupied = bounds
    scaled = (value - low) * scale
    scaled = max(scaled, 0.0)
    scaled = min(scaled, 254.0)
    q = int32(int32(scaled + 0.5) - int32(127))
    is_free, is_occupied = value < free_below, value > occupied_above
    least = int32(-127) if is_free else (occupied if is_occupied else first)
    most = free if is_free else (int32(127) if is_occupied else last)
    q = max(q, least)
    q = min(q, most)
    q = int32(-127) if q < -127 else q
    return int32(127) if q > 127 else q


@jit
def quantise(
    log_odds: Float32Array,
    observed: BoolArray,
    low: float,
    high: float,
    free_below: float,
    occupied_above: float,
    row0: int,
    row1: int,
    col0: int,
    col1: int,
    tile: int,
    picture: Int8Array,
    changed: BoolArray,
    cells: UInt32Array,
    listed: int,
) -> int:
    """Update the box [row0, row1) × [col0, col1) of ``picture``; return ``listed`` plus the number of changed cells.

    ``log_odds`` (rows, cols) float32, ``observed`` (rows, cols) bool. ``picture`` (rows, cols) int8 is written, and
    ``changed`` (⌈rows / tile⌉, ⌈cols / tile⌉) bool is set for each tile of ``tile`` × ``tile`` cells in which a value
    changed. Log-odds ``low`` … ``high`` map to −127 … 127, clamped at the ends; −128 is "never observed". Each value is
    the nearest one of the same state (free below and occupied above two log-odds), so the picture never shows a cell in
    a wrong state. Parts of the box outside the grid are ignored. Changed cells are written to ``cells`` (n,) uint32, as
    ``row << 16 | col``, from the entry ``listed`` on; those beyond its size are only counted.
    """
    rows, cols = log_odds.shape
    scale = 254.0 / (high - low)
    bounds = _bounds_of_states(low, high, free_below, occupied_above)
    count = listed
    quantised = np.empty(tile, dtype=int8)
    col_low, col_high = max(col0, 0), min(col1, cols)
    for r in range(max(row0, 0), min(row1, rows)):
        start = col_low
        while start < col_high:
            stop = min((start // tile + 1) * tile, col_high)
            values, seen, shown = log_odds[r, start:stop], observed[r, start:stop], picture[r, start:stop]
            differing = int64(0)
            for c in range(stop - start):
                q = _step_of(float(values[c]), low, scale, free_below, occupied_above, bounds)
                new = int8(q) if seen[c] else int8(NEVER_OBSERVED)
                differing += int64(shown[c] != new)
                quantised[c] = new
            if differing > 0:
                changed[r // tile, start // tile] = True
                if count + differing <= len(cells):
                    at = count
                    for c in range(stop - start):
                        if shown[c] != quantised[c]:
                            cells[at] = uint32((r << ROW_SHIFT) | (start + c))
                            at += 1
                for c in range(stop - start):
                    shown[c] = quantised[c]
                count += int(differing)
            start = stop
    return count


@jit
def quantise_cells(
    log_odds: Float32Array,
    observed: BoolArray,
    low: float,
    high: float,
    free_below: float,
    occupied_above: float,
    written: UInt32Array,
    tile: int,
    picture: Int8Array,
    changed: BoolArray,
    cells: UInt32Array,
    listed: int,
) -> int:
    """Like :func:`quantise`, for the cells ``written`` (m,) uint32: ``row · cols + col``, possibly repeated.

    The entry of ``cells`` after the listed ones may also be written.
    """
    cols = uint32(log_odds.shape[1])
    side = uint32(tile)
    scale = 254.0 / (high - low)
    bounds = _bounds_of_states(low, high, free_below, occupied_above)
    count = listed
    for i in range(len(written)):
        r, c = written[i] // cols, written[i] % cols
        q = _step_of(float(log_odds[r, c]), low, scale, free_below, occupied_above, bounds)
        new = int8(q) if observed[r, c] else int8(NEVER_OBSERVED)
        # Without a branch that depends on the picture, so that the reads of its cells from memory overlap.
        differs = picture[r, c] != new
        picture[r, c] = new
        changed[r // side, c // side] |= differs
        if count < len(cells):
            cells[count] = uint32((r << uint32(ROW_SHIFT)) | c)
        count += int(differs)
    return count


@jit
def sort_by_tile(
    picture: Int8Array,
    cells: UInt32Array,
    tile: int,
    tiles: Int16Array,
    places: UInt16Array,
    values: Int8Array,
) -> int:
    """Sort listed ``cells`` (n,) uint32, each ``row << 16 | col``, by tile; return the number k of tiles.

    ``picture`` (rows, cols) int8; a tile has ``tile`` × ``tile`` cells. Written to ``tiles`` (k, 3), which may be
    larger: for each tile, in row-major order, its column, row and number of cells. Written for each cell, in list order
    within its tile: to ``places`` (n,) ``row · tile + col`` within the tile, and to ``values`` (n,) its value in the
    picture. A counting sort (Knuth, The Art of Computer Programming, 5.2).
    """
    tile_cols = -(-picture.shape[1] // tile)
    tile_rows = -(-picture.shape[0] // tile)
    at = np.zeros(tile_rows * tile_cols, dtype=int32)
    for i in range(len(cells)):
        row, col = int64(cells[i] >> ROW_SHIFT), int64(cells[i] & COL_MASK)
        at[(row // tile) * tile_cols + col // tile] += 1
    count, first = 0, 0
    for t in range(len(at)):
        number = int(int64(at[t]))
        at[t] = first
        if number > 0:
            tiles[count, 0], tiles[count, 1] = int16(t % tile_cols), int16(t // tile_cols)
            tiles[count, 2] = int16(number)
            count += 1
            first += number
    for i in range(len(cells)):
        row, col = int64(cells[i] >> ROW_SHIFT), int64(cells[i] & COL_MASK)
        t = (row // tile) * tile_cols + col // tile
        places[at[t]] = uint16((row % tile) * tile + col % tile)
        values[at[t]] = picture[row, col]
        at[t] += 1
    return count
