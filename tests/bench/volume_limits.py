"""Limits of the voxels' kernels on this machine: the same bytes marked, added to and read from a list made before.

What is left of a kernel's time is what it takes to find the voxels, to enter blocks in the hash, and to touch new
memory.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mapper.volume import OccupancyVolume
from mapper.volume.kernels.rays import CENTRE
from mapper.volume.occupancy.queries import HIT as AT_OCCUPIED
from mapper.volume.occupancy.queries import Casts
from tests.bench.limits import HIT, update_listed

BLOCK = np.uint32(1 << 31)  #: of an entry of a list of reads: a block's, not a voxel's
Entries = NDArray[np.uint32]


@njit(cache=True)
def _next_borders(start, away, resolution, voxel, step, border, apart):
    """Write the steps of a ray along the axes, the distances to the first borders and those between two of them."""
    for k in range(3):
        step[k], border[k], apart[k] = 0, np.inf, np.inf
        if away[k] != 0.0:
            step[k] = 1 if away[k] > 0.0 else -1
            apart[k] = resolution / abs(away[k])
            edge = (voxel[k] - CENTRE + (1 if away[k] > 0.0 else 0)) * resolution
            border[k] = (edge - start[k]) / away[k]


@njit(cache=True)
def _list_marks(start, ends, first, lasts, low, shape, resolution, out):
    """Write the places in a box (nz, ny, nx) of the voxels before the last one of each ray; return how many.

    With an empty ``out`` they are only counted.
    """
    count = 0
    voxel, step = np.empty(3, np.int64), np.empty(3, np.int64)
    border, apart = np.empty(3), np.empty(3)
    for i in range(len(ends)):
        voxel[:] = first
        _next_borders(start, ends[i] - start, resolution, voxel, step, border, apart)
        while not (voxel[0] == lasts[i, 0] and voxel[1] == lasts[i, 1] and voxel[2] == lasts[i, 2]):
            if len(out):
                z, y, x = voxel[2] - low[2], voxel[1] - low[1], voxel[0] - low[0]
                out[count] = (z * shape[1] + y) * shape[2] + x
            count += 1
            axis = np.argmin(border)
            if border[axis] > 1.0:
                break
            voxel[axis] += step[axis]
            border[axis] += apart[axis]
    return count


@njit(cache=True)
def _insert(marks, passed, values, changed, miss, hit, low, high):
    """Mark what rays pass, and add to each voxel that changes."""
    for k in range(len(passed)):
        marks[passed[k]] = 1
    update_listed(values, changed, miss, hit, low, high)


def insertion_limit(
    volume: OccupancyVolume, points: NDArray[np.float32], origin: NDArray[np.float32]
) -> tuple[Callable[[], None], float]:
    """Return a function that takes the limit of inserting a scan into an empty map, which ``volume`` is after it.

    Beside it the share of the voxels of the map that are in the list of those that the rays pass or end in.
    """
    config = volume.config
    rays, lasts, hits, _ = volume.rays_of(points, origin)
    first = np.floor(origin.astype(np.float64) / config.resolution).astype(np.int64) + CENTRE
    every = np.concatenate([lasts, hits, first[None]])
    low, high = every.min(axis=0) - 1, every.max(axis=0) + 2
    shape = (high - low)[::-1]
    lists = partial(
        _list_marks, origin.astype(np.float64), rays.astype(np.float64), first, lasts, low, shape, config.resolution
    )
    passed = np.empty(lists(np.empty(0, dtype=np.uint32)), dtype=np.uint32)
    lists(passed)
    marks = np.zeros(int(np.prod(shape)), dtype=np.uint8)
    marks[passed] = 1
    z, y, x = (hits - low).T[::-1]
    marks[(z * shape[1] + y) * shape[2] + x] = 1
    known = volume.belief.values.reshape(-1)
    changed = np.flatnonzero(~np.isnan(known)).astype(np.uint32)
    changed |= np.where(known[changed] > 0.0, HIT, np.uint32(0))
    values = np.zeros(len(known), dtype=np.float32)
    updates = (config.log_odds_miss, config.log_odds_hit, config.log_odds_min, config.log_odds_max)
    work = partial(_insert, marks, passed, values, changed, *map(np.float32, updates))
    return work, int(marks.sum()) / volume.n_known


@njit(cache=True)
def _list_reads(origins, directions, keys, kind, grid, corner, resolution, out, lengths):
    """Write the blocks that rays cross, and the voxels of those that are searched, up to the last one of each ray.

    A block is its place in ``grid`` (nz, ny, nx), a voxel the number of its bit in the words of its ``kind``; return
    how many there are. With an empty ``out`` they are only counted.
    """
    count = 0
    depth, height, width = grid.shape
    voxel, step = np.empty(3, np.int64), np.empty(3, np.int64)
    border, apart = np.empty(3), np.empty(3)
    for i in range(len(origins)):
        before = count
        for k in range(3):
            voxel[k] = int(np.floor(origins[i, k] / resolution)) + CENTRE
        _next_borders(origins[i], directions[i], resolution, voxel, step, border, apart)
        block, held = -1, -2
        while True:
            x, y, z = (voxel[0] >> 3) - corner[0], (voxel[1] >> 3) - corner[1], (voxel[2] >> 3) - corner[2]
            if not (0 <= x < width and 0 <= y < height and 0 <= z < depth):
                break
            here = (z * height + y) * width + x
            if here != block:
                block, held = here, grid[z, y, x]
                if len(out):
                    out[count] = np.uint32(block) | BLOCK
                count += 1
            if held >= 0 and held & (1 + kind) != 0:
                word = ((held >> 2) * 2 + kind) * 8 + (voxel[2] & 7)
                if len(out):
                    out[count] = np.uint32(word << 6 | (voxel[1] & 7) << 3 | voxel[0] & 7)
                count += 1
            if voxel[0] == keys[i, 0] and voxel[1] == keys[i, 1] and voxel[2] == keys[i, 2]:
                break
            axis = np.argmin(border)
            voxel[axis] += step[axis]
            border[axis] += apart[axis]
        if len(out):
            lengths[i] = count - before
    return count


@njit(cache=True)
def _read(words, grid, entries, lengths, out):
    """Read what a list names, and write for each ray (n,) whether the last voxel that it read ends it."""
    at = 0
    for i in range(len(lengths)):
        last = np.uint64(0)
        for k in range(at, at + lengths[i]):
            entry = entries[k]
            if entry & BLOCK:
                last = np.uint64(grid[entry & ~BLOCK] & 3) & np.uint64(0)
            else:
                last = words[entry >> np.uint32(6)] >> np.uint64(entry & np.uint32(63)) & np.uint64(1)
        at += lengths[i]
        out[i] = last


def cast_reads(
    volume: OccupancyVolume,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    found: Casts,
    *,
    through_unknown: bool,
) -> tuple[Entries, NDArray[np.int64]]:
    """Return the blocks and voxels (m,) that casts, which found ``found``, read, and how many each ray reads (n,)."""
    masks = volume.stop_masks()
    corner = np.array([masks.x, masks.y, masks.z])
    kind = 0 if through_unknown else 1
    lengths = np.empty(len(origins), dtype=np.int64)
    lists = partial(
        _list_reads, origins.astype(np.float64), directions.astype(np.float64), found.keys, kind, masks.grid, corner,
        volume.config.resolution,
    )  # fmt: skip
    entries = np.empty(lists(np.empty(0, dtype=np.uint32), lengths), dtype=np.uint32)
    lists(entries, lengths)
    return entries, lengths


def cast_limit(
    volume: OccupancyVolume, entries: Entries, lengths: NDArray[np.int64], found: Casts
) -> tuple[Callable[[], None], float]:
    """Return a function that takes the limit of casts by what they read, and the share of hits that it finds."""
    masks = volume.stop_masks()
    out = np.empty(len(lengths), dtype=np.uint8)
    work = partial(_read, masks.words.reshape(-1), masks.grid.reshape(-1), entries, lengths, out)
    work()
    return work, float(np.mean(out[found.ends == AT_OCCUPIED]))
