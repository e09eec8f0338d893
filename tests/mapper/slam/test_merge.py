"""Two logs of one place, each in a frame of its own, in one map."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.evaluation import absolute_errors, align
from mapper.sensors.scan import ScanLog
from mapper.simulation.lidar import SensorConfig
from mapper.slam import MergeCancelled, MergeProgress, SlamConfig, map_along, merge_logs
from tests.mapper.slam.worlds import along, drive

WIDE = SensorConfig(n_beams=120, field_of_view=2.0 * np.pi * 119 / 120, range_max=10.0, range_noise=0.02)
FIRST = [(3.2, 1.25), (18.0, 1.25)]
SECOND = [(16.0, 1.4), (22.7, 1.4), (22.7, 8.0)]
CONFIG = SlamConfig(refinement=2)


def in_frame(log: ScanLog, origin: tuple[float, float, float]) -> ScanLog:
    """The log with its odometry in another frame, whose origin is there."""
    odometry = log.trajectory("odometry")
    moved = replace(odometry, poses=compose(inverse(np.array(origin)), odometry.poses))
    return replace(log, trajectories={**log.trajectories, "odometry": moved})


@pytest.fixture(scope="module")
def logs() -> tuple[ScanLog, ScanLog]:
    """The corridors of a loop, by two robots that saw a corner of it in common, with unlike lidars."""
    first = drive("loop", along([*FIRST, (22.7, 1.25), (22.7, 4.0)], 0.3), sensor=WIDE, turn_bias=0.01)
    second = drive("loop", along(SECOND, 0.3), mount=(0.2, 0.0, np.pi / 2), turn_bias=0.01, seed=8)
    return in_frame(first, (3.0, 1.0, 0.3)), in_frame(second, (-4.0, 9.0, 2.5))


def test_two_logs_in_one_frame(logs: tuple[ScanLog, ScanLog]) -> None:
    seen: list[MergeProgress] = []
    found = merge_logs(*logs, CONFIG, progress=seen.append)
    true = np.concatenate([log.trajectory("true").poses for log in logs])
    poses = np.concatenate(found.poses)
    off = absolute_errors(true, align(true, poses).apply(poses))[0]
    assert off.max() < 0.15
    assert len(found.loops) >= 3
    assert [one.fraction for one in seen] == sorted(one.fraction for one in seen)
    # One map holds both.
    grid = map_along(list(zip(logs, found.poses, strict=True)))
    alone = map_along([(logs[0], found.poses[0])])
    assert np.count_nonzero(grid.observed) > np.count_nonzero(alone.observed) + 1500
    assert not np.array_equal(grid.geometry.shape, alone.geometry.shape)
    with pytest.raises(MergeCancelled):
        merge_logs(*logs, CONFIG, results=found.results, progress=lambda one: one.stage != "loops")


def test_a_guess_of_the_second_frame(logs: tuple[ScanLog, ScanLog]) -> None:
    results = merge_logs(*logs, CONFIG).results
    guess = compose(inverse(np.array([3.0, 1.0, 0.3])), np.array([-4.0, 9.0, 2.5]))
    found = merge_logs(*logs, CONFIG, guess=guess + np.array([0.8, -0.6, 0.05]), results=results)
    np.testing.assert_allclose(found.placed[:2], guess[:2], atol=0.8)
    with pytest.raises(ConfigError, match="do not show the same place"):
        merge_logs(*logs, CONFIG, guess=guess + np.array([60.0, 0.0, 0.0]), results=results)


def test_logs_of_two_places(logs: tuple[ScanLog, ScanLog]) -> None:
    other = drive("room", along([(3.4, 3.6), (6.4, 3.6), (6.4, 5.4)], 0.3))
    with pytest.raises(ConfigError, match="do not show the same place"):
        merge_logs(logs[0], other, CONFIG)
    blind = replace(other, ranges=np.full_like(other.ranges, np.inf))
    with pytest.raises(ConfigError, match="no scan has"):
        merge_logs(logs[0], blind, CONFIG)
