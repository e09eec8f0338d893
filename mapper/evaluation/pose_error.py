"""Errors of poses: absolute, pose by pose, and relative, motion by motion.

Source: Sturm et al. 2012, A benchmark for the evaluation of RGB-D SLAM systems, IROS (absolute trajectory error,
relative pose error); evo's APE and RPE with the pose relations translation part and rotation angle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse, wrap_angle

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]


def absolute_errors(reference: Float64Array, estimate: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return translation (n,), metres, and rotation (n,), radians ≥ 0, of estimate⁻¹ ∘ reference, for poses (n, 3).

    The translation is the distance of the two places, in whatever frame.
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
