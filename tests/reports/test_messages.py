"""Logs whose messages and containers people in the field have stumbled over: the map must be that of the room.

A case is a kind of log that public reports describe, made here: a robot drives through a room whose walls are known in
closed form, and every reading that counts must end on one of them, by the beams and limits that its own message states.
"""

from __future__ import annotations

import io
import json
import math
import re
import sqlite3
import struct
import zipfile
from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.se2 import compose
from mapper.io.clouds import read_cloud
from mapper.io.logs import open_log
from mapper.io.logs.text.carmen_beams import front_laser_beams
from mapper.io.trajectories import read_tum, with_trajectory
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import is_deskewed
from mapper.mapping.update_plan import plan_update
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, scan, sonar, transform, written

T0 = 1_700_000_000 * SECOND
STEP = SECOND // 5
N = 12
LEFT, RIGHT, BELOW, ABOVE = -3.0, 5.0, -2.0, 4.0  #: the walls, metres
MOUNT = (0.2, 0.1, 0.4)


def pose(i: float) -> tuple[float, float, float]:
    """Where the robot is at step i."""
    return (0.1 * i, 0.02 * i, 0.15 * i)


def distances(
    i: float, bearings: NDArray[np.floating[Any]], mount: tuple[float, float, float] = MOUNT
) -> NDArray[np.float64]:
    """The distance to the nearest wall along each bearing of the sensor."""
    x, y, yaw = compose(np.array(pose(i)), np.array(mount))
    cos, sin = np.cos(yaw + bearings), np.sin(yaw + bearings)
    with np.errstate(divide="ignore"):
        across = np.where(cos > 0.0, (RIGHT - x) / cos, (LEFT - x) / cos)
        along = np.where(sin > 0.0, (ABOVE - y) / sin, (BELOW - y) / sin)
    return np.asarray(np.minimum(np.abs(across), np.abs(along)))


def measured(
    i: int, angles: tuple[float, float] = (-math.pi, math.radians(2.0)), n: int = 180, **fields: object
) -> Said:
    """A scan at step i of n beams from angles[0] on, angles[1] apart."""
    said = scan(T0 + i * STEP, distances(i, angles[0] + angles[1] * np.arange(n)), angles=angles)
    return replace(said, fields=said.fields | fields)


def drive(scans: Callable[[int], Said], n: int = N) -> list[Said]:
    said = [transform(T0 - SECOND, "base_link", "laser", *MOUNT, topic="/tf_static")]
    for i in range(n):
        said += [transform(T0 + i * STEP, "odom", "base_link", *pose(i)), scans(i)]
    return said


def ends(log: ScanLog) -> NDArray[np.float64]:
    """Where the measured readings of all scans end, (n, 2), by each scan's own bearings and limits."""
    found = []
    for t in range(log.n_scans):
        one = log.scan(t)
        counts = (one.ranges >= one.range_min) & (one.ranges <= one.range_max)
        x, y, yaw = compose(log.trajectory().poses[t], log.mount_of(t))
        ranges, bearings = one.ranges[counts].astype(np.float64), one.angles[counts] + yaw
        found.append(np.stack([x + ranges * np.cos(bearings), y + ranges * np.sin(bearings)], axis=-1))
    return np.concatenate(found)


def off_the_walls(points: NDArray[np.float64]) -> float:
    """By how far the farthest point is from the nearest wall, metres."""
    x, y = points.T
    return float(np.abs(np.stack([x - LEFT, x - RIGHT, y - BELOW, y - ABOVE])).min(axis=0).max())


@dataclass(frozen=True)
class Case:
    """A kind of log: what people reported, and what must be read of it."""

    name: str
    source: str
    said: Callable[[], list[Said]]
    readings: int = N * 180  #: that count
    notes: tuple[str, ...] = ()
    within: float = 1e-3  #: metres that a reading may end from the walls
    kind: str = "mcap"


def limited(i: int) -> Said:
    """A scan whose range_max is its largest reading."""
    said = measured(i)
    return replace(said, fields=said.fields | {"range_max": float(said.fields["ranges"].max())})


def nothing_at(limit: float, i: int) -> Said:
    """A scan of a sensor that says no return by its range_max."""
    said = measured(i)
    ranges = np.where(said.fields["ranges"] > limit, np.float32(limit), said.fields["ranges"])
    return replace(said, fields=said.fields | {"ranges": ranges, "range_max": limit})


def own_range(i: int) -> Said:
    """A lidar that is switched between 3 m and 30 m and says no return by inf."""
    said, limit = measured(i), 3.0 if i % 2 else 30.0
    ranges = np.where(said.fields["ranges"] > limit, np.float32(np.inf), said.fields["ranges"])
    return replace(said, fields=said.fields | {"ranges": ranges, "range_max": limit})


def ramped(i: int) -> Said:
    """A lidar whose greatest range grows from scan to scan; what is farther is inf."""
    said, limit = measured(i), 3.0 + 0.1 * i
    ranges = np.where(said.fields["ranges"] > limit, np.float32(np.inf), said.fields["ranges"])
    return replace(said, fields=said.fields | {"ranges": ranges, "range_max": limit})


def turned(i: int) -> Said:
    """A lidar that is switched in resolution, in its first angle by a whole turn, and in the sense of its sweep."""
    n, first, sign = ((180, -math.pi, 1.0), (360, math.pi, 1.0), (90, 0.0, -1.0))[i % 3]
    return measured(i, (first, sign * 2.0 * math.pi / n), n)


def jittering(i: int) -> Said:
    """A lidar that sends another number of beams over the whole turn in each scan."""
    n = 350 + i
    return measured(i, (-math.pi, 2.0 * math.pi / n), n)


def within(limit: Callable[[int], float]) -> int:
    """How many readings of a scan each at the steps are below the limit of their step."""
    bearings = -math.pi + math.radians(2.0) * np.arange(180)
    return int(sum(np.count_nonzero(distances(i, bearings).astype(np.float32) < limit(i)) for i in range(N)))


CASES = (
    Case("range_max is the largest reading", "SICKAG/sick_scan_xd#509", lambda: drive(limited),
         notes=("largest reading",)),
    Case("range_max 0", "Slamtec/rplidar_ros#71", lambda: drive(lambda i: measured(i, range_max=0.0)),
         notes=("All 12 messages on /scan state a range_max of 0 m",)),
    Case("range_max NaN", "Slamtec/rplidar_ros#115", lambda: drive(lambda i: measured(i, range_max=math.nan)),
         notes=("state a range_max of nan m",)),
    Case("range_max inf", "REP 117", lambda: drive(lambda i: measured(i, range_max=math.inf)),
         notes=("range_max inf",)),
    Case("limits the other way round", "sensor_msgs/LaserScan",
         lambda: drive(lambda i: measured(i, range_min=30.0, range_max=0.1)), notes=("the other way round",)),
    Case("no return is range_max", "ros-perception/laser_geometry#9", lambda: drive(lambda i: nothing_at(3.5, i)),
         within(lambda _: 3.5), ("are exactly range_max, 3.5 m",)),
    Case("another resolution, turn and sense", "sensor_msgs/LaserScan", lambda: drive(turned), 4 * (180 + 360 + 90),
         ("do not have the same beams", "4 with 360 beams")),
    Case("another number of beams in each scan", "Slamtec/rplidar_ros#31", lambda: drive(jittering),
         sum(350 + i for i in range(N)), ("do not have the same beams", "and 8 kinds more")),
    Case("fewer beams now and then", "sensor_msgs/LaserScan", lambda: drive(lambda i: measured(i, n=180 - i % 4)),
         N * 180 - 18),
    Case("another greatest range in each scan", "sensor_msgs/LaserScan", lambda: drive(ramped),
         within(lambda i: 3.0 + 0.1 * i), ("and 8 kinds more",)),
    Case("another greatest range", "sensor_msgs/LaserScan", lambda: drive(own_range),
         within(lambda i: 3.0 if i % 2 else 30.0), ("do not have the same beams or limits",)),
)  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_each_message_counts_by_what_it_states_itself(tmp_path, case):
    log = open_log(written(tmp_path, case.said(), case.kind))
    points = ends(log)
    assert (log.n_scans, len(points)) == (N, case.readings)
    assert off_the_walls(points) < case.within
    for words in case.notes:
        assert any(words in note for note in log.notes), (words, log.notes)
    if not case.notes:
        assert log.notes == ()


