"""Puzzles: their score against closed forms, what spoils a log, and that each can be solved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.grid.metrics import wall_agreement
from mapper.mapping.parameters import MappingConfig
from mapper.puzzles import CAUSES, RECIPES, points, puzzle_of, repair_share, spoil
from mapper.puzzles.drives import LIDAR, TRUE, drive, swept
from mapper.puzzles.scoring import Measures, repair_shares
from mapper.puzzles.spoiling import disc_ranges, truncated_positions
from mapper.sensors.scan import ScanLog, Trajectory

PARAMETERS = MappingConfig(range_max=8.0)


@pytest.fixture(scope="module")
def log() -> ScanLog:
    return drive("room", 13, 120)


def test_the_agreement_of_a_line_that_is_partly_there() -> None:
    line = np.column_stack([np.arange(100) * 0.05, np.zeros(100)])
    assert wall_agreement(line, line) == 1.0
    assert wall_agreement(line[:60], line, 0.01) == pytest.approx(2 * 1.0 * 0.6 / 1.6)  # all of it right, 60 % found
    shifted = line + np.array([0.0, 0.1])
    assert wall_agreement(shifted, line, 0.1) == 1.0
    assert wall_agreement(shifted, line, 0.099) == 0.0
    assert wall_agreement(line[:0], line) == 0.0
    with pytest.raises(ConfigError, match="above 0 m"):
        wall_agreement(line, line, 0.0)


def test_the_score_by_hand() -> None:
    spoiled, repaired = Measures(0.2, 0.4, 0.6), Measures(1.0, 0.8, 0.6)
    now = Measures(0.6, 0.7, 0.1)
    shares = repair_shares(spoiled, repaired, now)
    assert shares == pytest.approx({"agreement": 0.5, "sharpness": 0.75})  # the entropy is not improved by the repair
    assert repair_share(shares) == pytest.approx((0.6 * 0.5 + 0.2 * 0.75) / 0.8)
    assert repair_share(repair_shares(spoiled, repaired, Measures(0.0, 0.0, 1.0))) == 0.0
    assert points(is_named=True, repair=0.5, wrong=1, hints=2, can_repair=True) == 40 + 30 - 30
    assert points(is_named=True, repair=0.0, wrong=0, hints=0, can_repair=False) == 100
    assert points(is_named=False, repair=0.1, wrong=3, hints=3, can_repair=True) == 0


def test_a_beam_meets_a_disc_where_geometry_says() -> None:
    laser = np.array([[1.0, 2.0, math.pi / 2]])
    angles = np.array([0.0, math.asin(0.1 / 2.0), math.asin(0.201 / 2.0), math.pi])
    found = disc_ranges(laser, angles, np.array([[1.0, 4.0]]), 0.2)[0]
    along = 2.0 * math.cos(angles[1]) - math.sqrt(0.2**2 - 0.1**2)
    assert found == pytest.approx([1.8, along, math.inf, math.inf])


def test_a_wrong_mount_is_repaired_by_its_parameters(log: ScanLog) -> None:
    for cause in ("mount_yaw", "mount_x"):
        found = spoil(log, cause, 3)
        config = PARAMETERS.with_values(found.repair)
        assert compose(np.array(found.log.mount), np.array(config.mount)) == pytest.approx(log.mount, abs=1e-12)
        assert found.log.mount != log.mount


def test_a_time_offset_moves_stamps_and_leaves_the_motion(log: ScanLog) -> None:
    found = spoil(log, "time_offset", 3)
    late = -found.repair["time_offset"]
    assert np.all(found.log.stamps_ns - log.stamps_ns == round(late * 1e9))
    timed = found.log.trajectory(TRUE).timed
    assert timed is not None
    assert timed.at(log.stamps_ns)[5:-5] == pytest.approx(log.trajectory(TRUE).poses[5:-5], abs=1e-6)


def test_truncation_is_that_of_python_and_moves_what_is_below_zero_by_one_cell() -> None:
    xy = np.random.default_rng(5).uniform(-3.0, 3.0, (200, 2))
    by_int = [[int(v / 0.25) * 0.25 + v % 0.25 for v in row] for row in xy]
    assert truncated_positions(xy, 0.25) == pytest.approx(np.array(by_int), abs=1e-12)
    assert truncated_positions(xy, 0.25) - xy == pytest.approx(np.where(xy < 0.0, 0.25, 0.0), abs=1e-12)
    assert truncated_positions(np.array([-0.1, 0.0, 0.1]), 0.25) == pytest.approx([0.15, 0.0, 0.1])


def test_truncated_poses_are_right_above_zero_only_between_the_scans_too(log: ScanLog) -> None:
    found = spoil(log, "truncation", 3)
    right, wrong = found.log.trajectory(found.repair_trajectory), found.log.trajectory(found.trajectory)
    assert np.median(right.poses[:, :2], axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)
    side = np.abs(wrong.poses - right.poses).max()
    assert 0.3 <= side <= 0.5
    assert right.timed is not None
    assert wrong.timed is not None
    for true, cut in ((right.poses, wrong.poses), (right.timed.poses, wrong.timed.poses)):
        assert (cut - true)[:, :2] == pytest.approx(np.where(true[:, :2] < 0.0, side, 0.0), abs=1e-9)
        assert np.array_equal(cut[:, 2], true[:, 2])


def test_another_origin_displaces_all_poses_from_one_scan_on(log: ScanLog) -> None:
    found = spoil(log, "grid_origin", 3)
    off = (found.log.trajectory(found.trajectory).poses - log.trajectory(TRUE).poses)[:, :2]
    moved = np.hypot(*off.T) > 0.0
    assert 0.4 * log.n_scans <= np.argmax(moved) <= 0.6 * log.n_scans
    assert moved[np.argmax(moved) :].all()
    assert off[moved] == pytest.approx(np.tile(off[-1], (moved.sum(), 1)), abs=1e-12)
    assert 0.4 <= np.hypot(*off[-1]) <= 0.8


def test_people_only_shorten_readings_and_beams_at_max_range_are_no_longer_infinite(log: ScanLog) -> None:
    people = spoil(log, "people", 3).log.ranges
    assert np.all(people <= log.ranges)
    assert 0.001 < np.mean(people < log.ranges) < 0.2
    short = spoil(log, "max_range", 3)
    assert np.isfinite(short.log.ranges).all()
    assert np.isinf(short.reference.ranges).any()


@pytest.mark.parametrize("cause", [name for name, one in CAUSES.items() if one.of_log])
def test_what_any_log_can_have_is_repaired_as_the_puzzle_says(log: ScanLog, cause: str) -> None:
    made = puzzle_of(spoil(log, cause, 3), cause, PARAMETERS)
    assert made.can_repair
    assert made.share(made.spoiled) == 0.0
    values = {name: getattr(made.start, name) for name in made.start.__slots__} | dict(made.repair)
    assert made.share(made.measured(values, made.repair_trajectory or made.trajectory)) == 1.0
    assert made.repaired.agreement > 0.95


def test_a_sweep_is_measured_from_the_poses_of_its_beams(log: ScanLog) -> None:
    moving = swept(log.take(slice(0, 40)), "room")
    assert moving.time_increment == pytest.approx(1.0 / (LIDAR.scan_rate * LIDAR.n_beams))
    off = np.abs(np.minimum(moving.ranges, 8.0) - np.minimum(log.ranges[:40], 8.0))
    assert np.median(off[:, 0]) < 0.05  # the first beam is measured at the stamp
    assert off[:, -1].max() > 0.1


def test_what_cannot_be_spoiled_is_refused(log: ScanLog) -> None:
    still = replace(log, trajectories={"none": Trajectory(np.zeros((log.n_scans, 3)))})
    for bad, cause, said in (
        (log, "sweep", "There is no fault"),
        (log.take(slice(0, 1)), "drift", "at least two scans"),
        (still, "truncation", "does not move"),
        (replace(log, stamps_ns=np.zeros_like(log.stamps_ns)), "time_offset", "stamps of this log are equal"),
    ):
        with pytest.raises(ConfigError, match=said):
            spoil(bad, cause, 3)


def test_every_cause_has_a_puzzle_and_titles_do_not_tell_it() -> None:
    assert {one.cause for one in RECIPES.values()} == set(CAUSES)
    for one in RECIPES.values():
        assert CAUSES[one.cause].label.lower() not in f"{one.title} {one.story}".lower()


def test_a_drive_tells_how_far_it_is_can_be_ended_and_is_kept() -> None:
    told: list[float] = []
    made = drive("room", 77, 12, step=told.append)
    assert (told[0], len(told) > 12, told == sorted(told)) == (0.0, True, True)
    assert max(told) < 1.0
    told.clear()
    assert drive("room", 77, 12, step=told.append) is made
    assert told == [], "it is kept"

    def end(done: float) -> None:
        raise InterruptedError(done)

    with pytest.raises(InterruptedError):
        drive("room", 78, 12, step=end)
    assert drive("room", 78, 12).n_scans == 12
