"""Real logs: kernel against textbook on some scans, and against counting in NumPy on all scans."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.logs import open_log
from mapper.mapping import textbook
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import provenance
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog, Trajectory
from tests.marks import also_long

LOGS = ["intel-corrected.log.gz", *also_long("aces-corrected.log.gz", "fhw-corrected.log.gz")]


@pytest.fixture(scope="module", params=LOGS)
def log(request: pytest.FixtureRequest, data_dir: Path) -> ScanLog:
    return open_log(data_dir / "carmen" / request.param)


def thinned(log: ScanLog, n_scans: int) -> ScanLog:
    chosen = np.linspace(0, log.n_scans - 1, n_scans).astype(int)
    some = log.take(chosen)
    return replace(some, trajectories={"thinned": Trajectory(some.trajectory().poses)})


@pytest.mark.parametrize("config", [MappingConfig(), MappingConfig(window=0.3, model="step_window", no_return="free")])
def test_per_beam(log: ScanLog, config: MappingConfig) -> None:
    few = thinned(log, 4)
    geometry = geometry_for(few, config)
    ours, theirs = OccupancyGrid(geometry), OccupancyGrid(geometry)
    count = integrate_log(ours, few, config)
    poses = few.sensor_poses()
    assert count == sum(textbook.update_per_beam(theirs, few.scan(t), poses[t], config) for t in range(few.n_scans))
    np.testing.assert_array_equal(ours.log_odds, theirs.log_odds)
    np.testing.assert_array_equal(ours.observed, theirs.observed)


@pytest.mark.parametrize("window", [0.0, 0.3])
def test_per_scan(log: ScanLog, window: float) -> None:
    config = MappingConfig(update="per_scan", window=window, range_max=8.0)
    few = thinned(log, 2)
    poses = few.sensor_poses()
    for t in range(few.n_scans):
        x, y, _ = poses[t]
        geometry = GridGeometry(0.05, 300, 200, (x - 4.0, y - 9.0, 0.0))
        ours, theirs = OccupancyGrid(geometry), OccupancyGrid(geometry)
        count = integrate_log(ours, few, config, start=t, stop=t + 1)
        assert count == textbook.update_per_scan(theirs, few.scan(t), poses[t], config) > 1000
        np.testing.assert_array_equal(ours.log_odds, theirs.log_odds)


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@pytest.mark.parametrize("model", ["smooth_ramp", "sonar_cone", "moravec_elfes", "hit_counting"])
def test_the_other_models(log: ScanLog, model: str, update: str) -> None:
    config = MappingConfig(
        model=model, update=update, window=0.3, range_max=5.0, opening=0.1, cone_profile="gaussian", no_return="hit"
    )
    few = thinned(log, 2)
    few = replace(few, ranges=few.ranges[:, ::6].copy(), angle_increment=6 * few.angle_increment)
    poses = few.sensor_poses()
    for t in range(few.n_scans):
        x, y, _ = poses[t]
        geometry = GridGeometry(0.05, 140, 120, (x - 3.0, y - 3.5, 0.0))
        ours, theirs = OccupancyGrid(geometry), OccupancyGrid(geometry)
        count = integrate_log(ours, few, config, start=t, stop=t + 1)
        assert count == textbook.occupancy_grid_mapping(theirs, few.scan(t), poses[t], config) > 300
        np.testing.assert_array_equal(ours.observed, theirs.observed)
        np.testing.assert_allclose(ours.log_odds, theirs.log_odds, atol=1e-6 if model != "moravec_elfes" else 1e-5)
        if ours.cell_statistics is not None and theirs.cell_statistics is not None:
            np.testing.assert_allclose(ours.cell_statistics, theirs.cell_statistics, atol=1e-6)


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
def test_provenance(log: ScanLog, update: str) -> None:
    config = MappingConfig(update=update, window=0.2, no_return="free")
    replay = Replay(log, config)
    replay.advance_to(log.n_scans)
    grid, random = replay.grid, np.random.default_rng(3)
    for row, col in random.choice(np.argwhere(grid.observed), 20):
        told = replay.provenance(int(row), int(col))
        assert told.after == grid.log_odds[row, col]
        assert len(told.scans) > 0
    few = thinned(log, 3)
    poses, geometry = few.sensor_poses(), geometry_for(few, config)
    empty = OccupancyGrid(geometry)
    for z in (0.0, 1.0):  # where the sensor stands, and 1 m ahead of it
        cell = textbook.cell_at(empty, poses[1], 0.0, z)
        ours = provenance(geometry, few, config, cell)
        if update == "per_beam":
            scans = [few.scan(t) for t in range(few.n_scans)]
            theirs = textbook.provenance(empty, scans, poses, cell, config)
            assert list(zip(ours.scans.tolist(), ours.beams.tolist(), strict=True)) == [(t, k) for t, k, *_ in theirs]
            np.testing.assert_array_equal(ours.log_odds, np.array([value for *_, value in theirs], np.float32))
        else:
            assert (np.diff(ours.scans) > 0).all()


def hits_minus_misses(log: ScanLog, geometry: GridGeometry, range_max: float) -> np.ndarray:
    """Hits minus misses of each cell, by Bresenham's rule in closed form."""
    rows, cols = geometry.shape
    balance = np.zeros(rows * cols, dtype=np.int64)
    for ranges, (x, y, theta) in zip(log.ranges.astype(float), log.sensor_poses(), strict=True):
        valid = (ranges >= log.range_min) & (ranges <= min(range_max, log.range_max))
        bearing = theta + log.angles[valid]
        end_xy = np.stack([x + ranges[valid] * np.cos(bearing), y + ranges[valid] * np.sin(bearing)], axis=-1)
        (row, col), end = geometry.world_to_cell([x, y]), geometry.world_to_cell(end_xy)
        d = end - [row, col]
        a, b = np.abs(d).max(axis=1), np.abs(d).min(axis=1)
        beam = np.repeat(np.arange(len(d)), a)
        i = np.arange(len(beam)) - np.repeat(np.cumsum(a) - a, a)
        n = (2 * i * b[beam] + a[beam]) // (2 * a[beam])
        steep = (np.abs(d[:, 0]) > np.abs(d[:, 1]))[beam]
        r = row + np.sign(d[beam, 0]) * np.where(steep, i, n)
        c = col + np.sign(d[beam, 1]) * np.where(steep, n, i)
        np.subtract.at(balance, r * cols + c, 1)
        np.add.at(balance, end[:, 0] * cols + end[:, 1], 1)
    return balance.reshape(rows, cols)


def test_every_scan_of_a_log(log: ScanLog) -> None:
    config = MappingConfig(log_odds_hit=1.0, log_odds_miss=-1.0, clamp=False)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    expected = hits_minus_misses(log, grid.geometry, config.range_max)
    # Bearings are added here and turned there; where an endpoint lies on a cell's border the last bit decides.
    assert np.count_nonzero(grid.log_odds != expected) <= 1e-4 * np.count_nonzero(expected)
