"""Two lidars of one robot make one map, in the order of time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.several import bounds_of_logs, integrate_logs, stretches
from mapper.sensors.scan import ScanLog, Trajectory
from tests.mapper.mapping.sweeping import HALF, off_the_walls, to_the_walls, true_poses

MOUNTS = {"front": (0.3, 0.1, 0.0), "rear": (-0.4, 0.0, 3.0)}


def seen_by(mount: tuple[float, float, float], rate: float, delay: float = 0.0) -> ScanLog:
    """Scans of half a turn, each taken at one moment."""
    times = 100.0 + delay + np.arange(int(4.0 * rate)) / rate
    bases = true_poses(times)
    bearings = np.zeros((180, 3))
    bearings[:, 2] = np.radians(np.arange(180) - 90.0)
    ranges = to_the_walls(compose(compose(bases, np.array(mount))[:, np.newaxis], bearings)).astype(np.float32)
    return ScanLog(
        ranges,
        -np.pi / 2,
        np.pi / 180,
        0.05,
        20.0,
        np.round(times * 1e9).astype(np.int64),
        {"true": Trajectory(bases, frame_id="odom")},
        mount=mount,
    )


def first_of(log: ScanLog, n: int) -> ScanLog:
    poses = {"true": Trajectory(log.trajectory().poses[:n])}
    return replace(log, ranges=log.ranges[:n], stamps_ns=log.stamps_ns[:n], trajectories=poses)


@pytest.fixture(scope="module")
def logs() -> list[ScanLog]:
    return [seen_by(MOUNTS["front"], 10.0), seen_by(MOUNTS["rear"], 7.0, 0.013)]


def made(logs: list[ScanLog], config: MappingConfig, count: int | None = None) -> OccupancyGrid:
    geometry = geometry_for(logs[0], config, bounds_of=lambda _, config, name: bounds_of_logs(logs, config, name))
    grid = OccupancyGrid(geometry)
    integrate_logs(grid, logs, config, count=count)
    return grid


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
def test_the_map_is_that_of_the_scans_one_by_one_in_the_order_of_time(logs: list[ScanLog], update: str) -> None:
    config = MappingConfig(update=update, log_odds_max=1.0)  # with a tight clamp the order of the scans matters
    grid = made(logs, config)
    expected = OccupancyGrid(grid.geometry)
    scans = sorted((log.stamps_ns[t], k, t) for k, log in enumerate(logs) for t in range(log.n_scans))
    for _, k, t in scans:
        integrate_scan(expected, logs[k].scan(t), logs[k].sensor_poses()[t], config)
    assert expected.geometry == grid.geometry
    np.testing.assert_array_equal(grid.log_odds, expected.log_odds)


def test_both_lidars_see_the_true_walls(logs: list[ScanLog]) -> None:
    both = made(logs, MappingConfig())
    assert np.quantile(off_the_walls(both), 0.99) < 0.06
    few = [first_of(log, 3) for log in logs]
    walls = [len(off_the_walls(made(part, MappingConfig()))) for part in (few, few[:1], few[1:])]
    assert walls[0] > 1.5 * max(walls[1:]), "one looks ahead, the other behind"
    low, high = bounds_of_logs(logs, MappingConfig())
    np.testing.assert_allclose([low, high], [-HALF, HALF], atol=0.01)


def test_scans_are_merged_in_order_of_time(logs: list[ScanLog]) -> None:
    taken = list(stretches(logs, 5))
    assert taken == [(0, 0, 1), (1, 0, 1), (0, 1, 2), (1, 1, 2), (0, 2, 3)]
    assert sum(stop - start for _, start, stop in stretches(logs)) == sum(log.n_scans for log in logs)


def test_scans_with_stamps_that_jump_back_keep_the_order_of_the_file(logs: list[ScanLog]) -> None:
    stamps = logs[0].stamps_ns.copy()
    stamps[5] = stamps[2]
    taken = [part for part in stretches([replace(logs[0], stamps_ns=stamps), logs[1]]) if part[0] == 0]
    assert [start for _, start, _ in taken] == sorted(start for _, start, _ in taken)
    assert taken[-1][2] == len(stamps)


def test_too_many_scans_and_a_missing_trajectory_are_refused(logs: list[ScanLog]) -> None:
    grid = made(logs, MappingConfig(), 0)
    with pytest.raises(ConfigError, match=r"no scans 0 to 1000; they have 68"):
        integrate_logs(grid, logs, MappingConfig(), count=1000)
    other = replace(logs[1], trajectories={"another": logs[1].trajectory()})
    with pytest.raises(ConfigError, match="no trajectory 'true'"):
        integrate_logs(grid, [logs[0], other], MappingConfig(), "true")