def test_what_has_no_return_reaches_as_far_as_its_own_scan_states(tmp_path):
    log = open_log(written(tmp_path, drive(ramped), "mcap"))
    scans = [log.scan(i) for i in range(N)]
    assert [scan.range_max for scan in scans] == pytest.approx([3.0 + 0.1 * i for i in range(N)])
    assert all(np.isposinf(scan.ranges).any() for scan in scans)


def test_beams_of_more_kinds_than_are_kept_apart_count_at_the_nearest(tmp_path):
    said = [transform(T0 - SECOND, "base_link", "laser", *MOUNT, topic="/tf_static")]
    for i in range(70):
        n, stamp = 350 + i, T0 + i * STEP
        angles = (-math.pi, 2.0 * math.pi / n)
        one = scan(stamp, distances(0, angles[0] + angles[1] * np.arange(n)), angles=angles)
        said += [transform(stamp, "odom", "base_link", *pose(0)), one]
    log = open_log(written(tmp_path, said, "mcap"))
    assert any("in more than 64 ways" in note for note in log.notes)
    assert off_the_walls(ends(log)) < 0.12


@pytest.mark.parametrize("clipped", [True, False], ids=["clipped to it", "on both sides of it"])
def test_noise_on_what_says_no_return_makes_no_walls(tmp_path, clipped):
    """Simulators that add noise to all that a lidar says: half of what says no return is below range_max."""
    rng = np.random.default_rng(1)

    def noisy(i: int) -> Said:
        said = nothing_at(3.5, i)
        ranges = said.fields["ranges"].astype(np.float64) + rng.normal(0.0, 0.01, 180)
        ranges = np.minimum(ranges, 3.5) if clipped else ranges
        return replace(said, fields=said.fields | {"ranges": ranges.astype(np.float32)})

    log = open_log(written(tmp_path, drive(noisy), "mcap"))
    points = ends(log)
    wanted = within(lambda _: 3.5)
    assert 0.95 * wanted < len(points) < 1.01 * wanted
    assert off_the_walls(points) < 0.06
    assert any("at range_max, 3.5 m, with noise of some 0.0" in note for note in log.notes), log.notes


def test_a_real_wall_at_the_greatest_range_stays(tmp_path):
    """Few readings at range_max are no code for no return."""
    limit = float(np.float32(distances(0, np.array([-math.pi]))[0]))
    log = open_log(written(tmp_path, drive(lambda i: measured(i, range_max=limit)), "mcap"))
    assert not any("exactly range_max" in note for note in log.notes)
    assert log.scan(0).ranges[0] == np.float32(limit) == np.float32(log.range_max)


@pytest.mark.parametrize(
    ("increment", "scan_time", "is_possible"),
    [(0.2 / 180, 0.2, True), (0.8 / 180, 0.2, False), (0.1 / 180, 0.02, False), (0.2, 0.2, False)],
    ids=["possible", "longer than the time between scans", "longer than scan_time", "the scan's time for each beam"],
)
def test_sweeps_that_cannot_be_are_not_used(tmp_path, increment, scan_time, is_possible):
    """ROBOTIS-GIT/turtlebot3#690, cyberbotics/webots_ros2#1047: a time_increment that no sweep can have."""
    said = drive(lambda i: measured(i, time_increment=increment, scan_time=scan_time))
    log = open_log(written(tmp_path, said, "db3"))
    plan = plan_update(MappingConfig(), log.range_min, log.range_max)
    assert is_deskewed(log, plan, None) == is_possible
    assert any("deskew off" in note for note in log.notes) == (not is_possible)
    if is_possible:
        assert log.time_increment == pytest.approx(increment)


@pytest.mark.parametrize(("step", "contradicts"), [(2.0, False), (2.6, True)])
def test_an_angle_max_that_contradicts_the_increment_is_named(tmp_path, step, contradicts):
    """SteveMacenski/slam_toolbox#430: a count of beams that is not (angle_max − angle_min) / angle_increment + 1."""
    log = open_log(written(tmp_path, drive(lambda i: measured(i, angle_increment=math.radians(step))), "mcap"))
    said = [note for note in log.notes if "contradict themselves" in note]
    assert bool(said) == contradicts
    if contradicts:
        assert "All 12 messages on /scan" in said[0]
        assert "angle_max is 178°, and 180 beams 2.6° apart from -180° end at 285.4°" in said[0]


def test_increments_whose_sign_contradicts_the_angles_are_named(tmp_path):
    """ros-planning/navigation#310: angle_min above angle_max, as of a clockwise sweep, with a positive increment."""
    clockwise = (math.pi, -math.radians(2.0))
    right = open_log(written(tmp_path, drive(lambda i: measured(i, clockwise)), "mcap"))
    assert off_the_walls(ends(right)) < 2e-3
    assert not any("contradict" in note for note in right.notes)
    wrong = open_log(written(tmp_path, drive(lambda i: measured(i, clockwise, angle_increment=-clockwise[1])), "db3"))
    assert any("if the map is mirrored, its sign is wrong in the driver" in note for note in wrong.notes)


@pytest.mark.parametrize(
    ("first", "step", "last"), [(90.0, 1.0, -90.0), (90.0, 0.5, -90.0), (270.0, 1.0, 90.0), (90.0, -1.0, -90.0)]
)
def test_half_a_turn_through_180_degrees_contradicts_nothing(tmp_path, first, step, last):
    """It ends at the same angle either way round, so that angle_max cannot tell the sign."""
    angles = (math.radians(first), math.radians(step))
    said = drive(lambda i: measured(i, angles, round(180.0 / abs(step)) + 1, angle_max=math.radians(last)))
    assert not any("contradict" in note for note in open_log(written(tmp_path, said, "mcap")).notes)


@pytest.mark.parametrize(
    ("n", "first", "step"), [(181, -90.0, 1.0), (1081, -135.0, 0.25), (360, 0.0, 1.0), (361, 180.0, -1.0)]
)
def test_angles_in_degrees_are_converted_with_a_note(tmp_path, n, first, step):
    """A driver that fills angle_min and angle_increment with degrees: each beam goes another way round, a smear."""
    bearings = np.radians(first + step * np.arange(n))
    said = drive(lambda i: scan(T0 + i * STEP, distances(i, bearings), angles=(first, step)), 4)
    log = open_log(written(tmp_path, said, "mcap"))
    assert log.angle_min == pytest.approx(math.radians(first))
    assert off_the_walls(ends(log)) < 1e-3
    assert any("All 4 messages on /scan state their angles in degrees" in note for note in log.notes)


