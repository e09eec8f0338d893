"""Scan matching, for the table: random scans and poses, by the kernels and by the textbook."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.core.se2 import transform_points
from mapper.grid import GridGeometry
from mapper.matching import textbook
from mapper.matching.beams import HALF_WIDTH, LEAST_GAP, MAX_THICKNESS, MOST_BEAMS, REACH, prepare_scans
from mapper.matching.fields import FINE, gaussian_stamps
from mapper.matching.kernels.correlative import Window, best_in_window, branch_and_bound, score_window
from mapper.matching.kernels.likelihood_field import accumulate_field
from mapper.matching.kernels.point_to_line import accumulate_pairs, refine_pair, refine_pose, solve_step
from mapper.matching.kernels.score_field import add_scan, write_pyramid
from mapper.matching.kernels.segments import split_scan
from mapper.matching.kernels.types import CAUCHY, HUBER, LINE, POINTS, SQUARES, Iterations, PairRule, ScanArrays
from mapper.matching.kernels.views import compare_views
from mapper.sensors.scan import ScanLog, Trajectory
from tests.agreement.inputs import some

WEIGHTS = {"squares": SQUARES, "huber": HUBER, "cauchy": CAUCHY}


@dataclass(frozen=True)
class MatchCase:
    """A log of two scans of a room, where they were taken, and how to compare them."""

    log: ScanLog
    poses: np.ndarray  # (2, 3)
    gate: float
    max_beams: int
    min_cosine: float
    weight: str
    scale: float
    keep: float
    to_line: bool

    @property
    def scans(self) -> ScanArrays:
        return prepare_scans(self.log)

    @property
    def rule(self) -> PairRule:
        residual = LINE if self.to_line else POINTS
        return PairRule(self.min_cosine, self.max_beams, WEIGHTS[self.weight], self.scale, 1, self.keep, residual)


def point_scan(scans: ScanArrays, i: int) -> textbook.PointScan:
    """One of the prepared scans as the textbook takes it."""
    return textbook.PointScan(
        scans.points[i].astype(np.float64), scans.kind[i] > 0, scans.normals[i].astype(np.float64), scans.kind[i] > 1,
        scans.first[i], scans.step[i], bool(scans.wraps[i]), scans.sensor[i],
    )  # fmt: skip


@st.composite
def match_cases(draw: st.DrawFn) -> MatchCase:
    """Scans of a rectangular room with some readings replaced: by others, by no return, by none at all."""
    n_beams = draw(st.integers(3, 60))
    turn = draw(st.sampled_from([np.pi, 1.5 * np.pi, 2 * np.pi, 1.0]))
    step = turn / n_beams * draw(st.sampled_from([1.0, -1.0]))
    first = draw(some(0.0, -np.pi / 2, low=-4.0, high=4.0))
    mount = (draw(some(0.0, low=-0.5, high=0.5)), draw(some(0.0, low=-0.5, high=0.5)), draw(some(0.0, low=-4, high=4)))
    wide, deep = draw(st.floats(1.0, 6.0)), draw(st.floats(1.0, 6.0))
    poses = np.array([[draw(st.floats(-0.8, 0.8)), draw(st.floats(-0.8, 0.8)), draw(st.floats(-4, 4))] for _ in "ab"])
    bearings = poses[:, 2:] + mount[2] + first + step * np.arange(n_beams)
    with np.errstate(divide="ignore", over="ignore"):
        to_x = (np.where(np.cos(bearings) > 0, wide, -wide) - poses[:, :1]) / np.cos(bearings)
        to_y = (np.where(np.sin(bearings) > 0, deep, -deep) - poses[:, 1:2]) / np.sin(bearings)
    ranges = np.minimum(np.abs(to_x), np.abs(to_y))
    for _ in range(draw(st.integers(0, n_beams // 2))):
        i, k = draw(st.integers(0, 1)), draw(st.integers(0, n_beams - 1))
        ranges[i, k] = draw(some(np.inf, np.nan, -np.inf, 0.0, 10.0, low=0.0, high=12.0))
    log = ScanLog(
        ranges.astype(np.float32), first, step, 0.05, 10.0, np.zeros(2, dtype=np.int64),
        {"scan": Trajectory(poses)}, mount,
    )  # fmt: skip
    moved = poses + np.array(
        [[0, 0, 0], [draw(st.floats(-0.3, 0.3)), draw(st.floats(-0.3, 0.3)), draw(st.floats(-0.3, 0.3))]]
    )
    return MatchCase(
        log, moved, draw(some(0.3, low=0.01, high=1.0)), draw(st.integers(0, 20) | st.just(100)),
        draw(some(-1.0, 0.7, low=-1.0, high=1.0)), draw(st.sampled_from(sorted(WEIGHTS))), draw(st.floats(0.01, 0.2)),
        draw(some(1.0, low=0.0, high=1.0)), draw(st.booleans()),
    )  # fmt: skip


def prepared_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    scans = case.scans
    return scans.points.astype(np.float64), scans.normals.astype(np.float64), scans.kind


def prepared_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    log, scans, out = case.log, case.scans, []
    order = np.argsort(log.angles, kind="stable")
    for i, ranges in enumerate(log.ranges):
        points, used = textbook.scan_points(
            ranges[order], log.angles[order], np.array(log.mount), log.range_min, log.range_max
        )
        kernel = point_scan(scans, i)
        # The compiled points are float32, of which the line's direction is made.
        rounded = textbook.PointScan(
            kernel.points, used, kernel.normals, used, kernel.first, kernel.step, kernel.wraps, kernel.sensor
        )
        normals, with_normal = textbook.scan_normals(rounded, HALF_WIDTH, REACH, MOST_BEAMS, LEAST_GAP, MAX_THICKNESS)
        out.append((points, normals, used.astype(np.uint8) + with_normal))
    return tuple(np.stack(part) for part in zip(*out, strict=True))


def equations_by_textbook(
    case: MatchCase, gate: float, poses: np.ndarray, stride: int = 1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The normal equations (6, 6), (6,) of the second scan against the first, and the counts and sums (4,)."""
    moving, fixed = point_scan(case.scans, 1), point_scan(case.scans, 0)
    if case.min_cosine > -1.0:
        moving = replace(moving, is_point=moving.has_normal)
    moving = replace(moving, is_point=moving.is_point & (np.arange(len(moving.points)) % stride == 0))
    if not case.to_line and case.min_cosine <= -1.0:
        fixed = replace(fixed, has_normal=fixed.is_point)
    ours, theirs, tried = textbook.pairs_by_bearing(moving, poses[1], fixed, poses[0], gate, case.max_beams)
    turned = transform_points([0.0, 0.0, poses[0, 2]], fixed.normals[theirs])
    if case.min_cosine > -1.0:
        cosines = np.sum(turned * transform_points([0.0, 0.0, poses[1, 2]], moving.normals[ours]), axis=1)
        ours, theirs, turned = (part[cosines >= case.min_cosine] for part in (ours, theirs, turned))
    to = transform_points(poses[0], fixed.points[theirs])
    if case.to_line:
        e, jacobian = textbook.point_to_line_residuals(moving.points[ours], poses[1], to, turned)
        lengths = np.abs(e)
    else:
        e, jacobian = textbook.point_to_point_residuals(moving.points[ours], poses[1], to)
        lengths = np.hypot(*e.reshape(-1, 2).T)
    kept = textbook.smallest(lengths, case.keep)
    w = textbook.weights(case.weight, case.scale, lengths) * kept
    # The other scan's step has the same effect as the opposite one of the first, taken around the other's place.
    x, y = poses[0, :2] - poses[1, :2]
    by_other = -np.column_stack([jacobian[:, :2], jacobian[:, 2] + y * jacobian[:, 0] - x * jacobian[:, 1]])
    rows = np.repeat(w, len(e) // max(len(w), 1))
    hessian, gradient = textbook.normal_equations(np.hstack([jacobian, by_other]), e, rows)
    return hessian, gradient, np.array([kept.sum(), tried, np.sum(lengths[kept] ** 2), np.sum(w * lengths**2)])


def equations_of_pairs_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    hessians, gradients, figures = np.empty((1, 6, 6)), np.empty((1, 6)), np.empty((1, 4))
    accumulate_pairs(
        case.scans, np.array([1]), np.array([0]), case.poses, case.gate, case.rule, hessians, gradients, figures
    )
    return hessians[0], gradients[0], figures[0]


def equations_of_pairs_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    return equations_by_textbook(case, case.gate, case.poses)


PRIOR_WEIGHT = np.array([3.0, 3.0, 5.0])
ITERATIONS = Iterations(4, 0.4, 0.1, 0.5, 0.0, 0.0)


def refined_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    pose, hessian = case.poses[1].copy(), np.empty((3, 3))
    *_, count = refine_pose(
        case.scans, 1, case.scans, np.array([0]), case.poses, case.poses[1], PRIOR_WEIGHT, case.rule, ITERATIONS,
        pose, hessian,
    )  # fmt: skip
    return pose, hessian, count


def refined_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    poses, hessian = case.poses.copy(), np.empty((3, 3))
    gate = ITERATIONS.first_gate
    for _ in range(ITERATIONS.most):
        stride = 1 if gate <= ITERATIONS.last_gate else 2
        both, gradient, _figures = equations_by_textbook(case, gate, poses, stride)
        hessian = stride * both[:3, :3] + np.diag(PRIOR_WEIGHT)
        off = poses[1] - case.poses[1]
        poses[1] += np.linalg.solve(hessian, stride * gradient[:3] - PRIOR_WEIGHT * off)
        gate = max(gate * ITERATIONS.shrink, ITERATIONS.last_gate)
    poses[1, 2] = (poses[1, 2] + np.pi) % (2 * np.pi) - np.pi
    return poses[1], hessian, ITERATIONS.most


def refined_both_ways_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    pose, hessian = case.poses[1].copy(), np.empty((3, 3))
    iterations = ITERATIONS._replace(most=1, last_gate=ITERATIONS.first_gate)
    scans = case.scans
    *figures, count = refine_pair(scans, 1, scans, 0, case.poses[0], case.rule, iterations, pose, hessian)
    return hessian, np.array(figures), count


def refined_both_ways_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    case = replace(case, scale=max(case.scale, 0.25 * ITERATIONS.first_gate))
    there, _, figures = equations_by_textbook(case, ITERATIONS.first_gate, case.poses)
    log = replace(case.log, ranges=case.log.ranges[::-1])
    back, _, more = equations_by_textbook(replace(case, log=log), ITERATIONS.first_gate, case.poses[::-1])
    return there[:3, :3] + back[3:, 3:], figures + more, 1


def views_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    counts = compare_views(case.scans, 1, case.poses[1], case.scans, 0, case.poses[0], case.gate, case.max_beams)
    return (np.array(counts),)


def views_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    first, second = point_scan(case.scans, 0), point_scan(case.scans, 1)
    counts = textbook.compare_views(second, case.poses[1], first, case.poses[0], case.gate, case.max_beams)
    return (np.array(counts),)


def step_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    hessian, gradient, _ = equations_of_pairs_by_kernel(case)
    step = np.empty(3)
    hessian = hessian[:3, :3] + np.eye(3)
    return step, solve_step(hessian, gradient[:3], step)


def step_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    hessian, gradient, _ = equations_of_pairs_by_kernel(case)
    return np.linalg.solve(hessian[:3, :3] + np.eye(3), gradient[:3]), True


RESOLUTION, SIGMA = 0.1, 0.12


def _field(case: MatchCase) -> tuple[GridGeometry, np.ndarray]:
    """A field that is smaller than the room, so that points lie outside, with the first scan in it."""
    geometry = GridGeometry(RESOLUTION, 40, 60, (-3.0, -2.0, 0.3))
    scores = np.zeros(geometry.shape, dtype=np.uint8)
    add_scan(scores, geometry.frame, gaussian_stamps(RESOLUTION, SIGMA), case.scans, 0, case.poses[0], 1)
    return geometry, scores


def fields_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    _, scores = _field(case)
    levels = np.empty((4, *scores.shape), dtype=np.uint8)
    write_pyramid(scores, levels)
    return (levels,)


def fields_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    geometry, _ = _field(case)
    scan, (c, s) = point_scan(case.scans, 0), (np.cos(case.poses[0, 2]), np.sin(case.poses[0, 2]))
    x, y = scan.points[scan.is_point].T
    placed = np.stack([case.poses[0, 0] + c * x - s * y, case.poses[0, 1] + s * x + c * y], axis=-1)
    reach = gaussian_stamps(RESOLUTION, SIGMA).shape[2] // 2
    scores = textbook.score_field(geometry, placed, SIGMA, FINE, reach)
    return (np.stack([textbook.greatest_in_squares(scores, 1 << level) for level in range(4)]),)


def field_equations_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    geometry, scores = _field(case)
    hessian, gradient = np.empty((3, 3)), np.empty(3)
    figures = accumulate_field(scores, geometry.frame, case.scans, 1, case.poses[1], 1, hessian, gradient)
    return hessian, gradient, np.array(figures)


def field_equations_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    geometry, scores = _field(case)
    scan = point_scan(case.scans, 1)
    e, jacobian = textbook.field_residuals(scores, geometry, scan.points[scan.is_point], case.poses[1])
    return *textbook.normal_equations(jacobian, e, np.ones(len(e))), np.array([len(e), np.sum(e**2)])


def split_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    found = np.zeros((case.log.n_beams, 2), dtype=np.int64)
    count = split_scan(case.scans, 0, case.gate, case.scale, 3, found)
    return (found[:count],)


def split_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    scan = point_scan(case.scans, 0)
    found = [
        run[list(ends)]
        for run in textbook.runs(scan, case.gate)
        for ends in textbook.split(scan.points[run], case.scale, 3)
    ]
    return (np.array(found, dtype=np.int64).reshape(-1, 2),)


WINDOW = Window(5, 2, 0.07)


def searched_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    geometry, scores = _field(case)
    size = 2 * WINDOW.cells + 1
    volume, best, found = np.empty((2 * WINDOW.turns + 1, size, size), np.int32), np.empty(4, np.int64), []
    score_window(scores, geometry.frame, case.scans, 1, case.poses[1], WINDOW, 1, volume)
    best_in_window(volume, best)
    for top in (0, 1, 3):
        levels, bounded = np.empty((top + 1, *scores.shape), dtype=np.uint8), np.empty(4, dtype=np.int64)
        write_pyramid(scores, levels)
        branch_and_bound(levels, geometry.frame, case.scans, 1, case.poses[1], WINDOW, 1, 1, bounded)
        found.append(bounded)
    return volume, best, *found


def searched_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    geometry, scores = _field(case)
    scan = point_scan(case.scans, 1)
    turns = np.asarray(np.arange(-WINDOW.turns, WINDOW.turns + 1) * WINDOW.turn, dtype=np.float64)
    points = scan.points[scan.is_point]
    volume = textbook.scores_in_window(scores, geometry, points, case.poses[1], turns, WINDOW.cells)
    a, y, x = np.unravel_index(int(np.argmax(volume)), volume.shape)
    best = np.array([volume.max(), a - WINDOW.turns, y - WINDOW.cells, x - WINDOW.cells])
    bounded = best if best[0] > 0 else np.array([-1, 0, 0, 0])
    return volume, best, bounded, bounded, bounded
