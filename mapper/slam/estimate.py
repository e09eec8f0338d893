"""What SLAM of a log will take, before it starts."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.sensors.joint_log import sensor_of_scan
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.odometry import matched_scans, odometry_name

MS_PER_SCAN, MS_PER_BEAM = 1.0, 0.009  #: of processor time: measured on 1 to 3 thousand scans of 180 to 682 beams
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
    n = log.n_scans and len(
        matched_scans(sensor_of_scan(log), None if name is None else log.trajectory(name).poses, config)
    )
    beams = min(log.n_beams, int(config.n_beams))
    return SlamEstimate(
        n,
        1e-3 * n * (MS_PER_SCAN + MS_PER_BEAM * beams),
        FIXED_BYTES + n * (BYTES_PER_SCAN + BYTES_PER_BEAM * beams),
    )
