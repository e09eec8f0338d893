"""SLAM with several lidars, and with lidars that take a while for a scan."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.evaluation import absolute_errors, align
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.simulation.lidar import SensorConfig
from mapper.slam import slam_log
from tests.mapper.slam.worlds import along, drive, sweeping, without_poses

PATH = along([(3.2, 1.25), (12.0, 1.25)], 0.3)
ROUND = along([(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)], 0.25, 0.25)
WIDE = SensorConfig(n_beams=180, field_of_view=2.0 * np.pi * 179 / 180, range_max=10.0, range_noise=0.01)
NARROW = SensorConfig(n_beams=60, field_of_view=np.pi / 2.0, range_max=8.0, range_noise=0.02)


def off(log: ScanLog, poses: np.ndarray) -> np.ndarray:
    """Distances of poses from the true ones, metres (n,)."""
    true = log.trajectory("true").poses
    return absolute_errors(true, align(true, poses).apply(poses))[0]


@pytest.mark.parametrize("has_odometry", [True, False])
def test_beams_are_moved_to_where_the_first_one_was_taken(has_odometry: bool) -> None:
    """A robot at 1.25 m/s whose scans take 0.2 s: taken as of one moment, their points are up to 0.25 m off."""
    log = sweeping("room", ROUND, sensor=WIDE, mount=(0.1, 0.0, np.pi / 2.0))
    log = log if has_odometry else without_poses(log)
    true = sweeping("room", ROUND, sensor=WIDE, mount=(0.1, 0.0, np.pi / 2.0)).trajectory("true")
    judged = replace(log, trajectories={**log.trajectories, "true": true})
    # Without odometry the robot's velocity during the first scans is not known.
    moved, rigid = (off(judged, slam_log(one).poses)[3:] for one in (log, replace(log, time_increment=0.0)))
    assert moved.mean() < 0.02
    assert moved.mean() < 0.6 * rigid.mean()


def test_two_lidars_see_more_than_one() -> None:
    """One looks ahead and one back, in a corridor's end; either by itself sees little."""
    front = drive("loop", PATH, sensor=NARROW, mount=(0.3, 0.0, 0.0), turn_bias=0.05)
    back = drive("loop", PATH, sensor=replace(NARROW, n_beams=45), mount=(-0.3, 0.0, np.pi), turn_bias=0.05)
    named = [
        replace(front, topic="/front"),
        replace(back, topic="/back", stamps_ns=back.stamps_ns + 30_000_000, trajectories=front.trajectories),
    ]
    both = JointLog.of(named)
    found = slam_log(both)
    assert found.poses.shape == (2 * len(PATH), 3)
    assert off(both, found.poses).max() < 0.1
    assert off(both, both.trajectory("odometry").poses).max() > 0.2
    # Poses of scans that were taken at one place, by the two, agree.
    assert np.hypot(*(found.poses[::2] - found.poses[1::2])[:, :2].T).max() < 0.05
    again = slam_log(both)
    assert again.poses.tobytes() == found.poses.tobytes()


def test_two_lidars_without_odometry() -> None:
    half = replace(WIDE, n_beams=120, field_of_view=np.pi)
    logs = [drive("room", ROUND, sensor=half, mount=mount) for mount in ((0.2, 0.0, 0.0), (-0.2, 0.0, np.pi))]
    true = logs[0].trajectory("true")
    both = JointLog.of(
        [without_poses(replace(log, topic=name)) for log, name in zip(logs, ("/front", "/back"), strict=True)]
    )
    judged = replace(both, trajectories={**both.trajectories, "true": replace(true, poses=np.repeat(true.poses, 2, 0))})
    assert off(judged, slam_log(both).poses).max() < 0.15


def test_a_sonar_among_lidars_is_refused() -> None:
    front = drive("room", ROUND[:5], sensor=NARROW)
    with pytest.raises(ConfigError, match="Sonars and lidars"):
        JointLog.of([replace(front, topic="/a"), replace(front, topic="/b", beam_width=0.3)])
