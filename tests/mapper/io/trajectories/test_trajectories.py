"""TUM files, relations, and a TUM file as one more trajectory of a log."""

from __future__ import annotations

import gzip
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.export import tum_text
from mapper.io.logs import open_log
from mapper.io.trajectories import read_relations, read_tum, with_trajectory
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses

S = 1_000_000_000
LINE = "12.5 1.0 2.0 0 0 0 0 1"


def written(folder: Path, text: str) -> Path:
    path = folder / "a.tum"
    path.write_text(text)
    return path


def test_written_files_are_read_back(tmp_path: Path, office_log: ScanLog) -> None:
    log = replace(office_log, stamps_ns=office_log.stamps_ns + 1_700_000_000_123_456_789)
    text = tum_text(log)
    found = read_tum(written(tmp_path, text))
    np.testing.assert_array_equal(found.stamps_ns, log.stamps_ns)
    np.testing.assert_allclose(found.poses, log.trajectory().poses, atol=1e-6)
    assert found.notes == ()
    packed = tmp_path / "a.tum.gz"
    packed.write_bytes(gzip.compress(b"# a remark\n\n" + text.replace("\n", "\r\n").encode()))
    np.testing.assert_array_equal(read_tum(packed).poses, found.poses)


def test_the_reference_of_intel_is_read_as_numpy_reads_it(data_file: Callable[[str], Path]) -> None:
    path = data_file("carmen/intel.ref.tum")
    found, rows = read_tum(path), np.loadtxt(path)
    np.testing.assert_allclose(found.poses[:, :2], rows[:, 1:3])
    half = found.poses[:, 2] / 2
    # A quaternion and its negative are one rotation.
    np.testing.assert_allclose(np.abs(np.sin(half) * rows[:, 6] + np.cos(half) * rows[:, 7]), 1.0, atol=1e-9)
    np.testing.assert_allclose(found.stamps_ns / 1e9, rows[:, 0], atol=1e-6)
    assert found.notes == ("Of 13631 stamps 629 are earlier than the one before, and 2459 equal to it.",)


def test_stamps_keep_every_digit(tmp_path: Path) -> None:
    found = read_tum(
        written(tmp_path, "1700000000.123456789 0 0 0 0 0 0 1\n-1.5e0 0 0 0 0 0 0 1\n0e999999 0 0 0 0 0 0 1")
    )
    assert found.stamps_ns.tolist() == [1_700_000_000_123_456_789, -1_500_000_000, 0]


def test_a_pose_in_space_is_seen_from_above(tmp_path: Path) -> None:
    """A quarter turn to the left, and then 30° nose down: the heading stays."""
    yaw, pitch = math.pi / 2, math.radians(30.0)
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    text = f"0 1 2 0.5 {-sy * sp} {cy * sp} {sy * cp} {cy * cp}\n1 1 2 0 0 0 0 1\n"
    found = read_tum(written(tmp_path, text))
    np.testing.assert_allclose(found.poses, [[1.0, 2.0, yaw], [1.0, 2.0, 0.0]], atol=1e-9)
    (note,) = found.notes
    assert note.startswith("The trajectory is not planar: heights differ by 0.50 m and it tilts by up to 30°.")


def test_a_trajectory_in_another_format_is_named(tmp_path: Path) -> None:
    """In place of the number of its values alone."""
    for line, said in (
        ("1.0 0 0 2.5 0 1.0 0 0 0 0 1.0 0\n", r"has 12 values, .* in the format KITTI\. It states no times"),
        ("1403636580838555648,1,2,3,0.8,0.6,0,0\n", r"in the format EuRoC, not of TUM\. evo_traj euroc"),
        ("1,2,3,0,0,0.8,0.6\n", r"has 7 values, .* If the timestamp is missing, write it before"),
    ):
        with pytest.raises(ReadError, match=said):
            read_tum(written(tmp_path, line))


SHUFFLED = "x,y,z,qw,qx,qy,qz,time,frame"


@pytest.mark.parametrize(
    "text",
    [
        "12.5,1.25,-2,0,0,0,0.6,0.8",
        "12.5, 1.25, -2, 0, 0, 0, 0.6, 0.8,",
        "timestamp,tx,ty,tz,qx,qy,qz,qw\r\n12.5,1.25,-2,0,0,0,0.6,0.8",
        '"time [s]";"p_x [m]";"p_y [m]";"p_z [m]";"q_x";"q_y";"q_z";"q_w"\n12,5;1,25;-2;0;0;0;0,6;0,8',
        "12,5 1,25 -2 0,0 0 0 0,6 0,8",
        "12,5\t1,25\t-2,0\t0\t0\t0\t0,6\t0,8",
        (
            "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
            "12.5,1.25,-2,0,0.8,0,0,0.6"
        ),
        f"# a remark\n{SHUFFLED}\n1.25,-2,0,0.8,0,0,0.6,12.5,map",
        f"# {SHUFFLED.replace(',', ' ')}\n1.25 -2 0 0.8 0 0 0.6 12.5 map",
    ],
)
def test_tables_are_read_by_their_separators_and_names(tmp_path: Path, text: str) -> None:
    found = read_tum(written(tmp_path, text + "\n"))
    assert found.stamps_ns.tolist() == [12_500_000_000]
    np.testing.assert_allclose(found.poses, [[1.25, -2.0, 2.0 * math.atan2(0.6, 0.8)]])


