"""Residuals of a graph's measurements at given poses, as a series for plots."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.io.contents.model import Column, Series
from mapper.sensors.pose_graph import LOOP, PoseGraph

COLUMNS = tuple(
    Column(f"{kind} residual {of}", unit, f"residual {of}")
    for kind in ("odometry", "loop")
    for of, unit in (("distance", "m"), ("angle", "rad"))
)


def residuals(graph: PoseGraph, poses: ArrayLike) -> NDArray[np.float64]:
    """Return Z⁻¹ ∘ (Tᵢ⁻¹ ∘ Tⱼ) of each edge (e, 3): metres along and across its measurement Z, and radians.

    ``poses`` (m, 3) are ``T_map_base`` of the nodes. Source: Grisetti et al. 2010, A tutorial on graph-based SLAM, (1).
    """
    nodes = np.asarray(poses, dtype=np.float64)
    off = compose(inverse(graph.relative), compose(inverse(nodes[graph.i]), nodes[graph.j]))
    off[:, 2] = wrap_angle(off[:, 2])
    return np.asarray(off, dtype=np.float64)


def residual_series(graph: PoseGraph, poses: ArrayLike, stamps_ns: NDArray[np.int64]) -> Series:
    """Return the residuals of a graph's edges, each assigned to its later node.

    ``poses`` (m, 3) as for :func:`residuals`, ``stamps_ns`` (m,) the times of the nodes. Columns: distance, m, and
    absolute angle, rad, of the odometry edge; then the maxima of each over the loops. NaN if no such edge ends there.
    """
    off = residuals(graph, poses)
    sizes = np.column_stack([np.hypot(off[:, 0], off[:, 1]), np.abs(off[:, 2])])
    values = np.full((len(graph.nodes), len(COLUMNS)), np.nan)
    ends = np.maximum(graph.i, graph.j)
    is_loop = graph.kind == LOOP
    for first, of_kind in ((0, ~is_loop), (2, is_loop)):
        for n in range(2):
            np.fmax.at(values[:, first + n], ends[of_kind], sizes[of_kind, n])
    order = np.argsort(stamps_ns, kind="stable")
    return Series("slam", "pose graph", COLUMNS, stamps_ns[order], values[order])
