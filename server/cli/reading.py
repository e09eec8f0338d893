"""Reading the logs that commands use."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mapper.io.logs import open_log, open_robot_log
from mapper.io.logs.selection import Selection
from mapper.io.trajectories import read_tum, with_trajectory
from mapper.mapping.parameters import MappingConfig, as_mapped
from mapper.sensors.joint_log import JointLog, by_sensor
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.cli.common import fail, progress_bar, refusing


def read_log(path: Path, topic: str | None = None, tum: Path | None = None, tf: str | None = None) -> ScanLog:
    """Return the log at ``path``, with the trajectory of ``tum``, or end the command with an error.

    ``tf`` is the topic of the transforms to use.
    """
    with refusing(path), progress_bar("Reading") as progress:
        log = open_log(path, topic=topic, tf=tf, progress=progress)
    return with_tum(log, tum)


def read_sensors(
    path: Path, topics: Sequence[str], tum: Path | None, cut: PlanarCut, tf: str | None = None
) -> tuple[ScanLog, ...]:
    """Return the named sensors of a log; by default, those that make one map. See :func:`read_log`.

    ``cut`` has the options for cutting scans out of clouds and depth images, and ``tf`` is the topic of the transforms.
    """
    with refusing(path), progress_bar("Reading") as progress:
        robot = open_robot_log(path, selection=Selection(tuple(topics), cut, tf), progress=progress)
    return tuple(with_tum(log, tum) for log in robot.sensors.values())


def read_joint(path: Path, topics: Sequence[str], tum: Path | None = None, tf: str | None = None) -> ScanLog:
    """Return the sensors that :func:`read_sensors` returns as one log."""
    logs = read_sensors(path, list(dict.fromkeys(topics)), tum, PlanarCut(), tf)
    with refusing(path):
        return logs[0] if len(logs) == 1 else JointLog.of(logs)


def with_corrections(path: Path, log: ScanLog, mapping: MappingConfig) -> ScanLog:
    """Return the log with the same correction of its mount and clock as its map with these parameters.

    Ends the command if the mounts of several sensors would be corrected.
    """
    check_mount(len(by_sensor(log)), mapping)
    with refusing(path):
        return as_mapped(log, mapping)


def check_mount(n_sensors: int, mapping: MappingConfig) -> None:
    """End the command if a correction of the mount was given for several sensors."""
    if n_sensors > 1 and (any(mapping.mount) or mapping.mount_upside_down):
        fail("A correction of the mount is for one sensor; give one --topic with it.")


def with_tum(log: ScanLog, tum: Path | None) -> ScanLog:
    """Return the log with the trajectory of a TUM file, if one is given, or end the command with an error."""
    if tum is None:
        return log

    with refusing(tum):
        return with_trajectory(log, read_tum(tum))
