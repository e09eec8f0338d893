"""SLAM of long logs: what grows faster than the log is bounded, and can be cancelled at any time."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import WorkCancelledError
from mapper.evaluation import absolute_errors, align
from mapper.sensors.pose_graph import PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam import SlamCancelled, SlamConfig, SlamProgress, loop_closure, refinement, slam, slam_log, sparse_system
from mapper.slam.optimise import optimise, optimise_newest
from mapper.slam.refinement import PartedSystem, divided
from mapper.slam.sparse_system import SparseSystem
from tests.mapper.slam.worlds import along, drive

ROOM = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)]
ROUNDS = 12


@pytest.fixture(scope="module")
def rounds() -> ScanLog:
    """Some hundred scans of a robot that goes round and round in a room."""
    return drive("room", along([*ROOM[:1], *(ROOM[1:] * ROUNDS)], 0.3))


def system_of_places(n: int = 300) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Places, pairs of near ones, and their blocks, as an alignment gives them."""
    rng = np.random.default_rng(1)
    poses = np.column_stack([rng.uniform(0.0, 10.0, (n, 2)), np.zeros(n)])
    away = np.hypot(*(poses[:, np.newaxis, :2] - poses[:, :2]).T)
    pairs = np.argwhere(np.triu(away < 1.2, 1) | np.eye(n, k=1, dtype=bool))
    jacobians = np.concatenate(
        [np.tile(-np.eye(3), (len(pairs), 1, 1)), np.tile(np.eye(3), (len(pairs), 1, 1))], axis=2
    )
    jacobians += rng.normal(0.0, 0.05, jacobians.shape)
    hessians = np.einsum("kra,krb->kab", jacobians, jacobians)
    gradients = np.einsum("kra,kr->ka", jacobians, rng.normal(0.0, 0.1, (len(pairs), 3)))
    return poses, pairs, hessians, gradients


def dense_solution(n: int, pairs: np.ndarray, hessians: np.ndarray, gradients: np.ndarray) -> np.ndarray:
    whole, right = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for (i, j), hessian, gradient in zip(pairs, hessians, gradients, strict=True):
        at = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
        whole[np.ix_(at, at)] += hessian
        right[at] += gradient
    return np.concatenate([np.zeros(3), np.linalg.solve(whole[3:, 3:], right[3:])]).reshape(n, 3)


def test_places_are_divided_into_parts_of_bounded_size() -> None:
    places = np.random.default_rng(2).uniform(0.0, [30.0, 5.0], (1_000, 2))
    parts = divided(places, 130)
    assert sorted(np.concatenate(parts).tolist()) == list(range(1_000))
    assert max(len(part) for part in parts) <= 130
    assert all(np.ptp(places[part, 0]) < 5.0 for part in parts)  # across the longer side
    assert len(divided(np.zeros((50, 2)), 10)) == 8  # all at one place


def test_sweeps_over_parts_come_to_the_solution_with_less_memory() -> None:
    poses, pairs, hessians, gradients = system_of_places()
    n = len(poses)
    expected = dense_solution(n, pairs, hessians, gradients)
    one = PartedSystem(poses, pairs, n)
    np.testing.assert_allclose(one.solve(hessians, gradients), expected, atol=1e-9)
    system = PartedSystem(poses, pairs, 60)
    found, off = np.zeros((n, 3)), []
    for _ in range(60):
        left = gradients - np.einsum("kab,kb->ka", hessians, found[pairs].reshape(-1, 6))
        found += system.solve(hessians, left)
        off.append(float(np.abs(found - expected).max()))
    assert system.filled < 0.25 * one.filled
    assert off[0] < 0.5 * float(np.abs(expected).max())
    assert off[-1] < 0.1 * off[0]
    np.testing.assert_array_equal(found[0], 0.0)


def test_a_factorisation_in_steps_is_the_same_and_can_be_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    poses, pairs, hessians, gradients = system_of_places()
    system = SparseSystem(len(poses), pairs, np.array([0]))
    expected = system.solve(hessians, gradients)
    monkeypatch.setattr(sparse_system, "MOST_MULTIPLIED", 500)
    calls: list[int] = []
    np.testing.assert_array_equal(system.solve(hessians, gradients, check=lambda: calls.append(0)), expected)
    assert len(calls) > 20

    def cancel() -> None:
        raise WorkCancelledError("test.cancelled", "Cancelled.")

    with pytest.raises(WorkCancelledError):
        system.solve(hessians, gradients, check=cancel)


def test_long_logs_have_few_loops_and_their_graph_is_rarely_optimised(
    rounds: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The limits are made so small that a short log exceeds them."""
    calls: list[int] = []

    def counted(*args: object, **options: object) -> object:
        calls.append(0)
        return optimise(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(slam, "optimise", counted)
    config = SlamConfig(place_recognition=False)
    usual = slam_log(rounds, config)
    n_usual = len(calls)
    calls.clear()
    monkeypatch.setattr(loop_closure, "MOST_ATTEMPTS", 15)
    monkeypatch.setattr(slam, "LARGE", 60)
    monkeypatch.setattr(slam, "RARELY", 3)
    monkeypatch.setattr(refinement, "MOST_JOINT", 50)
    found = slam_log(rounds, config)
    way = float(np.hypot(*np.diff(found.poses[:, :2], axis=0).T).sum())
    # Attempts: one for each loop_distance until it is a fifteenth of the way, then 15 ln.
    begin = 15.0 * config.loop_distance
    attempts = 15.0 * (1.0 + np.log(way / begin))
    assert len(found.candidates) <= loop_closure.CANDIDATES * attempts
    assert len(found.candidates) < 0.7 * len(usual.candidates)
    assert found.graph.n_loops > 5
    assert len(calls) < n_usual
    true = rounds.trajectory("true").poses
    assert absolute_errors(true, align(true, found.poses).apply(found.poses))[0].max() < 0.15


def test_the_newest_poses_of_a_large_graph_move_at_once(rounds: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two solutions of the whole graph a loop that is far off moves only the poses shortly before it."""
    lengths: list[int] = []

    def counted(graph: PoseGraph, first: int, *given: object) -> object:
        lengths.append(len(graph.nodes) - first)
        return optimise_newest(graph, first, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(slam, "optimise_newest", counted)
    for name, value in {"LARGE": 60, "RARELY": 1, "NEWEST": 30, "FAR_OFF": 0.02}.items():
        monkeypatch.setattr(slam, name, value)
    monkeypatch.setattr(slam, "MOVED", 0.02)
    found = slam_log(rounds, SlamConfig(place_recognition=False))
    assert lengths
    assert max(lengths) < len(found.graph.nodes)
    true = rounds.trajectory("true").poses
    assert absolute_errors(true, align(true, found.poses).apply(found.poses))[0].max() < 0.15


def test_a_report_costs_nothing_until_its_poses_are_asked_for_and_any_can_cancel(rounds: ScanLog) -> None:
    stages: list[str] = []

    def cancel_in_refinement(one: SlamProgress) -> bool:
        stages.append(one.stage)
        return stages.count("refinement") < 3

    # Three reports within the first iteration: the steps of the work are asked, not only its end.
    with pytest.raises(SlamCancelled):
        slam_log(rounds, SlamConfig(refinement=1), progress=cancel_in_refinement)
    assert stages.count("refinement") == 3
