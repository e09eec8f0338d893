"""Sensors that move on the robot: panning and tilting lidars and clouds, in a room whose walls are known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

from mapper.core.se2 import compose, transform_points
from mapper.grid import OccupancyGrid
from mapper.io.export import write_mcap
from mapper.io.logs import open_log
from mapper.io.logs.opening import open_robot_log
from mapper.io.logs.selection import Selection
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.planar import textbook
from mapper.sensors.planar.cloud import Placement, cut_tilted
from mapper.sensors.planar.options import PlanarCut
from tests.mapper.io.logs.recorded import KINDS, SECOND, Said, cloud, odometry, scan, transform, written

ROOM = np.array([[-3.0, -2.0, 0.0], [3.0, 2.0, 2.5]])  #: corners, metres
T0, STEP = 1_600_000_000 * SECOND, SECOND // 10
BEARINGS = -math.pi + 0.02 + 0.05 * np.arange(125)
HEIGHT = 1.0


def to_the_room(place: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Distances (n,) from a place in the room to its walls, floor or ceiling, along unit vectors (n, 3)."""
    with np.errstate(divide="ignore"):
        distances = (np.where(directions > 0.0, ROOM[1], ROOM[0]) - place) / directions
    return np.asarray(np.nanmin(np.where(np.isfinite(distances), distances, np.nan), axis=1))


def seen(x: float, mount: tuple[float, float], yaw: float, roll: float) -> np.ndarray:
    """Ranges of a lidar whose base stands at (x, 0, 0): at ``mount`` on it, turned by yaw, then rolled about its x."""
    rays = np.stack([np.cos(BEARINGS), np.sin(BEARINGS), np.zeros(len(BEARINGS))], axis=1)
    turned = Rotation.from_euler("ZX", [yaw, roll]).apply(rays)
    return to_the_room(np.array([x + mount[0], mount[1], HEIGHT]), turned)


def run(n: int = 24, *, rolls: bool = False) -> list[Said]:
    """A robot that drives ahead with a lidar that pans by ±1 rad, or rolls by ±0.4 rad: tf twice as often as scans."""
    said = []
    for i in range(2 * n):
        at, swing = T0 + i * STEP // 2, math.sin(0.3 * i)
        yaw, roll = (0.5, 0.4 * swing) if rolls else (swing, 0.0)
        said.append(odometry(at, 0.01 * i, 0.0, 0.0))
        said.append(transform(at, "base_link", "laser", 0.2, 0.1 * (not rolls), yaw, roll, z=HEIGHT))
        if i % 2 == 0:
            ranges = seen(0.01 * i, (0.2, 0.1 * (not rolls)), yaw, roll)
            said.append(scan(at, ranges, angles=(float(BEARINGS[0]), 0.05), limits=(0.05, 20.0)))
    return said


def off_the_walls(path: Path) -> np.ndarray:
    """Distances of the occupied cells of a log's map from the walls, metres."""
    log = open_log(path)
    config = MappingConfig(resolution=0.05)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    x, y = grid.geometry.cell_to_world(np.argwhere(grid.p_occ > 0.65)).T
    return np.asarray(np.minimum(np.abs(np.abs(x) - 3.0), np.abs(np.abs(y) - 2.0)))


@pytest.mark.parametrize("kind", KINDS)
def test_each_scan_of_a_panning_lidar_has_the_mount_at_its_stamp(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path, run(), kind)
    log = open_log(path)
    assert log.mounts is not None
    expected = [(0.2, 0.1, math.sin(0.3 * i)) for i in range(0, 48, 2)]
    np.testing.assert_allclose(log.mounts, expected, atol=1e-9)
    assert log.mount == tuple(log.mounts[0])
    assert any(
        "'laser' moves on the robot, by up to 0.00 m and 57°; each scan has the mount" in note for note in log.notes
    )
    ends = [
        transform_points(pose, np.stack([r * np.cos(BEARINGS), r * np.sin(BEARINGS)], axis=1))
        for pose, r in zip(log.sensor_poses(), log.ranges.astype(np.float64), strict=True)
    ]
    x, y = np.abs(np.concatenate(ends)).T
    assert np.minimum(np.abs(x - 3.0), np.abs(y - 2.0)).max() < 1e-4
    assert off_the_walls(path).max() < 0.06


