"""The path from a session's robot to a goal on the costmap, planned again after each change."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from msgspec import Struct

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap import INSCRIBED, LETHAL, NO_INFORMATION, SpeedLimit
from mapper.grid import GridGeometry
from mapper.planning import GoalPlanner, Path, follow_path
from mapper.planning.parameters import PursuitConfig
from mapper.planning.plan import travel_time
from mapper.simulation.robot import PoseTuple
from server.parts.path.messages import GoalCommand, PathMessage
from server.sessions.part import Offers, Part, Robot
from server.sessions.parts import Costing, Costs
from server.sessions.tick import TickResult
from server.stream.commands import AutoCommand, DriveCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer, TableLayer
from server.stream.protocol import ProtocolError, place_of

CONTROL_S = 0.2  #: simulated time between two decisions of the follower of a path


class PathPart(Part):
    """The goal and the path to it, along which the robot drives if possible. It ends with its costmap."""

    commands = (GoalCommand,)
    recorded = (GoalCommand,)
    subject = "costmap"
    is_on = False
    followed: Costing

    @classmethod
    def of(cls, offers: Offers) -> PathPart | None:
        """Return the part of a source with a costmap and a robot."""
        if offers.costing is None or offers.robot is None:
            return None
        return cls(offers.costing, offers.robot, offers.drive)

    def __init__(
        self,
        costing: Costing,
        robot: Callable[[], Robot],
        drive: Callable[[float, float, TickResult], None] | None,
    ) -> None:
        """``costing``, ``robot`` and ``drive`` are those of :class:`server.sessions.part.Offers`."""
        self.followed, self._robot, self._drive = costing, robot, drive
        self._begin(None)
        self._steered = -math.inf  #: when the follower was last called, simulated seconds

    def _begin(self, costs: Costs | None) -> None:
        """Start without a goal, on these costs."""
        self._costs = costs
        self._path = PathToGoal()
        self._is_stale = False  #: whether the path must be planned again
        self._revision = -1  #: of the costs on which the path was planned
        self._planned: Robot | None = None  #: the robot for which the path was planned
        self._number = -1  #: of the newest scan

    def _current(self) -> Costs | None:
        """Return the current costs. If they were replaced, remove the goal."""
        costs = self.followed.costmap
        if costs is not self._costs:
            self._begin(costs)
            self.is_on = True  # without costs, until the pages are told that there is no path any more
        return costs

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The path and its potential; empty without a costmap."""
        return () if self._costs is None else self._path.layers

    def messages(self) -> tuple[PathMessage]:
        """Return the ``path`` message."""
        return (self._path.message(),)

    def history(self) -> list[GoalCommand]:
        """Return the command that sets the goal."""
        if self._path.goal is None:
            return []
        x, y = self._path.goal
        return [GoalCommand(x, y, self._path.drives)]

    def handle(self, command: GoalCommand, result: TickResult) -> None:
        """Set the goal. Raises :class:`ProtocolError` without a costmap."""
        if self._current() is None:
            raise ProtocolError("costmap.off", "There is no costmap: it has to be begun first.")
        place = place_of(command)
        drives = self._path.drives if command.drives is None else command.drives
        self._path.head_for(None if place is None else (place[0], place[1]), drives=drives and self._drive is not None)
        self._is_stale = result.changed = True

    def note(self, command: Struct, result: TickResult) -> None:
        """Stop driving along the path when another command drives the robot."""
        if isinstance(command, DriveCommand | AutoCommand) and self._current() is not None and self._path.drives:
            self._path.drives = False
            result.slot(*self.messages())

    def advance(self, seconds: float, result: TickResult) -> float:
        """Drive as the path follower commands."""
        costs = self._current()
        if costs is None or not self._path.drives:
            return seconds
        robot = self._robot()
        if not 0.0 <= robot.time_s - self._steered < CONTROL_S - 1e-6:
            self._steer(robot, costs, result)
        return min(seconds, CONTROL_S)

    def _steer(self, robot: Robot, costs: Costs, result: TickResult) -> None:
        if self._path.limit(costs.speed_limit(robot.pose), costs.pursuit.desired_linear_vel):
            result.slot(*self.messages())
        velocities = self._path.control(robot.pose, costs.pursuit)
        if velocities is not None and self._drive is not None:
            self._steered = robot.time_s
            linear, angular = (round(float(v), 3) for v in velocities)
            self._drive(linear, angular, result)
        if not self._path.drives:
            result.slot(*self.messages())  # the robot has arrived

    def changed(self, result: TickResult) -> None:
        """Plan again if the costs, the goal or the robot have changed."""
        costs = self._current()
        if costs is None:
            self.is_on = False
            result.slot(*self.messages())
            return
        robot = self._robot()
        is_scan = robot.scan is not None and robot.number != self._number
        self._number = robot.number if is_scan else self._number
        greatest = None if self._drive is None else costs.pursuit.desired_linear_vel
        are_new = costs.revision != self._revision
        self._is_stale |= self._path.limit(costs.speed_limit(robot.pose), greatest) | are_new
        if self._is_stale or (is_scan and self._path.goal is not None and self._has_moved(robot)):
            self._is_stale, self._revision, self._planned = False, costs.revision, robot
            self._path.plan(costs, robot.pose, are_new=are_new)
            result.changed = True
            result.slot(*self.messages())
        result.changed |= self._path.draw()

    def _has_moved(self, robot: Robot) -> bool:
        before = self._planned
        return before is None or any(abs(a - b) > 1e-3 for a, b in zip(robot.pose, before.pose, strict=True))


