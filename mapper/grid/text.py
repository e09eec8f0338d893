"""A map as text: three states, or a ramp of characters that grow denser with p_occ.

The picture is cropped to the observed cells, top row first. A block of cells becomes one character, chosen by its most
occupied cell, so that walls one cell thick survive. Characters are about twice as tall as wide, so a block has twice as
many rows as columns, and a map narrower than half the width uses two characters per cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid.occupancy_grid import (
    OCCUPIED,
    UNKNOWN,
    GridGeometry,
    OccupancyGrid,
    probability,
)

OCCUPIED_CHARACTER, FREE_CHARACTER, UNKNOWN_CHARACTER = "#", ".", "?"
RAMP = ".:-=+*#%@"  #: for p_occ from 0 to 1; a block that was never observed is a space


def three_state(grid: OccupancyGrid, width: int = 80) -> str:
    """Return the map as ``#`` occupied, ``.`` free and ``?`` unknown, at most ``width`` characters wide.

    Raises :class:`ConfigError` for a width below 1.
    """
    state = grid.classify()
    characters = np.full(256, UNKNOWN_CHARACTER)
    characters[[0, OCCUPIED]] = FREE_CHARACTER, OCCUPIED_CHARACTER
    return _text(characters[_blocks(_observed_part(grid, state), width)])


def density(grid: OccupancyGrid, width: int = 80) -> str:
    """Return the map in the characters of :data:`RAMP`, at most ``width`` characters wide.

    Raises :class:`ConfigError` for a width below 1.
    """
    step = np.minimum(np.floor(probability(grid.log_odds) * len(RAMP)), len(RAMP) - 1).astype(np.int8)
    step[~grid.observed] = UNKNOWN
    characters = np.array([*RAMP, " "])
    return _text(characters[_blocks(_observed_part(grid, step), width)])


def _observed_part(grid: OccupancyGrid, cells: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the smallest part of ``cells`` (rows, cols) with every observed cell, in image order."""
    rows, cols = np.flatnonzero(grid.observed.any(axis=1)), np.flatnonzero(grid.observed.any(axis=0))
    if rows.size:
        cells = cells[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    return np.asarray(GridGeometry.to_image(cells), dtype=np.int8)


def _blocks(cells: NDArray[np.int8], width: int) -> NDArray[np.int8]:
    """Return the maximum of each block of cells, in as many columns as fit ``width``."""
    if width < 1:
        raise ConfigError("render.width", f"A picture must be at least one character wide, not {width}.")
    rows, cols = cells.shape
    if 2 * cols <= width:
        return np.repeat(cells, 2, axis=1)
    width = min(width, cols)
    height = max(1, round(rows * width / (2 * cols)))
    tall = np.maximum.reduceat(cells, np.arange(height) * rows // height, axis=0)
    return np.asarray(np.maximum.reduceat(tall, np.arange(width) * cols // width, axis=1), dtype=np.int8)


def _text(characters: NDArray[np.str_]) -> str:
    return "\n".join("".join(row).rstrip() for row in characters)
