"""Matches of scans whose relative pose is known, by every method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.se2 import compose, inverse, transform_points
from mapper.evaluation.relations import records_of_relations
from mapper.io.logs import odometry_records, open_log
from mapper.io.trajectories import read_relations
from mapper.matching import METHODS, MatchConfig, Target, match_scan, prepare_scans, scan_target, textbook
from mapper.matching.kernels.point_to_line import refine_pair
from mapper.matching.kernels.types import POINTS, SQUARES, Iterations, PairRule
from mapper.sensors.scan import ScanLog
from tests.mapper.matching.rooms import CORRIDOR, ROOM, scan_log

POSES = np.array([[3.5, 2.2, 0.3], [3.9, 1.8, 0.8], [3.2, 2.6, -0.2]])
#: How far each method may end from the truth: m, rad.
ACCURACY = {"correlative": (0.11, 0.03), "exhaustive": (0.11, 0.03), "likelihood_field": (0.04, 0.02)}
ACCURACY["global_field"] = ACCURACY["likelihood_field"]


def errors(pose: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    off = compose(inverse(true), pose)
    return float(np.hypot(off[0], off[1])), abs(float(off[2]))


@pytest.fixture(scope="module")
def log() -> ScanLog:
    return scan_log(ROOM, POSES)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_finds_the_pose(log: ScanLog, method: str) -> None:
    scans, true = prepare_scans(log), compose(inverse(POSES[0]), POSES[1])
    is_local = METHODS[method].search == "guess"
    off = [0.05, -0.04, 0.05] if is_local else [0.4, -0.3, 0.4]
    config = MatchConfig(method=method, window_m=0.6, window_rad=0.6, first_gate=0.3)
    found = match_scan(scans, 1, scan_target(scans, 0), true + off, config)
    metres, radians = errors(found.pose, true)
    most_m, most_rad = ACCURACY.get(method, (0.02, 0.01))
    assert metres < most_m
    assert radians < most_rad
    assert not found.is_degenerate
    assert found.score > 0.5
    again = match_scan(scans, 1, scan_target(scans, 0), true + off, config)
    assert found.pose.tobytes() == again.pose.tobytes()
    assert found.covariance.tobytes() == again.covariance.tobytes()


@pytest.mark.parametrize("method", ["global", "global_field", "point_to_line", "features"])
def test_a_submap_is_a_target(log: ScanLog, method: str) -> None:
    scans = prepare_scans(log)
    target = Target(scans, np.array([0, 2]), POSES)
    found = match_scan(scans, 1, target, POSES[1] + 0.05, MatchConfig(method=method))
    metres, radians = errors(found.pose, POSES[1])
    assert metres < 0.04
    assert radians < 0.015


def test_the_covariance_is_that_of_many_noisy_scans() -> None:
    true = compose(inverse(POSES[0]), POSES[1])
    off, stated = [], []
    for seed in range(30):
        scans = prepare_scans(scan_log(ROOM, POSES[:2], noise=0.01, seed=seed))
        config = MatchConfig(method="point_to_line", weight="squares", min_cosine=0.8)
        found = match_scan(scans, 1, scan_target(scans, 0), true, config)
        off.append(found.pose - true)
        stated.append(np.diag(found.covariance))
    spread = np.std(off, axis=0) / np.sqrt(np.mean(stated, axis=0))
    assert (spread > 0.5).all()
    assert (spread < 3.0).all()  # neighbours share their normals, so it is more than the residuals' share


def test_a_corridor_is_degenerate_along_itself() -> None:
    poses = np.array([[0.0, 0.1, 0.2], [0.3, 0.0, 0.1]])
    scans = prepare_scans(scan_log(CORRIDOR, poses, noise=0.0))
    found = match_scan(scans, 1, scan_target(scans, 0), compose(inverse(poses[0]), poses[1]))
    assert found.is_degenerate
    assert found.unknown_direction is not None
    # In the frame of the first scan, which is turned by 0.2 rad.
    along = np.array([np.cos(0.2), -np.sin(0.2)])
    assert abs(found.unknown_direction[:2] @ along) > 0.99
    assert abs(found.unknown_direction[2]) < 0.05
    across = np.array([np.sin(0.2), np.cos(0.2)])
    assert abs(across @ (found.pose[:2] - compose(inverse(poses[0]), poses[1])[:2])) < 0.02


def test_of_two_modes_that_is_best_on_which_both_scans_agree() -> None:
    # Two equal rooms side by side: a point-to-line fit in the wrong one is as good as in the right one, but the door
    # between them is on the other side.
    rooms = np.array(
        [(0, 0, 8, 0), (8, 0, 8, 3), (8, 3, 0, 3), (0, 3, 0, 0), (4, 0, 4, 1.0), (4, 2.0, 4, 3.0)], dtype=np.float64
    )
    poses = np.array([[2.0, 1.4, 0.0], [2.4, 1.6, np.pi / 2]])
    scans = prepare_scans(scan_log(rooms, poses, n_beams=360))
    true = compose(inverse(poses[0]), poses[1])
    found = match_scan(
        scans, 1, scan_target(scans, 0), true + np.array([0.2, 0.3, 1.2]), MatchConfig(window_m=1.0, window_rad=np.pi)
    )
    assert len(found.scores) > 1
    assert found.score > found.scores.max() - 0.01
    assert errors(found.pose, true)[0] < 0.03


def test_point_to_point_ends_where_the_closed_form_does(log: ScanLog) -> None:
    scans, pose, hessian = prepare_scans(log, 0, 1), np.array([0.02, -0.01, 0.01]), np.empty((3, 3))
    # A scan and itself moved: each point corresponds to itself, and the closed form needs one step.
    rule = PairRule(-1.0, 3, SQUARES, 1.0, 1, 1.0, POINTS)
    refine_pair(scans, 0, scans, 0, np.zeros(3), rule, Iterations(50, 0.5, 0.5, 1.0, 1e-12, 1e-12), pose, hessian)
    points = scans.points[0][scans.kind[0] > 0].astype(np.float64)
    moved = transform_points(inverse(pose), points)
    np.testing.assert_allclose(textbook.best_rigid_motion(moved, points), pose, atol=1e-9)
    np.testing.assert_allclose(pose, 0.0, atol=1e-6)


def test_order_mount_and_side_of_the_sensor_make_no_difference(log: ScanLog) -> None:
    turned = replace(
        log,
        ranges=log.ranges[:, ::-1],
        angle_min=log.angle_min + (log.n_beams - 1) * log.angle_increment,
        angle_increment=-log.angle_increment,
    )
    upside_down = replace(log, angle_min=-log.angle_min, angle_increment=-log.angle_increment, upside_down=True)
    plain = prepare_scans(log)
    for other in (turned, upside_down):
        scans = prepare_scans(other)
        np.testing.assert_allclose(scans.points, plain.points, atol=1e-5)
        np.testing.assert_array_equal(scans.kind, plain.kind)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"ranges": np.full((3, 180), np.inf)}, "matching.points"),
        ({"ranges": np.full((3, 180), np.nan)}, "matching.points"),
        ({"ranges": np.where(np.arange(180) < 2, 1.0, np.nan) * np.ones((3, 1))}, "matching.points"),
        ({"ranges": np.ones((3, 2)), "angle_increment": 0.1}, "matching.beams"),
        ({"bearings": np.linspace(-2, 2, 180)}, "matching.bearings"),
    ],
)
def test_scans_that_cannot_be_matched_are_refused(log: ScanLog, change: dict[str, Any], code: str) -> None:
    def matched() -> None:
        scans = prepare_scans(replace(log, **change))
        match_scan(scans, 1, scan_target(scans, 0), np.zeros(3))

    with pytest.raises(ConfigError) as caught:
        matched()
    assert caught.value.code == code


def test_impossible_requests_are_refused(log: ScanLog) -> None:
    scans = prepare_scans(log)
    target = scan_target(scans, 0)
    for guess in ([np.nan, 0, 0], [np.inf, 0, 0], [0, 0], [1e9, 0, 0]):
        with pytest.raises(ConfigError):
            match_scan(scans, 1, target, np.array(guess))
    with pytest.raises(ConfigError, match="no scan 7"):
        match_scan(scans, 7, target, np.zeros(3))
    with pytest.raises(ConfigError, match="no scan -1"):
        scan_target(scans, -1)
    with pytest.raises(ConfigError, match="not finite"):
        Target(scans, np.array([0]), np.full((3, 3), np.nan))
    with pytest.raises(ConfigError, match="between 0 and 50 m"):
        MatchConfig(window_m=1000.0)
    with pytest.raises(LimitError, match="too many poses"):
        match_scan(scans, 1, target, np.zeros(3), MatchConfig(window_m=50.0, field_resolution=0.01))
    with pytest.raises(LimitError, match="too many poses"):
        match_scan(scans, 1, target, np.zeros(3), MatchConfig(method="exhaustive", window_m=50.0))
    with pytest.raises(ConfigError, match="No point of the scan lies near"):
        match_scan(scans, 1, target, np.array([300.0, 0.0, 0.0]))
    with pytest.raises(ConfigError, match="scans, not those"):
        prepare_scans(log, 2, 9)


def test_far_from_the_target_a_local_method_says_that_nothing_agrees(log: ScanLog) -> None:
    scans = prepare_scans(log)
    found = match_scan(scans, 1, scan_target(scans, 0), np.array([300.0, 0, 0]), MatchConfig(method="point_to_line"))
    assert found.score == 0.0
    assert found.is_degenerate
    assert found.pairs == 0


@pytest.mark.data
def test_relations_of_a_real_log_are_found(data_file: Callable[[str], Path]) -> None:
    path = data_file("carmen/intel_merged.log.gz")
    relations, records = read_relations(data_file("relations/intel.relations")), odometry_records(path)
    assert records is not None
    indices, clear = records_of_relations(relations.stamps_ns, relations.motions, records.messages)
    scan_of = {int(record): scan for scan, record in reversed(list(enumerate(records.before_scan)))}
    log, found = open_log(path), []
    random = np.random.default_rng(5)
    for (first, second), motion in zip(indices[clear], relations.motions[clear], strict=True):
        if int(first) in scan_of and int(second) in scan_of:
            pair = [prepare_scans(log, scan_of[int(k)], scan_of[int(k)] + 1) for k in (first, second)]
            guess = compose(motion, random.uniform(-1, 1, 3) * [0.7, 0.7, 1.0])
            match = match_scan(pair[1], 0, scan_target(pair[0], 0), guess, MatchConfig(window_m=1.1, window_rad=1.1))
            found.append(errors(match.pose, motion))
    good = np.asarray((np.array(found) < [0.10, np.deg2rad(2.0)]).all(axis=1))
    assert len(good) == 76
    assert np.mean(good) > 0.95
    assert np.median(np.array(found)[good, 0]) < 0.012
