"""When a filter says that it is sure: drives through simulated worlds whose true poses are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.confidence import (
    CHANGED,
    MOST_UNEXPLAINED,
    SOON,
    WANTED,
    WANTED_IN_CHANGED,
    Confidence,
    unexplained_shares,
)
from mapper.localization.localize import BEFORE_JUMP, confirmed
from mapper.localization.scan_beams import scan_beams
from mapper.sensors.scan import LaserScan, ScanLog
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.lidar import SensorConfig, measure
from mapper.simulation.shapes import outer_walls, wall
from mapper.simulation.worlds import World
from tests.mapper.localization.rooms import model_of, office, two_rooms
from tests.mapper.slam.worlds import SENSOR, along, drive

CONFIG = LocalizationConfig(global_particles=8000)


def equal_rooms() -> tuple[OccupancyGrid, World]:
    """A map of two rooms that are the same turned by half, and its world."""
    grid = two_rooms()
    walls = outer_walls(0.0, 0.0, 6.3, 2.2, 0.1) + wall((3.15, 0.0), (3.15, 2.2), 0.1)
    return grid, World("two", "Two equal rooms", (0.0, 0.0, 6.3, 2.2), tuple(walls), (1.0, 1.0, 0.0))


def test_in_an_office_the_filter_is_sure_after_some_scans_and_right() -> None:
    grid, log = office()
    found = localize_log(log, grid, CONFIG, trajectory="odometry", seed=2)
    off = np.hypot(*(found.poses - log.trajectory("true").poses)[:, :2].T)
    assert found.is_sure[-1]
    assert found.is_sure.mean() > 0.5
    assert off[found.is_sure].max() < 0.5
    assert not found.is_sure[~found.is_converged].any()


def test_in_one_of_two_equal_rooms_it_is_never_sure_however_well_particles_agree() -> None:
    grid, world = equal_rooms()
    path = along([(0.8, 0.7), (2.3, 0.7), (2.3, 1.5), (0.8, 1.5), (0.8, 0.7), (2.3, 0.7), (2.3, 1.5)], 0.25)
    log = drive(world, path, sensor=SensorConfig(n_beams=90, range_max=8.0), turn_bias=0.0)
    found = localize_log(log, model_of(grid), CONFIG, trajectory="odometry", initial_pose=path[0])
    assert found.is_converged.mean() > 0.5
    assert not found.is_sure.any()


def test_a_start_that_the_scans_contradict_is_not_believed() -> None:
    grid, log = office()
    wrong = log.trajectory("true").poses[60]
    robot = MonteCarloLocalizer(grid, CONFIG, range_max=log.range_max, initial_pose=wrong, seed=1)
    found = [robot.update(log.trajectory("odometry").poses[i], log.scan(i)) for i in range(12)]
    off = [math.hypot(*(one.pose - log.trajectory("true").poses[i])[:2]) for i, one in enumerate(found)]
    assert off[0] > 1.0
    assert found[0].is_converged  # as it was told
    assert max(one.contradicted for one, m in zip(found, off, strict=True) if m > 1.0) > 0.05
    assert not any(one.is_sure for one, m in zip(found, off, strict=True) if m > 1.0)


@pytest.fixture
def sure() -> tuple[MonteCarloLocalizer, ScanLog, int]:
    """Return a filter that is sure in the office, its log, and the scan that it is at."""
    grid, log = office()
    robot = MonteCarloLocalizer(grid, CONFIG, range_max=log.range_max, seed=2)
    wheels = log.trajectory("odometry").poses
    for i in range(log.n_scans):
        if robot.update(wheels[i], log.scan(i)).is_sure:
            return robot, log, i
    raise AssertionError("it is never sure")


def test_a_scan_that_is_not_used_tells_that_the_robot_was_carried_away(
    sure: tuple[MonteCarloLocalizer, ScanLog, int],
) -> None:
    robot, log, i = sure
    wheels, true = (log.trajectory(name).poses for name in ("odometry", "true"))
    far = int(np.argmax(np.hypot(*(true - true[i])[:, :2].T)))
    here, elsewhere, back = (robot.update(wheels[i], log.scan(k)) for k in (i, far, i))
    assert not any(found.is_updated for found in (here, elsewhere, back))
    assert (here.is_sure, elsewhere.is_sure, back.is_sure) == (True, False, True)


@pytest.mark.parametrize("turn", [0.0, math.radians(30.0)])
def test_where_the_estimate_jumps_beside_the_odometry_the_place_has_to_be_confirmed_again(
    sure: tuple[MonteCarloLocalizer, ScanLog, int], turn: float
) -> None:
    """The particles and the robot are turned, and the wheels do not notice: the scan fits as well as before."""
    robot, log, i = sure
    wheels, true = (log.trajectory(name).poses for name in ("odometry", "true"))
    robot.particles[:, 2] += turn
    pose = compose(true[i] + [0.0, 0.0, turn], compose(inverse(true[i]), true[i + 1]))
    found = robot.update(wheels[i + 1], measure(WORLDS["office"], SENSOR, pose, np.random.default_rng(1)))
    assert found.is_updated
    assert found.is_converged
    assert found.is_sure == (turn == 0.0)


def test_beams_that_go_on_behind_a_wall_and_such_as_end_before_it_are_not_explained() -> None:
    model = model_of(two_rooms())
    pose = np.array([1.5, 1.0, 0.0])
    wall_at = 3.1 - 1.5

    def shares(reading: float) -> tuple[float, float]:
        scan = LaserScan(np.full(3, reading, dtype=np.float32), -0.05, 0.05, 0.1, 8.0)
        return unexplained_shares(model, scan_beams(scan, (0.0, 0.0, 0.0), LocalizationConfig()), pose)

    assert shares(wall_at) == shares(wall_at + 0.2) == shares(wall_at - 0.2) == (0.0, 0.0)
    assert shares(wall_at + 0.5) == (1.0, 0.0)
    assert shares(wall_at - 0.5) == (0.0, 1.0)
    assert shares(math.nan) == (0.0, 0.0)


def confirms(one: Confidence) -> bool:
    return one.is_confirmed


def test_other_places_must_be_ruled_out_soon_and_one_after_the_other() -> None:
    one = Confidence()
    for _ in range(WANTED):
        assert not confirms(one)
        one.rule_out(1)
    assert confirms(one)
    one.wait(SOON)
    assert confirms(one)
    one.wait(1, 0.1)
    assert not confirms(one)  # the present one explains the scans better
    one.wait()
    assert confirms(one)
    one.wait(SOON + 1)
    assert not confirms(one)
    for _ in range(WANTED):
        one.rule_out(SOON + 1)  # another place explained that many scans nearly as well
    assert not confirms(one)
    for _ in range(WANTED):
        one.rule_out(SOON)
    one.look(1.0, 0.0)
    assert not confirms(one)
    for _ in range(20):
        one.look(0.0, 0.0)
    assert confirms(one)  # people passed by
    one.look(0.0, MOST_UNEXPLAINED + 0.01)
    assert not confirms(one)  # the scan may be of elsewhere
    one.look(0.0, MOST_UNEXPLAINED)
    assert confirms(one)
    one.look(1.0, 0.0)
    one.look(1.0, 0.0)
    for _ in range(10):
        one.look(0.0, 0.0)
    assert not confirms(one)  # it has to be confirmed again


def test_in_a_map_that_is_out_of_date_more_other_places_must_be_ruled_out() -> None:
    one, late = Confidence(), Confidence()
    late.rule_out(1)
    for _ in range(40):
        late.look(2.0 * CHANGED, 0.0)
        one.look(2.0 * CHANGED, 0.0)  # nothing speaks for its place, so that this says nothing of the map
    for place in (one, late):
        place.doubt()
        for _ in range(WANTED):
            place.rule_out(1)
    assert confirms(one)
    for _ in range(WANTED_IN_CHANGED - WANTED):
        assert not confirms(late)
        late.rule_out(1)
    assert confirms(late)


@pytest.mark.parametrize("jump", [None, 20])
def test_what_confirms_a_place_later_confirms_it_for_the_scans_before_up_to_a_jump(jump: int | None) -> None:
    odometry = np.column_stack([np.arange(40) * 0.3, np.zeros(40), np.full(40, 0.1)])
    poses = compose(np.array([5.0, 2.0, 1.0]), odometry)
    if jump is not None:
        poses[jump:] = compose(np.array([-3.0, 0.0, 0.0]), compose(inverse(poses[jump]), poses[jump:]))
    converged = np.arange(40) >= 4
    sure = np.isin(np.arange(40), [12, 18, 30])
    expected = np.zeros(40, dtype=bool)
    if jump is None:
        expected[4:31] = True
    else:  # of the five scans before the jump nothing is sure, and what comes later does not confirm them
        assert jump - BEFORE_JUMP < 18
        expected[4:13] = expected[20:31] = True
    assert confirmed(poses, odometry, converged, sure).tolist() == expected.tolist()
