"""Gauss–Newton alignment of scans, with correspondences by bearing.

The residual of a point is its distance to the line through the corresponding point of the other scan
(:mod:`mapper.matching.kernels.views`): Censi 2008. With the residual POINTS it is the vector to that point: Besl &
McKay 1992. Numba twins of :func:`mapper.matching.textbook.pairs_by_bearing` and the functions of
:mod:`mapper.matching.textbook` that use it.
"""

from __future__ import annotations

from math import cos, floor, pi, sin, sqrt

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import (
    CAUCHY,
    HUBER,
    LINE,
    POINT,
    POINT_WITH_NORMAL,
    Iterations,
    PairRule,
    ScanArrays,
)
from mapper.matching.kernels.views import _pair_points


@jit
def _weight(kind: int, scale: float, e: float) -> float:
    """Return the weight of a residual e, both in metres."""
    if kind == CAUCHY:
        return 1.0 / (1.0 + (e / scale) * (e / scale))
    if kind == HUBER:
        return 1.0 if abs(e) <= scale else scale / abs(e)
    return 1.0


@jit
def _of_other(hessian: Float64Array, gradient: Float64Array, a: float, b: float) -> None:
    """Transform normal equations for a step of the moving scan to those for a step of the other scan, in place.

    A step of the other scan moves its lines in the opposite direction in x and y, and rotates them about its own
    position, (a, b): its J is −(J_x, J_y, J_θ − a J_x − b J_y).
    """
    for u in range(3):
        hessian[u, 2] -= a * hessian[u, 0] + b * hessian[u, 1]
    for u in range(3):
        hessian[2, u] -= a * hessian[0, u] + b * hessian[1, u]
    gradient[0], gradient[1], gradient[2] = (
        -gradient[0],
        -gradient[1],
        -(gradient[2] - a * gradient[0] - b * gradient[1]),
    )


