"""Surface of a map of truncated signed distances as triangles, for all or some of its blocks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from mapper.core.array_types import Int32Array, Int64Array
from mapper.core.parallel import cores, in_parallel, shares
from mapper.volume.blocks import BLOCK
from mapper.volume.kernels.marching_cubes import (
    neighbours,
    sign_rows,
    surface_cells,
    vertex_rows,
    write_triangles,
    write_vertices,
)
from mapper.volume.kernels.types import MeshBlocks, MeshEdges
from mapper.volume.mesh.cube_cases import cube_tables
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.surface.tsdf import TsdfVolume

_SHARE = 64  # blocks above which a second thread is worthwhile


def surface_mesh(volume: TsdfVolume, slots: Int32Array | None = None, *, least_weight: float = 0.0) -> Mesh:
    """Return the zero level set of the distances by marching cubes, with shared vertices.

    A cell has triangles if its eight voxels are known, with a weight of at least ``least_weight``. Meshed are the cells
    with their first voxel in the blocks ``slots`` (n,), all distinct, or all cells.
    """
    return _meshed(volume, slots, least_weight)[0]


def surface_of_groups(volume: TsdfVolume, groups: Sequence[Int32Array]) -> tuple[Mesh, Int64Array]:
    """Return the surface of disjoint groups of blocks (g), and the end of each group's triangles (g,)."""
    whole, starts = _meshed(volume, np.concatenate([np.empty(0, np.int32), *groups]), 0.0)
    return whole, starts[np.cumsum([len(group) for group in groups], dtype=np.int64)]


def _meshed(volume: TsdfVolume, slots: Int32Array | None, least_weight: float) -> tuple[Mesh, Int64Array]:
    """Return the mesh of ``slots``, None for all, and for each block the number of triangles before it, (n + 1,)."""
    tables, count = cube_tables(), volume.blocks.count
    distances, weights = volume.distances.reshape(-1, BLOCK**3), volume.weights.reshape(-1, BLOCK**3)
    least = np.float32(max(least_weight, float(np.finfo(np.float32).tiny)))
    chosen = np.arange(count, dtype=np.int32) if slots is None else np.ascontiguousarray(slots, dtype=np.int32)
    near = _neighbours(volume, chosen, 0)
    signed = chosen if slots is None else _among(near, count)
    rows = np.zeros((3, count, 8, 8), dtype=np.uint8)
    blocks = MeshBlocks(*rows)
    in_parallel([partial(sign_rows, signed[a:b], distances, weights, least, blocks) for a, b in _parts(len(signed))])
    n_triangles = np.empty(len(chosen), dtype=np.int32)
    in_parallel(
        [
            partial(surface_cells, chosen[a:b], near[a:b], tables, blocks, n_triangles[a:b])
            for a, b in _parts(len(chosen))
        ]
    )
    of_blocks = _starts(n_triangles)
    some = np.flatnonzero(n_triangles)
    chosen, near, starts = chosen[some], near[some], _starts(n_triangles[some])
    owners = _among(near, count)
    around = _neighbours(volume, owners, -1)
    edges = MeshEdges(
        np.empty((len(owners), 3, 64), dtype=np.uint8),
        np.empty((len(owners), 3, 64), dtype=np.int32),
        np.full(count, -1, dtype=np.int32),
    )
    edges.owners[owners] = np.arange(len(owners), dtype=np.int32)
    n_vertices = np.empty(len(owners), dtype=np.int32)
    in_parallel(
        [
            partial(
                vertex_rows, owners[a:b], around[a:b], blocks, tables, edges.rows[a:b], edges.starts[a:b],
                n_vertices[a:b],
            )
            for a, b in _parts(len(owners))
        ]
    )  # fmt: skip
    firsts = _starts(n_vertices)
    vertices = np.empty((firsts[-1], 3), dtype=np.float32)
    normals = np.empty((firsts[-1], 3), dtype=np.float32)
    triangles = np.empty((starts[-1], 3), dtype=np.int32)
    corners, resolution = volume.blocks.corners[owners], volume.config.resolution
    in_parallel(
        [
            partial(
                write_vertices, owners[a:b], around[a:b], corners[a:b], firsts[a : b + 1], edges, a, distances, weights,
                least, resolution, vertices, normals,
            )
            for a, b in _parts(len(owners))
        ]
        + [
            partial(
                write_triangles, chosen[a:b], near[a:b], starts[a : b + 1], blocks, edges, firsts, tables, triangles,
            )
            for a, b in _parts(len(chosen))
        ]
    )  # fmt: skip
    return Mesh(vertices, normals, triangles), of_blocks


def blocks_of_change(volume: TsdfVolume, changed: Int32Array) -> Int32Array:
    """Return the slots (n,), ascending, of the blocks whose mesh may change with the voxels of ``changed`` (n,)."""
    return _among(_neighbours(volume, changed, -1), volume.blocks.count)


def _neighbours(volume: TsdfVolume, slots: Int32Array, low: int) -> Int32Array:
    out = np.empty((len(slots), (2 - low) ** 3), dtype=np.int32)
    corners, table = volume.blocks.corners[slots], volume.blocks.table
    in_parallel([partial(neighbours, table, corners[a:b], low, 1, out[a:b]) for a, b in _parts(len(slots))])
    return out


def _among(slots: Int32Array, count: int) -> Int32Array:
    """Return the distinct slots in an array, ascending, without −1."""
    is_among = np.zeros(count + 1, dtype=np.bool_)
    is_among[slots.reshape(-1)] = True
    return np.flatnonzero(is_among[:-1]).astype(np.int32)


def _starts(counts: Int32Array) -> Int64Array:
    """Return the exclusive cumulative sum (n + 1,) of counts (n,), with the total last."""
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts, dtype=np.int64)])


def _parts(n: int) -> list[tuple[int, int]]:
    return shares(n, min(cores(), 1 + n // _SHARE))
