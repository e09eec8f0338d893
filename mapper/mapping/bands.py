"""Drawing split by rows of the grid.

Each cell gets its additions from one thread, in the order of the log, so the result does not depend on the number of
threads, not even in its last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.core.parallel import bands, in_parallel

#: Draws the rows [row_low, row_high), widens a box (row0, row1, col0, col1); returns the number of cell updates.
Draw = Callable[[int, int, NDArray[np.int64]], int]


def draw_in_bands(
    draw: Draw, work: NDArray[np.float64], rows: tuple[int, int], threads: int, box: NDArray[np.int64]
) -> int:
    """Draw the rows [first, stop) of ``rows``, one band for each thread; return the number of cell updates.

    ``work`` (rows of the grid,) is the cost of each row, in any unit; ``box`` (4,) int64 (row0, row1, col0, col1),
    half-open, is widened to hold the cells that were touched.
    """
    first, stop = rows
    parts = [(first + low, first + high, box.copy()) for low, high in bands(work[first:stop], threads)]
    counts = in_parallel([partial(draw, *part) for part in parts])
    for _, _, own in parts:
        box[::2] = np.minimum(box[::2], own[::2])
        box[1::2] = np.maximum(box[1::2], own[1::2])
    return sum(int(count) for count in counts)
