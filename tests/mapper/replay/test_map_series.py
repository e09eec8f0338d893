"""The series of a log's map, against maps that are made anew for each scan and beams that are walked cell by cell."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import WorkCancelledError
from mapper.core.se2 import compose
from mapper.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.textbook_traversal import amanatides_woo, bresenham
from mapper.replay import map_series as module
from mapper.replay.map_series import map_series
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.simulation import sample_log


@pytest.fixture(scope="module")
def log() -> ScanLog:
    """A run whose odometry drifts, with readings of all kinds, of 90 beams, which the tests walk along in Python."""
    log = sample_log(60)
    log = replace(log, ranges=log.ranges[:, ::4], angle_increment=4.0 * log.angle_increment)
    ranges = log.ranges.copy()
    ranges[5, ::7] = math.nan
    ranges[6, ::5] = math.inf
    ranges[20] = math.nan
    return replace(log, ranges=ranges)


def made_anew(log: ScanLog, config: MappingConfig, trajectory: str, scans: int) -> OccupancyGrid:
    grid = OccupancyGrid(geometry_for(log, config, trajectory))
    integrate_log(grid, log, config, trajectory, stop=scans)
    return grid


def bits(grid: OccupancyGrid) -> float:
    p = grid.p_occ[grid.observed]
    p = p[(p > 0.0) & (p < 1.0)]
    return float(-(p * np.log2(p) + (1.0 - p) * np.log2(1.0 - p)).sum())


def is_near_wall(states: np.ndarray, row: int, col: int) -> bool:
    rows, cols = states.shape
    return any(
        states[r, c] == OCCUPIED
        for r in range(max(0, row - 2), min(rows, row + 3))
        for c in range(max(0, col - 2), min(cols, col + 3))
        if abs(r - row) + abs(c - col) <= 2
    )


def contradicted(log: ScanLog, config: MappingConfig, trajectory: str, states: np.ndarray, scan: int) -> float:
    """Walk along each beam of a scan, as the definition says it."""
    geometry = geometry_for(log, config, trajectory)
    x, y, yaw = compose(log.trajectory(trajectory).poses[scan], log.mounts_at(scan))
    start = (int(cell) for cell in geometry.world_to_cell(np.array([x, y])))
    row0, col0 = start
    readings, against = 0, 0
    for beam, r in enumerate(log.ranges[scan].astype(float)):
        if math.isnan(r) or r < log.range_min or (r > log.range_max and config.no_return != "free"):
            continue
        ends = r <= min(log.range_max, config.range_max)
        reach = r if ends else min(log.range_max, config.range_max)
        angle = yaw + log.angle_min + beam * log.angle_increment
        end_xy = np.array([x + reach * math.cos(angle), y + reach * math.sin(angle)])
        row1, col1 = (int(cell) for cell in geometry.world_to_cell(end_xy))
        end = (row1, col1)
        if config.traversal == "amanatides_woo":
            (u0, v0), (u1, v1) = (map(float, geometry.to_lattice(xy)) for xy in (np.array([x, y]), end_xy))
            cells = amanatides_woo((u0, v0), (u1, v1))
        else:
            cells = bresenham((row0, col0), end)
        readings += 1
        passed = any(
            states[cell] == OCCUPIED
            and (
                not ends
                or r - geometry.resolution * math.dist(_place(geometry, (x, y)), (cell[0] + 0.5, cell[1] + 0.5))
                > 2 * geometry.resolution
            )
            for cell in cells
            if cell != end
        )
        against += passed or (ends and states[end] == FREE and not is_near_wall(states, *end))
    return 100.0 * against / readings if readings else math.nan


def _place(geometry, xy: tuple[float, float]) -> tuple[float, float]:
    u, v = geometry.to_lattice(np.array(xy))
    return float(v), float(u)


@pytest.mark.parametrize("traversal", ["bresenham", "amanatides_woo"])
@pytest.mark.parametrize("trajectory", ["true", "odometry"])
def test_each_scan_as_from_maps_that_are_made_anew(log: ScanLog, trajectory: str, traversal: str) -> None:
    config = MappingConfig(traversal=traversal)
    shares: list[float] = []
    series = map_series(log, config, trajectory, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert series.stamps_ns.tolist() == log.stamps_ns.tolist()
    final = made_anew(log, config, trajectory, log.n_scans).classify()
    before = np.full(final.shape, UNKNOWN)
    for scan in range(log.n_scans):
        grid = made_anew(log, config, trajectory, scan + 1)
        state = grid.classify()
        expected = bits(grid), np.count_nonzero(state != before), contradicted(log, config, trajectory, final, scan)
        assert series.values[scan] == pytest.approx(expected, rel=1e-6, nan_ok=True), scan
        before = state


def test_poses_that_drift_contradict_their_map_more() -> None:
    log = sample_log(300)
    true, drifting = (np.nanmean(map_series(log, MappingConfig(), name).values[:, 2]) for name in ("true", "odometry"))
    assert drifting > 1.5 * true


def test_of_a_long_log_each_row_is_of_several_scans(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = map_series(log, MappingConfig())
    monkeypatch.setattr(module, "ROWS", 9)
    series = map_series(log, MappingConfig())
    newest = [6, 13, 20, 27, 34, 41, 48, 55, 59]
    assert series.stamps_ns.tolist() == log.stamps_ns[newest].tolist()
    np.testing.assert_allclose(series.values[:, [0, 2]], whole.values[newest][:, [0, 2]], rtol=1e-9)


def test_of_several_lidars_each_scan_by_its_own_beams(log: ScanLog) -> None:
    """Every other scan is taken as another lidar's: the map is the same."""
    even, odd = (replace(log.take(slice(first, None, 2)), topic=name) for first, name in ((0, "/a"), (1, "/b")))
    alone, joint = (
        map_series(log, MappingConfig(), "true"),
        map_series(JointLog.of([even, odd]), MappingConfig(), "true"),
    )
    np.testing.assert_allclose(joint.values, alone.values, rtol=1e-6)


def test_the_computation_ends_when_it_is_not_wanted(log: ScanLog) -> None:
    with pytest.raises(WorkCancelledError):
        map_series(log, MappingConfig(), may_continue=lambda: False)
