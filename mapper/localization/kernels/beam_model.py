"""Beam range finder model: each beam is cast through the map and its reading compared with the expected range.

Numba twin of :func:`mapper.localization.textbook.beam_range_finder_model`.
"""

from __future__ import annotations

from math import cos, exp, floor, inf, log, pi, sin, sqrt

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import to_lattice
from mapper.localization.kernels.types import Mixture, OccupiedCells

_to_lattice = jit(to_lattice)


@jit
def _expected_range(cells: OccupiedCells, x: float, y: float, bearing: float, range_max: float) -> float:
    """Return the distance at which a beam enters the first occupied cell, at most ``range_max``, metres.

    Traversal: Amanatides and Woo 1987. A beam that starts in an occupied cell has range 0.
    """
    rows, cols = cells.occupied.shape
    u, v = _to_lattice(x, y, cells.frame)
    c, s = cos(bearing), sin(bearing)
    d_u = cells.frame.cos_yaw * c + cells.frame.sin_yaw * s
    d_v = cells.frame.cos_yaw * s - cells.frame.sin_yaw * c
    col, row = floor(u), floor(v)
    step_u, step_v = (1 if d_u > 0.0 else -1), (1 if d_v > 0.0 else -1)
    t_u = inf if d_u == 0.0 else ((col + (d_u > 0.0)) - u) / d_u
    t_v = inf if d_v == 0.0 else ((row + (d_v > 0.0)) - v) / d_v
    far, t = range_max / cells.frame.resolution, 0.0
    while t < far:
        if 0 <= row < rows and 0 <= col < cols:
            if cells.occupied[row, col]:
                return t * cells.frame.resolution
        elif (
            (col < 0 and step_u < 0)
            or (col >= cols and step_u > 0)
            or (row < 0 and step_v < 0)
            or (row >= rows and step_v > 0)
        ):
            return range_max
        if t_u < t_v:
            t = t_u
            t_u += step_u / d_u
            col += step_u
        else:
            t = t_v
            t_v += step_v / d_v
            row += step_v
    return range_max


@jit
def weigh_by_beams(
    cells: OccupiedCells,
    mixture: Mixture,
    beams: Float64Array,
    sensor: Float64Array,
    poses: Float64Array,
    first: int,
    last: int,
    out: Float64Array,
) -> None:
    """Write Σ log p(z | x, m) over the beams into ``out`` (n,), for the poses [first, last) of ``poses`` (n, 3).

    ``beams`` (k, 2) are range, at most ``range_max``, and bearing in the base's frame; ``sensor`` (2,) is their origin
    in it.
    """
    z_top = mixture.range_max
    for i in range(first, last):
        c, s = cos(poses[i, 2]), sin(poses[i, 2])
        x = poses[i, 0] + c * sensor[0] - s * sensor[1]
        y = poses[i, 1] + s * sensor[0] + c * sensor[1]
        total = 0.0
        for b in range(beams.shape[0]):
            z = beams[b, 0]
            expected = _expected_range(cells, x, y, poses[i, 2] + beams[b, 1], z_top)
            e = (z - expected) / mixture.sigma_hit
            p = mixture.z_hit * exp(-0.5 * e * e) / (mixture.sigma_hit * sqrt(2.0 * pi))
            if z <= expected:
                share = 1.0 - exp(-mixture.lambda_short * expected)
                if share > 0.0:
                    p += mixture.z_short * mixture.lambda_short * exp(-mixture.lambda_short * z) / share
            if z >= z_top:
                p += mixture.z_max
            else:
                p += mixture.z_rand / z_top
            total += log(max(p, 1e-300))
        out[i] = total
