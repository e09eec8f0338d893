"""The geometry of a map in 3D: columns for occupied cells, an image for the floor. NumPy only.

The height of a column grows with p_occ. The floor shows p_occ as a colour and is transparent in unobserved cells. Large
grids are drawn at a lower resolution, which bounds the cost of the scene.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.grid import OCCUPIED_THRESHOLD, TILE, GridGeometry, log_odds
from server.scenes.shapes import Mesh, boxes
from server.sessions.drawings import COLUMN_M

MAX_SIDE = 1024  #: maximum number of drawn cells along a side; in a larger grid, blocks of cells are drawn
STEPS = np.asarray(log_odds([OCCUPIED_THRESHOLD, 0.8, 0.9, 0.95]), dtype=np.float32)  #: log-odds of each level
HEIGHTS = COLUMN_M * np.array([0.0, 0.4, 0.7, 0.9, 1.0])  #: metres of a column of level 0 … 4
# The floor at p_occ = 0, 0.5 and 1 (free, undecided, occupied): its colours on a light page, and its opacity. One scene
# serves light and dark pages, so the page's background shows through free cells, which are dark on a dark page.
_FLOOR_P = (0.0, 0.5, 1.0)
_FLOOR_RGBA = ((191, 220, 243, 0.4), (241, 238, 230, 0.4), (201, 104, 42, 1.0))
LIGHT_BACKGROUND = (250, 248, 242)  #: of a page's 3D view, see :mod:`server.scenes.proxy`


def _floor_colours() -> NDArray[np.uint8]:
    """Return the colours (256, 4), RGBA, of p_occ; over the light background they look like those listed."""
    steps = np.linspace(0, 1, 256)
    shown = np.column_stack([np.interp(steps, _FLOOR_P, channel) for channel in zip(*_FLOOR_RGBA, strict=True)])
    opacity = shown[:, 3:]
    through = (shown[:, :3] - (1.0 - opacity) * np.array(LIGHT_BACKGROUND)) / opacity
    return np.round(np.column_stack([through, 255.0 * opacity])).clip(0, 255).astype(np.uint8)


_FLOOR = _floor_colours()


@dataclass(frozen=True, slots=True)
class MapLevels:
    """The drawn form of a map: ``levels`` (rows, cols) uint8, 0 to 4, and ``floor`` (rows, cols, 4) uint8.

    Row 0 is at the smallest y. A drawn cell is ``cell`` metres wide, and is a block of ``block`` × ``block`` cells of
    the map, of which ``occupied`` (block × rows, block × cols) are occupied.
    """

    levels: NDArray[np.uint8]
    floor: NDArray[np.uint8]
    cell: float
    block: int
    occupied: NDArray[np.bool_]

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height in metres."""
        return self.levels.shape[1] * self.cell, self.levels.shape[0] * self.cell


