"""Recordings as kinds of robots make them, and two faults at once: each scan's place must be the true one.

Each case is made here. What is right follows from the rules of tf2 and of the messages, as in
:mod:`tests.reports.test_transforms`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, odometry, pose_stamped, scan, transform
from tests.reports.test_transforms import (
    AHEAD,
    BAD,
    LASER,
    MOUNT,
    STEP,
    T0,
    N,
    Pose,
    assert_places,
    back,
    by_tf,
    drive,
    of,
    robots,
    sensor_at,
    static,
    together,
    true,
    with_bad,
)

CLEARPATH = "/a200_0000"
TWO_PROGRAMS = "Two programs state on /tf where 'base_link' is in 'odom', in turns"
BASE = [LASER, *drive(by_tf())]


def stamped(said: list[Said], topic: str, stamp: Callable[[int], int], frame: str | None = None) -> list[Said]:
    """The same messages, those on a topic with other stamps, and in another frame."""
    out = []
    for one in said:
        fields = one.fields
        if one.topic == topic and "transforms" in fields:
            moved = [
                each | {"header": recorded.header(stamp(one.stamp_ns), each["header"]["frame_id"])}
                for each in fields["transforms"]
            ]
            fields = {"transforms": moved}
        elif one.topic == topic:
            known = fields["header"]["frame_id"]
            fields = fields | {"header": recorded.header(stamp(one.stamp_ns), known if frame is None else frame)}
        out.append(replace(one, fields=fields))
    return out


def turtlebot3(at: int, pose: Pose) -> list[Said]:
    return [transform(at, "odom", "base_footprint", *pose), odometry(at, *pose, child="base_footprint")]


def clearpath(at: int, pose: Pose) -> list[Said]:
    wheels = (1.2 * pose[0], pose[1], pose[2])
    return [
        transform(at, "odom", "base_link", *pose, topic=f"{CLEARPATH}/tf"),
        odometry(at, *wheels, f"{CLEARPATH}/platform/odom"),
    ]


def legged(at: int, pose: Pose) -> list[Said]:
    """The body is the root, and both fixed frames are in it."""
    other = of((1.0, 2.0, 0.3), pose)
    return [transform(at, "body", "odom", *back(pose)), transform(at + 1, "body", "vision", *back(other))]


def vision_only(at: int, pose: Pose) -> list[Said]:
    return [transform(at, "body", "vision", *back(pose))]


def lidar_inertial(at: int, pose: Pose) -> list[Said]:
    """Of a mapper that knows only its lidar."""
    return [
        transform(at, "camera_init", "body", *pose),
        odometry(at, *pose, "/Odometry", frame="camera_init", child="body"),
    ]


def smoothed(at: int, pose: Pose) -> list[Said]:
    """A mapper states the lidar itself in odom, and the robot's description states it in base_link."""
    lidar = of(pose, MOUNT)
    return [
        transform(at, "map", "odom"),
        transform(at, "odom", "lidar_link", *lidar),
        odometry(at, *lidar, "/lio/mapping/odometry", child="odom_mapping"),
    ]


def loop(at: int, pose: Pose) -> list[Said]:
    return [transform(at, "odom", "base_link", *pose), transform(at, "base_link", "odom", *back(pose))]


def only(source: Callable[[int, Pose], list[Said]], each: int) -> Callable[[int, Pose], list[Said]]:
    """The poses of a source at each of so many steps."""
    return lambda at, pose: source(at, pose) if (at - T0) // STEP % each == 0 else []


def wheels(at: int, pose: Pose) -> list[Said]:
    return [odometry(at, *pose)]


def beside(other: Callable[[Pose], Pose], each: int = 1) -> list[Said]:
    """The robot's motion, and what a second program states of the same frames between its transforms."""
    said = [LASER, *drive(by_tf())]
    for i in range(N * each):
        at = T0 + (2 * i + 1) * STEP // (2 * each)
        said.append(transform(at, "odom", "base_link", *other(true(i / each))))
    return sorted(said, key=lambda one: one.stamp_ns)


