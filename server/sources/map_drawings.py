"""The drawings of a map and a robot with the beams of its scan, for the 3D view."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from server.sessions.drawings import Drawing, GridColumns, RobotBody
from server.sessions.scene_controls import Sight
from server.sessions.view import RobotState

MAX_BEAMS = 120  #: beams drawn of one scan
BEAM_Z = 0.2  #: metres above the floor
BEAM_START = 0.35  #: metres from the sensor at which a beam begins; closer to it, beams would hide the robot


def beam_segments(state: RobotState, config: MappingConfig) -> NDArray[np.float32]:
    """Return the beams that hit something as segments (n, 2, 3) in the base frame, at most :data:`MAX_BEAMS`.

    The mount correction of the parameters is applied.
    """
    step = -(-len(state.scan.ranges) // MAX_BEAMS) or 1
    ranges = np.asarray(state.scan.ranges, dtype=np.float64)[::step]
    x, y, yaw = compose(inverse(state.pose), compose(state.scan_pose, config.mount))
    angles = yaw + state.scan.angles[::step]
    hit = np.isfinite(ranges) & (ranges > BEAM_START) & (ranges <= min(state.scan.range_max, config.range_max))
    ranges, angles = ranges[hit], angles[hit]
    segments = np.full((len(ranges), 2, 3), BEAM_Z, dtype=np.float32)
    for end, distance in enumerate((BEAM_START, ranges)):
        segments[:, end, 0] = x + distance * np.cos(angles)
        segments[:, end, 1] = y + distance * np.sin(angles)
    return segments


EYE_M = 0.35  #: camera height of a robot above the floor; its body is below


def sight_of(robot: RobotState) -> Sight:
    """Return the position and the forward direction of a robot's camera."""
    x, y, yaw = robot.pose
    return Sight((x, y, EYE_M), (math.cos(yaw), math.sin(yaw), 0.0))


def map_drawings(grid: OccupancyGrid, robot: RobotState, config: MappingConfig) -> list[Drawing]:
    """Return the drawings of a map, and of a robot with the beams of its newest scan."""
    return [
        GridColumns(name="map", label="Map", geometry=grid.geometry, log_odds=grid.log_odds, observed=grid.observed),
        RobotBody(name="robot", label="Robot", pose=robot.pose, beams=beam_segments(robot, config)),
    ]
