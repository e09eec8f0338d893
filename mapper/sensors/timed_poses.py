"""Poses with their own stamps: a trajectory from another program, or the odometry messages of a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import check_poses, interpolate
from mapper.sensors.georeference import NO_OFFSET, Offset

Times = NDArray[np.int64] | NDArray[np.float64]


def poses_at(times: Times, poses: NDArray[np.float64], at: Times) -> NDArray[np.float64]:
    """Interpolate n ≥ 1 ``poses`` (n, 3) at ``times`` (n,) to the times ``at`` (...); return (..., 3).

    The times ascend, and both use one unit. Positions are interpolated linearly, angles along the shorter arc. There is
    no extrapolation: before the first and after the last pose it is that pose.
    """
    return poses_between(times, poses, number_before(times, at), at)


def number_before(times: Times, at: Times) -> NDArray[np.int64]:
    """Return the index of the last of ``times`` (n,), ascending, at or before each of ``at``; 0 before all."""
    return np.clip(np.searchsorted(times, at, side="right") - 1, 0, None)


def poses_between(times: Times, poses: NDArray[np.float64], low: NDArray[np.int64], at: Times) -> NDArray[np.float64]:
    """Interpolate (..., 3) at ``at`` between the poses with index ``low`` and the next ones; the two broadcast."""
    high = np.minimum(low + 1, len(times) - 1)
    start, span = times[low], times[high] - times[low]
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(span > 0, np.clip((at - start) / span, 0.0, 1.0), 0.0)
    return interpolate(poses[low], poses[high], weight)


@dataclass(frozen=True, slots=True)
class TimedPoses:
    """Poses of one body in one fixed frame, in the order of their file.

    ``stamps_ns`` (n,) int64, as recorded (they may jump backwards); ``poses`` (n, 3) float64, ``T_frame_child``, metres
    and radians, minus an ``offset`` (x, y) if georeferenced; ``notes`` are the reader's remarks, one sentence each.
    Raises :class:`ConfigError` for arrays of other shapes and for poses that are not finite.
    """

    stamps_ns: NDArray[np.int64]
    poses: NDArray[np.float64]
    notes: tuple[str, ...] = ()
    offset: Offset = NO_OFFSET

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
        return TimedPoses(self.stamps_ns[indices], self.poses[indices], self.notes, self.offset)

    def covers(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of the times (n,) are between the earliest and the latest stamp, inclusive."""
        if not len(self):
            return np.zeros(len(stamps_ns), dtype=np.bool_)
        return np.asarray((stamps_ns >= self.stamps_ns.min()) & (stamps_ns <= self.stamps_ns.max()))

    def at(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the poses (n, 3) at the times (n,), ns, like :func:`poses_at`.

        Raises :class:`ConfigError` if there are no poses.
        """
        if not len(self):
            raise ConfigError("poses.empty", "There are no poses to interpolate.")
        ordered = self.in_order()
        return poses_at(ordered.stamps_ns, ordered.poses, stamps_ns)

    def in_order(self) -> TimedPoses:
        """Return the poses in the order of their stamps."""
        if (self.stamps_ns[1:] >= self.stamps_ns[:-1]).all():
            return self
        return self.take(np.argsort(self.stamps_ns, kind="stable"))


@dataclass(frozen=True, slots=True)
class OdometryRecords:
    """The odometry messages of a log in record order, and the positions of the scans among them.

    ``messages`` are the n messages; ``before_scan`` (n_scans,) int64 is the index of the last message before each scan,
    −1 if there is none. ``at_scans`` (n_scans, 3) float64 is the odometry pose at each scan, ``T_odom_base``: from the
    scan's own record in logs that have it (CARMEN), otherwise interpolated at the scan's stamp. None if unknown. Raises
    :class:`ConfigError` for an index without a message.
    """

    messages: TimedPoses
    before_scan: NDArray[np.int64]
    at_scans: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "before_scan", np.ascontiguousarray(self.before_scan, dtype=np.int64))
        outside = (self.before_scan < -1) | (self.before_scan >= len(self.messages))
        if self.before_scan.ndim != 1 or outside.any():
            raise ConfigError("poses.records", "The indices before the scans must be those of messages, or −1.")
        if self.at_scans is not None:
            object.__setattr__(self, "at_scans", np.ascontiguousarray(self.at_scans, dtype=np.float64))
            check_poses(self.at_scans, (len(self.before_scan), 3))

    def take(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice) -> OdometryRecords:
        """Return all messages, with some of the scans."""
        at_scans = None if self.at_scans is None else self.at_scans[scans]
        return OdometryRecords(self.messages, self.before_scan[scans], at_scans)
