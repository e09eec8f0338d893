"""Check of the unit of the stamps: times in a smaller unit read as seconds."""

from __future__ import annotations

import numpy as np

from mapper.core.time_units import UNITS
from mapper.diagnosis.finding import Finding
from mapper.sensors.scan import ScanLog

RARE_S = 10.0  #: maximum scan interval of a mapping robot
DRIVEN_M = 1.0  #: minimum extent of the path; poses of a robot at rest differ by noise
MOVED_M = 1e-3  #: minimum motion between two scans
SPEEDS = (0.01, 3.0)  #: m/s, of robots; the ratio is below 1000, so that at most one unit fits


def check(log: ScanLog, trajectory: str) -> list[Finding]:
    """Compare the scan interval and the robot's speed with the usual values.

    A finding requires a median interval of more than 10 s, and a median speed of the moving robot that is below 0.01
    m/s for stamps in seconds, and plausible for milli-, micro- or nanoseconds.
    """
    along = log.trajectory(trajectory)
    passed = np.diff(log.stamps_ns.astype(np.float64)) * 1e-9
    step = np.hypot(*np.diff(along.poses[:, :2], axis=0).T)
    moves = (passed > 0.0) & (step > MOVED_M)
    if along.is_placeholder or not moves.any() or np.ptp(along.poses[:, :2], axis=0).max() < DRIVEN_M:
        return []
    usual = float(np.median(passed[passed > 0.0]))
    speed = float(np.median(step[moves] / passed[moves]))
    fitting = [(factor, unit) for factor, unit in UNITS if SPEEDS[0] <= speed * factor <= SPEEDS[1]]
    if usual < RARE_S or not fitting or speed >= SPEEDS[0]:
        return []
    factor, unit = fitting[0]
    return [
        Finding(
            "clock.unit",
            f"The times are likely {unit} that are read as seconds: by them one scan comes every {usual:,.0f} s, in "
            f"which the robot drives {speed * usual:.2g} m; in {unit} these are {usual / factor:.2g} s, and "
            f"{speed * factor:.2g} m/s.",
            f"Divide the log’s times by {factor:,.0f}: until then its durations, speeds and delays are wrong.",
            0.9,
        )
    ]
