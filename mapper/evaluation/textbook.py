"""Evaluation of trajectories as in the papers, pose by pose: the reference for the fast version.

Umeyama 1991 (equations 34 to 43), Sturm et al. 2012 (equations 1 to 5).
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array

Pairs = list[tuple[int, int]]


def matrix(pose: Float64Array) -> Float64Array:
    """Return a pose (x, y, theta) as a homogeneous matrix (3, 3)."""
    x, y, theta = pose
    return np.array([[math.cos(theta), -math.sin(theta), x], [math.sin(theta), math.cos(theta), y], [0.0, 0.0, 1.0]])


def associate(reference_s: list[float], estimate_s: list[float], max_difference_s: float) -> Pairs:
    """Return, for each stamp of the estimate near a stamp of the reference, the indices (reference, estimate)."""
    pairs = []
    for j, stamp in enumerate(estimate_s):
        i = min(range(len(reference_s)), key=lambda i: abs(reference_s[i] - stamp))
        if abs(reference_s[i] - stamp) <= max_difference_s:
            pairs.append((i, j))
    return pairs


def umeyama(
    reference_xy: Float64Array, estimate_xy: Float64Array, *, with_scale: bool = False
) -> tuple[Float64Array, Float64Array, float]:
    """Return R (2, 2), t (2,), c that minimise 1/n Σ |yᵢ − (c R xᵢ + t)|², y the reference, x the estimate (n, 2)."""
    n = len(estimate_xy)
    mean_x, mean_y = estimate_xy.mean(axis=0), reference_xy.mean(axis=0)  # (34), (35)
    variance_x = sum(float(np.sum((x - mean_x) ** 2)) for x in estimate_xy) / n  # (36)
    covariance = (
        sum(
            (np.outer(y - mean_y, x - mean_x) for x, y in zip(estimate_xy, reference_xy, strict=True)),
            np.zeros((2, 2)),
        )
        / n
    )  # (38)
    u, d, v_t = np.linalg.svd(covariance)
    s = np.diag([1.0, 1.0 if np.linalg.det(u) * np.linalg.det(v_t) > 0.0 else -1.0])  # (43)
    rotation = u @ s @ v_t  # (40)
    scale = float(np.trace(np.diag(d) @ s)) / variance_x if with_scale else 1.0  # (42)
    return rotation, mean_y - scale * rotation @ mean_x, scale  # (41)


def absolute_errors(reference: Float64Array, estimate: Float64Array) -> list[tuple[float, float]]:
    """Return translation (m) and rotation (rad) of F = Q⁻¹ P for each pose, Q the reference (n, 3), P the estimate."""
    return [_magnitudes(np.linalg.inv(matrix(q)) @ matrix(p)) for q, p in zip(reference, estimate, strict=True)]


def relative_errors(reference: Float64Array, estimate: Float64Array, pairs: Pairs) -> list[tuple[float, float]]:
    """Return translation (m) and rotation (rad) of E = (Qᵢ⁻¹ Qⱼ)⁻¹ (Pᵢ⁻¹ Pⱼ) for each pair (i, j)."""
    errors = []
    for i, j in pairs:
        true_motion = np.linalg.inv(matrix(reference[i])) @ matrix(reference[j])
        motion = np.linalg.inv(matrix(estimate[i])) @ matrix(estimate[j])
        errors.append(_magnitudes(np.linalg.inv(true_motion) @ motion))
    return errors


def all_pairs(distances: Float64Array, delta: float, tolerance: float) -> Pairs:
    """Return for each pose the later one nearest to ``delta`` away; ``distances`` (n,) from the start."""
    pairs = []
    for i in range(len(distances) - 1):
        j = min(range(i + 1, len(distances)), key=lambda j: abs(distances[j] - distances[i] - delta))
        if abs(distances[j] - distances[i] - delta) <= tolerance:
            pairs.append((i, j))
    return pairs


def _magnitudes(motion: Float64Array) -> tuple[float, float]:
    return math.hypot(motion[0, 2], motion[1, 2]), abs(math.atan2(motion[1, 0], motion[0, 0]))
