"""Navigation in the lab: the costmap of the simulated robot, and the path to a goal on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.costmap import Footprint
from mapper.costmap.nav2_parameters import nav2_yaml, parse_nav2_costmap
from mapper.grid import CellBox, OccupancyGrid
from mapper.io.costmaps import RecordedCostmap
from mapper.mapping.integrate import Change
from mapper.planning.nav2_parameters import nav2_path_yaml, parse_nav2_planner, parse_nav2_pursuit
from mapper.sensors.scan import RangeScan
from mapper.simulation.live_map import LiveMap
from mapper.simulation.plan_map import plan_map
from mapper.simulation.robot import PoseTuple
from server.sessions.models.lab_costmap import LabCostmap, StaticMap, strokes_of
from server.sessions.models.lab_navigation_parameters import MOST_CORNERS, LabParameters, from_nav2, rows_with
from server.sessions.models.lab_path import LabPath
from server.sessions.models.navigation_messages import commands_of, cost_message, costmap_message
from server.sessions.models.simulation_commands import act
from server.sessions.tick import TickResult
from server.sessions.view import as_pose
from server.stream.layers import Layer
from server.stream.protocol import ProtocolError, number, text, values

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


class LabNavigation:
    """The costmap and the path of a simulation, from its command ``costmap`` on until the same command ends them."""

    def __init__(self, mapper: LiveMap, others: Mapping[str, Callable[[], OccupancyGrid | None]] | None = None) -> None:
        """``others`` return maps that the static layer may have by name, another object when one has changed.

        None is returned where there is no such map.
        """
        self._mapper = mapper
        self._others = others or {}
        self._followed: OccupancyGrid | None = None  #: the other map that the static layer has
        self._costmap: LabCostmap | None = None
        self._path = LabPath()
        self._seen: RangeScan | None = None
        self._pose: PoseTuple | None = None
        self._steered = -math.inf  #: when the follower was last asked, simulated seconds
        self._is_stale = False  #: whether the path has to be planned anew
        self._is_new = False  #: whether the layers have to be brought up to date before the next scan

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The costs, the sheets, the path and its potential; none while it is off."""
        return () if self._costmap is None else (*self._costmap.layers, *self._path.layers)

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds."""
        return 0 if self._costmap is None else self._costmap.cells

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
        velocities = self._path.control(believed_now(self._mapper), self._costmap.parameters)
        if velocities is not None:
            self._steered = time
            linear, angular = (round(v, 3) for v in velocities)
            act(self._mapper, {"type": "drive", "linear": linear, "angular": angular}, result)
        if not self._path.drives:
            result.slot(self._path.message())  # it has arrived

    def stop_driving(self, result: TickResult) -> None:
        """Drive no longer: somebody else drives the robot."""
        if self.is_driving:
            self._path.drives = False
            result.slot(self._path.message())

    def end(self, result: TickResult) -> None:
        """Keep no costmap and no path any more."""
        if self._costmap is not None:
            self._costmap, self._path = None, LabPath()
            result.slot(self.messages()[0])
            result.slot(self.messages()[1])

    def commands(self) -> list[dict[str, Any]]:
        """Return the commands from which another session gets the same costmap and goal."""
        return commands_of(self._costmap, self._path)

    def present_costs(self) -> RecordedCostmap | None:
        """Return the present costs."""
        return None if self._costmap is None else self._costmap.recorded(self._mapper.simulation.time, None)

    def present_mask(self) -> Int8Array | None:
        """Return the mask of the keepout zones."""
        return None if self._costmap is None else self._costmap.mask

    # -- commands -------------------------------------------------------------------------------------------------

    def obey(self, command: dict[str, Any], result: TickResult) -> None:
        """Carry out one of :data:`COMMANDS`. Raises :class:`ProtocolError` and :class:`ConfigError`."""
        if command["type"] == "costmap":
            self._set(command, result)
            return
        if self._costmap is None:
            raise ProtocolError("costmap.off", "There is no costmap: it has to be begun first.")
        match command["type"]:
            case "goal":
                drives = command.get("drives")
                place = (number(command, "x"), number(command, "y")) if command.get("x") is not None else None
                self._path.head_for(place, drives=self._path.drives if drives is None else drives)
                self._is_stale = True
            case "cost":
                x, y = number(command, "x"), number(command, "y")
                result.answer(cost_message(x, y, self._costmap.why(x, y)))
            case "nav2":
                self._exchange(self._costmap, command, result)

    def _set(self, command: dict[str, Any], result: TickResult) -> None:
        if not command.get("value", True):
            self.end(result)
            return
        costmap = self._costmap
        parameters = LabParameters() if costmap is None else costmap.parameters
        wanted = values({"values": {}} | command)
        if wanted.get("map") == "given":
            raise ConfigError("costmap.map", "A simulation has no given map: its static map is the belief or the plan.")
        parameters = parameters.with_values(wanted)
        corners = command.get("footprint")
        if corners is not None:
            if len(corners) > MOST_CORNERS:
                raise ConfigError("footprint.vertices", f"A footprint has at most {MOST_CORNERS} corners here.")
            parameters = replace(parameters, footprint=Footprint(tuple((x, y) for x, y in corners)))
        strokes = None if command.get("keepout") is None else strokes_of(command["keepout"])
        if costmap is None:
            self._costmap = costmap = LabCostmap(self._map(parameters), self._plan, parameters)
            self._seen = None
        elif parameters != costmap.parameters:
            costmap.change(parameters, self._map(parameters), self._plan)
        if strokes is not None:
            costmap.paint(strokes)
        self._is_new = self._is_stale = True
        result.slot(self.messages()[0])

    def _plan(self) -> StaticMap:
        return StaticMap(plan_map(self._mapper.simulation.world))

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
        costmap.change(found, self._map(found), self._plan)
        self._is_new = self._is_stale = True
        result.slot(self.messages()[0])
        result.answer({"type": "nav2", "text": None})

    def _map(self, parameters: LabParameters) -> OccupancyGrid:
        """Return the map of the static layer: the belief, or another one where that is chosen and there."""
        other = self._others.get(parameters.values["map"], lambda: None)()
        return self._mapper.grid if other is None else other

    # -- what is shown --------------------------------------------------------------------------------------------

    def draw(self, box: CellBox | None, result: TickResult, *, whole: bool) -> None:
        """Follow what changed in the map, ``box`` or the ``whole`` of it, look at a new scan, and plan anew."""
        costmap = self._costmap
        if costmap is None:
            return
        mapper, pose = self._mapper, believed_now(self._mapper)
        grid = self._map(costmap.parameters)
        if grid is not mapper.grid or self._followed is not None:
            box, whole = None if grid is not mapper.grid else box, whole or grid is not self._followed
            self._is_new |= whole
            self._followed = None if grid is mapper.grid else grid
        costmap.follow(grid, box, whole=whole)
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
        if self._is_stale or (moved and is_scan and self._path.goal is not None):
            self._is_stale, self._pose = False, pose
            self._path.plan(costmap.costs, costmap.geometry, pose, costmap.parameters, are_new=are_new)
            result.changed = True
            result.slot(self._path.message())

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages ``costmap`` and ``path``."""
        return [costmap_message(self._costmap), self._path.message()]
