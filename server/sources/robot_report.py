"""The fields of the ``frame`` message about a robot and its newest scan."""

from __future__ import annotations

from typing import Any

from mapper.mapping.parameters import MappingConfig
from server.sessions.messages import frame_fields, scan_fields
from server.sessions.view import RobotState


class RobotReport:
    """The fields of ``frame`` about a robot. Those of a scan are computed once for each scan."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._scan: dict[str, Any] = {}

    def frame(self, robot: RobotState) -> dict[str, Any]:
        """Return the fields of the robot's pose."""
        return frame_fields(robot)

    def scan(self, robot: RobotState, config: MappingConfig) -> dict[str, Any]:
        """Return the fields of the newest scan: the same object until there is a newer scan."""
        key = (robot.scan, robot.scan_pose, robot.believed_scan_pose, config.range_max)
        if not self._key or self._key[0] is not robot.scan or self._key[1:] != key[1:]:
            self._key, self._scan = key, scan_fields(robot, config)
        return self._scan
