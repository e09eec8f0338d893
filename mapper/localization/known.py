"""Scans at which the pose of a robot localised in a map is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def known_scans(converged: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return at which scans (n,) the pose is known; at those in ``converged`` (n,) the particles agree on one place.

    It is known there, and before the first of them, because it is propagated back along the odometry
    (:func:`mapper.localization.localize.carry_back`). While the robot is being relocalised, and if it is never
    localised, the estimate is an average of particles in several places.
    """
    known = converged.copy()
    converged_scans = np.flatnonzero(converged)
    known[: converged_scans[0] if len(converged_scans) else 0] = True
    return known
