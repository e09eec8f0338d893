"""The messages ``volume`` and ``voxel`` of a session that shows a map in 3D."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array
from mapper.io.logs.summary import start_s
from mapper.volume import OctreeFile
from mapper.volume.occupancy.provenance import VoxelUpdate
from mapper.volume.scans.replayed import ReplayedVolume
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.drawings import VolumeDrawings
from server.parts.volume.look import HEIGHTS, LOOK_PARAMETERS, Look

MOST_UPDATES = 200  #: of a voxel that are sent


def look_table(first: Look, now: Look, low: Float64Array, high: Float64Array) -> dict[str, Any]:
    """Return the table of what is shown, with the heights of the map as bounds, and the present values."""
    bottom, top = round(float(low[2]) - 0.5, 2), round(float(high[2]) + 0.5, 2)
    rows = []
    for row in LOOK_PARAMETERS:
        fields = asdict(row) | {"initial": getattr(first, row.name)}
        rows.append(fields | ({"low": bottom, "high": top} if row.name in HEIGHTS else {}))
    return {"table": rows, "values": asdict(now)}


def volume_message(
    now: ReplayedVolume, drawn: VolumeDrawings, low: Float64Array, high: Float64Array, more: dict[str, Any]
) -> dict[str, Any]:
    """Return the message ``volume``; ``more`` has the fields that are not of the map and its drawings."""
    volume, source = now.volume, now.source
    scans = source if isinstance(source, ScanSequence) else None
    occupied, free = volume.count_states()
    sides = np.maximum(np.ceil((high - low) / now.config.resolution), 1.0)
    chunks = drawn.faces.chunks
    return {
        "type": "volume",
        "low": low.tolist(),
        "high": high.tolist(),
        "has_scans": scans is not None,
        "points": len(source.tree.masks) if not isinstance(source, ScanSequence) else int(source.starts[now.index]),
        "left_out": now.inserted.left_out,
        "occupied": occupied,
        "free": free,
        "bytes": volume.n_bytes,
        "dense_bytes": 4.0 * float(np.prod(sides)),
        "chunks": len(chunks),
        "quads": sum(len(one) for one in chunks.values()),
        "pending": drawn.pending,
        "colours": [] if scans is None else ["own colour" if name == "rgb" else name for name in scans.fields],
        **more,
    }


def log_fields(source: ScanSequence | OctreeFile, log_id: str, topic: str | None, duration_s: float) -> dict[str, Any]:
    """Return the file as a log without planar scans."""
    scans = source if isinstance(source, ScanSequence) else None
    return {
        "id": log_id,
        "topic": topic or "",
        "cut": None,
        "trajectory": "",
        "trajectories": [],
        "n_beams": 0,
        "n_scans": 1 if scans is None else len(scans),
        "duration_s": 0.0 if scans is None or not scans.stamps_ns.any() else duration_s,
        "format": f"OctoMap {source.kind}" if isinstance(source, OctreeFile) else source.kind,
        "notes": list(source.notes),
        "start_s": None if scans is None else start_s(scans.stamps_ns),
    }


def voxel_message(centre: Float32Array | None, size: float) -> dict[str, Any]:
    """Return the message ``voxel`` without an answer; ``centre`` (3,) is None where no voxel is chosen."""
    return {
        "type": "voxel",
        "centre": None if centre is None else [round(float(v), 4) for v in centre],
        "size": size,
        "log_odds": None,
        "state": "unknown",
        "index": 0,
        "total": 0,
        "hits": 0,
        "updates": [],
    }


def update_fields(updates: Sequence[VoxelUpdate]) -> dict[str, Any]:
    """Return the fields of the message ``voxel`` on what the scans did to the voxel."""
    return {
        "total": len(updates),
        "hits": sum(one.is_hit for one in updates),
        "updates": [
            {
                "scan": one.scan + 1,
                "hit": one.is_hit,
                "beams": one.beams,
                "before": None if math.isnan(one.before) else one.before,
                "after": one.after,
            }
            for one in updates[-MOST_UPDATES:]
        ],
    }
