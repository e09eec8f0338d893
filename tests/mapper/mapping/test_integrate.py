"""Integration of scans: valid readings, mounts, errors."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.core.se2 import compose
from mapper.grid import CellBox, GridGeometry, OccupancyGrid
from mapper.mapping.integrate import Change, geometry_for, integrate_log, integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory

CONFIG = MappingConfig(resolution=1.0)
UPDATES = pytest.mark.parametrize("update", ["per_beam", "per_scan"])


def one_beam(z: float, range_min: float = 0.0, range_max: float = 8.0) -> LaserScan:
    return LaserScan(np.array([z], dtype=np.float32), 0.0, 0.01, range_min, range_max)


def corridor() -> OccupancyGrid:
    return OccupancyGrid(GridGeometry(1.0, 3, 12))


def log_of(n: int, **more: object) -> ScanLog:
    poses = np.column_stack([np.linspace(0, 4, n), np.zeros(n), np.linspace(0, 1, n)])
    ranges = np.linspace(1, 7, n * 20).reshape(n, 20).astype(np.float32)
    return ScanLog(ranges, -1.0, 0.1, 0.0, 80.0, np.arange(n), {"line": Trajectory(poses)}, **more)  # type: ignore[arg-type]


def test_a_beam_in_the_open() -> None:
    grid = corridor()
    change = integrate_scan(grid, one_beam(5.0), (0.5, 1.5, 0.0), CONFIG)
    miss, hit = np.float32(-0.4), np.float32(0.85)
    assert grid.log_odds[1].tolist() == [miss] * 5 + [hit] + [0.0] * 6
    assert grid.observed.sum() == 6
    assert change == Change(CellBox(1, 2, 0, 6), geometry_changed=False, cells_updated=6)


@pytest.mark.parametrize("prior", [0.0, -2.0, 3.5])
def test_cells_at_the_clamp_are_counted_and_observed(prior: float) -> None:
    grid = OccupancyGrid(GridGeometry(1.0, 3, 12), prior)
    assert CONFIG.clamp_limits == (-2.0, 3.5)
    for _ in range(20):
        change = integrate_scan(grid, one_beam(5.0), (0.5, 1.5, 0.0), CONFIG)
        assert change == Change(CellBox(1, 2, 0, 6), geometry_changed=False, cells_updated=6)
    assert grid.log_odds[1].tolist() == [-2.0] * 5 + [3.5] + [prior] * 6
    assert grid.observed[1].tolist() == [True] * 6 + [False] * 6


@pytest.mark.parametrize("z", [np.nan, -np.inf, -1.0, 0.05])
@UPDATES
def test_invalid_readings_add_no_evidence(z: float, update: str) -> None:
    grid = corridor()
    config = MappingConfig(update=update, no_return="free", resolution=1.0)
    assert integrate_scan(grid, one_beam(z, range_min=0.1), (0.5, 1.5, 0.0), config) == Change(None, False, 0)
    assert not grid.observed.any()


@pytest.mark.parametrize("z", [np.inf, 8.5, 81.83])
def test_no_return_is_ignored_or_free_up_to_the_smaller_max_range(z: float) -> None:
    grid = corridor()
    assert integrate_scan(grid, one_beam(z), (0.5, 1.5, 0.0), CONFIG).cells_updated == 0
    free = MappingConfig(no_return="free", resolution=1.0)
    assert integrate_scan(grid, one_beam(z), (0.5, 1.5, 0.0), free).cells_updated == 9
    nearer = replace(free, range_max=4.0)
    assert integrate_scan(grid, one_beam(z), (0.5, 1.5, 0.0), nearer).cells_updated == 5
    assert integrate_scan(grid, one_beam(4.5), (0.5, 1.5, 0.0), nearer).cells_updated == 5
    assert (grid.log_odds <= 0).all()


@UPDATES
def test_a_beam_of_zero_length_hits_the_sensors_own_cell(update: str) -> None:
    grid = corridor()
    change = integrate_scan(grid, one_beam(0.0), (2.5, 1.5, 0.7), MappingConfig(update=update, resolution=1.0))
    assert change == Change(CellBox(1, 2, 2, 3), False, 1)
    assert grid.log_odds[1, 2] == np.float32(0.85)


def test_per_scan_counts_a_cell_once_and_a_hit_before_a_miss() -> None:
    ranges = np.full(41, 6.0, dtype=np.float32)
    ranges[20] = 3.0
    fan = LaserScan(ranges, -0.1, 0.005, 0.0, 80.0)
    once, often = corridor(), corridor()
    integrate_scan(once, fan, (0.5, 1.5, 0.0), MappingConfig(update="per_scan", resolution=1.0))
    integrate_scan(often, fan, (0.5, 1.5, 0.0), CONFIG)
    # The cell beside the sensor: one miss, or one from each of 41 beams.
    assert once.log_odds[1, 1] == np.float32(-0.4)
    assert often.log_odds[1, 1] == np.float32(-2.0)
    # The short beam ends in a cell that others pass.
    assert once.log_odds[1, 3] == np.float32(0.85)
    assert often.log_odds[1, 3] == np.float32(-2.0)


def test_mounts_compose_and_a_hanging_laser_sweeps_the_other_way() -> None:
    mount, correction = (0.3, -0.2, 0.4), (0.1, 0.2, -0.3)
    config = MappingConfig(resolution=0.1, mount_x=0.1, mount_y=0.2, mount_yaw=-0.3)
    mounted = log_of(3, mount=mount)
    direct = replace(
        mounted, mount=(0.0, 0.0, 0.0), trajectories={"laser": Trajectory(compose(mounted.sensor_poses(), correction))}
    )
    ours = OccupancyGrid(geometry_for(mounted, config))
    theirs = OccupancyGrid(ours.geometry)
    integrate_log(ours, mounted, config)
    integrate_log(theirs, direct, MappingConfig(resolution=0.1))
    assert np.count_nonzero(ours.log_odds != theirs.log_odds) <= 2  # composed twice, rounded twice

    turned_over = replace(mounted, upside_down=True), replace(config, mount_upside_down=True)
    assert geometry_for(*turned_over) == geometry_for(mounted, config)
    assert (
        geometry_for(mounted, turned_over[1]) == geometry_for(turned_over[0], config) != geometry_for(mounted, config)
    )

    hanging = replace(mounted, upside_down=True)
    mirrored = replace(mounted, ranges=mounted.ranges[:, ::-1], angle_min=-mounted.angles[-1])
    grids = [OccupancyGrid(geometry_for(hanging, config)) for _ in range(2)]
    integrate_log(grids[0], hanging, MappingConfig(resolution=0.1, clamp=False))
    integrate_log(grids[1], mirrored, MappingConfig(resolution=0.1, clamp=False))
    np.testing.assert_allclose(grids[0].log_odds, grids[1].log_odds, atol=1e-5)


@UPDATES
@pytest.mark.parametrize("no_return", ["ignore", "free"])
def test_the_geometry_of_a_log_clips_nothing(update: str, no_return: str) -> None:
    log = log_of(6)
    config = MappingConfig(update=update, no_return=no_return, resolution=0.1, range_max=5.0, window=0.5)
    geometry = geometry_for(log, config)
    x, y, _ = geometry.origin
    larger = GridGeometry(0.1, geometry.rows + 256, geometry.cols + 256, (x - 12.8, y - 12.8, 0.0))
    grids = OccupancyGrid(geometry), OccupancyGrid(larger)
    assert integrate_log(grids[0], log, config) == integrate_log(grids[1], log, config)


def test_progress_counts_scans_and_changes_nothing() -> None:
    log = log_of(5)
    config = MappingConfig(resolution=0.1)
    plain, told = (OccupancyGrid(geometry_for(log, config)) for _ in range(2))
    calls: list[tuple[int, int]] = []
    count = integrate_log(plain, log, config, start=1)
    assert integrate_log(told, log, config, start=1, progress=lambda *call: calls.append(call)) == count
    assert calls[-1] == (4, 4)
    np.testing.assert_array_equal(plain.log_odds, told.log_odds)


def test_invalid_input_is_refused_and_changes_nothing() -> None:
    grid = corridor()
    with pytest.raises(ConfigError, match="finite"):
        integrate_scan(grid, one_beam(5.0), (np.nan, 0.0, 0.0), CONFIG)
    with pytest.raises(ConfigError, match="shape"):
        integrate_scan(grid, one_beam(5.0), (0.0, 0.0), CONFIG)
    with pytest.raises(ConfigError, match="from the origin"):
        integrate_scan(grid, one_beam(5.0), (1e9, 0.0, 0.0), CONFIG)
    with pytest.raises(LimitError, match="coarser"):
        integrate_scan(grid, one_beam(5.0), (9e5, 0.0, 0.0), CONFIG)
    assert grid.geometry == corridor().geometry
    assert not grid.observed.any()
    log = log_of(3)
    with pytest.raises(ConfigError, match="no scans 0 to 4"):
        integrate_log(grid, log, CONFIG, stop=4)
    with pytest.raises(LimitError, match="coarser"):
        geometry_for(log, CONFIG, limits=Limits(max_cells=1000))
    nothing = replace(
        log, ranges=log.ranges[:0], stamps_ns=log.stamps_ns[:0], trajectories={"none": Trajectory(np.zeros((0, 3)))}
    )
    with pytest.raises(ConfigError, match="without scans"):
        geometry_for(nothing, CONFIG)


def test_two_readings_of_moravec_and_elfes_worked_by_hand() -> None:
    # Cells of ½ m along the axis, ε = 1 m; s and z in cells. A reading of 5 says "empty" 1 − (s/3)² at s = 1, 2
    # and "occupied" 1 − ((s − 5)/2)² at s = 4, 5, 6, that is ¾, 1, ¾, which shared out over the arc are 0.3, 0.4, 0.3.
    # One of 3 then says "occupied" ¾, 1, ¾ at s = 2, 3, 4. At s = 2 the cell is empty by 5/9: ¾ · 4/9 = ⅓ is left.
    # Shared out, they are 0.16, 0.48, 0.36; and at s = 4, where 0.3 stood, that makes 0.3 + 0.36 − 0.3 · 0.36 = 0.552.
    config = MappingConfig(model="moravec_elfes", window=2.0, resolution=0.5, clamp=False)
    grid = OccupancyGrid(GridGeometry(0.5, 1, 9))
    readings, poses = np.array([[2.5], [1.5]], np.float32), np.tile((0.25, 0.25, 0.0), (2, 1))
    log = ScanLog(readings, 0.0, 0.01, 0.0, 80.0, np.zeros(2, np.int64), {"still": Trajectory(poses)})
    integrate_log(grid, log, config)  # in which the grid stays as large as it is, one row
    assert grid.cell_statistics is not None
    np.testing.assert_allclose(grid.cell_statistics[0, 0], [0, 0, 0.16, 0.48, 0.552, 0.4, 0.3, 0, 0], atol=1e-6)
    np.testing.assert_allclose(grid.cell_statistics[1, 0], [0, 8 / 9, 5 / 9, 0, 0, 0, 0, 0, 0], atol=1e-6)
    # Shown is the greater of both, "empty" below zero.
    shown = np.array([0, -8 / 9, -5 / 9, 0.48, 0.552, 0.4, 0.3, 0, 0])
    np.testing.assert_allclose(grid.p_occ[0], (1 + shown) / 2, atol=1e-6)
