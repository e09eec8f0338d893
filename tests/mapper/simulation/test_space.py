"""Worlds with heights and 3D sensors in them, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.simulation import WORLDS, SensorConfig, World
from mapper.simulation.blocks import Block, lintels, ramp, slab, stairs
from mapper.simulation.lidar import true_ranges
from mapper.simulation.plan_map import plan_map
from mapper.simulation.sensors_3d import SENSOR_3D_PARAMETERS, WALL_HEIGHT, Scan3D, Sensor3D, cast, measure_3d
from mapper.simulation.shapes import outer_walls, rect, wall
from mapper.simulation.worlds import LASER_HEIGHT

LEVELS = WORLDS["levels"]
LOW_TABLE = (4.0, 3.0)  # the middle of its board, 0.21 … 0.25 m high


def room(*blocks: Block) -> World:
    """A room from −5 to 5 m inside its walls."""
    return World("r", "R", (-5.2, -5.2, 5.2, 5.2), tuple(outer_walls(-5.2, -5.2, 5.2, 5.2, 0.2)), (0, 0, 0), blocks)


def along(elevation: float, azimuth: float = 0.0) -> list[list[float]]:
    flat = math.cos(elevation)
    return [[flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)]]


def test_a_ray_meets_sides_tops_bottoms_and_the_ground_where_geometry_says() -> None:
    world = room(slab(rect(2.0, -1.0, 3.0, 1.0), 0.2, 0.5))
    level = [[1.0, 0.0, 0.0]]
    assert cast(world, (0.0, 0.0, 0.3), level, 20.0) == pytest.approx([2.0])
    assert cast(world, (0.0, 0.0, 0.1), level, 20.0) == pytest.approx([5.0])  # below it, to the wall
    assert cast(world, (0.0, 0.0, 0.6), level, 20.0) == pytest.approx([5.0])  # above it
    assert cast(world, (2.5, 0.0, 2.0), [[0.0, 0.0, -1.0]], 20.0) == pytest.approx([1.5])  # its top
    assert cast(world, (2.5, 0.0, 0.1), [[0.0, 0.0, 1.0]], 20.0) == pytest.approx([0.1])  # its bottom
    assert cast(world, (0.0, 0.0, 1.0), along(-math.radians(45)), 20.0) == pytest.approx([math.sqrt(2.0)])  # the ground
    # From 1 m high towards the top's near edge at (2, 0.5): just beyond it, and just before it onto the side.
    assert cast(world, (0.0, 0.0, 1.0), along(-math.atan(0.5 / 2.1)), 20.0) == pytest.approx([math.hypot(2.1, 0.5)])
    assert cast(world, (0.0, 0.0, 1.0), along(-math.atan(0.6 / 2.0)), 20.0) == pytest.approx([math.hypot(2.0, 0.6)])
    assert cast(world, (0.0, 0.0, 1.0), along(0.5), 20.0) == pytest.approx([math.inf])  # over the walls: no ceiling
    assert cast(world, (0.0, 0.0, 0.3), level, 1.9) == pytest.approx([math.inf])


def test_ramps_stairs_and_lintels_have_their_heights() -> None:
    down = [[0.0, 0.0, -1.0]]
    world = room(ramp(3.0, -1.0, 1.0, 1.0, 0.8), *stairs(-3.0, -1.0, -1.0, 1.0, 0.6, 4))
    for x, height in ((2.9, 0.04), (2.0, 0.4), (1.1, 0.76), (-2.9, 0.15), (-2.3, 0.30), (-1.2, 0.6)):
        assert 3.0 - cast(world, (x, 0.0, 3.0), down, 20.0)[0] == pytest.approx(height)
    doors = [(4.0, 5.0)]
    walled = World(
        "w", "W", (-5, -5, 5, 5), tuple(wall((2, -5), (2, 5), 0.2, doors)), (0, 0, 0),
        tuple(lintels((2, -5), (2, 5), 0.2, doors)),
    )  # fmt: skip
    through, into = cast(walled, (0.0, -0.5, 1.0), along(0.0), 20.0), cast(walled, (0.0, -0.5, 2.1), along(0.0), 20.0)
    assert through == pytest.approx([math.inf])
    assert into == pytest.approx([1.9])


def test_the_low_table_is_in_the_way_of_the_3d_lidar_and_of_the_robot_and_not_of_the_flat_one() -> None:
    x, y = LOW_TABLE
    flat = true_ranges(LEVELS, SensorConfig(n_beams=360), (x - 2.0, y, 0.0))
    assert flat[180] > 4.0  # over the table, to what is behind it
    sensor = Sensor3D(noise=0.0)
    ends, origin = Scan3D(
        sensor, measure_3d(LEVELS, sensor, (x - 2.0, y, 0.0), np.random.default_rng(1)), (x - 2.0, y, 0.0), 0.0
    ).ends()
    assert origin == pytest.approx((x - 2.0, y, sensor.mount_height))
    on_top = np.abs(ends - (x, y, 0.25)) < (0.7, 0.4, 1e-6)
    assert on_top.all(axis=1).sum() > 20
    assert not LEVELS.is_free(LOW_TABLE)
    row, col = plan_map(LEVELS).geometry.world_to_cell(LOW_TABLE)
    assert plan_map(LEVELS).log_odds[row, col] < 0.0  # free in the plan of the lidar's plane


def test_the_flat_lidar_meets_a_ramp_where_it_is_as_high_as_its_plane() -> None:
    world = room(ramp(1.0, -1.0, 3.0, 1.0, 0.6))
    ranges = true_ranges(world, SensorConfig(n_beams=360), (0.0, 0.0, 0.0))
    assert ranges[180] == pytest.approx(1.0 + 2.0 * LASER_HEIGHT / 0.6)
    assert cast(world, (0.0, 0.0, LASER_HEIGHT), along(0.0), 20.0) == pytest.approx([ranges[180]])


@pytest.mark.parametrize("name", WORLDS)
def test_the_plane_of_the_flat_lidar_is_that_of_the_world_in_space(name: str) -> None:
    world, sensor = WORLDS[name], SensorConfig(n_beams=120, range_max=12.0)
    angle = sensor.bearings
    rays = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    origin = (*world.start[:2], LASER_HEIGHT)
    flat = true_ranges(world, sensor, (*world.start[:2], 0.0))
    np.testing.assert_allclose(cast(world, origin, rays, 12.0), flat, atol=1e-9)


def test_each_sensor_has_its_beams() -> None:
    lidar = Sensor3D(rings=16, beams=60, noise=0.0, reach=20.0)
    assert lidar.directions.shape == (960, 3)
    elevations = np.arcsin(lidar.directions[:, 2]).reshape(16, 60)
    np.testing.assert_allclose(np.degrees(elevations[:, 0]), np.linspace(-15.0, 15.0, 16))
    scan = measure_3d(room(), lidar, (0.0, 0.0, 0.3), np.random.default_rng(0)).reshape(16, 60)
    # The lowest ring meets the ground before the wall, everywhere at the same range.
    np.testing.assert_allclose(scan[0], lidar.mount_height / math.sin(math.radians(15.0)), rtol=1e-6)
    assert np.isinf(scan[-1, 0]) == (0.6 + 5.0 * math.tan(math.radians(15.0)) > WALL_HEIGHT)
    camera = Sensor3D(sensor="depth_camera", columns=32, tilt=0.0, noise=0.0, mount_height=1.0)
    depth = measure_3d(room(), camera, (0.0, 0.0, 0.0), np.random.default_rng(0)) * camera.directions[:, 0]
    middle = depth.reshape(24, 32)[8:12]
    np.testing.assert_allclose(middle, 5.0, rtol=1e-6)  # a wall across the axis has one depth
    left, right = camera.directions.reshape(24, 32, 3)[12, [0, -1]]
    assert left[1] > 0.0 > right[1]
    assert math.atan2(left[1], left[0]) == pytest.approx(0.5 * camera.view, rel=0.05)
    tilted = Sensor3D(sensor="tilted_lidar", beams=60, tilt=0.5, noise=0.0)
    ahead = measure_3d(room(), tilted, (0.0, 0.0, 0.0), np.random.default_rng(0))[30]
    assert ahead == pytest.approx(tilted.mount_height / math.sin(0.5))


def test_the_image_of_a_depth_camera_has_the_points_of_its_rays() -> None:
    camera = Sensor3D(sensor="depth_camera", columns=32, reach=6.0)
    ranges = measure_3d(room(), camera, (0.3, 0.1, 0.7), np.random.default_rng(0))
    scan = Scan3D(camera, ranges, (0.3, 0.1, 0.7), 0.0)
    image = scan.depth_image()
    assert image is not None
    assert image.depth.shape == (24, 32)
    known = np.isfinite(ranges)
    np.testing.assert_array_equal(image.depth.ravel() > 0.0, known)
    assert 0 < known.sum() < len(known)
    points = image.camera.points(image.depth) @ image.pose[:3, :3].T + image.pose[:3, 3]
    np.testing.assert_allclose(points[known], scan.ends()[0][known], atol=1e-5)
    assert Scan3D(Sensor3D(), ranges, (0.0, 0.0, 0.0), 0.0).depth_image() is None


def test_noise_is_that_of_the_table_and_no_return_stays_none() -> None:
    sensor = Sensor3D(noise=0.05, reach=6.0)
    true = measure_3d(room(), Sensor3D(noise=0.0, reach=6.0), (0.0, 0.0, 0.0), np.random.default_rng(1))
    noisy = measure_3d(room(), sensor, (0.0, 0.0, 0.0), np.random.default_rng(1))
    both = np.isfinite(true) & np.isfinite(noisy)
    assert np.std(noisy[both] - true[both]) == pytest.approx(0.05, rel=0.05)
    assert np.isinf(noisy[np.isinf(true)]).all()
    ends, origin = Scan3D(sensor, noisy, (1.0, 2.0, 0.5), 0.0).ends()
    far = np.linalg.norm(ends - origin, axis=1)
    np.testing.assert_allclose(far[np.isinf(noisy)], 6.6)
    np.testing.assert_allclose(far[np.isfinite(noisy)], noisy[np.isfinite(noisy)], rtol=1e-6)


def test_bad_blocks_rays_and_sensors_are_refused() -> None:
    square = rect(0, 0, 1, 1)
    for outline in (square[::-1], np.array([(0.0, 0.0), (1.0, 0.0)]), np.array([(0, 0), (2, 0), (1, 0.2), (0, 2.0)])):
        with pytest.raises(ConfigError, match="outline must"):
            slab(outline, 0.0, 1.0)
    with pytest.raises(ConfigError, match="above its bottom"):
        slab(square, 1.0, 1.0)
    with pytest.raises(ConfigError, match="above its bottom"):
        Block(square, 0.5, (0.0, 1.0, 0.0))
    with pytest.raises(ConfigError, match="finite"):
        slab(square, 0.0, math.nan)
    with pytest.raises(ConfigError, match="length 1"):
        cast(room(), (0.0, 0.0, 0.0), [[1.0, 1.0, 0.0]], 5.0)
    with pytest.raises(ConfigError, match="origin"):
        cast(room(), (0.0, 0.0, math.nan), [[1.0, 0.0, 0.0]], 5.0)
    with pytest.raises(ConfigError, match="whole"):
        Sensor3D(rings=7.5)  # type: ignore[arg-type]
    for row in SENSOR_3D_PARAMETERS:
        with pytest.raises(ConfigError, match=row.label):
            Sensor3D().with_values({row.name: "no" if row.kind == "choice" else row.high + 1.0})
    with pytest.raises(ConfigError, match="no parameter of the 3D sensor"):
        Sensor3D().with_values({"lens": 1.0})
