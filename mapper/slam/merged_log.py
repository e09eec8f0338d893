"""Merging of the scans of two logs into one log, along poses in one frame."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.sensors.joint_log import JointLog, part_of_scan, sensors_of
from mapper.sensors.scan import ScanLog, Trajectory

_NO_PART_OF_A_NAME = re.compile(r"[^A-Za-z0-9_/]")  #: characters not allowed in a topic of ROS 2

MERGED = "merged"  #: name of the trajectory
BETWEEN_NS = 1_000_000_000  #: from the last scan of one log to the first of the next, if a clock is shifted
#: Properties that two lidars must share for their scans to be rows of one log.
_SAME = (
    "n_beams", "angle_min", "angle_increment", "range_min", "range_max", "mount", "beam_width", "upside_down",
    "time_increment", "scan_time",
)  # fmt: skip


def merged_log(logs: tuple[ScanLog, ScanLog], poses: tuple[Float64Array, Float64Array]) -> tuple[ScanLog, str]:
    """Return the scans of both logs, the earlier log first, with the single trajectory :data:`MERGED`.

    ``poses`` are (n_scans, 3) each, ``T_map_base`` in one frame. If each log has one lidar with equal properties, they
    become one sensor on ``/scan``; otherwise each remains a sensor, its topic prefixed with ``/first`` or ``/second``.
    If the logs overlap in time, the second log's clock is shifted to start one second after the end of the first; the
    returned text says so, otherwise it is empty.
    """
    (start, end), (other_start, other_end) = ((int(log.stamps_ns.min()), int(log.stamps_ns.max())) for log in logs)
    shift = end + BETWEEN_NS - other_start if start <= other_end and other_start <= end else 0
    parts = [*_sensors(logs[0], poses[0], "/first", 0), *_sensors(logs[1], poses[1], "/second", shift)]
    if other_end < start:
        parts.reverse()
    note = ""
    if shift:
        note = f"the second log’s clock is set {shift / 1e9:+.3f} s, so that it follows the first log"
    if len(parts) == 2 and _are_alike(*parts):
        return _one_after_the_other(*parts), note
    return JointLog.of(parts), note


def _sensors(log: ScanLog, poses: Float64Array, name: str, shift: int) -> list[ScanLog]:
    """Return the sensors of a log with only their scans along ``poses`` (n_scans, 3) of all sensors."""
    owner = part_of_scan(log)
    return [
        replace(
            part,
            stamps_ns=part.stamps_ns + shift,
            order_ns=None if part.order_ns is None else part.order_ns + shift,
            trajectories={MERGED: Trajectory(poses[owner == number], "poses of two merged logs", "map")},
            topic=f"{name}/{_NO_PART_OF_A_NAME.sub('_', part.topic).strip('/') or f'scan_{number}'}",
            frame_id=f"{name.strip('/')}_{part.frame_id.strip('/')}",
            odometry=None,
            topics=(),
            notes=(),
        )
        for number, part in enumerate(sensors_of(log))
    ]


def _are_alike(first: ScanLog, second: ScanLog) -> bool:
    is_plain = all(log.bearings is None and log.mounts is None for log in (first, second))
    return is_plain and all(getattr(first, name) == getattr(second, name) for name in _SAME)


def _one_after_the_other(first: ScanLog, second: ScanLog) -> ScanLog:
    path = first.trajectories[MERGED]
    both = np.concatenate([path.poses, second.trajectories[MERGED].poses])
    return replace(
        first,
        ranges=np.concatenate([first.ranges, second.ranges]),
        stamps_ns=np.concatenate([first.stamps_ns, second.stamps_ns]),
        order_ns=None,
        trajectories={MERGED: replace(path, poses=both)},
        topic="/scan",
    )
