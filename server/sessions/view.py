"""What a session shows at one instant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import RangeScan
from mapper.simulation import SensorConfig, World
from server.sessions.why import Source
from server.stream.layers import GridLayer

Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SessionView:
    """What a session shows now. The arrays are the session's own: read them at once, write nothing.

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


@dataclass(frozen=True, slots=True)
class Side:
    """One of a session's maps, for questions about its cells, and the layer that shows it."""

    grid: OccupancyGrid
    config: MappingConfig
    sources: Callable[[], list[Source]]
    index: int
    layer: GridLayer


@dataclass(frozen=True, slots=True)
class LogView:
    """What a session shows of a log, enough for another session to show the same: the sensor and the trajectory, None
    for the usual ones, the values of the parameters, and how many scans are in the map.
    """

    topic: str | None = None
    trajectory: str | None = None
    values: dict[str, Any] | None = None
    index: int = 0


@dataclass(frozen=True, slots=True)
class RobotState:
    """Now and the newest scan: ``pose`` T_map_base and ``sensor_pose`` T_map_laser now, ``scan_pose`` T_map_laser then.

    The correction of the mount among the parameters is in neither: the map composes it onto them. ``believed_*`` are
    the same of where the robot believes to be, None where it knows.
    """

    pose: Pose
    sensor_pose: Pose
    scan_pose: Pose
    scan: RangeScan
    stamp_s: float
    believed_pose: Pose | None = None
    believed_scan_pose: Pose | None = None


def as_pose(row: NDArray[np.float64]) -> Pose:
    """Return (3,) as a tuple of plain numbers."""
    x, y, yaw = (float(v) for v in row)
    return (x, y, yaw)
