"""Marching cubes in blocks of voxels, first part: cells that contain the surface, and edges with a vertex.

Signs and cells are bits, eight per byte along x, so that rows of eight cells are processed at once. Numba twins of
:func:`mapper.volume.mesh.textbook.march`. Source: Lorensen & Cline, Marching cubes, SIGGRAPH 1987.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import BlockTable, CubeTables, MeshBlocks


@jit
def neighbours(table: BlockTable, corners: Int64Array, low: int, high: int, out: Int32Array) -> None:
    """Write the slots (n, side³), z y x, of the neighbours at ``low`` … ``high`` of blocks, −1 for missing ones.

    ``corners`` (n, 3) are the keys of the blocks' first voxels.
    """
    for i in range(corners.shape[0]):
        n = 0
        for z in range(low, high + 1):
            for y in range(low, high + 1):
                for x in range(low, high + 1):
                    kx, ky, kz = corners[i, 0] + 8 * x, corners[i, 1] + 8 * y, corners[i, 2] + 8 * z
                    inside = min(kx, ky, kz) >= 0 and max(kx, ky, kz) < 65536
                    out[i, n] = slot_of(table, block_code(kx, ky, kz)) if inside else -1
                    n += 1


@jit
def sign_rows(
    slots: Int32Array, distances: Float32Array, weights: Float32Array, least: np.float32, blocks: MeshBlocks
) -> None:
    """Write the bit rows of blocks: voxels behind the surface, and voxels with a weight of at least ``least``."""
    zero = np.float32(0.0)
    for i in range(slots.shape[0]):
        slot = slots[i]
        distance, weight = distances[slot], weights[slot]
        negative, known = blocks.negative[slot].reshape(64), blocks.known[slot].reshape(64)
        for row in range(64):
            signs, sure = np.uint8(0), np.uint8(0)
            for x in range(8):
                signs |= np.uint8(np.uint8(distance[8 * row + x] < zero) << np.uint8(x))
                sure |= np.uint8(np.uint8(weight[8 * row + x] >= least) << np.uint8(x))
            negative[row], known[row] = signs, sure


@jit
def _padded_rows(rows: UInt8Array, near: Int32Array, out: Int64Array) -> None:
    """Write nine rows of nine bits (9, 9), z y, of a block and its neighbours ``near`` (8,) at 0 and 1."""
    for z in range(9):
        for y in range(9):
            at = (z >> 3) * 4 + (y >> 3) * 2
            a, b = near[at], near[at + 1]
            bits = np.int64(0)
            if a >= 0:
                bits = np.int64(rows[a, z & 7, y & 7])
            if b >= 0:
                bits |= np.int64(rows[b, z & 7, y & 7] & 1) << 8
            out[z, y] = bits


@jit
def surface_cells(
    slots: Int32Array, near: Int32Array, tables: CubeTables, blocks: MeshBlocks, out_counts: Int32Array
) -> None:
    """Write the cells of blocks that contain the surface, and the number of triangles of each block (n,).

    ``near`` (n, 8) are the slots of the blocks at 0 and 1 from each. A cell contains the surface if its eight corners
    are known and of both signs.
    """
    negative, known = np.empty((9, 9), dtype=np.int64), np.empty((9, 9), dtype=np.int64)
    for i in range(slots.shape[0]):
        _padded_rows(blocks.negative, near[i], negative)
        some, every = np.int64(0), np.int64(511)
        for z in range(9):
            for y in range(9):
                some |= negative[z, y]
                every &= negative[z, y]
        count = 0
        cells = blocks.cells[slots[i]]
        cells[:] = 0
        if some != 0 and every != 511:
            _padded_rows(blocks.known, near[i], known)
            for z in range(8):
                for y in range(8):
                    a, b, c, d = negative[z, y], negative[z, y + 1], negative[z + 1, y], negative[z + 1, y + 1]
                    any_, all_four = a | b | c | d, a & b & c & d
                    sure = known[z, y] & known[z, y + 1] & known[z + 1, y] & known[z + 1, y + 1]
                    mixed = (any_ | any_ >> 1) & ~(all_four & all_four >> 1) & sure & (sure >> 1) & 255
                    cells[z, y] = mixed
                    x = 0
                    while mixed != 0:
                        if mixed & 1:
                            case = a >> x & 3 | (b >> x & 3) << 2 | (c >> x & 3) << 4 | (d >> x & 3) << 6
                            count += int(np.int64(tables.counts[case]))
                        mixed >>= 1
                        x += 1
        out_counts[i] = count


@jit
def vertex_rows(
    slots: Int32Array, around: Int32Array, blocks: MeshBlocks, tables: CubeTables, out_rows: UInt8Array,
    out_starts: Int32Array, out_counts: Int32Array,
) -> None:  # fmt: skip
    """Write the edges with a vertex (n, 3, 64), the number in the block before each row, and the number per block.

    An edge has a vertex if its ends have opposite signs and an adjacent cell contains the surface. ``around`` (n, 27)
    are the slots of the blocks at −1 … 1 from each.
    """
    negative, cells = np.empty((9, 9), dtype=np.int64), np.empty((9, 9), dtype=np.int64)
    for i in range(slots.shape[0]):
        for z in range(9):
            for y in range(9):
                # The signs start at 0; the cells start at −1, with bit 0 for x = −1.
                at = (1 + (z >> 3)) * 9 + (1 + (y >> 3)) * 3 + 1
                a, b = around[i, at], around[i, at + 1]
                bits = np.int64(0)
                if a >= 0:
                    bits = np.int64(blocks.negative[a, z & 7, y & 7])
                if b >= 0:
                    bits |= np.int64(blocks.negative[b, z & 7, y & 7] & 1) << 8
                negative[z, y] = bits
                at = (1 if z > 0 else 0) * 9 + (1 if y > 0 else 0) * 3
                a, b = around[i, at], around[i, at + 1]
                bits = np.int64(0)
                if b >= 0:
                    bits = np.int64(blocks.cells[b, (z + 7) & 7, (y + 7) & 7]) << 1
                if a >= 0:
                    bits |= np.int64(blocks.cells[a, (z + 7) & 7, (y + 7) & 7] >> 7)
                cells[z, y] = bits
        n = 0
        for axis in range(3):
            for row in range(64):
                z, y = row >> 3, row & 7
                here = negative[z, y]
                if axis == 0:
                    crossing = here ^ here >> 1
                    used = (cells[z, y] | cells[z, y + 1] | cells[z + 1, y] | cells[z + 1, y + 1]) >> 1
                elif axis == 1:
                    crossing = here ^ negative[z, y + 1]
                    beside = cells[z, y + 1] | cells[z + 1, y + 1]
                    used = beside | beside >> 1
                else:
                    crossing = here ^ negative[z + 1, y]
                    beside = cells[z + 1, y] | cells[z + 1, y + 1]
                    used = beside | beside >> 1
                crossed = crossing & used & 255
                out_rows[i, axis, row], out_starts[i, axis, row] = crossed, n
                n += int(np.int64(tables.bits[crossed]))
        out_counts[i] = n
