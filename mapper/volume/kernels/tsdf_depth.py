"""Depth images in truncated signed distance fields: the blocks that a surface may touch, and their update.

Numba twins of :func:`mapper.volume.surface.textbook.fuse_depth`. Source: Newcombe et al., KinectFusion, ISMAR 2011,
section 3.3: a voxel gets the depth of the pixel onto which its centre projects.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int32Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.types import Box, DepthView, Fusion

TILE = 8  #: pixels along a side of the tiles for which blocks are found
_PIECE = 4.0  # voxels of depth covered by one box
_SLACK = 1e-3  # tolerance for rounding, in voxels and pixels


@jit
def _mark_pyramid(
    view: DepthView, u: float, v: float, half: float, low: float, high: float, resolution: float, box: Box,
    marks: BoolArray,
) -> None:  # fmt: skip
    """Mark the blocks of the voxels with depths ``low`` … ``high``, metres, seen within ``half`` pixels of (u, v)."""
    rays, origin = view.rays, view.origin
    cx = rays[0, 0] * u + rays[0, 1] * v + rays[0, 2]
    cy = rays[1, 0] * u + rays[1, 1] * v + rays[1, 2]
    cz = rays[2, 0] * u + rays[2, 1] * v + rays[2, 2]
    ex = (abs(rays[0, 0]) + abs(rays[0, 1])) * half
    ey = (abs(rays[1, 0]) + abs(rays[1, 1])) * half
    ez = (abs(rays[2, 0]) + abs(rays[2, 1])) * half
    n = int(np.ceil((high - low) / (_PIECE * resolution)))
    step = (high - low) / n
    for i in range(n):
        a = low + i * step
        b = a + step
        x0 = (int(np.ceil(origin[0] + min(a * (cx - ex), b * (cx - ex)) - _SLACK)) >> 3) - (box.x >> 3)
        y0 = (int(np.ceil(origin[1] + min(a * (cy - ey), b * (cy - ey)) - _SLACK)) >> 3) - (box.y >> 3)
        z0 = (int(np.ceil(origin[2] + min(a * (cz - ez), b * (cz - ez)) - _SLACK)) >> 3) - (box.z >> 3)
        x1 = (int(np.floor(origin[0] + max(a * (cx + ex), b * (cx + ex)) + _SLACK)) >> 3) - (box.x >> 3)
        y1 = (int(np.floor(origin[1] + max(a * (cy + ey), b * (cy + ey)) + _SLACK)) >> 3) - (box.y >> 3)
        z1 = (int(np.floor(origin[2] + max(a * (cz + ez), b * (cz + ez)) + _SLACK)) >> 3) - (box.z >> 3)
        nx, ny, nz = box.nx >> 3, box.ny >> 3, box.nz >> 3
        for z in range(max(z0, 0), min(z1 + 1, nz)):
            for y in range(max(y0, 0), min(y1 + 1, ny)):
                for x in range(max(x0, 0), min(x1 + 1, nx)):
                    marks[(z * ny + y) * nx + x] = True


@jit
def depth_span(depth: Float32Array, far: np.float32) -> tuple[int, np.float32]:
    """Return how many depths (n,) are positive and at most ``far``, and their maximum, 0 without any."""
    zero, count, greatest = np.float32(0.0), 0, np.float32(0.0)
    for i in range(depth.shape[0]):
        d = depth[i]
        valid = (d > zero) & (d <= far)
        count += 1 if valid else 0
        here = d if valid else zero
        greatest = max(greatest, here)
    return count, greatest


@jit
def mark_surface(
    view: DepthView, fusion: Fusion, resolution: float, box: Box, first: int, last: int, marks: BoolArray
) -> None:
    """Mark the blocks (nz × ny × nx,) of a box that may have voxels within the truncation of the surface.

    Only the tile rows ``first`` … ``last`` − 1 are processed; several threads may mark one box.
    """
    band = np.float64(fusion.truncation)
    least, greatest = np.empty(view.width, dtype=np.float32), np.empty(view.width, dtype=np.float32)
    none, zero = np.float32(np.inf), np.float32(0.0)
    for tile in range(first, last):
        least[:], greatest[:] = none, zero
        top, bottom = tile * TILE, min(tile * TILE + TILE, view.height)
        for row in range(top, bottom):
            line = view.depth[row * view.width : (row + 1) * view.width]
            for col in range(view.width):
                d = line[col]
                valid = (d > zero) & (d <= fusion.far)
                low, high = d if valid else none, d if valid else zero
                least[col] = min(least[col], low)
                greatest[col] = max(greatest[col], high)
        for left in range(0, view.width, TILE):
            right = min(left + TILE, view.width)
            near, far = none, zero
            for col in range(left, right):
                near, far = min(near, least[col]), max(far, greatest[col])
            if far == zero:
                continue
            # One pyramid for each layer of similar depths, because one tile may see several surfaces.
            while True:
                end = far
                if far - near > fusion.truncation:
                    end = near
                    for row in range(top, bottom):
                        for col in range(left, right):
                            d = view.depth[row * view.width + col]
                            end = max(end, d if (d >= near) & (d - near <= fusion.truncation) else near)
                _mark_pyramid(
                    view, left + 0.5 * (TILE - 1), top + 0.5 * (TILE - 1), 0.5 * TILE + _SLACK,
                    max(near * (1.0 - 1e-6) - band, 0.0), end * (1.0 + 1e-6) + band, resolution, box, marks,
                )  # fmt: skip
                if end == far:
                    break
                near = none
                for row in range(top, bottom):
                    for col in range(left, right):
                        d = view.depth[row * view.width + col]
                        near = min(near, d if (d > end) & (d <= far) else none)


@jit
def fuse_depth(
    view: DepthView, fusion: Fusion, corners: Float32Array, offsets: Float32Array, slots: Int32Array,
    distances: Float32Array, weights: Float32Array, out_touched: UInt8Array,
) -> None:  # fmt: skip
    """Update the voxels of blocks by a depth image; write 1 for each changed one (n,), 3 if changed by the surface
    itself.

    ``corners`` (n, 3) are the first voxels' centres, u z, v z, z, in pixels and metres of the camera; ``offsets`` (3,
    512) are those of the others relative to it. ``distances`` and ``weights`` (slots, 512) are the map.
    """
    zero, unit, half, infinite = np.float32(0.0), np.float32(1.0), np.float32(0.5), np.float32(np.inf)
    right, bottom = np.float32(view.width - 0.5), np.float32(view.height - 0.5)
    band, near, far, most = fusion.truncation, fusion.near, fusion.far, fusion.max_weight
    carve, inverse_square = fusion.carve, fusion.inverse_square
    depth, width = view.depth, np.int32(view.width)
    fall = unit / max(band - near, np.float32(1e-30))
    # Three loops: the compiler vectorises the first and the last, but no loop that both looks up pixels and writes.
    pixels, away, depths = (
        np.empty(512, dtype=np.int32),
        np.empty(512, dtype=np.float32),
        np.empty(512, dtype=np.float32),
    )
    for i in range(slots.shape[0]):
        cu, cv, cz = corners[i, 0], corners[i, 1], corners[i, 2]
        for k in range(512):
            z = cz + offsets[2, k]
            inverse = np.divide(unit, z)  # `/` raises at 0, which prevents vectorisation
            u, v = (cu + offsets[0, k]) * inverse, (cv + offsets[1, k]) * inverse
            seen = (z > zero) & (u >= -half) & (u < right) & (v >= -half) & (v < bottom)
            col, row = np.int32(u + half if seen else zero), np.int32(v + half if seen else zero)
            pixels[k] = row * width + col
            away[k] = z if seen else infinite
        for k in range(512):
            depths[k] = depth[np.uint32(pixels[k])]
        line, weight = distances[slots[i]], weights[slots[i]]
        touched = np.int32(0)
        for k in range(512):
            d, z = depths[k], away[k]
            distance = d - z
            old, sure = line[k], weight[k]
            before = distance > band
            inverse = np.divide(unit, z)
            w = inverse * inverse if inverse_square else unit
            w = w * ((band + distance) * fall) if distance < -near else w
            update = (d > zero) & (d <= far) & (distance > -band) & (carve | ~before)
            total = sure + w
            mean = np.divide(sure * old + w * (band if before else distance), total)
            line[k] = mean if update else old
            weight[k] = min(total, most) if update else sure
            touched |= np.int32(update) | np.int32(np.int32(update & ~before) << np.int32(1))
        out_touched[i] = touched
