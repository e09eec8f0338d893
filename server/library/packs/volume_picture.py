"""The picture of a cloud or an octree on its card: seen from above, coloured by height."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mapper.core.array_types import Float32Array
from mapper.volume.occupancy.volume import centres_of
from mapper.volume.scans.scan_sequence import UPS, ScanSequence
from server.library.packs.picture import HEIGHTS, write_codes
from server.library.packs.volume import VolumeSource

SIDE = 320  #: pixels along the longer side
MOST_POINTS = 400_000
OUTLIERS = 0.5  #: per cent of the points at each end of an axis that may lie outside the picture


def write_volume_picture(source: VolumeSource, path: Path) -> bool:
    """Draw ``source`` into the file ``path``; return whether there was something to draw. Raises :class:`OSError`."""
    points = _points(source)
    if not len(points):
        return False
    low, high = np.percentile(points, [OUTLIERS, 100.0 - OUTLIERS], axis=0)
    size = float(max(high[0] - low[0], high[1] - low[1], 1e-3)) / (SIDE - 8)
    cols, rows = (int(np.ceil((high[k] - low[k]) / size)) + 8 for k in (0, 1))
    col = np.floor((points[:, 0] - low[0]) / size).astype(np.int64) + 4
    row = rows - 1 - (np.floor((points[:, 1] - low[1]) / size).astype(np.int64) + 4)
    inside = (col >= 0) & (col < cols) & (row >= 0) & (row < rows)
    share = (points[:, 2] - low[2]) / max(float(high[2] - low[2]), 1e-6)
    first, count = HEIGHTS
    codes = np.zeros((rows, cols), dtype=np.uint8)
    colours = (first + np.clip(share * count, 0, count - 1)).astype(np.uint8)
    np.maximum.at(codes, (row[inside], col[inside]), colours[inside])
    write_codes(codes, path)
    return True


def _points(source: VolumeSource) -> Float32Array:
    """Return at most :data:`MOST_POINTS` points (n, 3), or centres of an octree's occupied leaves, metres."""
    if isinstance(source, ScanSequence):
        points = source.points[:: -(-len(source.points) // MOST_POINTS)]
        return np.asarray(points @ np.array(UPS[source.first_up], dtype=np.float32).T)
    keys, depths, values = source.tree.leaves()
    sides = np.int64(1) << (16 - depths.astype(np.int64))
    occupied = values >= 0.0
    middles = keys[occupied] + sides[occupied, None] // 2
    return centres_of(middles[:: max(1, -(-len(middles) // MOST_POINTS))], source.tree.resolution)
