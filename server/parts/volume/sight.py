"""From where the sensor of a map in 3D looks."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.volume.scans.scan_sequence import ScanSequence
from server.sessions.drawings import Point
from server.sessions.scene_controls import Sight

LEAST_WAY_M = 0.1  #: between two places that say where a sensor is going


def sensor_sight(scans: ScanSequence, index: int) -> Sight | None:
    """Return from where the newest of the first ``index`` scans was taken, and in which direction.

    That is the direction of a depth image's optical axis. Of other scans it is not known: it is the direction in which
    the sensor had come there, or goes from there. None before the first scan, and where neither is known.
    """
    if index == 0:
        return None
    if scans.depth is not None:
        pose = scans.depth.poses[index - 1]
        return Sight(_point(pose[:3, 3]), _point(pose[:3, 2]))
    place = scans.origins[index - 1]
    directions = scans.origins - place
    far = np.flatnonzero(np.linalg.norm(directions, axis=1) >= LEAST_WAY_M)  # a place that is not known is not far: NaN
    before, after = far[far < index - 1], far[far >= index]
    if len(before):
        direction = -directions[before[-1]]
    elif len(after):
        direction = directions[after[0]]
    else:
        return None
    return Sight(_point(place), _point(direction / np.linalg.norm(direction)))


def _point(values: Float64Array) -> Point:
    return float(values[0]), float(values[1]), float(values[2])
