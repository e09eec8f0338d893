"""Scans of a sensor or of a log as a batch: mount corrected, fields computed, "no return" replaced for "hit"."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.update_plan import UpdatePlan
from mapper.sensors.scan import RangeScan, ScanLog, cones


def scan_batch_of_log(log: ScanLog, plan: UpdatePlan, trajectory: str | None, start: int, stop: int) -> ScanBatch:
    """Return the scans [start, stop) of a log with the poses of one of its trajectories and the corrected mount."""
    poses = log.trajectory(trajectory).poses[start:stop]
    return _batch(log, log.ranges[start:stop], compose(poses, np.array(log.mount)), plan)


def scan_batch_of_scan(scan: RangeScan, sensor_pose: NDArray[np.float64], plan: UpdatePlan) -> ScanBatch:
    """Return one scan, taken at ``sensor_pose`` (3,), ``T_map_laser``, with the corrected mount."""
    return _batch(scan, scan.ranges[np.newaxis], sensor_pose[np.newaxis], plan)


def _batch(
    sensor: RangeScan | ScanLog, ranges: NDArray[np.float32], poses: NDArray[np.float64], plan: UpdatePlan
) -> ScanBatch:
    angles = -sensor.angles if plan.upside_down else sensor.angles
    if plan.strategy.cone and not plan.per_scan:
        fields = cones(angles, plan.cone.opening)
    else:
        widest = plan.cone.opening / 2.0 if plan.strategy.cone else np.pi / 4.0
        fields = sensor.fields(widest, turned_over=plan.upside_down)
    range_min, range_max = plan.reading_filter.range_min, plan.reading_filter.range_max
    if plan.no_return_is_hit:
        # NumPy compares a float32 with a Python float as two float32, hence the float().
        greatest = np.float32(range_max)
        if float(greatest) > range_max:
            greatest = np.nextafter(greatest, np.float32(0.0))
        ranges = np.where(ranges > greatest, greatest, ranges)
    return ScanBatch(ranges, compose(poses, np.array(plan.mount)), angles, fields, range_min, range_max)
