"""Answers of the HTTP interface about a pose graph. Scans are numbered from 0; points and poses are map coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

PointTuple = tuple[float, float]
PoseTuple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LoopAnswer:
    """A loop of a pose graph: the constraint between two scans of one place, recorded at different times.

    ``residual`` is the distance of the graph's solution from the measurement, in standard deviations. ``weight`` is the
    factor of the robust kernel, 0 to 1, unless the loop is ``locked``.
    """

    edge: int
    scans: tuple[int, int]
    residual: float
    weight: float
    locked: bool


@dataclass(frozen=True, slots=True)
class PoseGraphAnswer:
    """The pose graph of a trajectory: its loops, worst first. ``tried`` is their number including the rejected ones.

    ``nodes`` and ``odometry`` are the numbers of nodes and of odometry edges. ``changed`` says whether the graph
    differs from the result of SLAM.
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
    """The end points of two scans, metres. ``aligned`` are those of the later scan, placed by a loop's measurement."""

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
    """An edge of either kind. ``off_m`` and ``off_deg`` are the deviations of the poses from its measurement."""

    kind: Literal["loop", "odometry"]
    off_m: float
    off_deg: float


@dataclass(frozen=True, slots=True)
class ScanConstraints:
    """The edges that determine the pose of a scan, the greatest residual first.

    ``scan`` is the scan of the graph's node nearest to the requested scan.
    """

    scan: int
    edges: list[ConstraintAnswer]


@dataclass(frozen=True, slots=True)
class EdgeAnswer(ConstraintAnswer):
    """An edge with both of its scans.

    ``score`` and ``inliers`` are those of the match, 0 to 1; null for an odometry edge.
    """

    score: float | None
    inliers: float | None
    poses: list[PoseTuple]
    points: ScanPoints


@dataclass(frozen=True, slots=True)
class TriedLoop:
    """A loop that SLAM tried, ``away_m`` metres from a place. ``reason`` is why it was rejected, empty if accepted."""

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
    """The loops that were tried near a place. ``visits`` are the runs of scans (first and last) recorded near it.

    ``pair`` is a scan of the first visit and one of the last, which a loop could join; null if there are not two
    visits.
    """

    visits: list[tuple[int, int]]
    pair: tuple[int, int] | None
    candidates: list[TriedLoop]


@dataclass(frozen=True, slots=True)
class ScoreLandscape:
    """The match score of an edge's later scan against the earlier one, at poses around the edge's measurement.

    ``scores`` are in percent: ``size`` rows of ``size`` cells of ``cell_m`` metres, from the least y. Each is the best
    over the angles, which are ``turn_deg`` apart; ``turn_of`` is the index of that angle. ``by_turn`` is the greatest
    score at each angle. ``centre`` is the later scan's pose according to the edge, ``present`` its pose in the map.
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
