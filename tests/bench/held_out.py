"""Hits and misses of one scan in a cell: what it costs where only the hits count, and what scans left out say of it."""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OCCUPIED_THRESHOLD, OccupancyGrid, log_odds
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.sensors.scan import ScanLog

EVERY = 10  #: one scan in so many is left out of the map
CLEAR_M = 0.2  #: from the sensor and from the end of a beam, where it is not said to pass freely
ROUNDS = 10


def held_out(logs: Iterable[tuple[str, ScanLog, float]]) -> None:
    """Print for each log (name, log, resolution) and each value of ``hit_and_passed`` the time of mapping all scans,
    and of beams that are not in the map the share that ends in an occupied cell, and of the places every cell along
    them the share that lies in one.
    """
    print("| log | hit and passed | mapping | ends in occupied cells | places passed in occupied cells |")
    print("|---|---|---|---|---|")
    for name, log, resolution in logs:
        rules = BY_NAME["hit_and_passed"].choices
        configs = {rule: MappingConfig(resolution=resolution, hit_and_passed=rule) for rule in rules}
        times = dict.fromkeys(rules, np.inf)
        for _ in range(ROUNDS):
            for rule, config in configs.items():
                times[rule] = min(times[rule], _seconds(log, config))
        numbers = np.arange(log.n_scans)
        kept, left_out = log.take(numbers[numbers % EVERY != 0]), log.take(numbers[numbers % EVERY == 0])
        for rule, config in configs.items():
            grid = OccupancyGrid(geometry_for(log, config))
            integrate_log(grid, kept, config)
            ended, passed = _said(grid, left_out, config)
            ratio = times[rule] / times[rules[0]]
            print(
                f"| {name} | {rule.replace('_', ' ')} | {1e3 * times[rule]:.1f} ms, {ratio:.2f} × | "
                f"{100 * ended:.1f} % | {100 * passed:.2f} % |"
            )


def _seconds(log: ScanLog, config: MappingConfig) -> float:
    grid = OccupancyGrid(geometry_for(log, config))
    began = time.perf_counter()
    integrate_log(grid, log, config)
    return time.perf_counter() - began


def _said(grid: OccupancyGrid, log: ScanLog, config: MappingConfig) -> tuple[float, float]:
    """Return the shares of the ends of beams, and of places that they pass, that lie in occupied cells."""
    occupied = grid.log_odds > log_odds(OCCUPIED_THRESHOLD)
    ends: list[NDArray[np.bool_]] = []
    places: list[NDArray[np.bool_]] = []
    for ranges, (x, y, theta) in zip(log.ranges.astype(np.float64), log.sensor_poses(), strict=True):
        measured = (ranges >= log.range_min) & (ranges <= min(log.range_max, config.range_max))
        bearing = theta + log.angles[measured]
        direction = np.stack([np.cos(bearing), np.sin(bearing)], axis=-1)
        z = ranges[measured]
        along = np.arange(CLEAR_M, max(z, default=0.0), config.resolution)
        beam, step = np.nonzero(along < z[:, np.newaxis] - CLEAR_M)
        for reach, of, found in ((z, np.arange(len(z)), ends), (along[step], beam, places)):
            rows, cols = grid.geometry.world_to_cell([x, y] + reach[:, np.newaxis] * direction[of]).T
            found.append(occupied[rows, cols])
    return float(np.concatenate(ends).mean()), float(np.concatenate(places).mean())