@jit
def accumulate_scan(
    moving: ScanArrays,
    i: int,
    pose: Float64Array,
    fixed: ScanArrays,
    j: int,
    at: Float64Array,
    gate: float,
    rule: PairRule,
    hessian: Float64Array,
    gradient: Float64Array,
    begin: int = 0,
) -> tuple[int, int, float, float]:
    """Add the normal equations of scan i of ``moving`` at ``pose`` against scan j of ``fixed`` at ``at``.

    ``pose`` and ``at`` are ``T_map_base`` (3,). To ``hessian`` (3, 3) and ``gradient`` (3,) are added Σ w JᵀJ and −Σ w
    Jᵀe over the pairs, for the step dx of (x, y, θ) in the map frame that solves ``hessian`` dx = ``gradient``. Beams
    ``begin``, ``begin`` + ``rule.stride``, … of scan i are paired. Returns the number of pairs, the number of points in
    the other scan's field of view, Σ e² and Σ w e².
    """
    c_i, s_i, c_j, s_j = cos(pose[2]), sin(pose[2]), cos(at[2]), sin(at[2])
    turn_c, turn_s = c_j * c_i + s_j * s_i, c_j * s_i - s_j * c_i  # rotation from base i to base j
    d_x, d_y = pose[0] - at[0], pose[1] - at[1]
    t_x, t_y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
    by_normal, to_line = rule.min_cosine > -1.0, rule.residual == LINE
    pair_kind = POINT_WITH_NORMAL if by_normal or to_line else POINT
    points, normals, kind = moving.points[i], moving.normals[i], moving.kind[i]
    lines, line_normals = fixed.points[j], fixed.normals[j]
    room = moving.n_beams[i] // rule.stride + 1
    beams, xy, n = np.empty(room, dtype=np.int64), np.empty((room, 2)), 0
    for k in range(begin, moving.n_beams[i], rule.stride):
        if kind[k] >= (POINT_WITH_NORMAL if by_normal else POINT):
            p_x, p_y = np.float64(points[k, 0]), np.float64(points[k, 1])
            xy[n, 0], xy[n, 1] = turn_c * p_x - turn_s * p_y + t_x, turn_s * p_x + turn_c * p_y + t_y
            beams[n] = k
            n += 1
    nearest = np.empty(n, dtype=np.int64)
    _pair_points(fixed, j, xy, n, gate, rule.max_beams, pair_kind, nearest)
    paired = np.empty((n, 6))  # for each pair: the point rotated and placed, and its partner
    pairs, tried = 0, 0
    for p in range(n):
        k, q = beams[p], nearest[p]
        if q == -2:
            continue
        tried += 1
        if q < 0:
            continue
        n_x, n_y = np.float64(line_normals[q, 0]), np.float64(line_normals[q, 1])
        if by_normal:
            m_x, m_y = np.float64(normals[k, 0]), np.float64(normals[k, 1])
            cosine = n_x * (turn_c * m_x - turn_s * m_y) + n_y * (turn_s * m_x + turn_c * m_y)
            if cosine < rule.min_cosine:
                continue
        p_x, p_y = np.float64(points[k, 0]), np.float64(points[k, 1])
        e_x, e_y = xy[p, 0] - np.float64(lines[q, 0]), xy[p, 1] - np.float64(lines[q, 1])
        r_x, r_y = turn_c * p_x - turn_s * p_y, turn_s * p_x + turn_c * p_y
        paired[pairs, 0], paired[pairs, 1], paired[pairs, 2], paired[pairs, 3] = r_x, r_y, n_x, n_y
        if to_line:
            paired[pairs, 4] = n_x * e_x + n_y * e_y
        else:
            paired[pairs, 4], paired[pairs, 5] = e_x, e_y
        pairs += 1
    greatest = 1e300
    if rule.keep < 1.0 and pairs > 0:
        squares_of = paired[:pairs, 4] ** 2
        if not to_line:
            squares_of += paired[:pairs, 5] ** 2
        squares_of.sort()
        greatest = squares_of[min(max(int(rule.keep * pairs), 1), pairs) - 1]
    count, squares, weighted = 0, 0.0, 0.0
    h00, h01, h02, h11, h12, h22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g0, g1, g2 = 0.0, 0.0, 0.0
    for k in range(pairs):
        r_x, r_y, n_x, n_y, e, e_y = paired[k, 0], paired[k, 1], paired[k, 2], paired[k, 3], paired[k, 4], paired[k, 5]
        if to_line:
            square = e * e
            if square > greatest:
                continue
            w = _weight(rule.weight, rule.scale, e)
            j_t = n_y * r_x - n_x * r_y
            h00 += w * n_x * n_x
            h01 += w * n_x * n_y
            h02 += w * n_x * j_t
            h11 += w * n_y * n_y
            h12 += w * n_y * j_t
            h22 += w * j_t * j_t
            g0 -= w * n_x * e
            g1 -= w * n_y * e
            g2 -= w * j_t * e
        else:
            square = e * e + e_y * e_y
            if square > greatest:
                continue
            w = _weight(rule.weight, rule.scale, sqrt(square))
            h00 += w
            h02 -= w * r_y
            h11 += w
            h12 += w * r_x
            h22 += w * (r_x * r_x + r_y * r_y)
            g0 -= w * e
            g1 -= w * e_y
            g2 -= w * (r_x * e_y - r_y * e)
        count += 1
        squares += square
        weighted += w * square
    # From the axes of the other scan's base to those of the map.
    off = c_j * s_j * (h00 - h11) + (c_j * c_j - s_j * s_j) * h01
    x_t, y_t = c_j * h02 - s_j * h12, s_j * h02 + c_j * h12
    hessian[0, 0] += c_j * c_j * h00 - 2.0 * c_j * s_j * h01 + s_j * s_j * h11
    hessian[0, 1] += off
    hessian[1, 0] += off
    hessian[1, 1] += s_j * s_j * h00 + 2.0 * c_j * s_j * h01 + c_j * c_j * h11
    hessian[0, 2] += x_t
    hessian[2, 0] += x_t
    hessian[1, 2] += y_t
    hessian[2, 1] += y_t
    hessian[2, 2] += h22
    gradient[0] += c_j * g0 - s_j * g1
    gradient[1] += s_j * g0 + c_j * g1
    gradient[2] += g2
    return count, tried, squares, weighted


