"""Paths, for the table: the cost to come on random costmaps, by the kernels and by the textbook."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.planning import PlannerConfig, textbook
from mapper.planning.kernels.steps import trace_back
from mapper.planning.plan import cost_to_come, step_costs

VALUES = np.array([1, 40, 120, 252, 253, 254, 254, 255], dtype=np.uint8)


@dataclass(frozen=True)
class PlanningCase:
    """A costmap, the costs of its steps, and two cells."""

    costs: np.ndarray
    table: np.ndarray
    start: tuple[int, int]
    goal: tuple[int, int]
    is_whole: bool = False  #: whether all cells are searched, without a goal


@st.composite
def planning_cases(draw: st.DrawFn) -> PlanningCase:
    """Maps with few and many obstacles, in some of which the goal cannot be reached."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    rows, cols = draw(st.sampled_from([(1, 1), (1, 30), (12, 17), (25, 20)]))
    costs = np.zeros((rows, cols), dtype=np.uint8)
    some = rng.random(costs.shape) < draw(st.sampled_from([0.0, 0.2, 0.6]))
    costs[some] = rng.choice(VALUES, int(some.sum()))
    config = PlannerConfig(
        allow_unknown=draw(st.booleans()),
        neutral_cost=draw(st.sampled_from([1.0, 50.0])),
        cost_factor=draw(st.sampled_from([0.0, 0.8, 3.0])),
    )
    start, goal = (tuple(int(k) for k in rng.integers(0, (rows, cols))) for _ in range(2))
    costs[start] = 0
    return PlanningCase(costs, step_costs(config), (start[0], start[1]), (goal[0], goal[1]), draw(st.booleans()))


def spread_by_kernel(case: PlanningCase) -> tuple[Any, ...]:
    return (cost_to_come(case.costs, case.table, case.start, None if case.is_whole else case.goal),)


def spread_by_textbook(case: PlanningCase) -> tuple[Any, ...]:
    return (textbook.dijkstra(case.costs, case.table, case.start, None if case.is_whole else case.goal),)


def searched_cells_by_kernel(case: PlanningCase) -> tuple[Any, ...]:
    return (cost_to_come(case.costs, case.table, case.start, case.goal, use_astar=True),)


def searched_cells_by_textbook(case: PlanningCase) -> tuple[Any, ...]:
    return (textbook.a_star(case.costs, case.table, case.start, case.goal),)


def path_by_kernel(case: PlanningCase) -> tuple[Any, ...]:
    """Follow the cost to come from the goal; nothing where it cannot be reached."""
    potential = cost_to_come(case.costs, case.table, case.start, case.goal)
    if not np.isfinite(potential[case.goal]):
        return (np.zeros((0, 2), dtype=np.int64),)
    cols = case.costs.shape[1]
    ends = case.start[0] * cols + case.start[1], case.goal[0] * cols + case.goal[1]
    out = np.empty(case.costs.size, dtype=np.int32)
    n = trace_back(case.costs, case.table, potential, *ends, out)
    return (np.stack(np.divmod(out[:n][::-1].astype(np.int64), cols), axis=-1),)


def path_by_textbook(case: PlanningCase) -> tuple[Any, ...]:
    potential = textbook.dijkstra(case.costs, case.table, case.start, case.goal)
    if not np.isfinite(potential[case.goal]):
        return (np.zeros((0, 2), dtype=np.int64),)
    return (textbook.path_back(case.costs, case.table, potential, case.start, case.goal),)
