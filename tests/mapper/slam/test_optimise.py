"""The pose graph's optimiser, against the textbook's dense one and against graphs whose solution is known."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.slam.optimise import optimise, optimise_newest
from mapper.slam.textbook import optimise_dense


def ring(n: int = 40, noise: float = 0.01, seed: int = 0) -> tuple[PoseGraph, np.ndarray]:
    """A ring of n poses with noisy odometry, and three right loops at its end; and the true poses."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * np.arange(n) / (n - 4)
    true = np.column_stack([5 * np.cos(angle), 5 * np.sin(angle), angle + np.pi / 2])
    i = np.r_[np.arange(n - 1), 0, 1, 2]
    j = np.r_[np.arange(1, n), n - 4, n - 3, n - 2]
    relative = compose(compose(inverse(true[i]), true[j]), rng.normal(0, noise, (len(i), 3)))
    poses = [true[0]]
    for k in range(n - 1):
        poses.append(compose(poses[-1], relative[k]))
    e = len(i)
    return PoseGraph(
        np.arange(n), np.array(poses), i, j, relative, np.broadcast_to(np.eye(3) / noise**2, (e, 3, 3)),
        np.r_[np.full(n - 1, ODOMETRY), np.full(3, LOOP)], np.zeros(e, dtype=bool), np.zeros(e), np.ones(e),
    ), true  # fmt: skip


def test_as_the_textbook() -> None:
    graph, _ = ring()
    found = optimise(graph, robust="none")
    np.testing.assert_allclose(found.poses, optimise_dense(graph), atol=1e-6)
    assert found.residual.max() < 4.0


def test_a_wrong_loop_loses_its_weight_unless_it_is_locked() -> None:
    graph, true = ring()
    wrong = graph.with_loop(5, 25, [0.0, 0.0, 0.0], 1e4 * np.eye(3))
    right = optimise(graph)
    found = optimise(wrong)
    assert found.weight[-1] < 0.01
    assert found.weight[-4:-1].min() > 0.5
    np.testing.assert_allclose(found.poses, right.poses, atol=0.05)
    locked = optimise(wrong.with_lock(len(wrong.i) - 1))
    assert np.hypot(*(locked.poses[5] - locked.poses[25])[:2]) < 0.5 * np.hypot(*(true[5] - true[25])[:2])


def test_a_removed_loop_leaves_no_trace() -> None:
    graph, _ = ring()
    more = graph.with_loop(3, 39, compose(inverse(graph.poses[3]), graph.poses[39]), 1e4 * np.eye(3))
    np.testing.assert_array_equal(optimise(more.without_edge(len(more.i) - 1)).poses, optimise(graph).poses)
    with pytest.raises(ConfigError, match="no loop with the number 0"):
        graph.without_edge(0)


def test_poses_that_no_edge_holds() -> None:
    graph, _ = ring()
    kept = (graph.i != 20) & (graph.j != 20)
    names = ("i", "j", "relative", "information", "kind", "locked", "residual", "weight")
    loose = replace(graph, **{name: getattr(graph, name)[kept] for name in names})
    with pytest.raises(ConfigError, match="leaves pose 20 undetermined"):
        optimise(loose)


def test_the_newest_poses_alone_come_to_the_solution_for_fixed_earlier_ones() -> None:
    graph, _ = ring()
    first = 25
    # As the textbook has it: edges among the earlier poses do not count where these are right and held fast.
    solved = optimise(graph, robust="none")
    off = replace(solved, poses=solved.poses + np.where(np.arange(40)[:, np.newaxis] < first, 0.0, [0.1, -0.05, 0.02]))
    found = optimise_newest(off, first, "none", 3.0, 60)
    np.testing.assert_allclose(found, solved.poses[first:], atol=1e-6)
    # With earlier poses that are wrong it is another solution, in which those stay.
    moved = replace(off, poses=off.poses + np.where(np.arange(40)[:, np.newaxis] < first, 0.3, 0.0))
    assert np.abs(optimise_newest(moved, first, "none", 3.0, 60) - solved.poses[first:]).max() > 0.1
