"""Parts of the messages of a session that shows a 3D map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, replace

from mapper.core.array_types import Float32Array, Float64Array
from mapper.io.logs.summary import start_s
from mapper.volume import OctreeFile
from mapper.volume.occupancy.provenance import VoxelUpdate
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.look import AXES, LOOK_PARAMETERS, Look
from server.parts.volume.messages import VoxelMessage
from server.stream.message_parts import LogInfo, Table, rows_of
from server.stream.message_parts import VoxelUpdate as SentUpdate

MOST_UPDATES = 200  #: maximum number of updates of a voxel sent


def look_table(first: Look, now: Look, low: Float64Array, high: Float64Array) -> Table:
    """Return the table of display options with the map's ends as bounds, and the current values."""
    ends = outside(low, high)
    rows = [
        replace(row, low=ends[0][axis], high=ends[1][axis]) if (axis := AXES.get(row.name)) is not None else row
        for row in LOOK_PARAMETERS
    ]
    return Table(rows_of(rows, first), asdict(now))


def outside(low: Float64Array, high: Float64Array) -> tuple[list[float], list[float]]:
    """Return the corners of a box around the map, half a metre away, in metres rounded to centimetres."""
    return (low - 0.5).round(2).tolist(), (high + 0.5).round(2).tolist()


def log_info(source: ScanSequence | OctreeFile, log_id: str, topic: str | None, duration_s: float) -> LogInfo:
    """Return the file as a log without planar scans."""
    scans = source if isinstance(source, ScanSequence) else None
    return LogInfo(
        id=log_id,
        topic=topic or "",
        cut=None,
        trajectory="",
        trajectories=[],
        compared=None,
        n_beams=0,
        n_scans=1 if scans is None else len(scans),
        duration_s=0.0 if scans is None or not scans.stamps_ns.any() else duration_s,
        format=f"OctoMap {source.kind}" if isinstance(source, OctreeFile) else source.kind,
        notes=list(source.notes),
        start_s=None if scans is None else start_s(scans.stamps_ns),
    )


def rounded_place(place: Float32Array | Float64Array) -> tuple[float, float, float]:
    """Return a place (3,), metres, rounded for messages."""
    x, y, z = (round(float(value), 4) for value in place)
    return x, y, z


def no_voxel(size: float) -> VoxelMessage:
    """Return the ``voxel`` message for no voxel; ``size`` is the side of a voxel, metres."""
    return VoxelMessage(centre=None, size=size, log_odds=None, state="unknown", index=0, total=0, hits=0, updates=[])


def sent_updates(updates: Sequence[VoxelUpdate]) -> list[SentUpdate]:
    """Return the newest updates of a voxel as fields of the ``voxel`` message."""
    return [
        SentUpdate(
            scan=update.scan + 1,
            hit=update.is_hit,
            beams=update.beams,
            before=None if math.isnan(update.before) else update.before,
            after=update.after,
        )
        for update in updates[-MOST_UPDATES:]
    ]