@pytest.mark.parametrize("begin", [b"", b"sep=;\r\n", b"\xef\xbb\xbfsep=;\r\n"])
def test_a_csv_log_with_degrees_that_excel_saved(tmp_path, begin):
    lines = ["angle_min;-90,0", "angle_increment;1,0", "stamp;x;y;theta;ranges"]
    lines += [f"{i},5;0,0;0,0;0,0;" + ";".join(["2,5"] * 181) for i in range(3)]
    (tmp_path / "a.csv").write_bytes(begin + "\r\n".join([*lines, ""]).encode())
    log = open_log(tmp_path / "a.csv")
    assert (log.angle_min, log.angle_increment) == pytest.approx((-math.pi / 2.0, math.radians(1.0)))
    assert log.ranges[0, 0] == 2.5
    assert "in degrees, where the format has radians" in log.notes[0]


def csv_of(said: Callable[[int], Said], limits: tuple[str, str], stamp: Callable[[int], str]) -> str:
    """Scans of a drive as a CSV log, with limits and times as they are given."""
    x, y, yaw = MOUNT
    lines = [f"angle_min,{-math.pi}", f"angle_increment,{math.radians(2.0)}"]
    lines += [f"range_min,{limits[0]}", f"range_max,{limits[1]}"]
    lines += [f"mount_x,{x}", f"mount_y,{y}", f"mount_yaw,{yaw}", "stamp,x,y,theta,ranges"]
    for i in range(N):
        values = (*pose(i), *said(i).fields["ranges"])
        lines.append(f"{stamp(i)}," + ",".join(f"{value:.6g}" for value in values))
    return "\n".join([*lines, ""])


def in_seconds(i: int) -> str:
    return f"{i * 0.2}"


@pytest.mark.parametrize(
    ("limits", "note"),
    [
        (("0.05", "0"), "All 12 messages of the log state a range_max of 0 m"),
        (("0.05", "nan"), "state a range_max of nan m"),
        (("30", "0.05"), "are taken the other way round"),
        (("nan", "30"), None),
    ],
)
def test_limits_of_a_csv_log_are_understood_as_those_of_messages(tmp_path, limits, note):
    (tmp_path / "a.csv").write_text(csv_of(measured, limits, in_seconds))
    log = open_log(tmp_path / "a.csv")
    assert len(ends(log)) == N * 180
    assert off_the_walls(ends(log)) < 1e-3
    assert log.notes == () if note is None else note in log.notes[0]


def test_what_is_exactly_range_max_in_a_csv_log_is_no_return(tmp_path):
    (tmp_path / "a.csv").write_text(csv_of(lambda i: nothing_at(3.5, i), ("0", "3.5"), in_seconds))
    log = open_log(tmp_path / "a.csv")
    assert len(ends(log)) == within(lambda _: 3.5)
    assert "readings of the log" in log.notes[0]
    assert "are exactly range_max, 3.5 m" in log.notes[0]


@pytest.mark.parametrize(("per_second", "unit"), [(1e3, "milli"), (1e6, "micro"), (1e9, "nano")])
def test_times_since_1970_in_smaller_units_are_converted(tmp_path, per_second, unit):
    """No time since 1970 in seconds is as large."""

    def stamp(i: int) -> str:
        return str(int((1_700_000_000 + i / 5) * per_second))

    (tmp_path / "a.csv").write_text(csv_of(measured, ("0.1", "30"), stamp))
    log = open_log(tmp_path / "a.csv")
    np.testing.assert_allclose((log.stamps_ns - log.stamps_ns[0]) * 1e-9, 0.2 * np.arange(N), atol=1e-6)
    assert log.stamps_ns[0] == T0
    assert log.notes == (f"The times are {unit}seconds since 1970, where the format has seconds: they are converted.",)
    (tmp_path / "a.txt").write_text("".join(f"{stamp(i)} {i} 0 0 0 0 0 1\n" for i in range(N)))
    poses = read_tum(tmp_path / "a.txt")
    np.testing.assert_array_equal(poses.stamps_ns, T0 + STEP * np.arange(N))
    assert f"{unit}seconds" in poses.notes[0]


def test_the_names_of_columns_before_a_trajectory_are_passed_over(tmp_path):
    """As spreadsheets and pandas write them, without the mark of a remark."""
    (tmp_path / "a.txt").write_text("timestamp tx ty tz qx qy qz qw\n1.5 2 3 0 0 0 0 1\n")
    assert read_tum(tmp_path / "a.txt").poses.tolist() == [[2.0, 3.0, 0.0]]


@pytest.mark.parametrize("stated", [30_000.0, 30.0])
def test_readings_in_millimetres_are_named(tmp_path, stated):
    said = [
        replace(one, fields=one.fields | {"ranges": 1000.0 * one.fields["ranges"], "range_max": stated})
        if one.topic == "/scan"
        else one
        for one in drive(measured)
    ]
    (note,) = open_log(written(tmp_path, said, "mcap")).notes
    assert re.fullmatch(r"The readings are usually 3,\d\d\d m, farther than a lidar measures: .*", note)


def test_scans_that_name_no_frame_say_so(tmp_path):
    said = [
        replace(one, fields=one.fields | {"header": recorded.header(one.stamp_ns, "")}) if one.topic == "/scan" else one
        for one in drive(measured)
    ]
    (note,) = open_log(written(tmp_path, said, "mcap")).notes
    assert note.startswith("The scans name no frame (frame_id is empty), so tf cannot say where they were made")


def test_logs_without_a_measured_distance_say_why(tmp_path):
    """SteveMacenski/slam_toolbox#662, ros-perception/slam_gmapping#47, and the fixed-distance rangers of REP 117."""
    nothing = drive(lambda i: replace(said := measured(i), fields=said.fields | {"ranges": np.full(180, np.inf, "f4")}))
    notes = open_log(written(tmp_path, nothing, "mcap")).notes
    assert any("All 2160 readings are no return" in note and "--no-return free" in note for note in notes)
    said = []
    for i in range(N):
        one = sonar(T0 + i * STEP, -np.inf if i % 3 else np.inf, "/ir", "ir")
        said.append(replace(one, fields=one.fields | {"min_range": 0.5, "max_range": 0.5}))
    notes = open_log(written(tmp_path, said, "bag")).notes
    assert any("a ranger for one fixed distance (REP 117)" in note for note in notes)
    assert any("None of the 12 readings is a measured distance" in note for note in notes)


@pytest.mark.parametrize(
    ("times", "limits", "said"),
    [
        (30.0, (0.1, 30.0), "are beyond range_max, 30 m. They are usually"),
        (1.0, (0.1, 0.5), "are beyond range_max, 0.5 m"),
        (1.0, (25.0, 30.0), "are below range_min, 25 m"),
    ],
)
def test_limits_that_exclude_all_readings_are_named(tmp_path, times, limits, said):
    """Readings in another unit, or limits of another sensor: "no return" would be a wrong reason."""
    bearings = np.radians(np.arange(90) * 4.0)
    said_scans = drive(
        lambda i: scan(T0 + i * STEP, times * distances(i, bearings), angles=(0.0, 0.07), limits=limits), 3
    )
    notes = open_log(written(tmp_path, said_scans, "mcap")).notes
    assert [note for note in notes if said in note and "that limit is wrong" in note]
    assert not any("no return" in note for note in notes)


