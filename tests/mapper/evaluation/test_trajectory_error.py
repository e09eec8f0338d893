"""Association, alignment, pairs and errors: against closed forms and the textbook."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, wrap_angle
from mapper.evaluation import (
    ComparisonOptions,
    absolute_errors,
    align,
    associate,
    compare_trajectories,
    pairs_over,
    relative_errors,
    textbook,
)
from mapper.evaluation.alignment import umeyama
from mapper.sensors.timed_poses import TimedPoses

S = 1_000_000_000
seeds = st.integers(0, 2**32 - 1)


def walk(seed: int, n: int = 40) -> np.ndarray:
    """A random walk (n, 3)."""
    random = np.random.default_rng(seed)
    steps = np.column_stack([random.uniform(0.0, 1.0, n), random.normal(0, 0.1, n), random.normal(0, 0.5, n)])
    poses = np.zeros((n, 3))
    for k in range(1, n):
        poses[k] = compose(poses[k - 1], steps[k])
    return poses


def straight(n: int, step: float = 1.0) -> TimedPoses:
    """Poses along the x axis, one a second."""
    return TimedPoses(np.arange(n) * S, np.column_stack([np.arange(n) * step, np.zeros(n), np.zeros(n)]))


def test_stamps_pair_with_the_nearest() -> None:
    few, many = np.array([10, 25, 70]) * S, np.array([0, 9, 12, 24, 26, 50]) * S
    assert associate(few, many, 2.0).tolist() == [[0, 1], [1, 3]]
    assert associate(many, few, 2.0).tolist() == [[1, 0], [3, 1]]
    assert associate(few, many, 1e3).tolist() == [[0, 1], [1, 3], [2, 5]]
    assert associate(few, many, 0.0, offset_s=1.0).tolist() == [[0, 1], [1, 3]]
    assert associate(few, many[::-1], 2.0).tolist() == [[0, 4], [1, 1]], "stamps need not be in order"


def test_a_difference_counts_up_to_its_end() -> None:
    assert len(associate(np.array([0]), np.array([10_000_000]), 0.01)) == 1
    with pytest.raises(ConfigError, match=r"within 0\.01 s"):
        associate(np.array([0]), np.array([10_000_001]), 0.01)


def test_of_equally_near_stamps_the_earlier_is_taken_or_the_first_in_a_list_that_runs_backwards() -> None:
    one = np.array([5]) * S
    assert associate(one, np.array([4, 6, 9]) * S, 1.0).tolist() == [[0, 0]]
    assert associate(one, np.array([5, 5, 9]) * S, 1.0).tolist() == [[0, 1]]
    assert associate(one, np.array([9, 6, 4]) * S, 1.0).tolist() == [[0, 1]]
    assert associate(one, np.array([9, 5, 5]) * S, 1.0).tolist() == [[0, 1]]


def test_equal_lists_pair_in_their_order() -> None:
    stamps = np.array([5, 5, 4, 4, 9]) * S
    assert associate(stamps, stamps).tolist() == [[k, k] for k in range(5)]


@pytest.mark.parametrize("stamps", [(np.array([], dtype=np.int64), np.array([1])), (np.array([1]), np.array([5 * S]))])
def test_nothing_in_common_is_said(stamps: tuple[np.ndarray, np.ndarray]) -> None:
    for one, other in (stamps, stamps[::-1]):
        with pytest.raises(ConfigError, match="No stamps"):
            associate(one, other)


@given(seeds, st.integers(0, 200))
def test_association_is_the_textbooks(seed: int, difference: int) -> None:
    random = np.random.default_rng(seed)
    many, few = np.sort(random.choice(10_000, 40, replace=False)), np.sort(random.choice(10_000, 12, replace=False))
    expected = textbook.associate(many.tolist(), few.tolist(), difference)
    try:
        found = associate(many * S, few * S, difference).tolist()
    except ConfigError:
        found = []
    assert found == [list(pair) for pair in expected]


@given(seeds, st.booleans())
def test_alignment_is_umeyamas(seed: int, with_scale: bool) -> None:
    reference, estimate = walk(seed)[:, :2], walk(seed + 1)[:, :2]
    rotation, translation, scale = textbook.umeyama(reference, estimate, with_scale=with_scale)
    found = umeyama(reference, estimate, with_scale=with_scale)
    np.testing.assert_allclose([math.cos(found.theta), math.sin(found.theta)], rotation[:, 0], atol=1e-7)
    np.testing.assert_allclose((found.x, found.y, found.scale), [*translation, scale], atol=1e-6)


@given(seeds, st.floats(-50, 50), st.floats(-50, 50), st.floats(-3.1, 3.1), st.floats(0.1, 10.0))
def test_alignment_undoes_a_motion_and_a_scale(seed: int, x: float, y: float, theta: float, scale: float) -> None:
    reference = walk(seed)
    shrunk = reference.copy()
    shrunk[:, :2] *= scale
    moved = compose([x, y, theta], shrunk)
    found = align(reference, moved, "scaled")
    assert found.scale * scale == pytest.approx(1.0)
    back = found.apply(moved)
    np.testing.assert_allclose(back[:, :2], reference[:, :2], atol=1e-7)
    np.testing.assert_allclose(wrap_angle(back[:, 2] - reference[:, 2]), 0.0, atol=1e-7)


def test_a_straight_line_can_be_aligned_and_a_place_cannot() -> None:
    line = straight(5).poses
    found = align(line, compose([3.0, 4.0, 1.0], line))
    assert wrap_angle(found.theta + 1.0) == pytest.approx(0.0)
    for still in (np.zeros((5, 3)), np.tile([1e5 + 0.1, -3e4, 0.2], (5, 1))):
        with pytest.raises(ConfigError, match="undetermined"):
            align(line, still)
        with pytest.raises(ConfigError, match="undetermined"):
            align(still, line)
        assert align(still, line, "origin").x == pytest.approx(still[0, 0])


def test_mirror_images_of_a_circle_cannot_be_aligned() -> None:
    angle = np.arange(12) * np.pi / 6
    circle = np.column_stack([np.cos(angle), np.sin(angle), angle])
    with pytest.raises(ConfigError, match="undetermined"):
        align(circle, circle * [1.0, -1.0, -1.0])


def test_pairs_by_frames_seconds_and_metres() -> None:
    poses, stamps = straight(7, 0.5).poses, np.arange(7) * S
    assert pairs_over(2, "frames", poses, stamps).tolist() == [[0, 2], [2, 4], [4, 6]]
    assert pairs_over(2, "frames", poses, stamps, all_pairs=True).tolist() == [[k, k + 2] for k in range(5)]
    assert pairs_over(1.5, "m", poses, stamps).tolist() == [[0, 3], [3, 6]]
    assert pairs_over(1.5, "m", poses, stamps, all_pairs=True).tolist() == [[k, k + 3] for k in range(4)]
    assert pairs_over(1.5, "s", poses, stamps).tolist() == [[0, 2], [2, 4], [4, 6]]
    assert pairs_over(1.9, "s", poses, stamps, all_pairs=True).tolist() == [[k, k + 2] for k in range(5)]
    assert pairs_over(5, "frames", straight(6).poses, stamps[:6]).tolist() == [[0, 5]]


@pytest.mark.parametrize(
    ("delta", "unit", "match"),
    [
        (0.0, "m", "above 0"),
        (-1.0, "s", "above 0"),
        (math.nan, "m", "above 0"),
        (1.5, "frames", "whole number"),
        (1.0, "km", "m, s or frames"),
        (100.0, "m", "smaller delta"),
        (7.0, "frames", "smaller delta"),
    ],
)
def test_impossible_pairs_are_refused(delta: float, unit: str, match: str) -> None:
    for all_pairs in (False, True):
        with pytest.raises(ConfigError, match=match):
            pairs_over(delta, unit, straight(7).poses, np.arange(7) * S, all_pairs=all_pairs)


def test_seconds_along_stamps_that_run_backwards_are_refused() -> None:
    with pytest.raises(ConfigError, match="backwards"):
        pairs_over(1.0, "s", straight(3).poses, np.array([0, 2, 1]) * S)


@pytest.mark.parametrize("n", [0, 1])
def test_too_few_poses_have_no_pairs(n: int) -> None:
    for unit in ("m", "s", "frames"):
        for all_pairs in (False, True):
            with pytest.raises(ConfigError, match="smaller delta"):
                pairs_over(1.0, unit, np.zeros((n, 3)), np.zeros(n, dtype=np.int64), all_pairs=all_pairs)


@given(seeds, st.floats(0.1, 8.0), st.floats(0.0, 1.0))
def test_all_pairs_are_the_textbooks(seed: int, delta: float, tolerance: float) -> None:
    poses = walk(seed)
    poses[10:15] = poses[10]  # the robot stands
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
    expected = textbook.all_pairs(way, delta, tolerance * delta)
    try:
        found = pairs_over(delta, "m", poses, np.arange(40), all_pairs=True, tolerance=tolerance).tolist()
    except ConfigError:
        found = []
    assert found == [list(pair) for pair in expected]


@given(seeds)
def test_errors_are_the_textbooks(seed: int) -> None:
    reference, estimate = walk(seed), walk(seed + 1)
    found = np.column_stack(absolute_errors(reference, estimate))
    np.testing.assert_allclose(found, textbook.absolute_errors(reference, estimate), atol=1e-9)
    pairs = [(i, i + 3) for i in range(30)]
    found = np.column_stack(relative_errors(reference, estimate, np.array(pairs)))
    np.testing.assert_allclose(found, textbook.relative_errors(reference, estimate, pairs), atol=1e-9)


def test_wheels_that_count_two_percent_too_much() -> None:
    """On a straight way of 100 m the error grows by 0.02 m with each metre, and every metre is off by 0.02 m."""
    true, wheels = straight(101), straight(101, 1.02)
    found = compare_trajectories(true, wheels, ComparisonOptions(align="none", delta=1.0))
    np.testing.assert_allclose(found.absolute_translation.errors, 0.02 * np.arange(101), atol=1e-12)
    figures = found.absolute_translation.statistics
    assert figures.sse == pytest.approx(0.02**2 * 100 * 101 * 201 / 6)
    assert figures.rmse == pytest.approx(math.sqrt(figures.sse / 101))
    assert (figures.mean, figures.median, figures.min, figures.max) == pytest.approx((1.0, 1.0, 0.0, 2.0))
    assert figures.std == pytest.approx(0.02 * math.sqrt((101**2 - 1) / 12))
    np.testing.assert_allclose(found.relative_translation.errors, 0.02, atol=1e-12)
    np.testing.assert_array_equal(found.relative_rotation.errors, 0.0)
    np.testing.assert_array_equal(found.relative_translation.stamps_ns, np.arange(1, 101) * S)
    aligned = compare_trajectories(true, wheels, ComparisonOptions(align="scaled"))
    assert aligned.alignment.scale == pytest.approx(1 / 1.02)
    np.testing.assert_allclose(aligned.absolute_translation.errors, 0.0, atol=1e-12)


def test_headings_that_are_off_count_as_rotation_alone() -> None:
    true = straight(11)
    turned = TimedPoses(true.stamps_ns, true.poses + np.array([0.0, 0.0, 0.1]))
    found = compare_trajectories(true, turned, ComparisonOptions(align="none"))
    np.testing.assert_allclose(found.absolute_translation.errors, 0.0)
    np.testing.assert_allclose(found.absolute_rotation.errors, 0.1)
    # Over a metre ahead, seen by a robot that is turned by 0.1: a chord.
    np.testing.assert_allclose(found.relative_translation.errors, 2 * math.sin(0.05))
    np.testing.assert_allclose(found.relative_rotation.errors, 0.0, atol=1e-12)
