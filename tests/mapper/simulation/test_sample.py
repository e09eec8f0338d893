"""The sample log: its map is that of its world, and its odometry drifts as the model states."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.grid import FREE, OCCUPIED, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import WORLDS, sample_log
from mapper.simulation.odometry import drifting_odometry


@pytest.fixture(scope="module")
def log():
    return sample_log()


def test_the_sample_has_its_two_trajectories_and_is_the_same_each_time(log):
    assert log.n_scans == 600
    assert list(log.trajectories) == ["true", "odometry"]
    again = sample_log(40)
    np.testing.assert_array_equal(again.ranges, log.ranges[:40])
    np.testing.assert_array_equal(again.trajectory("odometry").poses[:40], sample_log(40).trajectory("odometry").poses)
    true, odometry = (log.trajectory(name).poses for name in ("true", "odometry"))
    gap = np.hypot(*(true - odometry)[:, :2].T)
    assert gap[0] == 0.0
    assert 0.3 < gap.max() < 5.0  # enough to see walls double, and still an office


def test_with_true_poses_the_map_is_the_world(log):
    config = MappingConfig()
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    world = WORLDS["office"]
    state = grid.classify()
    occupied = world.clearance(grid.geometry.cell_to_world(np.argwhere(state == OCCUPIED)))
    assert len(occupied) > 2000
    assert (np.abs(occupied) <= 0.1).mean() >= 0.98
    free = world.clearance(grid.geometry.cell_to_world(np.argwhere(state == FREE)))
    assert (free > -0.05).mean() >= 0.999
    # Most of the floor was seen.
    assert len(free) * config.resolution**2 > 0.6 * 230.0


def test_with_odometry_the_map_is_worse(log):
    config = MappingConfig()
    off = {}
    for name in log.trajectories:
        grid = OccupancyGrid(geometry_for(log, config, name))
        integrate_log(grid, log, config, name)
        cells = grid.geometry.cell_to_world(np.argwhere(grid.classify() == OCCUPIED))
        off[name] = (np.abs(WORLDS["office"].clearance(cells)) > 0.1).mean()
    assert off["odometry"] > off["true"] + 0.2


def test_without_noise_or_bias_odometry_is_the_truth():
    rng = np.random.default_rng(0)
    motions = np.column_stack([rng.uniform(-0.2, 0.4, 200), np.zeros(200), rng.uniform(-0.4, 0.4, 200)])
    poses = [np.array([1.0, 2.0, 0.5])]
    for motion in motions:
        poses.append(compose(poses[-1], motion))
    got = drifting_odometry(poses, rng, (0.0, 0.0, 0.0, 0.0), 0.0)
    np.testing.assert_allclose(got[:, :2], np.array(poses)[:, :2], atol=1e-9)
    assert np.abs(np.angle(np.exp(1j * (got - poses)[:, 2]))).max() < 1e-9


def test_odometrys_noise_grows_with_the_way_however_it_is_cut():
    """100 m straight on: σ of the length is α₃ √100, of the heading α₂ √2 √100, and the bias turns it by 100 biases."""
    for n in (51, 501):
        path = np.column_stack([np.linspace(0.0, 100.0, n), np.zeros(n), np.zeros(n)])
        ends = []
        for seed in range(300):
            rng = np.random.default_rng(seed)
            ends.append(drifting_odometry(path, rng, (0.0, 0.002, 0.02, 0.0), 0.001)[[0, -1]])
        last = np.array(ends)[:, 1]
        assert last[:, 2].mean() == pytest.approx(0.1, abs=0.01)
        assert last[:, 2].std() == pytest.approx(0.002 * np.sqrt(200.0), rel=0.15)
    lengths = [drifting_odometry(path, np.random.default_rng(s), (0.0, 0.0, 0.02, 0.0), 0.0)[-1, 0] for s in range(300)]
    assert np.std(lengths) == pytest.approx(0.2, rel=0.15)


def test_the_first_pose_is_the_frame(log):
    true = log.trajectory("true").poses
    moved = drifting_odometry(true, np.random.default_rng(1), (0.0, 0.0, 0.0, 0.0), 0.0)
    np.testing.assert_allclose(compose(inverse(moved[0]), moved[-1]), compose(inverse(true[0]), true[-1]), atol=1e-6)
    assert len(drifting_odometry(true[:1], np.random.default_rng(1))) == 1
