"""Joint refinement: all scans are aligned with their spatial neighbours at once.

Source: Lu & Milios 1997, with point-to-line residuals (Censi 2008) in place of their relative poses.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.spatial import KDTree

from mapper.core.array_types import Float64Array, Int64Array
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


class PartedSystem:
    """The system H Δ = b over poses (n, 3) with contributions of ``pairs`` (p, 2) of them; the first pose is fixed.

    Up to ``most`` poses are one :class:`SparseSystem`, solved exactly. More are divided spatially into parts of at most
    ``most``, one of which is in memory at a time; each :meth:`solve` is one sweep over them, in alternating order.
    """

    def __init__(self, poses: Float64Array, pairs: Int64Array, most: int) -> None:
        self._n, self._pairs = len(poses), pairs
        self.parts = divided(poses[:, :2], most)
        self._whole = SparseSystem(self._n, pairs, np.array([0])) if len(self.parts) == 1 else None
        self.filled = 0  #: blocks of the largest factor so far

    def solve(
        self,
        hessians: Float64Array,
        gradients: Float64Array,
        damping: float = 0.0,
        check: Callable[[], None] | None = None,
    ) -> Float64Array:
        """Return Δ (n, 3) after one sweep, like :meth:`SparseSystem.solve`."""
        if self._whole is not None:
            self.filled = self._whole.filled
            return self._whole.solve(hessians, gradients, damping, check)
        step = np.zeros((self._n, 3))
        for part in self.parts:
            inside = np.zeros(self._n, dtype=np.bool_)
            inside[part] = True
            inside[0] = False
            rows = np.flatnonzero(inside[self._pairs].any(axis=1))
            pairs, blocks = self._pairs[rows], hessians[rows]
            known = step[pairs].reshape(-1, 6)
            sides = gradients[rows] - np.einsum("kab,kb->ka", blocks, known)
            system = SparseSystem(self._n, pairs, np.flatnonzero(~inside))
            step[inside] = system.solve(blocks, sides, damping, check)[inside]
            self.filled = max(self.filled, system.filled)
        self.parts.reverse()
        return step


def divided(places: Float64Array, most: int) -> list[Int64Array]:
    """Partition places (n, 2) into parts of at most ``most`` by halving across the longer side; return their indices.

    The indices of a part ascend.
    """
    parts = [np.arange(len(places), dtype=np.int64)]
    done: list[Int64Array] = []
    while parts:
        part = parts.pop()
        if len(part) <= most:
            done.append(part)
            continue
        along = places[part, int(np.argmax(np.ptp(places[part], axis=0)))]
        order = np.argsort(along, kind="stable")
        parts += [np.sort(part[order[len(part) // 2 :]]), np.sort(part[order[: len(part) // 2]])]
    return done


RADIUS = 2.0  #: metres: a larger radius has no benefit and fills the factor
MOST_NEAR = 400  #: scans within the radius that are considered
BLOCK = 64  #: scans whose neighbours are looked up at once
BEFORE = 2  #: previous scans with which each is aligned
FIRST_GATE, LAST_GATE, SHRINK = 0.3, 0.10, 0.7
SCALE = 0.05  #: metres: residuals from which pairs lose weight
LEAST_SHARE, LEAST_PAIRS = 0.35, 25
COARSE = 2  #: beam stride until the last iteration
SECOND_SEARCH = 2  #: iteration before which the neighbours are searched again
EDGE_SHARE = 0.2  #: factor of the graph's information, because the pairs use the same points
DAMPING = 1e-9
PARTS = 16  #: parts of the pairs, computed on all cores; the sums do not depend on it
MOST_JOINT = 4_000  #: poses solved at once; more are divided spatially, so that memory stays bounded
MOST_AT_ONCE = 10_000  #: pairs between two checks for cancellation


def refine(
    graph: PoseGraph,
    store: ScanStore,
    config: SlamConfig,
    progress: Callable[[float, Float64Array], None] | None = None,
    check: Callable[[], None] | None = None,
) -> Float64Array:
    """Return the poses (m, 3) after the iterations of the config; ``progress`` receives the fraction done and the
    poses.

    ``check`` is called from time to time and may raise to cancel the work.
    """
    poses = graph.poses.copy()
    m = len(poses)
    iterations = int(config.refinement)
    if m < 3 or iterations == 0:
        return poses
    scans, rule = store.arrays, pair_rule(store.least_step)._replace(scale=SCALE)
    edges = graph.i, graph.j, graph.relative
    e = len(graph.i)
    errors = np.empty((e, 3))
    gate = FIRST_GATE
    scale = CORRELATION / NOISE**2
    first = second = np.zeros(0, dtype=np.int64)
    system: PartedSystem | None = None
    hessians, gradients = np.empty((0, 6, 6)), np.empty((0, 6))
    for done in range(1, iterations + 1):
        if system is None or done == SECOND_SEARCH:
            pairs = neighbour_pairs(poses, int(config.refinement_neighbours), BEFORE * store.n_sensors, check)
            first, second = pairs.T.copy()
            ends = np.column_stack([np.r_[first, edges[0]], np.r_[second, edges[1]]])
            system = PartedSystem(poses, ends, MOST_JOINT)
            hessians, gradients = np.empty((len(ends), 6, 6)), np.empty((len(ends), 6))
        # Until the last iteration half of the beams are enough.
        stride = 1 if done == iterations else COARSE
        p = len(first)
        blocks, sides = hessians[:p], gradients[:p]
        rows = scans, first, second, poses, gate, rule._replace(stride=stride)
        figures = _accumulated(*rows, blocks, sides, check)
        few = (stride * figures[:, 0] < LEAST_PAIRS) | (figures[:, 0] < LEAST_SHARE * figures[:, 1])
        blocks[few], sides[few] = 0.0, 0.0
        blocks *= stride * scale
        sides *= stride * scale
        edge_errors(poses, *edges, errors)
        weights = EDGE_SHARE * graph.weight
        linearise_edges(poses, *edges, graph.information, weights, errors, hessians[p:], gradients[p:])
        poses += system.solve(hessians, gradients, DAMPING, check)
        poses[:, 2] = wrap_angle(poses[:, 2])
        gate = max(gate * SHRINK, LAST_GATE)
        if progress is not None:
            progress(done / iterations, poses)
    return poses


def _accumulated(
    scans: ScanArrays, first: Int64Array, second: Int64Array, poses: Float64Array, gate: float, rule: PairRule,
    hessians: Float64Array, gradients: Float64Array, check: Callable[[], None] | None,
) -> Float64Array:  # fmt: skip
    """Write ``hessians`` and ``gradients`` like :func:`accumulate_pairs`, on all cores; return its figures (p, 4).

    ``check`` is called after every :data:`MOST_AT_ONCE` pairs.
    """
    p = len(first)
    figures = np.empty((p, 4))
    for begin in range(0, p, MOST_AT_ONCE):
        of_share = shares(min(MOST_AT_ONCE, p - begin), PARTS)
        in_parallel(
            [
                partial(
                    accumulate_pairs, scans, first[a:b], second[a:b], poses, gate, rule,
                    hessians[a:b], gradients[a:b], figures[a:b],
                )
                for a, b in ((begin + low, begin + high) for low, high in of_share)
            ]
        )  # fmt: skip
        if check is not None:
            check()
    return figures


def neighbour_pairs(
    poses: Float64Array, n: int, before: int = BEFORE, check: Callable[[], None] | None = None
) -> Int64Array:
    """Return pairs (p, 2) of poses to align: each with the ``before`` previous ones and with ``n`` nearby.

    Half of the ``n`` are the nearest in position and heading (1 rad counts as 1 m), the others are evenly spread over
    the rest within :data:`RADIUS`. If there are more than :data:`MOST_NEAR`, an evenly spread subset is considered. The
    roles of points and lines alternate between pairs, because each assignment favours one direction. ``check`` is
    called from time to time.
    """
    m = len(poses)
    tree = KDTree(poses[:, :2])
    neighbours = [np.zeros((0, 2), dtype=np.int64)]
    for begin in range(0, m, BLOCK):
        if check is not None:
            check()
        rows = np.arange(begin, min(begin + BLOCK, m))
        near = tree.query_ball_point(poses[rows, :2], RADIUS, return_sorted=True)
        for row, others in zip(rows.tolist(), near, strict=True):
            earlier = np.array(others[: bisect_left(others, row - before)], dtype=np.int64)
            if len(earlier) > MOST_NEAR:
                earlier = earlier[np.arange(MOST_NEAR) * len(earlier) // MOST_NEAR]
            cost = np.hypot(*(poses[earlier, :2] - poses[row, :2]).T)
            cost += np.abs(wrap_angle(poses[earlier, 2] - poses[row, 2]))
            earlier = earlier[np.argsort(cost, kind="stable")]
            rest = earlier[n // 2 :]
            count = min(n - n // 2, len(rest))
            spread = rest[(np.arange(count) + 1) * len(rest) // max(count, 1) - 1]
            chosen = np.concatenate([earlier[: n // 2], spread])
            neighbours.append(np.column_stack([chosen, np.full(len(chosen), row)]))
    neighbours += [np.column_stack([np.arange(m - k), np.arange(k, m)]) for k in range(1, min(before, m - 1) + 1)]
    pairs = np.concatenate(neighbours)
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    flipped = pairs.sum(axis=1) % 2 == 1
    pairs[flipped] = pairs[flipped, ::-1]
    return np.ascontiguousarray(pairs)
