"""The path from a session's robot to a goal on the costmap, planned again when one of them changes."""

from __future__ import annotations

import math
from collections.abc import Callable

from msgspec import Struct

from server.parts.path.messages import GoalCommand, PathMessage
from server.parts.path.path import PathToGoal
from server.sessions.part import Offers, Part, Robot
from server.sessions.parts import Costing, Costs
from server.sessions.tick import TickResult
from server.stream.commands import AutoCommand, DriveCommand
from server.stream.layers import Layer
from server.stream.protocol import ProtocolError, place_of

CONTROL_S = 0.2  #: simulated time between two decisions of the follower of a path


class PathPart(Part):
    """The goal and the path to it, along which the robot drives where it can; it ends with its costmap."""

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
        """``costing``, ``robot`` and ``drive`` as :class:`server.sessions.part.Offers` has them."""
        self.followed, self._robot, self._drive = costing, robot, drive
        self._begin(None)
        self._steered = -math.inf  #: when the follower was last asked, simulated seconds

    def _begin(self, costs: Costs | None) -> None:
        """Have no goal yet, on these costs."""
        self._costs = costs
        self._path = PathToGoal()
        self._is_stale = False  #: whether the path has to be planned again
        self._revision = -1  #: of the costs that it was planned on
        self._planned: Robot | None = None  #: the robot that it was planned for
        self._number = -1  #: of the newest scan

    def _current(self) -> Costs | None:
        """Return the present costs; on others than before there is no goal yet."""
        costs = self.followed.costmap
        if costs is not self._costs:
            self._begin(costs)
            self.is_on = True  # without costs, until the pages know that there is no path any more
        return costs

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The path and its potential; none without a costmap."""
        return () if self._costs is None else self._path.layers

    def messages(self) -> tuple[PathMessage]:
        """Return the message ``path``."""
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
        """Stop driving along the path where the robot is driven by other commands."""
        if isinstance(command, DriveCommand | AutoCommand) and self._current() is not None and self._path.drives:
            self._path.drives = False
            result.slot(*self.messages())

    def advance(self, seconds: float, result: TickResult) -> float:
        """Drive as the follower of the path wants."""
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
            result.slot(*self.messages())  # it has arrived

    def changed(self, result: TickResult) -> None:
        """Plan again where the costs, the goal or the robot are others."""
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