def test_a_panning_lidar_maps_as_a_fixed_one_on_a_base_that_turns(tmp_path: Path) -> None:
    """Independently of how mounts are used: the same scans with all motion in the poses."""
    log = open_log(written(tmp_path, run(), "bag"))
    assert log.mounts is not None
    mounts = log.mounts
    moved = {name: replace(one, poses=compose(one.poses, mounts), timed=None) for name, one in log.trajectories.items()}
    fixed = replace(log, mounts=None, mount=(0.0, 0.0, 0.0), trajectories=moved)
    config = MappingConfig(mount_yaw=0.3, mount_x=0.1)
    maps = []
    for one in (log, fixed):
        grid = OccupancyGrid(geometry_for(one, config))
        integrate_log(grid, one, config)
        maps.append(grid.log_odds)
    np.testing.assert_array_equal(maps[0], maps[1])
    some = log.take(np.array([3, 7]))
    assert some.mounts is not None
    np.testing.assert_array_equal(some.mounts, log.mounts[[3, 7]])


def test_deskewed_beams_have_the_mount_of_their_scan(tmp_path: Path) -> None:
    log = replace(open_log(written(tmp_path, run(), "bag")), time_increment=1e-4)
    config = MappingConfig()
    whole = OccupancyGrid(geometry_for(log, config))
    integrate_log(whole, log, config)
    one_by_one = OccupancyGrid(whole.geometry)
    assert log.mounts is not None
    for t, mount in enumerate(log.mounts.tolist()):
        integrate_log(one_by_one, replace(log, mounts=None, mount=tuple(mount)), config, None, t, t + 1)
    np.testing.assert_array_equal(whole.log_odds, one_by_one.log_odds)


def test_a_tilting_lidar_is_cut_by_heights_so_that_floor_and_ceiling_are_no_walls(tmp_path: Path) -> None:
    path = written(tmp_path, run(rolls=True), "mcap")
    cut = PlanarCut(min_height=0.1, max_height=2.4, angle_increment=0.05)
    log = open_robot_log(path, selection=Selection((), cut)).first
    assert any("The sensor tilts by 0° to 23°: each scan is cut to a level one" in note for note in log.notes)
    assert log.mounts is None, "it tilts in one place"
    assert (log.mount, log.n_beams) == ((0.2, 0.0, 0.0), cut.n_beams)
    hit = np.isfinite(log.ranges)
    assert hit.mean() > 0.5
    assert np.isposinf(log.ranges).any(), "directions in which only the floor was seen"
    poses, (rows, beams) = log.sensor_poses(), np.nonzero(hit)
    bearing = log.angles[beams]
    x = poses[rows, 0] + log.ranges[hit] * np.cos(bearing)
    y = poses[rows, 1] + log.ranges[hit] * np.sin(bearing)
    off = np.minimum(np.abs(np.abs(x) - 3.0), np.abs(np.abs(y) - 2.0))
    # A point counts in the middle of its sector: at 4 m half a sector is 0.1 m.
    assert off.max() < 0.15
    floor = open_robot_log(path, selection=Selection((), PlanarCut(min_height=-1.0, max_height=0.05))).first
    assert np.isfinite(floor.ranges).any()


