"""A pose graph as estimated by SLAM and after manual changes: its solution, drawing and questions."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points
from mapper.io.contents.model import Series
from mapper.io.contents.scan_series import plot_stamps
from mapper.matching.kernels.types import NO_POINT
from mapper.matching.match import match_scan
from mapper.matching.parameters import MatchConfig
from mapper.matching.target import scan_target
from mapper.sensors.pose_graph import CONTRADICTS, LOOP, STRAINED, PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam import LoopCandidates
from mapper.slam.optimise import optimise
from mapper.slam.residuals import residual_series, residuals
from mapper.slam.scan_store import scans_of
from server.sessions.drawings import Segments
from server.sessions.graph_answers import (
    ConstraintAnswer,
    EdgeAnswer,
    LoopAnswer,
    PoseGraphAnswer,
    ScanConstraints,
    ScanPair,
    ScanPoints,
    TriedLoop,
    TriedLoopScans,
    TriedNear,
)
from server.sessions.parts import ShownLoops
from server.sessions.view import GraphChange
from server.stream.layers import GraphLayer

KERNELS = ("geman_mcclure", "cauchy", "huber", "none")
SCALES = (0.5, 50.0)  #: least and greatest scale of the kernel, in standard deviations
NEAREST = 12  #: maximum number of candidates listed for a place
RADIUS = 3.0  #: metres around a place in which they are searched
WINDOW = 3.0  #: metres to each side in which a manually added loop is matched
LEAST_SCORE = 0.4  #: of such a match, 0 to 1
LEAST_DEVIATIONS = (0.03, 0.03, 0.01)  #: m, m, rad: lower bound for the standard deviations of a match
MAX_POINTS = 720  #: of one drawn scan
LOOP_Z = 0.1  #: metres above the floor, and so above the path, at which the 3D view draws loops
#: of loops that fit, that are strained, and that contradict the rest
LOOP_COLOURS = np.array([(46, 130, 90), (214, 150, 30), (200, 40, 60)], dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class GraphOptions:
    """Options of the graph's solver: the robust kernel of its loops and its scale, in standard deviations."""

    robust: str = "geman_mcclure"
    robust_scale: float = 3.0

    def __post_init__(self) -> None:
        if self.robust not in KERNELS:
            raise ConfigError("graph.robust", f"The kernel {self.robust!r:.40} is not one of {', '.join(KERNELS)}.")
        if not (math.isfinite(self.robust_scale) and SCALES[0] <= self.robust_scale <= SCALES[1]):
            raise ConfigError("graph.robust_scale", f"The scale of the kernel must be {SCALES[0]:g} to {SCALES[1]:g}.")


