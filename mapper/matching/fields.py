"""Score fields: grids in which a correlative matcher looks up how well a point fits."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError

FINE = 16  #: places of a point within its cell, along each side, for which stamps are made
REACH = 3.0  #: standard deviations from a point up to which a stamp reaches
GREATEST = 255  #: score at a point


@lru_cache(maxsize=16)
def gaussian_stamps(resolution: float, sigma: float) -> UInt8Array:
    """Return the scores (16, 16, side, side) uint8 of the cells around a point, for each 1/16 of a cell it may lie in.

    The score of a cell is 255 · exp(−d² / (2 ``sigma``²)), rounded down, of the distance d from the point to the
    cell's centre; ``resolution`` is metres a cell and ``sigma`` metres. Source: Olson 2009, section III. Raises
    :class:`ConfigError` where a stamp would be wider than 127 cells.
    """
    if not (resolution > 0.0 and 0.0 < sigma <= 20.0 * resolution):
        raise ConfigError(
            "matching.sigma",
            f"The width of a score field must be positive and at most 20 cells of {resolution:g} m, not {sigma:g} m.",
        )
    reach = int(REACH * sigma / resolution) + 1
    places = (np.arange(FINE) + 0.5) / FINE
    off = (np.arange(-reach, reach + 1) + 0.5 - places[:, np.newaxis]) * resolution
    squares = off[:, np.newaxis, :, np.newaxis] ** 2 + off[np.newaxis, :, np.newaxis, :] ** 2
    stamps = (GREATEST * np.exp(-squares / (2.0 * sigma**2))).astype(np.uint8)
    stamps.flags.writeable = False
    return stamps
