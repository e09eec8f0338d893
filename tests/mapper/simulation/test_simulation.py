"""The simulation: exploring, driving, teleporting; reproducible with the same seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.simulation import WORLDS, SensorConfig, Simulation
from mapper.simulation.kernels.driving import BRAKING, MAX_ANGULAR, MAX_LINEAR
from mapper.simulation.simulation import ROBOT_RADIUS
from mapper.simulation.worlds import clearance_lattice

SPARSE = SensorConfig(n_beams=30, scan_rate=1.0)


@pytest.mark.parametrize("name", WORLDS)
def test_in_ten_minutes_the_robot_explores_the_world_without_collision(name):
    world = WORLDS[name]
    simulation = Simulation(world, SPARSE, seed=1)
    poses, speeds = [], []
    for _ in range(6000):
        simulation.advance(0.1)
        poses.append(simulation.pose)
        speeds.append((simulation.robot.linear, simulation.robot.angular))
    path = np.array(poses)
    assert world.clearance(path[:, :2]).min() > ROBOT_RADIUS
    lattice = clearance_lattice(world)
    places = lattice.geometry.cell_to_world(np.argwhere(lattice.clearance >= ROBOT_RADIUS))
    nearest = np.full(len(places), np.inf)
    for x, y, _ in path[::5]:
        np.minimum(nearest, np.hypot(places[:, 0] - x, places[:, 1] - y), out=nearest)
    assert (nearest < 1.0).mean() > 0.9
    # It walks, most of the time, no faster than it can, and never jumps.
    linear, angular = np.abs(speeds).T
    assert (linear < 0.05).mean() < 0.15
    assert linear.max() <= MAX_LINEAR
    assert angular.max() <= MAX_ANGULAR
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).max() <= 0.1 * MAX_LINEAR + 1e-9
    assert np.abs(np.diff(linear)).max() <= 0.1 * BRAKING + 1e-9


@pytest.mark.parametrize("name", WORLDS)
def test_a_teleport_into_a_solid_moves_to_free_space_and_is_reported(name):
    world = WORLDS[name]
    simulation = Simulation(world, SPARSE)
    for solid in world.solids:
        x, y = solid[:3].mean(axis=0)  # inside every triangle that the solid's corners make, if convex there
        landing = simulation.teleport(float(x), float(y), 1.0)
        assert world.is_free(landing.pose[:2], ROBOT_RADIUS)
        assert simulation.pose == landing.pose
        assert landing.pose[2] == pytest.approx(1.0)
        if world.clearance((x, y)) < 0.0:
            assert landing.moved
            assert "Inside a wall" in landing.message
            assert f"{np.hypot(landing.pose[0] - x, landing.pose[1] - y):.2f} m" in landing.message


def test_teleports_to_free_outside_tight_and_impossible_places():
    simulation = Simulation(WORLDS["office"], SPARSE)
    heading = simulation.pose[2]
    free = simulation.teleport(7.0, 7.0)
    assert not free.moved
    assert free.pose == (7.0, 7.0, heading)
    outside = simulation.teleport(-5.0, 7.0)
    assert outside.moved
    assert "Outside the map" in outside.message
    assert simulation.world.is_free(outside.pose[:2], ROBOT_RADIUS)
    tight = simulation.teleport(7.0, 7.9)
    assert tight.moved
    assert "Too tight" in tight.message
    assert simulation.world.is_free(simulation.teleport(1e300, -1e300).pose[:2], ROBOT_RADIUS)
    before = simulation.pose
    for x, y, yaw in ((np.nan, 1.0, None), (1.0, np.inf, None), (1.0, 1.0, np.nan)):
        with pytest.raises(ConfigError, match="finite"):
            simulation.teleport(x, y, yaw)
    assert simulation.pose == before


@pytest.mark.parametrize("name", WORLDS)
def test_after_a_teleport_anywhere_the_robot_walks_on(name):
    world = WORLDS[name]
    rng = np.random.default_rng(8)
    x0, y0, x1, y1 = world.bounds
    simulation = Simulation(world, SPARSE)
    for _ in range(8):
        landing = simulation.teleport(rng.uniform(x0, x1), rng.uniform(y0, y1), rng.uniform(-3.0, 3.0))
        walked = 0.0
        for _ in range(24):
            before = simulation.pose
            simulation.advance(0.5)
            walked += np.hypot(simulation.pose[0] - before[0], simulation.pose[1] - before[1])
        assert walked > 1.5, landing


@settings(max_examples=15)
@given(
    st.sampled_from(sorted(WORLDS)),
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.integers(1, 40)), min_size=1, max_size=12),
)
def test_driven_by_hand_into_anything_the_robot_never_enters_it(name, commands):
    simulation = Simulation(WORLDS[name], SPARSE)
    for linear, angular, ticks in commands:
        simulation.drive(linear, angular)
        for _ in range(ticks):
            simulation.advance(1 / 30)
            assert simulation.world.is_free(simulation.robot.pose[:2], ROBOT_RADIUS)
            # What is shown between two steps lies on the chord of an arc, which cuts a corner by less than v²·t²/8r.
            assert simulation.world.is_free(simulation.pose[:2], ROBOT_RADIUS - 5e-4)
    assert not simulation.auto


def test_a_velocity_command_expires_after_half_a_second():
    simulation = Simulation(WORLDS["hall"], SPARSE)
    simulation.teleport(5.0, 8.0, 0.0)
    simulation.drive(0.5, 0.0)
    assert not simulation.auto
    simulation.advance(0.48)
    assert simulation.robot.linear == pytest.approx(0.5)
    simulation.advance(1.0)
    assert simulation.robot.linear == 0.0
    halted = simulation.pose
    # Speeding up at 1.2 m/s², 0.5 s in all, braking at 2 m/s²: 0.25 − 0.5²/2.4 + 0.5²/4 metres, to a step or two.
    assert halted[0] - 5.0 == pytest.approx(0.25 - 0.25 / 2.4 + 0.25 / 4, abs=0.02)
    simulation.advance(2.0)
    assert simulation.pose == halted
    simulation.auto = True
    simulation.advance(5.0)
    assert np.hypot(simulation.pose[0] - halted[0], simulation.pose[1] - halted[1]) > 0.5


def test_driving_slides_along_a_wall():
    simulation = Simulation(WORLDS["loop"], SPARSE)
    simulation.teleport(10.0, 0.6, -0.5)  # towards the south wall, whose face is y = 0.2
    for _ in range(6):
        simulation.drive(0.8, 0.0)
        simulation.advance(0.4)
    assert simulation.pose[1] == pytest.approx(0.2 + ROBOT_RADIUS, abs=0.01)
    assert simulation.pose[0] > 10.8


def test_driving_straight_into_a_wall_stops():
    simulation = Simulation(WORLDS["loop"], SPARSE)
    simulation.teleport(10.0, 0.6, -np.pi / 2)
    for _ in range(6):
        simulation.drive(0.8, 0.0)
        simulation.advance(0.4)
    assert simulation.pose[:2] == pytest.approx((10.0, 0.2 + ROBOT_RADIUS), abs=0.01)
    assert abs(simulation.robot.linear) < 0.1


def test_scans_have_the_sensors_rate_and_the_robots_pose():
    mount = (0.1, 0.05, 0.3)
    simulation = Simulation(WORLDS["office"], SensorConfig(n_beams=60, scan_rate=5.0, range_noise=0.0), mount=mount)
    taken = [pair for _ in range(300) for pair in simulation.advance(1 / 30)]
    assert len(taken) == 50
    stamps = np.array([scan.stamp_ns for scan, _ in taken])
    np.testing.assert_allclose(np.diff(stamps), 0.2e9, atol=1.0)
    assert simulation.time == pytest.approx(10.0)
    np.testing.assert_allclose(simulation.sensor_pose, compose(simulation.pose, mount))
    # Every reading ends on a solid's face, seen from the mount on the robot.
    for scan, pose in taken[::10]:
        laser = compose(pose, mount)
        hit = np.isfinite(scan.ranges)
        angle = laser[2] + scan.angles[hit]
        ends = laser[:2] + scan.ranges[hit, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        np.testing.assert_allclose(simulation.world.clearance(ends), 0.0, atol=1e-5)


def test_the_same_seed_gives_the_same_run_with_any_time_step():
    def run(seed: int, cuts: list[float]) -> tuple[np.ndarray, np.ndarray]:
        simulation = Simulation(WORLDS["office"], SensorConfig(n_beams=45), seed)
        taken = [pair for dt in cuts for pair in simulation.advance(dt)]
        return np.array([pose for _, pose in taken]), np.array([scan.ranges for scan, _ in taken])

    poses, ranges = run(3, [20.0])
    again, ranges_again = run(3, [1 / 32] * 640)
    np.testing.assert_array_equal(poses, again)
    np.testing.assert_array_equal(ranges, ranges_again)
    other, _ = run(4, [20.0])
    assert not np.array_equal(poses, other)


def test_a_change_of_sensor_changes_the_scans_and_not_the_way():
    plain, changed = (Simulation(WORLDS["maze"], SPARSE, seed=2) for _ in range(2))
    changed.set_sensor(SensorConfig(n_beams=120, scan_rate=20.0))
    taken = changed.advance(20.0)
    plain.advance(20.0)
    assert plain.pose == changed.pose
    assert len(taken) == 400
    assert {len(scan.ranges) for scan, _ in taken} == {120}


def test_a_faster_scan_rate_takes_effect_immediately():
    simulation = Simulation(WORLDS["maze"], SPARSE)
    simulation.advance(0.1)
    simulation.set_sensor(SensorConfig(scan_rate=20.0))
    assert len(simulation.advance(0.2)) == 4


def test_motion_between_frames_is_even():
    """At 30 frames a second a step of physics more or less in a frame must not show."""
    simulation = Simulation(WORLDS["loop"], SPARSE)
    simulation.advance(2.0)
    places = []
    for _ in range(30):
        simulation.advance(1 / 30)
        places.append(simulation.pose[:2])
    steps = np.hypot(*np.diff(places, axis=0).T)
    assert np.abs(np.diff(steps)).max() < 0.1 * steps.mean()


def test_impossible_arguments_are_refused():
    for dt in (-0.1, np.nan, np.inf):
        with pytest.raises(ConfigError, match="Time"):
            Simulation(WORLDS["room"]).advance(dt)
    for bad in ((np.nan, 0.0), (0.0, np.inf)):
        with pytest.raises(ConfigError, match="Velocities"):
            Simulation(WORLDS["room"]).drive(*bad)
    with pytest.raises(ConfigError, match="mount"):
        Simulation(WORLDS["room"], mount=(0.0, np.nan, 0.0))
    with pytest.raises(ConfigError, match="radius"):
        Simulation(WORLDS["room"], radius=0.0)
