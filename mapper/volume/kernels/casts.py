"""Ray casts through a voxel map to the first occupied voxel, or the first occupied or unknown one.

Numba twin of :func:`mapper.volume.occupancy.textbook.cast_ray`. Blocks without a voxel that ends the ray are crossed in
one step; in other blocks the ray is followed voxel by voxel. Source: Amanatides & Woo, A fast voxel traversal algorithm
for ray tracing, 1987, over blocks and over voxels, with the number types and tie order of octomap's castRay.

octomap adds the distance between borders once for each voxel. A step over a block multiplies instead, which rounds
differently, so the order of two borders is the same only if they are farther apart than the error of either sum. A ray
with two borders nearer than :data:`_TIE` voxels is traced again voxel by voxel from its origin.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int32Array, Int64Array, UInt8Array, UInt64Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.rays import CENTRE, _crossing
from mapper.volume.kernels.types import Belief, BlockTable, CastRule, StopMasks

HIT, UNKNOWN, TOO_FAR, OUTSIDE = 1, 2, 3, 4  #: how a cast ray ends
_LAST, _BLOCKS = 2 * CENTRE - 1, 8191  # the maximum key, and the maximum block coordinate along an axis
# The error of a sum of n distances is at most n times half the last place of the largest: 5e-7 voxels for 65,536 of
# them along the longest ray in the lattice.
_TIE = 1e-5
_LAYER = np.uint64(0xFFFF)  # the bits of the lower layer of a part
_ABSENT = -2  # no block: its slot is negative, and rays stop in it if they stop at unknown voxels


@jit
def stop_masks(
    parts: Int32Array, values: Float32Array, occupied: float, stale: BoolArray, words: UInt64Array, found: UInt8Array
) -> None:
    """Write the arrays of :class:`StopMasks` for those blocks (n,) that are ``stale``.

    ``parts`` (n, 16) are their parts in ``values``, as in :class:`Belief`; ``occupied`` is the log-odds threshold of
    occupied voxels.
    """
    for i in range(parts.shape[0]):
        if not stale[i]:
            continue
        any_occupied, any_stop = np.uint64(0), np.uint64(0)
        words[i] = 0
        for p in range(16):
            part, z, shift = values[parts[i, p]].reshape(32), p >> 2 << 1, np.uint64((p & 3) << 4)
            full, stop = np.uint64(0), np.uint64(0)
            for k in range(32):
                full |= np.uint64(part[k] >= occupied) << np.uint64(k)
                stop |= np.uint64(not part[k] < occupied) << np.uint64(k)  # also for NaN
            words[i, 0, z] |= (full & _LAYER) << shift
            words[i, 1, z] |= (stop & _LAYER) << shift
            words[i, 0, z + 1] |= full >> np.uint64(16) << shift
            words[i, 1, z + 1] |= stop >> np.uint64(16) << shift
            any_occupied |= full
            any_stop |= stop
        found[i] = (1 if any_occupied else 0) + (2 if any_stop else 0)


@jit
def index_blocks(codes: Int64Array, found: UInt8Array, x: int, y: int, z: int, out: Int32Array) -> None:
    """Write the grid of :class:`StopMasks`, starting at the block (``x``, ``y``, ``z``); it contains all blocks
    (n,).
    """
    out[:] = _ABSENT
    for slot in range(codes.shape[0]):
        code = codes[slot]
        out[(code >> 26) - z, (code >> 13 & _BLOCKS) - y, (code & _BLOCKS) - x] = slot << 2 | np.int64(found[slot])


@jit
def _indexed(table: BlockTable, masks: StopMasks, x: int, y: int, z: int) -> int:
    """Return 4 · slot + found of the block at (x, y, z), :data:`_ABSENT` if there is none."""
    if masks.grid.size > 0:
        i, j, k = x - masks.x, y - masks.y, z - masks.z
        depth, height, width = masks.grid.shape
        if ((i | j | k) >= 0) & (i < width) & (j < height) & (k < depth):
            return int(masks.grid[np.uint64(k), np.uint64(j), np.uint64(i)])
        return _ABSENT
    if (x | y | z) & ~_BLOCKS != 0:
        return _ABSENT
    slot = slot_of(table, z << 26 | y << 13 | x)
    return slot << 2 | int(np.int64(masks.found[slot])) if slot >= 0 else _ABSENT


@jit
def _squared_range(x: int, y: int, z: int, ox: float, oy: float, oz: float, resolution: float) -> float:
    """Return the squared distance from an origin to the centre of a voxel, with squares in float32 and a float64
    sum.
    """
    ax = np.float32((x - CENTRE + 0.5) * resolution) - ox
    ay = np.float32((y - CENTRE + 0.5) * resolution) - oy
    az = np.float32((z - CENTRE + 0.5) * resolution) - oz
    return np.float64(ax * ax) + np.float64(ay * ay) + np.float64(az * az)  # numba's float() leaves a float32 as it is


@jit
def _crossed(at: float, first: float, per_voxel: float) -> tuple[int, bool]:
    """Return how many borders of an axis a ray crosses before the distance ``at``, and whether one is at ``at``.

    ``first`` is the distance to the first border; there are ``per_voxel`` of them per metre.
    """
    if per_voxel == 0.0 or at == -np.inf:  # parallel to the borders, or before the ray's origin
        return 0, False
    passed = (at - first) * per_voxel
    whole = np.floor(passed)
    rest = passed - whole
    return (int(whole) + 1 if passed >= 0.0 else 0), (rest < _TIE) | (rest > 1.0 - _TIE)


@jit
def _cast_by_voxels(
    belief: Belief, origin: Float32Array, start: tuple[int, int, int], steps: tuple[int, int, int],
    firsts: tuple[float, float, float], apart: tuple[float, float, float], rule: CastRule,
) -> tuple[int, int, int, int]:  # fmt: skip
    """Return the last voxel of a ray and how it ends, with distances accumulated voxel by voxel."""
    ox, oy, oz = origin[0], origin[1], origin[2]
    x, y, z = start
    tx, ty, tz = firsts
    reach = rule.range_max * rule.range_max
    slot, code = -1, -2
    moved = False
    while True:
        if min(x, y, z) < 0 or max(x, y, z) > _LAST:
            return min(max(x, 0), _LAST), min(max(y, 0), _LAST), min(max(z, 0), _LAST), OUTSIDE
        if moved and rule.range_max > 0.0 and _squared_range(x, y, z, ox, oy, oz, rule.resolution) > reach:
            return x, y, z, TOO_FAR
        here = block_code(x, y, z)
        if here != code:
            code, slot = here, slot_of(belief.table, here)
        part = belief.parts[slot, (z >> 1 & 3) << 2 | y >> 1 & 3] if slot >= 0 else 0
        value = belief.values[part, z & 1, y & 1, x & 7]
        if value >= rule.occupied:
            return x, y, z, HIT
        if np.isnan(value) and not rule.through_unknown:
            return x, y, z, UNKNOWN
        moved = True
        if tx < ty and tx < tz:
            x, tx = x + steps[0], tx + apart[0]
        elif not tx < ty and ty < tz:
            y, ty = y + steps[1], ty + apart[1]
        else:
            z, tz = z + steps[2], tz + apart[2]


@jit
def cast_rays(
    belief: Belief, masks: StopMasks, origins: Float32Array, directions: Float32Array, rule: CastRule,
    out_keys: Int64Array, out_points: Float32Array, out_ends: UInt8Array,
) -> None:  # fmt: skip
    """Write the last voxels of rays, their keys (n, 3) and centres (n, 3) in metres, and how the rays end (n,).

    ``origins`` and ``directions`` (n, 3) are finite; directions have any length but 0. A ray with its origin outside
    the lattice gets the key 0.
    """
    resolution, through = rule.resolution, rule.through_unknown
    factor, top = 1.0 / resolution, float(CENTRE)
    reach, tie = rule.range_max * rule.range_max, _TIE * resolution
    # The centres of voxels entered before this distance are in range.
    near = rule.range_max - 2.0 * resolution if rule.range_max > 0.0 else np.inf
    kind, mask = (0, 1) if through else (1, 2)
    for i in range(origins.shape[0]):
        ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
        fx, fy, fz = np.floor(factor * float(ox)), np.floor(factor * float(oy)), np.floor(factor * float(oz))
        end = 0 if (min(fx, fy, fz) >= -top) & (max(fx, fy, fz) < top) else OUTSIDE
        if end != 0:
            fx, fy, fz = -top, -top, -top
        x, y, z = int(fx) + CENTRE, int(fy) + CENTRE, int(fz) + CENTRE
        x0, y0, z0 = x, y, z
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        length = np.float32(sqrt(float(dx * dx + dy * dy + dz * dz)))
        dx, dy, dz = dx / length, dy / length, dz / length
        step_x, first_x, apart_x = _crossing(x, ox, dx, resolution, 0.5 * resolution)
        step_y, first_y, apart_y = _crossing(y, oy, dy, resolution, 0.5 * resolution)
        step_z, first_z, apart_z = _crossing(z, oz, dz, resolution, 0.5 * resolution)
        per_x, per_y, per_z = abs(float(dx)) * factor, abs(float(dy)) * factor, abs(float(dz)) * factor
        bx, by, bz = x >> 3, y >> 3, z >> 3
        # Distances to the block's borders. A ray parallel to an axis never crosses the borders of that axis.
        out_x = first_x + (7 - (x & 7) if step_x > 0 else x & 7) * apart_x if step_x != 0 else np.inf
        out_y = first_y + (7 - (y & 7) if step_y > 0 else y & 7) * apart_y if step_y != 0 else np.inf
        out_z = first_z + (7 - (z & 7) if step_z > 0 else z & 7) * apart_z if step_z != 0 else np.inf
        entered, along_x, along_y, tied = -np.inf, False, False, False
        k = 0  # index of the voxel in the block
        while end == 0:
            leaves = min(out_x, out_y, out_z)
            inside = (bx | by | bz) & ~_BLOCKS == 0
            held = _indexed(belief.table, masks, bx, by, bz)
            slot = held >> 2
            search = (held & mask != 0) | (not inside)
            if search or leaves > near:
                # The voxel where the ray enters the block, initially that of the origin.
                nx, at_x = _crossed(entered, first_x, per_x)
                ny, at_y = _crossed(entered, first_y, per_y)
                nz, at_z = _crossed(entered, first_z, per_z)
                tied |= (at_x & (not along_x)) | (at_y & (not along_y)) | (at_z & (along_x | along_y))
                x = min(max(x0 + nx * step_x - 8 * bx, 0), 7)
                y = min(max(y0 + ny * step_y - 8 * by, 0), 7)
                z = min(max(z0 + nz * step_z - 8 * bz, 0), 7)
                k = z << 6 | y << 3 | x
                if not inside:
                    end = OUTSIDE
                    break
                tx = first_x + (8 * bx + x - x0) * step_x * apart_x if step_x != 0 else np.inf
                ty = first_y + (8 * by + y - y0) * step_y * apart_y if step_y != 0 else np.inf
                tz = first_z + (8 * bz + z - z0) * step_z * apart_z if step_z != 0 else np.inf
                while True:
                    if entered > near:
                        x, y, z = 8 * bx + (k & 7), 8 * by + (k >> 3 & 7), 8 * bz + (k >> 6)
                        if _squared_range(x, y, z, ox, oy, oz, resolution) > reach:
                            end = TOO_FAR
                            break
                    if slot >= 0:
                        if masks.words[slot, kind, k >> 6] >> np.uint64(k & 63) & np.uint64(1):
                            end = HIT if masks.words[slot, 0, k >> 6] >> np.uint64(k & 63) & np.uint64(1) else UNKNOWN
                            break
                    elif not through:
                        end = UNKNOWN
                        break
                    x_first, sooner = tx < ty, min(tx, ty)
                    not_z = sooner < tz
                    entered = min(sooner, tz)
                    tied |= (abs(tx - ty) < tie) | (abs(sooner - tz) < tie)
                    if entered > leaves - tie:
                        break
                    # There are no branches, because the next axis is not predictable.
                    x_next, y_next = x_first & not_z, (not x_first) & not_z
                    k += (step_x if x_first else 8 * step_y) if not_z else 64 * step_z
                    after_x, after_y, after_z = tx + apart_x, ty + apart_y, tz + apart_z
                    tx = after_x if x_next else tx
                    ty = after_y if y_next else ty
                    tz = tz if not_z else after_z
                if end != 0:
                    break
            entered = leaves
            x_first, sooner = out_x < out_y, min(out_x, out_y)
            not_z = sooner < out_z
            tied |= (abs(out_x - out_y) < tie) | (abs(sooner - out_z) < tie)
            along_x, along_y = x_first & not_z, (not x_first) & not_z
            bx += step_x if along_x else 0
            by += step_y if along_y else 0
            bz += 0 if not_z else step_z
            after_x, after_y, after_z = out_x + 8.0 * apart_x, out_y + 8.0 * apart_y, out_z + 8.0 * apart_z
            out_x = after_x if along_x else out_x
            out_y = after_y if along_y else out_y
            out_z = out_z if not_z else after_z
        if tied:
            x, y, z, end = _cast_by_voxels(
                belief, origins[i], (x0, y0, z0), (step_x, step_y, step_z), (first_x, first_y, first_z),
                (apart_x, apart_y, apart_z), rule,
            )  # fmt: skip
        else:
            x = min(max(8 * bx + (k & 7), 0), _LAST)
            y = min(max(8 * by + (k >> 3 & 7), 0), _LAST)
            z = min(max(8 * bz + (k >> 6), 0), _LAST)
        out_keys[i, 0], out_keys[i, 1], out_keys[i, 2], out_ends[i] = x, y, z, end
        out_points[i, 0] = np.float32((x - CENTRE + 0.5) * resolution)
        out_points[i, 1] = np.float32((y - CENTRE + 0.5) * resolution)
        out_points[i, 2] = np.float32((z - CENTRE + 0.5) * resolution)
