"""Check for a constant delay between scans and poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from mapper.core.se2 import wrap_angle
from mapper.diagnosis.consistency import Examined, consistency
from mapper.diagnosis.finding import Finding
from mapper.mapping.parameters import BY_NAME
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog

CLOCK = "timing.clock"  #: poses by another clock, corrected when the log is read
DELAYS_S = (0.05, 0.1, 0.2, 0.3, 0.5, 0.8)  #: tried with both signs
FINER_S = (0.08, 0.04, 0.02, 0.01)  #: steps around the best of them, in order
LEAST_SPANS = 8  #: minimum length of the log in multiples of a tested delay
LEAST_SCANS = 10
OFF_BORDER = 0.13  #: in cells: everything is shifted by it, so that walls at round coordinates are not on a cell border
#: How many times as consistent, and by how much at least, a map must be for other times to be said to fit better.
BETTER, BY = 1.06, 0.015


def check_clock(log: ScanLog) -> list[Finding]:
    """Return the finding on a source of poses from reading the log (:mod:`mapper.io.logs.pose_clocks`)."""
    stated_error = next((part.wrong_clock for part in sensors_of(log) if part.wrong_clock), "")
    if not stated_error:
        return []
    advice = (
        "The map is right without more; set the two clocks by one server, or correct where the sender takes its stamps."
    )
    return [Finding(CLOCK, stated_error, advice, 0.95)]


def check(log: ScanLog, seen: Examined) -> list[Finding]:
    """Try poses from slightly earlier or later on the trajectory for all scans."""
    stamps = log.stamps_ns.astype(np.float64) * 1e-9
    if np.ptp(stamps) == 0.0 or log.trajectory(seen.trajectory).from_scans:
        return []
    order = np.argsort(stamps, kind="stable")
    poses = log.trajectory(seen.trajectory).poses[order]
    times, yaw = stamps[order], np.unwrap(poses[:, 2])
    at = stamps[seen.scans]

    delays = [delay for delay in DELAYS_S if LEAST_SPANS * delay <= times[-1] - times[0]]
    # The poses at all tested times must be known; beyond the ends, scans would be placed on top of each other.
    margin = max(delays, default=0.0) + sum(FINER_S)
    known = np.flatnonzero((at >= times[0] + margin) & (at <= times[-1] - margin))
    if not delays or len(known) < LEAST_SCANS:
        return []
    at, seen = at[known], seen.part(known)

    columns = (poses[:, 0], poses[:, 1], yaw)
    middle = [float(np.interp(at, times, column).mean()) for column in columns[:2]]

    def delayed(delay: float) -> float:
        moved = [np.interp(at + delay, times, column) for column in columns]
        # A motion common to all poses, as along a straight line, shifts the whole map. It shows no delay, only the
        # alignment of walls with the grid.
        for axis in (0, 1):
            moved[axis] += middle[axis] - moved[axis].mean() + OFF_BORDER * seen.config.resolution
        moved[2] = wrap_angle(moved[2])
        return consistency(seen.with_poses(np.stack(moved, axis=-1)))

    now = delayed(0.0)
    tried = [(delayed(sign * delay), sign * delay) for delay in delays for sign in (1.0, -1.0)]
    best, delay = max(tried)
    if best < BETTER * now or best < now + BY:
        return []
    for step in FINER_S:
        best, delay = max(
            [(best, delay), *((delayed(delay + sign * step), delay + sign * step) for sign in (1.0, -1.0))]
        )
    offset = round(seen.time_offset + delay, 2)
    row = BY_NAME["time_offset"]
    parameters: dict[str, Any] | None = {"time_offset": offset} if row.low <= offset <= row.high else None
    remedy = f"Map with a time offset of {offset:g} s (--time-offset {offset:g}). " if parameters else ""
    who = "after" if delay > 0.0 else "before"
    return [
        Finding(
            "timing.delay",
            f"Poses and scans are out of step: the map is sharper with poses from about {abs(delay):.2f} s {who} each "
            f"scan’s time: beams end where others end in {100 * best:.0f} % instead of {100 * now:.0f} % of all cases.",
            f"{remedy}Check how the two clocks are set, and whether scans are stamped when they begin, end or arrive.",
            min(0.95, 0.4 + 4.0 * (best - now)),
            parameters=parameters,
        )
    ]
