"""Monte Carlo localization, for the table: random maps, particles and scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.special import ndtri

from mapper.core.se2 import compose, transform_points
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.localization import LocalizationConfig, textbook
from mapper.localization.estimate import find_clusters
from mapper.localization.kernels.beam_model import weigh_by_beams
from mapper.localization.kernels.motion import draw_normal, draw_uniform, move_particles
from mapper.localization.kernels.resampling import fill_bins, low_variance
from mapper.localization.kernels.scan_at_pose import count_unexplained, score_poses
from mapper.localization.kernels.types import Bins, Mixture, OccupiedCells
from mapper.localization.likelihood_field import likelihood_field, occupied_cells
from mapper.localization.monte_carlo import bandwidth
from mapper.localization.motion import key_of, motion_between
from mapper.localization.recovery import averaged
from mapper.localization.resample import kld_number
from mapper.localization.weighing import effective_number

RANGE_MAX = 5.0


@dataclass(frozen=True)
class LocalizationCase:
    """A map with some walls, particles in and around it, and a scan."""

    grid: OccupancyGrid
    particles: np.ndarray
    weights: np.ndarray
    ranges: np.ndarray
    bearings: np.ndarray
    odometry: np.ndarray
    config: LocalizationConfig
    key: int


@st.composite
def localization_cases(draw: st.DrawFn) -> LocalizationCase:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    rows, cols, n = draw(st.integers(3, 12)), draw(st.integers(3, 12)), draw(st.integers(1, 25))
    grid = OccupancyGrid(GridGeometry(0.25, rows, cols, (-1.0, 0.5, draw(st.sampled_from([0.0, 0.7])))))
    grid.observed[:] = True
    grid.log_odds[:] = np.where(rng.random((rows, cols)) < 0.2, 3.0, -3.0)
    grid.log_odds[rows // 2, cols // 2] = 3.0
    particles = np.column_stack(
        [
            transform_points(grid.geometry.origin, rng.uniform(-0.5, 3.5, (n, 2))),
            rng.uniform(-math.pi, math.pi, n),
        ]
    )
    config = LocalizationConfig(
        laser_model_type=draw(st.sampled_from(["likelihood_field", "likelihood_field_prob"])),
        robot_model_type=draw(st.sampled_from(["differential", "omni"])),
        alpha1=float(rng.uniform(0, 0.5)), alpha2=float(rng.uniform(0, 0.5)), alpha3=float(rng.uniform(0, 0.5)),
        alpha4=float(rng.uniform(0, 0.5)), sigma_hit=float(rng.uniform(0.05, 0.5)),
    )  # fmt: skip
    weights = rng.random(n) + 1e-3
    odometry = rng.normal(size=(2, 3)) * draw(st.sampled_from([0.001, 0.3, 1.0]))
    ranges = np.append(rng.uniform(0.05, RANGE_MAX, 7), RANGE_MAX)
    return LocalizationCase(
        grid, particles, weights / weights.sum(), ranges, rng.uniform(-3, 3, 8), odometry, config,
        key_of(draw(st.integers(0, 2**62)), 3, 1),
    )  # fmt: skip


def _uniform(key: int, counter: int) -> float:
    """The generator's number: the hash of its counter, here with integers of any size."""

    def hashed(x: int) -> int:
        for shift, factor in ((16, 0x21F0AAAD), (15, 0x735A2D97)):
            x = ((x ^ (x >> shift)) * factor) % 2**32
        return x ^ (x >> 15)

    return (hashed(hashed((counter ^ key) % 2**32) ^ ((key >> 31) % 2**32)) + 0.5) / 2**32


def _normals(key: int, i: int) -> np.ndarray:
    return np.array([ndtri(_uniform(key, 3 * i + j)) for j in range(3)])


def moved_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    out = case.particles.copy()
    before, after = case.odometry
    move_particles(out, motion_between(before, after, case.config), case.key, 0, len(out))
    return _position_and_heading(out)


def moved_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    c, (before, after) = case.config, case.odometry
    alphas = (c.alpha1, c.alpha2, c.alpha3, c.alpha4)
    out = []
    for i, pose in enumerate(case.particles):
        normals = _normals(case.key, i)
        if c.robot_model_type == "omni":
            cos, sin = math.cos(before[2]), math.sin(before[2])
            dx, dy = after[:2] - before[:2]
            motion = np.array(
                [cos * dx + sin * dy, cos * dy - sin * dx, math.remainder(after[2] - before[2], math.tau)]
            )
            out.append(textbook.sample_motion_model_omni(motion, (*alphas, c.alpha5), pose, normals))
        else:
            control = textbook.odometry_control(before, after)
            sigmas = textbook.odometry_sigmas(control, alphas)
            out.append(textbook.sample_motion_model_odometry(control, sigmas, pose, normals))
    return _position_and_heading(np.array(out))


