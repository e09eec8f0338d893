"""CARMEN lines written by hand, and the result of reading each."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog

TAIL = "12.5 host 0.5"


def flaser(readings, laser, robot=None, stamp=12.5, word="FLASER") -> str:
    numbers = [*laser, *(laser if robot is None else robot)]
    return f"{word} {len(readings)} {' '.join(map(str, [*readings, *numbers]))} {stamp} host 0.5"


def robot_laser(readings, laser, robot, range_max=50.0, word="ROBOTLASER1", remissions=()) -> str:
    n = len(readings)
    fields = [0, -math.pi / 2, math.pi, math.pi / n, range_max, 0.1, 0, n, *readings, len(remissions), *remissions]
    return f"{word} {' '.join(map(str, [*fields, *laser, *robot, 0, 0, 0, 0, 0]))} {TAIL}"


def written(folder: Path, *lines: str) -> ScanLog:
    path = folder / "a.log"
    path.write_text("".join(line + "\n" for line in lines))
    return open_log(path)


def test_a_front_laser_line_has_ranges_pose_and_time(tmp_path):
    log = written(tmp_path, flaser([1.0, 2.5, 3.0, 4.25], (1.0, 2.0, 0.5), stamp=976052890.244084))
    assert log.ranges.tolist() == [[1.0, 2.5, 3.0, 4.25]]
    assert log.trajectory("scan").poses.tolist() == [[1.0, 2.0, 0.5]]
    assert abs(int(log.stamps_ns[0]) - 976052890244084000) < 1000  # a double holds such a time to about 100 ns
    assert list(log.trajectories) == ["scan"]
    assert log.mount == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("n", "degrees"), [(180, 1.0), (181, 1.0), (360, 0.5), (361, 0.5), (4, 45.0), (5, 45.0), (1, None)]
)
def test_the_field_of_view_follows_from_the_number_of_beams(tmp_path, n, degrees):
    log = written(tmp_path, flaser([1.0] * n, (0, 0, 0)))
    assert log.angle_min == -math.pi / 2
    if degrees is not None:
        assert math.degrees(log.angle_increment) == pytest.approx(degrees, rel=1e-12)


def test_readings_of_80_m_and_more_are_no_return(tmp_path):
    log = written(tmp_path, flaser([79.99, 80.0, 81.83, 1e300], (0, 0, 0)))
    assert log.range_max == 80.0
    assert log.ranges[0, 0] == np.float32(79.99)
    assert np.isposinf(log.ranges[0, 1:]).all()


def test_a_stated_maximum_range_wins(tmp_path):
    log = written(tmp_path, "PARAM robot_frontlaser_max 8.0 nohost 0", flaser([7.9, 8.0, 20.0, math.inf], (0, 0, 0)))
    assert log.range_max == 8.0
    assert np.isposinf(log.ranges[0, 1:]).all()


@pytest.mark.parametrize("value", ["0", "0.0", "-1"])
@pytest.mark.parametrize("name", ["robot_frontlaser_max", "laser_front_laser_fov", "laser_front_laser_resolution"])
def test_a_parameter_of_the_laser_that_is_zero_counts_as_not_stated(tmp_path, name, value):
    readings = [7.9, 20.0] * 90
    log = written(tmp_path, f"PARAM {name} {value} nohost 0", flaser(readings, (0, 0, 0)))
    plain = written(tmp_path, flaser(readings, (0, 0, 0)))
    np.testing.assert_array_equal(log.ranges, plain.ranges)
    assert (log.range_max, log.angle_increment) == (plain.range_max, plain.angle_increment)
    (note,) = set(log.notes) - set(plain.notes)
    assert note.startswith(f"PARAM {name} is {float(value):g} ")
    rear = written(tmp_path, f"PARAM {name.replace('front', 'rear')} {value} nohost 0", flaser(readings, (0, 0, 0)))
    assert rear.notes == plain.notes


def test_zero_negative_and_nan_readings_are_no_measurement_and_noted(tmp_path):
    log = written(tmp_path, flaser([0.0, -1.0, math.nan, 2.0], (0, 0, 0)))
    assert np.isnan(log.ranges[0, :3]).all()
    assert log.ranges[0, 3] == 2.0
    assert any("3 readings" in note for note in log.notes)


def test_the_mount_is_read_from_param_and_gives_the_robot_pose(tmp_path):
    # A robot at (1, 2) that looks along y, with its laser 0.3 m ahead: the laser is at (1, 2.3).
    half = math.pi / 2
    log = written(
        tmp_path, "PARAM robot_frontlaser_offset 0.3 nohost 0", flaser([1.0] * 4, (1.0, 2.3, half), (1.0, 2.0, half))
    )
    assert log.mount == (0.3, 0.0, 0.0)
    np.testing.assert_allclose(log.trajectory().poses, [[1.0, 2.0, half]], atol=1e-12)
    np.testing.assert_allclose(log.sensor_poses(), [[1.0, 2.3, half]], atol=1e-12)
    assert list(log.trajectories) == ["scan"]


def test_a_constant_offset_between_the_two_poses_is_a_mount(tmp_path):
    log = written(
        tmp_path,
        flaser([1.0] * 4, (0.2, 0, 0), (0, 0, 0)),
        flaser([1.0] * 4, (0, 0.2, math.pi / 2), (0, 0, math.pi / 2)),
    )
    np.testing.assert_allclose(log.mount, (0.2, 0, 0), atol=1e-12)
    assert any("mount" in note for note in log.notes)


def test_an_offset_that_varies_is_another_trajectory(tmp_path):
    log = written(tmp_path, flaser([1.0] * 4, (1, 0, 0), (5, 5, 1)), flaser([1.0] * 4, (2, 0, 0), (7, 7, 2)))
    assert log.mount == (0.0, 0.0, 0.0)
    assert log.default_trajectory == "scan"
    np.testing.assert_allclose(log.trajectory("odom").poses, [[5, 5, 1], [7, 7, 2]])


def test_the_rear_laser_looks_back(tmp_path):
    log = written(
        tmp_path,
        "PARAM robot_rearlaser_offset -0.25 nohost 0",
        flaser([1.0] * 4, (-0.25, 0, math.pi), (0, 0, 0), word="RLASER"),
    )
    assert log.mount == (-0.25, 0.0, math.pi)
    np.testing.assert_allclose(log.trajectory().poses, [[0, 0, 0]], atol=1e-12)


@pytest.mark.parametrize(
    ("front", "rear"), [("FLASER", "RLASER"), ("ROBOTLASER1", "FLASER"), ("ROBOTLASER1", "ROBOTLASER2")]
)
def test_of_several_sensors_the_front_one_is_taken_and_the_other_noted(tmp_path, front, rear):
    def line(word: str, reading: float) -> str:
        make = robot_laser if word.startswith("ROBOT") else flaser
        return make([reading] * 4, (0, 0, 0), (0, 0, 0), word=word)

    log = written(tmp_path, line(rear, 9.0), line(front, 1.0), line(rear, 9.0))
    assert log.ranges.tolist() == [[1.0] * 4]
    assert any(f"2 {rear}" in note for note in log.notes)


def test_a_robot_laser_line_states_its_angles_and_range(tmp_path):
    log = written(tmp_path, robot_laser([1.0, 49.9, 50.0, 81.83], (1.5, 0, 0), (1, 0, 0), remissions=(7, 8)))
    assert log.range_max == 50.0
    assert log.angle_min == pytest.approx(-math.pi / 2)
    assert log.angle_increment == pytest.approx(math.pi / 4)
    assert log.ranges[0, 1] == np.float32(49.9)
    assert np.isposinf(log.ranges[0, 2:]).all()
    np.testing.assert_allclose(log.mount, (0.5, 0, 0), atol=1e-12)
    np.testing.assert_allclose(log.trajectory().poses, [[1, 0, 0]], atol=1e-12)


def test_six_digits_of_resolution_are_made_exact_by_the_field_of_view(tmp_path):
    n = 1081
    fields = [0, -2.35619449, 4.71238898, 0.004363, 30, 0.01, 0, n, *[1.0] * n, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    log = written(tmp_path, f"ROBOTLASER1 {' '.join(map(str, fields))} {TAIL}")
    assert log.angles[-1] == pytest.approx(math.radians(135.0), abs=1e-7)  # 1080 × 0.004363 would be off by 0.02°


def test_wheel_odometry_is_interpolated_between_its_neighbours_in_the_file(tmp_path):
    log = written(
        tmp_path,
        "ODOM 0 0 3.0 0 0 0 10.0 host 0",
        flaser([1.0] * 4, (9, 9, 0), stamp=12.0),
        "ODOM 4 8 -3.0 0 0 0 14.0 host 0",
        flaser([1.0] * 4, (8, 8, 0), stamp=99.0),
    )
    across = 2 * math.pi - 6.0  # the short way from 3.0 to −3.0
    expected = [[2.0, 4.0, 3.0 + across / 2 - (2 * math.pi if 3.0 + across / 2 >= math.pi else 0)], [4.0, 8.0, -3.0]]
    np.testing.assert_allclose(log.trajectory("wheel").poses, expected, atol=1e-12)


def test_wheel_odometry_survives_a_clock_that_jumps_back(tmp_path):
    log = written(
        tmp_path,
        "ODOM 1 0 0 0 0 0 50.0 host 0",
        flaser([1.0] * 4, (0, 0, 0), stamp=50.0),
        "ODOM 2 0 0 0 0 0 20.0 host 0",  # earlier than the message before it
        flaser([1.0] * 4, (0, 0, 0), stamp=21.0),
        "ODOM 3 0 0 0 0 0 22.0 host 0",
    )
    np.testing.assert_allclose(log.trajectory("wheel").poses[:, 0], [1.0, 2.5])
    assert any("backwards once" in note for note in log.notes)


def test_wheel_odometry_of_a_file_sorted_by_kind_is_matched_by_stamps(tmp_path):
    odometry = [f"ODOM {x} 0 0 0 0 0 {x} host 0" for x in range(10)]
    log = written(tmp_path, *odometry, *(flaser([1.0] * 4, (0, 0, 0), stamp=t) for t in (2.5, 7.0)))
    np.testing.assert_allclose(log.trajectory("wheel").poses[:, 0], [2.5, 7.0])


def test_wheel_odometry_is_chained_across_restarts_from_a_corrected_pose(tmp_path):
    log = written(
        tmp_path,
        "ODOM 0 0 0 0 0 0 10 host 0",
        flaser([1.0] * 4, (5, 5, math.pi / 2), stamp=10),
        f"ODOM 5 5 {math.pi / 2} 0 0 0 3.1e-200 host 0",  # where the mapper puts the robot
        f"ODOM 5 6 {math.pi / 2} 0 0 0 11 host 0",  # one metre ahead from there
        flaser([1.0] * 4, (7, 7, 0), stamp=11),
        "ODOM 7 7 0 0 0 0 1e200 host 0",
    )
    np.testing.assert_allclose(log.trajectory("wheel").poses, [[0, 0, 0], [1, 0, 0]], atol=1e-12)


def test_the_true_pose_of_a_simulator_is_a_trajectory(tmp_path):
    log = written(
        tmp_path,
        "TRUEPOS 1 2 0.1 9 9 9 10 host 0",
        flaser([1.0] * 4, (0, 0, 0), stamp=10.5),
        "TRUEPOS 2 2 0.1 9 9 9 11 host 0",
    )
    np.testing.assert_allclose(log.trajectory("truepos").poses, [[1.5, 2, 0.1]])


def test_other_messages_are_ignored_and_counted(tmp_path):
    log = written(
        tmp_path,
        "# a comment",
        "",
        "SYNC start 0 host 0",
        "NEFF 15",
        "NEFF 14",
        "SONAR whatever",
        flaser([1.0], (0, 0, 0)),
    )
    assert log.n_scans == 1
    assert "Ignored 2 NEFF, 1 SYNC, 1 SONAR lines." in log.notes


def test_largest_readings_that_pile_up_are_noted(tmp_path):
    readings = [1.0 + 0.01 * i for i in range(170)] + [50.0] * 10
    log = written(tmp_path, *(flaser(readings, (0, 0, 0)) for _ in range(3)))
    assert any("30 readings are at the largest value, 50.00 m" in note for note in log.notes)
    assert np.isfinite(log.ranges).all()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("name", ["a.log", "a.gz", "picture.png"])
def test_the_kind_is_read_from_the_bytes_not_from_the_name(tmp_path, end, packed, name):
    text = (flaser([1.0, 2.0], (0, 0, 0)) + end).encode() * 3
    path = tmp_path / name
    path.write_bytes(gzip.compress(text) if packed else text)
    log = open_log(path)
    assert (log.n_scans, log.n_beams, log.name, log.format) == (3, 2, name, "CARMEN FLASER")


def test_a_gzip_file_of_several_members_and_padding_is_one_log(tmp_path):
    line = (flaser([1.0, 2.0], (0, 0, 0)) + "\n").encode()
    path = tmp_path / "a.gz"
    path.write_bytes(gzip.compress(line) + gzip.compress(line * 2) + bytes(512))
    assert open_log(path).n_scans == 3


def test_progress_ends_at_one(tmp_path):
    path = tmp_path / "a.log"
    path.write_text((flaser([1.0] * 180, (0, 0, 0)) + "\n") * 2000)
    shares: list[float] = []
    open_log(path, progress=shares.append)
    assert shares == sorted(shares)
    assert len(shares) > 3
    assert shares[-1] == 1.0


def test_the_mount_may_be_aside_and_turned(tmp_path):
    log = written(
        tmp_path,
        "PARAM robot_frontlaser_offset 0.3 nohost 0",
        "PARAM robot_frontlaser_side_offset -0.1 nohost 0",
        "PARAM robot_frontlaser_angular_offset 0.5 nohost 0",
        flaser([1.0] * 4, (0, 0, 0)),
    )
    assert log.mount == (0.3, -0.1, 0.5)


def test_each_sensor_of_a_log_can_be_read(tmp_path):
    path = tmp_path / "a.log"
    front, rear = flaser([1.0] * 4, (0, 0, 0)), flaser([2.0] * 3, (0, 0, 0)).replace("FLASER", "RLASER")
    path.write_text(f"{front}\n{rear}\n{rear}\n")
    assert open_log(path).n_beams == 4
    log = open_log(path, topic="RLASER")
    assert (log.n_beams, log.n_scans) == (3, 2)
    assert [(one.name, one.count, one.beams, one.chosen) for one in log.topics] == [
        ("RLASER", 2, 3, True),
        ("FLASER", 1, 4, False),
    ]
    with pytest.raises(ReadError, match="no 'ODOM' scans; it has FLASER, RLASER"):
        open_log(path, topic="ODOM")
