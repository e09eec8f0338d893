"""The costmap over the map of a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError
from mapper.core.parameter import Values
from mapper.costmap import NO_INFORMATION
from mapper.costmap.nav2.reading import costmap_of
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.costmaps import RecordedCostmap
from mapper.io.ros_parameters import parse_ros_parameters
from mapper.planning.nav2_parameters import path_of
from server.parts.costmap.costmap import Costmap
from server.parts.costmap.messages import (
    CostCommand,
    CostmapCommand,
    CostmapMessage,
    CostMessage,
    Nav2Command,
    Nav2Message,
)
from server.parts.costmap.parameters import (
    INITIAL,
    OF_THE_FOLLOWER,
    CostmapParameters,
    footprint_of,
    from_nav2,
    rows_with,
)
from server.parts.costmap.zones import painted_filters, strokes_of
from server.sessions.commands import UseCosts, UseTerrain
from server.sessions.part import Offers, Part, Robot, StaticMap
from server.sessions.parts import Costed, FootprintAnswer, LayerCosts, UploadedCosts
from server.sessions.tick import TickResult
from server.stream.commands import RestartCommand, WorldCommand
from server.stream.layers import Layer
from server.stream.message_parts import LayerCost
from server.stream.protocol import ProtocolError

MOST_CELLS = 5_000_000  #: maximum size of the map, because each costmap holds a dozen grids of that size
_MOST_NAMES = 12  #: maximum number of parameters in one notice
_UNSEEN = "{} has no source of the type LaserScan: it sees nothing of the scans here."

_OTHER_TOPIC = "{} has no source with the topic {}: the scans go to its sources with the first topic of a LaserScan."


class CostmapPart(Part, Costed):
    """A costmap. The ``costmap`` command begins and ends it."""

    commands = (CostmapCommand, CostCommand, Nav2Command, UseCosts)
    recorded = (CostmapCommand, Nav2Command)
    subject = "costmap"
    is_on = False

    @classmethod
    def of(cls, offers: Offers) -> CostmapPart | None:
        """Return the part of a source with a map and a robot in it."""
        if offers.grid is None or offers.robot is None:
            return None
        return cls(offers, offers.grid, offers.robot)

    def __init__(self, offers: Offers, grid: Callable[[], OccupancyGrid], robot: Callable[[], Robot]) -> None:
        self._grid, self._robot, self._plans, self._maps = grid, robot, offers.plans, offers.maps
        self._offered = offers.costs.get("terrain_layer", lambda: None)
        titles: dict[str, str] = {"belief": offers.map_title}
        titles |= {name: plan.title for name, plan in self._plans.items()}
        titles |= {name: other.title for name, other in self._maps.items()}
        self._names = tuple(titles)
        self.tables = {"costmap": rows_with(titles, () if offers.drive else OF_THE_FOLLOWER)}
        offers.costing = self
        self.costmap: Costmap | None = None
        self._is_new = False  #: whether the costs must be brought up to date before the next scan
        self._version: object = None  #: version of the static layer's plan
        self._followed: OccupancyGrid | None = None  #: the other map that the static layer uses
        self._number = -1  #: number of the scan that the obstacle layers used last
        self._uploaded: UploadedCosts | None = None
        self._laid: LayerCosts | None = None  #: the terrain in the costmap

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The costs and the layers' own costs; none while it is off."""
        return () if self.costmap is None else self.costmap.layers

    @property
    def cells(self) -> int:
        """Number of cells of its grids."""
        return 0 if self.costmap is None else self.costmap.cells

    def messages(self) -> tuple[CostmapMessage]:
        """Return the ``costmap`` message."""
        costmap = self.costmap
        parameters = CostmapParameters() if costmap is None else costmap.parameters
        strokes = () if costmap is None else costmap.strokes
        footprint = parameters.footprint_answer()
        message = CostmapMessage(
            is_on=costmap is not None,
            values=dict(parameters.values),
            keepout=[stroke.message() for stroke in strokes],
            footprint=footprint.footprint,
            inscribed_radius=footprint.inscribed_radius,
            circumscribed_radius=footprint.circumscribed_radius,
        )
        return (message,)

    def history(self) -> list[Struct]:
        """Return the commands that create the same costmap in another session.

        A loaded Nav2 file is in a ``nav2`` command with its current contents. The ``use_terrain`` command names an
        upload, which the service then reads.
        """
        costmap = self.costmap
        if costmap is None:
            return []
        loaded = costmap.parameters
        values = {name: value for name, value in loaded.values.items() if value != INITIAL[name]}
        (message,) = self.messages()
        outline = None if loaded.loaded is not None else message.footprint
        commands: list[Struct] = [CostmapCommand(values=values, footprint=outline, keepout=message.keepout)]
        if loaded.loaded is not None:
            commands.append(Nav2Command(loaded.nav2_text((), costmap.geometry.resolution)))
        if self._uploaded is not None:
            commands.append(UseTerrain(self._uploaded.log_id))
        return commands

    def present_costs(self) -> RecordedCostmap | None:
        """Return the current costs."""
        return None if self.costmap is None else self.costmap.recorded(self._robot().time_s, None)

    def present_footprint(self) -> FootprintAnswer | None:
        """Return the footprint with both radii, None without a costmap."""
        return None if self.costmap is None else self.costmap.parameters.footprint_answer()

    def present_masks(self) -> dict[str, Int8Array]:
        """Return the painted masks of the keepout zones and of the speed limits."""
        return {} if self.costmap is None else self.costmap.masks

    # -- commands -------------------------------------------------------------------------------------------------

    def handle(self, command: CostmapCommand | CostCommand | Nav2Command | UseCosts, result: TickResult) -> None:
        """Carry out a command. If it raises :class:`ProtocolError` or :class:`ConfigError`, nothing has changed.

        Answering a question does not count as a change, because pages would ask again after each new frame.
        """
        costmap = self.costmap
        if isinstance(command, CostmapCommand):
            self._set(command, result)
        elif isinstance(command, UseCosts):
            self._use_terrain(command.costs, result)
        elif costmap is None:
            raise ProtocolError("costmap.off", "There is no costmap: it has to be begun first.")
        elif isinstance(command, CostCommand):
            x, y = command.x, command.y
            costs = [LayerCost(cost.layer, cost.cost, cost.master, cost.sentence) for cost in costmap.why(x, y)]
            result.answer(CostMessage(round(x, 4), round(y, 4), costs, costmap.why_speed(x, y)))
        else:
            self._exchange(costmap, command, result)

    def _set(self, command: CostmapCommand, result: TickResult) -> None:
        if command.value is False:
            self._end(result)
            return
        costmap = self.costmap
        self._check(command.values)
        first = CostmapParameters().with_values(self._first_values()) if costmap is None else costmap.parameters
        outline = None if command.footprint is None else footprint_of(command.footprint)
        parameters = first.with_values(command.values, outline)
        strokes = None if command.keepout is None else strokes_of(command.keepout)
        if costmap is None:
            self.costmap = costmap = Costmap(self._map(parameters), self._plan, parameters)
            self.is_on = True
            self._laid, self._number = None, -1
        elif parameters != costmap.parameters:
            costmap.change(parameters, self._map(parameters), self._plan)
        if strokes is not None:
            costmap.paint(strokes)
        self._note_change(result)

    def _check(self, values: Mapping[str, Any]) -> None:
        """Raise :class:`ConfigError` for parameters that this session cannot use."""
        if (n := _cells_of(self._grid())) > MOST_CELLS:
            message = f"The map has {n} cells, and a costmap at most {MOST_CELLS}; choose a coarser resolution."
            raise ConfigError("costmap.too_large", message)
        name = values.get("map", "belief")
        if name not in self._names:
            message = f"The static map of this session is one of {', '.join(self._names)}: it has no map {name!r:.80}."
            raise ConfigError("costmap.map", message)

    def _first_values(self) -> Values:
        """Return initial values for the table: the static map is the plan that contains the poses, if there is one."""
        for name, plan in self._plans.items():
            if plan.is_first() and _cells_of(plan.read().grid) <= MOST_CELLS:
                return {"map": name}
        return {}

    def _map(self, parameters: CostmapParameters) -> OccupancyGrid:
        """Return the map of the static layer: the source's own, or the chosen other one if it exists."""
        other = self._maps.get(parameters.values["map"])
        grid = None if other is None else other.read()
        return self._grid() if grid is None else grid

    def _plan(self, name: str) -> StaticMap | None:
        """Return the plan that replaces the source's map, None if the map of this name is not a plan."""
        plan = self._plans.get(name)
        if plan is None:
            return None
        static = plan.read()
        if (n := _cells_of(static.grid)) > MOST_CELLS:
            message = f"The {name} map has {n} cells, and a costmap at most {MOST_CELLS}."
            raise ConfigError("costmap.too_large", message)
        self._version = plan.version()
        return static

    def _end(self, result: TickResult) -> None:
        if self.costmap is not None:
            self.costmap, self.is_on = None, False
            result.changed = True
            result.slot(*self.messages())

    def _use_terrain(self, terrain: UploadedCosts | None, result: TickResult) -> None:
        """Use the costs of an upload for the terrain layer."""
        self._uploaded = terrain
        result.changed = True
        geometry = self._grid().geometry if self.costmap is None else self.costmap.geometry
        if terrain is not None and not _meets(terrain, geometry):
            message = "The terrain has no known cell within the costmap: are both in one frame?"
            result.notice("terrain.elsewhere", message)

    def _exchange(self, costmap: Costmap, command: Nav2Command, result: TickResult) -> None:
        """Answer with the parameters as Nav2 yaml, or set them from it."""
        if command.text is None:
            masks, kind = costmap.masks, costmap.parameters.values["speed_limits"]
            filters = painted_filters(masks.get("keepout"), masks.get("speed"), kind)
            result.answer(Nav2Message(costmap.parameters.nav2_text(filters, costmap.geometry.resolution)))
            return
        root = parse_ros_parameters(command.text.encode())
        read, read_path = costmap_of(root), path_of(root)
        exchange, notes = from_nav2(costmap.parameters, root, read, read_path)
        costmap.change(exchange, self._map(exchange), self._plan)
        unused = *read.unused, *read_path.unused
        all_notes = [*read.notes, *read_path.notes, *notes, *(_UNSEEN.format(name) for name in costmap.blind)]
        topics = self._robot().topics
        if topics:
            listed = ", ".join(topics)
            all_notes += [_OTHER_TOPIC.format(name, listed) for name in costmap.with_other_topics(topics)]
        if not read.general.track_unknown_space:
            all_notes.append("track_unknown_space is off: cells that the map does not know count as free.")
        if unused:
            names = ", ".join(unused[:_MOST_NAMES]) + (" and more" if len(unused) > _MOST_NAMES else "")
            all_notes.append(f"Without effect here, and kept in the yaml that you download: {names}.")
        if all_notes:  # one notice, because a page shows only the newest
            result.notice("nav2.kept", " ".join(all_notes))
        self._note_change(result)
        result.answer(Nav2Message(None))

    def _note_change(self, result: TickResult) -> None:
        self._is_new = result.changed = True
        result.slot(*self.messages())

    def note(self, command: Struct, result: TickResult) -> None:
        """End when the world changes."""
        if isinstance(command, WorldCommand | RestartCommand):
            self._end(result)

    # -- computing ------------------------------------------------------------------------------------------------

    def changed(self, result: TickResult) -> None:
        """Apply the changes of the map, and a new scan."""
        costmap = self.costmap
        if costmap is None:
            return
        self._renew_plan(costmap, result)
        if (n := _cells_of(self._grid())) > MOST_CELLS and costmap.parameters.values["map"] not in self._plans:
            self._end(result)
            result.notice(
                "costmap.too_large", f"The map has {n} cells now, and a costmap at most {MOST_CELLS}: it has ended."
            )
            return
        robot = self._robot()
        are_new = self._follow(costmap, robot, result)
        is_scan = robot.scan is not None and robot.number != self._number
        if is_scan and robot.scan is not None:
            self._number = robot.number
            costmap.look(robot.scan, robot.scan_pose, robot.topic, robot.topics)
        if is_scan or are_new:
            self._is_new = False
            are_new |= costmap.update(robot.time_s, robot.pose)
        costmap.revision += are_new

    def _renew_plan(self, costmap: Costmap, result: TickResult) -> None:
        """Use a new plan, such as a map that was just loaded."""
        name = costmap.parameters.values["map"]
        if name not in self._plans or self._version is self._plans[name].version():
            return
        try:
            costmap.renew_plan(self._plan(name), self._grid())
            self._is_new = True
        except ConfigError as error:  # the costmap keeps the previous map
            self._version = self._plans[name].version()
            result.notice(error.code, error.message)

    def _follow(self, costmap: Costmap, robot: Robot, result: TickResult) -> bool:
        """Apply changes of the maps below; return whether the costs have changed."""
        own, box, whole = self._grid(), result.box, result.new_grid
        grid = self._map(costmap.parameters)
        if grid is not own or self._followed is not None:
            box, whole = None if grid is not own else box, whole or grid is not self._followed
            self._is_new |= whole
            self._followed = None if grid is own else grid
        if robot.number < self._number:
            costmap.begin(grid)  # marks of later scans are not known yet
        else:
            costmap.follow(grid, box, whole=whole)
        terrain = self._offered() if self._uploaded is None else self._uploaded
        if terrain is not self._laid:
            self._laid, self._is_new = terrain, True
            costmap.lay_terrain(terrain)
        return self._is_new or whole


def _cells_of(grid: OccupancyGrid) -> int:
    return grid.geometry.rows * grid.geometry.cols


def _meets(terrain: LayerCosts, geometry: GridGeometry) -> bool:
    """Return whether a known cell of a terrain coincides with a cell of another geometry."""
    rows, cols = (terrain.costs() != NO_INFORMATION).nonzero()
    if not len(rows):
        return False
    step = max(1, len(rows) // 100_000)
    centres = terrain.geometry.cell_to_world(np.column_stack([rows[::step], cols[::step]]))
    return bool(geometry.contains(geometry.world_to_cell(centres)).any())


part_of = CostmapPart.of
