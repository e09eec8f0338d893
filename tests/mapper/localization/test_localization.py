"""The filter finds the robot, follows it, and finds it again; the same result on any number of threads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.parallel import single_threaded
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.grid import OccupancyGrid
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.known import known_scans
from mapper.localization.localize import covariance_lines
from mapper.localization.scan_beams import ScanBeams, scan_beams
from mapper.localization.weighing import log_likelihoods, scan_sums
from mapper.sensors.scan import ScanLog, Trajectory
from tests.mapper.localization.rooms import office, two_rooms
from tests.mapper.slam.worlds import without_poses
from tests.marks import also_long

FEW = LocalizationConfig(global_particles=8000)


def errors(log: ScanLog, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    true = log.trajectory("true").poses
    return np.hypot(*(poses - true)[:, :2].T), np.abs(wrap_angle(poses[:, 2] - true[:, 2]))


@pytest.mark.parametrize("model", ["likelihood_field_prob", "likelihood_field", *also_long("beam")])
def test_follows_a_robot_whose_start_is_known(model: str):
    grid, log = office()
    start = log.trajectory("true").poses[0] + [0.2, -0.1, 0.1]
    config = LocalizationConfig(laser_model_type=model, laser_max_beams=30, max_particles=1000, reset_below=0.0)
    found = localize_log(log, grid, config, initial_pose=start)
    off, turned = errors(log, found.poses)
    odometry_off, _ = errors(log, log.trajectory("odometry").poses)
    assert odometry_off[-1] > 0.5
    assert off.max() < 0.5
    assert np.median(off) < 0.15
    assert turned.max() < 0.3
    assert found.is_converged[-1]
    assert found.odometry == "odometry"


def test_finds_a_robot_without_a_hint():
    grid, log = office()
    found = localize_log(log, grid, FEW, seed=1)
    off, _ = errors(log, found.poses)
    assert not found.is_converged[0]
    assert found.first_converged is not None
    assert found.is_converged[-10:].all()
    assert off[-10:].max() < 0.4
    # The covariance tells of it: metres before, decimetres after.
    spread = np.sqrt(found.covariance[:, 0, 0] + found.covariance[:, 1, 1])
    assert spread[0] > 2.0
    assert spread[-1] < 0.5


def test_where_the_filter_never_converges_no_pose_is_known():
    grid, log = office()
    found = localize_log(log.take(slice(0, 2)), grid, FEW, seed=1)
    assert found.first_converged is None
    assert not found.is_known.any()


@pytest.mark.parametrize(
    ("converged", "known"),
    [
        ("00000", "00000"),
        ("00111", "11111"),
        ("11111", "11111"),
        ("01100", "11100"),
        ("00110001", "11110001"),
    ],
)
def test_poses_are_known_where_it_converged_and_before_it_first_did(converged: str, known: str):
    assert known_scans(np.array([*converged]) == "1").tolist() == [one == "1" for one in known]


def test_finds_a_kidnapped_robot_again():
    grid, log = office()
    odometry, true = log.trajectory("odometry").poses, log.trajectory("true").poses
    robot = MonteCarloLocalizer(grid, FEW, range_max=log.range_max, initial_pose=true[0], seed=2)
    for k in range(12):
        robot.update(odometry[k], log.scan(k))
    assert math.hypot(*(robot.estimate.pose - true[11])[:2]) < 0.4
    # Carried to another place: the odometry does not notice.
    jump = 62
    unnoticed = compose(odometry[11], inverse(odometry[jump]))
    assert math.hypot(*(true[jump] - true[11])[:2]) > 4.0
    off = []
    for k in range(jump, log.n_scans):
        found = robot.update(compose(unnoticed, odometry[k]), log.scan(k))
        off.append(math.hypot(*(found.pose - true[k])[:2]))
    assert off[0] > 3.0
    assert max(off[-5:]) < 0.4
    assert found.is_converged


def test_is_the_same_on_one_thread_and_on_several_and_for_another_seed_it_is_not():
    grid, log = office()
    part = log.take(slice(0, 15))
    several = localize_log(part, grid, FEW, seed=5)
    with single_threaded():
        one = localize_log(part, grid, FEW, seed=5)
    np.testing.assert_array_equal(several.poses, one.poses)
    np.testing.assert_array_equal(several.covariance, one.covariance)
    assert (localize_log(part, grid, FEW, seed=6).poses != one.poses).any()


def test_a_robot_that_stands_is_carried_on_by_its_odometry():
    grid, log = office()
    robot = MonteCarloLocalizer(grid, range_max=log.range_max, initial_pose=log.trajectory("true").poses[0])
    first = robot.update((0.0, 0.0, 0.0), log.scan(0))
    second = robot.update((0.1, 0.0, 0.05), log.scan(0))
    assert first.is_updated
    assert not second.is_updated
    assert robot.n_updates == 1
    np.testing.assert_allclose(second.pose, compose(first.pose, (0.1, 0.0, 0.05)), atol=1e-12)


def test_two_equal_rooms_stay_two_clusters():
    grid = two_rooms()
    robot = MonteCarloLocalizer(grid, range_max=8.0)
    robot.set_particles([[1.0, 1.0, 0.0], [4.1, 1.0, 0.0]] * 50, [0.4, 0.6] * 50)
    robot.correct(_no_beams())
    assert not robot.estimate.is_converged
    assert robot.estimate.share == pytest.approx(0.6)
    np.testing.assert_allclose(robot.estimate.pose, [4.1, 1.0, 0.0], atol=1e-9)
    # Around the better one: 0.4 of the weight is 3.1 m away.
    assert robot.estimate.covariance[0, 0] == pytest.approx(0.4 * 3.1**2)
    assert robot.estimate.entropy == pytest.approx(-0.4 * math.log2(0.4) - 0.6 * math.log2(0.6))


def _no_beams() -> ScanBeams:

    return ScanBeams(np.empty((0, 2)), np.empty((0, 2)), np.zeros(2), 8.0)


def test_augmented_mcl_adds_random_particles_once_scans_fit_worse():
    grid, log = office()
    config = LocalizationConfig(recovery_alpha_slow=0.01, recovery_alpha_fast=0.5, reset_below=0.0)
    true = log.trajectory("true").poses
    robot = MonteCarloLocalizer(grid, config, range_max=log.range_max, initial_pose=true[0])
    for k in range(6):
        robot.update(log.trajectory("odometry").poses[k], log.scan(k))
    wide = []
    for k in range(6):
        robot.predict(np.zeros(3), np.array([0.0, 0.0, 0.3]))
        robot.update_beams((k + 100.0, 0.0, 0.0), _beams(log, 30 + k))
        wide.append(np.ptp(robot.particles[:, 0]))
    assert max(wide) > 5.0


def _beams(log: ScanLog, index: int) -> ScanBeams:

    return scan_beams(log.scan(index), log.mount, LocalizationConfig())


def test_a_table_of_how_certain_each_pose_is():
    grid, log = office()
    part = log.take(slice(0, 4))
    found = localize_log(part, grid, FEW)
    lines = covariance_lines(part, found)
    assert len(lines) == 5
    last = dict(zip(lines[0].strip().split(","), lines[-1].strip().split(","), strict=True))
    assert int(last["scan"]) == 3
    assert int(last["stamp_ns"]) == part.stamps_ns[3]
    assert bool(int(last["converged"])) == found.is_converged[3]
    assert float(last["yy"]) == pytest.approx(found.covariance[3, 1, 1], rel=1e-6)


def test_a_localization_can_be_cancelled_and_tells_how_far_it_is():
    grid, log = office()
    shares: list[float] = []
    with pytest.raises(WorkCancelledError):
        localize_log(log, grid, FEW, progress=shares.append, may_continue=lambda: len(shares) < 3)
    assert len(shares) == 3
    assert shares == sorted(shares)


def without(grid: OccupancyGrid, value: float) -> OccupancyGrid:
    grid.log_odds[:] = value
    return grid


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        (without(two_rooms(), 3.0), "The map has no free cells"),
        (without(two_rooms(), -3.0), "The map has no occupied cells"),
        (without(two_rooms(), 0.0), "The map has no free cells"),
    ],
    ids=["all occupied", "all free", "all unknown"],
)
def test_a_map_in_which_no_robot_can_be_found(grid: OccupancyGrid, said: str):
    with pytest.raises(ConfigError, match=said):
        MonteCarloLocalizer(grid)


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        ((100.0, 1.0, 0.0), r"The pose \(100, 1\) m is outside the map, which goes from \(0.05, 0.05\)"),
        ((1.0, math.nan, 0.0), "three finite numbers"),
        ((1.0, 1.0), "three finite numbers"),
    ],
)
def test_a_pose_that_is_not_in_the_map(pose: tuple[float, ...], said: str):
    with pytest.raises(ConfigError, match=said):
        MonteCarloLocalizer(two_rooms(), initial_pose=pose)


@pytest.mark.parametrize(
    ("weights", "said"),
    [([1.0, math.nan], "2 finite numbers"), ([-1.0, 2.0], "none negative"), ([0.0, 0.0], "not all of them 0"),
     ([1.0], "2 finite numbers")],
)  # fmt: skip
def test_weights_that_are_none(weights: list[float], said: str):
    robot = MonteCarloLocalizer(two_rooms())
    before = robot.particles
    with pytest.raises(ConfigError, match=said):
        robot.set_particles(np.ones((2, 3)), weights)
    assert robot.particles is before


def test_particles_and_odometry_that_are_not_finite():
    robot = MonteCarloLocalizer(two_rooms())
    with pytest.raises(ConfigError, match="three finite numbers"):
        robot.set_particles([[0.0, math.inf, 0.0]])
    _, log = office()
    with pytest.raises(ConfigError, match="Odometry must be three finite numbers"):
        robot.update((0.0, math.nan, 0.0), log.scan(0))


def test_a_log_without_odometry():
    grid, log = office()
    with pytest.raises(ConfigError, match="The log has no odometry"):
        localize_log(without_poses(log), grid)


def test_a_log_without_scans():
    grid, log = office()
    with pytest.raises(ConfigError, match="no scans to localize with"):
        localize_log(log.take(slice(0, 0)), grid)


def test_the_odometry_is_the_trajectory_in_a_frame_of_that_name():
    grid, log = office()
    poses = log.trajectory("odometry").poses
    both = replace(log, trajectories={"amcl": Trajectory(poses, "", "map"), "wheels": Trajectory(poses, "", "odom")})
    assert localize_log(both.take(slice(0, 1)), grid, FEW).odometry == "wheels"


def test_a_range_that_leaves_no_reading():
    with pytest.raises(ConfigError, match="No reading is used"):
        MonteCarloLocalizer(two_rooms(), LocalizationConfig(laser_max_range=0.5), range_min=1.0, range_max=8.0)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"z_hit": 0.0, "z_rand": 0.0}, "z_hit and z_rand must not both be 0"),
        ({"min_particles": 3000}, "min_particles, 3000, must be at most max_particles, 2000"),
        ({"recovery_alpha_slow": 0.1, "recovery_alpha_fast": 0.01}, "0 < slow < fast"),
        ({"laser_max_beams": 30.5}, "must be a whole number"),
        ({"laser_min_range": -0.5}, "laser_min_range must be -1 or 0 and more"),
        ({"laser_min_range": 5.0, "laser_max_range": 4.0}, "must be above laser_min_range"),
        ({"sigma_hit": math.nan}, "sigma_hit"),
        ({"sigma": 1.0}, "There is no localization parameter 'sigma'"),
    ],
)
def test_parameters_that_are_impossible(values: dict[str, float], said: str):
    with pytest.raises(ConfigError, match=said):
        LocalizationConfig().with_values(values)


def test_a_filter_that_has_not_converged_gets_particles_where_the_scan_fits():
    grid, log = office()
    odometry, true = log.trajectory("odometry").poses, log.trajectory("true").poses
    off = {}
    for reset_below in (0.85, 0.0):
        config = replace(FEW, reset_below=reset_below)
        robot = MonteCarloLocalizer(grid, config, range_max=log.range_max, seed=3)
        # All particles are in two places, in neither of which the robot is.
        away = true[0] + np.array([[0.0, 3.0, 2.0], [0.0, -3.0, -2.0]])
        robot.set_particles(np.repeat(away, 250, axis=0) + np.random.default_rng(1).normal(0.0, 0.1, (500, 3)))
        for k in range(30):
            found = robot.update(odometry[k], log.scan(k))
        off[reset_below] = math.hypot(*(found.pose - true[29])[:2])
    assert off[0.85] < 0.4 < off[0.0]


def test_many_beams_count_as_fewer_independent_ones():
    grid, log = office()
    pose = log.trajectory("true").poses[:1]
    for model in ("likelihood_field_prob", "beam"):
        logs = {}
        for count in (0, 5, 1000):
            config = LocalizationConfig(laser_model_type=model, laser_max_beams=30, independent_beams=count)
            robot = MonteCarloLocalizer(grid, config, range_max=log.range_max)
            scan = scan_beams(log.scan(0), log.mount, config)
            logs[count] = log_likelihoods(robot.model, scan, pose, scan_sums(robot.model, scan, pose), config)[0]
            n = len(scan.beams if model == "beam" else scan.points)
        assert logs[1000] == logs[0] < logs[5] < 0.0
        assert logs[5] == pytest.approx(logs[0] * 5 / n)
