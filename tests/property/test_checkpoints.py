"""Seeks by checkpoints give the same map as mapping from the start, to the last bit."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from threading import Thread

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, grid_for, integrate_log, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay, checkpoints
from mapper.replay.checkpoints import Checkpoints
from mapper.replay.replay import IncrementalReplay
from mapper.sensors.scan import ScanLog, Trajectory

N = 60
WAYS = [
    MappingConfig(resolution=0.1),
    MappingConfig(resolution=0.1, clamp=False, log_odds_prior=0.3, update="per_scan"),
    MappingConfig(resolution=0.1, log_odds_min=-0.7, log_odds_max=0.9, traversal="amanatides_woo", no_return="free"),
    MappingConfig(resolution=0.1, model="step_window", window=0.3),
    MappingConfig(resolution=0.1, model="smooth_ramp", update="per_scan"),
    MappingConfig(resolution=0.1, model="sonar_cone", opening=0.3),
    MappingConfig(resolution=0.1, model="moravec_elfes", opening=0.3, log_odds_prior=-0.4),
    MappingConfig(resolution=0.1, model="hit_counting"),
    MappingConfig(resolution=0.1, model="hit_counting", update="per_scan"),
]


def named(config: MappingConfig) -> str:
    return f"{config.model}, {config.update}"


@pytest.fixture(scope="module")
def log() -> ScanLog:
    random = np.random.default_rng(3)
    poses = np.cumsum(random.normal(0.15, [0.3, 0.3, 0.2], (N, 3)), axis=0)
    ranges = random.uniform(0.2, 4.0, (N, 12)).astype(np.float32)
    other = Trajectory(poses + np.array([0.0, 40.0, 0.5]))
    return ScanLog(
        ranges, -2.0, 0.3, 0.1, 3.7, np.arange(N, dtype=np.int64), {"walk": Trajectory(poses), "other": other}
    )


@pytest.fixture(autouse=True)
def _often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints after every few scans."""
    monkeypatch.setattr(checkpoints, "SPACING", 1000)
    monkeypatch.setattr(checkpoints, "WORTH_KEEPING", 0)
    monkeypatch.setattr("mapper.replay.replay.FIRST_READINGS", 24)


def assert_same(ours: OccupancyGrid, theirs: OccupancyGrid) -> None:
    """Compare bits: −0 is not +0 here."""
    assert ours.geometry == theirs.geometry
    assert ours.log_odds.tobytes() == theirs.log_odds.tobytes()
    np.testing.assert_array_equal(ours.observed, theirs.observed)
    if theirs.cell_statistics is not None and (ours.cell_statistics is not None or ours.observed.any()):
        assert ours.cell_statistics is not None
        assert ours.cell_statistics.tobytes() == theirs.cell_statistics.tobytes()


def one_go(
    log: ScanLog, config: MappingConfig, stop: int, trajectory: str | None = None, prior: OccupancyGrid | None = None
) -> OccupancyGrid:
    grid = grid_for(log, config, trajectory, prior=prior)
    integrate_log(grid, log, config, trajectory, 0, stop)
    return grid


def kept_by(replay: Replay) -> Checkpoints:
    return replay._replay.checkpoints


@pytest.mark.parametrize("config", WAYS, ids=named)
@given(jumps=st.lists(st.integers(0, N), min_size=1, max_size=5), prefetched=st.integers(0, 5), budget=st.booleans())
@settings(max_examples=12)
def test_seeks_of_every_model_end_at_the_map_made_in_one_go(
    log: ScanLog, config: MappingConfig, jumps: list[int], prefetched: int, budget: bool
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checkpoints, "BUDGET_BYTES", 20_000 if budget else 1 << 20)
        replay = Replay(log, config)
        replay.advance_to(4)
        for index in jumps:
            prefetcher = replay.prefetcher()
            for _ in range(prefetched if prefetcher else 0):
                assert prefetcher is not None
                prefetcher.step()
            before = replay.grid.log_odds.copy()
            change = replay.advance_to(index)
            assert_same(replay.grid, one_go(log, config, index))
            different = np.argwhere(replay.grid.log_odds != before)
            if len(different):
                assert change.box is not None
                assert (different >= [change.box.row0, change.box.col0]).all()
                assert (different < [change.box.row1, change.box.col1]).all()


