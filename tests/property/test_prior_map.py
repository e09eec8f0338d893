"""Mapping that continues from a map: no cell moves or is lost, and the prior is counted once."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.merge import merged
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog

#: Increments that float32 adds without rounding.
CONFIG = MappingConfig(resolution=0.1, clamp=False, range_max=8.0, log_odds_hit=0.75, log_odds_miss=-0.25)


def half_way(log: ScanLog, config: MappingConfig) -> OccupancyGrid:
    grid = grid_for(log, config)
    integrate_log(grid, log, config, stop=log.n_scans // 2)
    return grid


def test_mapping_two_halves_in_turn_equals_mapping_the_whole(office_log: ScanLog) -> None:
    whole = grid_for(office_log, CONFIG)
    integrate_log(whole, office_log, CONFIG)
    second = grid_for(office_log, CONFIG, prior=half_way(office_log, CONFIG))
    integrate_log(second, office_log, CONFIG, start=office_log.n_scans // 2)
    np.testing.assert_array_equal(second.log_odds, whole.log_odds)
    np.testing.assert_array_equal(second.observed, whole.observed)


def test_the_prior_map_is_counted_once_when_its_continuations_are_merged(office_log: ScanLog) -> None:
    prior, n = half_way(office_log, CONFIG), office_log.n_scans
    parts = []
    for start, stop in ((n // 2, 3 * n // 4), (3 * n // 4, n)):
        grid = grid_for(office_log, CONFIG, prior=prior)
        integrate_log(grid, office_log, CONFIG, start=start, stop=stop)
        parts.append(grid)
    both = grid_for(office_log, CONFIG, prior=prior)
    integrate_log(both, office_log, CONFIG, start=n // 2)
    np.testing.assert_array_equal(merged(*parts).log_odds, both.log_odds)


def test_a_rotated_prior_map_keeps_its_pose_and_grows(office_log: ScanLog) -> None:
    geometry = GridGeometry(0.1, 20, 30, (2.0, 1.0, 0.7))
    known = OccupancyGrid(geometry)
    known.log_odds[5, 7], known.observed[5, 7] = 2.5, True
    grid = grid_for(office_log, CONFIG, prior=known)
    assert grid.geometry.origin[2] == 0.7
    assert grid.geometry.rows > 20
    row, col = grid.geometry.world_to_cell(geometry.cell_to_world((5, 7)))
    assert (grid.log_odds[row, col], grid.observed[row, col]) == (2.5, True)
    assert np.count_nonzero(grid.observed) == 1
    assert integrate_log(grid, office_log, CONFIG) > 1000
    assert np.count_nonzero(grid.observed) > 1000


@pytest.mark.parametrize("model", MODELS)
def test_a_replay_to_scan_0_restores_the_prior_map(office_log: ScanLog, model: str) -> None:
    config = CONFIG.with_values({"model": model, "clamp": True})
    replay = Replay(office_log, config, prior=half_way(office_log, CONFIG.with_values({"clamp": True})))
    replay.advance_to(20)
    there = replay.grid.log_odds.copy()
    row, col = np.argwhere(there != replay.grid.prior())[0]
    told = replay.provenance(int(row), int(col))
    assert told.before == pytest.approx(float(replay.grid.prior()[row, col]))
    assert told.after == pytest.approx(float(there[row, col]), abs=1e-5)
    replay.advance_to(0)
    np.testing.assert_array_equal(replay.grid.log_odds, replay.grid.prior())
    replay.advance_to(20)
    np.testing.assert_array_equal(replay.grid.log_odds, there)


def test_cells_of_another_size_are_refused(office_log: ScanLog) -> None:
    with pytest.raises(ConfigError, match="must be the same"):
        grid_for(office_log, CONFIG, prior=OccupancyGrid(GridGeometry(0.05, 10, 10)))


def test_a_prior_map_is_finite_and_of_the_grids_shape() -> None:
    for prior in (np.zeros((2, 3), np.float32), np.full((2, 2), np.inf, np.float32)):
        with pytest.raises(ConfigError, match="prior map"):
            OccupancyGrid(GridGeometry(1.0, 2, 2), 0.0, prior)
