"""Score fields: lookup grids of a correlative matcher for the fit of a point."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError

FINE = 16  #: sub-cell positions, along each side, for which stamps are computed
REACH = 3.0  #: radius of a stamp in standard deviations
GREATEST = 255  #: score at a point


@lru_cache(maxsize=16)
def gaussian_stamps(resolution: float, sigma: float) -> UInt8Array:
    """Return scores (16, 16, side, side) uint8 of the cells around a point, for each 1/16-cell position of the point.

    The score of a cell is 255 · exp(−d² / (2 ``sigma``²)), rounded down, for the distance d from the point to the
    cell's centre; ``resolution`` is in metres per cell and ``sigma`` in metres. Source: Olson 2009, section III. Raises
    :class:`ConfigError` if a stamp would be wider than 127 cells.
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