def map_levels(geometry: GridGeometry, values: NDArray[np.float32], observed: NDArray[np.bool_]) -> MapLevels:
    """Return the drawn form of the log-odds ``values`` and ``observed`` (rows, cols).

    A block of cells has the log-odds of its most occupied cell, so that thin walls stay visible.
    """
    block = -(-max(geometry.shape) // MAX_SIDE)
    seen = np.where(observed, values, np.float32(-np.inf))
    if block > 1:
        rows, cols = (-(-side // block) for side in geometry.shape)
        whole = np.full((rows * block, cols * block), -np.inf, dtype=np.float32)
        whole[: geometry.rows, : geometry.cols] = seen
        occupied = whole > STEPS[0]
        seen = whole.reshape(rows, block, cols, block).max(axis=(1, 3))
    else:
        occupied = seen > STEPS[0]
    levels = np.zeros(seen.shape, dtype=np.uint8)
    for step in STEPS:
        levels += seen > step
    unseen = np.isneginf(seen)
    # Unobserved cells are transparent and have the colour of free ones, so that smoothing adds no dark edge.
    p_occ = 1.0 / (1.0 + np.exp(-np.where(unseen, np.float32(-8.0), seen)))
    floor = _FLOOR[(p_occ * 255.0).astype(np.uint8)]
    floor[unseen, 3] = 0
    return MapLevels(levels, floor, geometry.resolution * block, block, occupied)


def first_column(
    shown: MapLevels, scale: float, start: NDArray[np.float64], along: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return the place (3,) at which a line of sight is in the first column that it meets; None if it meets none.

    ``start``, ``along`` (3,) and the place are in the frame of the map, metres; columns are ``scale`` times as high as
    :data:`HEIGHTS`. The place is the middle of the line's segment in the column, because the side by which it enters is
    the border of two cells. In the column of a block of cells, it is in an occupied one: the first that the line meets,
    otherwise the centre of the one nearest to the line's segment.
    """
    top = scale * HEIGHTS[-1]
    enter, leave = _shares_inside(np.zeros(3), np.array([*shown.size_m, top]), start, along)
    if not enter < leave < np.inf:
        return None
    cells = _cells_along(*((start[:2] + share * along[:2]) / shown.cell for share in (enter, leave)))
    cells = cells[((cells >= 0) & (cells < shown.levels.shape)).all(axis=1)]  # an end may be on the map's border
    heights = scale * HEIGHTS[shown.levels[*cells.T]]
    shares = _shares_of_columns(cells, shown.cell, heights, start, along)
    met = np.flatnonzero((heights > 0.0) & np.isfinite(shares))
    if not len(met):
        return None
    place: NDArray[np.float64] = start + shares[met[0]] * along
    if shown.block == 1:
        return place
    row, col = shown.block * cells[met[0]]
    inner = np.argwhere(shown.occupied[row : row + shown.block, col : col + shown.block]) + np.array([row, col])
    width = shown.cell / shown.block
    shares = _shares_of_columns(inner, width, heights[met[0]], start, along)
    if np.isfinite(shares).any():
        place = start + shares.min() * along
    else:
        middles = (inner[:, ::-1] + 0.5) * width
        place[:2] = middles[np.hypot(*(middles - place[:2]).T).argmin()]
    return place


def _shares_of_columns(
    cells: NDArray[np.intp], width: float, heights: ArrayLike, start: NDArray[np.float64], along: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the middles (n,) of a line's segments in columns, as multiples of ``along``; ∞ if it does not meet them.

    The columns stand on ``cells`` (n, 2), row and column, are ``width`` metres wide, and ``heights`` high, metres.
    """
    low = np.column_stack([cells[:, ::-1] * width, np.zeros(len(cells))])
    high = np.column_stack([low[:, :2] + width, np.broadcast_to(heights, len(cells))])
    enter, leave = _shares_inside(low, high, start, along)
    middles: NDArray[np.float64] = np.full(len(cells), np.inf)
    np.add(0.5 * enter, 0.5 * leave, where=enter < leave, out=middles)
    return middles


def _cells_along(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the cells (n, 2), row and column, that a line crosses, in order, from its ends (2,), column and row.

    Between two crossings of grid lines, the line is in the cell that contains the midpoint.
    """
    along = end - start
    shares = [np.array([0.0, 1.0])]
    for first, length in zip(start, along, strict=True):
        lines = np.arange(np.ceil(min(first, first + length)), max(first, first + length))
        if length != 0.0:
            shares.append((lines - first) / length)
    crossings = np.unique(np.concatenate(shares))
    middles = start + 0.5 * (crossings[1:] + crossings[:-1])[:, None] * along
    cells: NDArray[np.intp] = np.floor(middles).astype(np.intp)
    return cells[:, ::-1]


def _shares_inside(
    low: NDArray[np.float64], high: NDArray[np.float64], start: NDArray[np.float64], along: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where a ray enters and leaves boxes from ``low`` to ``high`` (..., 3), as multiples of ``along`` from 0.

    It meets those that it enters before leaving them. Source: the slabs of Kay & Kajiya, SIGGRAPH 1986.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        at_low, at_high = ((side - start) / (along + 0.0) for side in (low, high))  # + 0.0 avoids −0.0
    # A line in the plane of a side and parallel to it yields 0 / 0 there, and is between the two sides.
    at_low, at_high = np.where(np.isnan(at_low), -np.inf, at_low), np.where(np.isnan(at_high), np.inf, at_high)
    enter = np.minimum(at_low, at_high).max(axis=-1, initial=0.0)
    return enter, np.maximum(at_low, at_high).min(axis=-1)


def changed_tiles(new: NDArray[np.uint8], old: NDArray[np.uint8] | None) -> list[tuple[int, int]]:
    """Return the tiles (row, col) of 64 × 64 cells in which the levels differ; without ``old``, those with a column."""
    different = new != 0 if old is None or old.shape != new.shape else new != old
    rows, cols = (-(-side // TILE) for side in new.shape)
    whole = np.zeros((rows * TILE, cols * TILE), dtype=np.bool_)
    whole[: new.shape[0], : new.shape[1]] = different
    return [(int(r), int(c)) for r, c in np.argwhere(whole.reshape(rows, TILE, cols, TILE).any(axis=(1, 3)))]


def tile_columns(levels: NDArray[np.uint8], tile: tuple[int, int], cell: float) -> Mesh:
    """Return the columns of one tile as boxes, metres from the corner of cell (0, 0); equal neighbours share one."""
    row, col = tile[0] * TILE, tile[1] * TILE
    part = levels[row : row + TILE, col : col + TILE]
    along, across = _runs(part), _runs(part.T)
    runs = across[:, [1, 0, 3, 2, 4]] if len(across) < len(along) else along
    low = np.column_stack([(runs[:, 1] + col) * cell, (runs[:, 0] + row) * cell, np.zeros(len(runs))])
    high = np.column_stack([(runs[:, 3] + col) * cell, (runs[:, 2] + row) * cell, HEIGHTS[runs[:, 4]]])
    return boxes(low, high)


def _runs(part: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the runs of equal level along rows (n, 5): row0, col0, row1, col1 (half-open), level."""
    padded = np.pad(part, ((0, 0), (1, 1)))
    edge = padded[:, 1:] != padded[:, :-1]
    row, first = np.nonzero(edge & (padded[:, 1:] != 0))
    _, last = np.nonzero(edge & (padded[:, :-1] != 0))
    return np.column_stack([row, first, row + 1, last, part[row, first]]).astype(np.int64)
