"""Particle motion by noisy odometry, and particles drawn uniformly from free space.

Numba twins of :func:`mapper.localization.textbook.sample_motion_model_odometry` and of its omnidirectional variant.
Random numbers are a function of a key and a counter, so that they do not depend on the thread that draws them. Each is
a hash of its counter: two rounds of a 32-bit integer hash with two multiplications, each with half of the key. The hash
was found by C. Wellons' search for low-bias hashes. Source of the idea: Salmon et al. 2011, Parallel random numbers: as
easy as 1, 2, 3. Normal deviates are the inverse of the normal distribution (Wichura 1988, algorithm AS 241, PPND7,
error below 1e-6).
"""

from __future__ import annotations

from math import cos, floor, log, pi, sin, sqrt

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame
from mapper.localization.kernels.types import Motion

_WORD = 0xFFFFFFFF


@jit
def _hashed(x: int) -> int:
    """Return a hash of x, both 32-bit. Products stay below 2⁶³."""
    x ^= x >> 16
    x = (x * 0x21F0AAAD) & _WORD
    x ^= x >> 15
    x = (x * 0x735A2D97) & _WORD
    return x ^ (x >> 15)


@jit
def _uniform(key: int, counter: int) -> float:
    """Return a number in (0, 1), one of 2³², for a key of 62 bits and a counter below 2³²."""
    word = _hashed(_hashed((counter ^ key) & _WORD) ^ ((key >> 31) & _WORD))
    return (word + 0.5) / 4294967296.0


@jit
def _normal(p: float) -> float:
    """Return the standard normal quantile of ``p``, 0 < p < 1."""
    q = p - 0.5
    if abs(q) <= 0.425:
        r = 0.180625 - q * q
        above = ((5.9109374720e1 * r + 1.5929113202e2) * r + 5.0434271938e1) * r + 3.3871327179
        below = ((6.7187563600e1 * r + 7.8757757664e1) * r + 1.7895169469e1) * r + 1.0
        return q * above / below
    r = sqrt(-log(p if q < 0.0 else 1.0 - p))
    if r <= 5.0:
        r -= 1.6
        above = ((1.7023821103e-1 * r + 1.3067284816) * r + 2.7568153900) * r + 1.4234372777
        below = (1.2021132975e-1 * r + 7.3700164250e-1) * r + 1.0
    else:
        r -= 5.0
        above = ((1.7337203997e-2 * r + 4.2868294337e-1) * r + 3.0812263860) * r + 6.6579051150
        below = (1.2258202635e-2 * r + 2.4197894225e-1) * r + 1.0
    return -above / below if q < 0.0 else above / below


@jit
def move_particles(poses: Float64Array, motion: Motion, key: int, first: int, last: int) -> None:
    """Move the particles [first, last) of ``poses`` (n, 3) in place, each with independent noise.

    The noise depends only on ``key`` and the particle's index. Angles are wrapped to [−π, π).
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
    """Write poses [first, last) of ``poses`` (n, 3), uniform over the free cells and all headings.

    ``free_cells`` (m,) are row · ``cols`` + column. The cells are stratified: particle i of n is drawn from the i-th of
    n equal parts of them.
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
