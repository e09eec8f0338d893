"""Merged partial maps against the map of all scans."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.merge import merged
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@given(cut=st.integers(0, 150), prior=st.sampled_from([0.0, 0.25, -0.5]))
@settings(max_examples=15)
def test_partial_maps_add_up_to_the_whole(office_log: ScanLog, update: str, cut: int, prior: float) -> None:
    # Quarters are exact in float32, so not even the order of additions shows.
    config = MappingConfig(
        update=update, clamp=False, log_odds_hit=0.75, log_odds_miss=-0.25, log_odds_prior=prior, resolution=0.2
    )
    geometry = geometry_for(office_log, config)
    whole, first, second = (OccupancyGrid(geometry, prior) for _ in range(3))
    integrate_log(whole, office_log, config)
    integrate_log(first, office_log, config, stop=cut)
    integrate_log(second, office_log, config, start=cut)
    both = merged(first, second)
    assert both.geometry == geometry
    np.testing.assert_array_equal(both.log_odds, whole.log_odds)
    np.testing.assert_array_equal(both.observed, whole.observed)


@given(st.integers(-30, 30), st.integers(-30, 30), st.sampled_from([0.0, 0.7, -2.0]))
def test_grids_of_other_extent_are_laid_over_one_another(row: int, col: int, yaw: float) -> None:
    a = OccupancyGrid(GridGeometry(0.1, 20, 30, (1.0, 2.0, yaw)), 0.5)
    corner = a.geometry.cell_to_world((row - 0.5, col - 0.5))
    b = OccupancyGrid(GridGeometry(0.1, 25, 10, (corner[0], corner[1], yaw)), 0.5)
    a.log_odds[3, 4], a.observed[3, 4] = 2.0, True
    b.log_odds[6, 7], b.observed[6, 7] = -1.0, True
    both = merged(a, b)
    assert both.log_odds.sum() == pytest.approx(0.5 * both.log_odds.size + 1.5 - 1.5)
    assert both.observed.sum() == 1 + ((row + 6, col + 7) != (3, 4))
    for grid, cell, single_threaded in ((a, (3, 4), 2.0), (b, (6, 7), -1.0)):
        r, c = both.geometry.world_to_cell(grid.geometry.cell_to_world(cell))
        assert both.observed[r, c]
        assert both.log_odds[r, c] == (single_threaded if (row + 6, col + 7) != (3, 4) else 0.5)


def test_maps_that_do_not_fit_are_refused() -> None:
    a = OccupancyGrid(GridGeometry(0.1, 20, 30))
    for geometry, why in (
        (GridGeometry(0.2, 20, 30), "no cells in common"),
        (GridGeometry(0.1, 20, 30, (0.0, 0.0, 0.1)), "no cells in common"),
        (GridGeometry(0.1, 20, 30, (0.05, 0.0, 0.0)), "0.5 columns apart"),
    ):
        with pytest.raises(ConfigError, match=why):
            merged(a, OccupancyGrid(geometry))
    with pytest.raises(ConfigError, match="priors differ"):
        merged(a, OccupancyGrid(a.geometry, 0.1))
    small = OccupancyGrid(GridGeometry(0.1, 20, 30, limits=Limits(max_cells=1000)))
    with pytest.raises(LimitError):
        merged(small, OccupancyGrid(GridGeometry(0.1, 20, 30, (50.0, 50.0, 0.0))))


def test_maps_that_went_on_from_different_maps_or_count_are_refused() -> None:
    geometry = GridGeometry(0.1, 2, 3)
    known = np.array([[1.0, np.nan, 0.5], [np.nan, np.nan, -1.0]], dtype=np.float32)
    a, same, other = (OccupancyGrid(geometry, 0.0, map_) for map_ in (known, known.copy(), known + np.float32(0.5)))
    np.testing.assert_array_equal(merged(a, same).log_odds, np.nan_to_num(known))
    with pytest.raises(ConfigError, match="prior maps differ"):
        merged(a, other)
    counted = OccupancyGrid(geometry)
    counted.cell_statistics = np.zeros((2, 2, 3), dtype=np.float32)
    for pair in ((counted, OccupancyGrid(geometry)), (OccupancyGrid(geometry), counted)):
        with pytest.raises(ConfigError, match="maps of log-odds"):
            merged(*pair)
