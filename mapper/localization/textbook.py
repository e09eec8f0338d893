"""Monte Carlo localization in plain NumPy, as in Probabilistic Robotics: the reference for the compiled version.

Source: Thrun, Burgard and Fox 2005, chapters 4, 5, 6 and 8. Random numbers are arguments, so that functions are
deterministic. Poses are (3,), particles (n, 3), metres and radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.se2 import compose, wrap_angle
from mapper.grid import GridGeometry

Alphas = tuple[float, float, float, float]


def odometry_control(before: Float64Array, after: Float64Array) -> tuple[float, float, float]:
    """Return turn, distance and turn (rad, m, rad) between two poses of the odometry. Table 5.6, lines 2 to 4.

    Computed with complex numbers: a direction is a unit number, and turns are quotients of directions. Below 1 cm the
    direction of the distance is noise, and the first turn is 0, as in AMCL.
    """
    heading, next_heading = np.exp(1j * before[2]), np.exp(1j * after[2])
    step = complex(after[0] - before[0], after[1] - before[1])
    distance = abs(step)
    direction = heading if distance < 0.01 else step / distance
    turns = wrap_angle(np.angle([direction / heading, next_heading / direction]))  # −π, not π, as elsewhere
    return float(turns[0]), distance, float(turns[1])


def odometry_sigmas(control: tuple[float, float, float], alphas: Alphas) -> Float64Array:
    """Return the standard deviations (3,) of turn, distance and turn. Table 5.6, lines 5 to 7.

    A turn counts from the nearest multiple of a half turn, as in AMCL, so that driving backwards is not a turn.
    """
    turns = np.array([math.remainder(control[0], math.pi), math.remainder(control[2], math.pi)]) ** 2
    a1, a2, a3, a4 = alphas
    of_turns = a1 * turns + a2 * control[1] ** 2
    return np.sqrt([of_turns[0], a3 * control[1] ** 2 + a4 * turns.sum(), of_turns[1]])


def sample_motion_model_odometry(
    control: tuple[float, float, float], sigmas: Float64Array, pose: Float64Array, normals: Float64Array
) -> Float64Array:
    """Sample a pose after a motion. Table 5.6, lines 5 to 11, with ``sample(σ²)`` = σ · one of ``normals`` (3,)."""
    turn_1, distance, turn_2 = np.array(control) - sigmas * normals
    x, y, theta = pose
    return np.array(
        [
            x + distance * math.cos(theta + turn_1),
            y + distance * math.sin(theta + turn_1),
            wrap_angle(theta + turn_1 + turn_2),
        ]
    )


def sample_motion_model_omni(
    motion: Float64Array, alphas: tuple[float, ...], pose: Float64Array, normals: Float64Array
) -> Float64Array:
    """Sample a pose after a ``motion`` (3,) of a robot that also moves sideways; ``normals`` (3,) as above.

    Source: Nav2's AMCL, OmniMotionModel: distance, sideways distance and turn have errors.
    """
    a1, a2, a3, a4, a5 = alphas
    distance, turn = math.hypot(motion[0], motion[1]), motion[2]
    direction = pose[2] + math.atan2(motion[1], motion[0])
    sideways = math.sqrt(a4 * turn**2 + a5 * distance**2) * normals[0]
    forward = distance - math.sqrt(a3 * distance**2 + a4 * turn**2) * normals[1]
    turned = turn - math.sqrt(a1 * turn**2 + a2 * distance**2) * normals[2]
    c, s = math.cos(direction), math.sin(direction)
    return np.array(
        [pose[0] + forward * c - sideways * s, pose[1] + forward * s + sideways * c, wrap_angle(pose[2] + turned)]
    )


def motion_model_odometry(
    after: Float64Array, control: tuple[float, float, float], before: Float64Array, alphas: Alphas
) -> float:
    """Return p(x_t | u_t, x_{t−1}), the density of the pose ``after``. Table 5.5, with ``prob`` the normal density."""
    hypothesis = odometry_control(before, after)
    sigmas = odometry_sigmas(hypothesis, alphas)
    errors = np.array(control) - np.array(hypothesis)
    errors[[0, 2]] = wrap_angle(errors[[0, 2]])
    return float(np.prod(np.exp(-0.5 * (errors / sigmas) ** 2) / (sigmas * math.sqrt(2.0 * math.pi))))


def expected_range(
    occupied: BoolArray, geometry: GridGeometry, sensor_pose: Float64Array, bearing: float, range_max: float
) -> float:
    """Return the distance at which a beam enters the first occupied cell, at most ``range_max``, metres.

    All crossings of the beam with the lattice lines are sorted by distance; between two of them it is in one cell.
    """
    u, v = geometry.to_lattice(sensor_pose[:2])
    heading = sensor_pose[2] + bearing - geometry.origin[2]
    d = np.array([math.cos(heading), math.sin(heading)])
    far = range_max / geometry.resolution
    crossings = [0.0, far]
    for start, slope in ((u, d[0]), (v, d[1])):
        if slope != 0.0:
            low, high = sorted((start, start + far * slope))
            lines = np.arange(math.ceil(low), math.floor(high) + 1)
            crossings += ((lines - start) / slope).tolist()
    ordered = sorted(t for t in crossings if 0.0 <= t <= far)
    for near, next_one in pairwise(ordered):
        middle = 0.5 * (near + next_one)
        row, col = math.floor(v + middle * d[1]), math.floor(u + middle * d[0])
        if 0 <= row < geometry.rows and 0 <= col < geometry.cols and occupied[row, col]:
            return near * geometry.resolution
    return range_max


def count_unexplained(
    readings: Sequence[float],
    bearings: Sequence[float],
    sensor_pose: Float64Array,
    map_range: Callable[[Float64Array, float], float],
    turn: float,
    margin: float,
) -> tuple[int, int]:
    """Return how many readings are longer and shorter than the map allows within ``turn`` radians of their bearings.

    ``map_range`` returns the range in the map for a sensor pose and a bearing; readings may deviate from it by
    ``margin`` m.
    """
    longer = shorter = 0
    for z, bearing in zip(readings, bearings, strict=True):
        ranges = [map_range(sensor_pose, bearing + side * turn) for side in (-1, 0, 1)]
        longer += z > max(ranges) + margin
        shorter += z < min(ranges) - margin
    return longer, shorter


def beam_density(
    z: float, expected: float, z_hit: float, z_short: float, z_max: float, z_rand: float, sigma_hit: float,
    lambda_short: float, range_max: float,
) -> float:  # fmt: skip
    """Return p(z | x, m) of one reading, table 6.1, line 4, with equations (6.4) to (6.11).

    p_hit is the normal density without the factor that makes its integral over [0, ``range_max``] one.
    """
    p_hit = math.exp(-0.5 * ((z - expected) / sigma_hit) ** 2) / (sigma_hit * math.sqrt(2.0 * math.pi))
    share = 1.0 - math.exp(-lambda_short * expected)
    p_short = lambda_short * math.exp(-lambda_short * z) / share if z <= expected and share > 0.0 else 0.0
    p_max = 1.0 if z >= range_max else 0.0
    p_rand = 1.0 / range_max if z < range_max else 0.0
    return z_hit * p_hit + z_short * p_short + z_max * p_max + z_rand * p_rand


def beam_range_finder_model(readings: Sequence[float], expected: Sequence[float], *mixture: float) -> float:
    """Return q = Π p(z_k | x, m) for readings and their expected ranges in the map. Table 6.1."""
    q = 1.0
    for z, z_map in zip(readings, expected, strict=True):
        q *= beam_density(z, z_map, *mixture)
    return q


def likelihood_field_range_finder_model(
    distances: Float64Array, z_hit: float, z_rand: float, sigma_hit: float, range_max: float
) -> float:
    """Return q of a scan whose endpoints are ``distances`` (k,) from the nearest occupied cell. Table 6.3.

    The factor 1 / (σ √2π) of ``prob`` is omitted, as in AMCL, so that ``z_hit`` and ``z_rand`` have the same meaning.
    Readings of ``range_max`` and more are excluded by the caller (line 3).
    """
    q = 1.0
    for distance in distances:
        q *= z_hit * math.exp(-(distance**2) / (2.0 * sigma_hit**2)) + z_rand / range_max
    return q


def distances_to_occupied(occupied: BoolArray, resolution: float, most: float) -> Float64Array:
    """Return the distance of each cell's centre (rows, cols) from that of the nearest occupied cell, at most ``most``
    m.
    """
    rows, cols = np.nonzero(occupied)
    out = np.full(occupied.shape, most)
    for r, c in np.ndindex(*occupied.shape):
        if len(rows):
            out[r, c] = min(most, resolution * math.sqrt(float(np.min((rows - r) ** 2 + (cols - c) ** 2))))
    return out


def field_score(scores: NDArray[np.uint16], geometry: GridGeometry, points: Float64Array, pose: Float64Array) -> int:
    """Return the sum of a field's ``scores`` (rows, cols) at the endpoints (k, 2) of a scan taken at ``pose``."""
    total = 0
    for point in points:
        end = compose(pose, np.array([point[0], point[1], 0.0]))[:2]
        row, col = geometry.world_to_cell(end)
        if 0 <= row < geometry.rows and 0 <= col < geometry.cols:
            total += int(scores[row, col])
    return total


