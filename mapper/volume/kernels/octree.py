"""Octree of a map in depth-first order, as stored in files: a node, then the trees of its children from 0 to 7.

Numba twins of :func:`mapper.volume.occupancy.textbook.pruned_tree` and of the file formats. A node has a value and the
bits of its children; a leaf has none. The Morton code of a voxel has the bits of its key interleaved, x lowest, so that
depth-first order is the order of the codes. Source: octomap's OcTreeBaseImpl::writeNodesRecurs and
OccupancyOcTreeBase::writeBinaryNode.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit

DEPTH = 16
ENDS_EARLY, NO_CHILDREN, TOO_DEEP = -1, -2, -3  #: errors in the data of a tree


@jit
def _spread(key: int) -> int:
    """Return the 16 bits of a key, each preceded by two zeros."""
    key = (key | key << 16) & 0x0000FF0000FF
    key = (key | key << 8) & 0x00F00F00F00F
    key = (key | key << 4) & 0x0C30C30C30C3
    return (key | key << 2) & 0x249249249249


@jit
def _gather(code: int) -> int:
    """Return every third bit of a Morton code: the inverse of :func:`_spread`."""
    code &= 0x249249249249
    code = (code | code >> 2) & 0x0C30C30C30C3
    code = (code | code >> 4) & 0x00F00F00F00F
    code = (code | code >> 8) & 0x0000FF0000FF
    return (code | code >> 16) & 0xFFFF


@jit
def morton_codes(keys: Int64Array, out: Int64Array) -> None:
    """Write the Morton codes (n,) of keys (n, 3)."""
    for i in range(keys.shape[0]):
        out[i] = _spread(keys[i, 0]) | _spread(keys[i, 1]) << 1 | _spread(keys[i, 2]) << 2


@jit
def morton_keys(codes: Int64Array, out: Int64Array) -> None:
    """Write the keys (n, 3) of Morton codes (n,)."""
    for i in range(codes.shape[0]):
        out[i, 0], out[i, 1], out[i, 2] = _gather(codes[i]), _gather(codes[i] >> 1), _gather(codes[i] >> 2)


@jit
def grow_tree(
    blocks: Int64Array, slots: Int64Array, parts: Int32Array, values: Float32Array, within: Int64Array,
    out_values: Float32Array, out_masks: UInt8Array,
) -> int:  # fmt: skip
    """Write the unpruned tree of all known voxels; return the number of nodes.

    ``blocks`` (n,) are the Morton codes of the first voxels of blocks, ascending, ``slots`` (n,) their rows of
    ``parts`` (slots, 16), which with ``values`` (parts, 32) is as in :class:`Belief`. ``within`` (512,) is the position
    in a block of the voxel of each Morton code: 32 times the index of its part, plus its position there. Values of
    inner nodes are 0.
    """
    path = np.zeros(DEPTH + 1, dtype=np.int64)
    n, last = 0, np.int64(-1)
    for b in range(blocks.shape[0]):
        for k in range(512):
            value = values[parts[slots[b], within[k] >> 5], within[k] & 31]
            if np.isnan(value):
                continue
            code = blocks[b] | k
            depth = 0
            if last >= 0:
                depth = 1
                while code >> 3 * (DEPTH - depth) == last >> 3 * (DEPTH - depth):
                    depth += 1
            for level in range(depth, DEPTH + 1):
                if level > 0:
                    out_masks[path[level - 1]] |= np.uint8(1 << (code >> 3 * (DEPTH - level) & 7))
                path[level] = n
                out_values[n], out_masks[n] = 0.0, 0
                n += 1
            out_values[n - 1] = value
            last = code
    return n


@jit
def prune_tree(
    values: Float32Array, masks: UInt8Array, join: bool, out_values: Float32Array, out_masks: UInt8Array
) -> int:
    """Write the tree with inner nodes set to the maximum of their children; return its number of nodes.

    With ``join`` it is pruned: a parent of eight leaves with equal values becomes a leaf. ``out_values`` and
    ``out_masks`` (n,) have room for the whole tree.
    """
    n = values.shape[0]
    sizes = np.empty(n, dtype=np.int64)  # nodes in the subtree of a node, before pruning
    pending = np.empty(8 * (DEPTH + 1), dtype=np.int64)
    top = 0
    for i in range(n - 1, -1, -1):
        sizes[i], out_masks[i], out_values[i] = 1, masks[i], values[i]
        if masks[i] != 0:
            greatest, least, leaves, size, children = np.float32(-np.inf), np.float32(np.inf), True, 1, 0
            bits = masks[i]
            while bits != 0:
                child = pending[top - 1]
                top -= 1
                greatest, least = max(greatest, out_values[child]), min(least, out_values[child])
                leaves &= out_masks[child] == 0
                size += sizes[child]
                children += 1
                bits &= np.uint8(bits - np.uint8(1))
            sizes[i], out_values[i] = size, greatest
            if join and children == 8 and leaves and greatest == least:
                out_masks[i] = 0
        pending[top] = i
        top += 1
    m, i = 0, 0
    while i < n:
        value, mask = out_values[i], out_masks[i]
        i += sizes[i] if mask == 0 else 1
        out_values[m], out_masks[m] = value, mask
        m += 1
    return m


@jit
def place_nodes(masks: UInt8Array, out_codes: Int64Array, out_depths: UInt8Array) -> None:
    """Write the Morton code of the first voxel of each node (n,) and its depth, 0 for the root."""
    codes, depths = np.empty(8 * (DEPTH + 1), dtype=np.int64), np.empty(8 * (DEPTH + 1), dtype=np.uint8)
    codes[0], depths[0], top = 0, 0, 1
    for i in range(masks.shape[0]):
        top -= 1
        code, depth = codes[top], np.int64(depths[top])
        out_codes[i], out_depths[i] = code, depth
        for k in range(7, -1, -1):
            if masks[i] >> k & 1:
                codes[top], depths[top] = code | np.int64(k) << 3 * (DEPTH - 1 - depth), depth + 1
                top += 1


@jit
def read_ot(data: UInt8Array, out_masks: UInt8Array) -> int:
    """Write the child bits of all nodes of a .ot file; return the number of nodes, or an error code.

    ``data`` has five bytes per node. ``out_masks`` has room for all nodes that fit into it.
    """
    left = np.zeros(DEPTH + 1, dtype=np.int64)  # remaining nodes by depth
    depth, n = 0, 0
    left[0] = 1
    while True:
        while left[depth] == 0:
            if depth == 0:
                return n
            depth -= 1
        if 5 * n + 5 > data.shape[0]:
            return ENDS_EARLY
        left[depth] -= 1
        mask = data[5 * n + 4]
        out_masks[n] = mask
        n += 1
        if mask != 0:
            if depth == DEPTH:
                return TOO_DEEP
            depth += 1
            left[depth] = 0
            while mask != 0:
                left[depth] += 1
                mask &= np.uint8(mask - np.uint8(1))


@jit
def read_bt(
    data: UInt8Array, free: np.float32, occupied: np.float32, out_values: Float32Array, out_masks: UInt8Array
) -> tuple[int, int]:
    """Write the nodes of a .bt file; return their number or an error code, and the number of bytes read.

    ``data`` has two bytes per inner node, with two bits for each child: 0 unknown, 1 free, 2 occupied, 3 with children.
    ``out_values`` and ``out_masks`` have room for 1 + 8 nodes per two bytes. Inner nodes have the value 0.
    """
    pending = np.empty(8 * (DEPTH + 1), dtype=np.int8)  # the states of pending nodes
    depths = np.empty(8 * (DEPTH + 1), dtype=np.int64)
    pending[0], depths[0], top, n, at = 3, 0, 1, 0, 0
    while top > 0:
        top -= 1
        state, depth = pending[top], depths[top]
        out_masks[n], out_values[n] = 0, free if state == 1 else occupied
        if state == 3:
            if at + 2 > data.shape[0]:
                return ENDS_EARLY, at
            if depth == DEPTH:
                return TOO_DEEP, at
            bits = np.int64(data[at]) | np.int64(data[at + 1]) << 8
            if bits == 0 and n > 0:
                return NO_CHILDREN, at
            at += 2
            mask = 0
            for k in range(7, -1, -1):
                if bits >> 2 * k & 3:
                    mask |= 1 << k
                    pending[top], depths[top] = bits >> 2 * k & 3, depth + 1
                    top += 1
            out_masks[n], out_values[n] = mask, 0.0
        n += 1
    return n, at


@jit
def write_bt(values: Float32Array, masks: UInt8Array, occupied: np.float32, out: UInt8Array) -> None:
    """Write the two bytes of each inner node, and of the root, in the .bt format, from the states of the leaves."""
    place = np.empty(8 * (DEPTH + 1), dtype=np.int64)  # of pending nodes: 16 × the position of the parent + 2 × index
    top, m = 0, 0
    for i in range(masks.shape[0]):
        if i > 0:
            top -= 1
            state = 3 if masks[i] != 0 else 2 if values[i] >= occupied else 1
            bit = place[top] & 15
            out[(place[top] >> 4) * 2 + (bit >> 3)] |= np.uint8(state << (bit & 7))
        if masks[i] != 0 or i == 0:
            out[2 * m], out[2 * m + 1] = 0, 0
            for k in range(7, -1, -1):
                if masks[i] >> k & 1:
                    place[top] = m << 4 | 2 * k
                    top += 1
            m += 1


@jit
def fill_leaves(
    codes: Int64Array, depths: UInt8Array, values: Float32Array, blocks: Int64Array, out: Float32Array
) -> None:
    """Write the values of leaves (n,), in Morton order, into the voxels (blocks, 512), in Morton order, of blocks.

    ``codes`` are those of the leaves' first voxels; ``blocks`` are the Morton codes of all touched blocks, divided by
    512, ascending.
    """
    b = 0
    for i in range(codes.shape[0]):
        code = codes[i]
        voxels = np.int64(1) << 3 * (DEPTH - np.int64(depths[i]))
        while blocks[b] < code >> 9:
            b += 1
        first = code & 511
        while voxels > 0:
            n = min(voxels, 512 - first)
            out[b, first : first + n] = values[i]
            voxels -= n
            first = 0
            if voxels > 0:
                b += 1