def test_a_map_that_is_too_large_has_the_notes_on_its_log(tmp_path, run):
    """Poses in millimetres: a coarser resolution would not help."""
    said = drive(measured, 4)
    for k, one in enumerate([one for one in said if one.topic == "/tf"]):
        said[said.index(one)] = transform(one.stamp_ns, "odom", "base_link", 1000.0 * k, 0.0)
    told = run("map", written(tmp_path, said, "mcap"), "--out", tmp_path / "map")
    assert told.status == 2
    assert "choose a coarser resolution" in told.err
    assert "apparently its poses are in millimetres" in told.err


def test_refused_messages_are_counted_by_their_reasons(tmp_path):
    said = drive(measured)
    said += [replace(one := measured(i), fields=one.fields | {"angle_increment": 0.0}) for i in range(3)]
    said += [replace(one := measured(9), fields=one.fields | {"ranges": np.zeros(0, dtype=np.float32)})]
    log = open_log(written(tmp_path, said, "db3"))
    (note,) = [note for note in log.notes if "could not be read" in note]
    assert "4 of 16 on /scan: 3 of them: the angle_increment is 0 rad for 180 beams (message 13)" in note
    assert "1 of them: they have no readings (message 16)" in note


# -- text logs ------------------------------------------------------------------------------------------------------


def flaser(n: int, first: float, step: float, head: Iterable[str] = (), word: str = "FLASER") -> bytes:
    """A CARMEN log of n beams from ``first`` on, ``step`` apart, degrees."""
    bearings = np.radians(first + step * np.arange(n))
    lines = list(head)
    for i in range(N):
        ranges = " ".join(f"{value:.4f}" for value in distances(i, bearings, (0.0, 0.0, 0.0)))
        place = " ".join(f"{value:.6f}" for value in pose(i))
        lines.append(f"{word} {n} {ranges} {place} {place} {i * 0.2:.6f} host {i * 0.2:.6f}")
    return "\n".join([*lines, ""]).encode()


URG = 360.0 / 1024.0
#: Beams, first bearing and step in degrees, and lines before them. gmapping: carmenconfiguration.cpp; MRPT: the
#: parameters of carmen_log_tools; the manuals of SICK's LMS 200 and Hokuyo's UTM-30LX.
ANGLES: tuple[tuple[int, float, float, tuple[str, ...], str], ...] = (
    (180, -90.0, 1.0, (), ""),
    (361, -90.0, 0.5, (), "0.5° apart, 180° in all"),
    (540, -135.0, 0.5, (), "0.5° apart"),
    (683, -341.0 * URG, URG, (), "0.3516° apart"),
    (769, -384.0 * URG, URG, (), "270° in all"),
    (1081, -135.0, 0.25, (), "0.25° apart, 270° in all"),
    (401, -50.0, 0.25, (), "100° in all"),
    (271, -135.0, 1.0, (), "270° in all"),
    (811, -135.0, 1.0 / 3.0, (), "270° in all"),
    (381, -95.0, 0.5, (), "190° in all"),
    (273, -136.0, 1.0, ("PARAM laser_front_laser_resolution 1.0",), "as PARAM states"),
    (513, -128.0, 0.5, ("PARAM laser_front_laser_fov 256", "PARAM laser_front_laser_resolution 0.5"), "256° in all"),
    (501, -125.0, 0.5, ("PARAM laser_front_laser_fov 4.363323",), "as PARAM states"),
    (361, -180.0, 1.0, ("PARAM laser_front_laser_fov 360", "PARAM laser_front_laser_resolution 1"), "as PARAM states"),
    (121, -120.0, 2.0, ("PARAM laser_laser1_fov 240", "PARAM laser_laser1_resolution 2"), "as PARAM states"),
    (725, -362.0 * URG, URG, (), "as lidars with one beam more send them"),
    (542, -135.25, 0.5, (), "as lidars with one beam less send them"),
    (91, -90.0, 2.0, (), "180° is assumed"),
)  # fmt: skip


TEXTS_THAT_ARE_NO_LOGS = {
    "a table of rostopic echo": ("%time,field.header.seq,field.ranges0\n1,2,3.0\n", "as rostopic echo -p prints it"),
    "messages of ros2 topic echo": ("header:\n  stamp:\n    sec: 1\nranges:\n- 1.0\n", "as ros2 topic echo prints"),
    "a pointer of Git LFS": ("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1\n", "git lfs pull"),
    "a pointer of git-annex": ("/annex/objects/SHA256E-s1234--4d7a.bag\n", "git annex get fetches it"),
    "an answer of a server": ("<!DOCTYPE html>\n<html><head><title>Sign in</title>", "download the file itself"),
    "poses of KITTI": ("1.0e0 1e-3 0 5.5 -1e-3 1.0 0 0 0 0 1.0 0\n" * 3, "in the format KITTI.*It states no times"),
    "poses of NCLT": ("1335704128000000,1.5,0,0,0,0,0.1\n" * 3, "in the format NCLT.*as TUM has them"),
    "poses of EuRoC": ("#t,x\n1403636580838555648,1,2,3,0.8,0.6,0,0,0.1\n" * 3, "in the format EuRoC.*evo_traj"),
}


@pytest.mark.parametrize("name", TEXTS_THAT_ARE_NO_LOGS)
def test_texts_that_are_no_logs_are_told_what_they_are(tmp_path, name):
    text, said = TEXTS_THAT_ARE_NO_LOGS[name]
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(ReadError, match=said):
        open_log(tmp_path / "a.csv")
    if "poses" in name:  # numbers, which could be points
        with pytest.raises(ReadError, match=said):
            read_cloud(tmp_path / "a.csv")


