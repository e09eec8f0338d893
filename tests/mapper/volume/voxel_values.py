"""The values of the voxels that hold some points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float32Array
from mapper.volume.occupancy.volume import OccupancyVolume, keys_of


def log_odds_at(volume: OccupancyVolume, points: ArrayLike) -> Float32Array:
    """Return the log-odds (n,) of the voxels that hold points (n, 3), NaN where unknown or outside the lattice."""
    keys, inside = keys_of(np.asarray(points, dtype=np.float32), volume.config.resolution)
    return volume.log_odds_of(np.where(inside[:, None], keys, 0), inside)
