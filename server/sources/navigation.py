"""The costmap over the map of a session, and the path to a goal on it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, TypeAlias

from msgspec import Struct

from mapper.core.array_types import Int8Array
from mapper.costmap.nav2_parameters import costmap_of
from mapper.costmap.nav2_writing import nav2_yaml
from mapper.grid import OccupancyGrid
from mapper.io.ros_parameters import parse_ros_parameters
from mapper.planning.nav2_parameters import nav2_path_yaml, path_of
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.sources.lab_costmap import LabCostmap, StaticMap
from server.sources.lab_navigation_parameters import LabParameters, footprint_of, from_nav2
from server.sources.lab_path import LabPath
from server.sources.navigation_messages import (
    commands_of,
    cost_message,
    costmap_message,
    footprint_fields,
)
from server.sources.painted_zones import painted_filters, strokes_of
from server.stream.commands import CostCommand, CostmapCommand, GoalCommand, Nav2Command
from server.stream.layers import Layer
from server.stream.protocol import ProtocolError, place_of

_MOST_NAMES = 12  #: of parameters in one notice


OfNavigation: TypeAlias = CostmapCommand | GoalCommand | CostCommand | Nav2Command


class Navigation(Part, ABC):
    """The costmap and the path, from the command ``costmap`` on until the same command ends them."""

    commands: ClassVar[tuple[type[Struct], ...]] = (CostmapCommand, GoalCommand, CostCommand, Nav2Command)
    subject = "costmap"

    def __init__(self) -> None:
        self._costmap: LabCostmap | None = None
        self._path = LabPath()
        self._is_new = False  #: whether the costs have to be brought up to date before the next scan
        self._is_stale = False  #: whether the path has to be planned again

    def _first_values(self) -> dict[str, Any]:
        """Return the values that a new costmap has in the place of the table's first ones."""
        return {}

    @abstractmethod
    def _check(self, wanted: Mapping[str, Any]) -> None:
        """Raise :class:`ConfigError` for parameters that this session cannot have."""

    @abstractmethod
    def _map(self, parameters: LabParameters) -> OccupancyGrid:
        """Return the map of the static layer."""

    @abstractmethod
    def _plan(self) -> StaticMap:
        """Return the map that takes its place if the parameter ``map`` says so."""

    @abstractmethod
    def _forget_scans(self) -> None:
        """Have the next scan looked at by a costmap that is new."""

    @abstractmethod
    def _drives(self, command: GoalCommand) -> bool:
        """Return whether the robot is to drive to the goal of a command."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The costs, the sheets, the path and its potential; none while it is off."""
        return () if self._costmap is None else (*self._costmap.layers, *self._path.layers)

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds."""
        return 0 if self._costmap is None else self._costmap.cells

    def history(self) -> list[dict[str, Any]]:
        """Return the commands from which another session gets the same costmap and goal."""
        return commands_of(self._costmap, self._path)

    def present_footprint(self) -> dict[str, Any] | None:
        """Return the footprint with both radii, None while there is no costmap."""
        return None if self._costmap is None else footprint_fields(self._costmap.parameters)

    def present_masks(self) -> dict[str, Int8Array]:
        """Return the masks of the keepout zones and of the speed limits, as far as they are painted."""
        return {} if self._costmap is None else self._costmap.masks

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages ``costmap`` and ``path``."""
        return [costmap_message(self._costmap), self._path.message()]

    def end(self, result: TickResult) -> None:
        """Keep no costmap and no path any more."""
        if self._costmap is not None:
            self._costmap, self._path = None, LabPath()
            for told in self.messages():
                result.slot(told)

    def handle(self, command: OfNavigation, result: TickResult) -> None:
        """Carry out a command for the costmap or the path.

        Raises :class:`ProtocolError` and :class:`ConfigError`; nothing has changed then.
        """
        costmap = self._costmap
        if isinstance(command, CostmapCommand):
            self._set(command, result)
        elif costmap is None:
            raise ProtocolError("costmap.off", "There is no costmap: it has to be begun first.")
        elif isinstance(command, GoalCommand):
            place = place_of(command)
            self._path.head_for(None if place is None else (place[0], place[1]), drives=self._drives(command))
            self._is_stale = True
        elif isinstance(command, CostCommand):
            x, y = command.x, command.y
            result.answer(cost_message(x, y, costmap.why(x, y), costmap.why_speed(x, y)))
        else:
            self._exchange(costmap, command, result)
        result.changed = True

    def _set(self, command: CostmapCommand, result: TickResult) -> None:
        if not command.value:
            self.end(result)
            return
        costmap = self._costmap
        self._check(command.values)
        first = LabParameters().with_values(self._first_values()) if costmap is None else costmap.parameters
        parameters = first.with_values(command.values)
        if command.footprint is not None:
            parameters = replace(parameters, footprint=footprint_of(command.footprint))
        strokes = None if command.keepout is None else strokes_of(command.keepout)
        if costmap is None:
            self._costmap = costmap = LabCostmap(self._map(parameters), self._plan, parameters)
            self._forget_scans()
        elif parameters != costmap.parameters:
            costmap.change(parameters, self._map(parameters), self._plan)
        if strokes is not None:
            costmap.paint(strokes)
        self._note_change(result)

    def _exchange(self, costmap: LabCostmap, command: Nav2Command, result: TickResult) -> None:
        """Answer with the parameters as Nav2's yaml, or take them from one."""
        if command.text is None:
            masks, kind = costmap.masks, costmap.parameters.values["speed_limits"]
            filters = painted_filters(masks.get("keepout"), masks.get("speed"), kind)
            parts = nav2_yaml(replace(costmap.parameters.nav2, filters=filters), costmap.geometry.resolution)
            path = nav2_path_yaml(costmap.parameters.path)
            result.answer({"type": "nav2", "text": parts + path})
            return
        root = parse_ros_parameters(command.text.encode())
        read, read_path = costmap_of(root), path_of(root)
        found = from_nav2(costmap.parameters, read, read_path)
        costmap.change(found, self._map(found), self._plan)
        unused = *read.unused, *read_path.unused
        said = [*read.notes, *read_path.notes]
        if not read.general.track_unknown_space:
            said.append("track_unknown_space is off: cells that the map does not know count as free.")
        if unused:
            names = ", ".join(unused[:_MOST_NAMES]) + (" and more" if len(unused) > _MOST_NAMES else "")
            said.append(f"Without effect here, and kept in the yaml that you download: {names}.")
        if said:  # in one notice: a page shows the newest
            result.notice("nav2.kept", " ".join(said))
        self._note_change(result)
        result.answer({"type": "nav2", "text": None})

    def _note_change(self, result: TickResult) -> None:
        self._is_new = self._is_stale = True
        result.slot(self.messages()[0])
