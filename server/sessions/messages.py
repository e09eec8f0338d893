"""The messages that a session sends, as :mod:`server.stream.protocol` describes them."""

from __future__ import annotations

from typing import Any, cast

import msgspec
import numpy as np
from msgspec import UNSET

from mapper.core.kernels.decimals import MOST_BYTES, TOO_LARGE, write_thousandths
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import RangeScan, SonarScan
from server.sessions.view import Pose, RobotState
from server.stream.messages import FrameMessage, ScanFields, WorkingMessage

#: No reading: pages wait for a first scan.
NO_READINGS = ScanFields(scan_pose=(0.0, 0.0, 0.0), ranges=[], angle_min=0.0, angle_increment=0.0, range_max=0.0)


def working_message(elapsed_s: float | None = None, fraction: float | None = None, what: str = "map") -> WorkingMessage:
    """Return a ``working`` message; without a time the computation has ended."""
    return WorkingMessage(
        elapsed_s=None if elapsed_s is None else round(elapsed_s, 2),
        fraction=None if fraction is None else round(fraction, 3),
        what=what,
    )


def set_robot(frame: FrameMessage, robot_state: RobotState) -> None:
    """Set the fields of a ``frame`` message about the robot's pose."""
    frame.stamp = round(robot_state.stamp_s, 4)
    frame.pose = _rounded(robot_state.pose)
    frame.sensor_pose = _rounded(robot_state.sensor_pose)
    if robot_state.believed_pose is not None:
        frame.believed_pose = _rounded(robot_state.believed_pose)


def scan_of(robot_state: RobotState, config: MappingConfig) -> ScanFields:
    """Return the fields of a ``frame`` message about the robot's scan."""
    scan, believed = robot_state.scan, robot_state.believed_scan_pose
    return ScanFields(
        scan_pose=_rounded(robot_state.scan_pose),
        believed_scan_pose=UNSET if believed is None else _rounded(believed),
        ranges=_ranges(scan),
        angle_min=0.0 if isinstance(scan, SonarScan) else scan.angle_min,
        angle_increment=0.0 if isinstance(scan, SonarScan) else scan.angle_increment,
        bearings=np.round(scan.bearings, 5).tolist() if isinstance(scan, SonarScan) else UNSET,
        beam_width=scan.beam_width if scan.beam_width > 0.0 else UNSET,
        range_max=min(scan.range_max, config.range_max),
    )


class ScanReport:
    """The fields of ``frame`` about a scan, computed once for each scan."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._scan = NO_READINGS

    def scan(self, robot: RobotState, config: MappingConfig) -> ScanFields:
        """Return the fields of the newest scan: the same object until there is a newer scan."""
        key = (robot.scan, robot.scan_pose, robot.believed_scan_pose, config.range_max)
        if not self._key or self._key[0] is not robot.scan or self._key[1:] != key[1:]:
            self._key, self._scan = key, scan_of(robot, config)
        return self._scan


def _rounded(pose: Pose) -> Pose:
    x, y, yaw = (round(value, 4) for value in pose)
    return (x, y, yaw)


def _ranges(scan: RangeScan) -> list[float | None]:
    """Return :func:`readings` as JSON, which the encoder copies, where none is too large for that."""
    text = np.empty(2 + MOST_BYTES * len(scan.ranges), dtype=np.uint8)
    low, high = (float(np.float32(limit)) for limit in (scan.range_min, scan.range_max))  # as NumPy compares them
    size = write_thousandths(scan.ranges, low, high, text)
    return readings(scan) if size == TOO_LARGE else cast("list[float | None]", msgspec.Raw(text[:size].tobytes()))


def readings(scan: RangeScan) -> list[float | None]:
    """Return the scan's readings in metres, rounded, None for no return and for an invalid reading."""
    ranges = scan.ranges
    measured = (ranges >= scan.range_min) & (ranges <= scan.range_max) & np.isfinite(ranges)
    rounded: list[float | None] = np.round(ranges.astype(np.float64), 3).tolist()
    for i in np.flatnonzero(~measured).tolist():
        rounded[i] = None
    return rounded
