"""Scans whose pose is not known are in no map: it is that of the other scans, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.diagnosis import examine
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.joint_log import JointLog
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import sample_log
from tests.mapper.localization.rooms import two_lidars

N = 40
KNOWN = (np.arange(N) % 7 != 0) & (np.arange(N) > 10)


@pytest.fixture(scope="module")
def log() -> ScanLog:
    whole = sample_log(N, "room")
    return replace(whole, trajectories={"true": whole.trajectory("true")})


def partly(log: ScanLog, known: np.ndarray) -> ScanLog:
    """The log, of which other poses are wrong and not known."""
    poses = log.trajectory("true").poses.copy()
    poses[~known] += [3.0, 2.0, 1.0]
    return replace(log, trajectories={"true": Trajectory(poses, is_known=known)})


@pytest.mark.parametrize("changed", [lambda log: log, two_lidars, lambda log: replace(log, time_increment=1e-3)])
def test_a_map_has_the_scans_whose_poses_are_known(log: ScanLog, changed: Callable[[ScanLog], ScanLog]) -> None:
    whole, config = changed(log), MappingConfig(resolution=0.1)
    known = np.repeat(KNOWN, whole.n_scans // N)
    grid = grid_for(whole, config, "true")
    expected = grid.emptied()
    integrate_log(expected, whole.take(known), config, "true")
    integrate_log(grid, partly(whole, known), config, "true")
    assert grid.observed.any()
    np.testing.assert_array_equal(grid.observed, expected.observed)
    np.testing.assert_array_equal(grid.log_odds, expected.log_odds)


def test_the_map_along_poses_of_which_none_is_known_is_empty(log: ScanLog) -> None:
    replay = Replay(partly(log, np.zeros(N, dtype=np.bool_)), MappingConfig(), "true")
    replay.advance_to(N)
    assert replay.index == N
    assert not replay.grid.observed.any()
    (finding,) = examine(replay.log)
    assert "0 readings of the 0 scans whose poses are known" in finding.sentence
    assert not replay.adopt(log), "with the poses known the map is another one"


def test_parts_of_a_log_and_sensors_keep_which_poses_are_known(log: ScanLog) -> None:
    known = partly(log, KNOWN)
    np.testing.assert_array_equal(known.take(slice(5, 30)).trajectory().is_known, KNOWN[5:30])
    of_both = np.arange(2 * N) % 3 != 0
    both = partly(two_lidars(log), of_both)
    assert isinstance(both, JointLog)
    for number, part in enumerate(both.parts):
        np.testing.assert_array_equal(part.trajectory().is_known, of_both[both.part_of_scan == number])
    np.testing.assert_array_equal(JointLog.of(both.parts).trajectory().is_known, of_both)
    seen = np.isfinite(at_middle_of_sweep(known).ranges).any(axis=1)
    np.testing.assert_array_equal(seen, KNOWN)


def test_what_is_known_is_said_of_each_pose() -> None:
    with pytest.raises(ConfigError, match="3 poses cannot be known"):
        Trajectory(np.zeros((3, 3)), is_known=np.ones(2, dtype=np.bool_))
