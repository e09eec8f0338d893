"""Summary and picture of a map for the library. They need the replay, and are only used in readings."""

from __future__ import annotations

from dataclasses import replace

from mapper.core.array_types import UInt8Array
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD
from mapper.io.logs.summary import NO_SCANS, LogSummary, MapSummary
from mapper.replay.overview import cells_overview
from server.library.packs.reference_map import ReferenceMap

FORMAT = "map"


def summarise_map(reference: ReferenceMap) -> LogSummary:
    """Return the figures of a map: a record without scans."""
    geometry = reference.geometry
    return replace(
        NO_SCANS,
        name=reference.title,
        format=FORMAT,
        notes=reference.notes,
        map=MapSummary(geometry.rows, geometry.cols, geometry.resolution),
    )


def map_codes(reference: ReferenceMap) -> UInt8Array:
    """Return the codes of a map's picture for its card."""
    values = reference.values
    return cells_overview((values >= 0) & (values < 100 * FREE_THRESHOLD), values > 100 * OCCUPIED_THRESHOLD)
