"""Surface normals at occupied voxels, estimated from the occupied voxels around them."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.mesh.voxel_classes import ChunkKey, Painted
from mapper.volume.occupancy.volume import OccupancyVolume

REACH = 2  #: radius, in voxels, of the neighbourhood to which a plane is fitted
STEPS = 8  #: quantisation steps of the square of each component
_SIDE = 2 * REACH + 1
_AROUND = np.stack(np.meshgrid(*[np.arange(-REACH, REACH + 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
_PRODUCTS = np.column_stack([np.ones(len(_AROUND)), _AROUND] + [_AROUND[:, [k]] * _AROUND for k in range(3)])


def voxel_normals(volume: OccupancyVolume, chunk: ChunkKey) -> tuple[Int64Array, Float64Array]:
    """Return the indices (n,) of a chunk's occupied voxels, (z · 32 + y) · 32 + x, and their normals (n, 3).

    A normal is a unit vector in the map's frame: the direction of least variance of the centres of the occupied voxels
    within two voxels along each axis. Its sign is that of Σ d · n over the offsets d of the free voxels among them, so
    that it points to free space, or upwards if the sum is 0. Source of the direction: principal components of
    neighbours, Hoppe et al., Surface reconstruction from unorganized points, SIGGRAPH 1992.
    """
    places = np.arange(-REACH, CHUNK + REACH)
    keys = np.stack(np.meshgrid(*[CHUNK * k + places for k in chunk], indexing="ij"), axis=-1).reshape(-1, 3)
    values = volume.log_odds_of(keys).reshape((CHUNK + 2 * REACH,) * 3)
    is_occupied = values >= volume.config.log_odds_occupied
    inner = is_occupied[REACH:-REACH, REACH:-REACH, REACH:-REACH]
    x, y, z = np.nonzero(inner)
    if not len(x):
        return np.empty(0, np.int64), np.empty((0, 3))
    near = sliding_window_view(is_occupied, (_SIDE,) * 3)[x, y, z].reshape(len(x), -1)
    sums = near @ _PRODUCTS
    mean = sums[:, 1:4] / sums[:, :1]
    spread = sums[:, 4:].reshape(-1, 3, 3) / sums[:, :1, None] - mean[:, :, None] * mean[:, None, :]
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    free = np.where(values < volume.config.log_odds_occupied, 1.0, 0.0)
    towards = sliding_window_view(free, (_SIDE,) * 3)[x, y, z].reshape(len(x), -1) @ _AROUND
    facing = (normals * towards).sum(axis=1)
    is_back = np.where(np.abs(facing) > 1e-9, facing < 0.0, normals[:, 2] < 0.0)
    normals[is_back] *= -1.0
    return (z * CHUNK + y) * CHUNK + x, normals


def painted_directions(volume: OccupancyVolume, chunk: ChunkKey) -> Painted:
    """Return the normal directions of a chunk's occupied voxels, as the colours of :class:`VoxelFaces`."""
    numbers, normals = voxel_normals(volume, chunk)
    return {chunk: (numbers, direction_numbers(normals))}


def direction_numbers(normals: Float64Array) -> UInt8Array:
    """Return the index, from 1, of the direction of each of ``normals`` (n, 3) in :func:`directions`."""
    squares = normals**2
    squares = squares / np.maximum(squares.sum(axis=1, keepdims=True), 1e-12)
    i = np.round(STEPS * squares[:, 0]).astype(np.int64)
    j = np.minimum(np.round(STEPS * squares[:, 1]).astype(np.int64), STEPS - i)
    return np.asarray(1 + (i * (STEPS + 1) + j) * 2 + (normals[:, 2] >= 0.0), dtype=np.uint8)


def directions() -> NDArray[np.float64]:
    """Return the direction (n, 3) of each index of :func:`direction_numbers`, the first of which is 1.

    Directions that differ only in the signs of x and y share an index.
    """
    i, j, up = np.meshgrid(np.arange(STEPS + 1), np.arange(STEPS + 1), np.arange(2), indexing="ij")
    z = np.maximum(STEPS - i - j, 0)
    normals = np.sqrt(np.stack([i, j, z], axis=-1) / STEPS)
    normals[..., 2] *= np.where(up == 1, 1.0, -1.0)
    return np.asarray(normals.reshape(-1, 3))
