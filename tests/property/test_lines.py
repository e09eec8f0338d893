"""The kernel's lines, in fixed point, against Bresenham's rule in integers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from mapper.mapping.kernels.bresenham import MAX_STEPS, draw_lines
from mapper.mapping.kernels.types import Cells, LogOddsUpdate
from mapper.mapping.textbook_traversal import bresenham
from mapper.mapping.update import NO_ENDS


def drawn(shape: tuple[int, int], start: tuple[int, int], end: tuple[int, int]) -> NDArray[np.float32]:
    """Return how often the kernel visits each cell."""
    visits, observed = np.zeros(shape, np.float32), np.zeros(shape, np.bool_)
    steps = max(abs(end[0] - start[0]), abs(end[1] - start[1]))
    line = np.array([[*start, *end, steps + 1, steps + 1, -1, -1, -1]], dtype=np.int32).T.copy()
    update = LogOddsUpdate(np.float32(1), np.float32(0), np.float32(-100), np.float32(100))
    box = np.array([shape[0], 0, shape[1], 0])
    draw_lines(
        Cells(visits.reshape(-1), observed.reshape(-1), shape[1]), line, update, False, NO_ENDS, 0, shape[0], box, True
    )
    return visits


def test_every_short_line() -> None:
    side = 19
    for end in np.ndindex(side, side):
        line = bresenham((9, 9), (int(end[0]), int(end[1])))
        expected = np.zeros((side, side), np.float32)
        expected[tuple(np.transpose(line))] = 1
        np.testing.assert_array_equal(drawn((side, side), (9, 9), (int(end[0]), int(end[1]))), expected)


@pytest.mark.parametrize("major", [MAX_STEPS - 1, MAX_STEPS - 2, 300_007, 3 * (1 << 17)])
@pytest.mark.parametrize("minor", [1, 2, 3, 5])
@pytest.mark.parametrize("way", [1, -1])
def test_the_longest_lines(major: int, minor: int, way: int) -> None:
    # After i steps along the longer axis (2·i·minor + major) // (2·major) along the other one: no rounding at all.
    start, end = ((0, 0), (minor, major)) if way > 0 else ((minor, major), (0, 0))
    rows, cols = np.nonzero(drawn((minor + 1, major + 1), start, end))
    order = np.argsort(cols)
    i = np.arange(major + 1)
    expected = (2 * i * minor + major) // (2 * major)
    np.testing.assert_array_equal(cols[order], i)
    np.testing.assert_array_equal(rows[order], expected if way > 0 else (minor - expected)[::-1])
