"""Differences between two maps of one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.core.errors import ConfigError
from mapper.volume.occupancy.volume import OccupancyVolume


@dataclass(frozen=True, slots=True)
class Changes:
    """Keys (n, 3) of the voxels that are known in both maps and changed their state, and counts of the others.

    ``appeared`` are occupied in the second map only, ``vanished`` in the first only. ``same`` is the number of voxels
    with equal states in both, ``only_first`` and ``only_second`` the numbers of voxels known in one map only.
    """

    appeared: Int64Array
    vanished: Int64Array
    same: int
    only_first: int
    only_second: int


def changes_between(first: OccupancyVolume, second: OccupancyVolume) -> Changes:
    """Compare two maps. Raises :class:`ConfigError` if their voxel sizes differ."""
    if first.config.resolution != second.config.resolution:
        raise ConfigError(
            "volume.resolutions",
            f"Maps can be compared where their voxels are of one size, not {first.config.resolution:g} and "
            f"{second.config.resolution:g} m.",
        )
    _, slots, others = np.intersect1d(first.blocks.codes, second.blocks.codes, return_indices=True)
    before, after = first.values_of(slots), second.values_of(others)
    known = ~np.isnan(before) & ~np.isnan(after)
    was, is_now = before >= first.config.log_odds_occupied, after >= second.config.log_odds_occupied
    corners = first.blocks.corners[slots]

    def keys(states: np.ndarray) -> Int64Array:
        block, z, y, x = np.nonzero(states)
        return corners[block] + np.stack([x, y, z], axis=1)

    both = int(known.sum())
    changed = known & (was != is_now)
    return Changes(
        keys(changed & is_now),
        keys(changed & was),
        both - int(changed.sum()),
        first.n_known - both,
        second.n_known - both,
    )
