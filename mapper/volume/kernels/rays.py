"""The marks of the voxels that a scan's beams pass and end in.

Numba twin of :func:`mapper.volume.textbook.seen_voxels`. Source: Amanatides & Woo, A fast voxel traversal algorithm for
ray tracing, 1987, with the number types and the order of ties of octomap's computeRayKeys.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.types import Box

CENTRE = 32768
PASSED, ENDED = np.uint8(1), np.uint8(2)  #: marks of a voxel


@jit
def _norm(x: float, y: float, z: float) -> float:
    return sqrt(float(x * x + y * y + z * z))


@jit
def _crossing(key: int, origin: float, along: float, resolution: float, half: float) -> tuple[int, float, float]:
    """Return the step, the distance to the first border and the distance between borders, of one axis."""
    if along == 0.0:
        return 0, np.inf, np.inf
    step = 1 if along > 0.0 else -1
    border = (key - CENTRE + 0.5) * resolution + step * half
    return step, (border - float(origin)) / float(along), resolution / abs(float(along))


@jit
def voxel_keys(points: Float32Array, resolution: float, out: Int64Array, out_inside: BoolArray) -> None:
    """Write the keys (n, 3) of the voxels that hold points (n, 3), and which points are finite and in the lattice."""
    factor, top = 1.0 / resolution, float(CENTRE)
    for i in range(points.shape[0]):
        x = np.floor(factor * float(points[i, 0]))
        y = np.floor(factor * float(points[i, 1]))
        z = np.floor(factor * float(points[i, 2]))
        inside = (x >= -top) & (x < top) & (y >= -top) & (y < top) & (z >= -top) & (z < top)
        out_inside[i] = inside
        if inside:
            out[i, 0], out[i, 1], out[i, 2] = int(x) + CENTRE, int(y) + CENTRE, int(z) + CENTRE
        else:
            out[i, 0], out[i, 1], out[i, 2] = 0, 0, 0


@jit
def mark_rays(
    origin: Float32Array, ends: Float32Array, first: Int64Array, lasts: Int64Array, resolution: float, box: Box,
    marks: UInt8Array,
) -> None:  # fmt: skip
    """Mark the voxels of a box (nz, ny, nx) that rays pass, from ``origin`` (3,) to ``ends`` (n, 3), metres.

    ``first`` (3,) and ``lasts`` (n, 3) are the keys of their voxels; the last voxel of a ray is not marked. Several
    threads may mark one box.
    """
    half = float(np.float32(resolution * 0.5))
    top_x, top_y, top_z = box.x + box.nx, box.y + box.ny, box.z + box.nz
    row, layer = box.nx, box.nx * box.ny
    for i in range(ends.shape[0]):
        x, y, z = first[0], first[1], first[2]
        last_x, last_y, last_z = lasts[i, 0], lasts[i, 1], lasts[i, 2]
        if x == last_x and y == last_y and z == last_z:
            continue
        # A ray that ends a voxel too far for rounding is still within these bounds.
        low_x, low_y, low_z = min(x, last_x) - 1, min(y, last_y) - 1, min(z, last_z) - 1
        high_x, high_y, high_z = max(x, last_x) + 1, max(y, last_y) + 1, max(z, last_z) + 1
        if high_x < box.x or high_y < box.y or high_z < box.z or low_x >= top_x or low_y >= top_y or low_z >= top_z:
            continue
        dx, dy, dz = ends[i, 0] - origin[0], ends[i, 1] - origin[1], ends[i, 2] - origin[2]
        length = np.float32(_norm(dx, dy, dz))
        step_x, tx, apart_x = _crossing(x, origin[0], dx / length, resolution, half)
        step_y, ty, apart_y = _crossing(y, origin[1], dy / length, resolution, half)
        step_z, tz, apart_z = _crossing(z, origin[2], dz / length, resolution, half)
        limit = float(length)
        # There are no branches but the loop's: which axis comes next cannot be predicted.
        x, y, z, last_x, last_y, last_z = (
            x - box.x,
            y - box.y,
            z - box.z,
            last_x - box.x,
            last_y - box.y,
            last_z - box.z,
        )
        while True:
            if (x >= 0) & (x < box.nx) & (y >= 0) & (y < box.ny) & (z >= 0) & (z < box.nz):
                marks[z * layer + y * row + x] = PASSED
            x_first = tx < ty
            not_z = min(tx, ty) < tz
            x_next, y_next = x_first & not_z, (not x_first) & not_z
            x += step_x if x_next else 0
            y += step_y if y_next else 0
            z += 0 if not_z else step_z
            after_x, after_y, after_z = tx + apart_x, ty + apart_y, tz + apart_z
            tx = after_x if x_next else tx
            ty = after_y if y_next else ty
            tz = tz if not_z else after_z
            if ((x == last_x) & (y == last_y) & (z == last_z)) | (min(tx, ty, tz) > limit):
                break


@jit
def mark_ends(keys: Int64Array, box: Box, marks: UInt8Array) -> None:
    """Mark the voxels of a box in which beams end; ``keys`` (n, 3)."""
    for i in range(keys.shape[0]):
        x, y, z = keys[i, 0] - box.x, keys[i, 1] - box.y, keys[i, 2] - box.z
        if x >= 0 and x < box.nx and y >= 0 and y < box.ny and z >= 0 and z < box.nz:
            marks[(z * box.ny + y) * box.nx + x] = ENDED
