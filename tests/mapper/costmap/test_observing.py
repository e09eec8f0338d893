"""Scans as observations of the obstacle layers, and a static layer whose map changes."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.costmap import LETHAL, CostmapConfig, KeepoutLayer, StaticConfig, StaticLayer
from mapper.costmap.layers import observation_of_scan
from mapper.grid import CellBox, GridGeometry
from mapper.sensors.scan import LaserScan


def test_the_end_points_of_a_scan_are_in_the_map() -> None:
    ranges = np.array([2.0, np.inf, np.nan, 0.05, 1.0], dtype=np.float32)
    scan = LaserScan(ranges, 0.0, np.pi / 2, 0.1, 8.0, stamp_ns=1_500_000_000)
    seen = observation_of_scan(scan, (1.0, 2.0, np.pi / 2), height=0.3)
    np.testing.assert_allclose(seen.sensor, [1.0, 2.0, 0.3])
    # Two beams have valid readings: ahead of the sensor, which looks along y, and once around.
    np.testing.assert_allclose(seen.points, [[1.0, 4.0, 0.3], [1.0, 3.0, 0.3]], atol=1e-6)
    assert seen.stamp == 1.5
    with_free = observation_of_scan(scan, (1.0, 2.0, np.pi / 2), inf_is_valid=True)
    np.testing.assert_allclose(with_free.points[1], [1.0 - 7.9999, 2.0, 0.0], atol=1e-6)


def test_a_renewed_part_of_the_map_changes_the_box_of_the_cells_that_differ() -> None:
    geometry = GridGeometry(0.1, 20, 30)
    values = np.zeros((20, 30), dtype=np.int8)
    layer = StaticLayer(geometry, values, StaticConfig(), CostmapConfig())
    assert layer.changed(0.0, None) == CellBox(0, 20, 0, 30)
    part = np.zeros((5, 6), dtype=np.int8)
    layer.renew(part, CellBox(3, 8, 4, 10))
    assert layer.changed(0.0, None) is None  # nothing differs
    part[1, 2] = part[2, 4] = 100
    layer.renew(part, CellBox(3, 8, 4, 10))
    assert layer.changed(0.0, None) == CellBox(4, 6, 6, 9)
    assert np.argwhere(layer.costs == LETHAL).tolist() == [[4, 6], [5, 8]]
    assert not values.any()  # the reference map is not written to
    with pytest.raises(ConfigError, match="box has"):
        layer.renew(part, CellBox(0, 2, 0, 2))


def test_cleared_zones_change_the_box_around_them() -> None:
    layer = KeepoutLayer(GridGeometry(0.1, 20, 30))
    layer.clear()
    assert layer.changed(0.0, None) is None
    layer.paint(np.array([[0.5, 0.5], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]]), 100)
    painted = layer.changed(0.0, None)
    layer.clear()
    assert layer.changed(0.0, None) == painted
    assert (layer.costs == 255).all()
