"""Logs that SLAM can do little or nothing with: each is answered clearly."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.evaluation import absolute_errors, align
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.shapes import outer_walls
from mapper.simulation.worlds import World
from mapper.slam import SlamConfig, slam_log
from mapper.slam.estimate import estimate
from tests.mapper.slam.worlds import along, drive, without_poses

ROOM = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)]


@pytest.fixture(scope="module")
def room() -> ScanLog:
    """A round of a room, 40 scans or so."""
    return drive("room", along(ROOM, 0.3))


def off(log: ScanLog, poses: np.ndarray) -> float:
    """The greatest distance from the true poses, metres."""
    true = log.trajectory("true").poses
    return float(absolute_errors(true, align(true, poses).apply(poses))[0].max())


def test_no_scan_and_one_scan(room: ScanLog) -> None:
    with pytest.raises(ConfigError, match="no scans"):
        slam_log(room.take(slice(0, 0)))
    one = slam_log(room.take(slice(0, 1)))
    np.testing.assert_allclose(one.poses, room.trajectory().poses[:1])
    assert len(one.graph.i) == 0


def test_scans_without_returns_follow_the_odometry(room: ScanLog) -> None:
    ranges = room.ranges.copy()
    ranges[10:20] = np.inf
    found = slam_log(replace(room, ranges=ranges))
    assert off(room, found.poses) < 0.15
    assert "10 scans fit none" in found.notes[0]
    with pytest.raises(ConfigError, match="no scan has"):
        slam_log(replace(room, ranges=np.full_like(ranges, np.inf)))


def test_poses_that_are_no_numbers(room: ScanLog) -> None:
    poses = room.trajectory().poses.copy()
    poses[5, 0] = np.nan
    with pytest.raises(ConfigError, match=re.escape("Pose 5 is not finite")):
        replace(room, trajectories={"odometry": Trajectory(poses)})


def test_without_odometry_the_scans_are_enough() -> None:
    wide = SensorConfig(n_beams=180, field_of_view=1.5 * np.pi, range_max=10.0, range_noise=0.01)
    log = drive("room", along(ROOM, 0.2, 0.2), sensor=wide)
    found = slam_log(without_poses(log))
    assert found.odometry is None
    assert off(log, found.poses) < 0.15


def test_of_too_many_scans_some_are_matched() -> None:
    twice = without_poses(drive("room", along(ROOM, 0.07, 0.1)))
    found = slam_log(twice, SlamConfig(max_nodes=100))
    assert len(found.graph.nodes) <= 100
    assert len(found.poses) == twice.n_scans
    assert twice.n_scans > 100
    assert np.hypot(*np.diff(found.poses[:, :2], axis=0).T).max() < 0.3
    assert "100 were matched" in found.notes[0]


def test_a_trajectory_that_the_log_lacks(room: ScanLog) -> None:
    with pytest.raises(ConfigError, match="no trajectory 'wheel'"):
        slam_log(room, trajectory="wheel")


def test_stamps_do_not_matter(room: ScanLog) -> None:
    expected = slam_log(room).poses
    stamps = room.stamps_ns.copy()
    stamps[5:9] = stamps[5]
    stamps[20:30] = stamps[20:30][::-1]
    np.testing.assert_array_equal(slam_log(replace(room, stamps_ns=stamps)).poses, expected)


def test_sonars_are_refused(room: ScanLog) -> None:
    with pytest.raises(ConfigError, match="needs a lidar"):
        slam_log(replace(room, beam_width=0.3))


@pytest.mark.parametrize(("mount", "upside_down"), [((0.2, -0.1, np.pi / 2), False), ((-0.1, 0.05, -2.5), True)])
def test_any_mount(mount: tuple[float, float, float], upside_down: bool) -> None:
    log = drive("room", along(ROOM, 0.3), mount=mount)
    if upside_down:
        # The same beams, as a sensor that hangs upside down numbers them.
        log = replace(log, upside_down=True, angle_min=-log.angle_min, angle_increment=-log.angle_increment)
    assert off(log, slam_log(log).poses) < 0.15


def test_a_long_corridor_keeps_the_length_that_the_odometry_reports() -> None:
    """200 m without anything to tell one place from another: only the odometry knows how far the robot came."""
    path = np.column_stack([np.arange(2.0, 198.0, 1.0), np.full(196, 1.0), np.zeros(196)])
    corridor = World(
        "corridor", "Corridor", (0.0, 0.0, 200.0, 2.0), tuple(outer_walls(0.0, 0.0, 200.0, 2.0, 0.1)), (2.0, 1.0, 0.0)
    )
    log = drive(corridor, path, turn_bias=0.002)
    found = slam_log(log)
    wheels = log.trajectory("odometry").poses
    way = np.hypot(*np.diff(wheels[:, :2], axis=0).T).sum()
    assert np.hypot(*(found.poses[-1] - found.poses[0])[:2]) == pytest.approx(way, rel=0.02)
    assert np.abs(found.poses[:, 2] - found.poses[0, 2]).max() < 0.1  # the walls show the heading
    assert not found.candidates.accepted.any()
    told = re.match(r"Along (\d+) m of the path the scans do not determine how far the robot moved", found.notes[0])
    assert told
    assert int(told[1]) > 170
    in_a_room = slam_log(drive("room", along(ROOM, 0.4)))
    assert not in_a_room.notes


def test_two_places_that_look_alike_are_not_joined() -> None:
    """Two equal rooms side by side, 12 m apart, with equal ways in them: no loop joins one to the other."""
    walls = (*outer_walls(0.0, 0.0, 8.0, 6.0, 0.2), *outer_walls(12.0, 0.0, 20.0, 6.0, 0.2))
    world = World("twins", "Twins", (-1.0, -1.0, 21.0, 7.0), walls, (2.0, 2.0, 0.0))
    round_trip = along([(2.0, 2.0), (6.0, 2.0), (6.0, 4.0), (2.0, 4.0), (2.0, 2.0)], 0.4)
    log = drive(world, np.concatenate([round_trip, compose([12.0, 0.0, 0.0], round_trip)]), turn_bias=0.0)
    found = slam_log(log)
    graph = found.graph
    half = len(round_trip)
    loops = graph.kind == 1
    assert not ((graph.nodes[graph.i[loops]] < half) & (graph.nodes[graph.j[loops]] >= half)).any()


def test_time_and_memory_are_known_before_and_bounded(room: ScanLog) -> None:
    n = 100_000
    path = np.column_stack([np.arange(n) * 0.1, np.zeros((n, 2))])
    long = replace(
        room,
        ranges=np.broadcast_to(room.ranges[:1], (n, room.n_beams)).copy(),
        stamps_ns=np.arange(n),
        trajectories={"odometry": Trajectory(path, frame_id="odom")},
    )
    expected = estimate(long)
    assert expected.n_matched <= SlamConfig().max_nodes
    assert 0.0 < expected.seconds < 600.0
    assert expected.n_bytes < 1_000_000_000
    short = estimate(room)
    assert short.n_matched <= room.n_scans
    assert short.seconds < expected.seconds


def test_values_out_of_their_range_name_the_parameter() -> None:
    with pytest.raises(ConfigError, match="loop_window"):
        SlamConfig(loop_window=-1.0)
    with pytest.raises(ConfigError, match="no SLAM parameter 'window'"):
        SlamConfig().with_values({"window": 1.0})