BINARY_THAT_ARE_NO_LOGS = {
    "Cartographer": (0x7B1D1F7B5BF501DB.to_bytes(8, "little") + bytes(40), "cartographer_pbstream_to_ros_map"),
    "slam_toolbox": (b"\x16" + bytes(7) + b"serialization::archive" + bytes(40), "save its map with map_saver"),
    "PCAP": (struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1), "replay them to the lidar’s ROS driver"),
    "PCAP, big endian, ns": (struct.pack(">IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 1), "PCAP"),
    "PCAPNG": (struct.pack("<III", 0x0A0D0D0A, 28, 0x1A2B3C4D), "PCAP"),
    "Livox Viewer": (b"livox_tech" + bytes(30), "livox_ros_driver plays it"),
    "GeoTIFF": (b"II*\0" + bytes(30), "heights, save as points"),
}


@pytest.mark.parametrize("name", BINARY_THAT_ARE_NO_LOGS)
def test_files_of_other_programs_are_named_with_what_to_do(tmp_path, name):
    """In place of "binary data of an unknown kind"."""
    data, said = BINARY_THAT_ARE_NO_LOGS[name]
    (tmp_path / "a").write_bytes(data)
    for read in (open_log, read_cloud):
        with pytest.raises(ReadError, match=said):
            read(tmp_path / "a")


def test_a_database_of_rtabmap_is_named_with_what_exports_it(tmp_path):
    with closing(sqlite3.connect(tmp_path / "map.db")) as database:
        for table in ("Node", "Data", "Link"):
            database.execute(f"CREATE TABLE {table}(id INTEGER)")
        database.commit()
    with pytest.raises(ReadError, match=r"RTAB-Map.*rtabmap-export"):
        open_log(tmp_path / "map.db")


def test_a_workbook_is_no_archive_to_unpack(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.xlsx", "w") as book:
        book.writestr("[Content_Types].xml", "<Types/>")
    with pytest.raises(ReadError, match="workbook of Excel \\(save its sheet as CSV"):
        open_log(tmp_path / "a.xlsx")


def test_a_folder_of_clouds_says_how_they_are_mapped(tmp_path):
    for k in range(3):
        (tmp_path / f"{k:06d}.pcd").write_bytes(b"VERSION 0.7\n")
    (tmp_path / "timestamps.txt").write_text("2011-09-26 13:02:25.594\n")
    with pytest.raises(
        ReadError, match=r"holds 3 clouds, as '000000\.pcd', and no log: gridbloom map3d maps such files"
    ):
        open_log(tmp_path)


@pytest.mark.parametrize(("n", "first", "step", "head", "words"), ANGLES)
def test_the_beams_of_lines_without_angles(tmp_path, n, first, step, head, words):
    path = tmp_path / "a.log"
    path.write_bytes(flaser(n, first, step, head))
    log = open_log(path)
    assert off_the_walls(ends(log)) < 2e-3
    assert (words and any(words in note for note in log.notes)) or not log.notes
    assert log.angles_assumed == (words == "180° is assumed")


def test_lines_whose_beams_change_are_each_read_as_they_are(tmp_path):
    """A lidar whose resolution, field of view and range are switched while CARMEN records."""
    modes = ((180, -90.0, 1.0), (361, -90.0, 0.5), (541, -135.0, 0.5))
    logs = [flaser(*mode).splitlines() for mode in modes]
    path = tmp_path / "a.log"
    path.write_bytes(b"\n".join([logs[i % 3][i] for i in range(N)] + [b""]))
    log = open_log(path)
    assert isinstance(log, JointLog)
    assert (log.n_scans, log.topic, len(log.parts)) == (N, "FLASER", 3)
    assert len(ends(log)) == N // 3 * (180 + 361 + 541)
    assert off_the_walls(ends(log)) < 2e-3
    assert any("do not have the same beams or limits: 4 with" in note for note in log.notes)
    np.testing.assert_allclose(log.trajectory().poses, [pose(i) for i in range(N)], atol=1e-6)


def test_lines_that_state_other_angles_and_limits_are_each_read_so(tmp_path):
    lines = []
    for i in range(N):
        first, step, n, limit = ((-1.57, 0.0174533, 181, 50.0), (-1.2, 0.01, 241, 4.0))[i % 2]
        ranges = " ".join(f"{r:.5f}" for r in distances(i, first + step * np.arange(n), (0.0, 0.0, 0.0)))
        place = " ".join(f"{value:.6f}" for value in pose(i))
        lines.append(
            f"ROBOTLASER1 0 {first} {step * (n - 1):.7f} {step} {limit} 0.01 0 {n} {ranges} 0 {place} {place} "
            f"0 0 0 0 0 {i * 0.2:.6f} host {i * 0.2:.6f}"
        )
    path = tmp_path / "a.log"
    path.write_text("\n".join([*lines, ""]))
    log = open_log(path)
    assert [log.scan(i).range_max for i in range(2)] == [50.0, 4.0]
    points = ends(log)
    assert off_the_walls(points) < 2e-3
    assert np.isposinf(log.scan(1).ranges).any()


def test_a_line_without_a_maximum_range_has_that_of_sicks_lidars(tmp_path):
    """Drivers that do not know their lidar's range write 0."""
    ranges = " ".join(f"{r:.5f}" for r in distances(0, np.radians(np.arange(-90.0, 91.0)), (0.0, 0.0, 0.0)))
    line = f"ROBOTLASER1 0 -1.570796 3.141593 0.0174533 0 0.01 0 181 {ranges} 0 0 0 0 0 0 0 0 0 0 0 0 1.0 host 1.0\n"
    (tmp_path / "a.log").write_text(line)
    log = open_log(tmp_path / "a.log")
    assert log.range_max == 80.0
    assert off_the_walls(ends(log)) < 2e-3
    assert log.notes[0].startswith("ROBOTLASER1 lines state a maximum range of 0 m, which no lidar has")


def test_lines_of_the_first_carmen_are_read_as_those_of_the_front_laser(tmp_path):
    data = flaser(181, -90.0, 1.0)
    (tmp_path / "a.log").write_bytes(data)
    (tmp_path / "b.log").write_bytes(data.replace(b"FLASER", b"LASER"))
    first, old = (open_log(tmp_path / name) for name in ("a.log", "b.log"))
    assert (old.topic, old.n_scans) == ("LASER", N)
    np.testing.assert_array_equal(old.ranges, first.ranges)
    np.testing.assert_array_equal(old.trajectory().poses, first.trajectory().poses)
    assert (old.angle_min, old.angle_increment) == (first.angle_min, first.angle_increment)


def in_units(data: bytes, of_length: float) -> bytes:
    """A CARMEN log with its readings and positions in another unit, so many of them in a metre."""
    lines = []
    for line in data.decode().splitlines():
        word, n, *fields = line.split()
        values = np.array(fields[: int(n) + 6], dtype=float)
        values *= of_length
        values[[-4, -1]] /= of_length
        lines.append(" ".join([word, n, *(f"{value:.6g}" for value in values), *fields[int(n) + 6 :]]))
    return "\n".join([*lines, ""]).encode()


def test_readings_in_millimetres_are_no_code_for_no_return(tmp_path):
    path = tmp_path / "a.log"
    path.write_bytes(in_units(flaser(180, -90.0, 1.0), 1000.0))
    said = " ".join(open_log(path).notes)
    assert re.search(r"The readings are usually [\d,]+ m, farther than a lidar measures: apparently they are in", said)
    assert "no return" not in said


@pytest.mark.parametrize("code", [81.91, 1e9])
def test_a_code_for_no_return_is_no_other_unit(tmp_path, code):
    """In the open most beams have it."""
    lines = [line.split() for line in flaser(180, -90.0, 1.0).decode().splitlines()]
    for line in lines:
        line[2:152] = [str(code)] * 150
    path = tmp_path / "a.log"
    path.write_text("\n".join(" ".join(line) for line in lines) + "\n")
    log = open_log(path)
    assert log.notes == ()
    assert np.isposinf(log.ranges).sum() == 150 * N


def nothing_read_as(code: float, poses: Callable[[int], tuple[float, float, float]] = pose) -> bytes:
    """A CARMEN log of a lidar that sees up to 4 m and reads ``code`` where nothing is."""
    bearings = np.radians(-90.0 + np.arange(180))
    lines = []
    for i in range(N):
        ranges = distances(i, bearings, (0.0, 0.0, 0.0))
        ranges[ranges > 4.0] = code
        place = " ".join(f"{value:.6f}" for value in poses(i))
        readings = " ".join(f"{value:.2f}" for value in ranges)
        lines.append(f"FLASER 180 {readings} {place} {place} {i * 0.2:.6f} host {i * 0.2:.6f}")
    return "\n".join([*lines, ""]).encode()


@pytest.mark.parametrize("code", [4.0, 5.12, 40.95])
def test_a_distance_that_no_wall_can_have_over_so_many_beams_is_no_return(tmp_path, code):
    """FLASER lines state no range_max: lidars that see up to 4 m read that where nothing is."""
    path = tmp_path / "a.log"
    path.write_bytes(nothing_read_as(code))
    log = open_log(path)
    assert off_the_walls(ends(log)) < 0.01
    assert np.isposinf(log.ranges).sum() > 200
    (note,) = [note for note in log.notes if "no return" in note]
    assert f"are exactly {code:g} m, the greatest there is" in note


def test_a_greatest_distance_that_a_robot_sees_from_one_place_may_be_a_wall(tmp_path):
    path = tmp_path / "a.log"
    path.write_bytes(nothing_read_as(4.0, lambda i: (0.0, 0.0, 0.02 * i)))
    log = open_log(path)
    assert not np.isposinf(log.ranges).any()
    assert any("likely the sensor’s code for no return" in note for note in log.notes)


def test_a_flat_wall_at_the_greatest_distance_stays(tmp_path):
    """Rounded to decimetres, 18° of walls that are 4 m away, and parallel to the way, read the same."""
    bearings = np.radians(-90.0 + np.arange(181))
    with np.errstate(divide="ignore"):
        ranges = 4.0 / np.abs(np.sin(bearings))
    ranges = np.where(ranges < 4.05, 4.0, np.round(3.0 + 0.5 * np.abs(bearings), 1))
    readings = " ".join(f"{value:.1f}" for value in ranges)
    places = [f"{0.1 * i:.3f} 0 0" for i in range(20)]
    lines = [f"FLASER 181 {readings} {place} {place} {i} host {i}" for i, place in enumerate(places)]
    (tmp_path / "a.log").write_text("\n".join(lines) + "\n")
    log = open_log(tmp_path / "a.log")
    assert np.count_nonzero(log.ranges == np.float32(4.0)) >= 20 * 20
    assert not np.isposinf(log.ranges).any()


def test_headings_in_degrees_are_refused(tmp_path):
    """They are compared with how the robot moves: it may have turned on and on, so that many radians are stated."""
    path = tmp_path / "a.log"

    def wrote(unit: float, turns: int = 0) -> None:
        lines = []
        for i in range(N + 3):
            a = 0.15 * i
            place = f"{3 * math.sin(a):.6f} {3 - 3 * math.cos(a):.6f} {(a + turns * 2 * math.pi) / unit:.6f}"
            lines.append(f"FLASER 3 1 2 1 {place} {place} {i * 0.2:.6f} host {i * 0.2:.6f}\n")
        path.write_text("".join(lines))

    wrote(math.radians(1.0))
    with pytest.raises(ReadError, match=r"The headings of the poses, [\d.]+ to [\d.]+, are in degrees"):
        open_log(path)
    wrote(1.0, turns=3)
    assert open_log(path).trajectory().poses[5, 2] == pytest.approx(0.75)


def test_a_recording_whose_topics_have_no_messages_says_so(tmp_path):
    path = written(tmp_path, [scan(0, [1.0, 2.0])], "db3")
    with closing(sqlite3.connect(path)) as database:
        database.execute("DELETE FROM messages")
        database.commit()
    with pytest.raises(ReadError, match=r"its topics have no messages \(sensor_msgs/LaserScan on /scan\)"):
        open_log(path)


def test_in_a_folder_without_a_log_the_file_that_should_be_one_is_named(tmp_path):
    (tmp_path / "run_0.db3").write_bytes(b"")
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  version: 5\n")
    with pytest.raises(ReadError, match=r"^run_0\.db3: The file is empty\.$"):
        open_log(tmp_path)


def test_dp_slam_and_rear_lasers_have_the_same_table():
    """One table for all formats whose lines state no angles."""
    beams = front_laser_beams(541, "Laser")
    assert (math.degrees(beams.angle_min), math.degrees(beams.angle_increment)) == pytest.approx((-135.0, 0.5))
    assert "541 beams of the Laser lines" in beams.notes[0]


def test_raw_lasers_have_the_poses_of_the_odometry(tmp_path):
    """CARMEN's RAWLASER lines state angles, and no poses."""
    bearings = np.radians(-100.0 + 0.5 * np.arange(401))
    lines = []
    for i in range(N):
        place = " ".join(f"{value:.6f}" for value in pose(i))
        ranges = " ".join(f"{value:.4f}" for value in distances(i, bearings, (0.0, 0.0, 0.0)))
        lines.append(f"ODOM {place} 0 0 0 {i * 0.2:.6f} h {i * 0.2:.6f}")
        lines.append(
            f"RAWLASER1 0 -1.745329 3.490659 0.008727 81.9 0.01 0 401 {ranges} 0 {i * 0.2:.6f} h {i * 0.2:.6f}"
        )
    path = tmp_path / "a.log"
    path.write_text("\n".join([*lines, ""]))
    log = open_log(path)
    assert (log.format, list(log.trajectories)) == ("CARMEN RAWLASER1", ["wheel"])
    assert off_the_walls(ends(log)) < 2e-3
    assert log.mount_assumed
    assert any("RAWLASER1 lines do not say where the laser is on the robot" in note for note in log.notes)
    path.write_text("\n".join(["PARAM robot_frontlaser_offset 0.0", *lines, ""]))
    stated = open_log(path)
    assert (stated.mount_assumed, stated.notes) == (False, ())
    path.write_text("\n".join([line for line in lines if line.startswith("RAW")] + [""]))
    without = open_log(path)
    assert without.trajectory().is_placeholder
    assert any("RAWLASER1 lines state no poses" in note for note in without.notes)
    given = with_trajectory(without, TimedPoses(without.stamps_ns, np.zeros((N, 3))))
    assert not any("no poses" in note for note in given.notes)


@pytest.mark.parametrize(("resolution", "contradicts"), [(0.5, False), (0.5025, False), (0.25, True), (1.0, True)])
def test_beams_whose_field_of_view_contradicts_their_resolution_are_named(tmp_path, resolution, contradicts):
    """The resolution counts, as in CARMEN (carmen_laser: start_angle + i · angular_resolution)."""
    fov, step = math.radians(180.0), math.radians(resolution)
    line = f"ROBOTLASER1 0 {-0.5 * fov:.6f} {fov:.6f} {step:.6f} 81.9 0.01 0 361 {'1.0 ' * 361}0 {'0 ' * 11}0 h 0\n"
    path = tmp_path / "a.log"
    path.write_text(line * 3)
    log = open_log(path)
    assert log.angle_increment == pytest.approx(step, abs=1e-6)
    assert any("and the field of view is 180°" in note for note in log.notes) == contradicts


def test_what_gmapping_writes_has_the_poses_of_its_best_particle(tmp_path):
    bearings = np.radians(-90.0 + np.arange(181))
    lines = []
    for i in range(N):
        ranges = " ".join(f"{value:.4f}" for value in distances(i, bearings, (0.0, 0.0, 0.0)))
        x, y, yaw = pose(i)
        lines += [
            f"FRAME {i} 0.1 0.1",
            f"LASER_READING 181 {ranges} {1.2 * x:.6f} {y:.6f} {yaw:.6f} {i * 0.2:.6f}",
            f"SM_UPDATE 2 9 9 9 -40 {x:.6f} {y:.6f} {yaw:.6f} -3",
            "NEFF 1.9",
        ]
    path = tmp_path / "a.gfs"
    path.write_text("\n".join([*lines, ""]))
    log = open_log(path)
    assert list(log.trajectories) == ["gmapping", "odom"]
    assert off_the_walls(ends(log)) < 2e-3


# -- containers and types -------------------------------------------------------------------------------------------


def key(number: int, wire: int) -> bytes:
    return bytes([number << 3 | wire])


def length(number: int, data: bytes) -> bytes:
    n, out = len(data), b""
    while n >= 0x80:
        out, n = out + bytes([n & 0x7F | 0x80]), n >> 7
    return key(number, 2) + out + bytes([n]) + data


def double(number: int, value: float) -> bytes:
    return key(number, 1) + struct.pack("<d", value)


def protobuf(kind: str, values: dict[str, Any]) -> bytes:
    """A message of Foxglove's schemas, written by hand from the numbers in its .proto files."""
    seconds = values["timestamp"]["sec"]
    varint = b""
    while seconds >= 0x80:
        varint, seconds = varint + bytes([seconds & 0x7F | 0x80]), seconds >> 7
    stamp = key(1, 0) + varint + bytes([seconds]) + key(2, 5 - 5) + varint_of(values["timestamp"]["nsec"])
    out = length(1, stamp)
    if kind == "FrameTransform":
        out += length(2, values["parent_frame_id"].encode()) + length(3, values["child_frame_id"].encode())
        out += length(4, b"".join(double(k, values["translation"][axis]) for k, axis in enumerate("xyz", 1)))
        return out + length(5, b"".join(double(k, values["rotation"][axis]) for k, axis in enumerate("xyzw", 1)))
    place, turn = values["pose"]["position"], values["pose"]["orientation"]
    position = b"".join(double(k, place[axis]) for k, axis in enumerate("xyz", 1))
    orientation = b"".join(double(k, turn[axis]) for k, axis in enumerate("xyzw", 1))
    out += length(2, values["frame_id"].encode()) + length(3, length(1, position) + length(2, orientation))
    out += double(4, values["start_angle"]) + double(5, values["end_angle"])
    return out + length(6, struct.pack(f"<{len(values['ranges'])}d", *values["ranges"]))


def varint_of(n: int) -> bytes:
    out = b""
    while n >= 0x80:
        out, n = out + bytes([n & 0x7F | 0x80]), n >> 7
    return out + bytes([n])


def foxglove(encoding: str) -> bytes:
    """A drive as Foxglove's schemas have it: the scan's pose in the base's frame is stated in the scan."""
    out = io.BytesIO()
    writer = Writer(out)
    writer.start()
    schema = {"json": "jsonschema", "protobuf": "protobuf"}[encoding]
    channels = {}
    for kind, topic in (("FrameTransform", "/transforms"), ("LaserScan", "/scan")):
        number = writer.register_schema(f"foxglove.{kind}", schema, b"{}")
        channels[kind] = writer.register_channel(topic, encoding, number)
    bearings = -2.0 + 0.05 * np.arange(81)
    half = MOUNT[2] / 2.0
    for i in range(N):
        at, (x, y, yaw) = T0 + i * STEP, pose(i)
        stamp = {"sec": at // SECOND, "nsec": at % SECOND}
        messages: dict[str, dict[str, Any]] = {
            "FrameTransform": {
                "timestamp": stamp,
                "parent_frame_id": "odom",
                "child_frame_id": "base_link",
                "translation": {"x": x, "y": y, "z": 0.0},
                "rotation": recorded.quaternion(yaw),
            },
            "LaserScan": {
                "timestamp": stamp,
                "frame_id": "base_link",
                "pose": {
                    "position": {"x": MOUNT[0], "y": MOUNT[1], "z": 0.0},
                    "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
                },
                "start_angle": -2.0,
                "end_angle": 2.0,
                "ranges": distances(i, bearings).tolist(),
            },
        }
        for kind, values in messages.items():
            data = json.dumps(values).encode() if encoding == "json" else protobuf(kind, values)
            writer.add_message(channels[kind], at, data, at)
    writer.finish()  # type: ignore[no-untyped-call]
    return out.getvalue()


@pytest.mark.parametrize("encoding", ["json", "protobuf"])
def test_foxgloves_messages_are_read(tmp_path, encoding):
    """foxglove/mcap#316, rerun-io/rerun#9949."""
    path = tmp_path / "a.mcap"
    path.write_bytes(foxglove(encoding))
    log = open_log(path)
    assert (log.n_scans, log.n_beams, log.default_trajectory) == (N, 81, "tf/odom")
    assert log.mount == pytest.approx(MOUNT, abs=1e-6)
    assert off_the_walls(ends(log)) < 1e-3
    assert f"foxglove.LaserScan messages in {encoding} on /scan are read as sensor_msgs/LaserScan." in log.notes


FOXGLOVE_MSGS = {
    "PackedElementField": "string name\nuint32 offset\nuint8 type",
    "LaserScan": "{time} timestamp\nstring frame_id\ngeometry_msgs/Pose pose\nfloat64 start_angle\n"
    "float64 end_angle\nfloat64[] ranges\nfloat64[] intensities",
    "PointCloud": "{time} timestamp\nstring frame_id\ngeometry_msgs/Pose pose\nuint32 point_stride\n"
    "foxglove_msgs/PackedElementField[] fields\nuint8[] data",
    "FrameTransform": "{time} timestamp\nstring parent_frame_id\nstring child_frame_id\n"
    "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "FrameTransforms": "foxglove_msgs/FrameTransform[] transforms",
}  #: foxglove-sdk's schemas of ROS


@pytest.mark.parametrize("sensor", ["LaserScan", "PointCloud"])
@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
def test_foxgloves_messages_in_the_serialisation_of_ros_are_read(tmp_path, kind, sensor):
    """foxglove_msgs, as ros_foxglove_bridge's packages have them; of a robot in a namespace of its own."""
    from rosbags.typesys import get_types_from_msg

    for ros, time in ((1, "time"), (2, "builtin_interfaces/Time")):
        types: dict[str, Any] = {}
        for name, text in FOXGLOVE_MSGS.items():
            types |= get_types_from_msg(text.format(time=time), f"foxglove_msgs/msg/{name}")
        recorded.store(ros).register(types)
    bearings = -2.0 + 0.05 * np.arange(81)
    said = []
    for i in range(N):
        at, (x, y, yaw) = T0 + i * STEP, pose(i)
        stamp = {"sec": at // SECOND, "nanosec": at % SECOND}
        place = {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": recorded.quaternion(yaw)}
        one = {"timestamp": stamp, "parent_frame_id": "odom", "child_frame_id": "base_link", **place}
        said.append(Said("/robot/transforms", "foxglove_msgs/msg/FrameTransforms", at, {"transforms": [one]}))
        origin = {
            "position": {"x": MOUNT[0], "y": MOUNT[1], "z": 0.4}, "orientation": recorded.quaternion(MOUNT[2])
        }  # fmt: skip
        fields: dict[str, Any] = {"timestamp": stamp, "frame_id": "base_link", "pose": origin}
        ranges = distances(i, bearings)
        if sensor == "LaserScan":
            fields |= {"start_angle": -2.0, "end_angle": 2.0, "ranges": ranges, "intensities": np.zeros(0)}
        else:
            points = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings), 0.0 * ranges], axis=1)
            packed = [{"name": name, "offset": 4 * k, "type": 7} for k, name in enumerate("xyz")]
            data = np.frombuffer(points.astype("<f4").tobytes(), np.uint8)
            fields |= {"point_stride": 12, "fields": packed, "data": data}
        said.append(Said("/robot/front/scan", f"foxglove_msgs/msg/{sensor}", at, fields))
    log = open_log(written(tmp_path, said, kind))
    assert (log.n_scans, log.default_trajectory) == (N, "tf/odom")
    if sensor == "LaserScan":
        assert log.mount == pytest.approx(MOUNT, abs=1e-6)
    assert len(ends(log)) > 0.9 * N * len(bearings)
    assert off_the_walls(ends(log)) < (1e-3 if sensor == "LaserScan" else 0.12)
    encoding = "ros1" if kind == "bag" else "cdr"
    assert any(f"{sensor} messages in {encoding} on /robot/front/scan are read as" in note for note in log.notes)


def test_flatbuffers_are_named(tmp_path):
    out = io.BytesIO()
    writer = Writer(out)
    writer.start()
    number = writer.register_schema("foxglove.LaserScan", "flatbuffer", b"\0")
    channel = writer.register_channel("/scan", "flatbuffer", number)
    writer.add_message(channel, T0, b"\0" * 40, T0)
    writer.finish()  # type: ignore[no-untyped-call]
    path = tmp_path / "a.mcap"
    path.write_bytes(out.getvalue())
    with pytest.raises(ReadError, match="the messages are encoded as 'flatbuffer', which is not read"):
        open_log(path)


def test_a_schema_that_is_empty_is_known_by_its_name(tmp_path):
    """ros2/rosbag2#1922; and one whose messages are serialised otherwise is named."""
    for encoding, schema in (("cdr", ""), ("json", "jsonschema")):
        out = io.BytesIO()
        writer = Writer(out)
        writer.start()
        channels: dict[str, int] = {}
        for said in drive(measured):
            if said.topic not in channels:
                kind = writer.register_schema(said.kind, schema, b"")
                channels[said.topic] = writer.register_channel(said.topic, encoding, kind)
            writer.add_message(channels[said.topic], said.stamp_ns, recorded.serialised(said, 2), said.stamp_ns)
        writer.finish()  # type: ignore[no-untyped-call]
        path = tmp_path / "a.mcap"
        path.write_bytes(out.getvalue())
        if encoding == "cdr":
            assert off_the_walls(ends(open_log(path))) < 1e-3
            continue
        with pytest.raises(
            ReadError, match=r"serialised in a way that is not read.*the messages are encoded as 'json'"
        ):
            open_log(path)


def record(header: bytes, data: bytes, stated: int | None = None) -> bytes:
    n = len(data) if stated is None else stated
    return struct.pack("<I", len(header)) + header + struct.pack("<I", n) + data


def header(**fields: bytes) -> bytes:
    parts = [name.encode() + b"=" + value for name, value in fields.items()]
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def test_the_stated_length_of_an_index_is_ignored_as_rosbag_does(tmp_path):
    """ccny-ros-pkg/scan_tools PR 77: bags of 2010, whose index records state 20 bytes an entry and have 12."""
    out = b"#ROSBAG V2.0\n" + record(header(op=b"\x03"), b"")
    said = drive(measured)
    for part in (said[:9], said[9:]):
        data, counts = b"", dict[str, int]()
        for one in part:
            number = struct.pack("<I", list(dict.fromkeys(s.topic for s in said)).index(one.topic))
            if one.topic not in counts:
                about = header(topic=one.topic.encode(), type=one.kind.replace("/msg/", "/").encode())
                data += record(header(op=b"\x07", conn=number, topic=one.topic.encode()), about)
            counts[one.topic] = counts.get(one.topic, 0) + 1
            time = struct.pack("<II", *divmod(one.stamp_ns, SECOND))
            data += record(header(op=b"\x02", conn=number, time=time), recorded.serialised(one, 1))
        out += record(header(op=b"\x05", compression=b"none", size=struct.pack("<I", len(data))), data)
        for at, count in enumerate(counts.values()):
            about = header(
                op=b"\x04", ver=struct.pack("<I", 1), conn=struct.pack("<I", at), count=struct.pack("<I", count)
            )
            out += record(about, bytes(12 * count), 20 * count)
    path = tmp_path / "a.bag"
    path.write_bytes(out)
    log = open_log(path)
    assert (log.n_scans, log.notes) == (N, ())
    assert off_the_walls(ends(log)) < 1e-3


@pytest.mark.parametrize(("version", "words"), [("V1.2", "rosbag of ROS 1 converts it"), ("V1.1", "C Turtle")])
def test_old_bags_name_their_version_and_what_converts_them(tmp_path, version, words):
    """wiki.ros.org/Bags/Format."""
    path = tmp_path / "a.bag"
    path.write_bytes(f"#ROSRECORD {version}\n".encode() + bytes(100))
    with pytest.raises(ReadError, match=rf"old format \(#ROSRECORD {version}\).*{words}") as caught:
        open_log(path)
    assert caught.value.code == "log.version"


@pytest.mark.parametrize("ros", [1, 2])
def test_livox_messages_are_clouds(tmp_path, ros):
    """Livox-SDK/livox_ros_driver#104: CustomMsg, which CDR aligns otherwise than ROS 1."""
    from rosbags.typesys import get_types_from_msg

    package = "livox_ros_driver" if ros == 1 else "livox_ros_driver2"
    recorded.store(ros).register(
        {
            **get_types_from_msg(
                "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
                "CustomPoint[] points",
                f"{package}/msg/CustomMsg",
            ),
            **get_types_from_msg(
                "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\nuint8 reflectivity\nuint8 tag\nuint8 line",
                f"{package}/msg/CustomPoint",
            ),
        }
    )
    bearings = np.radians(np.arange(0.5, 360.0, 1.0))

    def points(i: int) -> Said:
        ranges = distances(i, bearings)
        numbers = [
            {
                "offset_time": k,
                "x": r * math.cos(b),
                "y": r * math.sin(b),
                "z": 0.5,
                "reflectivity": 1,
                "tag": 2,
                "line": 3,
            }
            for k, (r, b) in enumerate(zip(ranges.tolist(), bearings.tolist(), strict=True))
        ]
        fields = {
            "header": recorded.header(T0 + i * STEP, "laser"), "timebase": 0, "point_num": len(numbers), "lidar_id": 0,
            "rsvd": np.zeros(3, np.uint8), "points": numbers,
        }  # fmt: skip
        return Said("/livox/lidar", f"{package}/msg/CustomMsg", T0 + i * STEP, fields)

    log = open_log(written(tmp_path, drive(points), "bag" if ros == 1 else "db3"))
    assert log.n_scans == N
    assert len(ends(log)) > 0.9 * N * len(bearings)
    assert off_the_walls(ends(log)) < 0.12  # a cut's beams are 1° wide


def test_scans_of_two_resolutions_survive_the_pack_and_are_mapped_as_one(tmp_path):
    from mapper.io.logs import open_robot_log
    from server.library.packs.log import read_pack, write_pack

    robot = open_robot_log(written(tmp_path, drive(turned), "mcap"))
    write_pack(robot, tmp_path / "pack.npz")
    log = read_pack(tmp_path / "pack.npz", "/scan")
    assert isinstance(log, JointLog)
    assert (log.topic, log.n_scans) == ("/scan", N)
    np.testing.assert_array_equal(ends(log), ends(robot.first))
