"""Linearised edges of a pose graph, and assembly of pairwise blocks into a sparse system."""

from __future__ import annotations

import math

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.jit import jit


@jit
def edge_errors(
    poses: Float64Array, first: Int64Array, second: Int64Array, relative: Float64Array, errors: Float64Array
) -> None:
    """Write the error (e, 3) of each edge: Z⁻¹ ∘ (Tᵢ⁻¹ ∘ Tⱼ) as x, y and wrapped angle, as in g2o."""
    for k in range(len(first)):
        i, j = first[k], second[k]
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        u = c * dx + s * dy - relative[k, 0]
        v = -s * dx + c * dy - relative[k, 1]
        cz, sz = math.cos(relative[k, 2]), math.sin(relative[k, 2])
        errors[k, 0] = cz * u + sz * v
        errors[k, 1] = -sz * u + cz * v
        angle = poses[j, 2] - poses[i, 2] - relative[k, 2]
        errors[k, 2] = angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@jit
def squared_errors(errors: Float64Array, information: Float64Array, chi2: Float64Array) -> None:
    """Write eᵀ Ω e (e,) of ``errors`` (e, 3) with ``information`` (e, 3, 3)."""
    for k in range(len(chi2)):
        total = 0.0
        for r in range(3):
            for c in range(3):
                total += errors[k, r] * information[k, r, c] * errors[k, c]
        chi2[k] = total


@jit
def linearise_edges(
    poses: Float64Array,
    first: Int64Array,
    second: Int64Array,
    relative: Float64Array,
    information: Float64Array,
    weights: Float64Array,
    errors: Float64Array,
    hessians: Float64Array,
    gradients: Float64Array,
) -> None:
    """Write w JᵀΩJ (e, 6, 6) and −w JᵀΩe (e, 6) of each edge with respect to the poses of its two ends.

    ``errors`` (e, 3) are those of :func:`edge_errors`, ``weights`` (e,) those of the robust kernel, and ``information``
    (e, 3, 3) is symmetric. Increments are added to x, y and theta in the map frame. Source: Grisetti et al. 2010, A
    tutorial on graph-based SLAM.
    """
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        turned = poses[i, 2] + relative[k, 2]
        # With R = R(θᵢ + θz): e = Rᵀ (tⱼ − tᵢ) − Rzᵀ tz.
        c, s = math.cos(turned), math.sin(turned)
        o, w = information[k], weights[k]
        u, v = -s * dx + c * dy, -c * dx - s * dy
        # J for the second pose is diag(Rᵀ, 1); for the first it is the negative, with (u, v) for the rotation.
        for a in range(2):
            m0, m1 = (c, -s) if a == 0 else (s, c)
            p0, p1, p2 = m0 * o[0, 0] + m1 * o[1, 0], m0 * o[0, 1] + m1 * o[1, 1], m0 * o[0, 2] + m1 * o[1, 2]
            hessians[k, 3 + a, 3] = w * (p0 * c - p1 * s)
            hessians[k, 3 + a, 4] = w * (p0 * s + p1 * c)
            hessians[k, 3 + a, 5] = w * p2
            hessians[k, 3 + a, 2] = w * (p0 * u + p1 * v - p2)
            gradients[k, 3 + a] = -w * (p0 * errors[k, 0] + p1 * errors[k, 1] + p2 * errors[k, 2])
        hessians[k, 5, 3] = hessians[k, 3, 5]
        hessians[k, 5, 4] = hessians[k, 4, 5]
        hessians[k, 5, 5] = w * o[2, 2]
        hessians[k, 5, 2] = w * (o[2, 0] * u + o[2, 1] * v - o[2, 2])
        gradients[k, 5] = -w * (o[2, 0] * errors[k, 0] + o[2, 1] * errors[k, 1] + o[2, 2] * errors[k, 2])
        t0 = u * o[0, 0] + v * o[1, 0] - o[2, 0]
        t1 = u * o[0, 1] + v * o[1, 1] - o[2, 1]
        t2 = u * o[0, 2] + v * o[1, 2] - o[2, 2]
        hessians[k, 2, 2] = w * (t0 * u + t1 * v - t2)
        gradients[k, 2] = -w * (t0 * errors[k, 0] + t1 * errors[k, 1] + t2 * errors[k, 2])
        for a in range(2):
            gradients[k, a] = -gradients[k, 3 + a]
            hessians[k, a, 2] = -hessians[k, 3 + a, 2]
            hessians[k, 2, a] = -hessians[k, 3 + a, 2]
            for b in range(3):
                hessians[k, a, 3 + b] = -hessians[k, 3 + a, 3 + b]
                hessians[k, 3 + b, a] = -hessians[k, 3 + a, 3 + b]
            for b in range(2):
                hessians[k, a, b] = hessians[k, 3 + a, 3 + b]
        for a in range(3):
            hessians[k, 2, 3 + a] = hessians[k, 3 + a, 2]


@jit
def add_pairs(
    first: Int64Array,
    second: Int64Array,
    slots: Int64Array,
    is_swapped: BoolArray,
    hessians: Float64Array,
    gradients: Float64Array,
    diagonal: Float64Array,
    upper: Float64Array,
    right: Float64Array,
) -> None:
    """Add blocks (p, 6, 6) and (p, 6) of pairs of poses to a system of 3 × 3 blocks.

    ``first`` and ``second`` (p,) are rows of the system, −1 for a fixed pose. ``slots`` (p,) is the pair's block of
    ``upper`` (u, 3, 3), −1 if an end is fixed; with ``is_swapped`` (p,) its row is the second pose. ``diagonal`` (n, 3,
    3) and ``right`` (n, 3) are the other parts of the system.
    """
    for k in range(len(first)):
        i, j = first[k], second[k]
        if i >= 0:
            for r in range(3):
                right[i, r] += gradients[k, r]
                for c in range(3):
                    diagonal[i, r, c] += hessians[k, r, c]
        if j >= 0:
            for r in range(3):
                right[j, r] += gradients[k, 3 + r]
                for c in range(3):
                    diagonal[j, r, c] += hessians[k, 3 + r, 3 + c]
        p = slots[k]
        if p >= 0:
            for r in range(3):
                for c in range(3):
                    upper[p, r, c] += hessians[k, 3 + r, c] if is_swapped[k] else hessians[k, r, 3 + c]
