"""The costmap over a log's map, and the path from its robot to a goal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.io.costmaps import RecordedCostmap
from mapper.io.maps.reading import grid_of_values
from server.parts.terrain.costs import meets
from server.sessions.commands import UseTerrain
from server.sessions.parts import UploadedCosts
from server.sessions.tick import TickResult
from server.sources.lab_costmap import StaticMap
from server.sources.lab_navigation_parameters import LabParameters, rows_with
from server.sources.navigation import Navigation, OfNavigation
from server.stream.commands import GoalCommand

if TYPE_CHECKING:
    from server.library.packs.given_map import GivenMap
    from server.sources.log_recording import LogRecording

LOCALIZED = "localized"  #: the trajectory of poses that were found in the given map
MOST_CELLS = 4_000_000  #: of the map: each costmap holds a dozen grids of its size
_OF_THE_LAB = ("desired_linear_vel", "lookahead_dist")  #: nothing drives
ROWS = rows_with(
    "Which map the static layer has: the log's own, or the map of the group Localize, for poses in that map.",
    ("belief", "given"),
    _OF_THE_LAB,
)


class LogNavigation(Navigation):
    """The costmap and the path of a log. The path begins at the robot of the newest scan in the map."""

    commands = (*Navigation.commands, UseTerrain)

    def __init__(self, recording: LogRecording, given_map: Callable[[], GivenMap | None]) -> None:
        """``given_map`` returns the map that the log is localized in."""
        super().__init__()
        self.tables = {"navigation": ROWS}
        self._recording, self._given_map = recording, given_map
        self._given: GivenMap | None = None  #: which the static layer has
        self._index = -1  #: of the scan that the layers of obstacles saw last
        self._terrain: UploadedCosts | None = None
        self._laid: UploadedCosts | None = None  #: the terrain in the costmap

    def _first_values(self) -> dict[str, Any]:
        """Return the given map as the static one, where the poses in use are those that were found in it."""
        given = self._given_map()
        if given is None or given.values.size > MOST_CELLS or self._recording.trajectory != LOCALIZED:
            return {}
        return {"map": "given"}

    def _check(self, wanted: Mapping[str, Any]) -> None:
        geometry = self._recording.replay.grid.geometry
        n = geometry.rows * geometry.cols
        if n > MOST_CELLS:
            message = f"The map has {n} cells, and a costmap at most {MOST_CELLS}; choose a coarser resolution."
            raise ConfigError("costmap.too_large", message)
        if wanted.get("map", "belief") not in ("belief", "given"):
            raise ConfigError(
                "costmap.map", "A log has no plan of its world: its static map is its own or a given one."
            )

    def _map(self, parameters: LabParameters) -> OccupancyGrid:  # noqa: ARG002 - a given map is no belief, but a plan
        return self._recording.replay.grid

    def _forget_scans(self) -> None:
        self._index = -1
        self._laid = None

    def _drives(self, command: GoalCommand) -> bool:  # noqa: ARG002 - the robot of a log drives as recorded
        return False

    def _plan(self) -> StaticMap:
        """Return the map that the log is localized in."""
        given = self._given_map()
        if given is None:
            raise ConfigError("costmap.no_given_map", "There is no given map: choose one in the group Localize.")
        if given.values.size > MOST_CELLS:
            message = f"The given map has {given.values.size} cells, and a costmap at most {MOST_CELLS}."
            raise ConfigError("costmap.too_large", message)
        self._given = given
        return StaticMap(grid_of_values(given.geometry, given.values), given.keepout, given.speed)

    def changed(self, result: TickResult) -> None:
        """Follow what changed in the map, look at a new scan, and plan again."""
        costmap, replay, box, whole = self._costmap, self._recording.replay, result.box, result.new_grid
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
            self.end(result)
            result.notice(
                "costmap.too_large", f"The map has {n} cells now, and a costmap at most {MOST_CELLS}: it has ended."
            )
            return
        if replay.index < self._index:
            costmap.begin(replay.grid)  # what later scans marked is not known yet
        else:
            costmap.follow(replay.grid, box, whole=whole)
        if self._terrain is not self._laid:
            self._laid, self._is_new = self._terrain, True
            costmap.lay_terrain(self._terrain)
        robot = self._recording.robot_state()
        if replay.index != self._index:
            self._index, self._is_new = replay.index, True
            costmap.look(robot.scan, robot.scan_pose)
        are_new = self._is_new or whole
        if are_new:
            self._is_new, self._is_stale = False, True
            costmap.update(robot.scan.stamp_ns * 1e-9, robot.pose)
        self._is_stale |= self._path.limit(costmap.speed_limit(robot.pose), None)
        if self._is_stale:
            self._is_stale = False
            limits = costmap.speed_filters
            self._path.plan(costmap.costs, costmap.geometry, robot.pose, costmap.parameters, limits, are_new=are_new)
            result.changed = True
            result.slot(self._path.message())
        result.changed |= self._path.draw()

    def handle(self, command: OfNavigation | UseTerrain, result: TickResult) -> None:
        """Carry out a command; of the service, take the costs of an upload for the terrain's layer."""
        if not isinstance(command, UseTerrain):
            super().handle(command, result)
            return
        result.changed = True
        terrain = self._terrain = command.terrain
        costmap = self._costmap
        geometry = self._recording.replay.grid.geometry if costmap is None else costmap.geometry
        if terrain is not None and not meets(terrain, geometry):
            message = "The terrain has no known cell within the costmap: are both in one frame?"
            result.notice("terrain.elsewhere", message)

    def history(self) -> list[dict[str, Any]]:
        """Return the commands from which another session gets the same costmap, goal and terrain.

        The command ``use_terrain`` names the upload, which the service then reads.
        """
        found = super().history()
        if found and self._terrain is not None:
            found.append({"type": "use_terrain", "log": self._terrain.log_id})
        return found

    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs."""
        recording = self._recording
        stamp_s = recording.robot_state().scan.stamp_ns * 1e-9
        return None if self._costmap is None else self._costmap.recorded(stamp_s, None)
