"""Information matrix of an aligned pose, from the sums of its point-to-line pairs."""

from __future__ import annotations

from math import cos, hypot, sin, sqrt

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit


@jit
def _invert(matrix: Float64Array, inverse: Float64Array) -> None:
    """Write the inverse (3, 3) of a symmetric positive definite ``matrix`` (3, 3), by its cofactors."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * p + b * q + c * r)
    inverse[0, 0], inverse[0, 1], inverse[0, 2] = scale * p, scale * q, scale * r
    inverse[1, 0], inverse[1, 1], inverse[1, 2] = scale * q, scale * (a * f - c * c), scale * (b * c - a * e)
    inverse[2, 0], inverse[2, 1], inverse[2, 2] = scale * r, scale * (b * c - a * e), scale * (a * d - b * b)


@jit
def _shrinkage(h: Float64Array, false_share: float) -> tuple[float, float, float]:
    """Return K (2, 2) as its elements 00, 01, 11, such that K H K subtracts a share of H's greater eigenvalue from
    both.

    H is the x-y block of ``h`` (3, 3).
    """
    mean, half = 0.5 * (h[0, 0] + h[1, 1]), 0.5 * (h[0, 0] - h[1, 1])
    radius = hypot(half, h[0, 1])
    high, low = max(mean + radius, 1e-9), max(mean - radius, 1e-9)
    of_high = sqrt(1.0 - false_share)
    of_low = sqrt(max(low - false_share * high, 1e-9) / low)
    # The direction of the greater eigenvalue: its projector is half of 1 + (half, h01) / radius.
    c2, s2 = (half / radius, h[0, 1] / radius) if radius > 0.0 else (1.0, 0.0)
    p00, p01, p11 = 0.5 * (1.0 + c2), 0.5 * s2, 0.5 * (1.0 - c2)
    k00 = of_low + (of_high - of_low) * p00
    k01 = (of_high - of_low) * p01
    k11 = of_low + (of_high - of_low) * p11
    return k00, k01, k11


@jit
def write_information(
    hessian: Float64Array,
    prior: Float64Array,
    heading: float,
    false_share: float,
    scale: float,
    floor: Float64Array,
    information: Float64Array,
) -> None:
    """Write the information (3, 3) of a pose in its own frame, from the pairs' sums in the map frame.

    ``hessian`` (3, 3) is Σ w JᵀJ over x, y and theta, with the weights ``prior`` (3,) of a prior on its diagonal; its
    unit is ``scale``. ``heading`` is the pose's, radians. ``false_share`` of the greater eigenvalue of the pairs' x-y
    block is subtracted from both, because a wall with noisy normals falsely constrains motion along itself. ``floor``
    (3,) are minimum standard deviations of the result, metres and radians.
    """
    h = hessian.copy()
    for k in range(3):
        h[k, k] -= prior[k]
    k00, k01, k11 = _shrinkage(h, false_share)
    # K H K, rotated into the frame of the pose.
    c, s = cos(heading), sin(heading)
    t = np.zeros((3, 3))
    t[0, 0], t[0, 1] = k00 * c + k01 * s, -k00 * s + k01 * c
    t[1, 0], t[1, 1] = k01 * c + k11 * s, -k01 * s + k11 * c
    t[2, 2] = 1.0
    own, covariance = np.zeros((3, 3)), np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            total = 0.0
            for u in range(3):
                for v in range(3):
                    total += t[u, i] * h[u, v] * t[v, j]
            own[i, j] = scale * total
    turned = (c * c * prior[0] + s * s * prior[1], s * s * prior[0] + c * c * prior[1])
    own[0, 0] += scale * turned[0] + 1e-3
    own[1, 1] += scale * turned[1] + 1e-3
    own[0, 1] += scale * c * s * (prior[1] - prior[0])
    own[1, 0] = own[0, 1]
    own[2, 2] += scale * prior[2] + 1e-3
    _invert(own, covariance)
    for k in range(3):
        covariance[k, k] += floor[k] * floor[k]
    _invert(covariance, information)
