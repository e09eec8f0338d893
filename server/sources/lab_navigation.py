"""Navigation in the lab: the costmap of the simulated robot, and the path to a goal on it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from msgspec import Struct

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.io.costmaps import RecordedCostmap
from mapper.mapping.integrate import Change
from mapper.sensors.scan import RangeScan
from mapper.simulation.live_map import LiveMap
from mapper.simulation.plan_map import plan_map
from mapper.simulation.robot import PoseTuple
from server.sessions.part import Offers
from server.sessions.parts import LayerCosts
from server.sessions.tick import TickResult
from server.sessions.view import as_pose
from server.sources.lab_costmap import StaticMap
from server.sources.lab_navigation_parameters import LabParameters, rows_with
from server.sources.navigation import Navigation
from server.sources.simulation_commands import act
from server.stream.commands import AutoCommand, DriveCommand, GoalCommand, RestartCommand, WorldCommand

ROWS = rows_with(
    "Which map the static layer has: the belief as it changes, the plan of the world as it was when chosen, or the "
    "3D map from above or the classes of its terrain, as long as there are such.",
    ("belief", "plan", "map_3d", "terrain"),
)
CONTROL_S = 0.2  #: simulated time between two decisions of the follower of a path


def believed_now(mapper: LiveMap) -> PoseTuple:
    """Return where the robot takes itself to be in the map now.

    Its true motion since the newest scan is added: the drift in a tenth of a second is negligible.
    """
    since = compose(inverse(np.array(mapper.newest_pose)), np.array(mapper.simulation.pose))
    return as_pose(compose(mapper.believed_pose, since))


class LabNavigation(Navigation):
    """The costmap and the path of a simulation, along which the robot drives."""

    def __init__(
        self,
        mapper: LiveMap,
        offers: Offers,
    ) -> None:
        """``offers`` has the maps that the static layer may have, and the costs of the terrain's layer."""
        super().__init__()
        self.tables = {"navigation": ROWS}
        self._mapper = mapper
        self._others = offers.maps
        self._terrain = offers.costs.get("terrain_layer", lambda: None)
        self._laid: LayerCosts | None = None  #: the terrain in the costmap
        self._followed: OccupancyGrid | None = None  #: the other map that the static layer has
        self._seen: RangeScan | None = None
        self._pose: PoseTuple | None = None
        self._steered = -math.inf  #: when the follower was last asked, simulated seconds

    @property
    def is_driving(self) -> bool:
        """Whether the robot drives along the path."""
        return self._costmap is not None and self._path.drives

    def advance(self, seconds: float, result: TickResult) -> Iterator[Change]:
        """Let the simulated time pass, and drive as the follower of the path wants; yield what each scan changed."""
        left = seconds
        while left > 0.0:
            step = min(left, CONTROL_S) if self.is_driving else left
            left -= step
            self._steer(result)
            yield from self._mapper.advance(step)

    def _steer(self, result: TickResult) -> None:
        time = self._mapper.simulation.time
        if self._costmap is None or not self.is_driving or 0.0 <= time - self._steered < CONTROL_S - 1e-6:
            return
        pose, parameters = believed_now(self._mapper), self._costmap.parameters
        if self._path.limit(self._costmap.speed_limit(pose), parameters.pursuit.desired_linear_vel):
            result.slot(self._path.message())
        velocities = self._path.control(pose, parameters)
        if velocities is not None:
            self._steered = time
            linear, angular = (round(float(v), 3) for v in velocities)
            act(self._mapper, DriveCommand(linear, angular), result)
        if not self._path.drives:
            result.slot(self._path.message())  # it has arrived

    def note(self, command: Struct, result: TickResult) -> None:
        """Stop driving along the path where the robot is driven by other commands; end in another world."""
        if isinstance(command, WorldCommand | RestartCommand):
            self.end(result)
        elif isinstance(command, DriveCommand | AutoCommand) and self.is_driving:
            self._path.drives = False
            result.slot(self._path.message())

    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs."""
        return None if self._costmap is None else self._costmap.recorded(self._mapper.simulation.time, None)

    def _check(self, wanted: Mapping[str, Any]) -> None:
        if wanted.get("map") == "given":
            raise ConfigError("costmap.map", "A simulation has no given map: its static map is the belief or the plan.")

    def _map(self, parameters: LabParameters) -> OccupancyGrid:
        """Return the map of the static layer: the belief, or another one where that is chosen and there."""
        other = self._others.get(parameters.values["map"], lambda: None)()
        return self._mapper.grid if other is None else other

    def _plan(self) -> StaticMap:
        return StaticMap(plan_map(self._mapper.simulation.world))

    def _forget_scans(self) -> None:
        self._laid = None
        self._seen = None

    def _drives(self, command: GoalCommand) -> bool:
        return self._path.drives if command.drives is None else command.drives

    def changed(self, result: TickResult) -> None:
        """Follow what changed in the map, look at a new scan, and plan again."""
        costmap, box, whole = self._costmap, result.box, result.new_grid
        if costmap is None:
            return
        mapper, pose = self._mapper, believed_now(self._mapper)
        grid = self._map(costmap.parameters)
        if grid is not mapper.grid or self._followed is not None:
            box, whole = None if grid is not mapper.grid else box, whole or grid is not self._followed
            self._is_new |= whole
            self._followed = None if grid is mapper.grid else grid
        costmap.follow(grid, box, whole=whole)
        terrain = self._terrain()
        if terrain is not self._laid:
            self._laid, self._is_new = terrain, True
            costmap.lay_terrain(terrain)
        scan = mapper.newest
        is_scan = not mapper.hidden and scan is not None and scan is not self._seen
        if is_scan and scan is not None:
            self._seen = scan
            costmap.look(scan, compose(mapper.believed_pose, mapper.simulation.mount))
        are_new = self._is_new or whole
        if is_scan or are_new:
            self._is_new = False
            are_new |= costmap.update(mapper.simulation.time, pose)
            self._is_stale |= are_new
        moved = self._pose is None or any(abs(a - b) > 1e-3 for a, b in zip(pose, self._pose, strict=True))
        greatest = costmap.parameters.pursuit.desired_linear_vel
        self._is_stale |= self._path.limit(costmap.speed_limit(pose), greatest)
        if self._is_stale or (moved and is_scan and self._path.goal is not None):
            self._is_stale, self._pose = False, pose
            limits = costmap.speed_filters
            self._path.plan(costmap.costs, costmap.geometry, pose, costmap.parameters, limits, are_new=are_new)
            result.changed = True
            result.slot(self._path.message())
        result.changed |= self._path.draw()
