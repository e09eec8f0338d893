"""Ranges of a lidar's beams in plain NumPy: the kernel must return the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.simulation.kernels.lidar import VERTEX_SLACK
from mapper.simulation.lidar import RANGE_MIN
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
    nearest: Float64Array = np.where(on_edge, t, np.inf).min(axis=1, initial=np.inf)
    return nearest


def noisy(ranges: Float64Array, noise: Float64Array, sigma: float, range_max: float) -> NDArray[np.float32]:
    """Return the readings of ``ranges`` (n,), metres, with ``sigma`` metres times ``noise`` (n,), as a lidar reports.

    None is below RANGE_MIN; one beyond ``range_max`` is +inf.
    """
    readings = np.maximum(ranges + sigma * noise, RANGE_MIN).astype(np.float32)
    readings[readings > range_max] = np.inf
    return readings
