"""A simulated run without faults, for tests that put one in."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from mapper.sensors.scan import ScanLog
from mapper.simulation import sample_log


@cache
def true_run(n_scans: int, every: int = 1) -> ScanLog:
    """Return the sample log with its true poses; of its beams every so many, as the doctor takes their time."""
    log = sample_log(n_scans)
    thinned = replace(log, ranges=log.ranges[:, ::every].copy(), angle_increment=every * log.angle_increment)
    return replace(thinned, trajectories={"true": log.trajectory("true")})
