"""Joint refinement: all scans aligned with their neighbours in space at once.

Source: Lu & Milios 1997, with point-to-line residuals (Censi 2008) in place of their relative poses.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from mapper.core.parallel import in_parallel, shares
from mapper.core.se2 import wrap_angle
from mapper.matching.kernels.point_to_line import accumulate_pairs
from mapper.matching.kernels.types import PairRule, ScanArrays
from mapper.sensors.pose_graph import PoseGraph
from mapper.slam.config import SlamConfig
from mapper.slam.kernels.edges import edge_errors, linearise_edges
from mapper.slam.matching_rules import CORRELATION, NOISE, pair_rule
from mapper.slam.scan_store import ScanStore
from mapper.slam.sparse_system import SparseSystem

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

RADIUS = 3.0  #: metres
BEFORE = 4  #: scans before each one that it is aligned with
FIRST_GATE, LAST_GATE, SHRINK = 0.3, 0.10, 0.7
LEAST_SHARE, LEAST_PAIRS = 0.35, 25
SECOND_SEARCH = 3  #: the iteration before which the neighbours are looked for again
EDGE_SHARE = 0.2  #: of the graph's information that counts, for the same points are in the pairs
DAMPING = 1e-9
PARTS = 16  #: of the pairs, computed on all cores; the sums do not depend on it


def refine(
    graph: PoseGraph,
    store: ScanStore,
    config: SlamConfig,
    progress: Callable[[float, Float64Array], None] | None = None,
) -> Float64Array:
    """Return the poses (m, 3) after the iterations of the config; ``progress`` gets the share done and the poses."""
    poses = graph.poses.copy()
    m = len(poses)
    iterations = int(config.refinement)
    if m < 3 or iterations == 0:
        return poses
    scans, rule = store.arrays, pair_rule(store.arrays)
    edges = graph.i, graph.j, graph.relative
    e = len(graph.i)
    errors, blocks, sides = np.empty((e, 3)), np.empty((e, 6, 6)), np.empty((e, 6))
    gate = FIRST_GATE
    scale = CORRELATION / NOISE**2
    first = second = np.zeros(0, dtype=np.int64)
    system: SparseSystem | None = None
    for done in range(1, iterations + 1):
        if system is None or done == SECOND_SEARCH:
            pairs = neighbour_pairs(poses, int(config.refinement_neighbours))
            first, second = np.concatenate([pairs, pairs[:, ::-1]]).T.copy()
            ends = np.column_stack([np.r_[first, edges[0]], np.r_[second, edges[1]]])
            system = SparseSystem(m, ends, np.array([0]))
        hessians, gradients, figures = _accumulated(scans, first, second, poses, gate, rule)
        few = (figures[:, 0] < LEAST_PAIRS) | (figures[:, 0] < LEAST_SHARE * figures[:, 1])
        hessians[few], gradients[few] = 0.0, 0.0
        edge_errors(poses, *edges, errors)
        linearise_edges(poses, *edges, graph.information, EDGE_SHARE * graph.weight, errors, blocks, sides)
        poses += system.solve(
            np.concatenate([hessians * scale, blocks]), np.concatenate([gradients * scale, sides]), DAMPING
        )
        poses[:, 2] = wrap_angle(poses[:, 2])
        gate = max(gate * SHRINK, LAST_GATE)
        if progress is not None:
            progress(done / iterations, poses)
    return poses


def _accumulated(
    scans: ScanArrays, first: Int64Array, second: Int64Array, poses: Float64Array, gate: float, rule: PairRule
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return what :func:`accumulate_pairs` writes, computed on all cores."""
    p = len(first)
    hessians, gradients, figures = np.empty((p, 6, 6)), np.empty((p, 6)), np.empty((p, 4))
    in_parallel(
        [
            partial(
                accumulate_pairs, scans, first[a:b], second[a:b], poses, gate, rule,
                hessians[a:b], gradients[a:b], figures[a:b],
            )
            for a, b in shares(p, PARTS)
        ]
    )  # fmt: skip
    return hessians, gradients, figures


def neighbour_pairs(poses: Float64Array, n: int) -> Int64Array:
    """Return pairs (p, 2) of poses to align, the later one first: each with the ones before it and with ``n`` nearby.

    Half of the ``n`` are the nearest in place and heading (1 rad counts as 1 m), the others are spread evenly over the
    rest within :data:`RADIUS`.
    """
    found = []
    tree = KDTree(poses[:, :2])
    near = tree.query_pairs(RADIUS, output_type="ndarray")
    near = np.concatenate([near, near[:, ::-1]])
    near = near[near[:, 0] - near[:, 1] > BEFORE]
    cost = np.hypot(*(poses[near[:, 0], :2] - poses[near[:, 1], :2]).T) + np.abs(
        wrap_angle(poses[near[:, 0], 2] - poses[near[:, 1], 2])
    )
    order = np.lexsort((near[:, 1], cost, near[:, 0]))
    near = near[order]
    starts = np.searchsorted(near[:, 0], np.arange(len(poses) + 1))
    for k in range(len(poses)):
        before = np.arange(max(0, k - BEFORE), k)
        own = near[starts[k] : starts[k + 1], 1]
        half = n // 2
        rest = own[half:]
        if len(rest) > n - half:
            rest = rest[np.linspace(0, len(rest) - 1, n - half).astype(np.int64)]
        others = np.concatenate([before, own[:half], rest])
        found.append(np.column_stack([np.full(len(others), k), others]))
    return np.concatenate(found)
