"""Recordings whose frames and poses people in the field have stumbled over: each scan's place must be the true one.

A case is a kind of recording that public reports describe, made here, with the rule of tf2 or of the message that says
what is right (ros2/geometry2: BufferCore, TimeCache, StaticCache). The robot drives a curve that is known in closed
form; every scan's place in the fixed frame is compared with it, up to where the frame begins.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mapper.core.errors import ReadError
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.grid import OccupancyGrid
from mapper.io.logs import open_log, open_robot_log
from mapper.io.maps import load_map, save_map
from mapper.io.trajectories import read_tum, with_trajectory
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, odometry, scan, transform, written

T0 = 1_700_000_000 * SECOND
STEP = SECOND // 5
N = 20
MOUNT = (0.3, -0.1, 0.5)
AHEAD = (0.0, 0.0, 0.0)
Pose = tuple[float, float, float]


def true(i: float, way: int = 0) -> Pose:
    """Where the robot is after i steps: on a circle, or the other way round on a smaller one."""
    a = 0.05 * i
    if way == 0:
        return (3.0 * math.sin(a), 3.0 - 3.0 * math.cos(a), a)
    return (2.0 - 2.0 * math.sin(a), -1.0 - 2.0 * math.cos(a) + 2.0, math.pi + a)


def of(*poses: Pose) -> Pose:
    """The product of transforms."""
    found = np.array(poses[0])
    for pose in poses[1:]:
        found = compose(found, np.array(pose))
    return (float(found[0]), float(found[1]), float(found[2]))


def back(pose: Pose) -> Pose:
    x, y, yaw = inverse(np.array(pose))
    return (float(x), float(y), float(yaw))


def static(parent: str, child: str, pose: Pose, at: int = T0 - SECOND, topic: str = "/tf_static") -> Said:
    return transform(at, parent, child, *pose, topic=topic)


def seen(at: int, topic: str = "/scan", frame: str = "laser") -> Said:
    return scan(at, [1.0, 2.0, 3.0], topic, frame)


def together(*parts: list[Said]) -> list[Said]:
    """Recordings at the same time as one."""
    return sorted((said for part in parts for said in part), key=lambda said: said.stamp_ns)


def drive(
    poses: Callable[[int, Pose], list[Said]], topic: str = "/scan", frame: str = "laser", way: int = 0
) -> list[Said]:
    """What ``poses`` states at each step, and a scan 20 ms after it, the last before the last step."""
    said = []
    for i in range(N + 1):
        said += poses(T0 + i * STEP, true(i, way))
        if i < N:
            said.append(seen(T0 + i * STEP + SECOND // 50, topic, frame))
    return said


def by_tf(parent: str = "odom", child: str = "base_link", topic: str = "/tf") -> Callable[[int, Pose], list[Said]]:
    return lambda at, pose: [transform(at, parent, child, *pose, topic=topic)]


def sensor_at(mount: Pose = MOUNT, way: int = 0, n: int = N) -> list[Pose]:
    """Where the sensor truly is at the scans of :func:`drive`."""
    return [of(true(i + 0.1, way), mount) for i in range(n)]


def assert_places(log: ScanLog, expected: list[Pose], trajectory: str | None = None, tolerance: float = 5e-3) -> None:
    """Compare the sensor's poses with the expected ones, both in the frame of the first."""
    found = log.sensor_poses(trajectory)
    assert len(found) == len(expected)
    wanted = np.array(expected)
    apart = compose(inverse(found[0]), found) - compose(inverse(wanted[0]), wanted)
    apart[:, 2] = wrap_angle(apart[:, 2])
    assert np.abs(apart).max() < tolerance


def with_bad(said: list[Said], bad: list[dict[str, object]]) -> list[Said]:
    """The same messages of transforms, each with other transforms before its own."""
    return [
        replace(one, fields={"transforms": [*bad, *one.fields["transforms"]]}) if "transforms" in one.fields else one
        for one in said
    ]


def stated(parent: str, child: str, quaternion: tuple[float, ...], x: float = 0.0) -> dict[str, object]:
    rotation = dict(zip("xyzw", quaternion, strict=True))
    place = {"translation": {"x": x, "y": 0.0, "z": 0.0}, "rotation": rotation}
    return {"header": recorded.header(T0, parent), "child_frame_id": child, "transform": place}


