"""Bounds and times of a 3D map before its first scan, and a suitable resolution and display options."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.sampling import sample_rows
from mapper.volume import OctreeFile
from mapper.volume.blocks import BLOCK
from mapper.volume.mesh.faces import CENTRE
from mapper.volume.scans.scan_sequence import ScanSequence, first_in_cubes
from server.parts.volume.look import COLOURS, Look
from server.parts.volume.message_fields import outside

MOST_SCAN_BOX = 1 << 31  #: voxels of the box around one scan: 200 × 200 × 50 m at 10 cm, some seconds
RESOLUTIONS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
POINTS_A_VOXEL = 1.5  #: least average at the initial resolution
VOXELS_ACROSS = 250  #: maximum along the longest side of a map at the initial resolution
UNTIMED_S = 0.5  #: between two scans without times
OUTLIERS = 1.0  #: percentage of the points at each end of an axis that may be outside the bounds
MOST_LOOKED_AT = 500_000  #: maximum number of points for estimating the bounds,
MOST_COUNTED = 100_000  #: and the initial resolution


def map_limits(limits: Limits) -> Limits:
    """Return the limits of a visitor's 3D map, with the visitor's limit of cells as the limit of voxels."""
    blocks = max(64, limits.max_cells // BLOCK**3)
    return replace(DEFAULT_LIMITS, max_blocks=min(DEFAULT_LIMITS.max_blocks, blocks), max_scan_box=MOST_SCAN_BOX)


def bounds_of(source: ScanSequence | OctreeFile) -> tuple[Float64Array, Float64Array]:
    """Return the least and greatest coordinates (3,), metres, of nearly all points, or of an octree's leaves."""
    if isinstance(source, ScanSequence):
        points = source.points[sample_rows(len(source.points), MOST_LOOKED_AT)].astype(np.float64)
        low, high = np.percentile(points, [OUTLIERS, 100.0 - OUTLIERS], axis=0)
        # Outliers may be anywhere; points slightly outside of most others are not outliers.
        margin = 0.25 * (high - low) + 1e-6
        return np.maximum(low - margin, points.min(axis=0)), np.minimum(high + margin, points.max(axis=0))
    keys, depths, values = source.tree.leaves()
    occupied = values >= 0.0
    some = occupied if occupied.any() else np.ones(len(keys), dtype=np.bool_)
    sides = np.int64(1) << (16 - depths[some].astype(np.int64))
    resolution = source.tree.resolution
    first, last = keys[some].min(axis=0), (keys[some] + sides[:, None]).max(axis=0)
    return _metres(first, resolution), _metres(last, resolution)


def _metres(keys: Int64Array, resolution: float) -> Float64Array:
    return (keys - CENTRE).astype(np.float64) * resolution


def times_of(source: ScanSequence | OctreeFile) -> Float64Array:
    """Return the time of each scan, seconds after the first; evenly spaced if there are no times."""
    if not isinstance(source, ScanSequence):
        return np.zeros(1)
    stamps = np.maximum.accumulate(source.stamps_ns)
    if stamps[-1] == stamps[0]:
        return np.arange(len(stamps), dtype=np.float64) * UNTIMED_S
    return np.asarray((stamps - stamps[0]).astype(np.float64) * 1e-9)


def first_resolution(source: ScanSequence | OctreeFile, low: Float64Array, high: Float64Array) -> float:
    """Return the finest usual resolution, metres, at which the map is not too large; for an octree, its own."""
    if not isinstance(source, ScanSequence):
        return source.tree.resolution
    longest, reach = float((high - low).max()), float(np.abs(np.stack([low, high])).max())
    some = source.points[sample_rows(len(source.points), MOST_COUNTED)]
    some = some[((some >= low) & (some <= high)).all(axis=1)]
    for resolution in RESOLUTIONS:
        if longest > VOXELS_ACROSS * resolution or reach > 30_000.0 * resolution:
            continue
        if len(some) >= POINTS_A_VOXEL * len(first_in_cubes(some, resolution)):
            return resolution
    return RESOLUTIONS[-1] if longest > 10.0 * RESOLUTIONS[-1] else RESOLUTIONS[2]


def check_resolution(low: Float64Array, high: Float64Array, resolution: float) -> None:
    """Raise :class:`ConfigError` if points within these bounds (3,) are too far out for a resolution, metres."""
    sides = np.maximum((high - low).astype(np.float64) / resolution, 1.0)
    reach = float(np.abs(np.stack([low, high])).max())
    if reach > CENTRE * resolution or float(sides.max()) > 2 * CENTRE:
        raise ConfigError(
            "volume.resolution",
            f"At {resolution:g} m a voxel the map reaches {CENTRE * resolution:.4g} m from 0 along each axis, and the "
            f"points lie up to {reach:.4g} m from 0; choose a coarser one.",
        )


def first_look(low: Float64Array, high: Float64Array, resolution: float) -> Look:
    """Return a look with colours spread over the heights of the map and cuts at its ends."""
    height = max(float(high[2] - low[2]), resolution)
    band = float(np.clip(np.ceil(height / COLOURS / 0.05) * 0.05, 0.05, 10.0))
    bottom, top = (corner[2] for corner in outside(low, high))
    return Look(band=band, cut_low=bottom, cut_high=top, band_low=bottom, band_high=top)
