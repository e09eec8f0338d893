"""Values that sessions, their parts and their readers exchange: poses, views, requests for a comparison."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.scan import RangeScan, ScanLog

Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LogView:
    """What a session shows of a log, enough for another session to show the same: the sensor and the trajectory, None
    for the usual ones, the values of the parameters, and how many scans are in the map.
    """

    topic: str | None = None
    trajectory: str | None = None
    values: dict[str, Any] | None = None
    index: int = 0


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to compare with: a map of ``log``, None being the session's own, with the poses of ``trajectory``.

    ``values`` are the parameters that it keeps; in all others it follows the session's.
    """

    values: dict[str, Any] = field(default_factory=dict)
    trajectory: str | None = None
    log: ScanLog | None = None
    log_id: str | None = None
    topic: str | None = None
    title: str = ""


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot and its newest scan.

    ``pose`` is T_map_base and ``sensor_pose`` T_map_laser now, ``scan_pose`` is T_map_laser at the scan. None of them
    includes the correction of the mount among the parameters, which the map composes onto them. ``believed_*`` are the
    same as the robot estimates them, None where the estimate is exact.
    """

    pose: Pose
    sensor_pose: Pose
    scan_pose: Pose
    scan: RangeScan
    stamp_s: float
    believed_pose: Pose | None = None
    believed_scan_pose: Pose | None = None


def as_pose(row: NDArray[np.float64]) -> Pose:
    """Return (3,) as a tuple of plain numbers."""
    x, y, yaw = (float(v) for v in row)
    return (x, y, yaw)