@given(
    steps=st.lists(
        st.one_of(
            st.integers(0, N), st.sampled_from(WAYS), st.floats(0.5, 3.5).map(lambda m: {"range_max": round(m, 1)})
        ),
        min_size=2,
        max_size=6,
    )
)
@settings(max_examples=25)
def test_other_parameters_between_seeks_leave_nothing_of_the_old_ones(
    log: ScanLog, steps: list[int | MappingConfig | dict[str, float]]
) -> None:
    replay = Replay(log, WAYS[0])
    replay.advance_to(N // 2)
    for step in steps:
        if isinstance(step, int):
            replay.advance_to(step)
        else:
            replay.reconfigure(step if isinstance(step, MappingConfig) else replay.config.with_values(step))
        assert_same(replay.grid, one_go(log, replay.config, replay.index))


@pytest.mark.parametrize("config", WAYS[-3:-1], ids=named)
def test_seeks_go_back_to_a_prior_map(log: ScanLog, config: MappingConfig) -> None:
    prior = one_go(log, WAYS[0], N // 3, "other")  # partly the same place, partly another: the grid grows
    replay = Replay(log, config, prior=prior)
    assert replay.grid.geometry != prior.geometry
    for index in (N, 7, 0, 41, 40):
        replay.advance_to(index)
        assert_same(replay.grid, one_go(log, config, index, prior=prior))
    assert kept_by(replay).moments


def test_a_seek_maps_at_most_the_scans_between_two_checkpoints(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    replay = Replay(log, WAYS[0])
    replay.advance_to(N)
    moments = kept_by(replay).moments
    gaps = np.diff([0, *moments, N])
    assert len(moments) > 5
    mapped: list[int] = []

    def counted(grid: OccupancyGrid, log: ScanLog, *rest: object) -> object:
        mapped.append(int(rest[3]) - int(rest[2]))  # type: ignore[call-overload]
        return integrate_scans(grid, log, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr("mapper.replay.replay.integrate_scans", counted)
    for index in (1, N - 1, N // 2, N // 4, N):
        mapped.clear()
        replay.advance_to(index)
        assert sum(mapped) <= gaps.max()
    mapped.clear()
    replay.advance_to(moments[3])
    assert not mapped


def test_the_prefetcher_makes_all_checkpoints_during_a_replay(log: ScanLog) -> None:
    replay = Replay(log, WAYS[0])
    assert replay.prefetcher() is None  # nothing is known of the log yet
    replay.advance_to(3)
    prefetcher = replay.prefetcher()
    assert prefetcher is not None

    def walk() -> None:
        while prefetcher.step():
            pass

    thread = Thread(target=walk)
    thread.start()
    for index in (10, 2, 30, 25, 60, 0, 59):
        replay.advance_to(index)
        assert_same(replay.grid, one_go(log, WAYS[0], index))
    thread.join()
    assert replay.prefetcher() is None
    assert kept_by(replay).reached == N
    for moment in kept_by(replay).moments:
        replay.advance_to(moment)
        assert_same(replay.grid, one_go(log, WAYS[0], moment))


def test_checkpoints_stay_within_their_budget(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoints, "BUDGET_BYTES", 30_000)
    replay = Replay(log, WAYS[0])
    tracemalloc.start()
    try:
        replay.advance_to(N)
        held = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, "*/zstd.py")])
    finally:
        tracemalloc.stop()
    kept = kept_by(replay)
    assert 0 < kept.nbytes <= 30_000
    assert 0 < sum(trace.size for trace in held.traces) <= kept.nbytes
    assert kept.spacing > checkpoints.SPACING
    assert len(kept.moments) > 1


def test_one_moment_is_kept_however_large(log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoints, "BUDGET_BYTES", 1)
    replay = Replay(log, WAYS[0])
    for index in (N, 30, N - 1, 3):
        replay.advance_to(index)
        assert_same(replay.grid, one_go(log, WAYS[0], index))
    assert len(kept_by(replay).moments) == 1


def test_scans_that_touch_nothing(log: ScanLog) -> None:
    blind = replace(log, ranges=np.full_like(log.ranges, np.nan))
    grid = OccupancyGrid(geometry_for(log, WAYS[0]))
    blank = IncrementalReplay(blind, WAYS[0], "walk", grid)
    blank.go_to(N)
    assert blank.go_to(0).box is None
    assert not grid.observed.any()
