"""Local map of a few scans: wall and free cells, wall directions, and corners.

Numba twins of :func:`mapper.slam.places_textbook.local_map`, :func:`mapper.slam.places_textbook.corner_strengths` and
:func:`mapper.slam.places_textbook.polar_shares`.
"""

from __future__ import annotations

from math import cos, floor, sin, sqrt
from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.matching.kernels.types import NO_POINT, POINT_WITH_NORMAL, ScanArrays

UNKNOWN, FREE, WALL = 0, 1, 2
NO_BIN = 255
MOST_PASSES = 4  #: maximum number of beams that pass through a wall cell for each that ends in it


class Square(NamedTuple):
    """Cells of ``resolution`` metres with rows and columns starting at (``low_x``, ``low_y``)."""

    low_x: float
    low_y: float
    resolution: float


@jit
def draw_scan(
    hits: Int32Array, passes: Int32Array, tensors: Float64Array, square: Square, scans: ScanArrays, i: int,
    pose: Float64Array, reach: float, stride: int,
) -> None:  # fmt: skip
    """Count the beams of scan i at ``pose`` (3,) that end in each cell and that pass through it, (rows, cols) each.

    A beam passes through the cells of the points at whole cell widths from its sensor, up to ``reach`` metres.
    ``tensors`` (rows, cols, 3) receives n_x², n_x n_y and n_y² of the normals of the points that end there. Every
    ``stride``-th beam counts.
    """
    rows, cols = hits.shape
    c, s = cos(pose[2]), sin(pose[2])
    at_x = pose[0] + c * scans.sensor[i, 0] - s * scans.sensor[i, 1]
    at_y = pose[1] + s * scans.sensor[i, 0] + c * scans.sensor[i, 1]
    for k in range(0, scans.n_beams[i], stride):
        if scans.kind[i, k] == NO_POINT:
            continue
        p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
        x, y = pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y
        d_x, d_y = x - at_x, y - at_y
        r = sqrt(d_x * d_x + d_y * d_y)
        if r < square.resolution:
            continue
        for step in range(int(min(r, reach) / square.resolution)):
            share = step * square.resolution / r
            col = floor((at_x + share * d_x - square.low_x) / square.resolution)
            row = floor((at_y + share * d_y - square.low_y) / square.resolution)
            if 0 <= row < rows and 0 <= col < cols:
                passes[row, col] += 1
        if r > reach:
            continue
        col = floor((x - square.low_x) / square.resolution)
        row = floor((y - square.low_y) / square.resolution)
        if 0 <= row < rows and 0 <= col < cols:
            hits[row, col] += 1
            if scans.kind[i, k] == POINT_WITH_NORMAL:
                n_x = c * np.float64(scans.normals[i, k, 0]) - s * np.float64(scans.normals[i, k, 1])
                n_y = s * np.float64(scans.normals[i, k, 0]) + c * np.float64(scans.normals[i, k, 1])
                tensors[row, col, 0] += n_x * n_x
                tensors[row, col, 1] += n_x * n_y
                tensors[row, col, 2] += n_y * n_y


@jit
def write_states(hits: Int32Array, passes: Int32Array, states: UInt8Array) -> None:
    """Write for each cell whether it is a wall, free or unknown (rows, cols)."""
    for row in range(hits.shape[0]):
        for col in range(hits.shape[1]):
            if hits[row, col] > 0 and MOST_PASSES * np.int64(hits[row, col]) >= passes[row, col]:
                states[row, col] = WALL
            else:
                states[row, col] = FREE if passes[row, col] > 0 else UNKNOWN


@jit
def write_corner_strengths(
    states: UInt8Array, hits: Int32Array, tensors: Float64Array, radius: int, strengths: Float64Array
) -> None:
    """Write how much the walls within ``radius`` cells of each wall cell point in two directions (rows, cols).

    It is the smaller eigenvalue of Σ n nᵀ, in which each wall cell counts once, with the mean of its points; 0 in other
    cells. Source: Harris & Stephens 1988, with wall normals in place of image gradients.
    """
    rows, cols = states.shape
    strengths[:] = 0.0
    for row in range(rows):
        for col in range(cols):
            if states[row, col] != WALL:
                continue
            xx, xy, yy = 0.0, 0.0, 0.0
            for r in range(max(row - radius, 0), min(row + radius + 1, rows)):
                for q in range(max(col - radius, 0), min(col + radius + 1, cols)):
                    if states[r, q] == WALL and (r - row) ** 2 + (q - col) ** 2 <= radius * radius:
                        xx += tensors[r, q, 0] / hits[r, q]
                        xy += tensors[r, q, 1] / hits[r, q]
                        yy += tensors[r, q, 2] / hits[r, q]
            half = 0.5 * (xx - yy)
            strengths[row, col] = max(0.5 * (xx + yy) - sqrt(half * half + xy * xy), 0.0)


@jit
def write_polar_shares(
    states: UInt8Array, keypoints: Int64Array, bins: UInt8Array, sizes: Int64Array, shares: Float32Array
) -> None:
    """Write the fraction of each bin's cells around each keypoint that are walls, and that are free (k, 2, n_bins).

    ``keypoints`` (k, 2) are rows and columns, ``bins`` (side, side) is the bin of each cell around one, 255 for none,
    and ``sizes`` (n_bins,) the number of cells of each bin. Cells outside the grid are unknown. Source: Tipaldi & Arras
    2010, the beta grid, with fractions of cells in place of probabilities.
    """
    reach = bins.shape[0] // 2
    rows, cols = states.shape
    shares[:] = 0.0
    for k in range(len(keypoints)):
        row, col = keypoints[k]
        for r in range(max(row - reach, 0), min(row + reach + 1, rows)):
            for q in range(max(col - reach, 0), min(col + reach + 1, cols)):
                b = bins[r - row + reach, q - col + reach]
                if b != NO_BIN and states[r, q] != UNKNOWN:
                    shares[k, 0 if states[r, q] == WALL else 1, b] += np.float32(1.0)
        for b in range(len(sizes)):
            shares[k, 0, b] /= np.float32(sizes[b])
            shares[k, 1, b] /= np.float32(sizes[b])