def test_a_line_with_fewer_values_than_names_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError) as error:
        read_tum(written(tmp_path, f"{SHUFFLED}\n1.25,-2,0,0.8,0,0,0.6,12.5\n"))
    assert error.value.message == "Line 2 has 8 values, but the line with the names of the columns has 9."


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("12.5 1.0 2.0", "Line 2 has 3 values, but a TUM line has 8: timestamp tx ty tz qx qy qz qw."),
        ("12.5", "Line 2 has 1 value, but a TUM line has 8: timestamp tx ty tz qx qy qz qw."),
        (f"{LINE} 7", "Line 2 has 9 values, but a TUM line has 8: timestamp tx ty tz qx qy qz qw."),
        (
            LINE.replace(" ", ","),
            "Line 2 has commas or semicolons between its values, but a TUM line has 8: timestamp tx ty tz qx qy qz qw.",
        ),
        ("12.5 1.0 two 0 0 0 0 1", "Line 2: 'two' in this TUM line is not a number."),
        ("now 1.0 2.0 0 0 0 0 1", "Line 2: 'now' in this TUM line is not a number."),
        ("1_0 1.0 2.0 0 0 0 0 1", "Line 2: '1_0' in this TUM line is not a number."),
        ("nan 1.0 2.0 0 0 0 0 1", "Line 2: the time 'nan' of this TUM line is impossible."),
        ("1e30 1.0 2.0 0 0 0 0 1", "Line 2: the time '1e30' of this TUM line is impossible."),
        (
            "12.5 nan 2.0 0 0 0 0 1",
            "Line 2: the position nan, 2, 0 must be finite and within 1e+08 m.",
        ),
        (
            "12.5 0 1e7 0 0 0 0 1",
            "Line 2: the position 0, 1e+07, 0 is more than 1e+06 m from the first.",
        ),
        ("12.5 0 0 0 0 0 0 0", "Line 2: the quaternion 0, 0, 0, 0 is not a rotation: its length is 0, not 1."),
        ("12.5 0 0 0 0 0 1 1", "Line 2: the quaternion 0, 0, 1, 1 is not a rotation: its length is 1.41, not 1."),
        ("12.5 0 0 0 0 0 nan 1", "Line 2: the quaternion 0, 0, nan, 1 is not a rotation: its length is nan, not 1."),
    ],
)
def test_a_damaged_line_is_named(tmp_path: Path, line: str, message: str) -> None:
    with pytest.raises(ReadError) as error:
        read_tum(written(tmp_path, f"{LINE}\n{line}\n{LINE}\n"))
    assert error.value.message == message


def test_files_without_poses_and_large_ones_are_refused(tmp_path: Path) -> None:
    for text in ("", "# only a remark\n\n"):
        with pytest.raises(ReadError, match=r"The file holds no poses, lines of timestamp tx ty tz qx qy qz qw\."):
            read_tum(written(tmp_path, text))
    with pytest.raises(ReadError, match=r"There is no file 'b\.tum'"):
        read_tum(tmp_path / "b.tum")
    with pytest.raises(LimitError, match="more lines than the limit of 2"):
        read_tum(written(tmp_path, f"{LINE}\n" * 3), Limits(max_lines=2))
    (tmp_path / "a.gz").write_bytes(gzip.compress(f"{LINE}\n".encode() * 3))
    with pytest.raises(LimitError, match="expands to more than the limit of 30 bytes"):
        read_tum(tmp_path / "a.gz", Limits(max_unpacked_bytes=30, max_expansion=0))


def test_every_prefix_is_read_or_refused(tmp_path: Path) -> None:
    text = f"# remark\n{LINE}\n13.5 -1.0 2.25 0 0 0 0.70710678 0.70710678\n"
    packed = gzip.compress(text.encode())
    for data in (text.encode(), packed):
        path = tmp_path / "a"
        refused = 0
        for end in range(len(data)):
            path.write_bytes(data[:end])
            try:
                assert 1 <= len(read_tum(path)) <= 2
            except ReadError:
                refused += 1
        assert refused > len(data) / 4
    path.write_bytes(packed[: len(packed) - 9])
    with pytest.raises(ReadError, match="The gzip data ends early, after line"):
        read_tum(path)


