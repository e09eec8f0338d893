"""Point-to-line Gauss–Newton between scans, with correspondences by bearing.

A point of the moving scan is seen from where the other scan was taken; the point of the other scan nearest to it is
looked for among the beams around that bearing (projective data association: Blais & Levine 1995; of scans: Lu & Milios
1997), and its residual is the distance to the line through that point (Censi 2008). Numba twins of
:func:`mapper.matching.textbook.pairs_by_bearing` and of what :mod:`mapper.matching.textbook` makes of them.
"""

from __future__ import annotations

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import (
    CAUCHY,
    HUBER,
    NO_POINT,
    POINT_WITH_NORMAL,
    Iterations,
    PairRule,
    ScanArrays,
)


@jit
def _weight(kind: int, scale: float, e: float) -> float:
    """Return the weight of a residual e, both in metres."""
    if kind == CAUCHY:
        return 1.0 / (1.0 + (e / scale) * (e / scale))
    if kind == HUBER:
        return 1.0 if abs(e) <= scale else scale / abs(e)
    return 1.0


@jit
def _beam_of(scans: ScanArrays, x: float, y: float) -> int:
    """Return the beam in whose direction a point (x, y) from the sensor lies, −1 where no beam points there."""
    turned = atan2(y, x) - scans.first
    turned -= 2.0 * pi * floor(turned / (2.0 * pi))
    beam = int(turned / scans.step + 0.5)
    if beam < scans.points.shape[1]:
        return beam
    if scans.wraps or turned > 2.0 * pi - 0.5 * scans.step:
        return 0
    return -1


@jit
def _nearest(scans: ScanArrays, scan: int, x: float, y: float, gate: float, max_beams: int) -> int:
    """Return the beam of a scan whose point with a normal is nearest to (x, y), in its base frame, within ``gate``.

    −1 where there is none, −2 where (x, y) is outside the field of view.
    """
    to_x, to_y = x - scans.sensor_x, y - scans.sensor_y
    centre = _beam_of(scans, to_x, to_y)
    if centre < 0:
        return -2
    points, kind = scans.points[scan], scans.kind[scan]
    n_beams = len(kind)
    r = sqrt(to_x * to_x + to_y * to_y)
    best, found = gate * gate, -1
    for k in range(max_beams + 1):
        if k > 0:
            # A point k beams off is at least r · sin δ away, δ ≥ (k − ½) · step, and sin δ ≥ δ − δ³ / 6.
            angle = min((k - 0.5) * scans.step, 0.5 * pi)
            apart = r * (angle - angle * angle * angle / 6.0)
            if apart * apart >= best or 2 * k > n_beams:
                break
        for b in (centre - k, centre + k):
            if b < 0 or b >= n_beams:
                if not scans.wraps:
                    continue
                b += n_beams if b < 0 else -n_beams  # noqa: PLW2901
            if kind[b] == POINT_WITH_NORMAL:
                d_x, d_y = float(points[b, 0]) - x, float(points[b, 1]) - y
                square = d_x * d_x + d_y * d_y
                if square < best:
                    best, found = square, b
    return found


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
) -> tuple[int, int, float, float]:
    """Add the normal equations of scan i of ``moving`` at ``pose`` against scan j of ``fixed`` at ``at``.

    ``pose`` and ``at`` are ``T_map_base`` (3,). To ``hessian`` (3, 3) and ``gradient`` (3,) are added Σ w JᵀJ and
    −Σ w Jᵀe over the pairs, for the step dx of (x, y, θ) in the map frame that solves ``hessian`` dx = ``gradient``.
    Returns the number of pairs, the number of points that lie in the other scan's field of view, Σ e² and Σ w e².
    """
    c_i, s_i, c_j, s_j = cos(pose[2]), sin(pose[2]), cos(at[2]), sin(at[2])
    turn_c, turn_s = c_j * c_i + s_j * s_i, c_j * s_i - s_j * c_i  # of the rotation from base i to base j
    d_x, d_y = pose[0] - at[0], pose[1] - at[1]
    t_x, t_y = c_j * d_x + s_j * d_y, -s_j * d_x + c_j * d_y
    with_normal = rule.min_cosine > -1.0
    least = POINT_WITH_NORMAL if with_normal else NO_POINT + 1
    pairs, tried, squares, weighted = 0, 0, 0.0, 0.0
    h00, h01, h02, h11, h12, h22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g0, g1, g2 = 0.0, 0.0, 0.0
    for k in range(0, moving.points.shape[1], rule.stride):
        if moving.kind[i, k] < least:
            continue
        p_x, p_y = float(moving.points[i, k, 0]), float(moving.points[i, k, 1])
        r_x, r_y = turn_c * p_x - turn_s * p_y, turn_s * p_x + turn_c * p_y
        x, y = r_x + t_x, r_y + t_y
        q = _nearest(fixed, j, x, y, gate, rule.max_beams)
        if q == -2:
            continue
        tried += 1
        if q < 0:
            continue
        n_x, n_y = float(fixed.normals[j, q, 0]), float(fixed.normals[j, q, 1])
        if with_normal:
            m_x, m_y = float(moving.normals[i, k, 0]), float(moving.normals[i, k, 1])
            cosine = n_x * (turn_c * m_x - turn_s * m_y) + n_y * (turn_s * m_x + turn_c * m_y)
            if cosine < rule.min_cosine:
                continue
        e = n_x * (x - float(fixed.points[j, q, 0])) + n_y * (y - float(fixed.points[j, q, 1]))
        w = _weight(rule.weight, rule.scale, e)
        j_t = n_y * r_x - n_x * r_y
        pairs += 1
        squares += e * e
        weighted += w * e * e
        h00 += w * n_x * n_x
        h01 += w * n_x * n_y
        h02 += w * n_x * j_t
        h11 += w * n_y * n_y
        h12 += w * n_y * j_t
        h22 += w * j_t * j_t
        g0 -= w * n_x * e
        g1 -= w * n_y * e
        g2 -= w * j_t * e
    # From the axes of the other scan's base to those of the map.
    hessian[0, 0] += c_j * c_j * h00 - 2.0 * c_j * s_j * h01 + s_j * s_j * h11
    off = c_j * s_j * (h00 - h11) + (c_j * c_j - s_j * s_j) * h01
    hessian[0, 1] += off
    hessian[1, 0] += off
    hessian[1, 1] += s_j * s_j * h00 + 2.0 * c_j * s_j * h01 + c_j * c_j * h11
    hessian[0, 2] += c_j * h02 - s_j * h12
    hessian[2, 0] += c_j * h02 - s_j * h12
    hessian[1, 2] += s_j * h02 + c_j * h12
    hessian[2, 1] += s_j * h02 + c_j * h12
    hessian[2, 2] += h22
    gradient[0] += c_j * g0 - s_j * g1
    gradient[1] += s_j * g0 + c_j * g1
    gradient[2] += g2
    return pairs, tried, squares, weighted


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
    one, right = np.empty((3, 3)), np.empty(3)
    for k in range(len(first)):
        i, j = first[k], second[k]
        one[:], right[:] = 0.0, 0.0
        figures[k, 0], figures[k, 1], figures[k, 2], figures[k, 3] = accumulate_scan(
            scans, i, poses[i], scans, j, poses[j], gate, rule, one, right
        )
        # The second scan's step moves its lines: in x and y the opposite of the first one's, and turning it turns the
        # points around its own place, which is the turn of the first one less a shift.
        a, b = poses[i, 1] - poses[j, 1], poses[j, 0] - poses[i, 0]
        for u in range(3):
            gradients[k, u] = right[u]
            for v in range(3):
                hessians[k, u, v] = one[u, v]
        # J_second = −(J_x, J_y, J_θ − a J_x − b J_y)
        gradients[k, 3], gradients[k, 4] = -right[0], -right[1]
        gradients[k, 5] = -(right[2] - a * right[0] - b * right[1])
        for u in range(3):
            hessians[k, u, 3] = hessians[k, 3, u] = -one[u, 0]
            hessians[k, u, 4] = hessians[k, 4, u] = -one[u, 1]
            hessians[k, u, 5] = hessians[k, 5, u] = -(one[u, 2] - a * one[u, 0] - b * one[u, 1])
        for u in range(3):
            hessians[k, 3, 3 + u] = -hessians[k, 0, 3 + u]
            hessians[k, 4, 3 + u] = -hessians[k, 1, 3 + u]
            hessians[k, 5, 3 + u] = -(hessians[k, 2, 3 + u] - a * hessians[k, 0, 3 + u] - b * hessians[k, 1, 3 + u])


