"""Graph optimisation as in the tutorial, with dense matrices and one edge at a time, and counts of scan agreement.

Source: Grisetti et al. 2010, A tutorial on graph-based SLAM, algorithm 1 and its equations for SE(2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse, transform_points, wrap_angle
from mapper.matching.textbook import PointScan, beam_towards, beams_around
from mapper.sensors.pose_graph import PoseGraph


def edge_error(pose_i: Float64Array, pose_j: Float64Array, relative: Float64Array) -> Float64Array:
    """Return e (3,): Z⁻¹ ∘ (Tᵢ⁻¹ ∘ Tⱼ), for three poses (3,)."""
    return compose(inverse(relative), compose(inverse(pose_i), pose_j))


def edge_jacobians(
    pose_i: Float64Array, pose_j: Float64Array, relative: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return ∂e/∂xᵢ and ∂e/∂xⱼ (3, 3), for increments that are added to x, y and theta."""
    c, s = np.cos(pose_i[2]), np.sin(pose_i[2])
    turn_i = np.array([[c, -s], [s, c]])
    derivative = np.array([[-s, -c], [c, -s]])
    cz, sz = np.cos(relative[2]), np.sin(relative[2])
    turn_z = np.array([[cz, -sz], [sz, cz]])
    a, b = np.zeros((3, 3)), np.zeros((3, 3))
    a[:2, :2] = -turn_z.T @ turn_i.T
    a[:2, 2] = turn_z.T @ derivative.T @ (pose_j[:2] - pose_i[:2])
    a[2, 2] = -1.0
    b[:2, :2] = turn_z.T @ turn_i.T
    b[2, 2] = 1.0
    return a, b


def optimise_dense(graph: PoseGraph) -> Float64Array:
    """Return the poses (m, 3) that minimise Σ eᵀ Ω e, by the Gauss–Newton method, with the first pose fixed."""
    poses = graph.poses.copy()
    m = len(poses)
    for _ in range(30):
        h, b = np.zeros((3 * m, 3 * m)), np.zeros(3 * m)
        for k, (i, j) in enumerate(zip(graph.i.tolist(), graph.j.tolist(), strict=True)):
            error = edge_error(poses[i], poses[j], graph.relative[k])
            jacobians = edge_jacobians(poses[i], poses[j], graph.relative[k])
            omega = graph.information[k]
            for index, first in zip((i, j), jacobians, strict=True):
                b[3 * index : 3 * index + 3] += first.T @ omega @ error
                for other, second in zip((i, j), jacobians, strict=True):
                    h[3 * index : 3 * index + 3, 3 * other : 3 * other + 3] += first.T @ omega @ second
        free = np.repeat(np.arange(m) != 0, 3)
        step = np.zeros(3 * m)
        step[free] = np.linalg.solve(h[np.ix_(free, free)], -b[free])
        poses += step.reshape(m, 3)
        poses[:, 2] = wrap_angle(poses[:, 2])
    return poses


def ways(start: int, driven: Float64Array, loops: NDArray[np.int64]) -> Float64Array:
    """Return the length (n,) of the shortest path from node ``start`` to each node of a chain, by Floyd's algorithm.

    ``driven`` (n,) is the distance driven up to each node; ``loops`` (l, 2) connect nodes with length 0.
    """
    n = len(driven)
    length = np.full((n, n), np.inf)
    np.fill_diagonal(length, 0.0)
    steps = np.diff(driven)
    for k in range(n - 1):
        length[k, k + 1] = length[k + 1, k] = steps[k]
    for i, j in loops.tolist():
        length[i, j] = length[j, i] = 0.0
    for k in range(n):
        length = np.minimum(length, length[:, k : k + 1] + length[k : k + 1])
    return np.asarray(length[start])


def information(
    hessian: Float64Array, prior: Float64Array, heading: float, false_share: float, scale: float, floor: Float64Array
) -> Float64Array:
    """Return the result of :func:`mapper.slam.kernels.information.write_information`, with NumPy's linear algebra."""
    pairs = hessian - np.diag(prior)
    values, vectors = np.linalg.eigh(pairs[:2, :2])
    shares = np.sqrt(np.maximum(values - false_share * values[1], 1e-9) / np.maximum(values, 1e-9))
    shrink = np.eye(3)
    shrink[:2, :2] = vectors @ np.diag(shares) @ vectors.T
    c, s = np.cos(heading), np.sin(heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    own = turn.T @ (shrink @ pairs @ shrink + np.diag(prior)) @ turn * scale + 1e-3 * np.eye(3)
    return np.asarray(np.linalg.inv(np.linalg.inv(own) + np.diag(floor**2)))


def agreement(
    moving: PointScan, pose: Float64Array, others: Sequence[PointScan], poses: Float64Array, gate: float
) -> tuple[int, int, int]:
    """Return the number of a scan's points, and how many agree with and contradict others at ``poses`` (k, 3).

    A point agrees if it is nearer than ``gate`` to a point of one of the others, among the beams that pass within a
    gate of it. It contradicts them if it does not agree and one of them saw through it: the beam that points there and
    its two neighbours all end two gates or more behind it.
    """
    agreeing = contradicting = 0
    placed = transform_points(pose, moving.points)[moving.is_point]
    for point in placed:
        is_near = is_free = False
        for other, at in zip(others, poses, strict=True):
            x = transform_points(inverse(at), point)
            beam = beam_towards(other, x)
            if beam < 0:
                continue
            r = float(np.linalg.norm(x - other.sensor))
            half = int(min(gate / max(r, 0.3), np.deg2rad(12.0)) / other.step) + 1
            around = beams_around(other, beam, half)
            around = around[other.is_point[around]]
            is_near |= bool((np.linalg.norm(other.points[around] - x, axis=1) < gate).any())
            three = beams_around(other, beam, 1)
            measured = np.linalg.norm(other.points[three] - other.sensor, axis=1)
            is_free |= len(three) == 3 and bool((other.is_point[three] & (measured >= r + 2.0 * gate)).all())
        agreeing += is_near
        contradicting += is_free and not is_near
    return len(placed), agreeing, contradicting
