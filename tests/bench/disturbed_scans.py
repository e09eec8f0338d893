"""The scans of a simulated log as polished walls and people who walk about leave them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.sensors.scan import ScanLog
from mapper.simulation import World
from mapper.simulation.faults import lengthened, with_lengthened
from mapper.simulation.sample import SAMPLE_SENSOR

PEOPLE, BODY_M, SPEED_M_S = 6, 0.25, 1.2  #: who walk about, their radius, and their speed
KEPT_M = 0.6  #: from the sensor to a person's middle: nobody comes nearer, so who would is left out meanwhile


def polished(log: ScanLog, world: World) -> ScanLog:
    """Return a log by :data:`SAMPLE_SENSOR` along its true poses in which long walls reflect slanting beams away."""
    longer = np.array([lengthened(world, SAMPLE_SENSOR, pose) for pose in log.sensor_poses()])
    return replace(log, ranges=with_lengthened(log.ranges, longer, log.range_max))


def crowded(log: ScanLog, world: World, kept_m: float = KEPT_M) -> ScanLog:
    """Return a log along its true poses with people who walk straight from one random place to the next.

    They walk through walls too, which hide them. Who is nearer to the sensor than ``kept_m`` is left out.
    """
    random = np.random.default_rng(7)
    x0, y0, x1, y1 = world.bounds
    seconds = (log.stamps_ns - log.stamps_ns[0]) * 1e-9
    poses, ranges = log.sensor_poses(), log.ranges.astype(np.float64)
    bearings = poses[:, 2:] + log.angles
    for _ in range(PEOPLE):
        places = random.uniform((x0, y0), (x1, y1), (100, 2))
        arrival = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))]) / SPEED_M_S
        at = np.stack([np.interp(seconds, arrival, column) for column in places.T], axis=-1) - poses[:, :2]
        # At an angle a to the middle of a circle of radius r, d away, it is met after d cos a − √(r² − d² sin² a).
        far, off = np.hypot(at[:, :1], at[:, 1:]), np.arctan2(at[:, 1:], at[:, :1]) - bearings
        inside = BODY_M**2 - (far * np.sin(off)) ** 2
        met = far * np.cos(off) - np.sqrt(np.maximum(inside, 0.0))
        ranges = np.where((inside > 0.0) & (met > 0.0) & (far > kept_m), np.minimum(ranges, met), ranges)
    return replace(log, ranges=ranges.astype(np.float32))
