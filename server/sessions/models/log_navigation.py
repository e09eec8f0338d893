"""The costmap over a log's map, and the path from its robot to a goal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError
from mapper.costmap import Footprint
from mapper.costmap.nav2_parameters import nav2_yaml, parse_nav2_costmap
from mapper.grid import CellBox
from mapper.io.costmaps import RecordedCostmap
from mapper.io.maps.reading import grid_of_values
from mapper.planning.nav2_parameters import nav2_path_yaml, parse_nav2_planner, parse_nav2_pursuit
from server.sessions.models.lab_costmap import LabCostmap, StaticMap, strokes_of
from server.sessions.models.lab_navigation_parameters import MOST_CORNERS, LabParameters, from_nav2, rows_with
from server.sessions.models.lab_path import LabPath
from server.sessions.models.navigation_messages import COMMANDS, commands_of, cost_message, costmap_message
from server.sessions.tick import TickResult
from server.stream.layers import Layer
from server.stream.protocol import ProtocolError, number, text, values

if TYPE_CHECKING:
    from server.library.given_map import GivenMap
    from server.sessions.models.log_recording import LogRecording

MOST_CELLS = 4_000_000  #: of the map: each costmap holds a dozen grids of its size
_OF_THE_LAB = ("desired_linear_vel", "lookahead_dist")  #: nothing drives
ROWS = rows_with(
    "Which map the static layer has: the log's own, or the map of the group Localize, for poses in that map.",
    ("belief", "given"),
    _OF_THE_LAB,
)


class LogNavigation:
    """The costmap and the path of a log, from its command ``costmap`` on until the same command ends them.

    The path begins at the robot of the newest scan in the map.
    """

    def __init__(self, recording: LogRecording, given_map: Callable[[], GivenMap | None]) -> None:
        """``given_map`` returns the map that the log is localized in."""
        self._recording, self._given_map = recording, given_map
        self._given: GivenMap | None = None  #: which the static layer has
        self._costmap: LabCostmap | None = None
        self._path = LabPath()
        self._index = -1  #: of the scan that the layers of obstacles saw last
        self._is_new = False  #: whether the costs have to be brought up to date, and the path with them
        self._is_stale = False  #: whether the path has to be planned anew

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The costs, the sheets, the path and its potential; none while it is off."""
        return () if self._costmap is None else (*self._costmap.layers, *self._path.layers)

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds."""
        return 0 if self._costmap is None else self._costmap.cells

    def obey(self, command: dict[str, Any], result: TickResult) -> bool:
        """Carry out a command for the costmap or the path; return whether it was one.

        Raises :class:`ProtocolError` and :class:`ConfigError`; nothing has changed then.
        """
        if command["type"] not in COMMANDS:
            return False
        costmap = self._costmap
        if command["type"] == "costmap":
            self._set(command, result)
        elif costmap is None:
            raise ProtocolError("costmap.off", "There is no costmap: it has to be begun first.")
        elif command["type"] == "goal":
            place = (number(command, "x"), number(command, "y")) if command.get("x") is not None else None
            self._path.head_for(place, drives=False)
            self._is_stale = True
        elif command["type"] == "cost":
            x, y = number(command, "x"), number(command, "y")
            result.answer(cost_message(x, y, costmap.why(x, y)))
        else:
            self._exchange(costmap, command, result)
        result.changed = True
        return True

    def _set(self, command: dict[str, Any], result: TickResult) -> None:
        grid, costmap = self._recording.replay.grid, self._costmap
        if not command.get("value", True):
            self._end(result)
            return
        n = grid.geometry.rows * grid.geometry.cols
        if n > MOST_CELLS:
            message = f"The map has {n} cells, and a costmap at most {MOST_CELLS}; choose a coarser resolution."
            raise ConfigError("costmap.too_large", message)
        parameters = LabParameters() if costmap is None else costmap.parameters
        wanted = values({"values": {}} | command)
        if wanted.get("map", "belief") not in ("belief", "given"):
            raise ConfigError(
                "costmap.map", "A log has no plan of its world: its static map is its own or a given one."
            )
        parameters = parameters.with_values(wanted)
        corners = command.get("footprint")
        if corners is not None:
            if len(corners) > MOST_CORNERS:
                raise ConfigError("footprint.vertices", f"A footprint has at most {MOST_CORNERS} corners here.")
            parameters = replace(parameters, footprint=Footprint(tuple((x, y) for x, y in corners)))
        strokes = None if command.get("keepout") is None else strokes_of(command["keepout"])
        if costmap is None:
            self._costmap = costmap = LabCostmap(grid, self._plan, parameters)
            self._index = -1
        elif parameters != costmap.parameters:
            costmap.change(parameters, grid, self._plan)
        if strokes is not None:
            costmap.paint(strokes)
        self._is_new = True
        for own in self.messages():
            result.slot(own)

    def _end(self, result: TickResult) -> None:
        self._costmap, self._path = None, LabPath()
        for own in self.messages():
            result.slot(own)

    def _plan(self) -> StaticMap:
        """Return the map that the log is localized in."""
        given = self._given_map()
        if given is None:
            raise ConfigError("costmap.no_given_map", "There is no given map: choose one in the group Localize.")
        if given.values.size > MOST_CELLS:
            message = f"The given map has {given.values.size} cells, and a costmap at most {MOST_CELLS}."
            raise ConfigError("costmap.too_large", message)
        self._given = given
        return StaticMap(grid_of_values(given.geometry, given.values), given.keepout)

    def _exchange(self, costmap: LabCostmap, command: dict[str, Any], result: TickResult) -> None:
        """Answer with the parameters as Nav2's yaml, or take them from one."""
        if command.get("text") is None:
            parts = nav2_yaml(costmap.parameters.nav2, costmap.geometry.resolution)
            path = nav2_path_yaml(costmap.parameters.planner, costmap.parameters.pursuit)
            result.answer({"type": "nav2", "text": parts + path})
            return
        data = text(command, "text").encode()
        found = from_nav2(
            costmap.parameters, parse_nav2_costmap(data), parse_nav2_planner(data), parse_nav2_pursuit(data)
        )
        costmap.change(found, self._recording.replay.grid, self._plan)
        self._is_new = True
        result.slot(self.messages()[0])
        result.answer({"type": "nav2", "text": None})

    def draw(self, box: CellBox | None, result: TickResult, *, whole: bool) -> None:
        """Follow what changed in the map, look at a new scan, and plan anew."""
        costmap, replay = self._costmap, self._recording.replay
        if costmap is None:
            return
        if costmap.parameters.values["map"] == "given" and self._given is not self._given_map():
            try:
                costmap.renew_plan(self._plan(), replay.grid)
                self._is_new = True
            except ConfigError as error:  # the costmap keeps the map from before
                self._given = self._given_map()
                result.notice(error.code, error.message)
        n = replay.grid.geometry.rows * replay.grid.geometry.cols
        if n > MOST_CELLS and costmap.parameters.values["map"] == "belief":
            self._end(result)
            result.notice(
                "costmap.too_large", f"The map has {n} cells now, and a costmap at most {MOST_CELLS}: it has ended."
            )
            return
        if replay.index < self._index:
            costmap.begin(replay.grid)  # what later scans marked is not known yet
        else:
            costmap.follow(replay.grid, box, whole=whole)
        robot = self._recording.robot_state()
        if replay.index != self._index:
            self._index, self._is_new = replay.index, True
            costmap.look(robot.scan, robot.scan_pose)
        are_new = self._is_new or whole
        if are_new:
            self._is_new, self._is_stale = False, True
            costmap.update(robot.scan.stamp_ns * 1e-9, robot.pose)
        if not self._is_stale:
            return
        self._is_stale = False
        self._path.plan(costmap.costs, costmap.geometry, robot.pose, costmap.parameters, are_new=are_new)
        result.changed = True
        result.slot(self._path.message())

    def commands(self) -> list[dict[str, Any]]:
        """Return the commands from which another session gets the same costmap and goal."""
        return commands_of(self._costmap, self._path)

    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs."""
        recording = self._recording
        stamp_s = recording.robot_state().scan.stamp_ns * 1e-9
        return None if self._costmap is None else self._costmap.recorded(stamp_s, None)

    def present_mask(self) -> Int8Array | None:
        """Return the mask of the keepout zones."""
        return None if self._costmap is None else self._costmap.mask

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages ``costmap`` and ``path``."""
        return [costmap_message(self._costmap), self._path.message()]