part_of = PathPart.of


ARRIVED_M = 0.12  #: distance from the end of the path at which the robot has arrived
PASSABLE = INSCRIBED - 1
Goal = tuple[float, float]


class PathToGoal:
    """The goal, the path to it, and whether the robot drives along it. ``message`` is what the page shows of it."""

    def __init__(self) -> None:
        self.goal: Goal | None = None
        self.drives = False
        self._path: Path | None = None
        self._planner: GoalPlanner | None = None
        self._shown: Float64Array | None = None  #: the potential in the layer
        self._reason: str | None = None
        self._travel_s: float | None = None
        self._carrot: Goal | None = None
        self._plan_ms = 0.0
        self._limit: SpeedLimit | None = None
        self._limit_words: str | None = None
        self._line = TableLayer("plan", "Path", "plan", ("x", "y"), "path")
        self._potential = GridLayer("potential", "Potential", "potential")
        self._potential.is_on_demand = True
        self._geometry: GridGeometry | None = None  #: of the costs in which a path was first found; None before

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The path, and the potential if there is one."""
        return (self._line,) if self._geometry is None else (self._line, self._potential)

    def head_for(self, goal: Goal | None, *, drives: bool) -> None:
        """Set the goal in map metres; None removes it."""
        self.goal, self.drives = goal, drives and goal is not None
        self._carrot = None

    def limit(self, limit: SpeedLimit | None, greatest: float | None) -> bool:
        """Set the speed limit at the robot's place; return whether its text has changed.

        ``greatest`` is the robot's speed without a limit, m/s, None if nothing drives.
        """
        before, self._limit = self._limit_words, limit
        if limit is None or limit.limit is None:
            self._limit_words = None
        else:
            unit = "%" if limit.percentage else "m/s"
            resulting = f": {limit.of(greatest):.2f} m/s" if limit.percentage and greatest is not None else ""
            self._limit_words = f"{limit.limit:g} {unit}{resulting}"
        return before != self._limit_words

    def plan(self, costs: Costs, pose: PoseTuple, *, are_new: bool = True) -> None:
        """Plan the path from the robot's pose, and store the reason if there is none.

        Unless ``are_new``, the costs are those of the last call. If the robot and the planner's parameters are
        unchanged too, the path to a moved goal is traced in the existing cost to come.
        """
        self._path = self._reason = self._travel_s = None
        started = time.perf_counter()
        if self.goal is None:
            self._planner = None
        else:
            try:
                planner = self._planner
                if are_new or planner is None or planner.config != costs.planner or not planner.begins_at(pose[:2]):
                    own = costs.costs
                    begun = _with_room(own, costs.geometry, pose, costs.radius)
                    begun = begun.copy() if begun is own else begun  # the costmap keeps writing its own array
                    self._planner = planner = GoalPlanner(begun, costs.geometry, pose[:2], costs.planner)
                self._path = planner.plan(pose[:2], self.goal)
                greatest = costs.pursuit.desired_linear_vel
                self._travel_s = travel_time(self._path.points, greatest, costs.speed_filters)
                if not self._path.reaches_goal:
                    away = math.dist(self._path.points[-1], self.goal)
                    self._reason = f"The robot cannot be at the goal itself: the path ends {away:.2f} m before it."
            except ConfigError as error:
                self._reason = error.message
        self._plan_ms = 1e3 * (time.perf_counter() - started)
        path = self._path
        self._line.set(np.zeros((2, 0)) if path is None else path.points.T)
        if path is not None or self._geometry is not None:
            self._geometry = costs.geometry

    def draw(self) -> bool:
        """Write a new potential into its layer if the layer is watched; return whether it was written."""
        potential = None if self._path is None else self._path.potential
        if self._geometry is None or not self._potential.is_watched or potential is self._shown:
            return False
        self._shown = potential
        shares = np.full(self._geometry.shape, 255, dtype=np.uint8)
        if potential is not None:
            known = potential < math.inf
            scale = 254.0 / max(float(potential.max(where=known, initial=0.0)), 1.0)
            np.multiply(potential, scale, out=shares, where=known, casting="unsafe")
        self._potential.set_bytes(self._geometry, shares)
        return True

    def control(self, pose: PoseTuple, pursuit: PursuitConfig) -> tuple[float, float] | None:
        """Return the velocities (m/s, rad/s) of a robot that drives along the path; None if it does not drive."""
        path = self._path
        if not self.drives or path is None:
            self._carrot = None
            return None
        if math.dist(path.points[-1], pose[:2]) < ARRIVED_M:
            self.drives, self._carrot = False, None
            return (0.0, 0.0)
        if self._limit is not None:
            pursuit = replace(pursuit, desired_linear_vel=self._limit.of(pursuit.desired_linear_vel))
        command = follow_path(path.points, pose, pursuit)
        self._carrot = command.carrot
        return command.linear, command.angular

    def message(self) -> PathMessage:
        """Return the ``path`` message."""
        path = self._path
        return PathMessage(
            goal=_rounded(self.goal),
            drives=self.drives,
            length=None if path is None else round(path.length, 3),
            cost=None if path is None else round(path.cost, 1),
            travel_s=None if path is None or self._travel_s is None else round(self._travel_s, 2),
            reaches_goal=path is not None and path.reaches_goal,
            reason=self._reason,
            carrot=_rounded(self._carrot),
            plan_ms=round(self._plan_ms, 2),
            speed_limit=self._limit_words,
        )


def _rounded(place: Goal | None) -> Goal | None:
    return None if place is None else (round(place[0], 3), round(place[1], 3))


def _with_room(costs: UInt8Array, geometry: GridGeometry, pose: PoseTuple, radius: float) -> UInt8Array:
    """Return costs with a way out for a robot that stands where its costmap does not allow it.

    If its cell is blocked, the blocked cells within ``radius`` m become passable. NavFn frees only the start cell.
    """
    row, col = (int(k) for k in geometry.world_to_cell(pose[:2]))
    if not geometry.contains((row, col)) or costs[row, col] < INSCRIBED:
        return costs
    reach = math.ceil(radius / geometry.resolution)
    top, left = max(row - reach, 0), max(col - reach, 0)
    out = costs.copy()
    near = out[top : row + reach + 1, left : col + reach + 1]
    rows, cols = np.indices(near.shape)
    within = np.hypot(rows + top - row, cols + left - col) <= reach
    blocked = (near == INSCRIBED) | (near == LETHAL) | (near == NO_INFORMATION)
    near[within & blocked] = PASSABLE
    return out
