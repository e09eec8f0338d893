"""The score of the poses around a loop of a pose graph, which shows how certain the loop is."""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, wrap_angle
from mapper.matching.parameters import MatchConfig
from mapper.matching.search import score_landscape
from mapper.matching.target import Target
from mapper.sensors.scan import ScanLog
from mapper.slam.scan_store import scans_of
from server.parts.slam.solved_graph import SolvedGraph
from server.sessions.graph_answers import PoseTuple, ScoreLandscape

#: ± 1 m in cells of 5 cm, ± 20° in steps of 2°: 35,301 poses, a few hundredths of a second for a scan of 360 beams.
WINDOW_M, CELL_M, WINDOW_RAD, STEP_RAD = 1.0, 0.05, math.radians(20.0), math.radians(2.0)
CONFIG = MatchConfig(
    method="exhaustive", window_m=WINDOW_M, window_rad=WINDOW_RAD, field_resolution=CELL_M, field_sigma=0.08,
    turn_step=STEP_RAD,
)  # fmt: skip


def landscape_of(solved: SolvedGraph, log: ScanLog, edge: int) -> ScoreLandscape:
    """Return the score of an edge's later scan at the poses around the edge's measurement.

    Raises :class:`mapper.core.errors.ConfigError` for an unknown edge, and for scans without points.
    """
    graph = solved.graph
    solved.check_edge(edge)
    i, j = int(graph.i[edge]), int(graph.j[edge])
    poses = solved.node_poses
    scans = scans_of(log, graph.nodes[[i, j]].tolist())
    target = Target(scans, np.zeros(1, dtype=np.int64), np.stack([poses[i], poses[i]]))
    centre = compose(poses[i], graph.relative[edge])
    landscape = score_landscape(scans, 1, target, centre, CONFIG)
    present = np.array([*poses[j, :2], centre[2] + wrap_angle(poses[j, 2] - centre[2])])
    return ScoreLandscape(
        edge=edge,
        cell_m=CELL_M,
        turn_deg=math.degrees(STEP_RAD),
        size=len(landscape.offsets),
        scores=np.rint(100.0 * landscape.greatest).astype(np.int64).ravel().tolist(),
        turn_of=landscape.turn_of.ravel().tolist(),
        by_turn=np.rint(100.0 * landscape.by_turn).astype(np.int64).tolist(),
        centre=rounded(centre),
        present=rounded(present),
    )


def rounded(pose: Float64Array) -> PoseTuple:
    """Return a pose (3,) with four decimals."""
    x, y, yaw = np.round(pose, 4).tolist()
    return x, y, yaw