NAN = float("nan")
BAD = [
    stated("base_link", "zero", (0.0, 0.0, 0.0, 0.0)),
    stated("base_link", "long", (0.0, 0.0, 0.0, 2.0)),
    stated("base_link", "nan", (NAN, NAN, NAN, NAN)),
    stated("base_link", "nowhere", (0.0, 0.0, 0.0, 1.0), NAN),
    stated("base_link", "base_link", (0.0, 0.0, 0.0, 1.0)),
    stated("", "orphan", (0.0, 0.0, 0.0, 1.0)),
    stated("base_link", "", (0.0, 0.0, 0.0, 1.0)),
]
LASER = static("base_link", "laser", MOUNT)
CAMERA = (0.4, 0.05, math.pi)
GEO = (691_000.3, 5_334_000.7)


def robots(*names: str) -> list[Said]:
    """Robots that drive in turns one way and the other, with the same frames and tf in their namespaces."""
    parts = []
    for number, name in enumerate(names):
        said = drive(by_tf(topic=f"{name}/tf"), f"{name}/scan", way=number % 2)
        parts.append([static("base_link", "laser", MOUNT, topic=f"{name}/tf_static"), *said])
    return together(*parts)


def runs(*starts: int, late: int = 0) -> list[Said]:
    """Drives one after the other whose stamps begin again; ``late`` old transforms come after a reset."""
    said = [LASER]
    for number, _ in enumerate(starts):
        old = [transform(T0 + k * SECOND // 50, "odom", "base_link", 9.0, 9.0) for k in range(late)] if number else []
        said += [*drive(by_tf(), way=number % 2), *old]
    return [replace(one, stamp_ns=T0 + k * SECOND // 100) for k, one in enumerate(said)]  # recorded on and on


def inverted(at: int, pose: Pose) -> list[Said]:
    return [transform(at, "base_link", "odom_lidar", *back(pose))]


def inverted_under(fixed: str) -> Callable[[int, Pose], list[Said]]:
    return lambda at, pose: [transform(at, "base_link", fixed, *back(pose))]


def camera_as_root(at: int, pose: Pose) -> list[Said]:
    return [transform(at, "odom", "camera_link", *of(pose, CAMERA))]


class Tilted:
    """A transform in space: metres along x, then degrees of yaw, pitch and roll (ZYX). SciPy does the rotations."""

    def __init__(self, x: float, *yaw_pitch_roll: float) -> None:
        self.place = np.array([x, 0.0, 0.2])
        self.turn = Rotation.from_euler("ZYX", yaw_pitch_roll, degrees=True)

    @classmethod
    def of(cls, pose: Pose) -> Tilted:
        found = cls(0.0, math.degrees(pose[2]), 0.0, 0.0)
        found.place = np.array([pose[0], pose[1], 0.0])
        return found

    def __matmul__(self, other: Tilted) -> Tilted:
        found = Tilted(0.0, 0.0, 0.0, 0.0)
        found.place, found.turn = self.place + self.turn.apply(other.place), self.turn * other.turn
        return found

    @property
    def back(self) -> Tilted:
        found = Tilted(0.0, 0.0, 0.0, 0.0)
        found.turn = self.turn.inv()
        found.place = -found.turn.apply(self.place)
        return found

    @property
    def fields(self) -> tuple[dict[str, float], dict[str, float]]:
        """Its position and its quaternion as messages have them."""
        place, turn = (dict(zip("xyzw", values.tolist(), strict=False)) for values in (self.place, self.turn.as_quat()))
        return place, turn


def tilted(parent: str, child: str, pose: Tilted) -> Said:
    said = static(parent, child, AHEAD)
    place, turn = pose.fields
    said.fields["transforms"][0]["transform"] = {"translation": place, "rotation": turn}
    return said


def tracked(camera: Tilted) -> Callable[[int, Pose], list[Said]]:
    """Odometry of a camera on the robot in the frame in which the camera itself began."""
    first = (Tilted.of(true(0)) @ camera).back

    def at_step(at: int, pose: Pose) -> list[Said]:
        said = odometry(at, *AHEAD, "/camera/odom", frame="camera_odom", child="camera")
        place, turn = (first @ Tilted.of(pose) @ camera).fields
        said.fields["pose"]["pose"] = {"position": place, "orientation": turn}
        return [said]

    return at_step


def suspended(at: int, pose: Pose) -> list[Said]:
    """Odometry of base_footprint alone; base_link rises in base_stabilized, and both are in the footprint."""
    rise = 0.01 * ((at - T0) // STEP % 3)
    return [
        transform(at, "base_footprint", "base_stabilized", z=0.1 + rise),
        transform(at, "base_stabilized", "base_link", z=rise, roll=0.0),
        odometry(at, *pose, child="base_footprint"),
    ]


def of_camera(at: int, pose: Pose) -> list[Said]:
    return [odometry(at, *of(pose, CAMERA), "/camera/odom", frame="odom_frame", child="camera_pose_frame")]


def two_parents(at: int, pose: Pose) -> list[Said]:
    drifted = (1.1 * pose[0], 1.1 * pose[1], pose[2] + 0.004 * (at - T0) / STEP)
    said = [transform(at + k, "odom", "base_link", *drifted) for k in range(2)]
    return [*said, transform(at + 2, "map", "base_link", *pose)] if (at - T0) // STEP % 2 == 0 else said


def replaced_mount() -> list[Said]:
    said = drive(by_tf())
    half = len(said) // 2
    rig = [static("base_link", "rig", (0.1, 0.0, 0.0)), static("rig", "laser", (0.2, -0.1, 0.5))]
    new = static("base_link", "laser", CAMERA, said[half].stamp_ns)
    return [*rig, *said[:half], new, *said[half:]]


def replaced_places() -> list[Pose]:
    before = sum(one.topic == "/scan" for one in drive(by_tf())[: len(drive(by_tf())) // 2])
    return [of(true(i + 0.1), MOUNT if i < before else CAMERA) for i in range(N)]


def lag(at: int, pose: Pose) -> list[Said]:
    """Transforms of a publisher of which each third message comes 1.2 s late, and one far ahead of time."""
    i = (at - T0) // STEP
    said = [transform(at, "odom", "base_link", *pose), transform(at + SECOND, "map", "odom")]
    if i % 3 == 2 and i > 6:
        said.append(replace(transform(at - 6 * STEP, "odom", "base_link", *true(i - 6)), stamp_ns=at + 1))
    return said


@dataclass(frozen=True)
class Case:
    source: str  #: public reports of this kind
    messages: list[Said]
    places: list[Pose]
    note: str = ""  #: what a note has to say, as a regular expression
    trajectory: str | None = None
    topic: str | None = None
    tf: str | None = None


CASES: dict[str, Case] = {
    "clean": Case("", [LASER, *drive(by_tf())], sensor_at()),
    "robots with the same frames": Case(
        "create3_sim#211, rosbot_xl_ros#71, navigation2#5449",
        robots("/a", "/b", "/fleet/c"),
        sensor_at(way=1),
        topic="/b/scan",
    ),
    "a robot in a nested namespace": Case(
        "geometry2#326", robots("/a", "/fleet/c"), sensor_at(way=1), topic="/fleet/c/scan"
    ),
    "a robot without a namespace beside one with": Case("geometry2#326", robots("", "/b"), sensor_at(), topic="/scan"),
    "frames with namespaces in one tf": Case(
        "geometry2#32",
        together(
            [static("b/base_link", "b/laser", MOUNT)],
            drive(by_tf("b/odom", "b/base_link"), "/b/scan", "b/laser", way=1),
            drive(by_tf("a/odom", "a/base_link"), "/a/scan", "a/laser"),
        ),
        sensor_at(way=1),
        topic="/b/scan",
    ),
    "a second topic of transforms": Case(
        "navigation2#5449",
        [LASER, *drive(lambda at, pose: [*by_tf()(at, pose), *by_tf("world", topic="/tf_gt")(at, pose)])],
        sensor_at(),
        r"looked up in /tf\. The log has other transforms, /tf_gt",
        trajectory="tf_gt/world",
    ),
    "a second topic of transforms that is chosen": Case(
        "navigation2#5449",
        [LASER, *drive(lambda at, pose: [*by_tf()(at, (7.0, 0.0, 0.0)), *by_tf("world", topic="/vicon/tf")(at, pose)])],
        sensor_at(),
        tf="vicon/tf",
    ),
    "invalid transforms in each message": Case(
        "fixposition_driver#69, OrbbecSDK_ROS1#49, realsense-ros PR 759",
        with_bad([LASER, *drive(by_tf())], BAD),
        sensor_at(),
        "'zero' in 'base_link', as in tf2: its quaternion is 0, 0, 0, 0, which is no rotation",
    ),
    "a simulation that is reset twice": Case(
        "geometry2#43, geometry2#329, slam_gmapping#66",
        runs(0, 1, 2),
        [*sensor_at(), *sensor_at(way=1), *sensor_at()],
        r"begins again at scan 21 \(3\.8 s back\) and scan 41",
    ),
    "late transforms are no reset": Case("geometry2#341, geometry2#347", [LASER, *drive(lag)], sensor_at()),
    "odometry of a camera": Case(
        "realsense-ros#1526, realsense-ros#912",
        [LASER, *drive(of_camera), static("base_link", "camera_pose_frame", CAMERA, T0 + N * STEP)],
        sensor_at(),
    ),
    "odometry of the base's footprint": Case(
        "turtlebot3#690",
        [
            LASER,
            static("base_footprint", "base_link", (0.1, 0.0, 0.0)),
            *drive(
                lambda at, pose: [
                    odometry(at, *of(pose, (-0.1, 0.0, 0.0)), child="base_footprint"),
                    *by_tf("odom", "base_footprint")(at, of(pose, (-0.1, 0.0, 0.0))),
                ]
            ),
        ],
        sensor_at(),
        trajectory="odom",
    ),
    "odometry of a footprint in which the base rises and tilts": Case(
        "hector_pose_estimation; tf of base_stabilized",
        [LASER, *drive(suspended)],
        sensor_at(),
        trajectory="odom",
    ),
    "a camera as the root of the robot": Case(
        "realsense-ros#2411, zed-ros-wrapper#447",
        [LASER, static("camera_link", "base_link", back(CAMERA)), *drive(camera_as_root)],
        sensor_at(),
    ),
    "a camera with a parent on the robot and one that tracks": Case(
        "realsense-ros#2411",
        [
            LASER,
            static("base_link", "camera", CAMERA),
            *drive(lambda at, pose: by_tf("odom", "camera")(at, of(pose, CAMERA))),
        ],
        sensor_at(),
        "2 parents of the frame 'camera'",
    ),
    "a mount that is stated upside down": Case(
        "cob_control#259", [static("laser", "base_link", back(MOUNT)), *drive(by_tf())], sensor_at()
    ),
    "two parents": Case(
        "autoware_universe#6676, hector_slam#27",
        [LASER, *drive(two_parents)],
        sensor_at(),
        r"2 parents of the frame 'base_link', 'odom' \(42 transforms\) and 'map' \(11",
    ),
    "a static transform that is replaced while scans come": Case(
        "depthai-ros#619, geometry2#705", replaced_mount(), replaced_places(), "static transforms were replaced"
    ),
    "a static transform that is replaced before the first scan": Case(
        "depthai-ros#619",
        [static("mast", "laser", CAMERA), static("base_link", "mast", CAMERA), LASER, *drive(by_tf())],
        sensor_at(),
    ),
    "odometry published upside down": Case(
        "kiss-icp#371, viso2#33, cob_control#259", [LASER, *drive(inverted)], sensor_at()
    ),
    **{
        f"odometry published upside down, of {frame}": Case(
            "kiss-icp#371, viso2#33, cob_control#259", [LASER, *drive(inverted_under(frame))], sensor_at()
        )
        for frame in ("camera_init", "lidar_init", "utm", "robot/enu", "local_origin_ned")
    },
    "odometry whose message states the fixed frame in the robot's": Case(
        "kiss-icp#371, viso2#33, cob_control#259",
        [LASER, *drive(lambda at, pose: [odometry(at, *back(pose), frame="base_link", child="odom")])],
        sensor_at(),
    ),
    **{
        f"odometry in the first frame of a camera that looks {name}": Case(
            "realsense-ros#1526, realsense-ros#2411",
            [LASER, tilted("base_link", "camera", Tilted.of(AHEAD) @ camera), *drive(tracked(camera))],
            sensor_at(),
            f"the robot is tilted by {degrees}°",
        )
        for name, camera, degrees in (
            ("ahead, by its optical frame", Tilted(0.3, -90.0, 0.0, -90.0), 90),
            ("down a little and aside", Tilted(0.3, 40.0, 25.0, 0.0), 25),
            ("ahead, upside down", Tilted(0.3, 20.0, 0.0, 180.0), 180),
        )
    },
    "poses alone": Case(
        "evo#660", [LASER, *drive(lambda at, pose: [recorded.pose_stamped(at, *pose)])], sensor_at(), trajectory="pose"
    ),
    "poses beside goals": Case(
        "evo#660",
        [
            LASER,
            recorded.pose_stamped(T0, 50.0, 50.0, 0.0, "/move_base_simple/goal"),
            *drive(lambda at, pose: [recorded.pose_stamped(at, *pose, "/mocap/pose")]),
            recorded.pose_stamped(T0 + N * STEP, -50.0, 50.0, 0.0, "/move_base_simple/goal"),
        ],
        sensor_at(),
    ),
    "poses without a header": Case(
        "geometry_msgs/Pose",
        [LASER, *drive(lambda at, pose: [recorded.bare_pose(at, *pose)])],
        sensor_at(),
        r"on /robot_pose \(geometry_msgs/Pose\) state no time: each has that at which it was recorded",
    ),
    "planar poses without a header": Case(
        "geometry_msgs/Pose2D, as of laser_scan_matcher",
        [LASER, *drive(lambda at, pose: [recorded.pose_2d(at, *pose)])],
        sensor_at(),
        "Pose2D. state no time",
    ),
    "transforms of a motion capture": Case(
        "vicon_bridge#10", [LASER, *drive(lambda at, pose: [recorded.transform_stamped(at, *pose)])], sensor_at(),
        "tf does not say where 'robot'",
    ),
    "the path of a mapper": Case(
        "hector_slam#27",
        [
            LASER,
            *drive(lambda at, pose: []),
            recorded.path(T0 + N * STEP, [recorded.pose_stamped(T0 + i * STEP, *true(i)) for i in range(N + 1)]),
        ],
        sensor_at(),
    ),
    "georeferenced transforms": Case(
        "gps_amcl#5, marti_common#561",
        [LASER, *drive(lambda at, pose: by_tf("utm")(at, (GEO[0] + pose[0], GEO[1] + pose[1], pose[2])))],
        sensor_at(),
        "less 691000 m in x and 5334000 m in y",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_every_scan_has_its_true_place(tmp_path: Path, name: str) -> None:
    case = CASES[name]
    log = open_log(written(tmp_path, case.messages, "mcap"), topic=case.topic, tf=case.tf)
    assert_places(log, case.places, case.trajectory)
    said = " ".join(log.notes)
    assert re.search(case.note, said), said
    assert "no poses" not in said


@pytest.mark.parametrize("frame", ["tool_origin", "gripper_init", "gimbal_enu", "utm_antenna"])
def test_a_frame_that_moves_on_the_robot_is_no_fixed_frame(tmp_path: Path, frame: str) -> None:
    """A word of its name is one of utm, enu, camera_init and the like, which name fixed frames as a whole."""
    said = drive(lambda at, pose: [*by_tf()(at, pose), transform(at, "base_link", frame, *back(pose))])
    log = open_log(written(tmp_path, [LASER, *said], "mcap"))
    assert not any(frame in name for name in log.trajectories), list(log.trajectories)
    assert_places(log, sensor_at())


def test_each_invalid_transform_is_named(tmp_path: Path) -> None:
    """tf2 ignores them one by one (BufferCore::setTransform)."""
    log = open_log(written(tmp_path, with_bad([LASER, *drive(by_tf())], BAD), "bag"))
    (said,) = (note for note in log.notes if "/tf_static" in note)
    for child, why in (
        ("zero", "no rotation"),
        ("long", "length 2, not 1"),
        ("nan", "quaternion is not finite"),
        ("nowhere", "position is not finite"),
        ("base_link", "of a frame in itself"),
        ("orphan", "does not name its parent"),
        ("", "does not name its child"),
    ):
        assert re.search(f"the transform of {child!r} in '[a-z_]*', as in tf2: [^;]*{why}", said), (child, said)


@pytest.mark.parametrize(("length", "why"), [(0.0, "0, 0, 0, 0, which is no rotation"), (2.0, "the length 2, not 1")])
def test_a_quaternion_that_is_no_rotation_is_the_reason_that_is_given(tmp_path: Path, length: float, why: str) -> None:
    """rbcar_sim#4."""
    said = [LASER, *drive(lambda at, pose: [odometry(at, *pose)])]
    for one in said:
        if one.topic == "/odom":
            one.fields["pose"]["pose"]["orientation"] = {"x": 0.0, "y": 0.0, "z": 0.0, "w": length}
    notes = open_log(written(tmp_path, said, "mcap")).notes
    assert any("poses can be used" in note and why in note for note in notes)
    assert not any("holds no poses" in note for note in notes)


def test_odometry_that_states_velocities_alone_is_named(tmp_path: Path) -> None:
    """A base whose driver fills the twist, and leaves the pose as it was made."""
    said = [LASER, *drive(lambda at, pose: [odometry(at, 0.0, 0.0, 0.0)])]
    for one in said:
        if one.topic == "/odom":
            one.fields["twist"]["twist"]["linear"] = {"x": 0.3, "y": 0.4, "z": 0.0}
    (note,) = open_log(written(tmp_path, said, "bag")).notes
    assert note.startswith("The poses on /odom never change, although its messages state velocities up to 0.5 m/s")


NOT_SOURCES: dict[str, tuple[Callable[[int, Pose], list[Said]], str]] = {
    "particles": (
        lambda at, pose: [recorded.pose_array(at, [pose, pose])],
        r"\(/particlecloud: geometry_msgs/PoseArray, many poses at one time\)",
    ),
    "a path without stamps": (
        lambda at, pose: [recorded.path(at, [recorded.pose_stamped(0, *pose) for _ in range(2)])],
        r"\(/trajectory: nav_msgs/Path, poses whose stamps do not ascend\)",
    ),
    "goals": (
        lambda at, pose: [recorded.pose_stamped(at, *pose, "/goal_pose")],
        r"\(/goal_pose: geometry_msgs/PoseStamped, where the robot is to go\)",
    ),
}


@pytest.mark.parametrize("name", NOT_SOURCES)
def test_poses_that_are_no_source_are_named_with_the_reason(tmp_path: Path, name: str) -> None:
    poses, why = NOT_SOURCES[name]
    log = open_log(written(tmp_path, [LASER, *drive(poses)], "bag"))
    (note,) = log.notes
    assert re.search(f"^The file holds no poses along which the robot moved {why}, so the map shows all", note), note


def test_a_frame_of_the_same_name_behind_a_prefix_is_named(tmp_path: Path) -> None:
    """geometry2#32: the scans lack the prefix that the robot's frames have, so that no look-up finds them."""
    said = [static("r1/base_link", "r1/laser", MOUNT), *drive(by_tf("r1/odom", "r1/base_link"))]
    log = open_log(written(tmp_path, said, "mcap"))
    (note,) = log.notes
    assert note.startswith("tf does not say where the frame 'laser' sits on the robot, only where 'r1/laser' sits; ")
    assert log.mount_assumed


@pytest.mark.parametrize(("mount", "is_assumed"), [(None, True), (AHEAD, False)])
def test_a_mount_that_no_transform_states_is_known_to_be_assumed(
    tmp_path: Path, mount: Pose | None, is_assumed: bool
) -> None:
    """Recorded without /tf_static; a mount that is stated to be the robot's centre is another thing."""
    said = [*([] if mount is None else [static("base_link", "laser", mount)]), *drive(by_tf())]
    log = open_log(written(tmp_path, said, "db3"))
    assert (log.mount, log.mount_assumed) == (AHEAD, is_assumed)


def test_poses_in_millimetres_are_named(tmp_path: Path) -> None:
    far = [LASER, *drive(lambda at, pose: [recorded.pose_stamped(at, 1000 * pose[0], 1000 * pose[1], pose[2])])]
    (note,) = open_log(written(tmp_path, far, "mcap")).notes
    assert re.search(r"By pose the robot usually moves at 7\d\d m/s: apparently its poses are in millimetres", note)


@pytest.mark.parametrize("topic", ["/scan", "/odom", "/tf"])
@pytest.mark.parametrize("step", [-3600, -2, 2])
def test_a_driver_that_sets_its_own_clock_is_no_reset(tmp_path: Path, topic: str, step: int) -> None:
    """Of three topics the stamps of one step, so the others are of one run, and they were recorded at regular times."""
    said = [LASER, *drive(lambda at, pose: [*by_tf()(at, pose), odometry(at, *pose)])]
    for one in [one for one in said if one.topic == topic][N // 2 :]:
        moved = recorded.header(one.stamp_ns + step * SECOND, "laser" if topic == "/scan" else "odom")
        (one.fields["transforms"][0] if topic == "/tf" else one.fields)["header"] = moved
    log = open_log(written(tmp_path, said, "mcap"))
    for name in log.trajectories:
        assert_places(log, sensor_at(), name)
    (note,) = log.notes
    assert note.startswith(f"The clock of {topic} was set by {step:+,.1f} s before message {N // 2 + 1}, while others")


def test_a_clock_that_all_topics_share_is_not_taken_to_be_set_by_one(tmp_path: Path) -> None:
    """The recorder is elsewhere, and the whole robot's clock is set ahead while it stands: all stamps stay."""
    said = [LASER, *drive(lambda at, pose: [*by_tf()(at, pose), odometry(at, *pose)])]
    late = T0 + N // 2 * STEP
    for one in said:
        for part in one.fields.get("transforms", [one.fields]):
            ahead = 30 * SECOND if one.stamp_ns >= late else 0
            part["header"] = recorded.header(one.stamp_ns + ahead, part["header"]["frame_id"])
    log = open_log(written(tmp_path, said, "mcap"))
    assert_places(log, sensor_at(), tolerance=0.02)  # the scan before the step is between two poses 30 s apart
    assert not any("was set by" in note for note in log.notes)
    assert int(np.diff(log.stamps_ns).max()) == 30 * SECOND + STEP


def test_the_last_transform_between_two_fixed_frames_holds(tmp_path: Path) -> None:
    """REP 105: a localiser that states map → base_link seldom, and ends early, leaves the rest to the wheels."""

    def seldom(at: int, pose: Pose) -> list[Said]:
        said = [transform(at, "odom", "base_link", *pose)]
        i = (at - T0) // STEP
        return [*said, transform(at + 1, "map", "base_link", *of((1.0, 2.0, 0.3), pose))] if i in (2, 5, 8) else said

    log = open_log(written(tmp_path, [LASER, *drive(seldom)], "db3"))
    assert_places(log, sensor_at(), "tf/map")
    assert any("after the last pose of tf/map, which moves as tf/odom there" in note for note in log.notes)


def test_other_robots_transforms_are_not_offered(tmp_path: Path) -> None:
    """A sensor below the namespace that has its robot's tf: what is beside that namespace is of other robots."""
    said = together(
        [static("base_link", "laser", MOUNT, topic="/fleet/a/tf_static")],
        drive(by_tf(topic="/fleet/a/tf"), "/fleet/a/lidar/front"),
        drive(by_tf(topic="/fleet/b/tf"), "/fleet/b/lidar/front", way=1),
    )
    log = open_log(written(tmp_path, said, "mcap"), topic="/fleet/a/lidar/front")
    assert list(log.trajectories) == ["tf/odom"]
    assert not any("looked up in" in note for note in log.notes)
    assert_places(log, sensor_at())


def test_trajectories_of_both_parents_are_kept(tmp_path: Path) -> None:
    log = open_log(written(tmp_path, [LASER, *drive(two_parents)], "mcap"))
    assert list(log.trajectories) == ["tf/map", "tf/odom"]
    drifted = [(1.1 * x, 1.1 * y, yaw + 0.004 * (i + 0.1)) for i in range(N) for x, y, yaw in [true(i + 0.1)]]
    np.testing.assert_allclose(log.trajectory("tf/odom").poses, drifted, atol=5e-3)


def test_each_robot_has_its_own_odometry(tmp_path: Path) -> None:
    said = together(
        *(
            drive(lambda at, pose, name=name: [odometry(at, *pose, f"{name}/odom")], f"{name}/scan", way=way)  # type: ignore[misc]
            for way, name in enumerate(("/a", "/b"))
        )
    )
    robot = open_robot_log(written(tmp_path, said, "mcap"))
    assert [list(log.trajectories) for log in robot.sensors.values()] == [["a/odom"], ["b/odom"]]
    assert_places(robot.sensors["/b/scan"], sensor_at((0.0, 0.0, 0.0), way=1))


def test_a_topic_of_transforms_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match=r"no transforms on '/gt'; it has /tf\."):
        open_log(written(tmp_path, [LASER, *drive(by_tf())], "mcap"), tf="/gt")


def test_poses_that_are_added_take_the_place_of_none(tmp_path: Path) -> None:
    """evo#393."""
    bare = open_log(written(tmp_path, [LASER, *drive(lambda at, pose: [])], "mcap"))
    assert any("holds no poses" in note for note in bare.notes)
    tum = tmp_path / "poses.txt"
    rows = [(T0 / SECOND + i / 5, *true(i)) for i in range(N + 1)]
    tum.write_text("".join(f"{t:.3f} {x} {y} 0 0 0 {math.sin(a / 2)} {math.cos(a / 2)}\n" for t, x, y, a in rows))
    log = with_trajectory(bare, read_tum(tum))
    assert list(log.trajectories) == ["tum"]
    assert not any("holds no poses" in note for note in log.notes)
    assert_places(log, sensor_at())


@pytest.mark.parametrize("kind", ["csv", "carmen", "tum", "mcap"])
def test_the_map_of_a_georeferenced_log_has_its_origin_there(tmp_path: Path, kind: str) -> None:
    """gps_amcl#5: the wall 2 m ahead of the first scan is at its UTM coordinates in the map's file."""
    csv = "angle_min,0\nangle_increment,0.01\nrange_max,5\nstamp,x,y,theta,ranges\n"
    x, y = (0.0, 0.0) if kind == "tum" else GEO
    (tmp_path / "a.csv").write_text(csv + "".join(f"{t},{x},{y},0,2.02,2.02,2.02\n" for t in range(1, 9)))
    log = open_log(tmp_path / "a.csv")
    if kind == "carmen":
        place = f"{x} {y} 0"
        lines = [f"FLASER 181 {'2.02 ' * 181}{place} {place} {t} host {t}" for t in range(1, 9)]
        (tmp_path / "a.log").write_text("\n".join([*lines, ""]))
        log = open_log(tmp_path / "a.log")
        log = replace(log, ranges=log.ranges[:, 90:93], angle_min=0.0, angle_increment=0.01)
    if kind == "tum":
        (tmp_path / "a.txt").write_text("".join(f"{t} {GEO[0]} {GEO[1]} 0 0 0 0 1\n" for t in range(1, 9)))
        log = with_trajectory(log, read_tum(tmp_path / "a.txt"))
    if kind == "mcap":
        at = [transform(T0 + i * STEP, "utm", "laser", GEO[0] + 0.01 * i, GEO[1]) for i in range(3)]
        said = [*at, *(scan(T0 + i * STEP, [2.02] * 3, angles=(0.0, 0.01)) for i in range(3))]
        log = open_log(written(tmp_path, said, "mcap"))
    config = MappingConfig(resolution=0.05)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config, None, 0, log.n_scans)
    assert np.abs(log.trajectory().poses).max() < 1000.0
    save_map(grid, tmp_path / "map", offset=log.trajectory().offset)
    loaded = load_map(tmp_path / "map.yaml")
    occupied = np.argwhere(loaded.values == 100)
    assert len(occupied)
    x, y = loaded.grid.geometry.cell_to_world(occupied).mean(axis=0)
    assert (x, y) == pytest.approx((GEO[0] + 2.02, GEO[1] + 0.02), abs=0.06)


def test_clouds_of_two_runs_at_one_stamp_have_no_pose(tmp_path: Path) -> None:
    """geometry2#43: of clouds the stamp alone is known, which both runs have; behind the shorter one it is plain."""
    points = np.array([[1.0, 0.0, 0.5]])
    said = [static("base_link", "velodyne", MOUNT)]
    for way, n in enumerate((N, N // 2)):
        for i in range(n + 1):
            said += [transform(T0 + i * STEP, "odom", "base_link", *true(i, way)), seen(T0 + i * STEP)]
            said.append(recorded.cloud(T0 + i * STEP, points))
    said = [replace(one, stamp_ns=T0 + k * SECOND // 100) for k, one in enumerate(said)]
    (stream,) = open_robot_log(written(tmp_path, said, "mcap")).clouds.values()
    stamps = T0 + STEP * np.arange(N + 1)
    poses = stream.poses("velodyne", stamps)
    assert poses is not None
    assert np.isnan(poses[: N // 2]).all()
    expected = [of(true(i), MOUNT) for i in range(N // 2 + 2, N + 1)]
    np.testing.assert_allclose(poses[N // 2 + 2 :, :2, 3], np.array(expected)[:, :2], atol=1e-9)
