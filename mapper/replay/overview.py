"""Small preview of a log's map, made from a bounded number of its beams. NumPy only.

Each cell counts the beams that end in it and those that pass it, as in the reflection probability maps of Probabilistic
Robotics, section 9.4. A cell of this coarse grid contains both a wall and the space before it, so it is shown as
occupied from a fraction of :data:`OCCUPIED_SHARE` on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.scan import ScanLog

SIDE = 320  #: cells along the longer side
MAX_SCANS = 400  #: of a log, evenly spaced
MAX_BEAMS = 120  #: of each scan, evenly spaced
LEAST_CELL_M = 0.05
MARGIN_CELLS = 4
OUTLIERS = 1.0  #: per cent of the endpoints at each edge that may be outside the picture
OCCUPIED_SHARE = 0.2

UNOBSERVED, FREE, OCCUPIED, PATH = range(4)  #: codes of cells


def cells_overview(free: NDArray[np.bool_], occupied: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return the codes of a picture of cells (rows, cols), row 0 at the greatest y, at most :data:`SIDE` per side.

    ``free`` and ``occupied`` (rows, cols) have row 0 at the smallest y. A pixel that covers several cells is occupied
    if one of them is, else free if one of them is.
    """
    step = -(-max(free.shape) // SIDE)
    codes = np.full((-(-free.shape[0] // step), -(-free.shape[1] // step)), UNOBSERVED, dtype=np.uint8)
    for cells, code in ((free, FREE), (occupied, OCCUPIED)):
        rows, cols = np.nonzero(cells)
        codes[rows // step, cols // step] = code
    return codes[::-1]


def map_overview(log: ScanLog) -> NDArray[np.uint8] | None:
    """Return the codes of the pixels of a picture (rows, cols), row 0 at the greatest y.

    None for a log without readings. The poses are those of the log's first trajectory, whose path is also drawn.
    """
    n = log.n_scans
    poses = next((trajectory.poses for trajectory in log.trajectories.values()), None)
    if n == 0 or log.n_beams == 0 or poses is None:
        return None
    scans = np.unique(np.linspace(0, n - 1, min(n, MAX_SCANS)).round().astype(int))
    beams = np.unique(np.linspace(0, log.n_beams - 1, min(log.n_beams, MAX_BEAMS)).round().astype(int))
    ranges = log.ranges[np.ix_(scans, beams)].astype(np.float64)
    valid = np.isfinite(ranges) & (ranges >= log.range_min) & (ranges <= log.range_max)
    if not valid.any():
        return None
    x, y, yaw = _sensor_poses(poses[scans], log.mount)
    bearings = log.angles[beams] * (-1.0 if log.upside_down else 1.0)
    angles = (yaw[:, None] + bearings)[valid]
    starts = np.column_stack([np.broadcast_to(coordinate[:, None], valid.shape)[valid] for coordinate in (x, y)])
    steps = np.column_stack([np.cos(angles), np.sin(angles)])
    ends = starts + ranges[valid][:, None] * steps

    low, high = _bounds(ends, poses[:, :2])
    cell = max(float((high - low).max()) / (SIDE - 2 * MARGIN_CELLS), LEAST_CELL_M)
    low = low - MARGIN_CELLS * cell
    cols, rows = (np.ceil((high - low) / cell).astype(int) + MARGIN_CELLS).tolist()

    def cells_of(points: NDArray[np.float64]) -> NDArray[np.int64]:
        at = np.floor((points - low) / cell)
        inside = ((at >= 0) & (at < (cols, rows))).all(axis=1)
        col, row = at[inside].astype(np.int64).T
        flat: NDArray[np.int64] = row * cols + col
        return flat

    hits = np.bincount(cells_of(ends), minlength=rows * cols)
    passed = np.zeros_like(hits)
    lengths = ranges[valid] - cell
    for k in range(int(np.ceil(min(float(lengths.max()) / cell, 1.5 * SIDE)))):
        on_way = lengths > k * cell
        passed += np.bincount(cells_of(starts[on_way] + k * cell * steps[on_way]), minlength=rows * cols)
    codes = np.full(rows * cols, UNOBSERVED, dtype=np.uint8)
    codes[passed > 1] = FREE  # one stray beam does not make free space
    codes[(hits > 0) & (hits >= OCCUPIED_SHARE * (hits + passed))] = OCCUPIED
    codes[cells_of(_path(poses[:, :2], cell))] = PATH
    return codes.reshape(rows, cols)[::-1]


def _sensor_poses(
    poses: NDArray[np.float64], mount: tuple[float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return x, y and yaw of the sensor at base poses (n, 3): T_map_base T_base_sensor."""
    x, y, yaw = poses.T
    cos, sin = np.cos(yaw), np.sin(yaw)
    return x + cos * mount[0] - sin * mount[1], y + sin * mount[0] + cos * mount[1], yaw + mount[2]


def _bounds(ends: NDArray[np.float64], path: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners of a box around the path and all endpoints except a few outliers."""
    low, high = np.percentile(ends, [OUTLIERS, 100.0 - OUTLIERS], axis=0)
    return np.minimum(low, path.min(axis=0)), np.maximum(high, path.max(axis=0))


def _path(points: NDArray[np.float64], cell: float) -> NDArray[np.float64]:
    """Return points along a path, at most half a cell apart and at most 16 per step of it."""
    points = points[np.unique(np.linspace(0, len(points) - 1, min(len(points), 4000)).round().astype(int))]
    if len(points) < 2:
        return points
    longest = float(np.hypot(*np.diff(points, axis=0).T).max())
    parts = int(min(max(np.ceil(longest / (0.5 * cell)), 1.0), 16.0))
    along = np.linspace(0.0, 1.0, parts, endpoint=False)[None, :, None]
    between: NDArray[np.float64] = points[:-1, None] + along * np.diff(points, axis=0)[:, None]
    return np.vstack([between.reshape(-1, 2), points[-1:]])
