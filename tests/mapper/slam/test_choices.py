"""Choice of scans, of their partners, and the robot's speed: small cases whose answers are known."""

import numpy as np

from mapper.core.se2 import compose
from mapper.slam.odometry import carry, next_scan, velocities_along
from mapper.slam.refinement import neighbour_pairs


def test_scans_shortly_after_a_matched_one_are_passed_over() -> None:
    times = np.asarray(np.arange(20) * 0.025, dtype=np.float64)
    assert next_scan(0, times, np.zeros(3)) == 4
    assert next_scan(3, times, np.array([0.0, 4.0, 0.0])) == 5  # 0.2 m of the way
    assert next_scan(3, times, np.array([0.0, 0.0, -20.0])) == 4
    assert next_scan(17, times, np.zeros(3)) == 19
    assert next_scan(19, times, np.zeros(3)) == 20
    assert next_scan(5, np.zeros(20), np.zeros(3)) == 6  # no time passes
    backwards = times.copy()
    backwards[7:] -= 0.1
    assert next_scan(5, backwards, np.zeros(3)) == 6


def test_velocities_are_those_until_the_next_pose() -> None:
    times = np.array([0.0, 0.1, 0.3, 2.0, 2.0])
    step = np.array([0.05, 0.0, 0.02])
    poses = [np.array([1.0, 2.0, 0.5])]
    for scale in (1.0, 2.0, 5.0, 0.0):
        poses.append(compose(poses[-1], scale * step))
    found = velocities_along(times, np.array(poses))
    np.testing.assert_allclose(found[0], step / 0.1, atol=1e-12)
    np.testing.assert_allclose(found[1], 2.0 * step / 0.2, atol=1e-12)
    np.testing.assert_allclose(found[2], found[1])  # the next is too late to tell
    np.testing.assert_array_equal(found[3:], 0.0)
    np.testing.assert_array_equal(velocities_along(times[:1], np.array(poses[:1])), np.zeros((1, 3)))


def test_poses_between_nodes_lie_by_time() -> None:
    nodes, ends = np.array([0, 3]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2]])
    found = carry(nodes, ends, None, np.array([0.0, 0.1, 0.9, 1.0]))
    np.testing.assert_allclose(found[:, 0], [0.0, 0.1, 0.9, 1.0])
    np.testing.assert_allclose(carry(nodes, ends, None, np.zeros(4))[:, 0], [0.0, 1 / 3, 2 / 3, 1.0])


def test_each_scan_is_aligned_with_near_and_with_far_ones() -> None:
    """A robot that went to and fro on 20 m, 0.1 m at a time."""
    x = np.concatenate([np.arange(0, 20, 0.1), np.arange(20, 0, -0.1)])
    poses = np.column_stack([x, np.zeros((len(x), 2))])
    pairs = neighbour_pairs(poses, 8)
    assert len({frozenset(pair) for pair in pairs.tolist()}) == len(pairs)
    of_last = np.sort(pairs[(pairs == 399).any(axis=1)].min(axis=1))
    assert {397, 398} <= set(of_last)
    away = np.abs(poses[of_last, 0] - poses[399, 0])
    assert len(of_last) == 2 + 8
    assert np.count_nonzero(away < 0.5) >= 6
    assert away.max() > 1.5
    # Of so many scans at one place that each is near all others, as many pairs remain as elsewhere.
    still = neighbour_pairs(np.zeros((3_000, 3)), 8)
    assert len(still) <= 3_000 * 10
