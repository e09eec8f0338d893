"""The robot and its newest scan as the ``frame`` message has them."""

from __future__ import annotations

from typing import Any

from mapper.mapping.parameters import MappingConfig
from server.sessions.messages import frame_fields, scan_fields
from server.sessions.view import RobotState


class RobotReport:
    """The fields of ``frame`` about a robot. Those of a scan are made once for each scan."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._scan: dict[str, Any] = {}

    def frame(self, robot: RobotState) -> dict[str, Any]:
        """Return where the robot is."""
        return frame_fields(robot)

    def scan(self, robot: RobotState, config: MappingConfig) -> dict[str, Any]:
        """Return what the robot sees: the same object while that is the same."""
        key = (robot.scan, robot.scan_pose, robot.believed_scan_pose, config.range_max)
        if not self._key or self._key[0] is not robot.scan or self._key[1:] != key[1:]:
            self._key, self._scan = key, scan_fields(robot, config)
        return self._scan
