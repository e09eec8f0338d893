"""RANSAC for each patch: the points that most others of their patch agree with on one plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray
from mapper.terrain.kernels import consensus as kernels
from mapper.terrain.parameters import PatchConfig
from mapper.terrain.patches import Patches

#: Planes of three points for each patch. With half of the points outliers no plane goes through three inliers in two of
#: a million patches: (1 − 1/8)¹⁰⁰.
TRIALS = 100


def agreeing(points: NDArray[np.floating[Any]], patches: Patches, distance: float) -> BoolArray:
    """Return which of ``points`` (n, 3), m, are within ``distance``, m along z, of the plane of most of their patch.

    The patches are those of the grid of ``patches``; its moments are not used. Points outside of the grid, and those of
    a patch in which no three points give a plane, agree with nothing. Source: Fischler & Bolles, Random Sample
    Consensus, 1981; the triples are those of :func:`mapper.terrain.textbook.triples_of`.
    """
    rows, cols, _ = patches.moments.shape
    local = np.asarray(points, dtype=np.float64) - patches.corner
    places = np.floor(local[:, :2] * (1.0 / patches.size))
    inside = ((places >= 0) & (places < (cols, rows))).all(axis=1)
    kept = np.flatnonzero(inside)
    at = places[kept].astype(np.int64)
    patch = at[:, 1] * cols + at[:, 0]
    order = np.argsort(patch, kind="stable")
    in_order = local[kept[order]]
    # About the patch's centre: planes of points far from 0 lose digits.
    in_order[:, :2] -= (at[order] + 0.5) * patches.size
    starts = np.concatenate([[0], np.cumsum(np.bincount(patch, minlength=rows * cols))]).astype(np.int64)
    found = np.empty(len(kept), dtype=np.bool_)
    kernels.consensus(in_order, starts, TRIALS, distance, found)
    out = np.zeros(len(local), dtype=np.bool_)
    out[kept[order]] = found
    return out


def fitted(points: NDArray[np.floating[Any]], patches: Patches, config: PatchConfig) -> BoolArray:
    """Return which of ``points`` (n, 3) the planes of ``patches`` are fitted to: all, or those that RANSAC keeps."""
    if config.fit == "ransac":
        return agreeing(points, patches, config.fit_distance)
    return np.ones(len(points), dtype=np.bool_)
