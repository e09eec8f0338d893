"""Changes of a pose graph by hand: the poses follow the solution, and nothing moves without a change."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.sensors.pose_graph import ODOMETRY, PoseGraph
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.slam import LoopCandidates
from server.library.packs.graph import graph_bytes, read_graph
from server.parts.slam.loop_landscape import landscape_of
from server.parts.slam.solved_graph import SolvedGraph
from server.sessions.graph_answers import TriedNear
from server.sessions.view import GraphChange
from tests.mapper.slam.worlds import drive
from tests.server.library.processing.slam_stand_ins import chain

HEALED = np.stack([np.arange(6) * 0.95, 0.1 * np.arange(6), np.zeros(6)], axis=1)  #: not the graph's solution


@pytest.fixture(scope="module")
def solved() -> SolvedGraph:
    return SolvedGraph.of("SLAM", HEALED, *chain(6))


@pytest.fixture(scope="module")
def log() -> ScanLog:
    """Eleven scans of a room, along a wall and back."""
    there = np.stack([np.linspace(1.5, 3.5, 6), np.full(6, 2.0), np.zeros(6)], axis=1)
    return drive("room", np.concatenate([there, there[4::-1]]), seed=1)


def test_without_a_change_the_poses_are_the_healed_ones(solved: SolvedGraph) -> None:
    assert solved.poses is HEALED
    assert not solved.public().changed


def test_without_its_loop_a_chain_is_as_long_as_its_odometry(solved: SolvedGraph, log: ScanLog) -> None:
    assert np.diff(solved.graph.poses[:, 0]) == pytest.approx(0.9167, abs=0.01), "the loop has shortened it"
    changed = solved.changed(log, GraphChange(remove=5))
    assert np.diff(changed.graph.poses[:, 0]) == pytest.approx(1.0, abs=1e-6)
    shift = np.arange(6) * (1.0 - np.diff(solved.graph.poses[:, 0]).mean())
    np.testing.assert_allclose(changed.poses[:, 0], HEALED[:, 0] + shift, atol=1e-3)
    np.testing.assert_allclose(changed.poses[:, 1], HEALED[:, 1], atol=1e-6)
    assert (changed.public().loops, changed.public().changed) == ([], True)
    again = changed.changed(log, GraphChange(reset=True))
    assert again.poses is HEALED
    assert len(again.public().loops) == 1


def test_a_lock_and_another_kernel_change_the_weight_of_a_loop(solved: SolvedGraph, log: ScanLog) -> None:
    strict = solved.changed(log, GraphChange(robust_scale=0.5))
    (loop,) = strict.public().loops
    assert loop.weight < 0.2
    locked = strict.changed(log, GraphChange(lock=loop.edge))
    assert locked.public().loops[0].locked
    assert locked.public().loops[0].weight == 1.0
    assert locked.poses[-1, 0] < strict.poses[-1, 0], "the locked loop pulls its end"
    assert strict.changed(log, GraphChange(robust="none")).public().loops[0].weight == 1.0


def test_the_edges_of_a_scan_say_what_determines_its_pose(solved: SolvedGraph) -> None:
    first = solved.constraints(0)
    assert {(one.edge, one.kind, one.scans) for one in first.edges} == {(0, "odometry", (0, 1)), (5, "loop", (0, 5))}
    assert {one.edge for one in solved.constraints(3).edges} == {2, 3}
    by_edge = {one.edge: one for one in first.edges}
    # Each step of the poses is 0.95 m forward and 0.1 m to the left; the odometry measured 1 m forward, the loop 4.5 m.
    assert by_edge[0].off_m == pytest.approx(np.hypot(0.05, 0.1), abs=1e-4)
    assert by_edge[5].off_m == pytest.approx(np.hypot(0.25, 0.5), abs=1e-4)
    residuals = [one.residual for one in first.edges]
    assert residuals == sorted(residuals, reverse=True)
    with pytest.raises(ConfigError):
        solved.constraints(6)


def test_a_loop_by_hand_puts_the_scans_where_they_were_taken(log: ScanLog) -> None:
    true = log.trajectory("true").poses
    believed = compose(np.stack([np.linspace(0.0, 0.5, 11), np.zeros(11), np.linspace(0.0, 0.1, 11)], axis=1), true)
    n = log.n_scans
    graph = PoseGraph(
        nodes=np.arange(n),
        poses=believed,
        i=np.arange(n - 1),
        j=np.arange(1, n),
        relative=compose(inverse(believed[:-1]), believed[1:]),
        information=np.tile(np.diag([100.0, 100.0, 400.0]), (n - 1, 1, 1)),
        kind=np.full(n - 1, ODOMETRY),
        locked=np.zeros(n - 1, dtype=bool),
        residual=np.zeros(n - 1),
        weight=np.ones(n - 1),
    )
    nothing = np.zeros(0, dtype=np.int64)
    tried = LoopCandidates(nothing, nothing, np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool), ())
    solved = SolvedGraph.of("SLAM", believed, graph, tried)
    changed = solved.changed(log, GraphChange(add=(0, 10)))
    between = compose(inverse(changed.poses[0]), changed.poses[10])
    expected = compose(inverse(true[0]), true[10])
    assert np.hypot(*(between - expected)[:2]) < 0.05
    assert abs(wrap_angle(between[2] - expected[2])) < np.radians(2.0)
    (loop,) = changed.public().loops
    assert (loop.scans, loop.locked) == ((0, 10), True)
    found = changed.edge(log, loop.edge)
    assert found.off_m < 0.05
    np.testing.assert_allclose(np.array(found.points.aligned), np.array(found.points.j), atol=0.1)
    assert changed.near(1.5, 2.0).visits == [(0, 10)]
    # The score around it is highest where the scans were taken, and lower away from there.
    landscape = landscape_of(changed, log, loop.edge)
    scores = np.array(landscape.scores).reshape(landscape.size, landscape.size)
    row, col = np.unravel_index(scores.argmax(), scores.shape)
    best = np.array([col, row]) * landscape.cell_m - 1.0 + landscape.centre[:2]
    np.testing.assert_allclose(best, changed.node_poses[10][:2], atol=0.08)
    assert abs(landscape.turn_of[int(scores.argmax())] - 10) <= 1, "the loop's own angle"
    assert scores.max() == max(landscape.by_turn) > 70 > scores[0, 0]
    assert landscape.present[:2] == pytest.approx(changed.node_poses[10][:2], abs=1e-3)
    with pytest.raises(ConfigError, match="edge"):
        landscape_of(changed, log, 99)


def test_near_a_place_there_is_what_was_tried_and_why_it_was_refused(solved: SolvedGraph, log: ScanLog) -> None:
    found = solved.near(1.0, 0.1)
    assert [(one.scans, one.accepted, one.reason) for one in found.candidates] == [
        ((1, 4), False, "only 30 % of the points are on walls of the earlier scans"),
        ((0, 5), True, ""),
    ]
    assert found.visits == [(0, 4)]
    assert solved.near(100.0, 0.0) == TriedNear([], None, [])
    assert solved.candidate(log, 1).scans == (1, 4)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (GraphChange(remove=0), "graph.edge"),
        (GraphChange(lock=99), "graph.edge"),
        (GraphChange(robust="welsch"), "graph.robust"),
        (GraphChange(robust_scale=0.0), "graph.robust_scale"),
        (GraphChange(add=(0, 1000)), "graph.scans"),
        (GraphChange(add=(2, 3)), "graph.scans"),
    ],
)
def test_what_cannot_be_changed_is_said(solved: SolvedGraph, log: ScanLog, change: GraphChange, code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        solved.changed(log, change)
    assert caught.value.code == code


def test_a_graph_comes_back_from_its_file(solved: SolvedGraph) -> None:
    graph, tried = read_graph(graph_bytes(solved.graph, solved.candidates))
    for name in ("nodes", "poses", "i", "j", "relative", "information", "kind", "locked", "residual", "weight"):
        np.testing.assert_array_equal(getattr(graph, name), getattr(solved.graph, name))
    assert tried.reason == solved.candidates.reason
    for damaged in (b"", b"PK\x03\x04 no file", graph_bytes(solved.graph, solved.candidates)[:200]):
        with pytest.raises(Exception, match="run SLAM again"):
            read_graph(damaged)


def test_the_trajectory_of_the_log_gets_the_poses(solved: SolvedGraph, log: ScanLog) -> None:
    six = log.take(slice(0, 6))
    six = solved.in_log(ScanLog(**{n: getattr(six, n) for n in ("ranges", "angle_min", "angle_increment", "range_min",
        "range_max", "stamps_ns")}, trajectories={"SLAM": Trajectory(np.zeros((6, 3)), "said")}))  # fmt: skip
    np.testing.assert_array_equal(six.trajectory("SLAM").poses, HEALED)
    assert six.trajectory("SLAM").description == "said"