@jit
def accumulate_pairs(
    scans: ScanArrays,
    first: Int64Array,
    second: Int64Array,
    poses: Float64Array,
    gate: float,
    rule: PairRule,
    hessians: Float64Array,
    gradients: Float64Array,
    figures: Float64Array,
) -> None:
    """Write the normal equations of pairs of scans for the steps of both poses, for joint refinement.

    Pair k is scan ``first``[k] against scan ``second``[k]; ``poses`` (n_scans, 3) are ``T_map_base``. Written are
    ``hessians`` (n_pairs, 6, 6) and ``gradients`` (n_pairs, 6), over (x, y, θ) of the first and then of the second
    scan, and ``figures`` (n_pairs, 4): pairs of points, points in the field of view, Σ e², Σ w e².
    """
    matrix, right = np.empty((3, 3)), np.empty(3)
    for k in range(len(first)):
        i, j = first[k], second[k]
        matrix[:], right[:] = 0.0, 0.0
        figures[k, 0], figures[k, 1], figures[k, 2], figures[k, 3] = accumulate_scan(
            scans, i, poses[i], scans, j, poses[j], gate, rule, matrix, right
        )
        a, b = poses[i, 1] - poses[j, 1], poses[j, 0] - poses[i, 0]
        for u in range(3):
            gradients[k, u] = right[u]
            for v in range(3):
                hessians[k, u, v] = matrix[u, v]
            hessians[k, u, 3] = hessians[k, 3, u] = -matrix[u, 0]
            hessians[k, u, 4] = hessians[k, 4, u] = -matrix[u, 1]
            hessians[k, u, 5] = hessians[k, 5, u] = -(matrix[u, 2] - a * matrix[u, 0] - b * matrix[u, 1])
        _of_other(matrix, right, a, b)
        for u in range(3):
            gradients[k, 3 + u] = right[u]
            for v in range(3):
                hessians[k, 3 + u, 3 + v] = matrix[u, v]


@jit
def solve_step(hessian: Float64Array, gradient: Float64Array, step: Float64Array) -> bool:
    """Solve ``hessian`` · ``step`` = ``gradient`` for ``step`` (3,); return whether there is a solution.

    Cholesky decomposition. A Hessian with a pivot below 1e-12 of its largest diagonal element has no solution, and
    ``step`` is then 0.
    """
    step[0] = step[1] = step[2] = 0.0
    least = 1e-12 * max(hessian[0, 0], hessian[1, 1], hessian[2, 2])
    d0 = hessian[0, 0]
    if not d0 > least:
        return False
    l00 = sqrt(d0)
    l10, l20 = hessian[1, 0] / l00, hessian[2, 0] / l00
    d1 = hessian[1, 1] - l10 * l10
    if not d1 > least:
        return False
    l11 = sqrt(d1)
    l21 = (hessian[2, 1] - l20 * l10) / l11
    d2 = hessian[2, 2] - l20 * l20 - l21 * l21
    if not d2 > least:
        return False
    l22 = sqrt(d2)
    y0 = gradient[0] / l00
    y1 = (gradient[1] - l10 * y0) / l11
    y2 = (gradient[2] - l20 * y0 - l21 * y1) / l22
    step[2] = y2 / l22
    step[1] = (y1 - l21 * step[2]) / l11
    step[0] = (y0 - l10 * step[1] - l20 * step[2]) / l00
    return True


@jit
def _take_step(
    hessian: Float64Array,
    gradient: Float64Array,
    iterations: Iterations,
    gate: float,
    pose: Float64Array,
    step: Float64Array,
) -> bool:
    """Add the Gauss–Newton step to ``pose``; return whether another iteration may change it further."""
    if not solve_step(hessian, gradient, step):
        return False
    pose[0] += step[0]
    pose[1] += step[1]
    pose[2] += step[2]
    length = sqrt(step[0] * step[0] + step[1] * step[1])
    return gate > iterations.last_gate or length >= iterations.stop_m or abs(step[2]) >= iterations.stop_rad


