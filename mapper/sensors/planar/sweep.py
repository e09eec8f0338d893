"""The times at which the beams of a scan that is cut out of a cloud were measured, by those of the cloud's points."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.sensors.planar.cloud import Placement, first_beam
from mapper.sensors.planar.options import PlanarCut

SAMPLE = 4096  #: points of a cloud that are looked at
SECTORS, LEAST_SECTORS, LEAST_POINTS = 24, 8, 3  #: into which they are sorted, and of which and in which there must be
EVEN = 0.05  #: of the sweep, by which the usual time of a sector may differ from a line over the bearing
MOST_OFF, MOST_STRAY = 0.1, 0.1  #: of the sweep, by which a point may differ, and the share of those that differ more


def sweep_of(
    points: Float64Array, times: Float64Array, placement: Placement, cut: PlanarCut
) -> tuple[float, float] | None:
    """Return when the first beam of a cut was measured, seconds after the stamp, and the time from one to the next.

    ``points`` (n, 3) are metres in the cloud's frame, ``times`` (n,) seconds after its stamp. None where the times do
    not go evenly with the bearing: of a lidar that looks everywhere at once or begins its turn elsewhere than the cut.
    """
    x, y, _ = placement.rotation @ points.T
    bearings = np.arctan2(y, x)
    known = np.isfinite(bearings) & np.isfinite(times) & (bearings >= cut.angle_min) & (bearings <= cut.angle_max)
    bearings, times = bearings[known], times[known]
    view = cut.angle_max - cut.angle_min
    sector = np.minimum((bearings - cut.angle_min) / view * SECTORS, SECTORS - 1).astype(np.int64)
    usual = np.array(
        [
            (np.median(bearings[sector == k]), np.median(times[sector == k]))
            for k in range(SECTORS)
            if np.count_nonzero(sector == k) >= LEAST_POINTS
        ]
    )
    if len(usual) < LEAST_SECTORS:
        return None
    slope, at_zero = np.polyfit(usual[:, 0], usual[:, 1], 1)
    sweep = abs(slope) * view
    off = np.abs(times - at_zero - slope * bearings)
    if not sweep > 0.0 or np.abs(usual[:, 1] - at_zero - slope * usual[:, 0]).max() > EVEN * sweep:
        return None
    if np.mean(off > MOST_OFF * sweep) > MOST_STRAY:
        return None
    return float(at_zero + slope * first_beam(cut)), float(slope * cut.angle_increment)
