"""The drawings of a map and a robot for the 3D view."""

from __future__ import annotations

from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from server.sessions.drawings import Drawing, GridColumns, RobotBody
from server.sessions.view import RobotState
from server.sources.beams import beam_segments


def map_drawings(grid: OccupancyGrid, robot: RobotState, config: MappingConfig) -> list[Drawing]:
    """Return the drawings of a map, and of a robot with the beams of its newest scan."""
    return [
        GridColumns(name="map", label="Map", geometry=grid.geometry, log_odds=grid.log_odds, observed=grid.observed),
        RobotBody(name="robot", label="Robot", pose=robot.pose, beams=beam_segments(robot, config)),
    ]
