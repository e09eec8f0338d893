"""The pose graph of two merged logs, for the log that has the scans of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.sensors.pose_graph import PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam.merge import MergedLogs
from mapper.slam.result import LoopCandidates


def merged_graph(logs: tuple[ScanLog, ScanLog], merged: MergedLogs) -> tuple[PoseGraph, LoopCandidates]:
    """Return the graph of both logs, numbered as the scans of :func:`mapper.slam.merged_log`, and all loops tried.

    These are the loops that were tried within each log, and those from scans of the second one to the first.
    """
    graph, split = merged.graph, merged.split
    n = len(graph.nodes)
    own = [
        replace(one.candidates, i=one.candidates.i + shift, j=one.candidates.j + shift)
        for one, shift in zip(merged.results, (0, split), strict=True)
    ]
    parts = [*own, merged.tried]
    i, j, score, inliers, accepted = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("i", "j", "score", "inliers", "accepted")
    )
    nodes, rows = graph.nodes, np.arange(n)
    if int(logs[1].stamps_ns.max()) < int(logs[0].stamps_ns.min()):  # the second log's scans are first there
        rows = (rows + n - split) % n
        is_second = nodes >= logs[0].n_scans
        nodes = np.where(is_second, nodes - logs[0].n_scans, nodes + logs[1].n_scans)
    order = np.argsort(rows)
    return (
        replace(graph, nodes=nodes[order], poses=graph.poses[order], i=rows[graph.i], j=rows[graph.j]),
        LoopCandidates(rows[i], rows[j], score, inliers, accepted, tuple(one for part in parts for one in part.reason)),
    )