def test_relations_are_read(tmp_path: Path, data_file: Callable[[str], Path]) -> None:
    path = data_file("relations/intel.relations")
    found, rows = read_relations(path), np.loadtxt(path)
    np.testing.assert_allclose(found.stamps_ns / 1e9, rows[:, :2], atol=1e-6)
    np.testing.assert_array_equal(found.motions, rows[:, [2, 3, 7]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n", "Line 1 has 3 values, but a relation line has 8: t1 t2 x y z roll pitch yaw."),
        ("1 2 3 4 5 6 7 eight\n", "Line 1: 'eight' in this relation line is not a number."),
        ("1 2 inf 4 5 6 7 8\n", "Line 1: the relative pose in this relation line is not finite: inf, 4.0, 8.0."),
        ("1 inf 3 4 5 6 7 8\n", "Line 1: the time 'inf' of this relation line is impossible."),
        ("\n", "The file holds no relations, lines of t1 t2 x y z roll pitch yaw."),
    ],
)
def test_damaged_relations_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ReadError) as error:
        read_relations(written(tmp_path, text))
    assert error.value.message == message


def test_poses_at_the_scans_stamps_are_taken_as_they_are(office_log: ScanLog) -> None:
    stamps = office_log.stamps_ns.copy()
    stamps[10:20] = stamps[10]  # where interpolating would give one pose to all
    log = replace(office_log, stamps_ns=stamps)
    poses = log.trajectory().poses + np.array([1.0, 2.0, 0.0])
    found = with_trajectory(log, TimedPoses(stamps + 400, poses))
    assert found.default_trajectory == "tum"
    assert list(found.trajectories) == ["tum", *log.trajectories]
    np.testing.assert_array_equal(found.trajectory().poses, poses)
    assert found.notes == log.notes


def test_poses_are_interpolated_and_scans_outside_left_out(office_log: ScanLog) -> None:
    """Poses every 10 s of a robot that drives at 0.2 m/s and turns across ±π."""
    log = replace(office_log, stamps_ns=np.arange(office_log.n_scans) * S)
    times = np.array([20.0, 40.0, 30.0, 50.0])  # not in order
    poses = np.column_stack([0.2 * times, -0.1 * times, (3.0 + 0.01 * times + np.pi) % (2 * np.pi) - np.pi])
    found = with_trajectory(log, TimedPoses((times * S).astype(np.int64), poses, ("a note",)))
    assert found.n_scans == 31
    np.testing.assert_array_equal(found.ranges, log.ranges[20:51])
    np.testing.assert_array_equal(found.stamps_ns, log.stamps_ns[20:51])
    for name, trajectory in log.trajectories.items():
        np.testing.assert_array_equal(found.trajectory(name).poses, trajectory.poses[20:51])
    t = np.arange(20.0, 51.0)
    expected = np.column_stack([0.2 * t, -0.1 * t, (3.0 + 0.01 * t + np.pi) % (2 * np.pi) - np.pi])
    np.testing.assert_allclose(found.trajectory("tum").poses, expected, atol=1e-9)
    left_out = log.n_scans - 31
    assert found.notes == (
        *log.notes,
        "a note",
        f"{left_out} scans lie before the first or after the last pose of the trajectory, and are left out.",
        "21 scans are more than 1 s from any pose of the trajectory; poses are interpolated there.",
    )


def test_poses_of_another_time_are_refused(office_log: ScanLog) -> None:
    poses = TimedPoses(office_log.stamps_ns[:3] + 10**6 * S, np.zeros((3, 3)))
    with pytest.raises(ConfigError, match="No scan is within the time of the trajectory: its poses are from 1000000"):
        with_trajectory(office_log, poses)
    with pytest.raises(ConfigError, match="has a trajectory 'true' already"):
        with_trajectory(office_log, poses, "true")


def test_poses_must_be_poses() -> None:
    with pytest.raises(ConfigError, match="not finite"):
        TimedPoses(np.zeros(1, dtype=np.int64), np.array([[0.0, 0.0, np.nan]]))
    with pytest.raises(ConfigError, match="shape"):
        TimedPoses(np.zeros(2, dtype=np.int64), np.zeros((1, 3)))
    with pytest.raises(ConfigError, match="no poses"):
        TimedPoses(np.zeros(0, dtype=np.int64), np.zeros((0, 3))).at(np.array([1]))
    assert not TimedPoses(np.zeros(0, dtype=np.int64), np.zeros((0, 3))).covers(np.array([1])).any()


def test_the_corrected_trajectory_of_intel_makes_the_corrected_logs_map_poses(data_file: Callable[[str], Path]) -> None:
    """At odometry rate, with stamps that repeat: interpolated, it is within the known error of that on this log."""
    log = with_trajectory(open_log(data_file("carmen/intel.log.gz")), read_tum(data_file("carmen/intel.ref.tum")))
    corrected = open_log(data_file("carmen/intel-corrected.log.gz"))
    assert log.n_scans == corrected.n_scans == 910
    off = np.hypot(*(log.trajectory("tum").poses - corrected.trajectory("scan").poses)[:, :2].T)
    assert np.median(off) < 0.1
