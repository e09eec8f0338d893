"""Targets of scan matching: another scan, several scans with their poses (a submap), or the walls of a map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import check_poses
from mapper.grid import OCCUPIED_THRESHOLD, OccupancyGrid
from mapper.matching.beams import scan_rows
from mapper.matching.kernels.types import NO_POINT, POINT, ScanArrays

FEWEST_POINTS = 3
MOST_MAP_POINTS = 5_000  #: if a map has more occupied cells, only every n-th is used


@dataclass(frozen=True, slots=True)
class Target:
    """Scans ``indices`` (k,) of ``scans`` with the poses (n_scans, 3) ``T_target_base`` of all scans.

    ``is_map`` marks the walls of a map: points without normals or viewpoint, for methods that need neither. Raises
    :class:`ConfigError` for scans that do not exist, poses that are not finite, and fewer than three points.
    """

    scans: ScanArrays
    indices: Int64Array
    poses: Float64Array
    is_map: bool = False

    def __post_init__(self) -> None:
        n_scans = len(self.scans.kind)
        object.__setattr__(self, "indices", np.ascontiguousarray(self.indices, dtype=np.int64))
        object.__setattr__(self, "poses", np.ascontiguousarray(self.poses, dtype=np.float64))
        check_poses(self.poses, (n_scans, 3))
        if (
            self.indices.ndim != 1
            or not len(self.indices)
            or not ((self.indices >= 0) & (self.indices < n_scans)).all()
        ):
            raise ConfigError("matching.target", f"The target must be one or more of the {n_scans} scans.")
        check_points(self.scans, self.indices, "the map" if self.is_map else "the target")

    @property
    def points(self) -> Float64Array:
        """All points (m, 2) in the target's frame."""
        kind, poses = self.scans.kind[self.indices], self.poses[self.indices]
        x, y = self.scans.points[self.indices, :, 0], self.scans.points[self.indices, :, 1]
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        placed = np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=-1)
        return np.asarray(placed[kind != NO_POINT], dtype=np.float64)


def check_points(scans: ScanArrays, indices: Int64Array, what: str) -> None:
    """Raise :class:`ConfigError` if the scans have fewer than three points in total."""
    count = int(np.count_nonzero(scans.kind[indices]))
    if count < FEWEST_POINTS:
        raise ConfigError(
            "matching.points", f"Matching needs {FEWEST_POINTS} points or more, and {what} has {count} usable readings."
        )


def scan_target(scans: ScanArrays, index: int) -> Target:
    """Return one scan as a target; the match is relative to its base frame."""
    if not 0 <= index < len(scans.kind):
        raise ConfigError("matching.scan", f"There is no scan {index}; the last is {len(scans.kind) - 1}.")
    rows = scan_rows(scans, index, index + 1)
    return Target(rows, np.zeros(1, dtype=np.int64), np.zeros((1, 3)))


def map_points(grid: OccupancyGrid, most: int = MOST_MAP_POINTS) -> ScanArrays:
    """Return the centres of the occupied cells of a grid as one scan of points without normals, in the map's frame.

    Occupied cells are observed cells with p_occ above 0.65, as in map_server. If there are more than ``most``, every
    n-th in row-major order is used.
    """
    cells = np.argwhere(grid.observed & (grid.p_occ > OCCUPIED_THRESHOLD))
    cells = cells[:: max(1, -(-len(cells) // most))]
    points = np.zeros((1, max(len(cells), 1), 2), dtype=np.float32)
    if len(cells):
        points[0] = grid.geometry.cell_to_world(cells)
    kind: UInt8Array = np.full((1, points.shape[1]), POINT if len(cells) else NO_POINT, dtype=np.uint8)
    n = np.array([points.shape[1]])
    single = np.ones(1)
    return ScanArrays(points, np.zeros_like(points), kind, n, 0.0 * single, single, single < 0.0, np.zeros((1, 2)))


def map_target(points: ScanArrays) -> Target:
    """Return the walls of a map, :func:`map_points`, as a target; the match is relative to the map's frame."""
    return Target(points, np.zeros(1, dtype=np.int64), np.zeros((1, 3)), is_map=True)
