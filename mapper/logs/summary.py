"""What a log holds, in a few figures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.scan import ScanLog, Topic


@dataclass(frozen=True, slots=True)
class TrajectorySummary:
    """``length_m`` is the way from the first scan's pose to the last's, as the sum of its steps."""

    name: str
    description: str
    length_m: float


@dataclass(frozen=True, slots=True)
class ReadingCounts:
    """How many of all readings are measured ranges, say "no return", or are no valid reading."""

    measured: int
    no_return: int
    invalid: int


@dataclass(frozen=True, slots=True)
class LogSummary:
    """Figures of one log: metres, radians and, where the name says so, degrees and seconds."""

    name: str
    format: str
    scans: int
    beams: int
    duration_s: float  #: between the earliest and the latest stamp
    field_of_view_deg: float  #: from the first beam to the last
    angle_min: float
    angle_increment: float
    range_max: float
    mount: tuple[float, float, float]
    readings: ReadingCounts
    trajectories: tuple[TrajectorySummary, ...]
    notes: tuple[str, ...]
    upside_down: bool = False
    topics: tuple[Topic, ...] = ()


def summarise(log: ScanLog) -> LogSummary:
    """Return the figures of ``log``."""
    seconds = recorded_seconds(log)
    return LogSummary(
        name=log.name,
        format=log.format,
        scans=log.n_scans,
        beams=log.n_beams,
        duration_s=float(seconds[-1]) if len(seconds) else 0.0,
        field_of_view_deg=math.degrees(abs(log.angle_increment)) * max(0, log.n_beams - 1),
        angle_min=log.angle_min,
        angle_increment=log.angle_increment,
        range_max=log.range_max,
        mount=log.mount,
        readings=_count_readings(log),
        trajectories=tuple(
            TrajectorySummary(name, trajectory.description, _length(trajectory.poses))
            for name, trajectory in log.trajectories.items()
        ),
        notes=log.notes,
        upside_down=log.upside_down,
        topics=log.topics,
    )


def recorded_seconds(log: ScanLog) -> NDArray[np.float64]:
    """Return how much of the recorded time is over at each scan (n_scans,), in seconds since the earliest stamp.

    Never decreasing: where the clock steps back, time stands still until it has caught up. The last one is the log's
    duration; all are zero for a log without times.
    """
    if log.n_scans == 0:
        return np.zeros(0)
    latest = np.maximum.accumulate(log.stamps_ns)
    # As unsigned numbers: the span of two absurd stamps does not fit into a signed one.
    span_ns: NDArray[np.uint64] = latest.view(np.uint64) - log.stamps_ns.min(keepdims=True).view(np.uint64)
    return span_ns.astype(np.float64) * 1e-9


def _length(poses: NDArray[np.float64]) -> float:
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())


def _count_readings(log: ScanLog) -> ReadingCounts:
    measured = int(np.count_nonzero((log.ranges >= log.range_min) & (log.ranges <= log.range_max)))
    no_return = int(np.count_nonzero(log.ranges > log.range_max))
    return ReadingCounts(measured, no_return, log.ranges.size - measured - no_return)