@jit
def solve_step(hessian: Float64Array, gradient: Float64Array, step: Float64Array) -> bool:
    """Write the solution (3,) of ``hessian`` · ``step`` = ``gradient``; return whether there is one.

    Cholesky's decomposition; a hessian with a pivot below 1e-12 of its largest diagonal element has none, and ``step``
    is 0 then.
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

    ``poses`` (n_scans of fixed, 3) and ``pose`` are ``T_map_base``; ``prior`` (3,) with ``prior_weight`` (3,), the
    inverse variances in units of the pairs' (0: none), pulls the pose. ``pose`` and ``hessian`` (3, 3), of the pairs
    and the prior at the last iteration's start, are written. Returns the number of pairs, the number of points in the
    others' fields of view, Σ e², Σ w e² and the number of iterations.
    """
    gradient, step = np.empty(3), np.empty(3)
    pairs, tried, squares, weighted, done = 0, 0, 0.0, 0.0, 0
    gate = iterations.first_gate
    for _ in range(iterations.most):
        hessian[:], gradient[:] = 0.0, 0.0
        pairs, tried, squares, weighted = 0, 0, 0.0, 0.0
        for j in others:
            a, b, c, d = accumulate_scan(moving, i, pose, fixed, j, poses[j], gate, rule, hessian, gradient)
            pairs += a
            tried += b
            squares += c
            weighted += d
        for u in range(3):
            off = pose[u] - prior[u]
            if u == 2:
                off -= 2.0 * pi * floor((off + pi) / (2.0 * pi))
            hessian[u, u] += prior_weight[u]
            gradient[u] -= prior_weight[u] * off
        done += 1
        if not solve_step(hessian, gradient, step):
            break
        pose[0] += step[0]
        pose[1] += step[1]
        pose[2] += step[2]
        if (
            gate <= iterations.last_gate
            and sqrt(step[0] * step[0] + step[1] * step[1]) < iterations.stop_m
            and abs(step[2]) < iterations.stop_rad
        ):
            break
        gate = max(gate * iterations.shrink, iterations.last_gate)
    pose[2] -= 2.0 * pi * floor((pose[2] + pi) / (2.0 * pi))
    return pairs, tried, squares, weighted, done
