"""The fields of the ``frame`` message about a robot's newest scan."""

from __future__ import annotations

from typing import Any

from mapper.mapping.parameters import MappingConfig
from server.sessions.messages import NO_READINGS, scan_of
from server.sessions.view import RobotState
from server.stream.messages import ScanFields


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
