"""Whether the scans beside a displacement confirm it: one may be aligned with somebody who stands before the lidar."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose
from mapper.diagnosis.events.displacement import Displacement
from mapper.diagnosis.events.motions import Motions
from mapper.sensors.scan import ScanLog

Float64Array = NDArray[np.float64]

SCANS = 8  #: before it and after it that are compared
REACH_M = 30.0  #: of the readings that are compared
FARTHEST_M = 0.3  #: from the nearest end of a beam before: what is farther was not seen then
MOST_BEAMS = 360  #: of each scan


def is_contradicted(log: ScanLog, motions: Motions, one: Displacement) -> bool:
    """Return whether what is seen after a displacement fits what was seen before it better without than with it.

    Of a robot that was displaced walls are double where the wheels have it; where only a scan was aligned wrongly, and
    those after it with that one, they are double where the scans have it. All readings of :data:`SCANS` scans on both
    sides count alike, so that somebody who covers many beams of some of them decides nothing.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few logs need

    first, last = max(0, one.before - SCANS), min(len(motions.scans) - 1, one.after + SCANS)
    back = _chained(motions.by_scans[first : one.before])
    seen = cKDTree(_ends(log, motions.scans[first : one.before + 1], back))
    forth = _chained(motions.by_scans[one.after : last])

    def apart(steps: Float64Array) -> float:
        """Return how far ends after the displacement are from those before it on average, metres."""
        begin = compose(back[-1], _chained(steps)[-1])
        ends = _ends(log, motions.scans[one.after : last + 1], compose(begin, forth))
        distances = seen.query(ends, distance_upper_bound=FARTHEST_M)[0]
        return float(np.minimum(distances, FARTHEST_M).mean()) if len(ends) else FARTHEST_M

    window = slice(one.before, one.after)
    return apart(motions.by_wheels[window]) < apart(motions.by_scans[window])


def _chained(steps: Float64Array) -> Float64Array:
    """Return the poses (n + 1, 3) to which n motions (n, 3) lead one after another, from zero on."""
    poses = np.zeros((len(steps) + 1, 3))
    for k, step in enumerate(steps):
        poses[k + 1] = compose(poses[k], step)
    return poses


def _ends(log: ScanLog, scans: NDArray[np.int64], poses: Float64Array) -> Float64Array:
    """Return where the measured beams of scans with the robot's ``poses`` (n, 3) end, (m, 2)."""
    ends = [np.zeros((0, 2))]
    for number, pose in zip(scans.tolist(), poses, strict=True):
        scan = log.scan(number)
        every = slice(None, None, 1 + len(scan.ranges) // MOST_BEAMS)
        ranges, angles = scan.ranges[every].astype(np.float64), scan.angles[every]
        with np.errstate(invalid="ignore"):
            measured = (ranges >= max(scan.range_min, 1e-3)) & (ranges <= min(scan.range_max, REACH_M))
        x, y, yaw = compose(pose, log.mount_of(number))
        bearings = angles[measured] + yaw
        along = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
        ends.append((x, y) + ranges[measured, np.newaxis] * along)
    return np.concatenate(ends)
