"""Position and viewing direction of a 3D map's sensor."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.volume.scans.scan_sequence import ScanSequence
from server.sessions.drawings import Point
from server.sessions.scene_controls import Sight

LEAST_WAY_M = 0.1  #: least distance between two places that determines a direction of motion


def sensor_sight(scans: ScanSequence, index: int) -> Sight | None:
    """Return the place of the newest of the first ``index`` scans, and the sensor's viewing direction there.

    For depth images this is the direction of the optical axis. For other scans it is unknown, so the direction of
    motion towards the place, or away from it, is used. Returns None before the first scan, and if neither is known.
    """
    if index == 0:
        return None
    if scans.depth is not None:
        pose = scans.depth.poses[index - 1]
        return Sight(_point(pose[:3, 3]), _point(pose[:3, 2]))
    place = scans.origins[index - 1]
    directions = scans.origins - place
    far = np.flatnonzero(np.linalg.norm(directions, axis=1) >= LEAST_WAY_M)  # unknown places (NaN) are not far
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
