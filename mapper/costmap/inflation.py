"""Inflation: costs that decrease with the distance from the nearest obstacle."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from itertools import product

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.parallel import cores, in_parallel
from mapper.costmap.costs import cells_of, cost_table
from mapper.costmap.kernels.inflation import (
    TILE_COLS,
    TILE_ROWS,
    mark_blocks,
    near_blocks,
    tile_distances,
    write_costs,
)
from mapper.costmap.parameters import InflationConfig
from mapper.grid.cell_box import CellBox

MAX_RADIUS = 253  #: cells; distances within a column are stored in a byte
_NARROW = 180  #: cells; maximum radius for which squared distances fit into 16 bits


@lru_cache(maxsize=16)
def _table(radius: int, resolution: float, inscribed_radius: float, cost_scaling_factor: float) -> UInt8Array:
    return cost_table(radius, resolution, inscribed_radius, cost_scaling_factor)


def radius_in_cells(config: InflationConfig, resolution: float) -> int:
    """Return the inflation radius in cells, rounded up. Raises :class:`LimitError` for more than 253."""
    radius = cells_of(config.inflation_radius, resolution)
    if radius > MAX_RADIUS:
        raise LimitError(
            "costmap.inflation_radius",
            f"An inflation radius of {config.inflation_radius:g} m is {radius} cells of {resolution:g} m, more than "
            f"{MAX_RADIUS}; choose a smaller radius or a coarser resolution.",
        )
    return radius


def squared_distances(costs: UInt8Array, radius: int) -> np.ndarray:
    """Return the squared distance (rows, cols), in cells, of each cell to the nearest lethal cell of ``costs``.

    Distances beyond ``radius`` cells are radius² + 1. The type is uint16 or uint32. Raises :class:`ConfigError` for a
    radius outside 0 … 253.
    """
    if not 0 <= radius <= MAX_RADIUS:
        raise ConfigError("costmap.radius", f"The radius must be 0 … {MAX_RADIUS} cells, not {radius}.")
    rows, cols = costs.shape
    out = np.full((rows, cols), radius * radius + 1, dtype=_type_for(radius))
    blocks = _blocks(costs, False)

    def fill(tiles: list[tuple[int, int]]) -> None:
        columns, squares, _ = _working(radius)
        for row, col in tiles:
            if near_blocks(blocks, row - radius, row + TILE_ROWS + radius, col - radius, col + TILE_COLS + radius):
                part = out[row : row + TILE_ROWS, col : col + TILE_COLS]
                tile_distances(costs, False, radius, row, col, *_cut(columns, squares, part, radius), part)

    _over_tiles(fill, CellBox(0, rows, 0, cols))
    return out


def inflate(
    costs: UInt8Array,
    config: InflationConfig,
    resolution: float,
    inscribed_radius: float,
    out: UInt8Array,
    box: CellBox | None = None,
) -> None:
    """Write the inflated costs of the cells of ``box``, by default the whole map, into ``out``.

    ``costs`` and ``out`` are (rows, cols) uint8, C-contiguous, and different arrays. Costs outside the box are read
    within the inflation radius, but not written. ``resolution`` is in m per cell, ``inscribed_radius`` in m. The result
    is that of Nav2's inflation layer with exact distances; Nav2 finds the nearest obstacle by a wavefront, which is not
    exact in rare cells. Source: nav2_costmap_2d, inflation_layer.cpp.
    """
    rows, cols = costs.shape
    box = box or CellBox(0, rows, 0, cols)
    radius = radius_in_cells(config, resolution)
    if radius == 0 or not config.enabled:
        out[box.row0 : box.row1, box.col0 : box.col1] = costs[box.row0 : box.row1, box.col0 : box.col1]
        return
    table = _table(radius, resolution, inscribed_radius, config.cost_scaling_factor)
    around = config.inflate_around_unknown
    low_row, low_col = max(box.row0 - radius, 0), max(box.col0 - radius, 0)
    near = costs[low_row : min(box.row1 + radius, rows), low_col : min(box.col1 + radius, cols)]
    blocks = _blocks(near, around)

    out[box.row0 : box.row1, box.col0 : box.col1] = costs[box.row0 : box.row1, box.col0 : box.col1]
    if not blocks.any():
        return

    def fill(tiles: list[tuple[int, int]]) -> None:
        columns, squares, distances = _working(radius)
        for row, col in tiles:
            top, left = row - low_row, col - low_col
            if near_blocks(blocks, top - radius, top + TILE_ROWS + radius, left - radius, left + TILE_COLS + radius):
                last_row, last_col = min(row + TILE_ROWS, box.row1), min(col + TILE_COLS, box.col1)
                part = distances[: last_row - row, : last_col - col]
                tile_distances(near, around, radius, top, left, *_cut(columns, squares, part, radius), part)
                old, new = costs[row:last_row, col:last_col], out[row:last_row, col:last_col]
                write_costs(part, table, config.inflate_unknown, old, new)

    _over_tiles(fill, box)


def _type_for(radius: int) -> type[np.unsignedinteger]:
    return np.uint16 if radius <= _NARROW else np.uint32


def _blocks(costs: UInt8Array, with_unknown: bool) -> np.ndarray:
    blocks = np.empty((math.ceil(costs.shape[0] / 64), math.ceil(costs.shape[1] / 64)), dtype=np.bool_)
    mark_blocks(costs, with_unknown, blocks)
    return blocks


def _working(radius: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return one thread's working memory for tiles of the maximum size."""
    kind = _type_for(radius)
    columns = np.empty((TILE_ROWS + 2 * radius) * (TILE_COLS + 2 * radius), dtype=np.uint8)
    return columns, np.empty(TILE_COLS + 2 * radius, dtype=kind), np.empty((TILE_ROWS, TILE_COLS), dtype=kind)


def _cut(columns: np.ndarray, squares: np.ndarray, part: np.ndarray, radius: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the working memory for a tile of the size of ``part``."""
    rows, cols = part.shape[0] + 2 * radius, part.shape[1] + 2 * radius
    return columns[: rows * cols].reshape(rows, cols), squares[:cols]


def _over_tiles(fill: Callable[[list[tuple[int, int]]], None], box: CellBox) -> None:
    """Call ``fill`` with the corners (row, col) of the tiles of a box, in one part per core."""
    tiles = list(product(range(box.row0, box.row1, TILE_ROWS), range(box.col0, box.col1, TILE_COLS)))
    n = min(cores(), len(tiles))
    if n <= 1:
        fill(tiles)
        return
    in_parallel([partial(fill, tiles[k::n]) for k in range(n)])
