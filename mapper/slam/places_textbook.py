"""Place recognition as in its sources, in plain NumPy: local maps, corners, descriptors, RANSAC.

Sources: Harris & Stephens 1988, A combined corner and edge detector; Tipaldi & Arras 2010, FLIRT; Fischler & Bolles
1981, Random sample consensus; Mangelson et al. 2018, Pairwise consistent measurement set maximization.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.se2 import transform_points, wrap_angle
from mapper.matching.textbook import PointScan

UNKNOWN, FREE, WALL = 0, 1, 2


def local_map(
    scans: list[PointScan],
    poses: Float64Array,
    low: Float64Array,
    shape: tuple[int, int],
    resolution: float,
    reach: float,
) -> tuple[Int64Array, Int64Array, Float64Array]:
    """Return the number of beams of scans at ``poses`` (k, 3) that end in each cell and that pass through it, (rows,
    cols).

    The third array (rows, cols, 3) is Σ n_x², Σ n_x n_y and Σ n_y² of the normals of the points in a cell. ``low`` (2,)
    is the corner of the first cell. A beam passes through the cells of the points at whole cell widths from its sensor,
    up to ``reach`` metres; a longer beam has no end.
    """
    hits, passes = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64)
    tensors = np.zeros((*shape, 3))

    def add(to: NDArray[np.int64] | Float64Array, points: Float64Array, values: Float64Array | int) -> None:
        col, row = np.floor((points - low) / resolution).astype(np.int64).T
        inside = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
        np.add.at(to, (row[inside], col[inside]), values if isinstance(values, int) else values[inside])

    for scan, pose in zip(scans, poses, strict=True):
        sensor = transform_points(pose, scan.sensor)
        normals = transform_points([0.0, 0.0, pose[2]], scan.normals)
        for k in np.flatnonzero(scan.is_point):
            point = transform_points(pose, scan.points[k])
            r = float(np.sqrt(np.sum((point - sensor) ** 2)))
            if r < resolution:
                continue
            steps = np.arange(int(min(r, reach) / resolution))[:, np.newaxis]
            add(passes, sensor + steps * resolution / r * (point - sensor), 1)
            if r <= reach:
                add(hits, point[np.newaxis], 1)
                if scan.has_normal[k]:
                    x, y = normals[k]
                    add(tensors, point[np.newaxis], np.array([[x * x, x * y, y * y]]))
    return hits, passes, tensors


def cell_states(hits: Int64Array, passes: Int64Array, most_passes: int) -> NDArray[np.uint8]:
    """Return the state of each cell (rows, cols): wall unless too many beams pass, else free, else unknown."""
    is_wall = (hits > 0) & (most_passes * hits >= passes)
    return np.where(is_wall, WALL, np.where(passes > 0, FREE, UNKNOWN)).astype(np.uint8)


def corner_strengths(states: NDArray[np.uint8], hits: Int64Array, tensors: Float64Array, radius: int) -> Float64Array:
    """Return the smaller eigenvalue of Σ n nᵀ over the walls within ``radius`` cells of each wall cell, else 0.

    Each cell counts once, with the mean of its points.
    """
    means = np.where((states == WALL)[..., np.newaxis], tensors / np.maximum(hits, 1)[..., np.newaxis], 0.0)
    out = np.zeros(states.shape)
    row, col = np.mgrid[: states.shape[0], : states.shape[1]]
    for r, q in np.argwhere(states == WALL):
        xx, xy, yy = means[(row - r) ** 2 + (col - q) ** 2 <= radius**2].sum(axis=0)
        out[r, q] = max(np.linalg.eigvalsh([[xx, xy], [xy, yy]])[0], 0.0)
    return out


def polar_shares(
    states: NDArray[np.uint8], keypoints: Int64Array, rings: int, sectors: int, radius: int
) -> NDArray[np.float32]:
    """Return the fraction of each bin's cells around each keypoint (k, 2) that are walls, and that are free (k, 2,
    bins).
    """
    row, col = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    ring = np.floor(np.hypot(row, col) * rings / (radius + 0.5)).astype(np.int64)
    sector = np.floor(np.arctan2(row, col) / (2.0 * np.pi) * sectors).astype(np.int64) % sectors
    bins = ring * sectors + sector
    padded = np.pad(states, radius)
    out = np.zeros((len(keypoints), 2, rings * sectors), dtype=np.float32)
    for k, (r, q) in enumerate(keypoints):
        around = padded[r : r + 2 * radius + 1, q : q + 2 * radius + 1]
        for b in range(rings * sectors):
            cells = around[bins == b]
            for which, state in enumerate((WALL, FREE)):
                out[k, which, b] = np.float32(np.count_nonzero(cells == state)) / np.float32(max(len(cells), 1))
    return out


def nearest_descriptors(ours: NDArray[np.float32], theirs: NDArray[np.float32], k: int) -> Int64Array:
    """Return the indices (m, k) of the descriptors ``theirs`` (n, d) nearest to each of ``ours`` (m, d), −1 for
    none.
    """
    out = np.full((len(ours), k), -1, dtype=np.int64)
    for a, row in enumerate(ours.astype(np.float64)):
        squares = np.array([sum(off * off for off in (row - other).tolist()) for other in theirs.astype(np.float64)])
        order = np.argsort(squares, kind="stable")[:k]
        out[a, : len(order)] = order
    return out


def pose_of_pairs(
    ours: Float64Array,
    theirs: Float64Array,
    owner: Int64Array,
    guess: Float64Array,
    windows: tuple[float, float],
    tolerance: float,
    least_distance: float,
) -> tuple[int, float]:
    """Return the number of points that agree with the best pose from two pairs of points, and their sum of squares.

    See :func:`mapper.slam.kernels.keypoint_pairs.pose_of_pairs`.
    """
    best = (0, 0.0)
    for p, q in combinations(range(len(ours)), 2):
        a, b = ours[q] - ours[p], theirs[q] - theirs[p]
        length = np.hypot(*a)
        if owner[p] == owner[q] or length < least_distance or abs(length - np.hypot(*b)) > tolerance:
            continue
        theta = np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)
        middle = transform_points([0.0, 0.0, theta], 0.5 * (ours[p] + ours[q]))
        pose = np.array([*(0.5 * (theirs[p] + theirs[q]) - middle), theta])
        if abs(float(wrap_angle(theta - guess[2]))) > windows[1] or np.hypot(*(pose - guess)[:2]) > windows[0]:
            continue
        squares = np.sum((transform_points(pose, ours) - theirs) ** 2, axis=1)
        least = [squares[owner == index].min() for index in np.unique(owner)]
        agreeing = [square for square in least if square <= tolerance**2]
        best = min(best, (len(agreeing), sum(agreeing)), key=lambda item: (-item[0], item[1]))
    return best


def largest_consistent(consistent: NDArray[np.bool_]) -> int:
    """Return the size of the largest group in which all pairs are ``consistent`` (n, n), by exhaustive search."""
    n = len(consistent)
    for size in range(n, 0, -1):
        for group in combinations(range(n), size):
            if all(consistent[a, b] for a, b in combinations(group, 2)):
                return size
    return 0