def by_steps(said: list[Said]) -> list[Said]:
    """The same messages, recorded one after another from one time on."""
    return [replace(one, stamp_ns=T0 + k * SECOND // 100) for k, one in enumerate(said)]


def resets(name: str, way: int) -> list[Said]:
    """A robot in a namespace whose simulation is reset; each run goes the other way."""
    return [
        static("base_link", "laser", MOUNT, topic=f"{name}/tf_static"),
        *drive(by_tf(topic=f"{name}/tf"), f"{name}/scan", way=way),
        *drive(by_tf(topic=f"{name}/tf"), f"{name}/scan", way=1 - way),
    ]


def late(said: list[Said], topic: str, by: int) -> list[Said]:
    """The same messages, those on a topic recorded later than they were stamped."""
    return [replace(one, stamp_ns=one.stamp_ns + by) if one.topic == topic else one for one in said]


def mixed(one: list[Said], other: list[Said]) -> list[Said]:
    """Two recordings message by message in turns."""
    return [said for pair in zip(one, other, strict=True) for said in pair]


@dataclass(frozen=True)
class Case:
    messages: list[Said]
    places: list[Pose]
    note: str = "^"  #: what the notes say, a regular expression
    topic: str | None = None
    unsaid: str = "tf does not say where|no poses"  #: what they do not say


CASES = {
    "TurtleBot3": Case(
        [
            static("base_footprint", "base_link", AHEAD),
            static("base_link", "base_scan", MOUNT),
            *drive(turtlebot3, frame="base_scan"),
        ],
        sensor_at(),
    ),
    "Clearpath, all in a namespace": Case(
        [
            static("base_link", "chassis_link", AHEAD, topic=f"{CLEARPATH}/tf_static"),
            static("chassis_link", "lidar2d_0_laser", MOUNT, topic=f"{CLEARPATH}/tf_static"),
            *drive(clearpath, f"{CLEARPATH}/sensors/lidar2d_0/scan", "lidar2d_0_laser"),
        ],
        sensor_at(),
    ),
    "a legged robot whose body is the root": Case([static("body", "laser", MOUNT), *drive(legged)], sensor_at()),
    "one with vision alone": Case([static("body", "laser", MOUNT), *drive(vision_only)], sensor_at()),
    "a drone with a pose of its autopilot": Case(
        drive(lambda at, pose: [pose_stamped(at, *pose, "/mavros/local_position/pose")]),
        sensor_at(AHEAD),
        unsaid="no poses",
    ),
    "a lidar-inertial mapper without a description": Case(
        drive(lidar_inertial, frame="livox"),
        sensor_at(AHEAD),
        "tf does not say where the frame 'livox'",
        unsaid="no poses",
    ),
    "a mapper that states the lidar": Case(
        [static("base_link", "lidar_link", MOUNT), *drive(smoothed, frame="lidar_link")],
        sensor_at(),
        "2 parents of the frame 'lidar_link'",
        unsaid="no poses",
    ),
    "frames with a tf_prefix and slashes": Case(
        [static("/r1/base_link", "/r1/laser", MOUNT), *drive(by_tf("/r1/odom", "/r1/base_link"), frame="/r1/laser")],
        sensor_at(),
    ),
    "odometry without a child": Case([LASER, *drive(lambda at, pose: [odometry(at, *pose, child="")])], sensor_at()),
    "odometry of itself": Case(
        [LASER, *drive(lambda at, pose: [odometry(at, *pose, child="odom")])],
        sensor_at(),
        "they are taken to be those of 'base_link'",
        unsaid="no poses",
    ),
    "odometry of another name of the base": Case(
        [LASER, *drive(lambda at, pose: [odometry(at, *pose, child="robot1/base_link")])],
        sensor_at(),
        "they are taken to be those of 'base_link'",
        unsaid="no poses",
    ),
    "poses in the robot's own frame": Case(
        [LASER, *drive(lambda at, pose: [pose_stamped(at, *pose, frame="base_link")])], sensor_at()
    ),
    "scans without stamps": Case(stamped(BASE, "/scan", lambda at: 0), sensor_at()),
    "transforms without stamps": Case(stamped(BASE, "/tf", lambda at: 0), sensor_at()),
    "scans with one stamp": Case(
        stamped(BASE, "/scan", lambda at: T0), sensor_at(), "All 20 scans on /scan have the same stamp"
    ),
    "scans with one stamp of long ago": Case(
        stamped(BASE, "/scan", lambda at: 7 * SECOND), sensor_at(), "All 20 scans on /scan have the same stamp"
    ),
    "transforms with one stamp": Case(
        stamped(BASE, "/tf", lambda at: T0), sensor_at(), "All 21 transforms between two frames on /tf have the same"
    ),
    "transforms with one stamp of long ago, and scans by a clock of their own": Case(
        stamped(stamped(BASE, "/tf", lambda at: 7 * SECOND), "/scan", lambda at: at - T0 + 12 * SECOND),
        sensor_at(),
        "All 21 transforms .* each scan gets the pose of when it was",
    ),
    "transforms whose stamps are whole seconds": Case(
        stamped(BASE, "/tf", lambda at: at // SECOND * SECOND), sensor_at(), "no more than 5 different stamps"
    ),
    "transforms that state microseconds as nanoseconds": Case(
        stamped(BASE, "/tf", lambda at: at // SECOND * SECOND + at % SECOND // 1000),
        sensor_at(),
        "21 transforms between two frames on /tf have stamps in 5 groups, in each of which they hardly go on",
    ),
    "odometry with one stamp": Case(
        stamped([LASER, *drive(wheels)], "/odom", lambda at: T0), sensor_at(), "All 21 poses on /odom have the same"
    ),
    "transforms that are sent again and again": Case(
        [replace(one, stamp_ns=one.stamp_ns + k) for one in BASE for k in range(3 if one.topic == "/tf" else 1)],
        sensor_at(),
        "^$",
    ),
    "scans by the time since the lidar was switched on": Case(
        stamped(BASE, "/scan", lambda at: at - T0 + 12 * SECOND), sensor_at(), "each scan gets the pose of when it was"
    ),
    "scans by a clock that is 1.4 s ahead": Case(
        stamped(BASE, "/scan", lambda at: at + 14 * SECOND // 10), sensor_at(), "is 1.4 s behind that of the scans"
    ),
    "scans by a clock that is 3.2 s behind": Case(
        stamped(BASE, "/scan", lambda at: at - 32 * SECOND // 10), sensor_at(), "is 3.2 s ahead of that of the scans"
    ),
    "transforms that a slow program states late": Case(
        [LASER, *late(drive(by_tf()), "/tf", 15 * SECOND // 10)], sensor_at(), unsaid="The clock of"
    ),
    "scans that the recorder got late": Case(
        [LASER, *late(drive(by_tf()), "/scan", 15 * SECOND // 10)], sensor_at(), unsaid="The clock of"
    ),
    "messages in no order": Case(
        [BASE[k] for k in np.random.default_rng(2).permutation(len(BASE))], sensor_at(), "were sorted", unsaid="begins"
    ),
    "transforms by a simulated clock": Case(
        stamped(BASE, "/tf", lambda at: at - T0 + SECOND), sensor_at(), "each scan gets the pose of when it was"
    ),
    "a recording of a recording": Case(
        [replace(one, stamp_ns=one.stamp_ns + 86_400 * SECOND) for one in BASE], sensor_at()
    ),
    "a slash before the scan's frame": Case(stamped(BASE, "/scan", lambda at: at, "/laser"), sensor_at()),
    "a mount that is stated for an hour later": Case(
        [static("base_link", "laser", MOUNT, T0 + 3600 * SECOND), *drive(by_tf())], sensor_at()
    ),
    "a mount among the moving transforms": Case(
        drive(lambda at, pose: [*by_tf()(at, pose), transform(at, "base_link", "laser", *MOUNT)]), sensor_at()
    ),
    "a mount that is stated at the end": Case([*drive(by_tf()), replace(LASER, stamp_ns=T0 + N * STEP)], sensor_at()),
    "a fixed transform of the robot beside its motion": Case(
        [LASER, static("odom", "base_link", AHEAD), *drive(by_tf())], sensor_at()
    ),
    "a fixed transform of the robot beside odometry": Case(
        [LASER, static("odom", "base_link", AHEAD), *drive(wheels)], sensor_at(), "By tf/odom the robot never moves"
    ),
    "a fixed map beside odometry": Case([LASER, static("map", "odom", AHEAD), *drive(wheels)], sensor_at()),
    "a second program that states the same frames, without motion": Case(  # slam_toolbox#784
        beside(lambda pose: AHEAD), sensor_at(), TWO_PROGRAMS
    ),
    "a second program that states no motion ten times as often": Case(
        beside(lambda pose: AHEAD, 10), sensor_at(), TWO_PROGRAMS
    ),
    "a second program that states the motion in a frame of its own": Case(  # rtabmap_ros#645
        beside(lambda pose: of((2.0, -1.0, 0.7), pose)), sensor_at(), TWO_PROGRAMS
    ),
    "all messages twice": Case([one for one in BASE for _ in (0, 1)], [place for place in sensor_at() for _ in (0, 1)]),
    "odometry once a second": Case([LASER, *drive(only(wheels, 5))], sensor_at()),
    "a loop of transforms": Case([LASER, *drive(loop)], sensor_at(), "form a loop"),
    "invalid transforms and scans without stamps": Case(
        stamped(with_bad(BASE, BAD), "/scan", lambda at: 0), sensor_at(), "as in tf2"
    ),
    "an inverted transform and a clock of its own": Case(
        stamped(
            [LASER, *drive(lambda at, pose: [transform(at, "base_link", "odom_lidar", *back(pose))])],
            "/scan",
            lambda at: at - T0 + 5 * SECOND,
        ),
        sensor_at(),
        "each scan gets the pose of when it was",
    ),
    "robots with the same frames, one without stamps": Case(
        stamped(robots("/a", "/b"), "/b/scan", lambda at: 0), sensor_at(way=1), topic="/b/scan"
    ),
    "robots with the same frames, reset": Case(
        by_steps(mixed(resets("/a", 0), resets("/b", 1))),
        [*sensor_at(way=1), *sensor_at(way=0)],
        "begins again at scan 21",
        topic="/b/scan",
    ),
    "a robot beside another one's scans alone": Case(
        together(BASE, [replace(one, topic="/b/scan") for one in drive(lambda at, pose: [])]),
        sensor_at(),
        topic="/scan",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_every_scan_has_its_true_place(tmp_path: Path, name: str) -> None:
    case = CASES[name]
    log = open_log(recorded.written(tmp_path, case.messages, "mcap"), topic=case.topic)
    assert_places(log, case.places, tolerance=0.03)
    said = " ".join(log.notes)
    assert re.search(case.note, said), said
    assert not re.search(case.unsaid, said), said


# -- containers -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_compressed_bags_with_a_bad_transform(tmp_path: Path, compression: str) -> None:
    path = recorded.write_bag(tmp_path / "a.bag", with_bad(BASE, BAD), compression)
    assert_places(open_log(path), sensor_at())


@pytest.mark.parametrize("mode", ["file", "message"])
def test_compressed_databases_of_a_namespace(tmp_path: Path, mode: str) -> None:
    suffix = "db3.zstd" if mode == "file" else "db3"
    path = recorded.write_rosbag2(tmp_path / "a", robots("/a", "/b"), StoragePlugin.SQLITE3, suffix, mode)
    assert_places(open_log(path, topic="/b/scan"), sensor_at(way=1))


def parts(folder: Path, *said: list[Said]) -> Path:
    """A recording in several files without metadata."""
    folder.mkdir()
    for number, messages in enumerate(said):
        one = recorded.write_rosbag2(folder.with_name(f"part{number}"), messages, StoragePlugin.SQLITE3, "db3")
        one.rename(folder / f"run_{number}.db3")
    return folder


def test_parts_that_rosbag_split_by_time_are_one_recording(tmp_path: Path) -> None:
    """``rosbag record --split``: each part has its own time in its name; the last was not closed."""
    names = ("run_2024-01-31-23-58-05_0.bag", "run_2024-02-01-00-03-05_1.bag", "run_2024-02-01-00-08-05_2.bag.active")
    for name, part in zip(names, (BASE[:15], BASE[15:30], BASE[30:]), strict=True):
        recorded.write_bag(tmp_path / name, part)
    assert_places(open_log(tmp_path), sensor_at())
    (tmp_path / "run_2024-02-01-00-13-05_0.bag").write_bytes((tmp_path / names[0]).read_bytes())
    with pytest.raises(ReadError, match="nor names of one kind, numbered from 0"):
        open_log(tmp_path)


def test_a_part_that_states_another_mount(tmp_path: Path) -> None:
    """The lidar is mounted elsewhere before the second file begins: each scan has the mount that held when it came."""
    said = drive(by_tf())
    half = len(said) // 2
    moved = static("base_link", "laser", (-0.2, 0.1, 1.0), said[half].stamp_ns)
    log = open_log(parts(tmp_path / "run", [LASER, *said[:half]], [moved, *said[half:]]))
    before = sum(one.topic == "/scan" for one in said[:half])
    assert_places(log, [of(true(i + 0.1), MOUNT if i < before else (-0.2, 0.1, 1.0)) for i in range(N)])


def test_a_second_part_alone_says_that_the_mount_is_missing(tmp_path: Path) -> None:
    """Latched transforms are in the first file only."""
    said = drive(by_tf())
    path = recorded.written(tmp_path, said[len(said) // 2 :], "db3")
    log = open_log(path)
    assert any("tf does not say where the frame 'laser'" in note for note in log.notes)
    assert_places(log, [true(i + 0.1) for i in range(N - log.n_scans, N)])


# -- what messages state ----------------------------------------------------------------------------------------------


def test_more_than_64_limits_lose_nothing_but_what_is_said(tmp_path: Path) -> None:
    said = [LASER]
    for i in range(80):
        one = scan(T0 + i * STEP, [1.0, 5.5, np.inf], limits=(0.1, 5.0 + 0.01 * i))
        one.fields["time_increment"] = (1e-4, 2e-4)[i % 2]
        said += [transform(T0 + i * STEP, "odom", "base_link", *true(0.1 * i)), one]
    log = open_log(recorded.written(tmp_path, said, "mcap"))
    assert log.n_scans == 80
    np.testing.assert_array_equal(np.isfinite(log.ranges[:, 0]), np.ones(80, dtype=bool))
    np.testing.assert_array_equal(np.isfinite(log.ranges[:, 1]), [5.0 + 0.01 * i >= 5.5 for i in range(80)])
    (note,) = (note for note in log.notes if "range_max 5.00 to 5.79 m" in note)
    assert "Of 129 readings without a return in messages with a smaller range_max than 5.79 m" in note
    assert any("the median of all, 0.00015 s, is used" in note for note in log.notes)


@pytest.mark.parametrize("step_back", [2 * SECOND, 30 * SECOND])
def test_transforms_whose_clock_is_set_back_alone_are_all_kept(tmp_path: Path, step_back: int) -> None:
    """The publisher's clock is set back near the end; scans before that have the poses of their time all the same."""
    late = T0 + (N - 3) * STEP
    said = stamped(BASE, "/tf", lambda at: at if at < late else at - step_back)
    said += [odometry(one.stamp_ns, 9.0, 9.0, 0.0, "/other") for one in BASE if one.topic == "/tf"]
    log = open_log(recorded.written(tmp_path, sorted(said, key=lambda one: one.stamp_ns), "mcap"))
    first = (N - 3) - 2 * SECOND // STEP - 1
    found = log.trajectory("tf/odom").poses[:first]
    np.testing.assert_allclose(found, [true(i + 0.1) for i in range(first)], atol=5e-3)
