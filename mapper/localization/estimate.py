"""Pose estimate from particles: their heaviest cluster, as in AMCL."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import wrap_angle
from mapper.localization.kernels.resampling import add_moments, fill_bins, join_bins
from mapper.localization.kernels.types import Bins

BINS = Bins(0.5, math.pi / 18.0)  #: those of AMCL's kd-tree: 0.5 m and 10°
TURNS = 36  #: bins of a full turn
CONVERGED_SHARE = 0.9  #: minimum weight of the best cluster,
CONVERGED_M = 0.5  #: and maximum standard deviations
CONVERGED_RAD = math.radians(20.0)
LOST_SHARE, LOST_TIMES = 0.5, 2.0  #: a converged filter stays so down to this weight, and up to these times wider


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Estimated pose of the robot, ``T_map_base``.

    ``pose`` (3,) and ``covariance`` (3, 3) are those of the heaviest cluster of particles; until it ``is_converged``,
    the covariance is that of all particles around that pose. ``share`` is the cluster's weight, 0 to 1, and ``fit`` the
    fit of the last scan: 1 if each endpoint is on a wall. ``entropy`` is that of the histogram of poses in bins of 0.5
    m and 10°, bits. ``is_updated`` means that the last scan was used. ``is_sure`` means that other places were ruled
    out (:mod:`mapper.localization.confidence`); ``contradicted`` is the fraction of recent readings, 0 to 1, that pass
    through walls of the map.
    """

    pose: Float64Array
    covariance: Float64Array
    is_converged: bool
    share: float
    fit: float
    entropy: float
    n_particles: int
    is_updated: bool
    is_sure: bool = False
    contradicted: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """Clusters of particles: ``weight`` (k,), ``mean`` (k, 3), ``covariance`` (k, 3, 3), and ``number`` (n,) per
    particle.

    ``entropy`` is that of the weights of the bins of :data:`BINS`, bits.
    """

    weight: Float64Array
    mean: Float64Array
    covariance: Float64Array
    number: NDArray[np.int64]
    entropy: float


def find_clusters(particles: Float64Array, weights: Float64Array) -> Clusters:
    """Return the clusters of ``particles`` (n, 3) with ``weights`` (n,), Σ = 1. Source: AMCL, pf_cluster_stats.

    The variance of the angle is −2 ln R, where R is the length of the mean direction (Mardia 1972).
    """
    n = len(particles)
    size = 1 << (2 * n - 1).bit_length()
    table, numbers = np.empty(size, dtype=np.int64), np.empty(size, dtype=np.int64)
    bins = np.empty(n, dtype=np.int64)
    count = fill_bins(particles, np.arange(n), BINS, table, numbers, bins)
    cluster_of_bin = np.empty(count, dtype=np.int64)
    moments = np.zeros((join_bins(table, numbers, TURNS, cluster_of_bin), 8))
    number = cluster_of_bin[bins]
    share = np.bincount(bins, weights=weights, minlength=count)
    share = share[share > 0.0]
    origin = particles[:, :2].mean(axis=0)
    add_moments(particles, weights, number, origin, moments)
    mean, covariance = statistics(moments, origin)
    return Clusters(moments[:, 0], mean, covariance, number, float(-np.sum(share * np.log2(share))))


def statistics(moments: Float64Array, origin: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return means (k, 3) and covariances (k, 3, 3) from the moments of ``add_moments``.

    x and y are uncorrelated with the angle, as in AMCL.
    """
    w = np.maximum(moments[:, 0], 1e-300)
    x, y, c, s, xx, xy, yy = (moments[:, k] / w for k in range(1, 8))
    mean = np.column_stack([x + origin[0], y + origin[1], np.arctan2(s, c)])
    length = np.clip(np.hypot(c, s), 1e-12, 1.0)
    covariance = np.zeros((len(moments), 3, 3))
    covariance[:, 0, 0], covariance[:, 1, 1] = np.maximum(xx - x * x, 0.0), np.maximum(yy - y * y, 0.0)
    covariance[:, 0, 1] = covariance[:, 1, 0] = xy - x * y
    covariance[:, 2, 2] = -2.0 * np.log(length)
    return mean, covariance


def estimate_of(clusters: Clusters, fit: float, *, was_converged: bool, is_updated: bool) -> Estimate:
    """Return the estimate from clusters, for a filter that had converged before or not."""
    best = int(np.argmax(clusters.weight))
    pose, covariance = clusters.mean[best], clusters.covariance[best]
    share = float(clusters.weight[best] / clusters.weight.sum())
    widest = math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1]))
    times = LOST_TIMES if was_converged else 1.0
    is_converged = (
        share >= (LOST_SHARE if was_converged else CONVERGED_SHARE)
        and widest <= times * CONVERGED_M
        and math.sqrt(covariance[2, 2]) <= times * CONVERGED_RAD
    )
    if not is_converged:
        covariance = _around(clusters, pose)
    return Estimate(pose, covariance, is_converged, share, fit, clusters.entropy, len(clusters.number), is_updated)


def _around(clusters: Clusters, pose: Float64Array) -> Float64Array:
    """Return the second moments (3, 3) of all particles about a pose."""
    weight = clusters.weight / clusters.weight.sum()
    off = clusters.mean - pose
    off[:, 2] = wrap_angle(off[:, 2])
    whole = clusters.covariance + off[:, :, np.newaxis] * off[:, np.newaxis, :]
    return np.asarray(np.einsum("k,kij->ij", weight, whole))
