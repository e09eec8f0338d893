"""Alignment of one trajectory to another: by least squares, or by the first pose.

Source: Umeyama 1991, Least-squares estimation of transformation parameters between two point patterns, IEEE PAMI 13(4),
in the plane, where the rotation has a closed form (:mod:`mapper.evaluation.textbook` uses the paper's singular value
decomposition).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points, wrap_angle


@dataclass(frozen=True, slots=True)
class Alignment:
    """p ↦ ``scale`` · R(theta) · p + (x, y): metres, radians, for points and poses of the estimate."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0
    scale: float = 1.0

    def apply(self, poses: Float64Array) -> Float64Array:
        """Transform poses (n, 3) to the reference's frame: positions are scaled, rotated and translated, headings
        rotated.
        """
        points = transform_points((self.x, self.y, self.theta), self.scale * poses[:, :2])
        return np.column_stack([points, wrap_angle(poses[:, 2] + self.theta)])


def _none(_reference: Float64Array, _estimate: Float64Array) -> Alignment:
    return Alignment()


def _origin(reference: Float64Array, estimate: Float64Array) -> Alignment:
    x, y, theta = compose(reference[0], inverse(estimate[0]))
    return Alignment(float(x), float(y), float(theta))


def _rigid(reference: Float64Array, estimate: Float64Array) -> Alignment:
    return umeyama(reference[:, :2], estimate[:, :2])


def _scaled(reference: Float64Array, estimate: Float64Array) -> Alignment:
    return umeyama(reference[:, :2], estimate[:, :2], with_scale=True)


#: Alignment methods by name: none, by the first pose, by least squares, by least squares with a scale.
ALIGNMENTS: Mapping[str, Callable[[Float64Array, Float64Array], Alignment]] = {
    "none": _none,
    "origin": _origin,
    "rigid": _rigid,
    "scaled": _scaled,
}


def align(reference: Float64Array, estimate: Float64Array, how: str = "rigid") -> Alignment:
    """Return the alignment of the poses ``estimate`` (n, 3) to ``reference`` (n, 3), n ≥ 1; ``how`` of
    :data:`ALIGNMENTS`.

    Raises :class:`ConfigError` for another ``how``, for no poses, and the errors of :func:`umeyama`.
    """
    if how not in ALIGNMENTS:
        raise ConfigError("evaluation.align", f"The alignment must be one of {', '.join(ALIGNMENTS)}, not {how!r:.40}.")
    if not len(reference):
        raise ConfigError("evaluation.no_pairs", "There are no poses to align.")
    return ALIGNMENTS[how](reference, estimate)


def umeyama(reference_xy: Float64Array, estimate_xy: Float64Array, *, with_scale: bool = False) -> Alignment:
    """Return rotation, translation and optionally scale that minimise Σ |reference − (scale · R · estimate + t)|².

    Both are (n, 2), metres. Two distinct points on a line are enough. Raises :class:`ConfigError` if the rotation is
    undetermined: all points of one of them coincide, or they are mirror images of each other like those of a circle.
    """
    mean_r, mean_e = reference_xy.mean(axis=0), estimate_xy.mean(axis=0)
    r, e = reference_xy - mean_r, estimate_xy - mean_e
    along = float(np.sum(e * r))
    across = float(np.sum(e[:, 0] * r[:, 1] - e[:, 1] * r[:, 0]))
    spread = float(np.sum(e * e)), float(np.sum(r * r))
    magnitude = np.hypot(along, across)
    # Coordinates, and therefore their differences, are accurate to about 1e-16 of their magnitude.
    size = np.finfo(np.float64).eps * max(1.0, float(np.abs(reference_xy).max()), float(np.abs(estimate_xy).max()))
    if min(spread) <= len(e) * (16.0 * size) ** 2 or magnitude <= 1e-12 * np.sqrt(spread[0] * spread[1]):
        raise ConfigError(
            "evaluation.degenerate",
            "The trajectories cannot be aligned: their places leave the rotation undetermined, as when the robot "
            "stands still. Align by the first pose (origin), or not at all (none).",
        )
    theta = float(np.arctan2(across, along))
    scale = float(magnitude / spread[0]) if with_scale else 1.0
    x, y = mean_r - transform_points((0.0, 0.0, theta), scale * mean_e)
    return Alignment(float(x), float(y), theta, scale)
