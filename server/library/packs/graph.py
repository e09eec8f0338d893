"""The pose graph of a trajectory, with the loops that were tried, as a compressed file of arrays."""

from __future__ import annotations

import io
import json
from dataclasses import fields

import numpy as np

from mapper.core.errors import ReadError
from mapper.sensors.pose_graph import PoseGraph
from mapper.slam import LoopCandidates
from server.library.packs.arrays import UNREADABLE, about_array, compressed_arrays

VERSION = 1
_GRAPH = tuple(field.name for field in fields(PoseGraph))
_TRIED = ("i", "j", "score", "inliers", "accepted")


def graph_bytes(graph: PoseGraph, candidates: LoopCandidates) -> bytes:
    """Return the file of a graph and of the loops that were tried."""
    about = json.dumps({"version": VERSION, "reasons": list(candidates.reason)})
    return compressed_arrays(
        {"about": about_array(about)}
        | {f"graph_{name}": getattr(graph, name) for name in _GRAPH}
        | {f"tried_{name}": getattr(candidates, name) for name in _TRIED}
    )


def read_graph(data: bytes) -> tuple[PoseGraph, LoopCandidates]:
    """Return what was passed to :func:`graph_bytes`. Raises :class:`ReadError` for anything else."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about["version"] != VERSION:
                raise ValueError(f"version {about['version']}")
            graph = PoseGraph(**{name: arrays[f"graph_{name}"] for name in _GRAPH})
            tried = {name: arrays[f"tried_{name}"] for name in _TRIED}
            return graph, LoopCandidates(**tried, reason=tuple(map(str, about["reasons"])))
    except UNREADABLE as error:
        raise ReadError("graph.file", "The file of this pose graph cannot be read; run SLAM again.") from error
