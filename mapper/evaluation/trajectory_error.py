"""Comparison of two trajectories: association by stamps, alignment, and absolute and relative errors, as in evo.

The definitions are those of evo_ape and evo_rpe (github.com/MichaelGrupp/evo) in the plane. Source: Sturm et al. 2012,
A benchmark for the evaluation of RGB-D SLAM systems, IROS (absolute trajectory error, relative pose error).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.evaluation.alignment import Alignment, align
from mapper.evaluation.association import MAX_DIFFERENCE_S, associate
from mapper.evaluation.pairs import TOLERANCE, pairs_over
from mapper.evaluation.statistics import ErrorSeries
from mapper.sensors.timed_poses import TimedPoses


def absolute_errors(reference: Float64Array, estimate: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return translation (n,), metres, and rotation (n,), radians ≥ 0, of estimate⁻¹ ∘ reference, for poses (n, 3).

    The translation is the distance between the two positions, which does not depend on the frame.
    """
    off = estimate - reference
    return np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))


def relative_errors(
    reference: Float64Array, estimate: Float64Array, pairs: Int64Array
) -> tuple[Float64Array, Float64Array]:
    """Return translation (k,), metres, and rotation (k,), radians ≥ 0, of (Qᵢ⁻¹ Qⱼ)⁻¹ ∘ (Pᵢ⁻¹ Pⱼ) for ``pairs`` (k, 2).

    Q are the poses of the reference (n, 3), P those of the estimate (n, 3).
    """
    return magnitudes(compose(inverse(_motions(reference, pairs)), _motions(estimate, pairs)))


def magnitudes(errors: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the lengths (n,), metres, and the angles (n,), radians ≥ 0, of rigid motions (n, 3)."""
    return np.hypot(errors[:, 0], errors[:, 1]), np.abs(errors[:, 2])


def _motions(poses: Float64Array, pairs: Int64Array) -> Float64Array:
    return compose(inverse(poses[pairs[:, 0]]), poses[pairs[:, 1]])


@dataclass(frozen=True, slots=True)
class ComparisonOptions:
    """Options of the comparison of two trajectories.

    ``max_difference_s`` and ``offset_s``: :func:`mapper.evaluation.associate`; ``align``:
    :data:`mapper.evaluation.ALIGNMENTS`; ``delta``, ``delta_unit``, ``all_pairs`` and ``tolerance``:
    :func:`mapper.evaluation.pairs_over`, along the estimate, or along the reference with ``pairs_from_reference``.
    """

    max_difference_s: float = MAX_DIFFERENCE_S
    offset_s: float = 0.0
    align: str = "rigid"
    delta: float = 1.0
    delta_unit: str = "m"
    all_pairs: bool = False
    tolerance: float = TOLERANCE
    pairs_from_reference: bool = False


@dataclass(frozen=True, slots=True)
class Comparison:
    """Result of a comparison. Translations are metres, rotations radians, all ≥ 0.

    ``reference`` and ``estimate`` are the n matching poses, with the estimate aligned by ``alignment``.
    ``absolute_translation`` and ``absolute_rotation`` are errors at each pose (n,), over the estimate's stamps;
    ``relative_translation`` and ``relative_rotation`` those over each pair, at the stamp of its end.
    """

    reference: TimedPoses
    estimate: TimedPoses
    alignment: Alignment
    absolute_translation: ErrorSeries
    absolute_rotation: ErrorSeries
    relative_translation: ErrorSeries
    relative_rotation: ErrorSeries


def compare_trajectories(
    reference: TimedPoses, estimate: TimedPoses, options: ComparisonOptions | None = None
) -> Comparison:
    """Return the errors of ``estimate`` against ``reference``, over time (:class:`ErrorSeries`) and as statistics.

    Raises :class:`ConfigError` if no stamps match, the positions cannot be aligned, no two poses are delta apart, or an
    option is impossible.
    """
    how = ComparisonOptions() if options is None else options
    together = associate(reference.stamps_ns, estimate.stamps_ns, how.max_difference_s, how.offset_s)
    reference, estimate = reference.take(together[:, 0]), estimate.take(together[:, 1])
    alignment = align(reference.poses, estimate.poses, how.align)
    estimate = TimedPoses(estimate.stamps_ns, alignment.apply(estimate.poses), estimate.notes)
    along = reference if how.pairs_from_reference else estimate
    pairs = pairs_over(
        how.delta, how.delta_unit, along.poses, along.stamps_ns, all_pairs=how.all_pairs, tolerance=how.tolerance
    )
    absolute = absolute_errors(reference.poses, estimate.poses)
    relative = relative_errors(reference.poses, estimate.poses, pairs)
    ends = estimate.stamps_ns[pairs[:, 1]]
    return Comparison(
        reference,
        estimate,
        alignment,
        ErrorSeries(estimate.stamps_ns, absolute[0]),
        ErrorSeries(estimate.stamps_ns, absolute[1]),
        ErrorSeries(ends, relative[0]),
        ErrorSeries(ends, relative[1]),
    )
