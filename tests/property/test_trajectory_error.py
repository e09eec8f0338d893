"""Invariances of trajectory errors: frames, order of the file, exchange of the two trajectories."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.se2 import compose, inverse
from mapper.evaluation import ComparisonOptions, Relations, compare_trajectories, evaluate_relations
from mapper.sensors.timed_poses import TimedPoses

motions = st.tuples(st.floats(-100, 100), st.floats(-100, 100), st.floats(-3.1, 3.1)).map(np.array)
aligning = st.sampled_from(["rigid", "scaled", "origin"])


@st.composite
def pairs_of_trajectories(draw: st.DrawFn) -> tuple[TimedPoses, TimedPoses]:
    """A random walk, and the same with random errors and jitter of the stamps."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(12, 60))
    steps = np.column_stack([random.uniform(0.1, 1.0, n), random.normal(0, 0.1, n), random.normal(0, 0.4, n)])
    poses = np.zeros((n, 3))
    for k in range(1, n):
        poses[k] = compose(poses[k - 1], steps[k])
    stamps = np.arange(n) * 100_000_000
    jitter = random.integers(-9_000_000, 9_000_000, n)
    return TimedPoses(stamps, poses), TimedPoses(stamps + jitter, compose(poses, random.normal(0, 0.05, (n, 3))))


def figures(reference: TimedPoses, estimate: TimedPoses, options: ComparisonOptions) -> list[float]:
    found = compare_trajectories(reference, estimate, options)
    series = (found.absolute_translation, found.absolute_rotation, found.relative_translation, found.relative_rotation)
    return [figure for one in series for figure in astuple(one.statistics)]


def moved(poses: TimedPoses, motion: np.ndarray) -> TimedPoses:
    return TimedPoses(poses.stamps_ns, compose(motion, poses.poses))


@given(pairs_of_trajectories(), motions)
def test_a_rigid_motion_of_both_changes_nothing(pair: tuple[TimedPoses, TimedPoses], motion: np.ndarray) -> None:
    reference, estimate = pair
    for align in ("none", "rigid", "scaled", "origin"):
        options = ComparisonOptions(align=align, delta=3, delta_unit="frames")
        np.testing.assert_allclose(
            figures(moved(reference, motion), moved(estimate, motion), options),
            figures(reference, estimate, options),
            atol=1e-7,
        )


@given(pairs_of_trajectories(), motions, aligning)
def test_a_rigid_motion_of_the_estimate_is_aligned_away(
    pair: tuple[TimedPoses, TimedPoses], motion: np.ndarray, align: str
) -> None:
    reference, estimate = pair
    options = ComparisonOptions(align=align, delta=3, delta_unit="frames")
    np.testing.assert_allclose(
        figures(reference, moved(estimate, motion), options), figures(reference, estimate, options), atol=1e-7
    )


@given(pairs_of_trajectories(), st.randoms(use_true_random=False))
def test_the_order_of_a_file_does_not_count_for_absolute_errors(
    pair: tuple[TimedPoses, TimedPoses], random: object
) -> None:
    reference, estimate = pair
    order = np.random.default_rng(random.randrange(2**32)).permutation(len(reference))  # type: ignore[attr-defined]
    options = ComparisonOptions(delta=1, delta_unit="frames")
    expected = compare_trajectories(reference, estimate, options).absolute_translation.statistics
    found = compare_trajectories(reference.take(order), estimate, options).absolute_translation.statistics
    np.testing.assert_allclose(astuple(found), astuple(expected), atol=1e-9)


@given(pairs_of_trajectories())
def test_least_squares_is_least(pair: tuple[TimedPoses, TimedPoses]) -> None:
    def rmse(align: str) -> float:
        options = ComparisonOptions(align=align, delta=1, delta_unit="frames")
        return compare_trajectories(*pair, options).absolute_translation.statistics.rmse

    assert rmse("rigid") <= rmse("none") + 1e-9
    assert rmse("rigid") <= rmse("origin") + 1e-9
    assert rmse("scaled") <= rmse("rigid") + 1e-9


@given(pairs_of_trajectories())
def test_a_trajectory_has_no_error_against_itself(pair: tuple[TimedPoses, TimedPoses]) -> None:
    reference, _ = pair
    np.testing.assert_allclose(figures(reference, reference, ComparisonOptions()), 0.0, atol=1e-7)


@given(pairs_of_trajectories(), motions, st.integers(1, 8))
def test_relations_do_not_depend_on_the_frame(
    pair: tuple[TimedPoses, TimedPoses], motion: np.ndarray, step: int
) -> None:
    true, estimate = pair
    judged = TimedPoses(true.stamps_ns, estimate.poses)
    begin = np.arange(len(true) - step)
    known = compose(inverse(true.poses[begin]), true.poses[begin + step])
    relations = Relations(np.column_stack([true.stamps_ns[begin], true.stamps_ns[begin + step]]), known)
    expected, found = evaluate_relations(relations, judged), evaluate_relations(relations, moved(judged, motion))
    np.testing.assert_allclose(found.translation.errors, expected.translation.errors, atol=1e-9)
    np.testing.assert_allclose(np.cos(found.rotation.errors), np.cos(expected.rotation.errors), atol=1e-9)
