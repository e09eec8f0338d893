"""Offset of maps of georeferenced clouds: file coordinates minus map coordinates.

Projected coordinates are millions of metres, which exceeds a voxel lattice and the resolution of float32.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.sampling import sample_rows
from mapper.grid.occupancy_grid import OccupancyGrid
from mapper.volume.placed_scan import PlacedScan

FAR_M = np.array([1000.0, 1000.0, 100.0])  #: a cloud this far from 0, x y z, is moved to it: float32 has steps of 0.5 m
#: at a northing of 5,400 km, and airborne scans are taken hundreds of metres up
OFFSET_STEP_M = 100.0


def offset_of(points: NDArray[np.floating[Any]]) -> Float64Array:
    """Return the shift of points (n, 3) towards 0: a multiple of 100 m, and 0 unless they are far from it."""
    middle = np.median(points[sample_rows(len(points), 10_000)], axis=0).astype(np.float64)
    return np.where(np.abs(middle) > FAR_M, np.round(middle / OFFSET_STEP_M) * OFFSET_STEP_M, 0.0)


def offset_notes(offset: Float64Array | None) -> list[str]:
    """Return a sentence on a map shifted by −``offset`` (3,); none for an unshifted map."""
    if offset is None or not offset.any():
        return []
    place = ", ".join(f"{value:,.0f}" for value in offset)
    return [f"The map’s origin is at {place} m of the file: its coordinates are far from 0."]


@dataclass(slots=True)
class MapOffset:
    """Offset (3,) of a map, metres, determined by the first points placed with it; None before."""

    value: Float64Array | None = None

    def placed(self, scans: Iterator[PlacedScan]) -> Iterator[PlacedScan]:
        """Yield scans with points and sensor position in the map."""
        for scan in scans:
            if self.value is None and len(scan.points):
                self.value = offset_of(scan.points)
            shift = self.value
            if shift is None or not shift.any():
                yield scan
            else:
                origin = None if scan.origin is None else scan.origin - shift
                yield replace(scan, points=scan.points - shift, origin=origin)


def georeferenced(grid: OccupancyGrid, offset: Float64Array | None) -> OccupancyGrid:
    """Return a 2D map, modifying its geometry, in the coordinates of the file."""
    if offset is not None and offset.any():
        x, y, yaw = grid.geometry.origin
        grid.geometry = replace(grid.geometry, origin=(x + float(offset[0]), y + float(offset[1]), yaw))
    return grid