def low_variance_sampler(weights: Float64Array, first: float, count: int) -> Int64Array:
    """Return the indices (count,) of particles drawn by ``weights`` (n,), Σ = 1; 0 ≤ first < 1/count is r in table
    4.4.
    """
    drawn, c, i = [], weights[0], 0
    for m in range(count):
        u = first + m / count
        while u > c and i < len(weights) - 1:
            i += 1
            c += weights[i]
        drawn.append(i)
    return np.array(drawn, dtype=np.int64)


def effective_number(weights: Float64Array) -> float:
    """Return N_eff = 1 / Σ w² of weights (n,), Σ = 1. Source: Liu 1996; Grisetti et al. 2005, equation 9."""
    return 1.0 / math.fsum(w * w for w in weights.tolist())


def bin_of(pose: Float64Array, side: float, turn: float) -> tuple[int, int, int]:
    """Return the bin of a pose: x and y in steps of ``side`` metres, the angle in steps of ``turn`` radians."""
    return math.floor(pose[0] / side), math.floor(pose[1] / side), math.floor(pose[2] / turn)


def kld_number(k: int, error: float, quantile: float) -> float:
    """Return the number of particles that k bins need. Table 8.4, line 11: equation (8.11).

    It is a quantile of the χ² distribution with k − 1 degrees of freedom, from the ``quantile`` of the standard normal
    distribution by the Wilson–Hilferty transformation, divided by twice the error.
    """
    freedom = max(k - 1, 0)
    if freedom == 0:
        return 0.0
    mean, deviation = 1.0 - 2.0 / (9.0 * freedom), math.sqrt(2.0 / (9.0 * freedom))
    return float(freedom * (mean + quantile * deviation) ** 3 / (2.0 * error))


