"""Particles moved by noisy odometry, and particles drawn uniformly from free space.

Numba twins of :func:`mapper.localization.textbook.sample_motion_model_odometry` and of its omnidirectional variant.
"""

from __future__ import annotations

from math import cos, floor, pi, sin

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame
from mapper.localization.kernels.random_numbers import _normal, _uniform
from mapper.localization.kernels.types import Motion


@jit
def move_particles(poses: Float64Array, motion: Motion, key: int, first: int, last: int) -> None:
    """Move the particles [first, last) of ``poses`` (n, 3) in place, each with errors of its own.

    The errors depend on ``key`` and the particle's number only. Angles come back in [−π, π).
    """
    for i in range(first, last):
        e_1 = motion.sigma_1 * _normal(_uniform(key, 3 * i))
        e_d = motion.sigma_distance * _normal(_uniform(key, 3 * i + 1))
        e_2 = motion.sigma_2 * _normal(_uniform(key, 3 * i + 2))
        distance = motion.distance - e_d
        if motion.omni:
            heading = poses[i, 2] + motion.turn_1
            c, s = cos(heading), sin(heading)
            poses[i, 0] += distance * c - e_1 * s
            poses[i, 1] += distance * s + e_1 * c
            angle = poses[i, 2] + motion.turn_2 - e_2
        else:
            heading = poses[i, 2] + motion.turn_1 - e_1
            poses[i, 0] += distance * cos(heading)
            poses[i, 1] += distance * sin(heading)
            angle = heading + motion.turn_2 - e_2
        poses[i, 2] = angle - 2.0 * pi * floor((angle + pi) / (2.0 * pi))


@jit
def draw_uniform(
    free_cells: Int64Array, cols: int, frame: Frame, key: int, poses: Float64Array, first: int, last: int
) -> None:
    """Write poses [first, last) of ``poses`` (n, 3): uniform over the free cells and over all headings.

    ``free_cells`` (m,) are row · ``cols`` + column. The cells are stratified: particle i of n is drawn from the i-th of
    n equal shares of them.
    """
    n, m = poses.shape[0], free_cells.shape[0]
    for i in range(first, last):
        cell = free_cells[min(m - 1, int((i + _uniform(key, 4 * i)) * m / n))]
        u = cell % cols + _uniform(key, 4 * i + 1)
        v = cell // cols + _uniform(key, 4 * i + 2)
        u, v = u * frame.resolution, v * frame.resolution
        poses[i, 0] = frame.origin_x + frame.cos_yaw * u - frame.sin_yaw * v
        poses[i, 1] = frame.origin_y + frame.sin_yaw * u + frame.cos_yaw * v
        poses[i, 2] = pi * (2.0 * _uniform(key, 4 * i + 3) - 1.0)


@jit
def draw_normal(mean: Float64Array, root: Float64Array, key: int, poses: Float64Array, first: int, last: int) -> None:
    """Write poses [first, last) of ``poses`` (n, 3): ``mean`` (3,) + ``root`` (3, 3) · standard normal deviates."""
    for i in range(first, last):
        a, b, c = _normal(_uniform(key, 3 * i)), _normal(_uniform(key, 3 * i + 1)), _normal(_uniform(key, 3 * i + 2))
        for k in range(3):
            poses[i, k] = mean[k] + root[k, 0] * a + root[k, 1] * b + root[k, 2] * c
        poses[i, 2] -= 2.0 * pi * floor((poses[i, 2] + pi) / (2.0 * pi))
