"""An alternative elsewhere in the map: the errors of the test that decides, and a robot in the other of two rooms."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from mapper.core.se2 import between_one, compose
from mapper.grid import OccupancyGrid
from mapper.localization import LocalizationConfig, MonteCarloLocalizer
from mapper.localization.estimate import Estimate
from mapper.localization.recovery import ERROR, LIMIT, MOST_SCANS, Alternative, near
from mapper.localization.scan_beams import ScanBeams
from tests.mapper.localization.rooms import two_rooms

NOWHERE = ScanBeams(np.empty((0, 2)), np.empty((0, 2)), np.zeros(2), 8.0)
RANGES = np.arange(0.1, 6.0, 0.02)
CONFIG = LocalizationConfig(global_particles=8000, max_particles=1000)


class Scripted:
    """A filter whose evidence is written down."""

    def __init__(self, evidence: Iterator[float], pose: tuple[float, float, float] = (9.0, 9.0, 0.0)) -> None:
        self.particles, self.weights = np.array([pose]), np.ones(1)
        self.estimate = Estimate(np.array(pose), np.eye(3), True, 1.0, 1.0, 0.0, 1, True)
        self._evidence = evidence
        self.log_evidence = 0.0

    def predict(self, before: np.ndarray, after: np.ndarray) -> None:
        pass

    def correct(self, scan: ScanBeams) -> None:
        self.log_evidence = next(self._evidence)


HERE = Scripted(iter(()), (0.0, 0.0, 0.0)).estimate


def decided(alternative: Alternative) -> str:
    while True:
        alternative.correct(NOWHERE, 0.0)
        if alternative.has_won:
            return "won"
        if alternative.has_lost(HERE):
            return "lost"


@pytest.mark.parametrize("right", ["won", "lost"])
def test_the_test_errs_as_rarely_as_it_says(right: str) -> None:
    # The logarithm of the ratio of two normal densities with means ±d/2 apart is normal, of mean ±d²/2, variance d².
    rng, d, n = np.random.default_rng(4), 0.8, 6000
    sign = 1.0 if right == "won" else -1.0
    wrong, scans = 0, []
    for _ in range(n):
        alternative = Alternative(Scripted(iter(rng.normal(sign * d * d / 2, d, 500))))
        wrong += decided(alternative) != right
        scans.append(alternative.n_scans)
    late = sum(count >= MOST_SCANS for count in scans)
    assert wrong <= late + n * ERROR + 4 * math.sqrt(n * ERROR)
    # Wald's mean number of scans; the sum passes the limit by less than d on average.
    assert LIMIT / (d * d / 2) * 0.95 < np.mean(scans) < (LIMIT + d) / (d * d / 2)


def test_a_rival_ends_where_the_filter_is_and_after_scans_that_do_not_decide() -> None:
    same = Alternative(Scripted(iter([0.0] * 9), (0.5, 0.5, 0.2)))
    assert decided(same) == "lost"
    assert same.n_scans == 1
    equal = Alternative(Scripted(iter([0.0] * 999)))
    assert decided(equal) == "lost"
    assert equal.n_scans == MOST_SCANS


def test_near_is_a_metre_and_forty_degrees() -> None:
    poses = [[0.0, 0.0, 0.0], [0.9, 0.0, 3.1], [0.0, 1.1, 0.0], [0.0, 0.0, 0.69], [0.0, 0.0, 0.71]]
    assert near(np.array(poses), np.zeros(3)).tolist() == [True, False, False, True, False]
    assert near(np.array([[0.0, 0.0, 3.1]]), np.array([0.0, 0.0, -3.1])).all()


def rooms_of_which_one_has_a_box() -> OccupancyGrid:
    grid = two_rooms()
    grid.log_odds[1:7, 54:62] = 3.0  # 0.8 m × 0.6 m, in a corner of the right room
    return grid


def seen(grid: OccupancyGrid, pose: np.ndarray) -> ScanBeams:
    """Readings of 30 beams from a pose, by steps of 2 cm."""
    bearings = np.linspace(-np.pi, np.pi, 30, endpoint=False)
    points = RANGES[:, np.newaxis, np.newaxis] * np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    rows, cols = np.moveaxis(grid.geometry.world_to_cell(compose_points(pose, points)), -1, 0)
    hit = grid.log_odds[rows.clip(0, 21), cols.clip(0, 62)] > 0.0
    ranges = RANGES[np.argmax(hit, axis=0)]
    ends = ranges[:, np.newaxis] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return ScanBeams(ends, np.column_stack([ranges, bearings]), np.zeros(2), 8.0)


def compose_points(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    turned: np.ndarray = points @ np.array([[c, s], [-s, c]]) + pose[:2]
    return turned


def last_error(start: list[float], believed: list[float], reset_below: float, seed: int) -> float:
    """The distance of the estimate after the robot has driven round in its room, metres."""
    grid = rooms_of_which_one_has_a_box()
    config = CONFIG.with_values({"reset_below": reset_below})
    robot = MonteCarloLocalizer(grid, config, range_max=8.0, initial_pose=believed, seed=seed)
    true, odometry = np.array(start), np.zeros(3)
    for _ in range(30):
        step = np.array([0.25, 0.0, 0.4])  # a circle of 0.6 m
        true, odometry = compose(true, step), compose(odometry, step)
        robot.update_beams(odometry, seen(grid, true))
    moved = between_one(tuple(robot.estimate.pose), tuple(true))
    return math.hypot(moved[0], moved[1])


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_in_the_other_of_two_nearly_equal_rooms_is_found(seed: int) -> None:
    left, right = [1.5, 0.4, 0.0], [4.6, 0.4, 0.0]
    # Scans of the room with the box fit at the same place in the other one better than half as well as at the best.
    assert last_error(right, left, 0.5, seed) < 0.2
    assert last_error(right, right, 0.5, seed) < 0.2
    assert last_error(right, left, 0.0, seed) > 2.0  # without alternatives it stays lost
