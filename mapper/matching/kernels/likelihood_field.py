"""Gauss–Newton alignment of a scan on a smooth score field: scan to map without correspondences.

Source: Kohlbrecher et al. 2011, equations 4 to 14 (Hector SLAM); Hess et al. 2016, equation CS, with a bilinear field.
Numba twin of :func:`mapper.matching.textbook.field_residuals`.
"""

from __future__ import annotations

from math import cos, floor, pi, sin

import numpy as np

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, to_lattice
from mapper.matching.kernels.point_to_line import _take_step
from mapper.matching.kernels.types import NO_POINT, Iterations, ScanArrays

_to_lattice = jit(to_lattice)


@jit
def accumulate_field(
    scores: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    stride: int,
    hessian: Float64Array,
    gradient: Float64Array,
) -> tuple[int, float]:
    """Write the normal equations of scan i at ``pose`` (3,) for the residuals e = 1 − M(R p + t) of its points.

    M is ``scores`` / 255, bilinear between cell centres; every ``stride``-th of the points that lie between four
    centres counts. Written are ``hessian`` (3, 3) Σ JᵀJ and ``gradient`` (3,) −Σ Jᵀe. Returns the number of points and
    Σ e².
    """
    rows, cols = scores.shape
    c, s = cos(pose[2]), sin(pose[2])
    hessian[:], gradient[:] = 0.0, 0.0
    inside, squares = 0, 0.0
    for k in range(0, scans.points.shape[1], stride):
        if scans.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
        r_x, r_y = c * p_x - s * p_y, s * p_x + c * p_y
        u, v = _to_lattice(pose[0] + r_x, pose[1] + r_y, frame)
        u, v = u - 0.5, v - 0.5
        left, below = floor(u), floor(v)
        if not (0.0 <= left < cols - 1 and 0.0 <= below < rows - 1):
            continue
        col, row = int(left), int(below)
        f_u, f_v = u - left, v - below
        m00, m01 = np.float64(scores[row, col]), np.float64(scores[row, col + 1])
        m10, m11 = np.float64(scores[row + 1, col]), np.float64(scores[row + 1, col + 1])
        value = (1.0 - f_v) * ((1.0 - f_u) * m00 + f_u * m01) + f_v * ((1.0 - f_u) * m10 + f_u * m11)
        by_u = ((1.0 - f_v) * (m01 - m00) + f_v * (m11 - m10)) / (255.0 * frame.resolution)
        by_v = ((1.0 - f_u) * (m10 - m00) + f_u * (m11 - m01)) / (255.0 * frame.resolution)
        e = 1.0 - value / 255.0
        j_x = -(frame.cos_yaw * by_u - frame.sin_yaw * by_v)
        j_y = -(frame.sin_yaw * by_u + frame.cos_yaw * by_v)
        j_t = j_y * r_x - j_x * r_y
        inside += 1
        squares += e * e
        hessian[0, 0] += j_x * j_x
        hessian[0, 1] += j_x * j_y
        hessian[0, 2] += j_x * j_t
        hessian[1, 1] += j_y * j_y
        hessian[1, 2] += j_y * j_t
        hessian[2, 2] += j_t * j_t
        gradient[0] -= j_x * e
        gradient[1] -= j_y * e
        gradient[2] -= j_t * e
    hessian[1, 0], hessian[2, 0], hessian[2, 1] = hessian[0, 1], hessian[0, 2], hessian[1, 2]
    return inside, squares


@jit
def refine_on_field(
    scores: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    stride: int,
    iterations: Iterations,
    pose: Float64Array,
    hessian: Float64Array,
) -> tuple[int, float, int]:
    """Refine ``pose`` (3,) of scan i on a field, see :func:`accumulate_field`, without gates.

    The iteration ends when a step would increase Σ e² of the points, counting 1 for those outside; that step is undone.
    ``hessian`` (3, 3) is that at the pose before the last step. Returns the number of points inside, Σ e² and the
    number of iterations.
    """
    gradient, step, before, trial = np.empty(3), np.empty(3), pose.copy(), np.empty((3, 3))
    count = 0
    for k in range(0, scans.points.shape[1], stride):
        if scans.kind[i, k] != NO_POINT:
            count += 1
    inside, squares, done, least = 0, 0.0, 0, 1e300
    for _ in range(iterations.most):
        n, e = accumulate_field(scores, frame, scans, i, pose, stride, trial, gradient)
        cost = e + (count - n)
        if cost >= least:
            pose[:] = before
            break
        least, inside, squares = cost, n, e
        hessian[:], before[:] = trial, pose
        done += 1
        if not _take_step(trial, gradient, iterations, iterations.last_gate, pose, step):
            break
    pose[2] -= 2.0 * pi * floor((pose[2] + pi) / (2.0 * pi))
    return inside, squares, done
