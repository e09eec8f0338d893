"""Planar scans cut out of the point clouds and depth images of recordings, against what the scene says."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError, ReadError
from mapper.io.logs import open_log, open_robot_log
from mapper.io.logs.ros.cloud_messages import DEPTHS, NotDepthError, camera_info, depth_image, point_cloud
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.selection import Selection
from mapper.sensors.planar.options import PlanarCut
from tests.hostile.lengths import lies
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import KINDS, Said, camera, cloud, image, odometry, scan, transform, written

T0, TENTH = 1_600_000_000 * recorded.SECOND, recorded.SECOND // 10
FIELDS = [("x", "f4"), ("y", "f8"), ("z", "f4"), ("intensity", "u1"), ("ring", "u2"), ("time", "f8")]
UP = 1.2  #: metres: height of the sensor above the base
AT = (0.3, -0.1, 0.5)  #: and its place and heading there


@given(
    st.sampled_from([1, 2]),
    st.booleans(),
    st.permutations(FIELDS),
    st.sampled_from("<>"),
    st.sampled_from([(1, 12), (3, 4), (12, 1)]),
    st.tuples(st.integers(0, 9), st.integers(0, 9)),
    st.integers(0, 2**32 - 1),
)
def test_clouds_of_any_layout(ros, little, layout, order, size, padding, seed):
    points = np.random.default_rng(seed).normal(0, 20, (12, 3)).astype(np.float32).astype(np.float64)
    points[seed % 12, seed % 3] = [np.nan, np.inf][seed % 2]
    said = cloud(T0, points, layout=layout, order=order, rows=size[0], padding=padding)
    found = point_cloud(recorded.serialised(said, ros, little_endian=little), cdr=ros == 2)
    assert (found.stamp_ns, found.frame) == (T0, "velodyne")
    np.testing.assert_array_equal(np.concatenate(list(found.parts())), points)


def test_clouds_of_whole_numbers_and_of_none():
    points = np.arange(-6, 6).reshape(4, 3)
    said = cloud(T0, points, layout=[("z", "i2"), ("x", "i1"), ("y", "i4")])
    found = point_cloud(recorded.serialised(said, 2), cdr=True)
    np.testing.assert_array_equal(np.concatenate(list(found.parts())), points)
    empty = point_cloud(recorded.serialised(cloud(T0, np.zeros((0, 3))), 2), cdr=True)
    assert list(empty.parts()) == []


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"width": 2**31}, "do not fit"),
        ({"height": 2**31, "row_step": 0}, "do not fit"),
        ({"point_step": 0}, "reaches beyond"),
        ({"point_step": 8}, "reaches beyond"),
        ({"row_step": 2**32 - 1, "height": 2}, "do not fit"),
        ({"fields": []}, "no field x"),
    ],
)
def test_clouds_that_lie(change, why):
    said = cloud(T0, np.zeros((5, 3)))
    said.fields |= change
    with pytest.raises(BadMessageError, match=why):
        point_cloud(recorded.serialised(said, 2), cdr=True)


@pytest.mark.parametrize("ros", [1, 2])
def test_false_lengths_and_cut_messages_are_refused(ros):
    samples = [
        (cloud(T0, np.zeros((5, 3))), point_cloud),
        (image(T0, np.ones((4, 6))), depth_image),
        (camera(T0, (6, 4), 5.0), camera_info),
    ]
    for said, decode in samples:
        data = recorded.serialised(said, ros)
        decode(data, cdr=ros == 2)
        for n in range(len(data) - 1):
            with pytest.raises(BadMessageError):
                decode(data[:n], cdr=ros == 2)
        for at in range(0, len(data) - 4, 4):
            for lie in lies(4):
                with contextlib.suppress(BadMessageError, NotDepthError):  # at most places there is no length
                    decode(data[:at] + lie + data[at + 4 :], cdr=ros == 2)


def room_points(rng: np.random.Generator) -> np.ndarray:
    """Points on the walls, the floor and the ceiling of a room around the base, x ±3, y ±2, z 0 to 2.5."""
    walls = rng.uniform([-3, -2, 0], [3, 2, 2.5], (6000, 3))
    side = rng.integers(0, 4, len(walls))
    walls[side < 2, 0] = np.where(side[side < 2] == 0, -3.0, 3.0)
    walls[side > 1, 1] = np.where(side[side > 1] == 2, -2.0, 2.0)
    flat = rng.uniform([-3, -2, 0], [3, 2, 1], (3000, 3))
    flat[:, 2] = np.where(flat[:, 2] < 0.5, 0.0, 2.5)
    return np.concatenate([walls, flat])


def in_sensor(points: np.ndarray) -> np.ndarray:
    """Points of the base frame in the frame of the sensor, which hangs upside down at AT, UP."""
    x, y, yaw = AT
    away = points - [x, y, UP]
    turned = np.column_stack(
        [
            np.cos(yaw) * away[:, 0] + np.sin(yaw) * away[:, 1],
            -np.sin(yaw) * away[:, 0] + np.cos(yaw) * away[:, 1],
            away[:, 2],
        ]
    )
    return turned * [1, -1, -1]


def distances(bearings: np.ndarray) -> np.ndarray:
    """Distance from the sensor to the walls, along the base's axes."""
    x, y, _ = AT
    cos, sin = np.cos(bearings), np.sin(bearings)
    with np.errstate(divide="ignore"):
        return np.asarray(np.minimum((np.where(cos > 0, 3, -3) - x) / cos, (np.where(sin > 0, 2, -2) - y) / sin))


