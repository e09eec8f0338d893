"""View of a session at one moment, read from its model, for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import SensorConfig, World
from server.sessions import SessionHost
from server.sessions.view import Pose


@dataclass(frozen=True, slots=True)
class SessionView:
    """View of a session. The arrays are the session's own: read them at once, write nothing.

    ``pose`` is where the base is now; ``sensor_pose`` is where the sensor was when it took ``ranges``,
    at the bearings ``angles``, radians.
    """

    geometry: GridGeometry
    log_odds: NDArray[np.float32]
    observed: NDArray[np.bool_]
    pose: Pose
    sensor_pose: Pose
    ranges: NDArray[np.float32]
    angles: NDArray[np.float64]
    range_max: float
    world: World | None
    config: MappingConfig
    sensor: SensorConfig | None
    playing: bool
    index: int
    count: int


def view_of(session: SessionHost) -> SessionView:
    """Return what a session of a map and a robot shows now."""
    model: Any = session.model
    grid = model.grid
    robot = (model.source or model).robot_state()
    index, count = model.progress
    return SessionView(
        geometry=grid.geometry,
        log_odds=grid.log_odds,
        observed=grid.observed,
        pose=robot.pose,
        sensor_pose=robot.scan_pose,
        ranges=robot.scan.ranges,
        angles=robot.scan.angles,
        range_max=min(robot.scan.range_max, model.config.range_max),
        world=getattr(model, "world", None),
        config=model.config,
        sensor=getattr(model, "sensor", None),
        playing=model.playback.playing,
        index=index,
        count=count,
    )
