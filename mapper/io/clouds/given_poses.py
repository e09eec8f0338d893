"""Sensor poses from a TUM file, for clouds that do not state where they were taken."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.tum_poses import FARTHEST_NS, poses_between
from mapper.io.trajectories.tum import tum_rows


@dataclass(frozen=True, slots=True)
class GivenPoses:
    """``T_map_sensor`` at stamps (n,), ns, in file order.

    ``values`` (n, 7) are x y z, metres, and the unit quaternion x y z w; ``name`` is the file's.
    """

    name: str
    stamps: NDArray[np.int64]
    values: NDArray[np.float64]

    @classmethod
    def read(cls, path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> GivenPoses:
        """Return the poses of a TUM file. Raises the errors of :func:`mapper.io.trajectories.tum.tum_rows`."""
        stamps, values, _ = tum_rows(Path(path), limits)
        return cls(Path(path).name, stamps, values)

    def __len__(self) -> int:
        return len(self.stamps)

    def matrix(self, number: int) -> Float64Array:
        """Return the pose with index ``number`` in the file as ``T_map_sensor`` (4, 4)."""
        row = slice(number, number + 1)
        return np.asarray(poses_between(self.stamps[row], self.values[row], self.stamps[row])[0])

    def at(self, frame_id: str, times_ns: Int64Array) -> Float64Array:
        """Return the poses (n, 4, 4) at stamps (n,), ns, for any frame; NaN if none is near.

        They are interpolated between two poses, like those of depth images.
        """
        del frame_id  # the file states the poses of the sensor itself
        stamps, first = np.unique(self.stamps, return_index=True)
        values = self.values[first]
        after = np.clip(np.searchsorted(stamps, times_ns), 0, len(stamps) - 1)
        before = np.maximum(after - 1, 0)
        gap = np.minimum(np.abs(times_ns - stamps[before]), np.abs(times_ns - stamps[after]))
        inside = (times_ns >= stamps[0]) & (times_ns <= stamps[-1]) & (gap <= FARTHEST_NS)
        poses = np.full((len(times_ns), 4, 4), np.nan)
        if inside.any():
            poses[inside] = poses_between(stamps, values, times_ns[inside])
        return poses
