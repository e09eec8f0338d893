"""Marks of the voxels that a scan's beams pass and end in.

Numba twin of :func:`mapper.volume.occupancy.textbook.seen_voxels`. Source: Amanatides & Woo, A fast voxel traversal
algorithm for ray tracing, 1987, with the number types and tie order of octomap's computeRayKeys.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.types import Box

CENTRE = 32768
PASSED, ENDED = np.uint8(1), np.uint8(2)  #: marks of a voxel
_LANES = 32  # rays processed together; with fewer the compiler unrolls the loop instead of vectorising it
_STEPS = 8  # steps of all lanes before finished rays are replaced


@jit
def _norm(x: float, y: float, z: float) -> float:
    return sqrt(float(x * x + y * y + z * z))


@jit
def _crossing(key: int, origin: float, along: float, resolution: float, half: float) -> tuple[int, float, float]:
    """Return the step, the distance to the first border and the distance between borders of one axis, metres.

    ``key`` is that of the first voxel, ``origin`` the sensor's coordinate, ``along`` the component of the unit
    direction; ``half`` is half of ``resolution``, in the number type in which to round.
    """
    if along == 0.0:
        return 0, np.inf, np.inf
    step = 1 if along > 0.0 else -1
    border = (key - CENTRE + 0.5) * resolution + step * half
    return step, (border - float(origin)) / float(along), resolution / abs(float(along))


@jit
def voxel_keys(points: Float32Array, resolution: float, out: Int64Array, out_inside: BoolArray) -> None:
    """Write the keys (n, 3) of the voxels that contain points (n, 3), and which points are finite and in the
    lattice.
    """
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
def pack_keys(keys: Int64Array) -> Int64Array:
    """Pack keys (n, 3) into integers (n,), 16 bits per axis, x lowest."""
    out = np.empty(keys.shape[0], dtype=np.int64)
    for i in range(keys.shape[0]):
        out[i] = keys[i, 2] << 32 | keys[i, 1] << 16 | keys[i, 0]
    return out


@jit
def distinct_voxels(packed: Int64Array, resolution: float, keys: Int64Array, centres: Float32Array) -> int:
    """Write the keys (n, 3) and centres (n, 3), metres, of the distinct voxels in sorted ``packed`` keys; return n."""
    n = 0
    for i in range(packed.shape[0]):
        if i > 0 and packed[i] == packed[i - 1]:
            continue
        for axis in range(3):
            key = packed[i] >> 16 * axis & 65535
            keys[n, axis], centres[n, axis] = key, np.float32((key - CENTRE + 0.5) * resolution)
        n += 1
    return n


@jit
def key_bounds(keys: Int64Array, low: Int64Array, high: Int64Array) -> None:
    """Lower ``low`` (3,) and raise ``high`` (3,) to the minimum and maximum of keys (n, 3) along each axis."""
    low_x, low_y, low_z, high_x, high_y, high_z = low[0], low[1], low[2], high[0], high[1], high[2]
    for i in range(keys.shape[0]):
        x, y, z = keys[i, 0], keys[i, 1], keys[i, 2]
        low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
        high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
    low[0], low[1], low[2], high[0], high[1], high[2] = low_x, low_y, low_z, high_x, high_y, high_z


@jit
def _mark_ray(
    first: Int64Array, last: Int64Array, steps: tuple[int, int, int], crossings: tuple[float, float, float],
    apart: tuple[float, float, float], limit: float, box: Box, marks: UInt8Array,
) -> None:  # fmt: skip
    """Mark the voxels of a box passed by a ray that may leave it."""
    x, y, z = first[0] - box.x, first[1] - box.y, first[2] - box.z
    last_x, last_y, last_z = last[0] - box.x, last[1] - box.y, last[2] - box.z
    tx, ty, tz = crossings
    while True:
        if (x >= 0) & (x < box.nx) & (y >= 0) & (y < box.ny) & (z >= 0) & (z < box.nz):
            marks[(z * box.ny + y) * box.nx + x] = PASSED
        if tx < ty and tx < tz:
            x, tx = x + steps[0], tx + apart[0]
        elif not tx < ty and ty < tz:
            y, ty = y + steps[1], ty + apart[1]
        else:
            z, tz = z + steps[2], tz + apart[2]
        if (x == last_x and y == last_y and z == last_z) or min(tx, ty, tz) > limit:
            break


@jit
def mark_rays(
    origin: Float32Array, ends: Float32Array, first: Int64Array, lasts: Int64Array, resolution: float, box: Box,
    marks: UInt8Array,
) -> None:  # fmt: skip
    """Mark the voxels of a box (nz, ny, nx) that rays pass, from ``origin`` (3,) to ``ends`` (n, 3), metres.

    ``first`` (3,) and ``lasts`` (n, 3) are the keys of their voxels; the last voxel of a ray is not marked. Several
    threads may mark one box. :data:`_LANES` rays are traced in parallel, one step of each in turn, so that the compiler
    vectorises the steps. When a ray has ended, the next one takes its lane; until then the lane stays in the first
    voxel.
    """
    half = float(np.float32(resolution * 0.5))
    row, layer = box.nx, box.nx * box.ny
    top_x, top_y, top_z = box.x + box.nx, box.y + box.ny, box.z + box.nz
    start = (first[2] - box.z) * layer + (first[1] - box.y) * row + (first[0] - box.x)
    # position, steps along x, y and z, last position, whether the lane has a ray
    place = np.zeros(6 * _LANES, dtype=np.int64)  # now, steps along x, y and z, last, whether the lane has a ray
    place[:_LANES] = start
    path = np.ones(7 * _LANES)  # distances to the next borders, distances between borders, length
    n, i = ends.shape[0], 0
    while True:
        n_rays = 0
        for k in range(_LANES):
            while place[5 * _LANES + k] == 0 and i < n:
                x, y, z = lasts[i, 0], lasts[i, 1], lasts[i, 2]
                ray = i
                i += 1
                if x == first[0] and y == first[1] and z == first[2]:
                    continue
                # A ray that ends one voxel too far because of rounding is still within these bounds.
                low_x, low_y, low_z = min(x, first[0]) - 1, min(y, first[1]) - 1, min(z, first[2]) - 1
                high_x, high_y, high_z = max(x, first[0]) + 1, max(y, first[1]) + 1, max(z, first[2]) + 1
                if high_x < box.x or high_y < box.y or high_z < box.z or low_x >= top_x or low_y >= top_y:
                    continue
                if low_z >= top_z:
                    continue
                dx, dy, dz = ends[ray, 0] - origin[0], ends[ray, 1] - origin[1], ends[ray, 2] - origin[2]
                length = np.float32(_norm(dx, dy, dz))
                step_x, tx, apart_x = _crossing(first[0], origin[0], dx / length, resolution, half)
                step_y, ty, apart_y = _crossing(first[1], origin[1], dy / length, resolution, half)
                step_z, tz, apart_z = _crossing(first[2], origin[2], dz / length, resolution, half)
                if (
                    low_x < box.x or low_y < box.y or low_z < box.z
                    or high_x >= top_x or high_y >= top_y or high_z >= top_z
                ):  # fmt: skip
                    _mark_ray(
                        first, lasts[ray], (step_x, step_y, step_z), (tx, ty, tz), (apart_x, apart_y, apart_z),
                        float(length), box, marks,
                    )  # fmt: skip
                    continue
                place[k], place[5 * _LANES + k] = start, 1
                place[_LANES + k], place[2 * _LANES + k], place[3 * _LANES + k] = step_x, step_y * row, step_z * layer
                place[4 * _LANES + k] = (z - box.z) * layer + (y - box.y) * row + (x - box.x)
                path[k], path[_LANES + k], path[2 * _LANES + k] = tx, ty, tz
                path[3 * _LANES + k], path[4 * _LANES + k], path[5 * _LANES + k] = apart_x, apart_y, apart_z
                path[6 * _LANES + k] = float(length)
            n_rays += place[5 * _LANES + k]
        if n_rays == 0:
            break
        for _ in range(_STEPS):
            for k in range(_LANES):
                marks[place[k]] = PASSED
            for k in range(_LANES):
                tx, ty, tz = path[k], path[_LANES + k], path[2 * _LANES + k]
                x_first, not_z = tx < ty, min(tx, ty) < tz
                to_x, to_y = x_first & not_z, (not x_first) & not_z
                tx = tx + path[3 * _LANES + k] if to_x else tx
                ty = ty + path[4 * _LANES + k] if to_y else ty
                tz = tz if not_z else tz + path[5 * _LANES + k]
                path[k], path[_LANES + k], path[2 * _LANES + k] = tx, ty, tz
                step = (place[_LANES + k] if x_first else place[2 * _LANES + k]) if not_z else place[3 * _LANES + k]
                at = place[k] + step
                goes_on = (
                    (place[5 * _LANES + k] != 0)
                    & (at != place[4 * _LANES + k])
                    & (not min(tx, ty, tz) > path[6 * _LANES + k])
                )
                place[k] = at if goes_on else start
                place[5 * _LANES + k] = 1 if goes_on else 0


@jit
def mark_ends(keys: Int64Array, box: Box, marks: UInt8Array) -> None:
    """Mark the voxels of a box in which beams end; ``keys`` (n, 3)."""
    for i in range(keys.shape[0]):
        x, y, z = keys[i, 0] - box.x, keys[i, 1] - box.y, keys[i, 2] - box.z
        if x >= 0 and x < box.nx and y >= 0 and y < box.ny and z >= 0 and z < box.nz:
            marks[(z * box.ny + y) * box.nx + x] = ENDED
