"""Ranges of a lidar's beams in plain NumPy: the kernel must return the same."""

from __future__ import annotations

import numpy as np

from mapper.simulation.kernels.lidar import VERTEX_SLACK
from mapper.simulation.worlds import Float64Array


def cast_beams(segments: Float64Array, x: float, y: float, bearings: Float64Array, range_max: float) -> Float64Array:
    """Return how far each beam (n,) goes from (x, y) to the nearest of all edges, +inf beyond ``range_max`` metres.

    ``segments`` (m, 4) as in :mod:`mapper.simulation.kernels.raycast`; ``bearings`` (n,) radians, map frame. Every
    beam is tried against every edge: a + u·e = t·d (O'Rourke, Computational Geometry in C, section 7.2).
    """
    ax, ay = segments[:, 0] - x, segments[:, 1] - y
    ex, ey = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    dx, dy = np.cos(bearings)[:, np.newaxis], np.sin(bearings)[:, np.newaxis]
    d_cross_e = dx * ey - dy * ex
    crosses = np.abs(d_cross_e) >= 1e-12
    divisor = np.where(crosses, d_cross_e, 1.0)
    t, u = (ax * ey - ay * ex) / divisor, (ax * dy - ay * dx) / divisor
    on_edge = crosses & (t >= 0.0) & (t <= range_max) & (u >= -VERTEX_SLACK) & (u <= 1.0 + VERTEX_SLACK)
    return np.where(on_edge, t, np.inf).min(axis=1, initial=np.inf)