def kld_sampling_mcl(
    draw: Callable[[], Float64Array], least: int, most: int, error: float, quantile: float, side: float, turn: float
) -> Float64Array:
    """Return particles (n, 3), drawn one at a time by ``draw`` until their bins need no more. Table 8.4."""
    particles: list[Float64Array] = []
    bins: set[tuple[int, int, int]] = set()
    while len(particles) < most and (len(particles) < least or len(particles) < kld_number(len(bins), error, quantile)):
        particles.append(draw())
        bins.add(bin_of(particles[-1], side, turn))
    return np.array(particles)


def mcl(
    particles: Float64Array,
    sample_motion: Callable[[Float64Array], Float64Array],
    measurement: Callable[[Float64Array], float],
    first: float,
) -> Float64Array:
    """Return the particles (n, 3) after a motion and a measurement. Table 8.2, resampled as in table 4.4."""
    moved = np.array([sample_motion(particle) for particle in particles])
    weights = np.array([measurement(particle) for particle in moved])
    return moved[low_variance_sampler(weights / weights.sum(), first, len(moved))]


def augmented_share(
    average: float, slow: float, fast: float, alpha_slow: float, alpha_fast: float
) -> tuple[float, float, float]:
    """Return w_slow, w_fast and the fraction of random particles, max(0, 1 − w_fast / w_slow). Table 8.3, from line
    10.
    """
    slow = (1.0 - alpha_slow) * slow + alpha_slow * average
    fast = (1.0 - alpha_fast) * fast + alpha_fast * average
    return slow, fast, 0.0 if fast >= slow else 1.0 - fast / slow


def clusters(particles: Float64Array, side: float, turn: float) -> Int64Array:
    """Return the cluster number (n,) of each particle; bins that touch, also at a corner, form one cluster.

    Clusters are numbered by their first particles. The angle wraps around. Source: AMCL, pf_kdtree_cluster.
    """
    turns = round(2.0 * math.pi / turn)
    bins = [bin_of(particle, side, turn) for particle in particles]

    def neighbours(a: tuple[int, int, int], b: tuple[int, int, int]) -> bool:
        round_way = (a[2] - b[2]) % turns
        return abs(a[0] - b[0]) <= 1 and abs(a[1] - b[1]) <= 1 and min(round_way, turns - round_way) <= 1

    number = np.full(len(particles), -1, dtype=np.int64)
    count = 0
    for start in range(len(particles)):
        if number[start] >= 0:
            continue
        waiting = [start]
        number[start] = count
        while waiting:
            at = waiting.pop()
            for other in np.flatnonzero(number < 0):
                if neighbours(bins[at], bins[other]):
                    number[other] = count
                    waiting.append(int(other))
        count += 1
    return number


def bandwidth(n: int, dimensions: int = 3) -> float:
    """Return the bandwidth of a Gaussian kernel density estimate of n samples, in units of their standard deviation.

    A(K) n^(−1 / (d + 4)) with A(K) of the normal kernel. Source: Silverman 1986, Density Estimation, table 4.1.
    """
    exponent = -1.0 / (dimensions + 4)
    return math.exp(exponent * (math.log(dimensions + 2) - math.log(4.0))) * math.exp(exponent * math.log(n))
