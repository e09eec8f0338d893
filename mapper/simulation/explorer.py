"""Explorer: chooses the robot's goals and plans the paths to them.

Goals are places that the robot has not been near for the longest time; paths prefer the middle of free space.
:mod:`mapper.simulation.kernels.driving` follows them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.grid import GridGeometry
from mapper.simulation.kernels.driving import ARRIVED, CAREFUL, MARGIN
from mapper.simulation.kernels.raycast import chord_clearance
from mapper.simulation.kernels.shortest_paths import relax, shortest_paths
from mapper.simulation.robot import PoseTuple, Robot
from mapper.simulation.worlds import World, clearance_lattice

VISITED_RADIUS = 1.1  # metres around the robot that count as visited
COMFORT = 0.55  # metres of clearance beyond which a path has no further benefit
GOAL_CLEARANCE = 0.15  # required clearance of a goal in metres beyond the radius
GOALS_TRIED = 48
ENTRIES_TRIED = 32  # cells considered as the start of a path
EASY_CLEARANCE = 0.15  # minimum clearance of a relaxed path in metres beyond the radius
RELAXATIONS = 40  # rounds
SPACING = 0.1  # metres between the points of a path, counted by the lookahead


@lru_cache(maxsize=16)
def _centres_of(lattice: GridGeometry) -> Float64Array:
    """Return the centres (rows, cols, 2) of the cells of a lattice, metres, shared by all robots in one world."""
    centres = lattice.cell_to_world(np.stack(np.meshgrid(*map(np.arange, lattice.shape), indexing="ij"), axis=-1))
    centres.setflags(write=False)
    return centres


@dataclass(frozen=True, slots=True)
class _Passable:
    """Cells of a world in which a robot can drive; shared by all robots of one radius.

    ``cells`` (n, 2) are the cells that a path may pass, ``centres`` (n, 2) their centres, metres; ``cost`` (rows, cols)
    is the cost per metre, +inf if impassable; ``goals`` (m,) are the possible goal cells, row · cols + col.
    """

    cells: NDArray[np.int64]
    centres: Float64Array
    cost: Float64Array
    goals: NDArray[np.int64]


@lru_cache(maxsize=16)
def _passable(world: World, radius: float) -> _Passable:
    """Return the cells in which a robot of ``radius`` metres can drive."""
    lattice = clearance_lattice(world)
    clearance = lattice.clearance
    passes = clearance >= radius + MARGIN
    crowding = np.clip((COMFORT - clearance) / (COMFORT - radius), 0.0, 1.0)
    cells = np.argwhere(passes)
    return _Passable(
        cells,
        _centres_of(lattice.geometry)[cells[:, 0], cells[:, 1]],
        np.where(passes, 1.0 + 6.0 * crowding**2, np.inf),
        np.flatnonzero(clearance >= radius + GOAL_CLEARANCE),
    )


@dataclass(slots=True)
class Explorer:
    """Plans the paths of one robot in one world. ``rng`` chooses between goals.

    ``visited`` (rows, cols) is the time in seconds at which the robot was last near each cell of the world's lattice.
    """

    world: World
    rng: np.random.Generator
    visited: Float64Array = field(init=False)
    path: Float64Array = field(init=False)  #: (n, 2), metres, the remaining path; empty before the first goal
    #: Position (m, m) and time (s) of the robot's last progress.
    progress: tuple[float, float, float] = field(init=False, default=(0.0, 0.0, 0.0))
    _centres: Float64Array = field(init=False)

    def __post_init__(self) -> None:
        lattice = clearance_lattice(self.world)
        self.visited = np.full(lattice.clearance.shape, -300.0)  # never visited counts as five minutes before the start
        self.path = np.empty((0, 2))
        self._centres = _centres_of(lattice.geometry)

    def enter(self, world: World) -> None:
        """Continue in a modified world with the same bounds: visits are kept, the goal is dropped."""
        self.world = world
        self.forget_path()

    def forget_path(self) -> None:
        """Drop the goal, because the robot was moved or steered manually."""
        self.path = np.empty((0, 2))

    def note(self, pose: PoseTuple, time: float) -> None:
        """Record that the robot is at ``pose`` at ``time`` seconds."""
        x0, y0 = self.world.bounds[:2]
        step = clearance_lattice(self.world).geometry.resolution
        reach = int(VISITED_RADIUS / step)
        row, col = int((pose[1] - y0) / step), int((pose[0] - x0) / step)
        rows, cols = slice(max(0, row - reach), row + reach + 1), slice(max(0, col - reach), col + reach + 1)
        near = np.hypot(*(self._centres[rows, cols] - pose[:2]).transpose(2, 0, 1)) <= VISITED_RADIUS
        self.visited[rows, cols][near] = time

    def plan(self, robot: Robot, time: float) -> None:
        """Choose a goal and the path to it, which is empty if there is none."""
        self.path = self._plan(robot, time)
        self.progress = (*robot.pose[:2], time)

    def _plan(self, robot: Robot, time: float) -> Float64Array:
        """Return a path (n, 2), metres, to the goal with the maximum gain minus cost; empty if there is none."""
        passable = _passable(self.world, robot.radius)
        cost = passable.cost
        row, col = self._entry(robot, passable)
        distance, parent = np.empty(cost.shape), np.empty(cost.shape, dtype=np.int64)
        shortest_paths(cost, row, col, distance, parent)
        metres = distance.ravel()[passable.goals] * clearance_lattice(self.world).geometry.resolution
        candidates = np.flatnonzero((metres < np.inf) & (metres > 2.0 * ARRIVED))
        if not len(candidates):
            return np.empty((0, 2))
        chosen = candidates[self.rng.integers(len(candidates), size=GOALS_TRIED)]
        rows, cols = divmod(passable.goals[chosen], cost.shape[1])
        # Seconds since the last visit, minus twice the seconds needed to go there.
        worth = (time - self.visited[rows, cols]) - 2.0 * metres[chosen] / CAREFUL
        goal = int(np.argmax(worth))
        return self._smoothed(self._cells_to(int(rows[goal]), int(cols[goal]), parent), robot)

    def _entry(self, robot: Robot, passable: _Passable) -> tuple[int, int]:
        """Return the passable cell nearest to the robot that it can reach in a straight line."""
        x, y, _ = robot.pose
        if not len(passable.cells):
            return 0, 0
        cell = self._cell_at(passable, x, y)
        if cell is not None and self._can_enter(self._centres[cell].tolist(), robot):
            return cell
        gaps = np.hypot(passable.centres[:, 0] - x, passable.centres[:, 1] - y)
        near = np.arange(len(gaps))
        if len(gaps) > ENTRIES_TRIED:
            near = np.flatnonzero(gaps <= np.partition(gaps, ENTRIES_TRIED - 1)[ENTRIES_TRIED - 1])
        order = near[np.argsort(gaps[near], kind="stable")][:ENTRIES_TRIED].tolist()
        places = passable.centres[order].tolist()
        index = next((i for i, place in zip(order, places, strict=True) if self._can_enter(place, robot)), order[0])
        row, col = passable.cells[index].tolist()
        return row, col

    def _cell_at(self, passable: _Passable, x: float, y: float) -> tuple[int, int] | None:
        """Return the passable cell nearest to (x, y) if the cell that contains (x, y) is passable, else None."""
        (x0, y0), (rows, cols) = self.world.bounds[:2], passable.cost.shape
        step = clearance_lattice(self.world).geometry.resolution
        row, col = int((y - y0) / step), int((x - x0) / step)
        if not (0 <= row < rows and 0 <= col < cols and passable.cost[row, col] < np.inf):
            return None
        first_row, first_col = max(row - 1, 0), max(col - 1, 0)  # on a border rounding decides
        around = np.s_[first_row : row + 2, first_col : col + 2]
        gaps = np.hypot(self._centres[around][..., 0] - x, self._centres[around][..., 1] - y)
        nearest = int(np.argmin(np.where(passable.cost[around] < np.inf, gaps, np.inf)))
        return first_row + nearest // gaps.shape[1], first_col + nearest % gaps.shape[1]

    def _can_enter(self, place: Sequence[float], robot: Robot) -> bool:
        """Return whether the robot can drive straight to a position (2,), metres."""
        (x, y, _), (to_x, to_y) = robot.pose, place
        return chord_clearance(self.world.segments, x, y, to_x, to_y) >= robot.radius

    def _cells_to(self, row: int, col: int, parent: NDArray[np.int64]) -> Float64Array:
        """Return the centres (n, 2) of the cells from the start to (row, col)."""
        cells = []
        cell, cols = row * parent.shape[1] + col, parent.shape[1]
        while cell >= 0:
            cells.append((cell // cols, cell % cols))
            cell = int(parent[cell // cols, cell % cols])
        rows, columns = np.array(cells[::-1]).T
        return np.asarray(self._centres[rows, columns], dtype=np.float64)

    def _smoothed(self, path: Float64Array, robot: Robot) -> Float64Array:
        """Return the path with relaxed corners, without reducing its clearance below the margin or its initial
        value.
        """
        path = path.copy()
        relax(self.world.segments, self.world.bounds, path, robot.radius + EASY_CLEARANCE, RELAXATIONS)
        # Evenly spaced points, because the lookahead counts them.
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        even = np.linspace(0.0, along[-1], max(2, round(along[-1] / SPACING) + 1))
        return np.stack([np.interp(even, along, path[:, axis]) for axis in (0, 1)], axis=-1)
