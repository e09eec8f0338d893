"""Integration of beams and depth images into truncated signed distance fields.

Of a beam, the voxels around its end, beam by beam; numba twin of
:func:`mapper.volume.surface.textbook.fuse_points`. Source: Curless & Levoy, SIGGRAPH 1996: signed distances along the
line of sight; Amanatides & Woo, 1987, for the voxels on a line.

Of a depth image, the blocks that its surface may touch, and their update; numba twins of
:func:`mapper.volume.surface.textbook.fuse_depth`. Source: Newcombe et al., KinectFusion, ISMAR 2011, section 3.3: a
voxel takes the depth of the pixel that its centre is seen in.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import BlockTable, Box, DepthView, Fusion

Axis = tuple[int, float, float]  #: step, parameter of the first border and between borders, 0 to 1 along the line


@jit
def _border(at: float, along: float) -> Axis:
    """Return one axis of a line from ``at`` with extent ``along``, in keys."""
    if along == 0.0:
        return 0, np.inf, np.inf
    step = 1 if along > 0.0 else -1
    border = np.floor(at + 0.5) + 0.5 * step
    return step, (border - at) / along, abs(1.0 / along)


@jit
def _line(
    origin: Float64Array, end: Float64Array, resolution: float, fusion: Fusion
) -> tuple[float, tuple[float, float, float], tuple[int, int, int], tuple[Axis, Axis, Axis]]:
    """Return a beam's length in metres, its direction in keys, the first voxel to update, and the axes from there.

    The length is 0 for a beam that updates nothing, because it has no length or is too long.
    """
    dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
    length = sqrt(dx * dx + dy * dy + dz * dz) * resolution
    if length > fusion.far:
        length = 0.0
    reach = np.float64(fusion.truncation) / length if length > 0.0 else 0.0
    a, b = 0.0 if fusion.carve else max(1.0 - reach, 0.0), 1.0 + reach
    px, py, pz = origin[0] + a * dx, origin[1] + a * dy, origin[2] + a * dz
    first = int(np.floor(px + 0.5)), int(np.floor(py + 0.5)), int(np.floor(pz + 0.5))
    axes = _border(px, (b - a) * dx), _border(py, (b - a) * dy), _border(pz, (b - a) * dz)
    return length, (dx, dy, dz), first, axes


@jit
def beam_blocks(origin: Float64Array, ends: Float64Array, resolution: float, fusion: Fusion, out: Int64Array) -> int:
    """Write the codes of the blocks with voxels that beams pass within the truncation of their ends; return their
    number.

    ``origin`` (3,) and ``ends`` (n, 3) are in keys. ``out`` must be long enough. The voxels are those of
    :func:`fuse_beams`, to the last bit.
    """
    band, n = np.float64(fusion.truncation), 0
    for i in range(ends.shape[0]):
        length, (dx, dy, dz), (x, y, z), axes = _line(origin, ends[i], resolution, fusion)
        if length == 0.0:
            continue
        (step_x, tx, apart_x), (step_y, ty, apart_y), (step_z, tz, apart_z) = axes
        last = -1
        while True:
            code = block_code(x, y, z)
            if code != last:
                along = (ends[i, 0] - x) * dx + (ends[i, 1] - y) * dy + (ends[i, 2] - z) * dz
                distance = along * resolution * resolution / length
                if distance > -band and distance <= band:
                    out[n], last = code, code
                    n += 1
            t = min(tx, ty, tz)
            if t > 1.0:
                break
            if tx == t:
                x, tx = x + step_x, tx + apart_x
            elif ty == t:
                y, ty = y + step_y, ty + apart_y
            else:
                z, tz = z + step_z, tz + apart_z
    return n


@jit
def fuse_beams(
    table: BlockTable, origin: Float64Array, ends: Float64Array, resolution: float, fusion: Fusion,
    distances: Float32Array, weights: Float32Array, out_touched: BoolArray,
) -> None:  # fmt: skip
    """Update the voxels that beams pass, in the order of the beams, and write which blocks (slots,) have changed.

    ``origin`` (3,) and ``ends`` (n, 3) are in keys; ``distances`` and ``weights`` (slots, 512) are the map. Each beam
    that passes a voxel updates it: within the truncation of its end and, if ``fusion.carve``, also farther before it,
    in the blocks of the table.
    """
    band, near = np.float64(fusion.truncation), np.float64(fusion.near)
    most = np.float64(fusion.max_weight)
    for i in range(ends.shape[0]):
        length, (dx, dy, dz), (x, y, z), axes = _line(origin, ends[i], resolution, fusion)
        if length == 0.0:
            continue
        (step_x, tx, apart_x), (step_y, ty, apart_y), (step_z, tz, apart_z) = axes
        base = 1.0 / (length * length) if fusion.inverse_square else 1.0
        code, slot = -1, -1
        while True:
            here = block_code(x, y, z)
            if here != code:
                code = here
                slot = slot_of(table, code)
            if slot >= 0:
                cell = (z & 7) << 6 | (y & 7) << 3 | (x & 7)
                along = (ends[i, 0] - x) * dx + (ends[i, 1] - y) * dy + (ends[i, 2] - z) * dz
                distance = along * resolution * resolution / length
                sure = np.float64(weights[slot, cell])
                if distance > -band and (distance <= band or fusion.carve):
                    w = base * (band + distance) / (band - near) if distance < -near else base
                    mean = (sure * np.float64(distances[slot, cell]) + w * min(distance, band)) / (sure + w)
                    distances[slot, cell] = mean
                    weights[slot, cell] = min(sure + w, most)
                    out_touched[slot] = True
            t = min(tx, ty, tz)
            if t > 1.0:
                break
            if tx == t:
                x, tx = x + step_x, tx + apart_x
            elif ty == t:
                y, ty = y + step_y, ty + apart_y
            else:
                z, tz = z + step_z, tz + apart_z


TILE = 8  #: pixels along a side of the tiles of which blocks are found
_PIECE = 4.0  # voxels of depth that are laid into one box
_SLACK = 1e-3  # voxels and pixels, for rounding


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
    """Return how many depths (n,) are positive and at most ``far``, and the greatest of them, 0 without any."""
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

    Only the rows of tiles ``first`` … ``last`` − 1 are looked at; several threads may mark one box.
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
            # One pyramid for each layer of depths that are near each other: one tile may see several surfaces.
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
    """Update the voxels of blocks by a depth image; write 1 for each that changed (n,), 3 where by the surface itself.

    ``corners`` (n, 3) are the first voxels' centres, u z, v z, z, in pixels and metres of the camera; ``offsets``
    (3, 512) what the others have more. ``distances`` and ``weights`` (slots, 512) are the map.
    """
    zero, unit, half, infinite = np.float32(0.0), np.float32(1.0), np.float32(0.5), np.float32(np.inf)
    right, bottom = np.float32(view.width - 0.5), np.float32(view.height - 0.5)
    band, near, far, most = fusion.truncation, fusion.near, fusion.far, fusion.max_weight
    carve, inverse_square = fusion.carve, fusion.inverse_square
    depth, width = view.depth, np.int32(view.width)
    fall = unit / max(band - near, np.float32(1e-30))
    # Three loops: the compiler vectorises the first and the last, but no loop that looks up pixels and writes.
    pixels, away, depths = (
        np.empty(512, dtype=np.int32),
        np.empty(512, dtype=np.float32),
        np.empty(512, dtype=np.float32),
    )
    for i in range(slots.shape[0]):
        cu, cv, cz = corners[i, 0], corners[i, 1], corners[i, 2]
        for k in range(512):
            z = cz + offsets[2, k]
            inverse = np.divide(unit, z)  # `/` raises at 0, and no such loop is vectorised
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
