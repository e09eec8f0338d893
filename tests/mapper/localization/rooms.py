"""Maps and drives for the tests of localization."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.localization.map_model import MapModel, map_model
from mapper.localization.parameters import LocalizationConfig
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from tests.mapper.slam.worlds import along, drive

OFFICE_WAY = [(6.2, 7.0), (14.0, 7.0), (14.0, 8.0), (5.0, 7.0), (2.5, 7.0), (8.0, 7.0)]


def two_rooms() -> OccupancyGrid:
    """Return a map of two rooms, 3 m × 2 m each, of cells of 0.1 m, with a wall between them."""
    grid = OccupancyGrid(GridGeometry(0.1, 22, 63, (0.0, 0.0, 0.0)))
    grid.observed[:] = True
    grid.log_odds[:] = -3.0
    for wall in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, 31], np.s_[:, -1]):
        grid.log_odds[wall] = 3.0
    return grid


def model_of(grid: OccupancyGrid, config: LocalizationConfig | None = None) -> MapModel:
    return map_model(grid, config or LocalizationConfig(), 8.0)


@cache
def office(seed: int = 3) -> tuple[OccupancyGrid, ScanLog]:
    """Return the map of the office by a true drive, and another drive through it with drifting odometry."""
    config = MappingConfig(resolution=0.05)
    path = along(OFFICE_WAY, 0.3)
    mapped = drive("office", path, seed=1)
    grid = grid_for(mapped, config, "true")
    integrate_log(grid, mapped, config, "true")
    return grid, drive("office", np.add(path[::-1], [0.0, 0.0, np.pi]), seed=seed, turn_bias=0.02)


def two_lidars(log: ScanLog) -> JointLog:
    """Return a log as two lidars would have made it: ``/right`` has the first half of its beams, ``/left`` the others.

    Each is mounted in the direction of its middle beam, and scans a microsecond after the other.
    """
    half = log.n_beams // 2
    parts = []
    for k, name in enumerate(("right", "left")):
        first = log.angle_min + k * half * log.angle_increment
        middle = first + half // 2 * log.angle_increment
        assert log.mount == (0.0, 0.0, 0.0)
        assert abs(middle) < math.pi
        parts.append(
            replace(
                log,
                ranges=np.ascontiguousarray(log.ranges[:, k * half : (k + 1) * half]),
                angle_min=first - middle,
                mount=(0.0, 0.0, middle),
                topic=f"/{name}",
                frame_id=name,
                stamps_ns=log.stamps_ns + 1000 * k,
            )
        )
    return JointLog.of(parts)
