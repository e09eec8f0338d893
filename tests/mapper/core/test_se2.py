"""SE(2) against matrices and group laws."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.se2 import compose, interpolate, inverse, transform_points, wrap_angle

poses = st.tuples(st.floats(-100, 100), st.floats(-100, 100), st.floats(-10, 10)).map(np.array)


def matrix(pose: np.ndarray) -> np.ndarray:
    x, y, theta = pose
    return np.array([[np.cos(theta), -np.sin(theta), x], [np.sin(theta), np.cos(theta), y], [0, 0, 1]])


@given(poses, poses)
def test_compose_is_the_product_of_matrices(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-9)


@given(poses)
def test_inverse_undoes(a: np.ndarray) -> None:
    np.testing.assert_allclose(matrix(compose(a, inverse(a))), np.eye(3), atol=1e-9)
    np.testing.assert_allclose(matrix(compose(inverse(a), a)), np.eye(3), atol=1e-9)


@given(poses, st.tuples(st.floats(-50, 50), st.floats(-50, 50)))
def test_points_go_through_the_matrix(a: np.ndarray, point: tuple[float, float]) -> None:
    expected = matrix(a) @ [*point, 1.0]
    np.testing.assert_allclose(transform_points(a, point), expected[:2], atol=1e-9)


def test_a_quarter_turn_to_the_left() -> None:
    np.testing.assert_allclose(transform_points((1.0, 2.0, np.pi / 2), [[1.0, 0.0], [0.0, 1.0]]), [[1, 3], [0, 2]])


def test_many_poses_at_once_are_each_alone() -> None:
    random = np.random.default_rng(0)
    a, b = random.normal(size=(4, 1, 3)), random.normal(size=(5, 3))
    together = compose(a, b)
    assert together.shape == (4, 5, 3)
    np.testing.assert_array_equal(together[2, 3], compose(a[2, 0], b[3]))


@given(st.floats(-1000, 1000))
def test_wrapped_angles_point_the_same_way(angle: float) -> None:
    wrapped = float(wrap_angle(angle))
    assert -np.pi <= wrapped < np.pi
    assert abs(np.exp(1j * wrapped) - np.exp(1j * angle)) < 1e-9


@given(poses, poses, st.floats(0, 1))
def test_between_two_poses_the_short_way_round(a: np.ndarray, b: np.ndarray, share: float) -> None:
    between = interpolate(a, b, share)
    np.testing.assert_allclose(between[:2], (1 - share) * a[:2] + share * b[:2], atol=1e-9)
    turn = np.angle(np.exp(1j * (b[2] - a[2])))
    if abs(turn) < 3.14:
        np.testing.assert_allclose(np.exp(1j * between[2]), np.exp(1j * (a[2] + share * turn)), atol=1e-9)


def test_half_a_turn_wraps_to_the_lower_end() -> None:
    assert wrap_angle([np.pi, -np.pi, 3 * np.pi]).tolist() == [-np.pi] * 3