def test_cutting_tilted_scans_is_cutting_the_points_of_each(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    cut = PlanarCut(min_height=0.2, max_height=1.5, angle_min=-2.0, angle_increment=0.07, cloud_range=(0.3, 8.0))
    ranges = rng.uniform(0.1, 12.0, (6, 40)).astype(np.float32)
    ranges[0, :3] = [np.nan, np.inf, -np.inf]
    bearings = np.linspace(-1.5, 2.0, 40)
    rotations = Rotation.random(6, random_state=3).as_matrix()
    translations = rng.normal(0.0, 1.0, (6, 3))
    found = cut_tilted(ranges, bearings, (0.2, 10.0), rotations, translations, cut)
    for i in range(6):
        points = [
            (r * math.cos(b), r * math.sin(b), 0.0)
            for r, b in zip(ranges[i].astype(np.float64).tolist(), bearings.tolist(), strict=True)
            if 0.2 <= r <= 10.0
        ]
        expected = textbook.cut_cloud(np.array(points), Placement(rotations[i], translations[i]), cut)
        np.testing.assert_array_equal(found[i], expected)


@pytest.mark.parametrize("late", [0, 3])
def test_each_cloud_of_a_moving_frame_is_cut_where_it_was_at_its_stamp(tmp_path: Path, late: int) -> None:
    """Transforms come after the clouds that they are for, some of them much later."""
    rng = np.random.default_rng(2)
    points = rng.uniform(-4.0, 4.0, (300, 3)).astype(np.float32).astype(np.float64)
    cut = PlanarCut(angle_increment=0.1, min_height=-1.0, max_height=1.0)
    said = [transform(T0, "base_link", "mast", 0.5, topic="/tf_static"), transform(T0, "mast", "velodyne")]
    expected, mounts, waiting = [], [], []
    for i in range(10):
        at, x, yaw = T0 + i * STEP, 0.1 * i, 0.2 * i
        said += [odometry(at, 0.0, 0.0, 0.0), cloud(at, points)]
        waiting.append(transform(at, "mast", "velodyne", x, 0.0, yaw))
        if len(waiting) > late:
            said.append(waiting.pop(0))
        turn = Rotation.from_euler("z", yaw).as_matrix()
        expected.append(textbook.cut_cloud(points, Placement(turn, np.array([0.5 + x, 0.0, 0.0])), cut))
        mounts.append((0.5 + x, 0.0, 0.0))
    for i, one in enumerate([*said, *waiting]):
        one.stamp_ns = T0 + i  # the order in the file
    log = open_robot_log(written(tmp_path, [*said, *waiting], "mcap"), selection=Selection((), cut)).first
    assert log.mounts is not None
    np.testing.assert_allclose(log.mounts, mounts, atol=1e-9)
    np.testing.assert_allclose(log.ranges, expected, atol=1e-5)


def test_a_moving_mount_is_exported_at_each_scan(tmp_path: Path) -> None:
    log = open_log(written(tmp_path, run(), "bag"))
    path = tmp_path / "out.mcap"
    with path.open("wb") as file:
        write_mcap(file, log)
    turns = []
    with AnyReader([path]) as reader:
        assert "/tf_static" not in {one.topic for one in reader.connections}
        for connection, _, data in reader.messages():
            if connection.topic == "/tf":
                message: Any = reader.deserialize(data, connection.msgtype)
                (edge,) = message.transforms
                if edge.child_frame_id == "laser":
                    turns.append(2.0 * math.atan2(edge.transform.rotation.z, edge.transform.rotation.w))
    assert log.mounts is not None
    np.testing.assert_allclose(turns, log.mounts[:, 2], atol=1e-9)
    again = open_log(path)
    assert again.mounts is not None
    np.testing.assert_allclose(again.mounts, log.mounts, atol=1e-9)


def test_a_mount_that_was_never_stated_for_some_scans_is_noted(tmp_path: Path) -> None:
    said = [one for one in run() if one.kind != "tf2_msgs/msg/TFMessage" or one.stamp_ns < T0 + 2 * SECOND]
    notes = open_log(written(tmp_path, said, "bag")).notes
    assert any("scans are before the first or after the last transform of the moving sensor" in note for note in notes)
