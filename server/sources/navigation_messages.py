"""Messages of a session about its costmap."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from mapper.costmap import CellReason
from mapper.costmap.nav2_writing import nav2_yaml
from mapper.planning.nav2_parameters import nav2_path_yaml
from server.sources.lab_costmap import LabCostmap
from server.sources.lab_navigation_parameters import IN_NAV2, INITIAL, LabParameters
from server.sources.lab_path import LabPath
from server.stream.commands import CostmapCommand, GoalCommand, Nav2Command
from server.stream.protocol import ProtocolError, command_of, type_of


def costmap_message(costmap: LabCostmap | None) -> dict[str, Any]:
    """Return the message ``costmap``; None for a session without one."""
    parameters = LabParameters() if costmap is None else costmap.parameters
    strokes = () if costmap is None else costmap.strokes
    return {
        "type": "costmap",
        "is_on": costmap is not None,
        "values": dict(parameters.values),
        **footprint_fields(parameters),
        "keepout": [one.message() for one in strokes],
    }


def footprint_fields(parameters: LabParameters) -> dict[str, Any]:
    """Return the corners of the footprint, metres in the robot's frame, and both radii of the padded one, metres."""
    outline = parameters.outline
    return {
        "footprint": [list(corner) for corner in parameters.footprint.vertices],
        "inscribed_radius": round(outline.inscribed_radius, 4),
        "circumscribed_radius": round(outline.circumscribed_radius, 4),
    }


def cost_message(x: float, y: float, reasons: list[CellReason], speed: str | None) -> dict[str, Any]:
    """Return the message ``cost`` of the place (x, y), metres, with what the speed filter says of it."""
    layers = [{"layer": one.layer, "cost": one.cost, "master": one.master, "sentence": one.sentence} for one in reasons]
    return {"type": "cost", "x": round(x, 4), "y": round(y, 4), "layers": layers, "speed": speed}


def commands_of(costmap: LabCostmap | None, path: LabPath) -> list[dict[str, Any]]:
    """Return the commands from which another session gets the same costmap and goal; none without a costmap.

    Where a Nav2 file was loaded that has more than the table of parameters, the command ``nav2`` has that. It has all
    layers, since a layer that is off may have such parameters too, and the command after it switches them as they are.
    """
    if costmap is None:
        return []
    message = costmap_message(costmap)
    values = {name: value for name, value in message["values"].items() if value != INITIAL[name]}
    found: list[dict[str, Any]] = [
        {"type": "costmap", "values": values, "footprint": message["footprint"], "keepout": message["keepout"]}
    ]
    loaded = costmap.parameters
    if loaded.has_more:
        flags = {name: loaded.values[name] for name in IN_NAV2}
        every = loaded.with_values(dict.fromkeys(IN_NAV2, True))
        text = nav2_yaml(every.nav2, costmap.geometry.resolution) + nav2_path_yaml(every.path)
        found += [{"type": "nav2", "text": text}, {"type": "costmap", "values": flags}]
    if path.goal is not None:
        x, y = path.goal
        found.append({"type": "goal", "x": x, "y": y, "drives": path.drives})
    return found


def checked_commands(given: Iterable[object]) -> Iterator[CostmapCommand | Nav2Command | GoalCommand]:
    """Yield the commands of :func:`commands_of` that a story from outside holds. Raises :class:`ProtocolError`."""
    for one in given:
        command = command_of(one)
        if not isinstance(command, CostmapCommand | Nav2Command | GoalCommand):
            raise ProtocolError("story.navigation", f"A story cannot hold the command {type_of(command)!r:.80}.")
        yield command
