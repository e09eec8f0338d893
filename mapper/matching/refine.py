"""Refinement of a pose, and its covariance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.matching.kernels.likelihood_field import accumulate_field, refine_on_field
from mapper.matching.kernels.point_to_line import accumulate_scan, refine_pair, refine_pose
from mapper.matching.task import Task

FIELD_LEVELS = (4.0, 2.0, 1.0)  #: the widths of the fields, coarse to fine, in units of ``field_sigma``
NO_PRIOR = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Refined:
    """A refined pose (3,) and its least-squares problem there: each observation of a surface counts once.

    ``hessian`` (3, 3) is Σ w JᵀJ, ``cost`` Σ w e² and ``pairs`` the number of residuals. ``unit`` is what residuals
    are in: "m", or "" for those of a field.
    """

    pose: Float64Array
    hessian: Float64Array
    cost: float
    pairs: int
    iterations: int
    unit: str = "m"


def by_pairs(task: Task, pose: Float64Array) -> Refined:
    """Refine by pairs of points, both ways where the target is one scan."""
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
    """Return the pose as it is; its least-squares problem is that of point to line, or of the field of a map."""
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