@jit
def refine_pose(
    moving: ScanArrays,
    i: int,
    fixed: ScanArrays,
    others: Int64Array,
    poses: Float64Array,
    prior: Float64Array,
    prior_weight: Float64Array,
    rule: PairRule,
    iterations: Iterations,
    pose: Float64Array,
    hessian: Float64Array,
) -> tuple[int, int, float, float, int]:
    """Refine ``pose`` (3,) of scan i of ``moving`` against the scans ``others`` (k,) of ``fixed`` at their ``poses``.

    With a stride, each of the others is paired with different beams of scan i, and the sums are multiplied by the
    stride; until the last gate the stride is doubled. ``poses`` (n_scans of fixed, 3) and ``pose`` are ``T_map_base``.
    ``prior`` (3,) with ``prior_weight`` (3,), the inverse variances in units of the pairs' (0: none), constrains the
    pose. ``pose`` and ``hessian`` (3, 3), of the pairs and the prior at the start of the last iteration, are written.
    Returns the number of pairs, the number of points in the others' fields of view, Σ e², Σ w e² and the number of
    iterations.
    """
    gradient, step = np.empty(3), np.empty(3)
    pairs, tried, squares, weighted, done = 0, 0, 0.0, 0.0, 0
    gate = iterations.first_gate
    for _ in range(iterations.most):
        hessian[:], gradient[:] = 0.0, 0.0
        pairs, tried, squares, weighted = 0, 0, 0.0, 0.0
        stride = rule.stride if gate <= iterations.last_gate else 2 * rule.stride
        now = PairRule(rule.min_cosine, rule.max_beams, rule.weight, rule.scale, stride, rule.keep, rule.residual)
        for k in range(len(others)):
            j = others[k]
            a, b, c, d = accumulate_scan(moving, i, pose, fixed, j, poses[j], gate, now, hessian, gradient, k % stride)
            pairs += a
            tried += b
            squares += c
            weighted += d
        pairs, tried, squares, weighted = stride * pairs, stride * tried, stride * squares, stride * weighted
        for u in range(3):
            gradient[u] *= stride
            for v in range(3):
                hessian[u, v] *= stride
        for u in range(3):
            off = pose[u] - prior[u]
            if u == 2:
                off -= 2.0 * pi * floor((off + pi) / (2.0 * pi))
            hessian[u, u] += prior_weight[u]
            gradient[u] -= prior_weight[u] * off
        done += 1
        if not _take_step(hessian, gradient, iterations, gate, pose, step):
            break
        gate = max(gate * iterations.shrink, iterations.last_gate)
    pose[2] -= 2.0 * pi * floor((pose[2] + pi) / (2.0 * pi))
    return pairs, tried, squares, weighted, done


@jit
def refine_pair(
    moving: ScanArrays,
    i: int,
    fixed: ScanArrays,
    j: int,
    at: Float64Array,
    rule: PairRule,
    iterations: Iterations,
    pose: Float64Array,
    hessian: Float64Array,
) -> tuple[int, int, float, float, int]:
    """Refine ``pose`` (3,) of scan i of ``moving`` against scan j of ``fixed`` at ``at`` (3,), with pairs in both
    directions.

    Like :func:`refine_pose` without a prior, but the points of scan j are also paired with scan i, so that neither
    scan's normals and gaps count more. The scale of the weight is at least a quarter of the gate, so that pairs count
    while the pose is still far off; until the last gate half of the beams are used. ``hessian`` (3, 3) and the sums
    cover both directions.
    """
    gradient, step, back, right = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty(3)
    pairs, tried, squares, weighted, done = 0, 0, 0.0, 0.0, 0
    gate = iterations.first_gate
    for _ in range(iterations.most):
        hessian[:], gradient[:], back[:], right[:] = 0.0, 0.0, 0.0, 0.0
        scale = max(rule.scale, 0.25 * gate)
        stride = rule.stride if gate <= iterations.last_gate else 2 * rule.stride
        now = PairRule(rule.min_cosine, rule.max_beams, rule.weight, scale, stride, rule.keep, rule.residual)
        pairs, tried, squares, weighted = accumulate_scan(moving, i, pose, fixed, j, at, gate, now, hessian, gradient)
        n, m, e, w = accumulate_scan(fixed, j, at, moving, i, pose, gate, now, back, right)
        pairs += n
        tried += m
        squares += e
        weighted += w
        _of_other(back, right, at[1] - pose[1], pose[0] - at[0])
        for u in range(3):
            gradient[u] += right[u]
            for v in range(3):
                hessian[u, v] += back[u, v]
        done += 1
        if not _take_step(hessian, gradient, iterations, gate, pose, step):
            break
        gate = max(gate * iterations.shrink, iterations.last_gate)
    pose[2] -= 2.0 * pi * floor((pose[2] + pi) / (2.0 * pi))
    return pairs, tried, squares, weighted, done