@dataclass(frozen=True, slots=True)
class SolvedGraph:
    """A graph as estimated by SLAM, and after manual changes.

    ``trajectory`` is the name of the trajectory computed from it. ``slam_poses`` (n_scans, 3) are its poses from SLAM,
    which a joint refinement has moved from the solution of the graph. A manual change moves each pose as much as it
    moves the solution; without changes the trajectory is that of SLAM.
    """

    trajectory: str
    slam_poses: Float64Array
    first: PoseGraph  #: the solution without changes
    graph: PoseGraph  #: the current solution
    candidates: LoopCandidates
    options: GraphOptions
    is_changed: bool = False

    @classmethod
    def of(cls, trajectory: str, slam_poses: Float64Array, graph: PoseGraph, candidates: LoopCandidates) -> SolvedGraph:
        """Solve a graph from SLAM (worker thread). Raises like :func:`mapper.slam.optimise`."""
        options = GraphOptions()
        solved = optimise(graph, robust=options.robust, robust_scale=options.robust_scale)
        return cls(trajectory, slam_poses, solved, solved, candidates, options)

    def solved(self, graph: PoseGraph, options: GraphOptions) -> SolvedGraph:
        """Return the solution of another graph of the same nodes (worker thread).

        Raises like :func:`mapper.slam.optimise`.
        """
        result = optimise(graph, robust=options.robust, robust_scale=options.robust_scale)
        return replace(self, graph=result, options=options, is_changed=True)

    @property
    def poses(self) -> Float64Array:
        """The poses of all scans (n_scans, 3), ``T_map_base``."""
        if self.graph is self.first:
            return self.slam_poses
        nodes = self.graph.nodes
        moved = compose(self.graph.poses, inverse(self.first.poses))  # movement of the map at each node
        scans = np.arange(len(self.slam_poses))
        before = np.clip(np.searchsorted(nodes, scans, side="right") - 1, 0, len(nodes) - 1)
        return compose(moved[before], self.slam_poses)

    @property
    def node_poses(self) -> Float64Array:
        """The poses of the nodes (m, 3) in the map."""
        return np.asarray(self.poses[self.graph.nodes], dtype=np.float64)

    def changed(self, log: ScanLog, change: GraphChange) -> SolvedGraph:
        """Return the solution after a manual change (worker thread).

        Raises :class:`ConfigError` for an unknown edge or candidate, and like :func:`mapper.slam.optimise`.
        """
        options = GraphOptions(
            self.options.robust if change.robust is None else change.robust,
            self.options.robust_scale if change.robust_scale is None else change.robust_scale,
        )
        graph = self.graph
        if change.reset:
            return replace(self, graph=self.first, options=GraphOptions(), is_changed=False)
        if change.remove is not None:
            graph = graph.without_edge(change.remove)
        if change.lock is not None:
            graph = graph.with_lock(change.lock, locked=True)
        if change.unlock is not None:
            graph = graph.with_lock(change.unlock, locked=False)
        if change.add is not None:
            graph = self._with_loop(graph, log, *change.add)
        return self.solved(graph, options)

    def _with_loop(self, graph: PoseGraph, log: ScanLog, first: int, second: int) -> PoseGraph:
        """Return the graph with a locked loop between two scans, obtained by matching them."""
        if not all(0 <= scan < log.n_scans for scan in (first, second)):
            raise ConfigError("graph.scans", f"The log has {log.n_scans} scans, not both {first} and {second}.")
        i, j = sorted(self._node_near(scan) for scan in (first, second))
        if j - i < 2:
            raise ConfigError("graph.scans", f"The scans {first} and {second} are consecutive: no loop can join them.")
        poses = self.node_poses
        scans = scans_of(log, graph.nodes[[i, j]].tolist())
        guess = compose(inverse(poses[i]), poses[j])
        match = match_scan(scans, 1, scan_target(scans, 0), guess, MatchConfig(window_m=WINDOW))
        if match.score < LEAST_SCORE:
            raise ConfigError(
                "graph.no_match",
                f"The scans {first} and {second} do not fit anywhere within {WINDOW:g} m: the best agreement is "
                f"{100 * match.score:.0f} %.",
            )
        if match.is_degenerate:
            raise ConfigError(
                "graph.no_match",
                f"The walls of the scans {first} and {second} leave one direction undetermined, as in a corridor.",
            )
        information = np.linalg.inv(match.covariance + np.diag(np.square(LEAST_DEVIATIONS)))
        return graph.with_loop(i, j, match.pose, information, locked=True)

    def _node_near(self, scan: int) -> int:
        """Return the row of the node with the nearest scan number."""
        return int(np.abs(self.graph.nodes - scan).argmin())

    def draw(self, layer: GraphLayer) -> None:
        """Write nodes and edges. An edge's value is a loop's residual in standard deviations, NaN for odometry."""
        graph = self.graph
        poses = self.node_poses
        values = np.where(graph.kind == LOOP, graph.residual, np.nan)
        nodes = np.stack([*poses.T, graph.nodes.astype(np.float64)])
        layer.set(nodes, np.stack([graph.i, graph.j], axis=1), values)

    def in_3d(self) -> tuple[ShownLoops, Segments]:
        """Return the loops, and their drawing, coloured by residual."""
        graph = self.graph
        edges = np.flatnonzero(graph.kind == LOOP)
        nodes = np.stack([graph.i[edges], graph.j[edges]], axis=1)
        ends = np.concatenate([self.node_poses[nodes][..., :2], np.full((len(edges), 2, 1), LOOP_Z)], axis=2)
        colors = LOOP_COLOURS[np.searchsorted((STRAINED, CONTRADICTS), graph.residual[edges], side="right")]
        return ShownLoops(edges, ends), Segments(
            name="loops",
            label="Loops",
            points=ends.astype(np.float32),
            colors=np.repeat(colors[:, None], 2, axis=1),
            width=3.0,
        )

    def public(self) -> PoseGraphAnswer:
        """Return the answer of the HTTP interface: the loops, worst first, and how the graph is solved."""
        graph = self.graph
        loops = np.flatnonzero(graph.kind == LOOP)
        order = loops[np.argsort(-graph.residual[loops], kind="stable")]
        return PoseGraphAnswer(
            trajectory=self.trajectory,
            nodes=len(graph.nodes),
            odometry=int(len(graph.i) - len(loops)),
            loops=[self._loop(int(edge)) for edge in order],
            tried=len(self.candidates),
            robust=self.options.robust,
            robust_scale=self.options.robust_scale,
            changed=self.is_changed,
        )

    def _loop(self, edge: int) -> LoopAnswer:
        graph = self.graph
        i, j = int(graph.i[edge]), int(graph.j[edge])
        return LoopAnswer(
            edge=edge,
            scans=(int(graph.nodes[i]), int(graph.nodes[j])),
            residual=round(float(graph.residual[edge]), 3),
            weight=round(float(graph.weight[edge]), 3),
            locked=bool(graph.locked[edge]),
        )

    def pair(self, log: ScanLog, i: int, j: int, relative: Float64Array | None) -> ScanPair:
        """Return the scans of the nodes i and j in the map: at their poses, and with j aligned by ``relative``.

        Points are map metres. Without ``relative``, which is ``Tᵢ⁻¹ ∘ Tⱼ``, there is no third list.
        """
        poses = self.node_poses
        aligned = None if relative is None else self._points(log, j, compose(poses[i], relative))
        points = ScanPoints(self._points(log, i, poses[i]), self._points(log, j, poses[j]), aligned)
        both = [(float(x), float(y), float(yaw)) for x, y, yaw in np.round(poses[[i, j]], 4)]
        return ScanPair(both, points)

    def _points(self, log: ScanLog, node: int, pose: Float64Array) -> list[tuple[float, float]]:
        scan = int(self.graph.nodes[node])
        scans = scans_of(log, [scan])
        points = scans.points[0][scans.kind[0] != NO_POINT].astype(np.float64)
        in_map = transform_points(pose, points[:: max(1, -(-len(points) // MAX_POINTS))])
        return [(float(x), float(y)) for x, y in np.round(in_map, 3)]

    def edge(self, log: ScanLog, edge: int) -> EdgeAnswer:
        """Return one edge with both of its scans. Raises :class:`ConfigError` for an unknown edge."""
        graph = self.graph
        self.check_edge(edge)
        i, j, relative = int(graph.i[edge]), int(graph.j[edge]), graph.relative[edge]
        constraint = self._constraint(edge, residuals(graph, self.node_poses)[edge])
        tried = np.flatnonzero((self.candidates.j == j) & self.candidates.accepted)
        score = float(self.candidates.score[tried[0]]) if len(tried) else None
        inliers = float(self.candidates.inliers[tried[0]]) if len(tried) else None
        pair = self.pair(log, i, j, relative)
        return EdgeAnswer(
            **asdict(constraint),
            score=None if score is None else round(score, 3),
            inliers=None if inliers is None else round(inliers, 3),
            poses=pair.poses,
            points=pair.points,
        )

    def _constraint(self, edge: int, off: Float64Array) -> ConstraintAnswer:
        """Return an edge without its scans; ``off`` (3,) is its row of :func:`residuals`."""
        return ConstraintAnswer(
            **asdict(self._loop(edge)),
            kind="loop" if self.graph.kind[edge] == LOOP else "odometry",
            off_m=round(float(np.hypot(off[0], off[1])), 4),
            off_deg=round(math.degrees(float(off[2])), 3),
        )

    def constraints(self, scan: int) -> ScanConstraints:
        """Return the edges of the node nearest to a scan. Raises :class:`ConfigError` for an unknown scan."""
        if not 0 <= scan < len(self.slam_poses):
            raise ConfigError("graph.scans", f"The log has {len(self.slam_poses)} scans; there is no number {scan}.")
        graph, node = self.graph, self._node_near(scan)
        edges = np.flatnonzero((graph.i == node) | (graph.j == node))
        edges = edges[np.argsort(-graph.residual[edges], kind="stable")]
        off = residuals(graph, self.node_poses)
        return ScanConstraints(int(graph.nodes[node]), [self._constraint(int(edge), off[edge]) for edge in edges])

    def check_edge(self, edge: int) -> None:
        """Raise :class:`ConfigError` for an unknown edge."""
        if not 0 <= edge < len(self.graph.i):
            raise ConfigError("graph.edge", f"The graph has {len(self.graph.i)} edges; there is no number {edge}.")

    def residuals(self, log: ScanLog) -> Series:
        """Return the residuals of the graph's measurements at the poses of the map over time."""
        return residual_series(self.graph, self.node_poses, plot_stamps(log)[self.graph.nodes])

    def near(self, x: float, y: float) -> TriedNear:
        """Return the loops tried near (x, y), map metres, the nearest first, and why they were rejected.

        ``visits`` are the runs of scans near the place, and ``pair`` the nearest scans of the first and the last run.
        """
        poses, tried = self.node_poses, self.candidates
        places = np.stack([poses[tried.i, :2], poses[tried.j, :2]])
        away = np.hypot(places[..., 0] - x, places[..., 1] - y).min(axis=0)
        order = np.argsort(away, kind="stable")[:NEAREST]
        distance = np.hypot(poses[:, 0] - x, poses[:, 1] - y)
        visits = _visits(self.graph.nodes[distance < RADIUS])
        pair = None
        if len(visits) > 1:
            ends = [self.graph.nodes[self._nearest_of(visit, distance)] for visit in (visits[0], visits[-1])]
            pair = (int(ends[0]), int(ends[1]))
        candidates = [self._candidate(int(k), float(away[k])) for k in order if away[k] <= RADIUS]
        return TriedNear(visits, pair, candidates)

    def _nearest_of(self, visit: tuple[int, int], distance: Float64Array) -> int:
        """Return the nearest node of a visit (its first and last scan); ``distance`` (m,) is that of all nodes."""
        rows = np.flatnonzero((self.graph.nodes >= visit[0]) & (self.graph.nodes <= visit[1]))
        return int(rows[distance[rows].argmin()])

    def _candidate(self, k: int, away: float) -> TriedLoop:
        tried = self.candidates
        i, j = int(tried.i[k]), int(tried.j[k])
        return TriedLoop(
            candidate=k,
            scans=(int(self.graph.nodes[i]), int(self.graph.nodes[j])),
            away_m=round(away, 2),
            score=round(float(tried.score[k]), 3),
            inliers=round(float(tried.inliers[k]), 3),
            accepted=bool(tried.accepted[k]),
            reason=tried.reason[k],
        )

    def candidate(self, log: ScanLog, k: int) -> TriedLoopScans:
        """Return a tried loop with both of its scans. Raises :class:`ConfigError` for an unknown one."""
        if not 0 <= k < len(self.candidates):
            raise ConfigError("graph.candidate", f"{len(self.candidates)} loops were tried; there is no number {k}.")
        i, j = int(self.candidates.i[k]), int(self.candidates.j[k])
        loop, pair = self._candidate(k, 0.0), self.pair(log, i, j, None)
        return TriedLoopScans(
            loop.candidate, loop.scans, loop.away_m, loop.score, loop.inliers, loop.accepted, loop.reason,
            pair.poses, pair.points,
        )  # fmt: skip

    def in_log(self, log: ScanLog) -> ScanLog:
        """Return ``log`` with the current poses as the graph's trajectory."""
        known = log.trajectory(self.trajectory)
        changed = replace(known, poses=self.poses, timed=None)
        return replace(log, trajectories={**log.trajectories, self.trajectory: changed})


def _visits(scans: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return the runs [first, last] of scan numbers with gaps of fewer than 50."""
    if not len(scans):
        return []
    cuts = np.flatnonzero(np.diff(scans) > 50)
    return [
        (int(a), int(b)) for a, b in zip(scans[np.r_[0, cuts + 1]], scans[np.r_[cuts, len(scans) - 1]], strict=True)
    ]


class ShowGraph(Struct):
    """Map along the poses of a graph that was solved again."""

    solved: SolvedGraph
