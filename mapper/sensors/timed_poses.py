"""Poses with stamps that are no log's scans: a trajectory from another program, the odometry messages of a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import interpolate
from mapper.sensors.scan import check_poses


@dataclass(frozen=True, slots=True)
class TimedPoses:
    """Poses of one body in one fixed frame, in the order of the file that they come from.

    ``stamps_ns`` (n,) int64, as recorded (they may jump backwards); ``poses`` (n, 3) float64, ``T_frame_child``,
    metres and radians; ``notes`` one sentence each on what the reader noticed. Raises :class:`ConfigError` for arrays
    of other shapes and for poses that are not finite.
    """

    stamps_ns: NDArray[np.int64]
    poses: NDArray[np.float64]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamps_ns", np.ascontiguousarray(self.stamps_ns, dtype=np.int64))
        object.__setattr__(self, "poses", np.ascontiguousarray(self.poses, dtype=np.float64))
        if self.stamps_ns.ndim != 1:
            raise ConfigError("poses.stamps", f"Stamps are one row, not an array of shape {self.stamps_ns.shape}.")
        check_poses(self.poses, (len(self.stamps_ns), 3))

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def take(self, indices: NDArray[np.int64]) -> TimedPoses:
        """Return the poses with these indices, in this order."""
        return TimedPoses(self.stamps_ns[indices], self.poses[indices], self.notes)

    def covers(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of the times (n,) lie between the earliest and the latest stamp, both included."""
        if not len(self):
            return np.zeros(len(stamps_ns), dtype=np.bool_)
        return np.asarray((stamps_ns >= self.stamps_ns.min()) & (stamps_ns <= self.stamps_ns.max()))

    def at(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the poses (n, 3) at the times (n,), ns.

        Linear in position, the short way round in angle, between the two poses around a time in the order of the
        stamps. Nothing is extrapolated: outside of them it is the nearest pose. Raises :class:`ConfigError` where there
        is no pose.
        """
        if not len(self):
            raise ConfigError("poses.empty", "There are no poses to interpolate.")
        order = np.argsort(self.stamps_ns, kind="stable")
        stamps, poses = self.stamps_ns[order], self.poses[order]
        after = np.searchsorted(stamps, stamps_ns, side="right")
        low, high = np.clip(after - 1, 0, len(stamps) - 1), np.clip(after, 0, len(stamps) - 1)
        span = stamps[high] - stamps[low]
        weight = np.clip((stamps_ns - stamps[low]) / np.where(span > 0, span, 1), 0.0, 1.0)
        return interpolate(poses[low], poses[high], np.where(span > 0, weight, 0.0))


@dataclass(frozen=True, slots=True)
class OdometryRecords:
    """The odometry messages of a log in the order of its records, and where the scans stand among them.

    ``messages`` are the n messages; ``before_scan`` (n_scans,) int64 is the index of the last message before each scan,
    −1 where there is none. Raises :class:`ConfigError` for an index of no message.
    """

    messages: TimedPoses
    before_scan: NDArray[np.int64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "before_scan", np.ascontiguousarray(self.before_scan, dtype=np.int64))
        outside = (self.before_scan < -1) | (self.before_scan >= len(self.messages))
        if self.before_scan.ndim != 1 or outside.any():
            raise ConfigError("poses.records", "The indices before the scans must be those of messages, or −1.")