def numbers_by_filter(case: LocalizationCase) -> tuple[Any, ...]:
    """Motion, numbers of particles, bandwidth and averages, as the filter computes them."""
    config = replace(case.config, recovery_alpha_slow=0.02, recovery_alpha_fast=0.3, robot_model_type="differential")
    before, after = case.odometry
    *control, _, _, _, _ = motion = motion_between(before, after, config)
    k, average = len(case.weights), float(case.weights[0])
    slow, fast = averaged(average, 0.4, 0.5, config)
    return (
        _turns(control),
        np.array(motion[3:6]),
        np.array([effective_number(case.weights), kld_number(k, config.pf_err, config.pf_z), bandwidth(k)]),
        np.array([slow, fast]),
    )


def numbers_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    c, (before, after) = case.config, case.odometry
    control = textbook.odometry_control(before, after)
    k, average = len(case.weights), float(case.weights[0])
    number = textbook.kld_number(k, c.pf_err, c.pf_z)
    slow, fast, _ = textbook.augmented_share(average, 0.4, 0.5, 0.02, 0.3)
    return (
        _turns(control),
        textbook.odometry_sigmas(control, (c.alpha1, c.alpha2, c.alpha3, c.alpha4)),
        np.array([textbook.effective_number(case.weights), number, textbook.bandwidth(k)]),
        np.array([slow, fast]),
    )


def _turns(control: Sequence[float]) -> np.ndarray:
    """Turn, distance and turn; a turn as its cosine and sine, since −π and π are one."""
    turn_1, distance, turn_2 = control
    return np.array([math.cos(turn_1), math.sin(turn_1), distance, math.cos(turn_2), math.sin(turn_2)])


