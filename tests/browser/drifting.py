"""A log whose odometry drifts, as a file: a simulated drive around a ring of corridors."""

from __future__ import annotations

import math

from mapper.sensors.scan import ScanLog
from tests.mapper.slam.worlds import along, drive


def carmen_text(log: ScanLog) -> bytes:
    """Return a log as CARMEN lines, with the poses of its first trajectory."""
    lines = [f"PARAM laser_front_laser_resolution {math.degrees(log.angle_increment):.6f}\n"]  # else angles are guessed
    for ranges, (x, y, yaw), ns in zip(log.ranges, log.trajectory().poses, log.stamps_ns, strict=True):
        readings = " ".join(f"{min(float(r), 80.0):.3f}" for r in ranges)
        pose = f"{x:.6f} {y:.6f} {yaw:.6f}"
        lines.append(f"FLASER {len(ranges)} {readings} {pose} {pose} {ns / 1e9:.6f} sim {ns / 1e9:.6f}\n")
    return "".join(lines).encode()


RING = [(3.2, 1.25), (22.7, 1.25), (22.7, 14.7), (1.3, 14.7), (1.3, 1.25), (22.7, 1.25)]


def drifting_ring() -> bytes:
    """Return almost two rounds through the corridors of the world "loop" as a CARMEN log."""
    return carmen_text(drive("loop", along(RING, 0.4)))
