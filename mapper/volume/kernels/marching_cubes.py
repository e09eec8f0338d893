"""Marching cubes in blocks of voxels: which cells have a surface, which edges a vertex; vertices, normals, triangles.

Signs and cells are bits, eight per byte along x, so that rows of eight cells are processed at once. Numba twins of
:func:`mapper.volume.mesh.textbook.march`. Source: Lorensen & Cline, Marching cubes, SIGGRAPH 1987: vertices by linear
interpolation along edges, normals by that of the gradients at their ends.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import BlockTable, CubeTables, MeshBlocks, MeshEdges


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


_ROW, _LAYER = 11, 121  # of a block padded by one voxel before and two behind, along each axis


@jit
def _padded_block(
    around: Int32Array, distances: Float32Array, weights: Float32Array, least: np.float32, out: Float32Array
) -> None:
    """Write the distances (11³,), z y x, from −1 to 9 of a block; NaN if the weight is less than ``least``."""
    nan = np.float32(np.nan)
    for z in range(-1, 10):
        for y in range(-1, 10):
            at = ((z >> 3) + 1) * 9 + ((y >> 3) + 1) * 3
            row = (z & 7) * 64 + (y & 7) * 8
            to = (z + 1) * _LAYER + (y + 1) * _ROW
            left, middle, right = around[at], around[at + 1], around[at + 2]
            out[to] = distances[left, row + 7] if left >= 0 and weights[left, row + 7] >= least else nan
            if middle >= 0:
                distance, weight = distances[middle, row : row + 8], weights[middle, row : row + 8]
                for x in range(8):
                    out[to + 1 + x] = distance[x] if weight[x] >= least else nan
            else:
                out[to + 1 : to + 9] = nan
            for x in range(2):
                out[to + 9 + x] = distances[right, row + x] if right >= 0 and weights[right, row + x] >= least else nan


@jit
def _slope(before: np.float32, here: np.float32, after: np.float32) -> np.float32:
    """Return the difference per voxel: central, or one-sided towards a known neighbour, or 0."""
    forward, backward = after - here, here - before
    known_forward, known_backward = forward == forward, backward == backward  # noqa: PLR0124 - NaN is not itself
    both = (after - before) * np.float32(0.5)
    distance = forward if known_forward else (backward if known_backward else np.float32(0.0))
    return both if known_forward & known_backward else distance


@jit
def write_vertices(
    slots: Int32Array, around: Int32Array, corners: Int64Array, firsts: Int64Array, edges: MeshEdges, begin: int,
    distances: Float32Array, weights: Float32Array, least: np.float32, resolution: float, out: Float32Array,
    out_normals: Float32Array,
) -> None:  # fmt: skip
    """Write the vertices (m, 3), metres, and their unit normals (m, 3), which point to the sensor's side.

    The blocks are those of the rows of ``edges`` from ``begin`` on; ``corners`` (n, 3) are the keys of their first
    voxels, ``around`` (n, 27) the slots around them and ``firsts`` (n + 1,) the indices of their first vertices.
    """
    field = np.empty(_ROW * _LAYER, dtype=np.float32)
    a, b = np.empty(3, dtype=np.float32), np.empty(3, dtype=np.float32)
    for i in range(slots.shape[0]):
        n = firsts[i]
        if n == firsts[i + 1]:
            continue
        _padded_block(around[i], distances, weights, least, field)
        for axis in range(3):
            along = 1 if axis == 0 else (_ROW if axis == 1 else _LAYER)
            for row in range(64):
                bits = np.int64(edges.rows[begin + i, axis, row])
                x = 0
                while bits != 0:
                    if bits & 1:
                        here = ((row >> 3) + 1) * _LAYER + ((row & 7) + 1) * _ROW + x + 1
                        there = here + along
                        da, db = field[here], field[there]
                        t = da / (da - db)
                        a[0] = _slope(field[here - 1], da, field[here + 1])
                        a[1] = _slope(field[here - _ROW], da, field[here + _ROW])
                        a[2] = _slope(field[here - _LAYER], da, field[here + _LAYER])
                        b[0] = _slope(field[there - 1], db, field[there + 1])
                        b[1] = _slope(field[there - _ROW], db, field[there + _ROW])
                        b[2] = _slope(field[there - _LAYER], db, field[there + _LAYER])
                        gx, gy, gz = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])
                        length = sqrt(np.float64(gx * gx + gy * gy + gz * gz))
                        if length > 0.0:
                            scale = 1.0 / length
                            out_normals[n, 0] = gx * scale
                            out_normals[n, 1] = gy * scale
                            out_normals[n, 2] = gz * scale
                        else:
                            out_normals[n] = np.float32(0.0)
                            out_normals[n, axis] = np.float32(1.0) if db > da else np.float32(-1.0)
                        out[n, 0] = (corners[i, 0] - 32767.5 + x + (t if axis == 0 else 0.0)) * resolution
                        out[n, 1] = (corners[i, 1] - 32767.5 + (row & 7) + (t if axis == 1 else 0.0)) * resolution
                        out[n, 2] = (corners[i, 2] - 32767.5 + (row >> 3) + (t if axis == 2 else 0.0)) * resolution
                        n += 1
                    bits >>= 1
                    x += 1


@jit
def write_triangles(
    slots: Int32Array, near: Int32Array, starts: Int64Array, blocks: MeshBlocks, edges: MeshEdges,
    firsts: Int64Array, tables: CubeTables, out: Int32Array,
) -> None:  # fmt: skip
    """Write the triangles (m, 3) as vertex indices, counter-clockwise seen from the sensor's side.

    ``near`` (n, 8) are the slots at 0 and 1 from the blocks, ``starts`` (n + 1,) the indices of their first triangles,
    ``firsts`` (owners + 1,) those of the first vertices of the rows of ``edges``.
    """
    owner = np.empty(8, dtype=np.int64)
    signs = np.empty(4, dtype=np.int64)  # of nine voxels each, for the rows at y and y + 1, and the same at z + 1
    # For the edges along an axis in one of these rows: the bits, the index of the first vertex and of the one at 8.
    bits, here, beyond = np.zeros((3, 12), dtype=np.int64)
    line, step = np.empty(12, dtype=np.int64), np.empty(12, dtype=np.int64)
    for k in range(12):
        corner = np.int64(tables.firsts[k])
        line[k], step[k] = 4 * (k >> 2) + (corner >> 1), corner & 1
    for i in range(slots.shape[0]):
        n = starts[i]
        if n == starts[i + 1]:
            continue
        for k in range(8):
            owner[k] = edges.owners[near[i, k]] if near[i, k] >= 0 else -1
        for row in range(64):
            mixed = np.int64(blocks.cells[slots[i], row >> 3, row & 7])
            if mixed == 0:
                continue
            for k in range(4):
                y, z = (row & 7) + (k & 1), (row >> 3) + (k >> 1)
                at, inner = (z >> 3) * 4 + (y >> 3) * 2, (z & 7) * 8 + (y & 7)
                signs[k] = 0
                if near[i, at] >= 0:
                    signs[k] = np.int64(blocks.negative[near[i, at], z & 7, y & 7])
                if near[i, at + 1] >= 0:
                    signs[k] |= (np.int64(blocks.negative[near[i, at + 1], z & 7, y & 7]) & 1) << 8
                before, after = owner[at], owner[at + 1]
                for axis in range(3):
                    if axis != 0 and k >> (axis - 1) & 1:
                        continue  # an edge of the cell along y or z starts at the cell's own y or z
                    if before >= 0:
                        bits[4 * axis + k] = edges.rows[before, axis, inner]
                        here[4 * axis + k] = firsts[before] + edges.starts[before, axis, inner]
                    if after >= 0:
                        beyond[4 * axis + k] = firsts[after] + edges.starts[after, axis, inner]
            x = 0
            while mixed != 0:
                if mixed & 1:
                    case = np.int64(0)
                    for k in range(4):
                        case |= (signs[k] >> x & 3) << 2 * k
                    for first in range(0, 3 * np.int64(tables.counts[case]), 3):
                        for k in range(3):
                            edge = np.int64(tables.edges[case, first + k])
                            to, place = line[edge], x + step[edge]
                            number = beyond[to]
                            if place < 8:
                                number = here[to] + np.int64(tables.bits[bits[to] & ((1 << place) - 1)])
                            out[n, k] = number
                        n += 1
                mixed >>= 1
                x += 1
