"""The benchmark counts the updates of the map; its times are not checked here."""

from dataclasses import replace

import pytest

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from mapper.tools.bench import bench_map


def test_bench_map(office_log: ScanLog) -> None:
    config = MappingConfig(resolution=0.2)
    figures = bench_map(office_log, config, repeats=2)
    for update, cells in (("per_beam", "cells"), ("per_scan", "per_scan_cells")):
        kind = replace(config, update=update)
        grid = OccupancyGrid(geometry_for(office_log, kind))
        assert figures[cells] == integrate_log(grid, office_log, kind) > 0
        assert figures[f"{update}_ms"] > 0
    with pytest.raises(ConfigError, match="at least one"):
        bench_map(office_log, config, repeats=0)
