"""Values that sessions, their parts and their readers exchange: poses, views, requests for a comparison."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import RangeScan, ScanLog
from mapper.simulation import SensorConfig, World

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
class LogView:
    """What a session shows of a log, enough for another session to show the same: the sensor and the trajectory, None
    for the usual ones, the values of the parameters, and how many scans are in the map.
    """

    topic: str | None = None
    trajectory: str | None = None
    values: dict[str, Any] | None = None
    index: int = 0


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to compare with: a map of ``log``, None being the session's own, with the poses of ``trajectory``.

    ``values`` are the parameters that it keeps; in all others it follows the session's.
    """

    values: dict[str, Any] = field(default_factory=dict)
    trajectory: str | None = None
    log: ScanLog | None = None
    log_id: str | None = None
    topic: str | None = None
    title: str = ""


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot and its newest scan.

    ``pose`` is T_map_base and ``sensor_pose`` T_map_laser now, ``scan_pose`` is T_map_laser at the scan. None of them
    includes the correction of the mount among the parameters, which the map composes onto them. ``believed_*`` are the
    same as the robot estimates them, None where the estimate is exact.
    """

    pose: Pose
    sensor_pose: Pose
    scan_pose: Pose
    scan: RangeScan
    stamp_s: float
    believed_pose: Pose | None = None
    believed_scan_pose: Pose | None = None


def view_of(
    grid: OccupancyGrid,
    robot: RobotState,
    config: MappingConfig,
    progress: tuple[int, int],
    *,
    playing: bool,
    world: World | None = None,
    sensor: SensorConfig | None = None,
) -> SessionView:
    """Return what is shown of a map and a robot."""
    return SessionView(
        geometry=grid.geometry,
        log_odds=grid.log_odds,
        observed=grid.observed,
        pose=robot.pose,
        sensor_pose=robot.scan_pose,
        ranges=robot.scan.ranges,
        angles=robot.scan.angles,
        range_max=min(robot.scan.range_max, config.range_max),
        world=world,
        config=config,
        sensor=sensor,
        playing=playing,
        index=progress[0],
        count=progress[1],
    )


def as_pose(row: NDArray[np.float64]) -> Pose:
    """Return (3,) as a tuple of plain numbers."""
    x, y, yaw = (float(v) for v in row)
    return (x, y, yaw)
