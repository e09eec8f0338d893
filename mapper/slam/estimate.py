"""Estimate of the time and memory of SLAM before it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.sensors.joint_log import sensor_of_scan
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.loop_closure import MOST_ATTEMPTS
from mapper.slam.odometry import matched_scans, odometry_name

MS_PER_SCAN, MS_PER_BEAM = 0.4, 0.004  #: processor time: measured on 1 to 3 thousand scans of 180 to 682 beams
MS_PER_ATTEMPT = 2.0  #: per attempted loop closure, measured on simulated drives of 4 and 8 km
#: multiplied by n^1.5 of the scans, for the repeated optimisation of the graph, as measured from 4 to 13 thousand
#: scans.
SECONDS_OF_GRAPH = 2e-5
MANY_ATTEMPTS = 2_000  #: attempted loops: with fewer, optimisation takes less time
BYTES_PER_BEAM = 17  #: a point, a normal and its kind
BYTES_PER_SCAN = 12_000  #: poses, edges, pairs and the share of the factor
FIXED_BYTES = 150_000_000  #: fields of submaps
PASSES = 2  #: over all scans, in memory at once if loops are closed: the best one and one with other rules


@dataclass(frozen=True, slots=True)
class SlamEstimate:
    """``n_matched`` scans to match, in about ``seconds`` of processor time and ``n_bytes`` of memory."""

    n_matched: int
    seconds: float
    n_bytes: int


def estimate(log: ScanLog, config: SlamConfig | None = None, trajectory: str | None = None) -> SlamEstimate:
    """Return the estimate for :func:`mapper.slam.slam_log` on a processor of 2020. Raises :class:`ConfigError`.

    The seconds are those of one pass. Each pass with other rules (:data:`mapper.slam.whole_log.STRICTER`), tried if the
    map contradicts itself, takes as long again. The memory is that of all passes held at once.
    """
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
        1e-3 * (n * (MS_PER_SCAN + MS_PER_BEAM * beams) + MS_PER_ATTEMPT * attempts)
        + SECONDS_OF_GRAPH * n**1.5 * min(attempts / MANY_ATTEMPTS, 1.0),
        FIXED_BYTES + n * (BYTES_PER_SCAN + BYTES_PER_BEAM * beams) * (PASSES if config.loop_closure else 1),
    )


def _attempts(driven: float, config: SlamConfig) -> float:
    """Return the number of loop searches along a path of this length, metres; see :meth:`LoopCloser.try_at`."""
    if not config.loop_closure:
        return 0.0
    begin = MOST_ATTEMPTS * config.loop_distance
    return driven / config.loop_distance if driven <= begin else MOST_ATTEMPTS * (1.0 + math.log(driven / begin))
