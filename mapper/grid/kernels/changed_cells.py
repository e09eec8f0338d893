"""Changed cells of a picture, sorted by tile."""

from __future__ import annotations

import numpy as np
from numpy import int16, int32, int64, uint16

from mapper.core.array_types import Int8Array, Int16Array, UInt16Array, UInt32Array
from mapper.core.jit import jit

ROW_SHIFT = 16  #: a listed cell is ``row << ROW_SHIFT | col``
COL_MASK = (1 << ROW_SHIFT) - 1


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

    ``picture`` (rows, cols) int8; a tile has ``tile`` × ``tile`` cells. Written: of each tile, in the order of the rows
    of tiles, its column, its row and the number of its cells to ``tiles`` (k, 3), which may have more rows and columns;
    and of each cell, in the order of the list within its tile, to ``places`` (n,) ``row · tile + col`` within the tile
    and to ``values`` (n,) its value in the picture now. A counting sort (Knuth, The Art of Computer Programming, 5.2).
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
