"""Observations of the obstacle layers from a planar scan: the end points of its beams."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.costmap.layers import Observation
from mapper.sensors.scan import RangeScan

_SHORT_OF_RANGE_MAX = 1e-4  #: metres, as Nav2 shortens a beam without return


def observation_of_scan(
    scan: RangeScan,
    sensor_pose: Sequence[float] | Float64Array,
    *,
    inf_is_valid: bool = False,
    height: float = 0.0,
    stamp: float | None = None,
) -> Observation:
    """Return the end points of a scan by a sensor at ``sensor_pose`` (x, y, yaw) in the map, ``height`` m up.

    With ``inf_is_valid`` a beam without return ends at the scan's greatest range, otherwise it is left out, as are
    readings that are invalid. ``stamp`` in seconds is that of the scan unless given. Source: nav2_costmap_2d,
    obstacle_layer.cpp, laserScanValidInfCallback.
    """
    x, y, yaw = (float(v) for v in sensor_pose)
    ranges = scan.ranges.astype(np.float64)
    if inf_is_valid:
        ranges = np.where(np.isposinf(ranges), scan.range_max - _SHORT_OF_RANGE_MAX, ranges)
    valid = (ranges >= scan.range_min) & (ranges <= scan.range_max)
    ranges, angles = ranges[valid], scan.angles[valid] + yaw
    points = np.column_stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles), np.full(len(ranges), height)])
    return Observation(np.array([x, y, height]), points, scan.stamp_ns * 1e-9 if stamp is None else stamp)
