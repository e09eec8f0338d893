"""Optimisation of a pose graph, with reduced weights for loops that contradict the rest.

Sources: Grisetti et al. 2010, A tutorial on graph-based SLAM, for the least squares; Yang et al. 2020, Graduated
non-convexity for robust spatial perception, for the robust kernel, whose scale starts so large that the problem is
nearly convex, and shrinks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import wrap_angle
from mapper.sensors.pose_graph import LOOP, PoseGraph
from mapper.slam.kernels.edges import edge_errors, linearise_edges, squared_errors
from mapper.slam.sparse_system import SparseSystem

MAX_ITERATIONS = 60
STOP = 1e-5  #: metres and radians: the iteration has converged when no step is larger
SHRINK = 0.25  #: factor of the squared scale of the kernel per iteration
GREATEST_TURN = 0.5  #: radians: maximum rotation of one step, within which the linearisation holds


def robust_weights(kernel: str, chi2: Float64Array, scale: float) -> Float64Array:
    """Return the weights (e,), 0 to 1, of a kernel for squared residuals ``chi2`` (e,) and a scale.

    Source: Zhang 1997, Parameter estimation techniques.
    """
    ratio = chi2 / (scale * scale)
    if kernel == "geman_mcclure":
        return np.asarray(1.0 / (1.0 + ratio) ** 2)
    if kernel == "cauchy":
        return np.asarray(1.0 / (1.0 + ratio))
    if kernel == "huber":
        return np.asarray(1.0 / np.sqrt(np.maximum(ratio, 1.0)))
    return np.ones_like(chi2)


def optimise(
    graph: PoseGraph,
    *,
    robust: str = "geman_mcclure",
    robust_scale: float = 3.0,
    max_iterations: int = MAX_ITERATIONS,
    system: SparseSystem | None = None,
    check: Callable[[], None] | None = None,
) -> PoseGraph:
    """Return the graph with the poses that minimise Σ ρ(eᵀ Ω e) over its edges, and their residuals and weights.

    The first node does not move. The robust kernel ρ (:func:`robust_weights`) applies to loops that are not locked; its
    scale starts at the largest residual. The starting poses are the graph's. ``system`` is a :class:`SparseSystem` of
    the graph's edges to reuse. ``check`` is called from time to time and may raise to cancel the work. Raises
    :class:`ConfigError` if the edges leave a pose undetermined.
    """
    m = len(graph.nodes)
    if m == 0 or not len(graph.i):
        return graph
    if system is None:
        system = SparseSystem(m, np.column_stack([graph.i, graph.j]), np.array([0]))
    poses = graph.poses.copy()
    e = len(graph.i)
    errors, chi2 = np.empty((e, 3)), np.empty(e)
    hessians, gradients = np.empty((e, 6, 6)), np.empty((e, 6))
    is_robust = (graph.kind == LOOP) & ~graph.locked & (robust != "none")
    weights = np.ones(e)
    square = robust_scale * robust_scale
    widening = 1.0
    edges = graph.i, graph.j, graph.relative

    def measure() -> None:
        edge_errors(poses, *edges, errors)
        squared_errors(errors, graph.information, chi2)

    def weigh(scale: float) -> None:
        weights[is_robust] = robust_weights(robust, chi2[is_robust], scale)

    measure()
    if is_robust.any():
        widening = max(1.0, 2.0 * float(chi2[is_robust].max()) / square)
    for _ in range(max_iterations):
        weigh(robust_scale * np.sqrt(widening))
        linearise_edges(poses, *edges, graph.information, weights, errors, hessians, gradients)
        step = system.solve(hessians, gradients, check=check)
        largest_turn = float(np.abs(step[:, 2]).max())
        if largest_turn > GREATEST_TURN:
            step *= GREATEST_TURN / largest_turn
        poses += step
        measure()
        if widening == 1.0 and float(np.abs(step).max()) < STOP:
            break
        widening = max(1.0, SHRINK * widening)
    weigh(robust_scale)
    poses[:, 2] = wrap_angle(poses[:, 2])
    return replace(graph, poses=poses, residual=np.sqrt(chi2), weight=weights.copy())


def optimise_newest(
    graph: PoseGraph, first: int, robust: str, robust_scale: float, max_iterations: int
) -> Float64Array:
    """Return the optimised poses (n − first, 3) of the nodes from row ``first`` on; earlier nodes do not move.

    ``first`` is at least 1; the other parameters are those of :func:`optimise`. The time depends on the number of
    moving nodes and their loops, not on the total number of nodes.
    """
    is_newest = (graph.i >= first) | (graph.j >= first)
    ends = np.column_stack([graph.i[is_newest], graph.j[is_newest]])
    used = np.unique(ends)
    rows = np.searchsorted(used, ends)
    part = replace(
        graph, nodes=graph.nodes[used], poses=graph.poses[used], i=rows[:, 0], j=rows[:, 1],
        relative=graph.relative[is_newest], information=graph.information[is_newest], kind=graph.kind[is_newest],
        locked=graph.locked[is_newest], residual=graph.residual[is_newest], weight=graph.weight[is_newest],
    )  # fmt: skip
    system = SparseSystem(len(used), rows, np.flatnonzero(used < first))
    solved = optimise(part, robust=robust, robust_scale=robust_scale, max_iterations=max_iterations, system=system)
    return solved.poses[used >= first]
