"""A replay goes on with a log of other trajectories only where its map stays what it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.replay import Replay
from mapper.sensors.scan import ScanLog, Trajectory


def straight(n: int = 20) -> np.ndarray:
    return np.stack([0.2 * np.arange(n), np.zeros(n), np.zeros(n)], axis=1)


def log_with(poses: np.ndarray) -> ScanLog:
    ranges = np.full((len(poses), 20), 2.0, dtype=np.float32)
    stamps = np.arange(len(poses), dtype=np.int64) * 10**8
    return ScanLog(ranges, -1.5, 0.15, 0.1, 10.0, stamps, {"way": Trajectory(poses)})


def changed(log: ScanLog, scan: int, by: float) -> ScanLog:
    poses = log.trajectory().poses.copy()
    poses[scan:, 1] += by
    return replace(log, trajectories={"way": Trajectory(poses)})


def test_scans_that_are_not_in_the_map_may_have_other_poses() -> None:
    log = log_with(straight())
    replay = Replay(log)
    replay.advance_to(8)
    assert replay.adopt(replace(log, trajectories={**log.trajectories, "more": Trajectory(straight() + 1.0)}))
    assert [*replay.log.trajectories] == ["way", "more"]
    other = changed(log, 12, 0.1)
    assert replay.adopt(other)
    replay.advance_to(20)
    fresh = Replay(other)
    fresh.advance_to(20)
    assert replay.grid.geometry == fresh.grid.geometry
    np.testing.assert_array_equal(replay.grid.log_odds, fresh.grid.log_odds)


def test_a_map_that_would_be_another_is_not_gone_on_with() -> None:
    log = log_with(straight())
    replay = Replay(log)
    replay.advance_to(8)
    for other in (changed(log, 3, 0.1), changed(log, 8, 0.1), changed(log, 12, 500.0)):
        assert not replay.adopt(other)
        assert replay.log is log
    replay.advance_to(15)
    replay.advance_to(8)  # checkpoints may hold scans up to 15
    assert not replay.adopt(changed(log, 12, 0.1))
