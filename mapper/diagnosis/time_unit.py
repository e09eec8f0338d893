"""The unit of the stamps: a log whose times are seconds only by name."""

from __future__ import annotations

import numpy as np

from mapper.core.time_units import UNITS
from mapper.diagnosis.finding import Finding
from mapper.sensors.scan import ScanLog

RARE_S = 10.0  #: between two scans; a robot that maps makes them more often
DRIVEN_M = 1.0  #: the place has to be longer than that: the poses of a robot that stands differ by their noise
MOVED_M = 1e-3  #: between two scans; less is standing
SPEEDS = (0.01, 3.0)  #: m/s, of robots; less than a factor of 1000 apart, so that one unit at most fits


def check(log: ScanLog, trajectory: str) -> list[Finding]:
    """Compare the times with the way that the robot drives in them.

    The finding needs both: usually more than 10 s from one scan to the next, and a median speed while the robot moves
    that is none by the stamps, but one of a robot where they count in thousandths, millionths or billionths.
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
            f"Divide the log's times by {factor:,.0f}: until then its durations, speeds and delays are wrong.",
            0.9,
        )
    ]
