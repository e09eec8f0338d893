"""From log-odds to the int8 picture that goes over the wire, and which of its tiles changed."""

from __future__ import annotations

from math import floor

from numpy import int8

from mapper.core.array_types import BoolArray, Float32Array, Int8Array
from mapper.core.jit import jit

NEVER_OBSERVED = -128  #: the picture's value for a cell that no beam touched


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
) -> int:
    """Bring the box [row0, row1) × [col0, col1) of ``picture`` up to date; return how many of its cells changed.

    ``log_odds`` (rows, cols) float32, ``observed`` (rows, cols) bool; ``picture`` (rows, cols) int8 is written, and
    ``changed`` (⌈rows / tile⌉, ⌈cols / tile⌉) bool becomes true for each tile of ``tile`` × ``tile`` cells in which a
    cell's value changed. Log-odds ``low`` … ``high`` spread over −127 … 127, values beyond are held at the ends;
    −128 is "never observed". Each value is the nearest one of the same state, free below and occupied above two
    log-odds: the picture never shows a cell in another state than it is in. The part of the box outside the grid is
    ignored.
    """
    rows, cols = log_odds.shape
    scale = 254.0 / (high - low)
    most_free, least_occupied = -128, 128
    for step in range(-127, 128):
        stands_for = low + (step + 127) / 254.0 * (high - low)
        if stands_for < free_below:
            most_free = step
        if stands_for > occupied_above:
            least_occupied = min(least_occupied, step)
    count = 0
    for r in range(max(row0, 0), min(row1, rows)):
        for c in range(max(col0, 0), min(col1, cols)):
            q = NEVER_OBSERVED
            if observed[r, c]:
                value = float(log_odds[r, c])
                q = floor(min(max((value - low) * scale, 0.0), 254.0) + 0.5) - 127
                if value < free_below:
                    q = min(q, most_free)
                elif value > occupied_above:
                    q = max(q, least_occupied)
                else:
                    q = min(max(q, most_free + 1), least_occupied - 1)
                q = min(max(q, -127), 127)
            if picture[r, c] != q:
                picture[r, c] = int8(q)
                changed[r // tile, c // tile] = True
                count += 1
    return count
