"""The pose graph of SLAM, for the table: random graphs, what the kernels make of them, and what the textbook does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.sensors.pose_graph import PoseGraph
from mapper.slam import textbook
from mapper.slam.kernels.agreement import count_agreement, count_common
from mapper.slam.kernels.edges import edge_errors, linearise_edges
from mapper.slam.kernels.graph_distance import least_of_ranges, ways_from
from mapper.slam.kernels.information import write_information
from mapper.slam.sparse_system import SparseSystem
from tests.agreement.matching import MatchCase, point_scan

FLOOR = np.array([0.01, 0.01, 0.005])


@dataclass(frozen=True)
class GraphCase:
    """A chain of poses with loops, and numbers of its own for each test."""

    graph: PoseGraph
    way: np.ndarray
    start: int
    hessian: np.ndarray
    heading: float


@st.composite
def graph_cases(draw: st.DrawFn) -> GraphCase:
    """Graphs of 2 to 12 poses, of which some have no loop and some have the same loop twice."""
    n = draw(st.integers(2, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    loops = draw(
        st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)).filter(lambda e: e[0] != e[1]), max_size=8)
    )
    i = np.array([*range(n - 1), *(a for a, _ in loops)])
    j = np.array([*range(1, n), *(b for _, b in loops)])
    e = len(i)
    roots = rng.normal(size=(e, 3, 3))
    graph = PoseGraph(
        np.arange(n), rng.normal(size=(n, 3)), i, j, rng.normal(size=(e, 3)),
        roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(3),
        np.zeros(e, dtype=np.uint8), np.zeros(e, dtype=np.bool_), np.zeros(e), np.ones(e),
    )  # fmt: skip
    way = np.concatenate([[0.0], np.cumsum(rng.integers(0, 8, n - 1) / 8.0)])
    points = rng.normal(size=(3, 9))
    return GraphCase(graph, way, draw(st.integers(0, n - 1)), points @ points.T, float(rng.normal()))


def _blocks(graph: PoseGraph) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    e = len(graph.i)
    errors, hessians, gradients = np.empty((e, 3)), np.empty((e, 6, 6)), np.empty((e, 6))
    edges = graph.i, graph.j, graph.relative
    edge_errors(graph.poses, *edges, errors)
    linearise_edges(graph.poses, *edges, graph.information, graph.weight, errors, hessians, gradients)
    return errors, hessians, gradients


def edges_by_kernel(case: GraphCase) -> tuple[Any, ...]:
    return _blocks(case.graph)


def edges_by_textbook(case: GraphCase) -> tuple[Any, ...]:
    graph, out = case.graph, []
    for i, j, relative, omega in zip(graph.i, graph.j, graph.relative, graph.information, strict=True):
        ends = graph.poses[i], graph.poses[j], relative
        error = textbook.edge_error(*ends)
        jacobian = np.concatenate(textbook.edge_jacobians(*ends), axis=1)
        out.append((error, jacobian.T @ omega @ jacobian, -jacobian.T @ omega @ error))
    return tuple(np.stack(part) for part in zip(*out, strict=True))


def solved_by_kernel(case: GraphCase) -> tuple[Any, ...]:
    graph = case.graph
    system = SparseSystem(len(graph.nodes), np.column_stack([graph.i, graph.j]), np.array([case.start]))
    _, hessians, gradients = _blocks(graph)
    return (system.solve(hessians, gradients),)


def solved_by_textbook(case: GraphCase) -> tuple[Any, ...]:
    graph = case.graph
    n = len(graph.nodes)
    whole, right = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    _, hessians, gradients = _blocks(graph)
    for i, j, h, g in zip(graph.i, graph.j, hessians, gradients, strict=True):
        at = np.concatenate([3 * i + np.arange(3), 3 * j + np.arange(3)])
        whole[np.ix_(at, at)] += h
        right[at] += g
    free = np.repeat(np.arange(n) != case.start, 3)
    step = np.zeros(3 * n)
    step[free] = np.linalg.solve(whole[np.ix_(free, free)], right[free])
    return (step.reshape(n, 3),)


def ways_by_kernel(case: GraphCase) -> tuple[Any, ...]:
    graph, n = case.graph, len(case.way)
    out = np.empty(n)
    ways_from(case.start, case.way, graph.i[n - 1 :], graph.j[n - 1 :], out)
    return (out,)


def ways_by_textbook(case: GraphCase) -> tuple[Any, ...]:
    graph, n = case.graph, len(case.way)
    return (textbook.ways(case.start, case.way, np.column_stack([graph.i, graph.j])[n - 1 :]),)


def information_by_kernel(case: GraphCase) -> tuple[Any, ...]:
    out, prior = np.empty((3, 3)), np.array([0.5, 0.5, 2.0])
    write_information(case.hessian + np.diag(prior), prior, case.heading, 0.03, 50.0, FLOOR, out)
    return (out / np.abs(out).max(),)


def information_by_textbook(case: GraphCase) -> tuple[Any, ...]:
    prior = np.array([0.5, 0.5, 2.0])
    out = textbook.information(case.hessian + np.diag(prior), prior, case.heading, 0.03, 50.0, FLOOR)
    return (out / np.abs(out).max(),)


def nearest_by_kernel(case: GraphCase) -> tuple[Any, ...]:
    out = np.empty(len(case.graph.i), dtype=np.int64)
    least_of_ranges(case.graph.poses[:, 0], *_ranges(case), out)
    return (out,)


def nearest_by_textbook(case: GraphCase) -> tuple[Any, ...]:
    begin, end = _ranges(case)
    values = case.graph.poses[:, 0]
    return (np.array([a + np.argmin(values[a:b]) for a, b in zip(begin, end, strict=True)]),)


def _ranges(case: GraphCase) -> tuple[np.ndarray, np.ndarray]:
    graph = case.graph
    return np.minimum(graph.i, graph.j), np.maximum(graph.i, graph.j)


def agreement_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    """Of the second scan with both, and with each by itself."""
    counts, common = np.empty(3, dtype=np.int64), np.empty(2, dtype=np.int64)
    both, pose = np.arange(2), case.poses[1] + np.array([0.1, 0.05, 0.02])
    count_agreement(case.scans, 1, pose, both, case.poses, case.gate, 1, counts)
    count_common(case.scans, 1, pose, both, case.poses, case.gate, 1, common)
    return counts, common


def agreement_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    scans, pose = [point_scan(case.scans, k) for k in range(2)], case.poses[1] + np.array([0.1, 0.05, 0.02])
    whole = textbook.agreement(scans[1], pose, scans, case.poses, case.gate)
    each = [textbook.agreement(scans[1], pose, scans[k : k + 1], case.poses[k : k + 1], case.gate) for k in range(2)]
    return np.array(whole), np.array([counts[1] for counts in each])
