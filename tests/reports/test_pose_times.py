"""Recordings whose poses begin late or end early: a scan gets no pose of another time.

tf2 refuses a look-up before the first and after the last transform ("extrapolation into the past", tf2/src/cache.cpp),
so that nodes drop such scans. Where another source has the robot's motion there, it carries the trajectory on
(REP 105).
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.io.logs import open_log, open_robot_log
from mapper.sensors.joint_log import JointLog
from mapper.sensors.robot_log import RobotLog
from server.library.packs.log import read_pack, write_pack
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, odometry, transform, written
from tests.reports.test_transforms import (
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
    replaced_mount,
    replaced_places,
    seen,
    sensor_at,
    static,
    true,
)

EARLY, LATE = 6, 16  #: the steps of the first and of the last pose

SOURCES: dict[str, Callable[[int, Pose], list[Said]]] = {
    "tf": lambda at, pose: [transform(at, "odom", "base_link", *pose)],
    "tf of the inverse": lambda at, pose: [transform(at, "odom", "base_link", *pose), transform(at, "map", "odom")],
    "odometry": lambda at, pose: [odometry(at, *pose)],
    "odometry of a camera": lambda at, pose: [odometry(at, *of(pose, (0.4, 0.0, 3.1)), child="camera_pose_frame")],
    "poses": lambda at, pose: [recorded.pose_stamped(at, *pose)],
    "estimates": lambda at, pose: [recorded.estimate(at, *pose)],
    "a motion capture": lambda at, pose: [recorded.transform_stamped(at, *pose, child="base_link")],
}
CAMERA = static("base_link", "camera_pose_frame", (0.4, 0.0, 3.1))


def step(at: int) -> int:
    return (at - T0) // STEP


def drifted(i: float) -> Pose:
    """Where the wheels have the robot after i steps: 4 % too far, and turned by 0.3° more with each."""
    x, y, yaw = true(i)
    return (1.04 * x, 1.04 * y, yaw + 0.005 * i)


def within(source: Callable[[int, Pose], list[Said]], first: int, last: int) -> Callable[[int, Pose], list[Said]]:
    """The poses of a source at some of the steps."""
    return lambda at, pose: source(at, pose) if first <= step(at) <= last else []


@pytest.mark.parametrize("name", SOURCES)
def test_scans_without_a_pose_are_left_out_and_counted(tmp_path: Path, name: str) -> None:
    said = [LASER, CAMERA, *drive(within(SOURCES[name], EARLY, LATE))]
    log = open_log(written(tmp_path, said, "mcap"))
    # Each scan is 20 ms after its step; the robot drives 15 cm in a step, so that the one at the end is near enough.
    assert_places(log, sensor_at()[EARLY : LATE + 1], tolerance=0.03)
    (note,) = (note for note in log.notes if "left out" in note and "extrapolated" in note)
    assert f"{N - (LATE + 1 - EARLY)} scans are left out: {EARLY} before the first and {N - LATE - 1} after" in note


def test_another_source_carries_the_trajectory_on(tmp_path: Path) -> None:
    """A localiser that is started later: before its first transform the wheels say how the robot moved (REP 105)."""

    def localized(at: int, pose: Pose) -> list[Said]:
        place = of((1.0, 2.0, 0.3), pose)
        return [odometry(at, *pose), *([recorded.estimate(at, *place)] if EARLY <= step(at) <= LATE else [])]

    log = open_log(written(tmp_path, [LASER, *drive(localized)], "db3"))
    for name in ("odom", "amcl_pose"):
        assert_places(log, sensor_at(), name, tolerance=0.03)
    wanted = [of((1.0, 2.0, 0.3), true(i + 0.1)) for i in range(N)]
    np.testing.assert_allclose(log.trajectory("amcl_pose").poses[:, :2], np.array(wanted)[:, :2], atol=0.03)
    assert any("last pose of amcl_pose, which moves as odom there" in note for note in log.notes)
    assert not any("left out" in note for note in log.notes)


def test_a_robot_that_stands_still_at_the_ends_has_its_pose_there(tmp_path: Path) -> None:
    """Scans 100 ms before the first transform of a robot that does not move yet are at that place."""
    said = [LASER, *(recorded.scan(T0 + i * STEP - STEP // 2, [1.0, 2.0, 3.0]) for i in range(5))]
    poses = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.6, 0.0, 0.0), (0.6, 0.0, 0.0)]
    said += [transform(T0 + i * STEP, "odom", "base_link", *pose) for i, pose in enumerate(poses)]
    log = open_log(written(tmp_path, sorted(said, key=lambda one: one.stamp_ns), "mcap"))
    np.testing.assert_allclose(log.trajectory().poses[:, 0], [0.0, 0.0, 0.15, 0.45, 0.6], atol=1e-6)
    assert not any("left out" in note for note in log.notes)


def test_a_sensor_is_offered_with_each_topic_of_transforms(tmp_path: Path) -> None:
    """A simulator's true transforms beside the robot's own: the sensor can be chosen with either (navigation2#5449)."""

    def both(at: int, pose: Pose) -> list[Said]:
        slipped = (1.2 * pose[0], pose[1], pose[2])
        return [
            transform(at, "odom", "base_link", *slipped),
            transform(at, "world", "base_link", *pose, topic="/tf_gt"),
        ]

    said = [LASER, static("base_link", "laser", (0.5, 0.0, 0.0), topic="/tf_gt_static"), *drive(both)]
    path = written(tmp_path, said, "bag")
    robot = open_robot_log(path)
    assert list(robot.sensors) == ["/scan", "/scan#/tf_gt"]
    assert robot.sensors["/scan"].mount == pytest.approx(MOUNT)
    assert [topic.name for topic in robot.first.topics if topic.beams] == ["/scan", "/scan#/tf_gt"]
    assert any(
        "open a sensor such as /scan#/tf_gt under Contents in the list of logs, or name their topic with --tf" in note
        for note in robot.first.notes
    )
    assert not any("Only /scan is mapped" in note for note in robot.first.notes)
    true_one = open_log(path, topic="/scan#/tf_gt")
    assert true_one.default_trajectory == "tf/world"
    assert_places(true_one, sensor_at((0.5, 0.0, 0.0)))


def test_a_cloud_is_offered_with_each_topic_of_transforms_and_cut_by_the_one_chosen(tmp_path: Path) -> None:
    """The heights that count are above the base where the chosen transforms have it."""
    low = static("base_link", "velodyne", (0.0, 0.0, 0.0))
    high = recorded.transform(T0 - SECOND, "base_link", "velodyne", 0.0, 0.0, z=5.0, topic="/tf_gt_static")
    said = [low, high]
    for i in range(4):
        said += [transform(T0 + i * STEP, "odom", "base_link", 0.1 * i, 0.0)]
        said += [transform(T0 + i * STEP, "world", "base_link", 0.2 * i, 0.0, topic="/tf_gt")]
        said += [recorded.cloud(T0 + i * STEP, [[3.0, 0.0, 0.5], [2.0, 0.0, -4.5]])]
    path = written(tmp_path, said, "mcap")
    robot = open_robot_log(path)
    assert list(robot.sensors) == ["/points"]
    assert [topic.name for topic in robot.first.topics if topic.beams] == ["/points", "/points#/tf_gt"]
    for name, length, reading in (("/points", 0.3, 3.0), ("/points#/tf_gt", 0.6, 2.0)):
        log = open_log(path, topic=name)
        assert log.trajectory().poses[-1, 0] == pytest.approx(length)
        assert log.ranges[0][np.isfinite(log.ranges[0])] == pytest.approx([reading])


def test_scans_of_a_lidar_that_is_switched_stay_in_order_where_its_clock_steps_back(tmp_path: Path) -> None:
    """Groups of scans with other beams follow one another as they were recorded, also once they are stored."""
    for resets in (True, False):
        said = [LASER]
        for number in range(2):
            for i in range(N):
                at = T0 + i * STEP if resets else T0 + (number * N + i) * STEP
                said.append(transform(at, "odom", "base_link", *true(i, number)))
                stamp = at if resets or number == 0 else at - 3 * STEP // 2  # else the lidar's clock alone is set back
                angles, readings = ((-1.5, 0.1), [2.0] * 3) if i // 3 % 2 == 0 else ((-1.5, 0.05), [2.0] * 6)
                one = recorded.scan(at, readings, angles=angles)
                said.append(replace(one, fields=one.fields | {"header": recorded.header(stamp, "laser")}))
        said = [replace(one, stamp_ns=T0 + k * STEP // 2) for k, one in enumerate(said)]  # recorded on and on
        log = open_log(written(tmp_path, said, "mcap"))
        assert isinstance(log, JointLog)
        write_pack(RobotLog.of_one(log), tmp_path / "pack")
        wanted = [one.fields["header"]["stamp"] for one in said if one.topic == "/scan"]
        stamps = [stamp["sec"] * recorded.SECOND + stamp["nanosec"] for stamp in wanted]
        for kept in (log, log.take(np.arange(2 * N)), read_pack(tmp_path / "pack")):
            assert kept.stamps_ns.tolist() == stamps
        if resets:
            assert_places(log, [of(true(i, way), MOUNT) for way in (0, 1) for i in range(N)])


@pytest.mark.parametrize("ahead", [0, SECOND // 5, SECOND], ids=["on time", "slam_toolbox", "AMCL"])
@pytest.mark.parametrize("every", [1, 5, 25], ids=["again and again", "with each scan", "once a second"])
def test_a_localisers_corrections_count_from_when_they_were_made(tmp_path: Path, ahead: int, every: int) -> None:
    """Wheels that drift, a correction each second, stated again meanwhile and stamped ahead.

    AMCL's transform_tolerance and slam_toolbox's transform_timeout (navigation2/nav2_amcl/src/amcl_node.cpp,
    slam_toolbox/src/slam_toolbox_common.cpp): tf2 looks up a correction that is older by as much.
    """
    said = [LASER]
    for at in range(5 * N + 1):  # 25 a second
        said.append(transform(T0 + at * STEP // 5, "odom", "base_link", *drifted(at / 5)))
        if at % every == 0:
            made = at // 25 * 5
            correction = of(true(made), back(drifted(made)))
            one = transform(T0 + at * STEP // 5 + ahead, "map", "odom", *correction)
            said.append(replace(one, stamp_ns=one.stamp_ns - ahead))
        if at % 5 == 0 and at < 5 * N:
            said.append(seen(T0 + at * STEP // 5 + SECOND // 50))
    log = open_log(written(tmp_path, said, "mcap"))
    assert_places(log, sensor_at(), "tf/map", tolerance=0.03)
    assert any("ahead of the odometry recorded with it" in note for note in log.notes) == (ahead > 0)


def legs(share: float = 1.0) -> list[Pose]:
    """A drive of 4 s, 25 poses a second: 1 m ahead, a quarter turn on the spot, a rest, 1 m ahead.

    The wheels measure ``share`` of each motion.
    """
    moves = [(0.04, 0.0, 0.0)] * 25 + [(0.0, 0.0, math.pi / 50)] * 25 + [(0.0, 0.0, 0.0)] * 25 + [(0.04, 0.0, 0.0)] * 25
    poses: list[Pose] = [(0.0, 0.0, 0.0)]
    for x, y, yaw in moves:
        poses.append(of(poses[-1], (share * x, share * y, share * yaw)))
    return poses


HOW: dict[str, Callable[[int, Pose, Pose], Said]] = {
    "corrections": lambda at, true, measured: transform(at, "map", "odom", *of(true, back(measured))),
    "transforms": lambda at, true, _: transform(at, "map", "base_link", *true),
    "estimates": lambda at, true, _: recorded.estimate(at, *true),
}


def driven(how: str, share: float, made: list[int], wheels: str = "tf") -> list[Said]:
    """Wheels that measure ``share`` of each motion of :func:`legs`, and what a localiser ``made`` of it at steps."""
    said = [LASER]
    for k, (pose, measured) in enumerate(zip(legs(), legs(share), strict=True)):
        at = T0 + k * SECOND // 25
        said.append(by_tf()(at, measured)[0] if wheels == "tf" else odometry(at, *measured))
        late = SECOND // 30  # by which a localiser's poses are recorded after the wheels'
        said += [replace(HOW[how](at, pose, measured), stamp_ns=at + late)] if k in made else []
        said += [seen(at)] if k % 5 == 0 else []
    return said


@pytest.mark.parametrize(("how", "wheels"), [(how, "tf") for how in HOW] + [("estimates", "odometry")])
@pytest.mark.parametrize("made", [[0, 12, 37, 87, 100], [0, 40, 100]], ids=["in each leg", "three"])
def test_between_two_corrections_the_robot_goes_the_odometrys_way(
    tmp_path: Path, how: str, wheels: str, made: list[int]
) -> None:
    """By time, it would drive on the spot where it turned, and turn where it stood."""
    log = open_log(written(tmp_path, driven(how, 1.1, made, wheels), "mcap"))
    name = "amcl_pose" if how == "estimates" else "tf/map"
    assert_places(log, [of(pose, MOUNT) for pose in legs()[::5]], name, tolerance=0.02)


@pytest.mark.parametrize("how", ["transforms", "estimates"])
def test_what_wheels_did_not_measure_is_interpolated_in_time(tmp_path: Path, how: str) -> None:
    """Of a drive of 4 m the wheels measured the last metre alone: it says nothing of when the others were driven."""
    said = [LASER]
    for k in range(101):
        at, pose = T0 + k * SECOND // 25, (0.04 * k, 0.0, 0.0)
        measured = (max(0.0, 0.04 * k - 3.0), 0.0, 0.0)
        said += [*by_tf()(at, measured), *([HOW[how](at, pose, measured)] if k % 100 == 0 else []), seen(at)]
    log = open_log(written(tmp_path, said, "mcap"))
    name = "amcl_pose" if how == "estimates" else "tf/map"
    assert_places(log, [of((0.04 * k, 0.0, 0.0), MOUNT) for k in range(101)], name)


def test_corrections_hold_where_odometry_is_set_back_by_them(tmp_path: Path) -> None:
    """Odometry that begins again from each correction: between two of them no transform is in between."""
    said = [LASER]
    for at in range(5 * N + 1):
        correction = of((0.4, -0.3, 0.1), (0.02 * (at // 25), 0.1 * (at // 25), 0.08 * (at // 25)))
        if at % 25 == 0:
            said.append(transform(T0 + at * STEP // 5, "map", "odom", *correction))
        said.append(transform(T0 + at * STEP // 5, "odom", "base_link", *of(back(correction), true(at / 5))))
        if at % 5 == 0 and at < 5 * N:
            said.append(seen(T0 + at * STEP // 5 + SECOND // 50))
    assert_places(open_log(written(tmp_path, said, "db3")), sensor_at(), "tf/map", tolerance=0.01)


def test_no_scan_is_between_the_two_sides_of_a_closed_loop(tmp_path: Path) -> None:
    """A correction that steps by 2 m in a fifth of a second is no drift: scans have it as it was, or as it is then."""
    said = [LASER]
    for at in range(5 * N + 1):
        said.append(transform(T0 + at * STEP // 5, "odom", "base_link", *true(at / 5)))
        if at % 5 == 0:
            said.append(transform(T0 + at * STEP // 5, "map", "odom", 0.0 if at < 50 else 2.0, 0.0, 0.0))
        if at % 5 == 3:
            said.append(seen(T0 + at * STEP // 5))
    log = open_log(written(tmp_path, said, "bag"))
    wanted = [of((0.0 if i < 10 else 2.0, 0.0, 0.0), true(i + 0.6)) for i in range(N)]
    np.testing.assert_allclose(log.trajectory("tf/map").poses[:, :2], np.array(wanted)[:, :2], atol=5e-3)


@pytest.mark.parametrize("how", HOW)
def test_a_pose_that_somebody_sets_is_named(tmp_path: Path, how: str) -> None:
    """The localiser believed a robot at another place until then, which stood or drove."""
    said = [LASER]
    for k, pose in enumerate(legs()):
        at = T0 + k * SECOND // 25
        seen_by_it = pose if k >= 40 else of((3.0, 1.0, 0.5), pose)
        said += [by_tf()(at, pose)[0], *([HOW[how](at, seen_by_it, pose)] if k % 5 == 0 else [])]
        said += [seen(at)] if k % 5 == 0 else []
    log = open_log(written(tmp_path, said, "mcap"))
    name = "amcl_pose" if how == "estimates" else "tf/map"
    (note,) = (note for note in log.notes if "leaps" in note)
    assert re.match(rf"By {name} the robot leaps by up to \d\.\d\d m and 29° before scan 9, where", note)
    poses = log.trajectory(name).poses
    np.testing.assert_allclose(poses[8:, :2], np.array(legs()[40::5])[:, :2], atol=1e-3)
    np.testing.assert_allclose(poses[:8, 2] - 0.5, np.array(legs()[:40:5])[:, 2], atol=1e-3)


def restarted(measured: Callable[[int, Pose], Pose], wheels: str) -> list[Said]:
    """The drive of :func:`legs` with what the wheels ``measured`` at each step."""
    said = [LASER]
    for k, pose in enumerate(legs()):
        at, own = T0 + k * SECOND // 25, measured(k, pose)
        said.append(odometry(at, *own) if wheels == "odometry" else by_tf()(at, own)[0])
        said += [seen(at + SECOND // 100)] if k % 5 == 0 and k < 100 else []
    return said


@pytest.mark.parametrize("wheels", ["tf", "odometry"])
@pytest.mark.parametrize("steps", [(60,), (60, 90)], ids=["once", "twice"])
def test_odometry_that_begins_again_is_counted_on(tmp_path: Path, steps: tuple[int, ...], wheels: str) -> None:
    """The driver of the base is restarted: it states the way from there."""

    def measured(k: int, pose: Pose) -> Pose:
        begun = max((one for one in steps if one <= k), default=0)
        return of(back(legs()[begun]), pose)

    log = open_log(written(tmp_path, restarted(measured, wheels), "mcap"))
    truth = [of(legs()[k], MOUNT) for k in range(0, 100, 5)]
    assert_places(log, truth, tolerance=0.06)  # what was driven in between is not measured
    (note,) = log.notes
    first = ", ".join(str(one // 5 + 1) for one in steps)
    assert re.search(rf"odom begins again at 0 before scan {first}, as where its driver is restarted", note)


def test_a_simulated_robot_that_is_set_back_is_where_its_odometry_says(tmp_path: Path) -> None:
    """Gazebo's /reset_world carries the robot to where it began: what it sees changes as well."""
    said = restarted(lambda k, pose: legs()[k - 60] if k >= 60 else pose, "odometry")
    scans = [one for one in said if one.topic == "/scan"]
    for one in scans[12:]:
        one.fields["ranges"] = np.array([4.0, 5.0, 6.0], dtype=np.float32)
    log = open_log(written(tmp_path, said, "mcap"))
    np.testing.assert_allclose(log.trajectory().poses[13:, :2], np.array(legs()[5:40:5])[:, :2], atol=0.03)
    assert log.notes == ()


@pytest.mark.parametrize("lost", [1, 10])
def test_a_tracker_that_states_0_for_a_while_does_not_begin_again(tmp_path: Path, lost: int) -> None:
    said = restarted(lambda k, pose: (0.0, 0.0, 0.0) if 60 <= k < 60 + lost else pose, "odometry")
    log = open_log(written(tmp_path, said, "mcap"))
    np.testing.assert_allclose(log.trajectory().poses[15:, :2], np.array(legs()[75:100:5])[:, :2], atol=0.03)
    assert log.notes == ()


@pytest.mark.parametrize(("first", "slower"), [(1, 1), (3, 1), (3, 3)])
def test_stamps_of_0_before_a_simulations_clock_has_come_have_its_time(tmp_path: Path, first: int, slower: int) -> None:
    """With use_sim_time a node's time is 0 until /clock comes; a simulation also begins at 0 itself.

    The recorder's clock is another one, so the time of recording is no stand-in by itself, and a simulation that is
    ``slower`` than it passes less time.
    """
    said = copy.deepcopy([LASER, *drive(lambda at, pose: [transform(at, "odom", "base_link", *pose)])])
    expected = open_log(written(tmp_path, said, "mcap"))
    for one in said:
        for header in [part["header"] for part in one.fields.get("transforms", [one.fields])]:
            ns = one.stamp_ns - T0 if one.stamp_ns >= T0 + first * STEP else 0
            header["stamp"] = {"sec": ns // recorded.SECOND, "nanosec": ns % recorded.SECOND}
        one.stamp_ns = T0 + slower * (one.stamp_ns - T0)
    log = open_log(written(tmp_path, said, "db3"))
    assert not any("clock" in note for note in log.notes)
    np.testing.assert_allclose(log.trajectory().poses, expected.trajectory().poses, atol=1e-6)
    assert (log.stamps_ns + T0 == expected.stamps_ns).all()


def _halves(said: list[Said]) -> list[Said]:
    return [*said[len(said) // 2 :], *said[: len(said) // 2]]


def _a_few_apart(said: list[Said]) -> list[Said]:
    said = said.copy()
    said.insert(5, said.pop(20))
    said.insert(30, said.pop(12))
    return said


ORDERS: dict[str, Callable[[list[Said]], list[Said]]] = {
    "the second half first": _halves,
    "the last first": lambda said: said[::-1],
    "by topic": lambda said: sorted(said, key=lambda one: one.topic),
    "a few in other places": _a_few_apart,
}


@pytest.mark.parametrize("form", ["bag", "db3", "mcap"])
@pytest.mark.parametrize("name", ORDERS)
def test_messages_count_by_when_they_were_recorded_not_by_where_they_are_stored(
    tmp_path: Path, name: str, form: str
) -> None:
    """As rosbag2 reads a db3 (``ORDER BY messages.timestamp``), MCAP's readers and rosbag do."""
    said = [LASER, *drive(SOURCES["tf"])]
    log = open_log(written(tmp_path, ORDERS[name](said), form))
    assert_places(log, sensor_at(), tolerance=0.03)
    assert (np.diff(log.stamps_ns) > 0).all()
    assert not any("begins again" in note or "backwards" in note for note in log.notes)


@pytest.mark.parametrize("name", ORDERS)
def test_replaced_static_transforms_count_by_when_they_were_recorded(tmp_path: Path, name: str) -> None:
    """As tf2 would have known them; the new one is stated twice, and the old one again in its first half."""
    said = replaced_mount()
    old, new = [one for one in said if one.topic == "/tf_static"][1:]
    said.insert(4, replace(old, stamp_ns=said[3].stamp_ns))
    said.append(replace(new, stamp_ns=said[-1].stamp_ns))
    log = open_log(written(tmp_path, ORDERS[name](said), "mcap"))
    assert_places(log, replaced_places(), tolerance=0.03)
