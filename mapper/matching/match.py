"""A match: pose, covariance, agreement of both sides, and unobservable directions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import wrap_angle
from mapper.matching.kernels.likelihood_field import accumulate_field, refine_on_field
from mapper.matching.kernels.point_to_line import accumulate_scan, refine_pair, refine_pose
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.kernels.views import compare_views
from mapper.matching.parameters import MatchConfig
from mapper.matching.search import SEARCHES
from mapper.matching.target import Target
from mapper.matching.task import MOST_BEAMS, Task

FIELD_LEVELS = (4.0, 2.0, 1.0)  #: the widths of the fields, coarse to fine, in units of ``field_sigma``
NO_PRIOR = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Refined:
    """A refined pose (3,) and its least-squares problem; each observation of a surface counts once.

    ``hessian`` (3, 3) is Σ w JᵀJ, ``cost`` Σ w e² and ``pairs`` the number of residuals. ``unit`` is the unit of the
    residuals: "m", or "" for those of a field.
    """

    pose: Float64Array
    hessian: Float64Array
    cost: float
    pairs: int
    iterations: int
    unit: str = "m"


def by_pairs(task: Task, pose: Float64Array) -> Refined:
    """Refine by pairs of points, in both directions if the target is one scan."""
    target, hessian = task.target, np.empty((3, 3))
    pose = pose.copy()
    if len(target.indices) == 1:
        j = int(target.indices[0])
        pairs, _, _, cost, done = refine_pair(
            task.source, task.index, target.scans, j, target.poses[j], task.rule, task.iterations, pose, hessian
        )
        return Refined(pose, hessian / 2.0, cost / 2.0, pairs // 2, done)
    pairs, _, _, cost, done = refine_pose(
        task.source, task.index, target.scans, target.indices, target.poses, pose, NO_PRIOR, task.rule, task.iterations,
        pose, hessian,
    )  # fmt: skip
    share = 1.0 / len(target.indices)
    return Refined(pose, hessian * share, cost * share, int(pairs * share), done)


def on_field(task: Task, pose: Float64Array) -> Refined:
    """Refine on fields of decreasing width."""
    pose, hessian, config = pose.copy(), np.zeros((3, 3)), task.config
    inside, cost, done = 0, 0.0, 0
    for level in FIELD_LEVELS:
        geometry, scores = task.score_field(config.field_resolution, config.field_sigma * level)
        inside, cost, count = refine_on_field(
            scores, geometry.frame, task.source, task.index, 1, task.iterations, pose, hessian
        )
        done += count
    return Refined(pose, hessian, cost, inside, done, "")


def unrefined(task: Task, pose: Float64Array) -> Refined:
    """Return the pose unchanged, with its least-squares problem: point to line, or the field of a map."""
    hessian, gradient, cost, pairs = np.zeros((3, 3)), np.zeros(3), 0.0, 0
    if task.target.is_map:
        geometry, scores = task.score_field(task.config.field_resolution, task.config.field_sigma)
        pairs, cost = accumulate_field(scores, geometry.frame, task.source, task.index, pose, 1, hessian, gradient)
        return Refined(pose.copy(), hessian, cost, pairs, 0, "")
    for j in task.target.indices:
        n, _, _, weighted = accumulate_scan(
            task.source, task.index, pose, task.target.scans, int(j), task.target.poses[j], task.config.first_gate,
            task.rule, hessian, gradient,
        )  # fmt: skip
        pairs += n
        cost += weighted
    share = 1.0 / len(task.target.indices)
    return Refined(pose.copy(), hessian * share, cost * share, int(pairs * share), 0)


REFINEMENTS: Mapping[str, Callable[[Task, Float64Array], Refined]] = {
    "none": unrefined,
    "point_to_line": by_pairs,
    "point_to_point": by_pairs,
    "likelihood_field": on_field,
}


FEW_POINTS = 20.0  #: number of non-agreeing points added to the total, so that a few points alone score low
SAME_SCORE = 0.01  #: a smaller difference in score does not decide which pose is right
LEAST_VARIANCE = 1e-8  #: of a residual, if all are 0
NOT_KNOWN = 1e6  #: maximum variance, m² or rad²


@dataclass(frozen=True, slots=True)
class Match:
    """The result of a match.

    ``pose`` (3,) is ``T_target_base``, metres and radians. ``covariance`` (3, 3) of x, y and θ is s² H⁻¹, the inverse
    of the Gauss–Newton Hessian times the variance of the weighted residuals, s² = Σ w e² / (n − 3) (Press et al. 2007,
    Numerical Recipes, 15.4; it assumes independent residuals and the right basin, so it is a lower bound). ``score``, 0
    to 1, measures the agreement of the two sides; see :func:`agreement`. ``is_degenerate`` means that some direction is
    not observable, as along a corridor; ``unknown_direction`` (3,) is then the motion (x, y, θ) in the target's frame
    that changes the residuals least. ``information`` is its fraction of the information, 0 to ½ (Zhang, Kaess & Singh
    2016 also use the smallest eigenvalue). ``candidates`` (k, 3) are the refined poses from which the best was chosen,
    and ``scores`` (k,) their scores.
    """

    pose: Float64Array
    covariance: Float64Array
    score: float
    is_degenerate: bool
    unknown_direction: Float64Array | None
    information: float
    rms: float
    pairs: int
    iterations: int
    candidates: Float64Array
    scores: Float64Array
    method: str


def match_scan(
    source: ScanArrays, index: int, target: Target, guess: Float64Array, config: MatchConfig | None = None
) -> Match:
    """Return the pose of scan ``index`` of ``source`` in the frame of ``target``, starting from ``guess`` (3,).

    Raises :class:`ConfigError` and :class:`LimitError` like :class:`Task`, and :class:`ConfigError` if no part of the
    scan is near the target anywhere in the window.
    """
    task = Task(source, index, target, guess, MatchConfig() if config is None else config)
    parts = task.config.parts
    begins = SEARCHES[parts.search](task)
    if not len(begins):
        raise ConfigError("matching.apart", "No point of the scan lies near the target at any pose of the window.")
    refined = [REFINEMENTS[parts.refinement](task, pose) for pose in begins]
    scores = np.array([agreement(task, match.pose) for match in refined])
    best = _chosen(task, refined, scores)
    match = refined[best]
    match.pose[2] = wrap_angle(match.pose[2])
    information, direction = _least_known(task, match.hessian)
    is_degenerate = information < task.config.least_information
    return Match(
        match.pose,
        covariance(match),
        float(scores[best]),
        is_degenerate,
        direction if is_degenerate else None,
        information,
        float(np.sqrt(match.cost / max(match.pairs, 1))),
        match.pairs,
        sum(match.iterations for match in refined),
        np.array([match.pose for match in refined]),
        scores,
        task.config.method,
    )


def _chosen(task: Task, refined: list[Refined], scores: Float64Array) -> int:
    """Return the index of the refined pose with the best score or, among nearly equal ones, nearest to the guess."""
    off = np.array([match.pose for match in refined]) - task.guess
    far = np.hypot(off[:, 0], off[:, 1]) + np.abs(wrap_angle(off[:, 2]))
    far[scores < scores.max() - SAME_SCORE] = np.inf
    return int(np.argmin(far))


def agreement(task: Task, pose: Float64Array) -> float:
    """Return the agreement of a scan at ``pose`` (3,) with the target, 0 to 1.

    Each point with a point of the other side at distance d < gate counts 1 − d² / gate². The score is the sum divided
    by the number of points that both sides should have seen, in both directions: points that agree, points that the
    other side saw through, and points behind its measurements, plus 20. For a map it is the same for the fraction of
    agreeing points, in one direction.
    """
    source, target, gate = task.source, task.target, task.config.score_gate
    if target.is_map:
        geometry, scores = task.score_field(task.config.field_resolution, max(gate / 2.0, task.config.field_resolution))
        x, y = source.points[task.index, source.kind[task.index] > 0].T
        c, s = np.cos(pose[2]), np.sin(pose[2])
        cells = geometry.world_to_cell(np.stack([pose[0] + c * x - s * y, pose[1] + s * x + c * y], axis=-1))
        cells = cells[geometry.contains(cells)]
        return float(scores[cells[:, 0], cells[:, 1]].sum(dtype=np.int64) / 255.0 / (len(x) + FEW_POINTS))
    seen, total = 0, 0.0
    for j in target.indices:
        at = target.poses[j]
        for candidate in (
            compare_views(source, task.index, pose, target.scans, int(j), at, gate, MOST_BEAMS),
            compare_views(target.scans, int(j), at, source, task.index, pose, gate, MOST_BEAMS),
        ):
            seen += candidate[0] + candidate[1] + candidate[2]
            total += candidate[3]
    return float(total / (seen + FEW_POINTS * len(target.indices)))


def covariance(refined: Refined) -> Float64Array:
    """Return s² H⁻¹ (3, 3); directions without information have the variance :data:`NOT_KNOWN`."""
    variance = max(refined.cost / max(refined.pairs - 3, 1), LEAST_VARIANCE)
    values, vectors = np.linalg.eigh(refined.hessian)
    variances = variance / np.maximum(values, variance / NOT_KNOWN)
    return np.asarray((vectors * variances) @ vectors.T)


def _least_known(task: Task, hessian: Float64Array) -> tuple[float, Float64Array]:
    """Return the smallest fraction of the information in any direction, and that direction (3,).

    The angle is scaled by the root mean square distance of the points, so that radians and metres are comparable. The
    fractions are eigenvalues of the scaled Hessian over the trace of its translation part, which is Σ w.
    """
    points = task.source.points[task.index, task.source.kind[task.index] > 0].astype(np.float64)
    lever = max(float(np.sqrt(np.mean(np.sum(points**2, axis=1)))), 1e-3)
    scale = np.array([1.0, 1.0, 1.0 / lever])
    total = hessian[0, 0] + hessian[1, 1]
    if not total > 0.0:
        return 0.0, np.array([1.0, 0.0, 0.0])
    values, vectors = np.linalg.eigh(hessian * scale * scale[:, np.newaxis])
    direction = vectors[:, 0] * scale
    first = direction[np.argmax(np.abs(direction))]
    return float(max(values[0], 0.0) / total), direction / np.linalg.norm(direction) * np.sign(first)
