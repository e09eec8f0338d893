"""Mapping core: maps from range scans. NumPy in, NumPy out, without web or asyncio.

The names to start with::

    from mapper import MappingConfig, OccupancyGrid, geometry_for, integrate_log, open_log, save_map

Each name is imported from its module on first use.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.costmap.layered import LayeredCostmap
    from mapper.diagnosis.diagnosis import diagnose
    from mapper.grid.occupancy_grid import GridGeometry, OccupancyGrid
    from mapper.io.export.recording import write_mcap
    from mapper.io.logs.opening import open_log
    from mapper.io.maps.reading import load_map
    from mapper.io.maps.writing import save_map
    from mapper.localization.monte_carlo import MonteCarloLocalizer
    from mapper.mapping.integrate import geometry_for, integrate_log, integrate_scan
    from mapper.mapping.parameters import MappingConfig
    from mapper.matching.match import match_scan
    from mapper.planning.plan import plan_path
    from mapper.sensors.scan import LaserScan, ScanLog
    from mapper.simulation.sample import sample_log
    from mapper.slam.whole_log import slam_log
    from mapper.volume.occupancy.volume import OccupancyVolume

__all__ = [
    "GridGeometry",
    "LaserScan",
    "LayeredCostmap",
    "MappingConfig",
    "MonteCarloLocalizer",
    "OccupancyGrid",
    "OccupancyVolume",
    "ScanLog",
    "diagnose",
    "geometry_for",
    "integrate_log",
    "integrate_scan",
    "load_map",
    "match_scan",
    "open_log",
    "plan_path",
    "sample_log",
    "save_map",
    "slam_log",
    "write_mcap",
]

__getattr__ = imported_later(__name__, __file__)
