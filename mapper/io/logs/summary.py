"""Summary figures of a log."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.time_units import EPOCH_S
from mapper.sensors.gaps import are_gaps
from mapper.sensors.joint_log import is_measured, sensors_of
from mapper.sensors.scan import ScanLog, Topic


@dataclass(frozen=True, slots=True)
class TrajectorySummary:
    """``length_m`` is the length of the path between the poses of the first and last scan, as the sum of its steps."""

    name: str
    description: str
    length_m: float


@dataclass(frozen=True, slots=True)
class ReadingCounts:
    """Numbers of readings that are measured ranges, "no return", or invalid."""

    measured: int
    no_return: int
    invalid: int


@dataclass(frozen=True, slots=True)
class TimeSummary:
    """Times of the scans. ``start_s`` is the earliest stamp since 1970, None for a clock with another epoch.

    A gap is a pause between two scans of more than a second and five times the usual one; ``longest_gap_at_s`` is the
    start of the longest, in seconds since the earliest stamp.
    """

    start_s: float | None
    rate_hz: float | None  #: from the median pause between two scans; None for a log without times
    gaps: int
    longest_gap_s: float
    longest_gap_at_s: float


@dataclass(frozen=True, slots=True)
class MapSummary:
    """The size of a map in cells, and the side of a cell in metres."""

    rows: int
    cols: int
    resolution: float


@dataclass(frozen=True, slots=True)
class LogSummary:
    """Figures of one log: metres, radians and, as the names indicate, degrees and seconds."""

    name: str
    format: str
    scans: int
    beams: int
    duration_s: float  #: between the earliest and the latest stamp
    field_of_view_deg: float  #: from the first beam to the last
    angle_min: float
    angle_increment: float
    range_max: float | None  #: None if unlimited, as for scans extracted from clouds
    mount: tuple[float, float, float]
    readings: ReadingCounts
    trajectories: tuple[TrajectorySummary, ...]
    notes: tuple[str, ...]
    upside_down: bool = False
    time: TimeSummary | None = None
    topics: tuple[Topic, ...] = ()
    costmaps: int = 0  #: for a recording without scans
    clouds: int = 0  #: number of 3D scans, for a file without planar ones; an octree counts as one
    points: int = 0  #: of these clouds, or leaves of the octree
    map: MapSummary | None = None  #: for map files, which have no scans


#: Default figures of a record without scans, to be completed with ``dataclasses.replace``.
NO_SCANS = LogSummary(
    name="",
    format="",
    scans=0,
    beams=0,
    duration_s=0.0,
    field_of_view_deg=0.0,
    angle_min=0.0,
    angle_increment=0.0,
    range_max=0.0,
    mount=(0.0, 0.0, 0.0),
    readings=ReadingCounts(0, 0, 0),
    trajectories=(),
    notes=(),
)


def summarise(log: ScanLog) -> LogSummary:
    """Return the figures of ``log``."""
    seconds, parts = recorded_seconds(log), sensors_of(log)
    return LogSummary(
        name=log.name,
        format=log.format,
        scans=log.n_scans,
        beams=log.n_beams,
        duration_s=float(seconds[-1]) if len(seconds) else 0.0,
        field_of_view_deg=max(math.degrees(float(np.ptp(part.angles))) if part.n_beams else 0.0 for part in parts),
        angle_min=log.angle_min,
        angle_increment=log.angle_increment,
        range_max=log.range_max if math.isfinite(log.range_max) else None,
        mount=log.mount,
        readings=_count_readings(log),
        trajectories=tuple(
            TrajectorySummary(name, trajectory.description, path_length(trajectory.poses))
            for name, trajectory in log.trajectories.items()
        ),
        notes=log.notes,
        upside_down=log.upside_down,
        time=_time(log.stamps_ns, seconds),
        topics=log.topics,
    )


def recorded_seconds(log: ScanLog) -> NDArray[np.float64]:
    """Return the elapsed recorded time at each scan (n_scans,), in seconds since the earliest stamp.

    Never decreasing: if the clock steps back, time stays constant until it has caught up. The last value is the log's
    duration; all are zero for a log without times.
    """
    if log.n_scans == 0:
        return np.zeros(0)
    latest = np.maximum.accumulate(log.stamps_ns)
    # Unsigned, because the span of two extreme stamps does not fit into a signed integer.
    span_ns: NDArray[np.uint64] = latest.view(np.uint64) - log.stamps_ns.min(keepdims=True).view(np.uint64)
    return span_ns.astype(np.float64) * 1e-9


def start_s(stamps_ns: NDArray[np.int64]) -> float | None:
    """Return the earliest stamp in seconds since 1970; None for a clock with another epoch, and without stamps."""
    start = float(stamps_ns.min()) * 1e-9 if len(stamps_ns) else 0.0
    return start if EPOCH_S[0] < start < EPOCH_S[1] else None


def _time(stamps_ns: NDArray[np.int64], seconds: NDArray[np.float64]) -> TimeSummary:
    pauses = np.diff(seconds)
    usual = float(np.median(pauses[pauses > 0.0])) if (pauses > 0.0).any() else 0.0
    gaps = are_gaps(pauses)
    longest = int(np.argmax(pauses)) if gaps.any() else -1
    return TimeSummary(
        start_s=start_s(stamps_ns),
        rate_hz=1.0 / usual if usual > 0.0 else None,
        gaps=int(np.count_nonzero(gaps)),
        longest_gap_s=float(pauses[longest]) if gaps.any() else 0.0,
        longest_gap_at_s=float(seconds[longest]) if gaps.any() else 0.0,
    )


def time_without_gaps(stamps_ns: NDArray[np.int64]) -> tuple[TimeSummary, float]:
    """Return the times of clouds or costmaps, without gap analysis, and the seconds from first to last."""
    seconds = np.sort(stamps_ns).astype(np.float64) * 1e-9
    usual = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 0.0
    rate = 1.0 / usual if usual > 0.0 and math.isfinite(usual) else None
    return TimeSummary(start_s(stamps_ns), rate, 0, 0.0, 0.0), float(np.ptp(seconds)) if len(seconds) else 0.0


def path_length(poses: NDArray[np.float64]) -> float:
    """Return the sum of the steps of a path of poses (n, 3), metres."""
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())


def _count_readings(log: ScanLog) -> ReadingCounts:
    measured = no_return = total = 0
    for part in sensors_of(log):
        measured += int(np.count_nonzero(is_measured(part)))
        no_return += int(np.count_nonzero((part.ranges > part.range_max) | np.isposinf(part.ranges)))
        total += part.ranges.size
    return ReadingCounts(measured, no_return, total - measured - no_return)
