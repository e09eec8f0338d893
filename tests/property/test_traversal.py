"""The cells of a line: Bresenham's example and rule, and exactly the cells that a segment crosses."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mapper.mapping.textbook_traversal import amanatides_woo, bresenham

cells = st.tuples(st.integers(-60, 60), st.integers(-60, 60))
points = st.tuples(st.floats(-30, 30), st.floats(-30, 30))


def test_the_worked_example() -> None:
    # From (0, 0) to 4 columns and 3 rows on: ∇ = 2, 0, −2, 4, and where it is negative only the column steps.
    assert bresenham((0, 0), (3, 4)) == [(0, 0), (1, 1), (2, 2), (2, 3), (3, 4)]


@given(cells, cells)
def test_bresenham_steps_once_along_the_longer_axis_and_stays_within_half_a_cell(start, end) -> None:
    line = np.array(bresenham(start, end))
    d = np.subtract(end, start)
    longer = int(np.abs(d[1]) >= np.abs(d[0]))
    assert line[0].tolist() == list(start)
    assert line[-1].tolist() == list(end)
    assert len(line) == np.abs(d).max() + 1
    steps = np.abs(np.diff(line, axis=0))
    assert (steps[:, longer] == 1).all()
    assert (steps <= 1).all()
    if len(line) > 1:
        ideal = start[1 - longer] + (line[:, longer] - start[longer]) * d[1 - longer] / d[longer]
        assert np.abs(line[:, 1 - longer] - ideal).max() <= 0.5


@given(cells, cells, st.sampled_from([(1, 0), (0, 1)]), st.sampled_from([-1, 1]), st.sampled_from([-1, 1]))
def test_bresenham_is_the_same_in_all_octants(start, end, axes, sign_row, sign_col) -> None:
    def turned(cell: tuple[int, int]) -> tuple[int, int]:
        return sign_row * cell[axes[0]], sign_col * cell[axes[1]]

    if abs(end[0] - start[0]) != abs(end[1] - start[1]):
        assert [turned(cell) for cell in bresenham(start, end)] == bresenham(turned(start), turned(end))


@given(points, points)
def test_exact_traversal_crosses_one_border_at_a_time_and_only_cells_on_the_segment(start, end) -> None:
    line = np.array(amanatides_woo(start, end))
    first, last = np.floor(start[::-1]), np.floor(end[::-1])
    np.testing.assert_array_equal(line[0], first)
    np.testing.assert_array_equal(line[-1], last)
    assert (np.abs(np.diff(line, axis=0)).sum(axis=1) == 1).all()
    assert len(line) == np.abs(last - first).sum() + 1
    # Clip the segment to each cell, a hair larger: something must be left.
    p, d = np.array(start[::-1]), np.subtract(end, start)[::-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # a segment may be as short as doubles go
        t = (line[:, :, np.newaxis] + [-1e-9, 1 + 1e-9] - p[:, np.newaxis]) / d[:, np.newaxis]
    t = np.where(d[:, np.newaxis] == 0, [-np.inf, np.inf], np.sort(t, axis=2))
    assert (np.maximum(t[:, :, 0].max(axis=1), 0) <= np.minimum(t[:, :, 1].min(axis=1), 1) + 1e-9).all()


@given(points, points)
def test_exact_traversal_skips_no_cell(start, end) -> None:
    line = set(amanatides_woo(start, end))
    along = np.linspace(0, 1, 2000)[:, np.newaxis] * np.subtract(end, start) + start
    # Only points well inside a cell: on a border, rounding says which side.
    inside = np.abs(along - np.round(along)).min(axis=1) > 1e-6
    assert {(int(v), int(u)) for u, v in np.floor(along[inside])} <= line
