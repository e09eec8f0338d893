"""Named tuples that the compiled functions of volumes take as arguments."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array, UInt8Array, UInt64Array


class BlockTable(NamedTuple):
    """A hash table with open addressing: the codes of blocks, −1 for empty entries, and the slots of their voxels.

    Both arrays have a power-of-two length of at least twice the number of blocks.
    """

    codes: Int64Array
    slots: Int32Array


class Box(NamedTuple):
    """A box of voxels: the key of its first voxel and its sides, all multiples of 8."""

    x: int
    y: int
    z: int
    nx: int
    ny: int
    nz: int


class Belief(NamedTuple):
    """The log-odds of voxels, NaN if unknown; for each block (slots,) their maximum and the number of known voxels.

    ``values`` (parts, 2, 2, 8), z y x, are parts of blocks and ``parts`` (slots, 16) their indices: the voxel (x, y, z)
    of a block is ``values[parts[slot, z >> 1 << 2 | y >> 1], z & 1, y & 1, x]``. Part 0 is all unknown.
    """

    table: BlockTable
    parts: Int32Array
    values: Float32Array
    maxima: Float32Array
    known: Int32Array


class StopMasks(NamedTuple):
    """Voxels that end a cast ray: a bit for each voxel of a block, and a byte that is non-zero if there are any.

    Words ``words[:, 0]`` (slots, 8), z, have bit 8 y + x set for occupied voxels, ``words[:, 1]`` for occupied or
    unknown ones. ``found`` (slots,) has bit 0 set if a block has any of the first kind, bit 1 for the second. ``grid``
    (nz, ny, nx) has 4 · slot + found for each block in the bounding box of all blocks, and −2, which also has bit 1
    set, for missing ones. Its first block is at (``x``, ``y``, ``z``), in blocks. It is empty if the box would be much
    larger than the map; blocks are then looked up in the hash table.
    """

    words: UInt64Array
    found: UInt8Array
    grid: Int32Array
    x: int
    y: int
    z: int


class CastRule(NamedTuple):
    """End of a cast ray: at log-odds of ``occupied`` or more, at unknown voxels, and beyond ``range_max`` > 0,
    metres.
    """

    resolution: float
    occupied: float
    through_unknown: bool
    range_max: float


class Updates(NamedTuple):
    """Log-odds increments of voxels by a scan, and their limits."""

    miss: np.float32
    hit: np.float32
    least: np.float32
    greatest: np.float32


class FaceRule(NamedTuple):
    """Drawn voxels, and their colours, numbers from 1 to ``colours``.

    Drawn are voxels with log-odds of ``occupied`` or more and a key x, y, z in ``first`` … ``last``. The colour
    increases by 1 for each ``band`` voxels of height above the key ``base`` or, if ``by_belief``, with the log-odds up
    to ``greatest``. If ``seen_only``, faces towards unknown voxels are omitted, because no sensor has seen them.
    """

    occupied: float
    greatest: float
    first: tuple[int, int, int]
    last: tuple[int, int, int]
    base: int
    band: int
    colours: int
    by_belief: bool
    seen_only: bool


class Fusion(NamedTuple):
    """Update of truncated signed distances by surface measurements; lengths in metres.

    ``near`` is the distance behind the surface at which weights begin to decrease, or the truncation itself if they do
    not.
    """

    truncation: np.float32
    near: np.float32
    max_weight: np.float32
    far: np.float32
    inverse_square: bool
    carve: bool


class DepthView(NamedTuple):
    """A depth image (height × width,), metres, row-major, and its camera relative to the voxels.

    ``rays`` (3, 3) float64 maps (u, v, 1) to the direction of that pixel at a depth of 1 m, in voxels of the lattice;
    ``origin`` (3,) is the camera's position in keys, such that the centre of the voxel of key k is at k.
    """

    depth: Float32Array
    width: int
    height: int
    rays: Float64Array
    origin: Float64Array


class CubeTables(NamedTuple):
    """The cases of marching cubes, see :mod:`mapper.volume.mesh.cube_cases`.

    They are the number of triangles (256,), their edges (256, 3 × the maximum number), the first corner of each edge
    (12,), and the number of set bits of each byte (256,).
    """

    counts: UInt8Array
    edges: UInt8Array
    firsts: UInt8Array
    bits: UInt8Array


class MeshBlocks(NamedTuple):
    """Blocks of a mesh during meshing, by the slots of their voxels.

    ``negative``, ``known`` and ``cells`` (slots, 8, 8), z y, are rows of eight bits, x ascending: voxels behind the
    surface, voxels with a weight, and cells that contain the surface (at a cell's first voxel).
    """

    negative: UInt8Array
    known: UInt8Array
    cells: UInt8Array


class MeshEdges(NamedTuple):
    """The vertices of a mesh, on edges between voxels, by the position of the edges' first voxel.

    ``rows`` (owners, 3, 64) are bits as in :class:`MeshBlocks` for edges along x, y and z, ``starts`` (owners, 3, 64)
    the index of the first vertex of each row. ``owners`` (slots,) are rows of these, −1 for blocks without vertices.
    """

    rows: UInt8Array
    starts: Int32Array
    owners: Int32Array
