"""Paths on costmaps: against SciPy's shortest paths, closed forms, and what is refused."""

import math
import re

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry
from mapper.planning import GoalPlanner, PlannerConfig, plan_path
from mapper.planning.plan import step_costs

GEOMETRY = GridGeometry(0.1, 40, 60, (-1.0, 2.0, 0.3))


def at(row: float, col: float) -> np.ndarray:
    return GEOMETRY.cell_to_world((row, col))


def rough_map() -> np.ndarray:
    """Costs of all kinds, with the start (5, 5) and the goal (33, 52) free."""
    rng = np.random.default_rng(5)
    costs = rng.integers(0, 256, GEOMETRY.shape).astype(np.uint8)
    costs[rng.random(costs.shape) < 0.25] = 254
    costs[5, 5] = costs[33, 52] = 0
    return costs


def by_scipy(costs: np.ndarray, table: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    """The cost to come of every cell, from a graph that is put together by shifting the whole map."""
    rows, cols = costs.shape
    number = np.arange(costs.size).reshape(costs.shape)
    padded = np.pad(table[costs], 1, constant_values=np.inf)
    ends: list[np.ndarray] = [np.zeros(0, dtype=int)] * 2
    weights = np.zeros(0)
    for d_row in (-1, 0, 1):
        for d_col in (-1, 0, 1):
            if d_row == d_col == 0:
                continue
            to = padded[1 + d_row : 1 + d_row + rows, 1 + d_col : 1 + d_col + cols]
            beside = np.minimum(
                padded[1 + d_row : 1 + d_row + rows, 1 : 1 + cols], padded[1 : 1 + rows, 1 + d_col : 1 + d_col + cols]
            )
            usable = np.isfinite(to) & np.isfinite(table[costs]) & (np.isfinite(beside) | (d_row * d_col == 0))
            ends = [np.append(ends[0], number[usable]), np.append(ends[1], number[usable] + d_row * cols + d_col)]
            weights = np.append(weights, to[usable] * math.hypot(d_row, d_col))
    graph = csr_matrix((weights, (ends[0], ends[1])), shape=(costs.size, costs.size))
    return np.asarray(dijkstra(graph, indices=int(number[start]))).reshape(costs.shape)


@pytest.mark.parametrize("allow_unknown", [True, False])
def test_the_cost_to_come_is_that_of_scipys_graph(allow_unknown: bool) -> None:
    costs, config = rough_map(), PlannerConfig(allow_unknown=allow_unknown)
    expected = by_scipy(costs, step_costs(config), (5, 5))
    path = plan_path(costs, GEOMETRY, at(5, 5), at(33, 52), config)
    known = np.isfinite(path.potential)
    np.testing.assert_allclose(path.potential[known], expected[known], rtol=1e-12)
    assert known[expected < expected[33, 52] - 1e-6].all()
    assert path.cost == pytest.approx(expected[33, 52], rel=1e-12)


def test_a_star_finds_a_path_of_the_same_cost_in_fewer_cells() -> None:
    costs = np.zeros(GEOMETRY.shape, dtype=np.uint8)
    costs[10:, 30] = 254
    one = plan_path(costs, GEOMETRY, at(20, 20), at(20, 40))
    other = plan_path(costs, GEOMETRY, at(20, 20), at(20, 40), PlannerConfig(use_astar=True))
    assert other.cost == pytest.approx(one.cost, rel=1e-12)
    assert np.isfinite(other.potential).sum() < np.isfinite(one.potential).sum()
    rough = rough_map()
    costs_of_both = [
        plan_path(rough, GEOMETRY, at(5, 5), at(33, 52), PlannerConfig(use_astar=a)).cost for a in (False, True)
    ]
    assert costs_of_both[0] == pytest.approx(costs_of_both[1], rel=1e-12)


@pytest.mark.parametrize("use_astar", [False, True])
def test_a_goal_that_moves_has_the_path_that_is_planned_anew(use_astar: bool) -> None:
    """Goals near and far, on obstacles, and beyond them; errors are the same."""
    costs, config = rough_map(), PlannerConfig(use_astar=use_astar, tolerance=0.3)
    costs[30:36, 50] = costs[30:36, 56] = costs[30, 50:57] = costs[35, 50:57] = 254  # a closed box
    planner = GoalPlanner(costs, GEOMETRY, at(5, 5), config)
    assert planner.begins_at(at(5, 5))
    assert not planner.begins_at(at(5, 6))
    rng = np.random.default_rng(4)
    seen: set[object] = set()
    for row, col in [(6, 6), (33, 53), *rng.integers((0, 0), GEOMETRY.shape, (30, 2)).tolist()]:
        try:
            expected = plan_path(costs, GEOMETRY, at(5, 5), at(row, col), config)
        except ConfigError as error:
            with pytest.raises(ConfigError, match=re.escape(error.message)):
                planner.plan(at(5, 5), at(row, col))
            seen.add(error.code)
            continue
        found = planner.plan(at(5, 5), at(row, col))
        assert (found.cost, found.reaches_goal) == (expected.cost, expected.reaches_goal)
        np.testing.assert_array_equal(found.cells, expected.cells)
        seen.add(found.reaches_goal)
    assert seen == {True, False, "path.none"}


def test_the_steps_of_a_path_add_up_to_its_cost_and_pass_no_obstacle() -> None:
    costs, table = rough_map(), step_costs(PlannerConfig())
    path = plan_path(costs, GEOMETRY, at(5, 5), at(33, 52))
    steps = np.abs(np.diff(path.cells, axis=0))
    assert (steps.max(axis=1) == 1).all()
    assert path.cost == pytest.approx((table[costs[tuple(path.cells[1:].T)]] * np.hypot(*steps.T)).sum())
    assert path.length == pytest.approx(np.hypot(*steps.T).sum() * 0.1)
    for (row, col), (to_row, to_col) in zip(path.cells[:-1], path.cells[1:], strict=True):
        assert table[costs[row, to_col]] < np.inf or table[costs[to_row, col]] < np.inf


def test_an_empty_map_has_the_octile_distance() -> None:
    costs = np.zeros(GEOMETRY.shape, dtype=np.uint8)
    path = plan_path(costs, GEOMETRY, at(2, 3), at(12, 33))
    assert path.cost == pytest.approx(50.0 * (20 + 10 * math.sqrt(2.0)))
    assert path.length == pytest.approx(0.1 * (20 + 10 * math.sqrt(2.0)))
    np.testing.assert_allclose(path.points[[0, -1]], [at(2, 3), at(12, 33)])


def test_steps_cost_what_navfn_makes_of_the_values() -> None:
    table = step_costs(PlannerConfig())
    assert [table[v] for v in (0, 1, 100, 252, 255)] == [50, 50, 130, 251, 253]
    assert np.isinf(table[[253, 254]]).all()
    assert np.isinf(step_costs(PlannerConfig(allow_unknown=False))[255])


def test_no_diagonal_step_between_two_blocked_cells() -> None:
    costs = np.full(GEOMETRY.shape, 254, dtype=np.uint8)
    costs[5, 5] = costs[6, 6] = 0
    with pytest.raises(ConfigError, match="obstacles are all around the 1 cells"):
        plan_path(costs, GEOMETRY, at(5, 5), at(6, 6), PlannerConfig(tolerance=0.0))
    costs[5, 6] = 0
    assert len(plan_path(costs, GEOMETRY, at(5, 5), at(6, 6)).cells) == 2


def test_a_path_ends_beside_an_occupied_goal() -> None:
    costs = np.zeros(GEOMETRY.shape, dtype=np.uint8)
    costs[18:23, 38:43] = 254
    path = plan_path(costs, GEOMETRY, at(20, 10), at(20, 40), PlannerConfig(tolerance=0.35))
    assert not path.reaches_goal
    assert math.hypot(*(path.points[-1] - at(20, 40))) == pytest.approx(0.3)
    with pytest.raises(ConfigError, match=r"its cell is lethal, and no cell within the tolerance of 0.25 m"):
        plan_path(costs, GEOMETRY, at(20, 10), at(20, 40), PlannerConfig(tolerance=0.25))


def test_start_and_goal_in_one_cell() -> None:
    costs = np.zeros(GEOMETRY.shape, dtype=np.uint8)
    path = plan_path(costs, GEOMETRY, at(20, 10), at(20, 10.3))
    assert (path.cost, path.reaches_goal) == (0.0, True)
    assert path.length == pytest.approx(0.03)


def wall(value: int) -> np.ndarray:
    costs = np.zeros(GEOMETRY.shape, dtype=np.uint8)
    costs[:, 30] = 254
    costs[20, 30] = value
    return costs


@pytest.mark.parametrize(
    ("costs", "start", "goal", "config", "code", "said"),
    [
        (wall(0), (math.nan, 0.0), at(20, 40), PlannerConfig(), "path.start", "start must be two finite numbers"),
        (wall(0), at(20, 10), (math.inf, 0.0), PlannerConfig(), "path.goal", "goal must be two finite numbers"),
        (wall(0), (99.0, 0.0), at(20, 40), PlannerConfig(), "path.start_outside", "the map, which goes from"),
        (wall(0), at(20, 10), (0.0, -99.0), PlannerConfig(), "path.goal_outside", r"goal \(0, -99\) is outside"),
        (wall(0), at(3, 30), at(20, 40), PlannerConfig(), "path.start_blocked", "start: its cell is lethal"),
        (wall(255), at(20, 30), at(20, 40), PlannerConfig(allow_unknown=False), "path.start_blocked", "is unknown"),
        (wall(254), at(20, 10), at(20, 40), PlannerConfig(), "path.none", "all around the 1200 cells"),
        (wall(253), at(20, 10), at(20, 40), PlannerConfig(), "path.none", "where the robot touches an obstacle"),
        (wall(255), at(20, 10), at(20, 40), PlannerConfig(allow_unknown=False), "path.none", "unknown cells"),
        (wall(0)[:, :-1], at(20, 10), at(20, 40), PlannerConfig(), "path.costs", r"must be \(40, 60\) uint8"),
    ],
)
def test_what_is_refused_says_why(costs, start, goal, config: PlannerConfig, code: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said) as refused:
        plan_path(costs, GEOMETRY, start, goal, config)
    assert refused.value.code == code


def test_unknown_cells_are_crossed_only_where_allowed() -> None:
    assert plan_path(wall(255), GEOMETRY, at(20, 10), at(20, 40)).reaches_goal
