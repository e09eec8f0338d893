"""ROS recordings in each container, written by independent writers: scans, frames, poses and topics."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ReadError
from mapper.core.se2 import compose, wrap_angle
from mapper.grid import OccupancyGrid
from mapper.io.logs import is_log, open_log, open_robot_log
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.driven_robot import MOUNT, T0, run, truth
from tests.mapper.io.logs.recorded import KINDS, SECOND, estimate, odometry, scan, sonar, transform, written


@pytest.mark.parametrize("kind", KINDS)
def test_scans_mount_and_trajectories(tmp_path, kind):
    path = written(tmp_path, run(), kind)
    assert is_log(path)
    log = open_log(path)
    assert (log.n_scans, log.n_beams) == (10, 5)
    np.testing.assert_array_equal(log.stamps_ns, T0 + SECOND // 10 + np.arange(10) * SECOND // 5)
    np.testing.assert_array_equal(log.ranges[3], np.array([4.0, np.nan, 31.0, np.nan, np.nan], dtype=np.float32))
    assert (log.angle_min, log.range_max) == (-1.5, 30.0)
    np.testing.assert_allclose(log.mount, MOUNT, atol=1e-12)
    assert not log.upside_down
    assert list(log.trajectories) == ["tf/map", "tf/odom", "odom", "amcl_pose"]
    expected = np.array([truth((2 * i + 1) / 10) for i in range(10)])
    for name, shift in (("tf/odom", 0.0), ("odom", 0.0), ("tf/map", 5.0), ("amcl_pose", 5.0)):
        poses = log.trajectory(name).poses
        np.testing.assert_allclose(poses[:, :2], expected[:, :2] + [0.0, shift], atol=1e-6)
        np.testing.assert_allclose(wrap_angle(poses[:, 2] - expected[:, 2]), 0.0, atol=1e-6)
    frames = {name: trajectory.frame_id for name, trajectory in log.trajectories.items()}
    assert frames == {"tf/map": "map", "tf/odom": "odom", "odom": "odom", "amcl_pose": "map"}
    # Where tf has the laser: the chain as anybody composes it.
    np.testing.assert_allclose(log.sensor_poses("tf/odom"), compose(expected, np.array(MOUNT)), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_topics_are_listed_with_their_properties(tmp_path, kind):
    more = [sonar(T0 + i, 1.0) for i in range(3)] + [recorded.text(T0, "hello")]
    log = open_log(written(tmp_path, run() + more, kind))
    laser, cone, *rest = log.topics
    assert (laser.name, laser.type, laser.count, laser.beams, laser.frame, laser.chosen) == (
        "/scan", "sensor_msgs/LaserScan", 10, 5, "laser", True,
    )  # fmt: skip
    assert laser.field_of_view_deg == pytest.approx(math.degrees(0.4))
    assert laser.rate_hz == pytest.approx(5.0)
    np.testing.assert_allclose(laser.mount or (), MOUNT, atol=1e-12)
    assert (cone.name, cone.count, cone.beams, cone.mount, cone.chosen) == ("/sonar", 3, 1, None, False)
    assert cone.field_of_view_deg == pytest.approx(math.degrees(0.5))
    counts = {topic.name: (topic.type, topic.count) for topic in rest}
    assert counts["/tf"] == ("tf2_msgs/TFMessage", 13)
    assert counts["/chatter"] == ("std_msgs/String", 1)
    assert counts["/amcl_pose"] == ("geometry_msgs/PoseWithCovarianceStamped", 11)


def test_the_sensor_with_most_scans_is_taken_or_the_one_that_is_named(tmp_path):
    said = [scan(T0 + i, [1.0, 2.0], "/front", "front") for i in range(3)]
    said += [scan(T0 + i, [3.0], "/rear", "rear") for i in range(4)]
    said += [sonar(T0 + i, 0.5) for i in range(9)]
    path = written(tmp_path, said, "bag")
    assert open_log(path).n_beams == 1, "the laser with most scans, not the sonar"
    assert open_log(path, topic="/front").n_scans == 3
    assert open_log(path, topic="front").n_scans == 3
    assert open_log(path, topic="/sonar").n_scans == 9
    with pytest.raises(ReadError, match=r"no scans on '/left'; it has .*/front.*/rear.*/sonar") as caught:
        open_log(path, topic="/left")
    assert caught.value.code == "log.topic"


def test_a_sonar_is_one_beam_as_wide_as_its_field_of_view(tmp_path):
    said = [transform(T0, "base_link", "sonar", 0.2, 0.1, math.pi / 2, topic="/tf_static")]
    said += [sonar(T0 + i * SECOND, reading, width=0.5) for i, reading in enumerate([1.0, np.inf, 0.01])]
    log = open_log(written(tmp_path, said, "mcap"))
    assert (log.beam_width, log.range_max, log.n_beams) == (0.5, 4.0, 1)
    np.testing.assert_array_equal(log.angles, [0.0])
    np.testing.assert_allclose(log.mount, (0.2, 0.1, math.pi / 2), atol=1e-12)
    config = MappingConfig(model="sonar_cone", update="per_scan", resolution=0.05)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config, None, 0, 1)
    # The echo came from an arc of a quarter metre, a metre to the robot's left.
    cells = grid.geometry.cell_to_world(np.argwhere(grid.log_odds > 0.0))
    distance = np.hypot(cells[:, 0] - 0.2, cells[:, 1] - 0.1)
    assert len(cells) > 5
    assert np.abs(distance - 1.0).max() < 0.3
    assert np.abs(np.arctan2(cells[:, 0] - 0.2, cells[:, 1] - 0.1)).max() < 0.25 + 0.1


def test_sonars_of_one_topic_are_distinguished_by_their_frames(tmp_path):
    said = [sonar(T0 + i, 1.0 + i % 2, frame=f"sonar_{i % 2}") for i in range(7)]
    log = open_log(written(tmp_path, said, "bag"))
    assert log.ranges.ravel().tolist() == [1.0] * 4
    assert {topic.name for topic in log.topics} == {"/sonar", "/sonar#sonar_1"}
    assert open_log(tmp_path / "run.bag", topic="/sonar#sonar_1").ranges.ravel().tolist() == [2.0] * 3


def test_a_laser_that_hangs_upside_down(tmp_path):
    said = [transform(T0, "base_link", "laser", 0.2, 0.0, 0.7, math.pi, topic="/tf_static")]
    said += [scan(T0 + i, [1.0] * 5) for i in range(3)]
    log = open_log(written(tmp_path, said, "mcap"))
    assert log.upside_down
    # Each beam's direction on the robot, by turning the beam's own vector: roll by π, then yaw.
    for i, bearing in enumerate(log.angles):
        a = -1.5 + 0.1 * i
        x, y = math.cos(a), -math.sin(a)
        direction = math.atan2(math.sin(0.7) * x + math.cos(0.7) * y, math.cos(0.7) * x - math.sin(0.7) * y)
        assert wrap_angle(log.mount[2] + bearing - direction) == pytest.approx(0.0, abs=1e-6)


def test_a_chain_of_mounts_and_the_tilt_of_a_sensor(tmp_path):
    said = [
        transform(T0, "base_footprint", "base_link", z=0.1, topic="/tf_static"),
        transform(T0, "base_link", "mast", 0.5, 0.0, math.pi / 2, topic="/tf_static"),
        transform(T0, "mast", "laser", 0.2, 0.0, 0.0, 0.6, topic="/tf_static"),
        scan(T0, [1.0]),
    ]
    log = open_log(written(tmp_path, said, "db3"))
    np.testing.assert_allclose(log.mount, (0.5, 0.2, math.pi / 2), atol=1e-12)
    assert any("tilted by 34°, in all scans alike" in note and "too far away" in note for note in log.notes)


@pytest.mark.parametrize("kind", KINDS)
def test_poses_in_tf_count_although_the_mount_is_missing(tmp_path, kind):
    """A recorder that starts late misses /tf_static, as a bag does where it was not recorded at all."""
    said = [one for one in run() if one.topic in ("/scan", "/tf")]
    late = tmp_path / "late"
    late.mkdir()
    whole, log = open_log(written(tmp_path, run(), kind)), open_log(written(late, said, kind))
    assert list(log.trajectories) == ["tf/map", "tf/odom"]
    for name, trajectory in log.trajectories.items():
        np.testing.assert_allclose(trajectory.poses, whole.trajectory(name).poses, atol=1e-12)
        assert trajectory.child_frame_id == "base_link"
    assert log.mount == (0.0, 0.0, 0.0)
    assert log.odometry is not None
    assert any("where the frame 'laser' sits" in note and "mount_yaw" in note for note in log.notes)
    assert not any("no poses" in note for note in log.notes)


def test_of_several_robots_a_sensor_without_a_mount_is_that_of_its_namespace(tmp_path):
    said = []
    for i in range(5):
        at = T0 + i * SECOND
        said += [transform(at, f"{name}/odom", f"{name}/base_link", i * speed) for name, speed in (("a", 1), ("b", 2))]
        said.append(scan(at, [1.0, 2.0], frame="b/laser"))
    log = open_log(written(tmp_path, said, "bag"))
    np.testing.assert_allclose(log.trajectory("tf/b/odom").poses[:, 0], [0.0, 2.0, 4.0, 6.0, 8.0])
    assert list(log.trajectories) == ["tf/b/odom"]
    unknown = [one for one in said if one.topic == "/tf"] + [scan(T0 + i * SECOND, [1.0, 2.0]) for i in range(5)]
    assert list(open_log(written(tmp_path, unknown, "mcap")).trajectories) == ["standing still"]


@pytest.mark.parametrize("kind", KINDS)
def test_without_poses_the_robot_does_not_move_and_a_note_gives_advice(tmp_path, kind):
    log = open_log(written(tmp_path, [scan(T0 + i, [1.0, 2.0]) for i in range(4)], kind))
    assert list(log.trajectories) == ["standing still"]
    assert not log.trajectory().poses.any()
    assert any("no poses" in note and "record /tf" in note for note in log.notes)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("source", ["odom", "tf/odom"])
@pytest.mark.parametrize("ahead_s", [3600, -1_699_999_000])
def test_clocks_that_differ_are_put_together_by_when_all_was_recorded(tmp_path, kind, source, ahead_s):
    """A scanner whose host was set wrongly, and one in simulated time: the recorder saw both."""
    said = [*[estimate(T0 - 5 * SECOND, 0.0, 0.0, 0.0) for _ in range(2)]]
    for i in range(11):
        at = T0 + i * SECOND // 5
        pose = odometry(at, *truth(i / 5)) if source == "odom" else transform(at, "odom", "laser", *truth(i / 5))
        seen = at + SECOND // 10
        said += [pose, replace(scan(seen + ahead_s * SECOND, [1.0]), stamp_ns=seen)]
    log = open_log(written(tmp_path, said[:-1], kind))
    np.testing.assert_allclose(log.trajectory(source).poses, [truth(i / 5 + 0.1) for i in range(10)], atol=2e-3)
    apart = f"{abs(ahead_s):,}.0 s {'behind' if ahead_s > 0 else 'ahead of'}"
    assert any(f"The clock of {source} is {apart} that of the scans" in note for note in log.notes)
    assert any("amcl_pose are from another time" in note for note in log.notes)


def test_poses_outside_the_scans_times_and_scans_behind_the_last_pose_are_left_out(tmp_path):
    said = [odometry(T0 + i * SECOND, float(i), 0.0, 0.0) for i in range(3)]
    said += [odometry(i * SECOND + 5, 0.0, 0.0, 0.0, "/clockless") for i in range(3)]
    said += [scan(T0 + i * SECOND, [1.0]) for i in range(5)]
    log = open_log(written(tmp_path, said, "mcap"))
    np.testing.assert_array_equal(log.trajectory("odom").poses[:, 0], [0.0, 1.0, 2.0])
    assert list(log.trajectories) == ["odom"]
    assert any("2 scans are left out: 2 after the last pose of odom" in note for note in log.notes)
    assert any("clockless are from another time" in note for note in log.notes)


def test_scans_with_other_beams_keep_their_own(tmp_path):
    said = [scan(T0 + i, [1.0, 2.0, 3.0, 4.0], angles=(0.0, 0.5)) for i in range(3)]
    said.append(scan(T0 + 3, [5.0, 6.0], angles=(2 * math.pi, 0.5)))  # a shorter sweep from the same angle
    said.append(scan(T0 + 4, [7.0, 8.0, 9.0], angles=(0.5, 0.45)))
    log = open_log(written(tmp_path, said, "bag"))
    assert (log.topic, log.n_scans, log.n_beams) == ("/scan", 5, 4)
    np.testing.assert_array_equal(log.ranges[3], np.array([5, 6, np.nan, np.nan], dtype=np.float32))
    np.testing.assert_array_equal(log.scan(4).ranges, np.array([7, 8, 9], dtype=np.float32))
    np.testing.assert_allclose(log.scan(4).angles, [0.5, 0.95, 1.4], atol=1e-6)
    np.testing.assert_allclose(log.scan(3).angles[:2], [0.0, 0.5], atol=1e-6)
    assert any("do not have the same beams" in note for note in log.notes)


def test_scans_whose_beams_are_all_different_count_at_the_nearest_of_the_usual_ones(tmp_path):
    said = [scan(T0 + i, [1.0, 2.0, 3.0, 4.0], angles=(0.0, 0.5)) for i in range(3)]
    said += [scan(T0 + 3 + i, [7.0, 8.0, 9.0], angles=(0.5 + 0.002 * i - 2 * math.pi, 0.45)) for i in range(66)]
    log = open_log(written(tmp_path, said, "bag"))
    assert (log.n_scans, log.n_beams) == (69, 4)
    np.testing.assert_array_equal(log.ranges[3], np.array([np.nan, 7, 8, 9], dtype=np.float32))
    assert any("66 of the 69 scans on /scan have other beams" in note for note in log.notes)


def test_scans_without_a_time_of_their_own_get_that_of_their_recording(tmp_path):
    said = scan(0, [1.0])
    said.stamp_ns = T0
    assert open_log(written(tmp_path, [said], "bag")).stamps_ns.tolist() == [T0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_without_scans_names_its_message_types(tmp_path, kind):
    with pytest.raises(ReadError, match=r"holds no scans .* it has nav_msgs/Odometry\.") as caught:
        open_log(written(tmp_path, [odometry(T0, 0, 0, 0)], kind))
    assert caught.value.code == "log.no_scans"


@given(st.lists(st.tuples(st.integers(0, 100), st.floats(-50, 50), st.floats(-3.1, 3.1)), min_size=1, max_size=8))
def test_interpolated_poses_are_those_of_the_textbook(knots):
    """Planar poses through the 3D machinery = linear in x, the short way round in the angle."""
    from mapper.core.limits import DEFAULT_LIMITS
    from mapper.io.logs.recording.timeline import Timeline

    line = Timeline(DEFAULT_LIMITS)
    by_time = dict.fromkeys(sorted({t for t, _, _ in knots}))
    for t, x, yaw in knots:
        if by_time[t] is None:
            by_time[t] = (x, yaw)
            q = recorded.quaternion(yaw)
            line.add(t * 10, (x, 0.0, 0.0, q["x"], q["y"], q["z"], q["w"]))
    times = np.array(list(by_time)) * 10
    xs, yaws = np.array([by_time[t] for t in by_time]).T
    asked = np.arange(-20, 1020, 7)
    expected = np.interp(asked, times, xs)
    poses = line.at(asked).planar
    np.testing.assert_allclose(np.broadcast_to(poses[:, 0], expected.shape), expected, atol=1e-9)
    turned = np.interp(asked, times, np.unwrap(yaws))
    # Half a turn in one step may go either way round.
    if not (np.abs(np.abs(wrap_angle(np.diff(yaws))) - np.pi) < 1e-6).any():
        np.testing.assert_allclose(wrap_angle(np.broadcast_to(poses[:, 2], turned.shape) - turned), 0.0, atol=1e-6)


def test_topics_of_one_name_and_two_types_are_two_sensors(tmp_path):
    messages = [m for i in range(4) for m in (scan(T0 + i, [1.0, 2.0], topic="/range"), sonar(T0 + i, 1.5, "/range"))]
    path = tmp_path / "run.mcap"
    path.write_bytes(recorded.mcap_bytes(messages))
    sensors = open_robot_log(path).sensors
    assert {name: (one.n_beams, one.n_scans) for name, one in sensors.items()} == {
        "/range": (2, 4),
        "/range#sonar": (1, 4),
    }
    assert all("could not be read" not in note for one in sensors.values() for note in one.notes)


def test_a_trajectory_has_the_stamps_of_its_source_and_the_frames_are_listed(tmp_path):
    messages = [transform(T0, "base_link", "laser", 0.2, topic="/tf_static"), scan(T0 + 5, [1.0]), scan(T0 + 25, [1.0])]
    messages += [transform(T0 + i, "odom", "base_link", 0.1 * i) for i in range(0, 40, 4)]
    messages += [odometry(T0 + i, 0.1 * i, 0.0, 0.0) for i in range(0, 40, 10)]
    path = tmp_path / "run.mcap"
    path.write_bytes(recorded.mcap_bytes(messages))
    robot = open_robot_log(path)
    tf, odom = (robot.first.trajectory(name).timed for name in ("tf/odom", "odom"))
    records = robot.first.odometry
    assert tf is not None
    assert odom is not None
    assert records is not None
    assert records.at_scans is not None
    assert (tf.stamps_ns - T0).tolist() == list(range(0, 40, 4))
    assert (odom.stamps_ns - T0).tolist() == [0, 10, 20, 30]
    np.testing.assert_allclose(tf.poses[:, 0], 0.1 * np.arange(0, 40, 4))
    assert robot.trajectories["tf/odom"] is tf
    assert (records.before_scan.tolist(), records.at_scans[:, 0].round(6).tolist()) == ([0, 2], [0.5, 2.5])
    assert [(one.parent, one.child, one.is_static, one.moves, one.count) for one in robot.transforms] == [
        ("odom", "base_link", False, True, 10),
        ("base_link", "laser", True, False, 1),
    ]


def test_which_of_several_sensors_is_mapped_is_said(tmp_path):
    ring = [sonar(T0 + i, 1.0, topic=f"/sonar/{i % 3}") for i in range(9)]
    path = written(tmp_path, ring, "mcap")
    said = "/sonar/0 is one of 3 sonars, which make one map: /sonar/0, /sonar/1, /sonar/2."
    assert sum(said in note for note in open_log(path).notes) == 1
    assert not any("Only" in note for note in open_log(path, topic="/sonar/1").notes)
    path.write_bytes(recorded.mcap_bytes([*ring, *run()]))
    assert sum(note.startswith("Only /scan is mapped; the log has 3 more") for note in open_log(path).notes) == 1
    path.write_bytes(recorded.mcap_bytes(run()))
    assert open_log(path).notes == ()
