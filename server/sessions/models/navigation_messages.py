"""What a session says of its costmap."""

from __future__ import annotations

from typing import Any

from mapper.costmap import CellReason
from server.sessions.models.lab_costmap import LabCostmap
from server.sessions.models.lab_navigation_parameters import LabParameters

COMMANDS = ("costmap", "goal", "cost", "nav2")


def costmap_message(costmap: LabCostmap | None) -> dict[str, Any]:
    """Return the message ``costmap``; None for a session without one."""
    parameters = LabParameters() if costmap is None else costmap.parameters
    outline = parameters.outline
    strokes = () if costmap is None else costmap.strokes
    return {
        "type": "costmap",
        "is_on": costmap is not None,
        "values": dict(parameters.values),
        "footprint": [list(corner) for corner in parameters.footprint.vertices],
        "inscribed_radius": round(outline.inscribed_radius, 4),
        "circumscribed_radius": round(outline.circumscribed_radius, 4),
        "keepout": [
            {"width": one.width, "erases": one.erases, "points": [list(point) for point in one.points]}
            for one in strokes
        ],
    }


def cost_message(x: float, y: float, reasons: list[CellReason]) -> dict[str, Any]:
    """Return the message ``cost`` of the place (x, y), metres."""
    layers = [{"layer": one.layer, "cost": one.cost, "master": one.master, "sentence": one.sentence} for one in reasons]
    return {"type": "cost", "x": round(x, 4), "y": round(y, 4), "layers": layers}
