"""Pixels of map images, in bands of rows from the top of the image down.

Only one band at a time is computed, so that the extra memory does not depend on the size of the map.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from mapper.grid import (
    FREE,
    FREE_THRESHOLD,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    UNKNOWN,
    GridGeometry,
    OccupancyGrid,
    probability,
)
from mapper.grid.compare import Difference, difference
from mapper.grid.merge import on_one_lattice

BAND_CELLS = 1 << 17  #: cells of one band, which has at least one row

GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE = 0, 205, 254
RAW_UNKNOWN = 255
UNOBSERVED_RGB = (176, 196, 222)  #: pale blue instead of grey, so that it is not read as a probability
DIFFERENCE_RGB = ((21, 95, 158), (241, 238, 230), (166, 62, 8))  #: more free, no difference, more occupied
APART_RGB = (*(228, 224, 212), *(196, 178, 214), *(214, 200, 150))  #: observed in neither map, in a only, in b only

Pixels = Iterator[NDArray[np.uint8]]


def row_bands(shape: tuple[int, int]) -> Iterator[slice]:
    """Yield the rows of a grid of ``shape`` (rows, cols) in image order, in bands, highest rows first."""
    rows, cols = shape
    step = max(1, BAND_CELLS // cols)
    for stop in range(rows, 0, -step):
        yield slice(max(stop - step, 0), stop)


def occupancy_values(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> NDArray[np.int8]:
    """Return p_occ in per cent (rows, cols) int8, −1 if not observed, as in nav_msgs/OccupancyGrid.

    Rounding never moves a value across a threshold: its three-way state is that of :meth:`OccupancyGrid.classify`.
    """
    values = np.empty(grid.geometry.shape, dtype=np.int8)
    for rows in row_bands(grid.geometry.shape):
        values[rows] = _values(grid.band(rows), occupied_threshold, free_threshold)
    return values


def _values(grid: OccupancyGrid, occupied_threshold: float, free_threshold: float) -> NDArray[np.int8]:
    state = grid.classify(occupied_threshold, free_threshold)
    values = np.rint(100.0 * probability(grid.log_odds)).astype(np.int8)
    low, high = int(np.floor(100.0 * free_threshold)) + 1, int(np.ceil(100.0 * occupied_threshold)) - 1
    values = np.where(state == UNKNOWN, np.clip(values, low, high), values)
    values = np.where(state == OCCUPIED, np.maximum(values, np.floor(100.0 * occupied_threshold) + 1), values)
    values = np.where(state == FREE, np.minimum(values, np.ceil(100.0 * free_threshold) - 1), values)
    return np.where(grid.observed, values, UNKNOWN).astype(np.int8)


def _banded(grid: OccupancyGrid, pixels: Callable[[OccupancyGrid], NDArray[np.uint8]]) -> Pixels:
    """Yield the pixels of each band, top row first."""
    for rows in row_bands(grid.geometry.shape):
        yield np.asarray(GridGeometry.to_image(pixels(grid.band(rows))), dtype=np.uint8)


def trinary_pixels(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> Pixels:
    """Yield (n, cols): 0 occupied, 254 free, 205 unknown."""

    def pixels(band: OccupancyGrid) -> NDArray[np.uint8]:
        state = band.classify(occupied_threshold, free_threshold)
        grey = np.full(state.shape, GREY_UNKNOWN, dtype=np.uint8)
        grey[state == OCCUPIED] = GREY_OCCUPIED
        grey[state == FREE] = GREY_FREE
        return grey

    return _banded(grid, pixels)


def raw_pixels(grid: OccupancyGrid, occupied_threshold: float, free_threshold: float) -> Pixels:
    """Yield (n, cols): :func:`occupancy_values`, 255 if not observed."""

    def pixels(band: OccupancyGrid) -> NDArray[np.uint8]:
        values = _values(band, occupied_threshold, free_threshold)
        return np.where(values == UNKNOWN, RAW_UNKNOWN, values).astype(np.uint8)

    return _banded(grid, pixels)


def scale_pixels(grid: OccupancyGrid, occupied_threshold: float, free_threshold: float) -> Pixels:
    """Yield (n, cols, 2): grey (100 − v) % for a value v of :func:`occupancy_values`, and alpha, 0 if unobserved."""

    def pixels(band: OccupancyGrid) -> NDArray[np.uint8]:
        values = _values(band, occupied_threshold, free_threshold)
        grey = np.where(values == UNKNOWN, 128, np.rint((100.0 - values) * 2.55)).astype(np.uint8)
        return np.stack([grey, np.where(values == UNKNOWN, 0, 255).astype(np.uint8)], axis=-1)

    return _banded(grid, pixels)


def probability_pixels(grid: OccupancyGrid) -> Pixels:
    """Yield (n, cols), indices into :data:`PROBABILITY_PALETTE`: 254 (1 − p_occ), 255 if not observed."""

    def pixels(band: OccupancyGrid) -> NDArray[np.uint8]:
        index = np.rint(254.0 * (1.0 - probability(band.log_odds))).astype(np.uint8)
        index[~band.observed] = 255
        return index

    return _banded(grid, pixels)


def difference_pixels(a: OccupancyGrid, b: OccupancyGrid) -> tuple[tuple[int, int], Pixels]:
    """Return the shape (rows, cols) of the lattice that contains both maps, and its pixels (n, cols) of ℓ_b − ℓ_a.

    They are indices into :data:`DIFFERENCE_PALETTE`: 129 is no difference, and 3 and 255 are the maximum difference,
    more free or more occupied in b, on a square-root scale to show small differences; 1 and 2 are observed in a only
    and in b only, 0 in neither. Raises the errors of :func:`mapper.grid.compare.difference`.
    """
    shape = on_one_lattice(a, b)[0].shape

    def pixels() -> Pixels:
        most = 1e-6
        for rows in row_bands(shape):
            apart, _ = _apart(difference(a, b, rows))
            most = max(most, float(np.abs(apart).max()))
        for rows in row_bands(shape):
            differing = difference(a, b, rows)
            apart, known = _apart(differing)
            index = (129 + np.copysign(np.rint(np.sqrt(np.abs(apart) / most) * 126.0), apart)).astype(np.uint8)
            index[~known] = (differing.observed_a + 2 * differing.observed_b.astype(np.uint8))[~known]
            yield np.asarray(GridGeometry.to_image(index), dtype=np.uint8)

    return shape, pixels()


def _apart(difference_: Difference) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return ℓ_b − ℓ_a where both maps have observed a cell, 0 elsewhere, and the mask of such cells."""
    known = difference_.observed_a & difference_.observed_b
    return np.where(known, difference_.log_odds, np.float32(0.0)), known


def _probability_palette() -> bytes:
    greys = np.rint(np.arange(255) * 255.0 / 254.0).astype(np.uint8)
    return bytes(np.repeat(greys, 3)) + bytes(UNOBSERVED_RGB)


def _difference_palette() -> bytes:
    ramp = np.linspace(0.0, 1.0, 127)[:, None]
    less, none, more = (np.array(rgb, dtype=np.float64) for rgb in DIFFERENCE_RGB)
    colours = np.concatenate([(none + (less - none) * ramp)[:0:-1], none + (more - none) * ramp])
    return bytes(APART_RGB) + bytes(np.rint(colours).astype(np.uint8))


PROBABILITY_PALETTE = _probability_palette()  #: white is certainly free, black certainly occupied, pale blue unobserved
DIFFERENCE_PALETTE = _difference_palette()  #: blue is more free, orange more occupied, the palest neither
