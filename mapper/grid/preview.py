"""Small picture of a map, shown by notebooks for a grid."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

MOST_PIXELS = 1024  #: along each side
UNOBSERVED_RGB = (176, 196, 222)  #: pale blue instead of grey, so that it is not read as a probability
_BAND_CELLS = 1 << 20  # cells processed together


def preview_png(log_odds: NDArray[np.float32], observed: NDArray[np.bool_]) -> bytes:
    """Return a PNG of p_occ, top row first: white is free, black is occupied, pale blue was never observed.

    ``log_odds`` and ``observed`` (rows, cols), row 0 at the smallest y. A map of more than :data:`MOST_PIXELS` cells
    along a side is downsampled by an integer factor; a pixel then shows the most occupied of its observed cells.
    """
    rows, cols = log_odds.shape
    factor = -(-max(rows, cols) // MOST_PIXELS)
    height, width = -(-rows // factor), -(-cols // factor)
    index = np.empty((height, width), dtype=np.uint8)
    step = max(1, _BAND_CELLS // (factor * cols))
    for first in range(0, height, step):
        part = slice(first * factor, min((first + step) * factor, rows))
        values = np.where(observed[part], log_odds[part], np.float32(np.nan))
        if factor > 1:
            values = _block_maximum(values, factor)
        # 1 − p: +inf and −inf are 0 and 1 without overflow.
        free = 0.5 - 0.5 * np.tanh(0.5 * values)
        index[first : first + step] = np.where(np.isnan(values), 255, np.rint(254.0 * free))
    image = Image.fromarray(np.ascontiguousarray(index[::-1]))
    greys = np.rint(np.arange(255) * 255.0 / 254.0).astype(int)
    image.putpalette([*np.repeat(greys, 3).tolist(), *UNOBSERVED_RGB])
    out = io.BytesIO()
    image.save(out, "PNG")
    return out.getvalue()


def _block_maximum(cells: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Return the maximum of each block of ``factor`` × ``factor`` cells, ignoring NaN; border blocks may be smaller.

    A block of NaN only is NaN.
    """
    rows, cols = cells.shape
    tall = np.fmax.reduceat(cells, np.arange(0, rows, factor), axis=0)
    return np.asarray(np.fmax.reduceat(tall, np.arange(0, cols, factor), axis=1))
