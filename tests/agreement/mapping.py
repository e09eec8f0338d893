"""Maps of logs, and the geometry that holds them, by the kernels and by the textbook."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from mapper.core.se2 import transform_points
from mapper.grid import OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping.integrate import bounds_of_log, geometry_for, integrate_log, integrate_scan
from mapper.sensors.scan import RangeScan
from tests.agreement.asking import beams_and_poses, sweeps
from tests.agreement.inputs import MappingCase


def map_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = integrate_log(grid, case.log, case.config)
    return grid.log_odds, grid.observed, count


def grid_of_all(case: MappingCase) -> OccupancyGrid:
    """The grid of a case, grown so that no scan reaches beyond it, not even by rounding in a turned grid."""
    grid = case.grid()
    low, high = bounds_of_log(case.log, case.config)
    grid.grow_to_include(low - 0.5 * grid.geometry.resolution, high + 0.5 * grid.geometry.resolution)
    return grid


def map_of_single_scans(case: MappingCase) -> tuple[Any, ...]:
    """The map as a live robot makes it, scan by scan."""
    grid, count = grid_of_all(case), 0
    for t, pose in enumerate(case.log.sensor_poses()):
        count += integrate_scan(grid, case.log.scan(t), tuple(pose.tolist()), case.config).cells_updated
    return grid.log_odds, grid.observed, count


def map_of_single_scans_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return updated_by_textbook(grid_of_all(case), case)


def map_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return updated_by_textbook(case.grid(), case)


def updated_by_textbook(grid: OccupancyGrid, case: MappingCase) -> tuple[Any, ...]:
    count = 0
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        count += textbook.occupancy_grid_mapping(grid, scan, pose, case.config)
    return grid.log_odds, grid.observed, count


def statistics_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = integrate_log(grid, case.log, case.config)
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def statistics_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = 0
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        count += textbook.occupancy_grid_mapping(grid, scan, pose, case.config)
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def sweeps_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    if case.config.only_hits:
        count = sum(textbook.update_hits_first(grid, views, case.config) for views in sweeps(case))
    else:
        count = sum(textbook.occupancy_grid_mapping(grid, *one, case.config) for one in beams_and_poses(case))
    return grid.log_odds, grid.observed, count


def swept_statistics_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    grid = case.grid()
    count = sum(textbook.occupancy_grid_mapping(grid, *one, case.config) for one in beams_and_poses(case))
    return grid.cell_statistics, grid.p_occ.astype(np.float32), grid.observed, count


def bounds_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    return (geometry_for(case.log, case.config),)


def bounds_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return bounds_of_scans(case, zip(case.scans(), case.sensor_poses(), strict=True))


def bounds_of_sweeps_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    return bounds_of_scans(case, beams_and_poses(case))


def bounds_of_scans(case: MappingCase, scans: Iterable[tuple[RangeScan, np.ndarray]]) -> tuple[Any, ...]:
    z_max = min(case.log.range_max, case.config.range_max)
    seen = []
    for scan, pose in scans:
        seen.append(pose[:2])
        for z, bearing in zip(textbook.readings(scan, case.config), scan.angles, strict=True):
            if z > z_max:
                reach = z_max if case.config.no_return == "free" else 0.0
            else:
                reach = z + case.config.window / 2 if z >= scan.range_min else 0.0
            in_laser = reach * np.array([np.cos(bearing), np.sin(bearing)])
            seen.append(transform_points(pose, in_laser))
    side = case.config.resolution
    low, high = np.min(seen, axis=0) - side, np.max(seen, axis=0) + side
    return (case.geometry.covering(low, high, side),)
