"""One scan of a log as it lies in the map: at the shifted time, its beams deskewed, seen from one pose."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import bearings, is_deskewed, sensor_poses_of_readings
from mapper.mapping.update_plan import UpdatePlan, plan_update
from mapper.sensors.joint_log import JointLog
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import RangeScan, ScanLog, SonarScan

Float64Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlacedScan:
    """A scan, and the poses (3,) that it is seen from: ``T_map_base`` and ``T_map_laser``.

    Neither pose includes the correction of the mount in the parameters. Of a deskewed scan each beam ends where it ends
    in the map: its ranges and bearings are those from the sensor's pose at the scan's stamp.
    """

    base_pose: Float64Array
    sensor_pose: Float64Array
    scan: RangeScan


def placed_scan(log: ScanLog, config: MappingConfig, trajectory: str | None, index: int) -> PlacedScan:
    """Return scan ``index`` as ``config`` has it in the map. Raises :class:`ConfigError` for an unknown trajectory."""
    if isinstance(log, JointLog):
        part = log.parts[int(log.part_of_scan[index])]
        return placed_scan(part, config, trajectory, int(log.scan_of_part[index]))
    plan = plan_update(config, log.range_min, log.range_max)
    scan, base = log.scan(index), base_pose(log, plan, trajectory, index)
    sensor = compose(base, log.mounts_at(index))
    if is_deskewed(log, plan, trajectory):
        ranges, angles = deskewed_beams(log, plan, trajectory, index)
        if plan.upside_down:
            angles = -angles
        scan = SonarScan(ranges, angles, scan.beam_width, scan.range_min, scan.range_max, scan.stamp_ns)
    return PlacedScan(base, sensor, scan)


def base_pose(log: ScanLog, plan: UpdatePlan, trajectory: str | None, index: int) -> Float64Array:
    """Return the robot's pose (3,) at the stamp of scan ``index``, shifted by the plan's time offset."""
    offset = log.trajectory(trajectory).offset_of_stamps(plan.time_offset)
    if offset == 0.0:
        return np.asarray(log.trajectory(trajectory).poses[index])
    return np.asarray(Motion.of(log, trajectory).at(seconds(log)[index : index + 1] + offset)[0])


def deskewed_beams(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, index: int
) -> tuple[NDArray[np.float32], Float64Array]:
    """Return range and bearing (n_beams,) of where the beams of scan ``index`` end, metres and radians.

    They are seen from where the sensor, mount corrected, was at the scan's stamp. Readings that are no number of metres
    stay as they are, in the direction in which the sensor looked then.
    """
    beams = np.arange(log.n_beams)
    poses = sensor_poses_of_readings(log, plan, trajectory, np.full(log.n_beams, index), beams)
    base = base_pose(log, plan, trajectory, index)
    here = compose(compose(base, log.mounts_at(index)), np.array(plan.mount))
    x, y, yaw = compose(inverse(here), poses).T
    readings, angles = log.ranges[index].astype(np.float64), yaw + bearings(log, plan)
    measured = np.isfinite(readings)
    reach = np.where(measured, readings, 0.0)
    x, y = x + reach * np.cos(angles), y + reach * np.sin(angles)
    ranges = np.where(measured, np.hypot(x, y), readings).astype(np.float32)
    return ranges, np.where(measured & (reach > 0.0), np.arctan2(y, x), angles)


def without_mount_correction(plan: UpdatePlan) -> UpdatePlan:
    """Return the plan for a sensor that is mounted as its log says."""
    return replace(plan, mount=(0.0, 0.0, 0.0), upside_down=False)
