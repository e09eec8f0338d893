"""Deskewing of scans whose beams are measured while the robot moves, in plain Python: one scan per beam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, interpolate
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.motion import DENSE_S
from mapper.sensors.scan import LaserScan, ScanLog


def deskewed(
    log: ScanLog, index: int, config: MappingConfig, trajectory: str | None = None
) -> list[tuple[LaserScan, NDArray[np.float64]]]:
    """Return each beam of a scan as a scan of one beam, straight ahead, with the pose from which it was measured.

    Beam k is measured at ``stamp + time_offset + k · time_increment``, and the robot's pose at that time is
    interpolated between two poses of the trajectory. With ``deskew`` "auto", the beams have the pose at the time of the
    first beam if the trajectory does not cover the sweep, or has a gap of more than
    :data:`mapper.sensors.motion.DENSE_S` around it. A scan before the first or after the last pose contributes nothing.

    Source: the unwarping of Cartographer (Hess et al. 2016) and of laser_geometry.
    """
    stamps = [float(stamp) * 1e-9 for stamp in log.stamps_ns]
    order = sorted(range(len(stamps)), key=lambda scan: stamps[scan])
    times, poses = [stamps[scan] for scan in order], log.trajectory(trajectory).poses[order]
    offset = 0.0 if log.trajectory(trajectory).from_scans else config.time_offset
    first = stamps[index] + offset
    last = first + log.time_increment * (log.n_beams - 1)
    before = [t for t in times if t <= min(first, last)]
    after = [t for t in times if t >= max(first, last)]
    dense = bool(before and after) and min(after) - max(before) <= DENSE_S
    own = log.trajectory(trajectory).poses[index] if offset == 0.0 else pose_at(first, times, poses)
    mount = compose(np.array(log.mount), np.array(config.mount))
    ranges = log.ranges[index] if times[0] <= first <= times[-1] else np.full(log.n_beams, np.nan)
    scans = []
    for k, bearing in enumerate(-log.angles if config.mount_upside_down else log.angles):
        base = pose_at(first + log.time_increment * k, times, poses) if dense or config.deskew == "on" else own
        beam = LaserScan(ranges[k : k + 1], 0.0, 0.0, log.range_min, log.range_max)
        scans.append((beam, compose(base, compose(mount, np.array([0.0, 0.0, bearing])))))
    return scans


def pose_at(time: float, times: Sequence[float], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate the pose (3,) at a time, given ``poses`` (n ≥ 2, 3) at ascending ``times`` (n,), seconds.

    For times outside the range it is the first or last pose.
    """
    if time >= times[-1]:
        return np.array(poses[-1])
    low = max([i for i in range(len(times) - 1) if times[i] <= time], default=0)
    span = times[low + 1] - times[low]
    weight = min(max((time - times[low]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    return interpolate(poses[low], poses[low + 1], weight)
