"""Summary and picture of a map for the library."""

from __future__ import annotations

from mapper.core.array_types import UInt8Array
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD
from mapper.io.logs.summary import LogSummary, MapSummary, ReadingCounts
from mapper.replay.overview import cells_overview
from server.library.packs.reference_map import ReferenceMap

FORMAT = "map"


def summarise_map(given: ReferenceMap) -> LogSummary:
    """Return the figures of a map: a record without scans."""
    geometry = given.geometry
    return LogSummary(
        name=given.title,
        format=FORMAT,
        scans=0,
        beams=0,
        duration_s=0.0,
        field_of_view_deg=0.0,
        angle_min=0.0,
        angle_increment=0.0,
        range_max=0.0,
        mount=(0.0, 0.0, 0.0),
        readings=ReadingCounts(0, 0, 0),
        trajectories=(),
        notes=given.notes,
        map=MapSummary(geometry.rows, geometry.cols, geometry.resolution),
    )


def map_codes(given: ReferenceMap) -> UInt8Array:
    """Return the codes of a picture of a map, for its card."""
    values = given.values
    return cells_overview((values >= 0) & (values < 100 * FREE_THRESHOLD), values > 100 * OCCUPIED_THRESHOLD)
