"""Cheapest path between two points on a costmap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import INSCRIBED, LETHAL, NO_INFORMATION, name_of_cost
from mapper.costmap.speed_filter import SpeedFilter
from mapper.grid.occupancy_grid import GridGeometry
from mapper.planning.kernels.search import search, spread
from mapper.planning.kernels.steps import trace_back
from mapper.planning.parameters import PlannerConfig


def travel_time(points: Float64Array, greatest: float, filters: Sequence[SpeedFilter] = ()) -> float:
    """Return the time, s, along the path ``points`` (n, 2), map metres, at the maximum allowed speed.

    ``greatest`` is the robot's maximum speed, m/s; each segment has the lowest limit of all ``filters`` at its
    midpoint. Acceleration, turning in place and slowing down in curves are not included. Raises :class:`ConfigError`
    for a speed that is not positive.
    """
    if not 0.0 < greatest < float("inf"):
        raise ConfigError("path.speed", f"The robot’s greatest speed must be above 0 m/s, not {greatest!r:.40}.")
    lengths = np.hypot(*np.diff(points, axis=0).T)
    middles = 0.5 * (points[:-1] + points[1:])
    speeds = np.full(len(lengths), greatest)
    for filter_ in filters:
        np.minimum(speeds, filter_.speeds_along(middles, greatest), out=speeds)
    return float((lengths / speeds).sum())


HIGHEST = 253  #: the maximum cost of a straight step (NavFn: COST_OBS - 1), used for unknown cells
BLOCKED = np.inf


def step_costs(config: PlannerConfig, inscribed_passable: bool = False) -> Float64Array:
    """Return the costs (256,) of a straight step onto a cell of each value; infinity for blocked cells.

    The cost is an integer, neutral_cost + cost_factor · value, at most 253 (NavFn::setCostmap). Lethal and inscribed
    cells are blocked; ``inscribed_passable`` gives the inscribed ones the maximum cost instead.
    """
    values = np.arange(256)
    table: Float64Array = np.minimum(np.floor(config.neutral_cost + config.cost_factor * values), HIGHEST)
    table[LETHAL] = BLOCKED
    table[INSCRIBED] = HIGHEST if inscribed_passable else BLOCKED
    table[NO_INFORMATION] = HIGHEST if config.allow_unknown else BLOCKED
    return table


Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Path:
    """A path on a costmap.

    ``cells`` (n, 2), (row, col), each adjacent to the one before. ``points`` (n, 2) are their centres in map metres,
    with the given start first and, if the path ``reaches_goal``, the goal last. ``cost`` is the sum of the costs of its
    steps, ``length`` is in m. ``potential`` (rows, cols) is the cost-to-come of each cell from the start, infinity if
    the search did not reach it.
    """

    cells: Int64Array
    points: Float64Array
    cost: float
    length: float
    reaches_goal: bool
    potential: Float64Array


def plan_path(
    costs: UInt8Array,
    geometry: GridGeometry,
    start_xy: Sequence[float] | Float64Array,
    goal_xy: Sequence[float] | Float64Array,
    config: PlannerConfig | None = None,
) -> Path:
    """Return the cheapest path from ``start_xy`` to ``goal_xy``, map metres, for a robot at the centre of each cell.

    ``costs`` (rows, cols) uint8 are those of a costmap with ``geometry``. Cells have eight neighbours. A straight step
    costs neutral_cost + cost_factor · value of the cell that it leads to, a diagonal one √2 times that
    (:func:`mapper.planning.plan.step_costs`). If the goal cannot be reached, the path ends in the nearest reachable
    cell within the tolerance. Raises :class:`ConfigError` for a start or a goal that is not finite or outside the map,
    a blocked start, and if there is no path, with the reason.
    """
    return GoalPlanner(costs, geometry, start_xy, config).plan(start_xy, goal_xy)


class GoalPlanner:
    """Plans paths from one start to changing goals, on constant costs.

    The cost-to-come from the start is valid for every goal, so the path to a goal already reached is only traced back.
    For a goal beyond the searched area all cells are searched once. A* searches again for each goal.
    """

    def __init__(
        self,
        costs: UInt8Array,
        geometry: GridGeometry,
        start_xy: Sequence[float] | Float64Array,
        config: PlannerConfig | None = None,
    ) -> None:
        """Create a planner on ``costs`` (rows, cols), which must not be modified afterwards. Raises
        :class:`ConfigError`.
        """
        if costs.shape != geometry.shape or costs.dtype != np.uint8:
            message = f"The costs must be {geometry.shape} uint8, as the geometry, not {costs.shape} {costs.dtype}."
            raise ConfigError("path.costs", message)
        self.config = config or PlannerConfig()
        self._costs, self._geometry = np.ascontiguousarray(costs), geometry
        self._table = step_costs(self.config)
        self._start = _cell(geometry, start_xy, "start")
        self._found: Float64Array | None = None
        self._is_whole = False
        self._others: dict[str, Float64Array] = {}  #: cost-to-come of all cells if something else were passable

    def begins_at(self, place: Sequence[float] | Float64Array) -> bool:
        """Return whether a position, map metres, is in the cell of the start."""
        return tuple(int(k) for k in self._geometry.world_to_cell(place)) == self._start

    def plan(self, start_xy: Sequence[float] | Float64Array, goal_xy: Sequence[float] | Float64Array) -> Path:
        """Return the cheapest path to a goal, like :func:`plan_path` with the same errors. The start must be in the
        start cell.
        """
        start, costs, geometry = self._start, self._costs, self._geometry
        goal = _cell(geometry, goal_xy, "goal")
        if math.isinf(self._table[costs[start]]):
            raise ConfigError("path.start_blocked", f"The robot cannot be at the start: {_why_blocked(costs, start)}.")
        potential = self._potential(goal)
        end = goal if potential[goal] < math.inf else _nearest(geometry, potential, goal_xy, self.config.tolerance)
        if end is None:
            raise ConfigError("path.none", self._why_none(goal, potential))
        cols = geometry.cols
        out = np.empty(costs.size, dtype=np.int32)
        n = trace_back(costs, self._table, potential, start[0] * cols + start[1], end[0] * cols + end[1], out)
        cells = np.stack(np.divmod(out[:n][::-1].astype(np.int64), cols), axis=-1)
        points = geometry.cell_to_world(cells)
        if end == goal:
            points[-1] = goal_xy
        if n > 1 or end != goal:
            points[0] = start_xy
        else:  # start and goal are in the same cell
            cells, points = np.repeat(cells, 2, axis=0), np.array([start_xy, goal_xy], dtype=np.float64)
        length = float(np.hypot(*np.diff(points, axis=0).T).sum())
        return Path(cells, points, float(potential[end]), length, end == goal, potential)

    def _potential(self, goal: Cell) -> Float64Array:
        """Return the cost-to-come of the cells up to the goal, or of all reachable cells if there is no path."""
        if self.config.use_astar:
            return cost_to_come(self._costs, self._table, self._start, goal, use_astar=True)
        potential = self._found
        if potential is None:
            potential = cost_to_come(self._costs, self._table, self._start, goal)
            self._is_whole = math.isinf(potential[goal])
        elif math.isinf(potential[goal]) and not self._is_whole:
            potential = cost_to_come(self._costs, self._table, self._start, None)
            self._is_whole = True
        self._found = potential
        return potential

    def _reaches(self, goal: Cell, name: str, table: Float64Array) -> bool:
        """Return whether the goal could be reached with other step costs."""
        if name not in self._others:
            self._others[name] = cost_to_come(self._costs, table, self._start, None)
        return math.isfinite(self._others[name][goal])

    def _why_none(self, goal: Cell, potential: Float64Array) -> str:
        """Return a sentence on what would have to change for a path to the goal to exist."""
        sentence, config = "There is no path to the goal", self.config
        if math.isinf(self._table[self._costs[goal]]):
            return (
                f"{sentence}: the robot cannot be there, {_why_blocked(self._costs, goal)}, and no cell within the "
                f"tolerance of {config.tolerance:g} m can be reached."
            )
        if not config.allow_unknown and self._reaches(goal, "unknown", step_costs(PlannerConfig(allow_unknown=True))):
            return f"{sentence} without crossing unknown cells."
        if self._reaches(goal, "inscribed", step_costs(config, inscribed_passable=True)):
            return f"{sentence}: it would have to pass where the robot touches an obstacle (inscribed cells)."
        reached = int(np.isfinite(potential).sum())
        return f"{sentence}: obstacles are all around the {reached} cells that can be reached from the start."


def cost_to_come(
    costs: UInt8Array, table: Float64Array, start: Cell, goal: Cell | None, use_astar: bool = False
) -> Float64Array:
    """Return the cost-to-come (rows, cols) from ``start``, by Dijkstra's algorithm or by A*; infinity elsewhere.

    ``table`` (256,) has the costs of a straight step. The search ends when the goal's cost is known. If the goal is
    unreachable or absent (A* requires one), the result covers every reachable cell.
    """
    cols = costs.shape[1]
    least = float(table.min())
    ends = start[0] * cols + start[1], -1 if goal is None else goal[0] * cols + goal[1]
    out = np.empty(costs.shape)
    first, other = np.empty(costs.size, dtype=np.int32), np.empty(costs.size, dtype=np.int32)
    if use_astar:
        search(costs, table, *ends, least, np.empty(costs.size), first, other, out)
    else:
        width = 0.999 * least  # narrower than any step, regardless of rounding in the sums
        n = int(math.sqrt(2.0) * float(table[np.isfinite(table)].max()) / width) + 3
        spread(costs, table, *ends, width, np.empty(n, dtype=np.int32), first, other, out)
    return out


def _cell(geometry: GridGeometry, place: Sequence[float] | Float64Array, what: str) -> Cell:
    xy = np.asarray(place, dtype=np.float64)
    if xy.shape != (2,) or not np.isfinite(xy).all():
        raise ConfigError(f"path.{what}", f"The {what} must be two finite numbers, x and y in m, not {xy.tolist()}.")
    row, col = (int(k) for k in geometry.world_to_cell(xy))
    if not geometry.contains((row, col)):
        message = f"The {what} ({xy[0]:g}, {xy[1]:g}) is outside the map, which {geometry.span_text}."
        raise ConfigError(f"path.{what}_outside", message)
    return row, col


def _nearest(
    geometry: GridGeometry, potential: Float64Array, goal_xy: Sequence[float] | Float64Array, tolerance: float
) -> Cell | None:
    """Return the reachable cell with the centre nearest to the goal and at most ``tolerance`` m from it."""
    row, col = (int(k) for k in geometry.world_to_cell(goal_xy))
    reach = int(tolerance / geometry.resolution) + 2
    top, left = max(row - reach, 0), max(col - reach, 0)
    near = np.argwhere(np.isfinite(potential[top : row + reach + 1, left : col + reach + 1])) + np.array([top, left])
    if not len(near):
        return None
    distances = np.hypot(*(geometry.cell_to_world(near) - np.asarray(goal_xy)).T)
    best = int(np.argmin(distances))
    return (int(near[best, 0]), int(near[best, 1])) if distances[best] <= tolerance else None


def _why_blocked(costs: UInt8Array, cell: Cell) -> str:
    cost = int(costs[cell])
    if cost == NO_INFORMATION:
        return "its cell is unknown, and the path may not cross unknown cells"
    return f"its cell is {name_of_cost(cost)}"
