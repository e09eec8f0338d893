"""The index of a patch's points, beside a pass over all points."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.terrain import Patches, PointIndex


@pytest.mark.parametrize("shape", [(7, 11), (1, 70_000), (70_000, 1)], ids=["few", "one long row", "one long column"])
def test_windows_have_the_points_that_a_pass_over_all_finds(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(2)
    rows, cols = shape
    size, corner = 0.3, np.array([-4.0, 2.5, 1.0])
    beyond = np.array([cols, rows]) * size + 0.5
    low, high = corner[:2] - 0.5, corner[:2] + beyond  # some lie outside
    points = np.column_stack([rng.uniform(low, high, (20_000, 2)), rng.normal(size=20_000)])
    index = PointIndex(points, Patches(np.zeros((rows, cols, 10)), size, corner))
    places = np.floor((points[:, :2] - corner[:2]) * (1.0 / size))
    within = ((places >= 0) & (places < (cols, rows))).all(axis=1)
    for reach in (0, 1, 3):
        near_points = places[rng.choice(np.flatnonzero(within), 8)].astype(int)
        for col, row in [(0, 0), (cols - 1, rows - 1), *near_points.tolist()]:
            near = (np.abs(places - (col, row)) <= reach).all(axis=1) & within
            np.testing.assert_array_equal(index.window(row, col, reach), np.flatnonzero(near))
    assert index.window(-9, 0).size == index.window(0, cols + 9).size == index.window(0, -9, 2).size == 0


def test_without_points_windows_are_empty() -> None:
    index = PointIndex(np.empty((0, 3)), Patches(np.zeros((2, 3, 10)), 1.0, np.zeros(3)))
    assert index.window(1, 1, 5).shape == (0,)
