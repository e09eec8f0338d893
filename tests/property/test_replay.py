"""A replay has the map of the first k scans, after any sequence of seeks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.grid import CellBox, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog, Trajectory


@pytest.fixture(scope="module")
def log() -> ScanLog:
    random = np.random.default_rng(3)
    n = 25
    poses = np.cumsum(random.normal(0, [0.3, 0.3, 0.2], (n, 3)), axis=0)
    return ScanLog(
        random.uniform(0.2, 9, (n, 40)).astype(np.float32),
        -2.0,
        0.1,
        0.1,
        8.0,
        np.arange(n, dtype=np.int64),
        {"walk": Trajectory(poses), "still": Trajectory(np.zeros((n, 3)))},
        mount=(0.2, 0.0, 0.1),
    )


def one_go(log: ScanLog, config: MappingConfig, stop: int, trajectory: str | None = None) -> OccupancyGrid:
    grid = OccupancyGrid(geometry_for(log, config, trajectory), config.log_odds_prior)
    integrate_log(grid, log, config, trajectory, 0, stop)
    return grid


def same(ours: OccupancyGrid, theirs: OccupancyGrid) -> bool:
    return (
        ours.geometry == theirs.geometry
        and np.array_equal(ours.log_odds, theirs.log_odds)
        and np.array_equal(ours.observed, theirs.observed)
    )


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@given(jumps=st.lists(st.integers(0, 25), min_size=1, max_size=6))
@settings(max_examples=25)
def test_any_order_of_jumps_is_the_map_made_in_one_go(log: ScanLog, update: str, jumps: list[int]) -> None:
    config = MappingConfig(update=update, resolution=0.2)
    replay = Replay(log, config)
    for index in jumps:
        before = replay.grid.log_odds.copy()
        change = replay.advance_to(index)
        assert replay.index == index
        assert not change.geometry_changed
        different = np.argwhere(replay.grid.log_odds != before)
        if len(different):
            box = change.box
            assert box is not None
            assert (different >= [box.row0, box.col0]).all()
            assert (different < [box.row1, box.col1]).all()
    assert same(replay.grid, one_go(log, config, jumps[-1]))


def test_a_map_made_in_parts_is_the_map_made_in_one_go(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    config = MappingConfig(resolution=0.2)
    monkeypatch.setattr("mapper.replay.replay.PART_READINGS", 3 * log.n_beams)
    replay = Replay(log, config)
    change = replay.advance_to(20)
    assert same(replay.grid, one_go(log, config, 20))
    rows, cols = np.nonzero(replay.grid.observed)
    assert change.box is not None
    assert change.box == CellBox(rows.min(), rows.max() + 1, cols.min(), cols.max() + 1)
    finer = MappingConfig(resolution=0.1)
    replay.reconfigure(finer)
    assert same(replay.grid, one_go(log, finer, 20))


def test_a_map_that_is_not_wanted_any_more_is_not_finished(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mapper.replay.replay.PART_READINGS", log.n_beams)
    replay = Replay(log, MappingConfig(resolution=0.2))
    answers = iter([True, True, False])
    replay.may_continue = lambda: next(answers)
    with pytest.raises(WorkCancelledError):
        replay.advance_to(20)


def test_advancing_scan_by_scan_equals_mapping_the_whole_log(log: ScanLog) -> None:
    config = MappingConfig(resolution=0.2, window=0.4)
    whole = one_go(log, config, log.n_scans)
    grid = OccupancyGrid(whole.geometry)
    poses = log.sensor_poses()
    for t in range(log.n_scans):
        assert not integrate_scan(grid, log.scan(t), poses[t], config).geometry_changed
    assert same(grid, whole)


def test_reconfigure_recomputes_the_map_at_the_same_index(log: ScanLog) -> None:
    replay = Replay(log, MappingConfig(resolution=0.2))
    replay.advance_to(20)
    wider = MappingConfig(resolution=0.2, window=0.6)
    assert replay.reconfigure(wider).cells_updated > 0
    assert replay.index == 20
    assert same(replay.grid, one_go(log, wider, 20))
    coarse = replay.reconfigure(MappingConfig(resolution=0.5))
    assert coarse.geometry_changed
    assert same(replay.grid, one_go(log, MappingConfig(resolution=0.5), 20))


def test_a_trajectory_by_name(log: ScanLog) -> None:
    replay = Replay(log, MappingConfig(), "still")
    replay.advance_to(25)
    assert same(replay.grid, one_go(log, MappingConfig(), 25, "still"))
    with pytest.raises(ConfigError, match="no trajectory 'odom'"):
        Replay(log, MappingConfig(), "odom")


def test_an_invalid_request_does_not_change_the_replay(log: ScanLog) -> None:
    replay = Replay(log, MappingConfig(resolution=0.2), limits=Limits(max_cells=1 << 18))
    replay.advance_to(7)
    before = replay.grid.log_odds.copy()
    with pytest.raises(ConfigError, match="no map after 26"):
        replay.advance_to(26)
    with pytest.raises(ConfigError, match="no map after -1"):
        replay.advance_to(-1)
    with pytest.raises(LimitError, match="coarser"):
        replay.reconfigure(MappingConfig(resolution=0.01))
    assert (replay.index, replay.config.resolution) == (7, 0.2)
    np.testing.assert_array_equal(replay.grid.log_odds, before)
