"""Faults: odometry drift and specular reflection, both recorded together with the true values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.simulation import WORLDS, Faults, Recording, SensorConfig, World
from mapper.simulation.faults import SPECULAR_ANGLE, lengthened, polished_faces, reflected_away, with_lengthened
from mapper.simulation.lidar import measure, true_ranges
from mapper.simulation.odometry import Odometer
from mapper.simulation.shapes import outer_walls, rect

SENSOR = SensorConfig(n_beams=360)
ANGLES = SENSOR.angle_min + SENSOR.angle_increment * np.arange(360)
# Inside 8 m × 6 m, walls 0.2 m thick, and a small post whose faces are too short to be polished.
HALL = World(
    "hall", "Hall", (0.0, 0.0, 8.0, 6.0), (*outer_walls(0.0, 0.0, 8.0, 6.0, 0.2), rect(5.0, 3.0, 5.3, 3.3)),
    (2.0, 2.0, 0.0),
)  # fmt: skip


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.9])
def test_a_beam_is_reflected_away_at_a_grazing_angle(yaw: float) -> None:
    x, y = 2.0, 2.0
    ranges = true_ranges(HALL, SENSOR, (x, y, yaw))
    lost = reflected_away(HALL, ranges, ANGLES, (x, y, yaw))
    for angle, reading, gone in zip(ANGLES + yaw, ranges, lost, strict=True):
        # By hand: which of the four inner faces the beam ends on, and how far off its normal.
        ex, ey = x + reading * math.cos(angle), y + reading * math.sin(angle)
        on_x = abs(ex - 0.2) < 1e-6 or abs(ex - 7.8) < 1e-6
        on_y = abs(ey - 0.2) < 1e-6 or abs(ey - 5.8) < 1e-6
        incidence = math.acos(min(1.0, abs(math.cos(angle) if on_x else math.sin(angle))))
        if abs(incidence - SPECULAR_ANGLE) > 1e-9 and on_x != on_y:
            assert gone == (incidence > SPECULAR_ANGLE), (math.degrees(angle), reading)
        if not (on_x or on_y):
            assert not gone  # the post
    assert 100 < lost.sum() < 200  # by the closed form each wall keeps the 60° before it


def test_readings_without_return_are_not_reflected_away() -> None:
    short = SensorConfig(range_max=1.0)
    ranges = true_ranges(HALL, short, (4.0, 3.0, 0.0))
    assert np.isinf(ranges).sum() > 100
    assert not reflected_away(HALL, ranges, ANGLES, (4.0, 3.0, 0.0))[np.isinf(ranges)].any()


def test_every_world_has_polished_walls_and_some_that_are_not() -> None:
    for world in WORLDS.values():
        faces = polished_faces(world)
        assert 4 <= len(faces) < len(world.segments)


def echo_in(x: float, y: float, low: float, high: float) -> float:
    """Echo in a cone in the hall between two bearings: ray by ray, each against the post, then the four walls."""
    nearest = math.inf
    for bearing in np.linspace(low, high, 1 + round((high - low) / math.radians(0.02))):
        dx, dy = math.cos(bearing), math.sin(bearing)
        enter_x, leave_x = sorted(((5.0 - x) / dx, (5.3 - x) / dx))
        enter_y, leave_y = sorted(((3.0 - y) / dy, (3.3 - y) / dy))
        if 0.0 < max(enter_x, enter_y) < min(leave_x, leave_y):
            echo = max(enter_x, enter_y)
        else:
            to_x, to_y = ((7.8 if dx > 0 else 0.2) - x) / dx, ((5.8 if dy > 0 else 0.2) - y) / dy
            off_normal = math.acos(abs(dx)) if to_x < to_y else math.acos(abs(dy))
            echo = min(to_x, to_y) if off_normal <= SPECULAR_ANGLE else math.inf
        nearest = min(nearest, echo)
    return nearest


@pytest.mark.parametrize("width", [0.35, 0.8])
@pytest.mark.parametrize("pose", [(2.0, 2.0, 0.013), (4.2, 2.3, 0.27), (1.0, 5.0, -2.2)])
def test_a_sonar_measures_the_nearest_reflecting_surface(pose: tuple[float, float, float], width: float) -> None:
    ring = SensorConfig(kind="sonar_ring", n_sonars=24, beam_width=width, range_max=12.0)
    true = true_ranges(HALL, ring, pose)
    heard = true + lengthened(HALL, ring, pose)
    x, y, yaw = pose
    expected = np.array([echo_in(x, y, yaw + b - width / 2, yaw + b + width / 2) for b in ring.bearings])
    # Rays a degree apart miss at most the last one before the edge of what is heard.
    np.testing.assert_allclose(heard, expected, rtol=0.025)
    lost, farther = np.isinf(heard), (heard > 1.05 * true) & np.isfinite(heard)
    assert (lost.sum() >= 2) or width > 0.5
    assert np.isclose(heard, true).sum() >= 8
    assert farther.any() or (pose, width) != ((4.2, 2.3, 0.27), 0.8)


def test_readings_that_get_too_long_do_not_return() -> None:
    ranges = np.array([1.0, 2.0, 3.0, np.inf], dtype=np.float32)
    before = ranges.copy()
    longer = np.array([0.0, 1.5, 2.5, 0.0], dtype=np.float16)
    assert with_lengthened(ranges, longer, 5.0).tolist() == [1.0, 3.5, math.inf, math.inf]
    np.testing.assert_array_equal(ranges, before)


def test_a_lidars_beams_return_as_they_are_or_not_at_all() -> None:
    pose = (2.0, 2.0, 0.3)
    longer = lengthened(HALL, SENSOR, pose)
    lost = reflected_away(HALL, true_ranges(HALL, SENSOR, pose), ANGLES, pose)
    assert 100 < lost.sum() < 200
    np.testing.assert_array_equal(longer, np.where(lost, np.inf, 0.0))


def test_wheels_without_faults_report_the_truth() -> None:
    odometer = Odometer((1.0, 2.0, 0.5), np.random.default_rng(0), (0.0, 0.0, 0.0, 0.0), 0.0)
    for pose in ((1.5, 2.2, 0.7), (1.4, 2.1, -3.0), (1.4, 2.1, 3.1), (9.0, -3.0, 0.0)):
        assert odometer.move(pose) == pytest.approx(pose)


def test_a_bias_bends_a_straight_way_into_a_circle() -> None:
    odometer = Odometer((0.0, 0.0, 0.0), np.random.default_rng(0), (0.0, 0.0, 0.0, 0.0), 0.1)
    for i in range(1, 1001):
        pose = odometer.move((0.01 * i, 0.0, 0.0))
    # 10 m along a circle of radius 1 / 0.1 rad/m: the closed form of the arc.
    assert pose == pytest.approx((10.0 * math.sin(1.0), 10.0 * (1.0 - math.cos(1.0)), 1.0), abs=0.02)
    odometer.place((0.0, 0.0, 0.0))
    assert odometer.move((0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)


def test_the_same_seed_drifts_the_same_way() -> None:
    ways = []
    for seed in (1, 1, 2):
        odometer = Odometer((0.0, 0.0, 0.0), np.random.default_rng(seed))
        ways.append([odometer.move((0.1 * i, 0.05 * i, 0.1 * i)) for i in range(50)])
    assert ways[0] == ways[1] != ways[2]


def test_a_recording_has_true_and_faulty_values() -> None:
    sensor = SensorConfig(n_beams=30)
    recording = Recording(sensor, capacity=40)
    rng = np.random.default_rng(5)
    for i in range(200):
        scan = measure(HALL, sensor, (2.0 + 0.01 * i, 2.0, 0.0), rng)
        longer = np.where(np.arange(30) == i % 30, np.inf, 0.0).astype(np.float16)
        recording.append(scan, (2.0 + 0.01 * i, 2.0, 0.0), (3.0 + 0.01 * i, 2.5, 0.1), longer)
    honest, faulty = recording.as_log(), recording.as_log(specular=True)
    assert recording.generation > 0
    true, odometry = (honest.trajectory(name).poses for name in ("true", "odometry"))
    np.testing.assert_allclose(odometry - true, np.tile([1.0, 0.5, 0.1], (len(true), 1)))
    numbers = np.round((true[:, 0] - 2.0) / 0.01).astype(int)
    assert np.isinf(faulty.ranges).sum() == honest.n_scans
    assert np.isinf(faulty.ranges[np.arange(len(numbers)), numbers % 30]).all()
    assert np.isfinite(honest.ranges).all()


@pytest.mark.parametrize(
    ("values", "code"), [({"drift": 1}, "parameter.drift"), ({"glass": True}, "parameter.unknown")]
)
def test_faults_are_true_or_false(values: dict[str, object], code: str) -> None:
    with pytest.raises(ConfigError) as error:
        Faults().with_values(values)
    assert error.value.code == code


def test_the_trajectory_that_the_map_is_made_with() -> None:
    assert Faults().trajectory == "true"
    assert Faults(drift=True).trajectory == "odometry"
