"""A trajectory in the format of the TUM RGB-D benchmark, as read by evo and many others.

Source: the benchmark's file formats: ``timestamp tx ty tz qx qy qz qw``, seconds, metres, a unit quaternion.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from mapper.sensors.scan import ScanLog


def tum_text(log: ScanLog, trajectory: str | None = None) -> str:
    """Return the pose of the robot's base at each scan, one line per scan, in file order and with its stamps.

    Unknown poses, such as before localization has converged, are omitted. Raises :class:`ConfigError` for a trajectory
    that the log lacks.
    """
    return "".join(tum_lines(log, trajectory))


def tum_lines(log: ScanLog, trajectory: str | None = None) -> Iterator[str]:
    """Return an iterator over the lines of :func:`tum_text`. Raises the same errors."""
    exported = log.trajectory(trajectory)
    half = exported.poses[:, 2] / 2.0
    known = itertools.repeat(True) if exported.is_known is None else exported.is_known
    rows = zip(
        log.stamps_ns, exported.poses[:, :2] + np.array(exported.offset), np.sin(half), np.cos(half), strict=True
    )
    known_rows = itertools.compress(rows, known)
    return (f"{_seconds(int(ns))} {x:.6f} {y:.6f} 0 0 0 {qz:.9f} {qw:.9f}\n" for ns, (x, y), qz, qw in known_rows)


def _seconds(stamp_ns: int) -> str:
    """Return nanoseconds as seconds with all digits, without the precision loss of a float."""
    whole, rest = divmod(abs(stamp_ns), 1_000_000_000)
    return f"{'-' if stamp_ns < 0 else ''}{whole}.{rest:09d}"
