"""Inflation against Nav2's formulas: written down as a table of cases, and against a distance transform of SciPy."""

import inspect
import math

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from mapper.core.errors import LimitError
from mapper.core.parallel import single_threaded
from mapper.costmap import LETHAL, InflationConfig, cost_of_distance
from mapper.costmap.inflation import inflate, squared_distances
from mapper.costmap.kernels.inflation import tile_distances

#: distance in m, inscribed radius in m, cost_scaling_factor, cost: by hand from the documentation's formula
#: 252 · exp(−cost_scaling_factor · (distance − inscribed_radius)), cut to a whole number
NAV2_CASES = [
    (0.0, 0.2, 10.0, 254),
    (0.05, 0.2, 10.0, 253),
    (0.2, 0.2, 10.0, 253),
    (0.25, 0.2, 10.0, 152),  # 252 · e^−0.5 = 152.8
    (0.3, 0.2, 10.0, 92),  # 252 · e^−1 = 92.7
    (0.55, 0.2, 10.0, 7),  # 252 · e^−3.5 = 7.6
    (0.55, 0.22, 3.0, 93),  # 252 · e^−0.99 = 93.6
    (1.0, 0.1, 0.0, 252),
    (3.0, 0.1, 10.0, 0),
]


@pytest.mark.parametrize(("distance", "inscribed", "factor", "cost"), NAV2_CASES)
def test_costs_are_those_of_nav2s_formula(distance: float, inscribed: float, factor: float, cost: int) -> None:
    assert cost_of_distance(distance, inscribed, factor) == cost


def test_a_single_obstacle_has_nav2s_rings_around_it() -> None:
    costs = np.zeros((21, 21), dtype=np.uint8)
    costs[10, 10] = LETHAL
    out = np.empty_like(costs)
    inflate(costs, InflationConfig(inflation_radius=0.3, cost_scaling_factor=5.0), 0.1, 0.1, out)
    for row, col in np.ndindex(21, 21):
        cells = math.hypot(row - 10, col - 10)
        expected = cost_of_distance(cells * 0.1, 0.1, 5.0) if cells <= 3 else 0
        assert out[row, col] == expected, (row, col)


@pytest.mark.parametrize("radius", [1, 11, 60, 200])
def test_distances_are_exact_over_the_borders_of_tiles(radius: int) -> None:
    rng = np.random.default_rng(radius)
    costs = np.where(rng.random((300, 700)) < 0.0005, LETHAL, 0).astype(np.uint8)
    costs[120:180, 300] = LETHAL
    found = squared_distances(costs, radius)
    exact = np.rint(distance_transform_edt(costs != LETHAL) ** 2).astype(np.int64)
    np.testing.assert_array_equal(found, np.minimum(exact, radius * radius + 1))
    with single_threaded():
        np.testing.assert_array_equal(squared_distances(costs, radius), found)


def test_rows_whose_obstacles_are_too_far_left_of_the_tile_read_no_cell_outside_of_it() -> None:
    # As plain Python, in which a cell outside of an array is an IndexError.
    radius, rows, cols, col0 = 5, 12, 20, 5
    costs = np.zeros((rows, col0 + cols), dtype=np.uint8)
    costs[0, 0] = LETHAL
    columns = np.empty((rows + 2 * radius, cols + 2 * radius), dtype=np.uint8)
    squares, out = np.empty(cols + 2 * radius, dtype=np.uint16), np.empty((rows, cols), dtype=np.uint16)
    inspect.unwrap(tile_distances)(costs, False, radius, 0, col0, columns, squares, out)
    exact = np.rint(distance_transform_edt(costs != LETHAL) ** 2).astype(np.int64)[:, col0:]
    np.testing.assert_array_equal(out, np.minimum(exact, radius * radius + 1))


def test_a_radius_of_too_many_cells_is_refused() -> None:
    costs = np.zeros((4, 4), dtype=np.uint8)
    with pytest.raises(LimitError, match=r"3 m is 300 cells of 0\.01 m, more than 253"):
        inflate(costs, InflationConfig(inflation_radius=3.0), 0.01, 0.1, np.empty_like(costs))