def recording_of_room(tf_at: int = 0, n: int = 4) -> list[Said]:
    points = in_sensor(room_points(np.random.default_rng(1)))
    said = [m for i in range(n) for m in (odometry(T0 + i * TENTH, 0.1 * i, 0.0, 0.0), cloud(T0 + i * TENTH, points))]
    x, y, yaw = AT
    mount = transform(T0, "base_link", "velodyne", x, y, yaw, np.pi, z=UP, topic="/tf_static")
    return [*said[:tf_at], mount, *said[tf_at:]]


@pytest.mark.parametrize(("kind", "tf_at"), [(kind, 0) for kind in KINDS] + [("mcap", 4), ("mcap", 8)])
def test_a_cloud_becomes_the_scan_of_its_height_band(tmp_path: Path, kind: str, tf_at: int) -> None:
    path = written(tmp_path, recording_of_room(tf_at), kind)
    cut = PlanarCut(min_height=0.1, max_height=2.0, angle_increment=np.radians(2.0))
    log = open_robot_log(path, selection=Selection(cut=cut)).first
    assert log.topic == "/points"
    assert (log.n_scans, log.n_beams) == (4, 180)
    np.testing.assert_allclose(log.mount, (AT[0], AT[1], 0.0), atol=1e-9)
    assert not log.upside_down
    # A beam's points lie within a degree of it.
    near, far = (
        np.array([f(distances(a + np.radians(np.linspace(-1, 1, 41)))) for a in log.angles]) for f in (np.min, np.max)
    )
    assert np.isfinite(log.ranges).all()
    assert (log.ranges > near - 1e-4).all()
    assert (log.ranges < far + 1e-4).all()
    np.testing.assert_allclose(log.trajectory().poses[:, 0], [0.0, 0.1, 0.2, 0.3], atol=1e-6)


def test_the_floor_alone_is_no_return_and_nothing_is_nothing(tmp_path: Path) -> None:
    points = np.array([[2.0, 0.0, -1.2], [0.0, 2.0, 0.0], [0.0, 3.0, 0.0]])
    tf = transform(T0, "base_link", "velodyne", z=1.2)
    path = written(tmp_path, [tf, cloud(T0, points)], "mcap")
    quarter = PlanarCut(min_height=0.1, angle_increment=np.pi / 2)
    log = open_robot_log(path, selection=Selection(cut=quarter)).first
    np.testing.assert_array_equal(log.ranges, [[np.nan, np.nan, np.inf, 2.0]])


def test_a_floor_in_the_height_band_is_noted(tmp_path: Path) -> None:
    """At an angle every third beam goes down to the floor, 2 m away, and all go on to a wall at 4 m."""
    bearings = np.radians(np.arange(0.5, 360.0))
    ahead = np.column_stack([np.cos(bearings), np.sin(bearings), np.zeros(360)])
    wall, floor = 4.0 * ahead - [0.0, 0.0, 0.2], 2.0 * ahead[::3] - [0.0, 0.0, 1.18]
    tf = transform(T0, "base_link", "velodyne", z=1.2, topic="/tf_static")
    path = written(tmp_path, [tf, cloud(T0, np.concatenate([wall, floor]))], "mcap")
    cuts = [PlanarCut(), PlanarCut(min_height=0.1), PlanarCut(min_height=-0.5)]
    noted = [
        [n for n in open_robot_log(path, selection=Selection(cut=cut)).first.notes if "floor" in n] for cut in cuts
    ]
    assert [len(notes) for notes in noted] == [1, 0, 0]
    assert noted[0][0].startswith("33 % of the beams")
    assert "raise min_height, for example to 0.1 m" in noted[0][0]


