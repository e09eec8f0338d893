"""Logs of sonars, the map that is exported with a log, and the messages of an exported file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader

from mapper.grid import OccupancyGrid
from mapper.io.export import GrowingMap
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


def map_of(log: ScanLog) -> tuple[OccupancyGrid, GrowingMap]:
    config = MappingConfig(resolution=0.1)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    return grid, GrowingMap(grid, config)


def sonars_of(log: ScanLog) -> ScanLog:
    bearings = np.array([-0.5, 0.1, 1.4])
    return replace(log, ranges=log.ranges[:, :3].copy(), bearings=bearings, beam_width=0.3, upside_down=False)


def read(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Every message by topic, decoded by rosbags with the definitions that are in the file."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([path]) as reader:
        for connection, stamp, data in reader.messages():
            found.setdefault(connection.topic, []).append((stamp, reader.deserialize(data, connection.msgtype)))
    return found
