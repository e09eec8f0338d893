"""A pose graph as SLAM left it and as changes by hand leave it: solved, drawn, and questioned."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points, wrap_angle
from mapper.sensors.pose_graph import LOOP, PoseGraph
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.slam import LoopCandidates, optimise
from server.sessions.view import GraphChange
from server.stream.layers import GraphLayer

KERNELS = ("geman_mcclure", "cauchy", "huber", "none")
SCALES = (0.5, 50.0)  #: least and greatest scale of the kernel, in standard deviations
NEAREST = 12  #: candidates that are listed for a place
RADIUS = 3.0  #: metres around a place in which they are looked for
MAX_POINTS = 720  #: of one scan that is drawn

Float64Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GraphOptions:
    """How the graph is solved: the robust kernel of its loops and its scale, in standard deviations."""

    robust: str = "geman_mcclure"
    robust_scale: float = 3.0

    def __post_init__(self) -> None:
        if self.robust not in KERNELS:
            raise ConfigError("graph.robust", f"The kernel {self.robust!r:.40} is none of {', '.join(KERNELS)}.")
        if not (math.isfinite(self.robust_scale) and SCALES[0] <= self.robust_scale <= SCALES[1]):
            raise ConfigError("graph.robust_scale", f"The scale of the kernel must be {SCALES[0]:g} to {SCALES[1]:g}.")


@dataclass(frozen=True, slots=True)
class SolvedGraph:
    """A graph as SLAM left it, and as changes by hand leave it.

    ``trajectory`` is the name of the trajectory that was made with it, ``healed`` (n_scans, 3) its poses as SLAM left
    them, which a joint refinement has moved from the solution of the graph. A change by hand moves each pose as much as
    it moves the solution: with no change the trajectory is the healed one.
    """

    trajectory: str
    healed: Float64Array
    first: PoseGraph  #: the solution without changes
    graph: PoseGraph  #: the present solution
    candidates: LoopCandidates
    options: GraphOptions
    is_changed: bool = False

    @classmethod
    def of(cls, trajectory: str, healed: Float64Array, graph: PoseGraph, candidates: LoopCandidates) -> SolvedGraph:
        """Solve a graph as SLAM left it (worker thread). Raises as :func:`mapper.slam.optimise`."""
        options = GraphOptions()
        solved = optimise(graph, robust=options.robust, robust_scale=options.robust_scale)
        return cls(trajectory, healed, solved, solved, candidates, options)

    def solved(self, graph: PoseGraph, options: GraphOptions) -> SolvedGraph:
        """Return the solution of another graph of the same nodes (worker thread).

        Raises as :func:`mapper.slam.optimise`.
        """
        found = optimise(graph, robust=options.robust, robust_scale=options.robust_scale)
        return replace(self, graph=found, options=options, is_changed=True)

    @property
    def poses(self) -> Float64Array:
        """Return the poses of all scans (n_scans, 3), ``T_map_base``."""
        if self.graph is self.first:
            return self.healed
        nodes = self.graph.nodes
        moved = compose(self.graph.poses, inverse(self.first.poses))  # of the map, at each node
        scans = np.arange(len(self.healed))
        before = np.clip(np.searchsorted(nodes, scans, side="right") - 1, 0, len(nodes) - 1)
        return compose(moved[before], self.healed)

    @property
    def node_poses(self) -> Float64Array:
        """Return the poses of the nodes (m, 3), as the map has them."""
        return np.asarray(self.poses[self.graph.nodes], dtype=np.float64)

    def changed(self, change: GraphChange) -> SolvedGraph:
        """Return the solution after a change by hand (worker thread).

        Raises :class:`ConfigError` for an edge or a candidate that there is not, and as
        :func:`mapper.slam.optimise`.
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
        return self.solved(graph, options)

    def draw(self, layer: GraphLayer) -> None:
        """Write nodes and edges; the value of an edge is a loop's residual in standard deviations, NaN of odometry."""
        graph = self.graph
        poses = self.node_poses
        values = np.where(graph.kind == LOOP, graph.residual, np.nan)
        nodes = np.stack([*poses.T, graph.nodes.astype(np.float64)])
        layer.set(nodes, np.stack([graph.i, graph.j], axis=1), values)

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows: the loops, worst first, and how the graph is solved."""
        graph = self.graph
        loops = np.flatnonzero(graph.kind == LOOP)
        order = loops[np.argsort(-graph.residual[loops], kind="stable")]
        return {
            "trajectory": self.trajectory,
            "nodes": len(graph.nodes),
            "odometry": int(len(graph.i) - len(loops)),
            "loops": [self._loop(int(edge)) for edge in order],
            "tried": len(self.candidates),
            "robust": self.options.robust,
            "robust_scale": self.options.robust_scale,
            "changed": self.is_changed,
        }

    def _loop(self, edge: int) -> dict[str, Any]:
        graph = self.graph
        i, j = int(graph.i[edge]), int(graph.j[edge])
        return {
            "edge": edge,
            "scans": [int(graph.nodes[i]), int(graph.nodes[j])],
            "residual": round(float(graph.residual[edge]), 3),
            "weight": round(float(graph.weight[edge]), 3),
            "locked": bool(graph.locked[edge]),
        }

    def pair(self, log: ScanLog, i: int, j: int, relative: Float64Array | None) -> dict[str, Any]:
        """Return the scans of the nodes i and j in the map: as the poses have them, and as ``relative`` aligns j.

        Points are map metres; without ``relative``, which is ``Tᵢ⁻¹ ∘ Tⱼ``, there is no third list.
        """
        poses = self.node_poses
        found = {"i": self._points(log, i, poses[i]), "j": self._points(log, j, poses[j])}
        if relative is not None:
            found["aligned"] = self._points(log, j, compose(poses[i], relative))
        return {"poses": [np.round(poses[k], 4).tolist() for k in (i, j)], "points": found}

    def _points(self, log: ScanLog, node: int, pose: Float64Array) -> list[list[float]]:
        ranges = log.ranges[int(self.graph.nodes[node])]
        seen = np.flatnonzero((ranges >= log.range_min) & (ranges <= log.range_max) & (ranges > 0.0))
        seen = seen[:: max(1, -(-len(seen) // MAX_POINTS))]
        angles, r = log.angles[seen], ranges[seen].astype(np.float64)
        points = np.stack([r * np.cos(angles), r * np.sin(angles)], axis=1)
        in_map = transform_points(compose(pose, np.array(log.mount)), points)
        return [[float(x), float(y)] for x, y in np.round(in_map, 3)]

    def edge(self, log: ScanLog, edge: int) -> dict[str, Any]:
        """Return one edge with both of its scans. Raises :class:`ConfigError` for an edge that there is not."""
        graph = self.graph
        if not 0 <= edge < len(graph.i):
            raise ConfigError("graph.edge", f"The graph has {len(graph.i)} edges; there is no number {edge}.")
        i, j, relative = int(graph.i[edge]), int(graph.j[edge]), graph.relative[edge]
        poses = self.node_poses
        off = compose(inverse(relative), compose(inverse(poses[i]), poses[j]))
        tried = np.flatnonzero((self.candidates.j == j) & self.candidates.accepted)
        score = float(self.candidates.score[tried[0]]) if len(tried) else None
        inliers = float(self.candidates.inliers[tried[0]]) if len(tried) else None
        return (
            self._loop(edge)
            | {
                "kind": "loop" if graph.kind[edge] == LOOP else "odometry",
                "off_m": round(float(np.hypot(off[0], off[1])), 4),
                "off_deg": round(math.degrees(float(wrap_angle(off[2]))), 3),
                "score": None if score is None else round(score, 3),
                "inliers": None if inliers is None else round(inliers, 3),
            }
            | self.pair(log, i, j, relative)
        )

    def near(self, x: float, y: float) -> dict[str, Any]:
        """Return which loops were tried near (x, y), map metres, the nearest first, and what refused them."""
        poses, tried = self.node_poses, self.candidates
        ends = np.stack([poses[tried.i, :2], poses[tried.j, :2]]) if len(tried) else np.zeros((2, 0, 2))
        away = np.hypot(ends[..., 0] - x, ends[..., 1] - y).min(axis=0)
        order = np.argsort(away, kind="stable")[:NEAREST]
        visits = np.flatnonzero(np.hypot(poses[:, 0] - x, poses[:, 1] - y) < RADIUS)
        return {
            "visits": _visits(self.graph.nodes[visits]),
            "candidates": [self._candidate(int(k), float(away[k])) for k in order if away[k] <= RADIUS],
        }

    def _candidate(self, k: int, away: float) -> dict[str, Any]:
        tried = self.candidates
        i, j = int(tried.i[k]), int(tried.j[k])
        return {
            "candidate": k,
            "scans": [int(self.graph.nodes[i]), int(self.graph.nodes[j])],
            "away_m": round(away, 2),
            "score": round(float(tried.score[k]), 3),
            "inliers": round(float(tried.inliers[k]), 3),
            "accepted": bool(tried.accepted[k]),
            "reason": tried.reason[k],
        }

    def candidate(self, log: ScanLog, k: int) -> dict[str, Any]:
        """Return a loop that was tried, with both of its scans. Raises :class:`ConfigError` for one that was not."""
        if not 0 <= k < len(self.candidates):
            raise ConfigError("graph.candidate", f"{len(self.candidates)} loops were tried; there is no number {k}.")
        i, j = int(self.candidates.i[k]), int(self.candidates.j[k])
        return self._candidate(k, 0.0) | self.pair(log, i, j, None)

    def in_log(self, log: ScanLog) -> ScanLog:
        """Return ``log`` with the present poses as the trajectory that the graph belongs to."""
        known = log.trajectory(self.trajectory)
        changed = Trajectory(self.poses, known.description, known.frame_id, known.child_frame_id)
        return replace(log, trajectories={**log.trajectories, self.trajectory: changed})


def _visits(scans: NDArray[np.int64]) -> list[list[int]]:
    """Return the runs [first, last] of scan numbers with fewer than 50 between one and the next."""
    if not len(scans):
        return []
    cuts = np.flatnonzero(np.diff(scans) > 50)
    return [
        [int(a), int(b)] for a, b in zip(scans[np.r_[0, cuts + 1]], scans[np.r_[cuts, len(scans) - 1]], strict=True)
    ]
