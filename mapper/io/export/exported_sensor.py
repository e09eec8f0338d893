"""A planar sensor as it is exported: the names of its topics and of its frame, and where its beams end."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.mapping.parameters import MappingConfig
from mapper.mapping.placed_scan import deskewed_beams, without_mount_correction
from mapper.mapping.prepare_scans import base_poses, is_deskewed
from mapper.mapping.update_plan import UpdatePlan, plan_update
from mapper.sensors.joint_log import JointLog, by_sensor
from mapper.sensors.scan import ScanLog

_NO_PART_OF_A_NAME = re.compile(r"[^A-Za-z0-9_/]")


@dataclass(frozen=True, slots=True)
class ExportedSensor:
    """One planar sensor: ``poses`` (n_scans, 3) are ``T_map_base`` at its scans.

    ``scan`` and ``points`` name the topics of a lidar, ``sonars`` and ``sonar_frames`` (n_beams,) the topics and frames
    of sonars. ``plan`` is that of the map, None where no beams are deskewed; ``rays`` (n_beams, 2) are the directions
    of the beams in the sensor's frame.
    """

    log: ScanLog
    poses: NDArray[np.float64]
    plan: UpdatePlan | None
    trajectory: str | None
    frame: str
    scan: str
    points: str
    sonars: tuple[str, ...]
    sonar_frames: tuple[str, ...]
    rays: NDArray[np.float64]

    def moves_on(self, base: str) -> bool:
        """Return whether the sensor moves on the robot, whose frame is ``base``."""
        return self.log.mounts is not None and self.frame != base

    def ends(self, index: int) -> NDArray[np.float64]:
        """Return where the beams of a scan end (n_beams, 2), metres in the sensor's frame at the scan's stamp.

        That is the sensor's place for readings that are no distance.
        """
        ranges, rays = self.log.ranges[index], self.rays
        if self.plan is not None:
            ranges, bearings = deskewed_beams(self.log, self.plan, self.trajectory, index)
            sign = -1.0 if self.log.upside_down else 1.0
            rays = np.stack([np.cos(bearings), sign * np.sin(bearings)], axis=1)
        return np.asarray(np.where(np.isfinite(ranges), ranges, 0.0)[:, None] * rays)


def exported_sensors(
    log: ScanLog, trajectory: str | None, config: MappingConfig | None, taken: Collection[str]
) -> list[ExportedSensor]:
    """Return the sensors of a log with names of their own.

    One sensor's topics are ``/scan`` and ``/points``, or ``/sonar_0`` …; those of several are named as they were in the
    recording, apart from what is not allowed in a name and from the names that are ``taken``. The parts of one lidar
    that was switched, which are in the log's order, share its names. ``config`` is that of the map in which the scans
    are to lie, if there is one.
    """
    if not isinstance(log, JointLog):
        names = [f"/sonar_{i}" for i in range(log.n_beams)]
        return [_sensor(log, trajectory, config, log.frame_id, "/scan", "/points", names)]
    sensors, topics, frames = by_sensor(log), set(taken), set[str]()
    found: dict[int, ExportedSensor] = {}
    for number, (sensor, scans) in enumerate(sensors):
        plain = _NO_PART_OF_A_NAME.sub("_", sensor.topic).strip("/") or f"scan_{number}"
        topic = _unused(f"/{plain}", number, topics) if len(sensors) > 1 else "/scan"
        frame = _unused(sensor.frame_id, number, frames)
        points = _unused(f"{topic}/points", number, topics) if len(sensors) > 1 else "/points"
        for index in np.unique(log.part_of_scan[scans]).tolist():  # of a lidar that was switched
            part = log.parts[index]
            sonars = [f"{topic}_{i}" for i in range(part.n_beams)] if part.n_beams > 1 else [topic]
            found[index] = _sensor(part, trajectory, config, frame, topic, points, sonars)
    return [found[index] for index in range(len(log.parts)) if index in found]


def _unused(name: str, number: int, used: set[str]) -> str:
    """Return a name that is not ``used`` yet, and add it to those."""
    while name in used:
        name = f"{name}_{number}"
    used.add(name)
    return name


def _sensor(
    log: ScanLog,
    trajectory: str | None,
    config: MappingConfig | None,
    frame: str,
    scan: str,
    points: str,
    sonars: Sequence[str],
) -> ExportedSensor:
    poses, plan = log.trajectory(trajectory).poses, None
    if config is not None:  # scans lie where they lie in that map
        plan = without_mount_correction(plan_update(config, log.range_min, log.range_max))
        poses = base_poses(log, plan, trajectory)
        plan = plan if is_deskewed(log, plan, trajectory) else None
    of_sonars: tuple[str, ...] = ()
    if log.bearings is not None:
        own = [name.rsplit("/", 1)[-1] for name in sonars]
        of_sonars = tuple(own) if log.n_beams > 1 else (frame,)
    angles = log.angle_min + log.angle_increment * np.arange(log.n_beams)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return ExportedSensor(log, poses, plan, trajectory, frame, scan, points, tuple(sonars), of_sonars, rays)
