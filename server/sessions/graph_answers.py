"""Answers of the HTTP interface about a pose graph. Scans are numbers from 0, points and poses are those of the map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

PointTuple = tuple[float, float]
PoseTuple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LoopAnswer:
    """A loop of a pose graph: the constraint between two scans that were taken at one place at different times.

    ``residual`` is how far the graph's solution is from the measurement, in standard deviations, ``weight`` what the
    robust kernel leaves of the loop, 0 to 1, unless it is ``locked``.
    """

    edge: int
    scans: tuple[int, int]
    residual: float
    weight: float
    locked: bool


@dataclass(frozen=True, slots=True)
class PoseGraphAnswer:
    """The pose graph of a trajectory: its loops, worst first; ``tried`` counts them with those that were refused.

    ``nodes`` and ``odometry`` are numbers of nodes and of edges of odometry; ``changed`` says whether it is not as SLAM
    left it.
    """

    trajectory: str
    nodes: int
    odometry: int
    loops: list[LoopAnswer]
    tried: int
    robust: str
    robust_scale: float
    changed: bool


@dataclass(frozen=True, slots=True)
class ScanPoints:
    """The end points of two scans, metres; ``aligned`` are those of the later one as a loop's measurement puts it."""

    i: list[PointTuple]
    j: list[PointTuple]
    aligned: list[PointTuple] | None


@dataclass(frozen=True, slots=True)
class ScanPair:
    """Two scans: the poses of both, and their points."""

    poses: list[PoseTuple]
    points: ScanPoints


@dataclass(frozen=True, slots=True)
class ConstraintAnswer(LoopAnswer):
    """An edge of either kind; ``off_m`` and ``off_deg`` are how far the poses are from its measurement."""

    kind: Literal["loop", "odometry"]
    off_m: float
    off_deg: float


@dataclass(frozen=True, slots=True)
class ScanConstraints:
    """The edges that determine the pose of a scan, the greatest residual first.

    ``scan`` is that of the node of the graph: the nearest to the one that was asked about.
    """

    scan: int
    edges: list[ConstraintAnswer]


@dataclass(frozen=True, slots=True)
class EdgeAnswer(ConstraintAnswer):
    """An edge with both of its scans.

    ``score`` and ``inliers`` are those of the match, 0 to 1, null of an edge of odometry.
    """

    score: float | None
    inliers: float | None
    poses: list[PoseTuple]
    points: ScanPoints


@dataclass(frozen=True, slots=True)
class TriedLoop:
    """A loop that SLAM tried, ``away_m`` metres from a place; ``reason`` says what refused it, empty if accepted."""

    candidate: int
    scans: tuple[int, int]
    away_m: float
    score: float
    inliers: float
    accepted: bool
    reason: str


@dataclass(frozen=True, slots=True)
class TriedLoopScans(TriedLoop):
    """A loop that SLAM tried, with both of its scans."""

    poses: list[PoseTuple]
    points: ScanPoints


@dataclass(frozen=True, slots=True)
class TriedNear:
    """What was tried near a place. ``visits`` are the runs of scans, first and last, that were taken near it.

    ``pair`` is a scan of the first visit and one of the last, which a loop could join; null without two visits.
    """

    visits: list[tuple[int, int]]
    pair: tuple[int, int] | None
    candidates: list[TriedLoop]


@dataclass(frozen=True, slots=True)
class ScoreLandscape:
    """How well the later scan of an edge fits the earlier one at the poses around the edge's measurement.

    ``scores`` are percent, ``size`` rows of as many cells of ``cell_m`` metres from the least y, each at the best of
    the angles ``turn_deg`` apart, whose number is in ``turn_of``; ``by_turn`` is the greatest at each angle.
    ``centre`` is where the edge puts the scan, ``present`` its pose in the map.
    """

    edge: int
    cell_m: float
    turn_deg: float
    size: int
    scores: list[int]
    turn_of: list[int]
    by_turn: list[int]
    centre: PoseTuple
    present: PoseTuple
