"""Estimate of the time and memory of SLAM, before it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.sensors.joint_log import sensor_of_scan
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.loop_closure import MOST_ATTEMPTS
from mapper.slam.odometry import matched_scans, odometry_name

MS_PER_SCAN, MS_PER_BEAM = 0.4, 0.004  #: of processor time: measured on 1 to 3 thousand scans of 180 to 682 beams
#: times n² of the scans and the loops that are looked for: the graph is optimised again and again
SECONDS_OF_LOOPS = 2.5e-10
BYTES_PER_BEAM = 17  #: a point, a normal and its kind
BYTES_PER_SCAN = 12_000  #: poses, edges, pairs and their share of the factor
FIXED_BYTES = 150_000_000  #: fields of submaps


@dataclass(frozen=True, slots=True)
class SlamEstimate:
    """``n_matched`` scans will be matched: about ``seconds`` of processor time and ``n_bytes`` of memory."""

    n_matched: int
    seconds: float
    n_bytes: int


def estimate(log: ScanLog, config: SlamConfig | None = None, trajectory: str | None = None) -> SlamEstimate:
    """Return what :func:`mapper.slam.slam_log` will take, on a processor of 2020. Raises :class:`ConfigError`."""
    config = config or SlamConfig()
    name = odometry_name(log) if trajectory is None else trajectory
    odometry = None if name is None else log.trajectory(name).poses
    n = log.n_scans and len(matched_scans(sensor_of_scan(log), odometry, config))
    attempts = _attempts(
        0.0 if odometry is None else float(np.hypot(*np.diff(odometry[:, :2], axis=0).T).sum()), config
    )
    beams = min(log.n_beams, int(config.n_beams))
    return SlamEstimate(
        n,
        1e-3 * n * (MS_PER_SCAN + MS_PER_BEAM * beams) + SECONDS_OF_LOOPS * n**2 * attempts,
        FIXED_BYTES + n * (BYTES_PER_SCAN + BYTES_PER_BEAM * beams),
    )


def _attempts(way: float, config: SlamConfig) -> float:
    """Return how often a loop is looked for over a way, metres; see :meth:`LoopCloser.try_at`."""
    if not config.loop_closure:
        return 0.0
    begin = MOST_ATTEMPTS * config.loop_distance
    return way / config.loop_distance if way <= begin else MOST_ATTEMPTS * (1.0 + math.log(way / begin))
