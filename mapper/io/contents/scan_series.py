"""Motion and readings of a log per scan, as a series for plots.

Source of the rates: finite differences of consecutive poses, as in evo's ``speed`` plot.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import wrap_angle
from mapper.io.contents.model import Column, Series
from mapper.sensors.joint_log import JointLog, sensors_of
from mapper.sensors.scan import ScanLog

BLOCK_READINGS = 1 << 22  #: readings classified at a time, so that the masks stay small

SPEED = Column("speed", "m/s", "speed")
TURN_RATE = Column("turn rate", "rad/s", "turn rate")
TURN = Column("turn", "rad", "turn")
RETURNS = Column("returns", "%", "returns")
STEP = Column("pose step", "m", "pose step")
INTERVAL = Column("interval", "s", "interval")


def has_times(log: ScanLog) -> bool:
    """Return whether the scans have different times; formats without stamps have one for all."""
    return log.n_scans > 0 and int(log.stamps_ns.max()) > int(log.stamps_ns.min())


def plot_stamps(log: ScanLog) -> NDArray[np.int64]:
    """Return the plot time of each scan (n_scans,), ns: its stamp, or one second per scan without times."""
    return log.stamps_ns if has_times(log) else np.arange(log.n_scans, dtype=np.int64) * 1_000_000_000


def plot_origin_ns(log: ScanLog) -> int:
    """Return the time of 0 s in plots of the scans."""
    return int(log.stamps_ns.min()) if has_times(log) else 0


def scan_series(log: ScanLog, trajectory: str | None = None) -> Series:
    """Return the readings of each scan of a log, and the robot's motion since the previous scan.

    Columns: speed (m/s, unsigned) and turn rate (rad/s, counter-clockwise) of the base along ``trajectory`` (None: the
    default) since the previous scan; the percentage of a scan's beams with a measured range (``range_min <= r <=
    range_max``); the distance between the two poses, m; the time between the two scans, s. NaN for the first scan, and
    for rates over a time that is zero or negative. The rows are in time order. A log without times (:func:`has_times`)
    has stamps one second apart, the turn (rad) in place of rates, and no intervals. The poses of a placeholder are not
    included. Raises :class:`mapper.core.errors.ConfigError` for a trajectory that the log lacks.
    """
    along = log.trajectory(trajectory)
    step_xy = np.diff(along.poses[:, :2], axis=0, prepend=np.nan)
    step = np.hypot(step_xy[:, 0], step_xy[:, 1])
    turn = _differences(along.poses[:, 2])
    turn = np.where(np.isnan(turn), np.nan, wrap_angle(turn))
    interval = _differences(log.stamps_ns.astype(np.float64)) * 1e-9
    passed = np.where(interval > 0.0, interval, np.nan)
    measured = {
        SPEED: step / passed,
        TURN_RATE: turn / passed,
        TURN: turn,
        STEP: step,
        RETURNS: 100.0 * _share_of_returns(log),
        INTERVAL: interval,
    }
    columns = scan_columns(log, trajectory)
    stamps = plot_stamps(log)
    order = np.argsort(stamps, kind="stable")
    values = np.column_stack([measured[column] for column in columns]).astype(np.float32)
    return Series("scans", "scan", columns, stamps[order], values[order])


def scan_columns(log: ScanLog, trajectory: str | None = None) -> tuple[Column, ...]:
    """Return the columns of :func:`scan_series`. Raises the same errors."""
    is_timed = has_times(log)
    motion = (*((SPEED, TURN_RATE) if is_timed else (TURN,)), STEP)
    moves = () if log.trajectory(trajectory).is_placeholder else motion
    return (*moves, RETURNS, *((INTERVAL,) if is_timed else ()))


def _differences(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.diff(values, prepend=np.nan)


def _share_of_returns(log: ScanLog) -> NDArray[np.float64]:
    """Return the fraction of each scan's beams with a measured range, (n_scans,), 0 to 1."""
    if isinstance(log, JointLog):  # the parts differ in their beams and limits
        shares = np.empty(log.n_scans)
        for number, part in enumerate(sensors_of(log)):
            own = log.part_of_scan == number
            shares[own] = _share_of_returns(part)[log.scan_of_part[own]]
        return shares
    shares = np.zeros(log.n_scans)
    rows = max(1, BLOCK_READINGS // max(1, log.n_beams))
    for first in range(0, log.n_scans, rows):
        ranges = log.ranges[first : first + rows]
        measured = (ranges >= log.range_min) & (ranges <= log.range_max) & np.isfinite(ranges)
        shares[first : first + rows] = np.count_nonzero(measured, axis=1) / max(1, log.n_beams)
    return shares