def _position_and_heading(poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and unit vectors of headings: −π and π are one direction."""
    return poses[:, :2].copy(), np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])


def drawn_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    geometry, free = case.grid.geometry, np.flatnonzero(~occupied_cells(case.grid))
    anywhere, near = np.empty((9, 3)), np.empty((9, 3))
    draw_uniform(free, geometry.cols, geometry.frame, case.key, anywhere, 0, 9)
    draw_normal(case.particles[0], np.diag([0.5, 0.2, 0.1]), case.key, near, 0, 9)
    return anywhere, *_position_and_heading(near)


def drawn_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    geometry, free = case.grid.geometry, np.argwhere(~occupied_cells(case.grid))
    anywhere, near = [], []
    for i in range(9):
        u = [_uniform(case.key, 4 * i + j) for j in range(4)]
        row, col = free[math.floor((i + u[0]) * len(free) / 9)]
        x, y = geometry.cell_to_world((row + u[2] - 0.5, col + u[1] - 0.5))
        anywhere.append((x, y, math.pi * (2.0 * u[3] - 1.0)))
        near.append(case.particles[0] + [0.5, 0.2, 0.1] * _normals(case.key, i))
    return np.array(anywhere), *_position_and_heading(np.array(near))


def scored_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    field = likelihood_field(case.grid, case.config, RANGE_MAX)
    points = (np.array([np.cos(case.bearings), np.sin(case.bearings)]) * case.ranges).T.copy()
    sums = np.empty(len(case.particles), dtype=np.int64)
    score_poses(field.field, points, case.particles, 0, len(sums), sums)
    return (field.log_weights(sums, len(points)),)


def scored_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    """Table 6.3 with the distances of the cells in which the beams end."""
    c, geometry = case.config, case.grid.geometry
    most = c.laser_likelihood_max_dist
    nearest = textbook.distances_to_occupied(occupied_cells(case.grid), geometry.resolution, most)
    out = []
    for pose in case.particles:
        distances = []
        for r, bearing in zip(case.ranges, case.bearings, strict=True):
            end = compose(pose, (r * math.cos(bearing), r * math.sin(bearing), 0.0))[:2]
            cell = geometry.world_to_cell(end)
            distances.append(nearest[tuple(cell)] if geometry.contains(cell) else most)
        found = np.array(distances)
        if c.laser_model_type == "likelihood_field_prob":
            out.append(
                math.log(textbook.likelihood_field_range_finder_model(found, c.z_hit, c.z_rand, c.sigma_hit, RANGE_MAX))
            )
        else:
            p = [
                textbook.likelihood_field_range_finder_model(np.array([d]), c.z_hit, c.z_rand, c.sigma_hit, RANGE_MAX)
                for d in found
            ]
            out.append(math.log1p(sum(value**3 for value in p)))
    return (np.array(out),)


def beams_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    c = case.config
    mixture = Mixture(c.z_hit, c.z_short, c.z_max, c.z_rand, c.sigma_hit, c.lambda_short, RANGE_MAX)
    cells = OccupiedCells(occupied_cells(case.grid), case.grid.geometry.frame)
    out = np.empty(len(case.particles))
    beams = np.column_stack([case.ranges, case.bearings])
    weigh_by_beams(cells, mixture, beams, np.array([0.1, -0.05]), case.particles, 0, len(out), out)
    return (out,)


def beams_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    c, occupied = case.config, occupied_cells(case.grid)
    mixture = (c.z_hit, c.z_short, c.z_max, c.z_rand, c.sigma_hit, c.lambda_short, RANGE_MAX)
    out = []
    for pose in case.particles:
        sensor = compose(pose, (0.1, -0.05, 0.0))
        expected = [
            textbook.expected_range(occupied, case.grid.geometry, sensor, bearing, RANGE_MAX)
            for bearing in case.bearings
        ]
        out.append(math.log(max(textbook.beam_range_finder_model(case.ranges.tolist(), expected, *mixture), 1e-300)))
    return (np.array(out),)


def unexplained_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    beams, sensor = np.column_stack([case.ranges, case.bearings]), np.array([0.1, -0.05])
    cells = OccupiedCells(occupied_cells(case.grid), case.grid.geometry.frame)
    return (np.array([count_unexplained(cells, beams, sensor, one, 0.1, 0.3, RANGE_MAX) for one in case.particles]),)


def unexplained_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    occupied, geometry = occupied_cells(case.grid), case.grid.geometry

    def map_range(sensor_pose: np.ndarray, bearing: float) -> float:
        return textbook.expected_range(occupied, geometry, sensor_pose, bearing, RANGE_MAX)

    return (
        np.array(
            [
                textbook.count_unexplained(
                    case.ranges.tolist(), case.bearings.tolist(), compose(one, (0.1, -0.05, 0.0)), map_range, 0.1, 0.3
                )
                for one in case.particles
            ]
        ),
    )


def resampled_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    out = np.empty(2 * len(case.weights) + 1, dtype=np.int64)
    low_variance(case.weights, _uniform(case.key, 0) / len(out), out)
    table, numbers = np.empty(256, dtype=np.int64), np.empty(256, dtype=np.int64)
    bins = np.empty(len(out), dtype=np.int64)
    return out, fill_bins(case.particles, out, Bins(0.5, math.pi / 18.0), table, numbers, bins), bins


def resampled_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    count = 2 * len(case.weights) + 1
    out = textbook.low_variance_sampler(case.weights, _uniform(case.key, 0) / count, count)
    bins = [textbook.bin_of(case.particles[i], 0.5, math.pi / 18.0) for i in out]
    first = list(dict.fromkeys(bins))
    return out, len(first), np.array([first.index(one) for one in bins])


def clusters_by_kernel(case: LocalizationCase) -> tuple[Any, ...]:
    found = find_clusters(case.particles, case.weights)
    return found.number, found.weight, *_position_and_heading(found.mean), found.covariance[:, :2, :2]


def clusters_by_textbook(case: LocalizationCase) -> tuple[Any, ...]:
    number = textbook.clusters(case.particles, 0.5, math.pi / 18.0)
    weight, place, heading, spread = [], [], [], []
    for k in range(number.max() + 1):
        w, poses = case.weights[number == k], case.particles[number == k]
        weight.append(w.sum())
        place.append(np.average(poses[:, :2], axis=0, weights=w))
        off = poses[:, :2] - place[-1]
        spread.append(np.einsum("i,ij,ik->jk", w, off, off) / w.sum())
        vector = np.array([w @ np.cos(poses[:, 2]), w @ np.sin(poses[:, 2])])
        heading.append(vector / np.hypot(*vector))
    return number, np.array(weight), np.array(place), np.array(heading), np.array(spread)