def test_a_cloud_without_transforms_is_cut_in_its_own_frame_and_that_is_said(tmp_path: Path) -> None:
    tf = transform(T0, "map", "elsewhere")
    path = written(tmp_path, [tf, cloud(T0, [[2.0, 0.1, 0.5], [1.0, 0.1, -0.5]])], "mcap")
    log = open_log(path)
    assert np.nanmin(log.ranges) == pytest.approx(np.hypot(2.0, 0.1))
    assert any("before its clouds were cut" in note for note in log.notes)


def test_a_lidar_is_preferred_and_the_clouds_beside_it_are_cut_where_they_are_named(tmp_path: Path) -> None:
    path = written(tmp_path, [scan(T0, [1, 2, 3]), *recording_of_room()], "mcap")
    log = open_log(path)
    assert log.topic == "/scan"
    assert [(one.name, one.count) for one in log.topics if one.type.endswith("PointCloud2")] == [("/points", 4)]
    assert list(open_robot_log(path).sensors) == ["/scan"]
    assert open_log(path, topic="/points").n_beams == 360
    with pytest.raises(ReadError, match="no scans on '/nothing'; it has /scan, /points"):
        open_log(path, topic="/nothing")


SIZE, FOCAL = (61, 41), 50.0


def wall(distance: float) -> np.ndarray:
    """A camera that looks along its axis at a wall sees the same depth everywhere."""
    return np.full((SIZE[1], SIZE[0]), distance)


def recording_of_camera(*images: Said, frame: str = "optical") -> list[Said]:
    optical = {
        "header": recorded.header(T0, "base_link"),
        "child_frame_id": frame,
        "transform": {
            "translation": {"x": 0.2, "y": 0.0, "z": 0.4},
            "rotation": {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5},
        },
    }
    tf = Said("/tf_static", "tf2_msgs/msg/TFMessage", T0, {"transforms": [optical]})
    return [tf, *images, odometry(T0, 0.0, 0.0, 0.0)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("encoding", ["16UC1", "32FC1"])
def test_a_depth_image_becomes_a_scan(tmp_path: Path, kind: str, encoding: str) -> None:
    depth = wall(2.0)
    depth[:, :30] = 3.0
    pixels = depth / DEPTHS[encoding][1]
    pixels[:, 45] = 0 if encoding == "16UC1" else np.nan
    images = [image(T0, pixels, encoding, order=">", padding=6), image(T0 + TENTH, pixels, encoding)]
    path = written(tmp_path, recording_of_camera(*images, camera(T0, SIZE, FOCAL)), kind)
    log = open_log(path)
    assert (log.n_scans, log.n_beams, log.topic) == (2, 61, "/camera/depth/image_raw")
    np.testing.assert_allclose(log.mount, (0.2, 0.0, 0.0), atol=1e-9)
    assert not log.upside_down
    ends = log.ranges * np.cos(log.angles)  # the wall is straight, across the view
    assert np.isnan(log.ranges).sum(axis=1).max() <= 6  # the column of no reading, and beams between two columns
    left = np.isfinite(ends) & (log.angles > 0.03)
    right = np.isfinite(ends) & (log.angles < -0.03)
    np.testing.assert_allclose(ends[left], 3.0, atol=0.05)
    np.testing.assert_allclose(ends[right], 2.0, atol=0.05)
    np.testing.assert_array_equal(log.ranges[0], log.ranges[1])


def test_images_of_another_size_than_their_camera_are_said(tmp_path: Path) -> None:
    good = image(T0, wall(2000.0))
    bad = image(T0 + TENTH, np.full((8, 6), 2000.0))
    path = written(tmp_path, recording_of_camera(camera(T0, SIZE, FOCAL), good, bad), "mcap")
    log = open_log(path)
    assert log.n_scans == 1
    assert any("an image of 6 × 8 pixels has a CameraInfo for 61 × 41" in note for note in log.notes)


def test_images_without_a_camera_or_a_depth_are_said(tmp_path: Path) -> None:
    path = written(tmp_path, recording_of_camera(image(T0, wall(2000.0))), "mcap")
    with pytest.raises(ReadError, match="no CameraInfo has come on /camera/depth/camera_info"):
        open_log(path)
    path = written(tmp_path, recording_of_camera(image(T0, wall(200.0), "mono8")), "mcap")
    with pytest.raises(ReadError, match=r"it has .*sensor_msgs/Image"):
        open_log(path)


def test_impossible_cuts_are_refused() -> None:
    for change in ({"min_height": 2.0, "max_height": 1.0}, {"angle_min": 1.0, "angle_max": 1.0}, {"scan_height": 0.0}):
        with pytest.raises(ConfigError):
            replace(PlanarCut(), **change)  # type: ignore[arg-type]
