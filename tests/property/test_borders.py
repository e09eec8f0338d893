"""The border of the grid: rays are clipped and never wrap, growth moves no cell."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.grid import TILE, GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_log, integrate_scan
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory

SIDE = 40


def log_of(ranges: list[float], bearing: float, pose: tuple[float, float, float]) -> ScanLog:
    readings = np.array([ranges], dtype=np.float32)
    return ScanLog(
        readings, bearing, 0.02, 0.0, 80.0, np.zeros(1, dtype=np.int64), {"one": Trajectory(np.array([pose]))}
    )


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@settings(max_examples=40)
@given(
    quarter=st.sampled_from([0, 1, 2, 3]),
    place=st.tuples(st.floats(0.5, 3.5), st.floats(0.5, 3.5)),
    tilt=st.floats(-0.6, 0.6),
    ranges=st.lists(st.floats(4.5, 30) | st.just(np.inf), min_size=1, max_size=6),
    window=st.sampled_from([0.0, 0.5]),
)
def test_a_ray_that_leaves_the_grid_does_not_change_the_opposite_edge(
    model, update, quarter, place, tilt, ranges, window
) -> None:
    config = MappingConfig(model=model, update=update, no_return="free", window=window, opening=0.3)
    grid = OccupancyGrid(GridGeometry(0.1, SIDE, SIDE))
    grid.log_odds[:] = np.random.default_rng(quarter).normal(size=grid.log_odds.shape)
    before = grid.log_odds.copy()
    sensor = (*place, quarter * np.pi / 2)
    integrate_log(grid, log_of(ranges, tilt, sensor), config)
    # Beams go within 60° of the heading, so what lies behind the sensor is not theirs to touch.
    cell = grid.geometry.world_to_cell(place)
    behind = [np.s_[:, : cell[1]], np.s_[: cell[0], :], np.s_[:, cell[1] + 1 :], np.s_[cell[0] + 1 :, :]][quarter]
    np.testing.assert_array_equal(grid.log_odds[behind], before[behind])
    assert not grid.observed[behind].any()


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@given(yaw=st.sampled_from([0.0, 0.4, -2.0]), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_growth_does_not_move_cells(model: str, update: str, yaw: float, seed: int) -> None:
    config = MappingConfig(model=model, update=update, log_odds_prior=0.25, opening=0.3)
    # Numbers that no cell's border coincides with: an origin computed again by growth differs in its last bits.
    random = np.random.default_rng(seed)
    grid = OccupancyGrid(GridGeometry(0.1, 30, 50, (-1.0, -2.0, yaw)), config.log_odds_prior)
    corner = grid.geometry.cell_to_world((-384.5, -384.5))
    large = OccupancyGrid(GridGeometry(0.1, 800, 800, (corner[0], corner[1], yaw)), config.log_odds_prior)
    for _ in range(4):
        pose = random.uniform([-15, -15, -3], [15, 15, 3])
        scan = LaserScan(random.uniform(0, 9, 9).astype(np.float32), -2.0, 0.5, 0.0, 80.0)
        old, old_log_odds = grid.geometry, grid.log_odds
        change = integrate_scan(grid, scan, pose, config)
        integrate_scan(large, scan, pose, config)
        assert change.geometry_changed == (grid.geometry != old)
        if change.geometry_changed:
            moved = grid.geometry.world_to_cell(old.cell_to_world((0, 0)))
            assert np.all(moved % TILE == 0)
        else:
            assert grid.log_odds is old_log_odds
    assert large.geometry.shape == (800, 800)
    row, col = large.geometry.world_to_cell(grid.geometry.cell_to_world((0, 0)))
    rows, cols = grid.geometry.shape
    part = np.s_[row : row + rows, col : col + cols]
    # Evidence that changes smoothly over the cells changes a little where the origin's last bits do.
    smooth = model in ("smooth_ramp", "sonar_cone", "moravec_elfes")
    np.testing.assert_allclose(large.log_odds[part], grid.log_odds, rtol=0, atol=1e-6 if smooth else 0)
    assert large.observed.sum() == grid.observed.sum()
