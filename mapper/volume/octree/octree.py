"""Octree of a map, in which eight equal voxels are one node, as in OctoMap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Int64Array, UInt8Array
from mapper.core.errors import LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.volume.blocks import BLOCK
from mapper.volume.kernels.octree import (
    DEPTH,
    fill_leaves,
    grow_tree,
    morton_codes,
    morton_keys,
    place_nodes,
    prune_tree,
)
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.occupancy.volume import OccupancyVolume

_VOXELS = BLOCK**3
_BLOCK_DEPTH = DEPTH - 3  # of a node that is one block


def _voxels_in_morton_order() -> Int64Array:
    """Return the index in a block, z y x, of the voxel of each Morton code (512,)."""
    keys = np.empty((_VOXELS, 3), dtype=np.int64)
    morton_keys(np.arange(_VOXELS), keys)
    order: Int64Array = keys @ np.array([1, BLOCK, BLOCK * BLOCK])
    return order


def _parts_in_morton_order() -> Int64Array:
    """Return the index in the parts of a block, see :class:`Belief`, of the voxel of each Morton code (512,)."""
    order = _voxels_in_morton_order()
    x, y, z = order & 7, order >> 3 & 7, order >> 6
    place: Int64Array = (z >> 1 << 2 | y >> 1) << 5 | (z & 1) << 4 | (y & 1) << 3 | x
    return place


@dataclass(frozen=True, slots=True)
class Octree:
    """Nodes in depth-first order: log-odds ``values`` (n,) float32 and the children bits ``masks`` (n,) uint8.

    Child 1 × x + 2 × y + 4 × z is in the upper half along these axes. The root is a cube of 2¹⁶ voxels of
    ``resolution`` metres around 0; without nodes everything is unknown.
    """

    resolution: float
    values: Float32Array
    masks: UInt8Array

    @classmethod
    def of(cls, volume: OccupancyVolume) -> Octree:
        """Return the pruned octree of a map. Source: octomap's OcTree::prune."""
        config = volume.config
        n = volume.blocks.count
        codes = np.empty(n, dtype=np.int64)
        morton_codes(volume.blocks.corners, codes)
        order = np.argsort(codes)
        belief = volume.belief
        values = belief.values.reshape(-1, 32)
        grown, masks = np.empty(n * 600, dtype=np.float32), np.empty(n * 600, dtype=np.uint8)
        n = grow_tree(codes[order], order, belief.parts, values, _parts_in_morton_order(), grown, masks)
        return cls(config.resolution, grown[:n], masks[:n]).pruned()

    def pruned(self) -> Octree:
        """Return the tree with eight equal leaves of one parent merged, and with the values of inner nodes."""
        return self._with_inner_values(join=True)

    def completed(self) -> Octree:
        """Return the tree with the values of inner nodes, the maxima of their children."""
        return self._with_inner_values(join=False)

    def _with_inner_values(self, *, join: bool) -> Octree:
        values, masks = np.empty_like(self.values), np.empty_like(self.masks)
        n = prune_tree(self.values, self.masks, join, values, masks)
        return Octree(self.resolution, values[:n].copy(), masks[:n].copy())

    def max_likelihood(self, config: VolumeConfig) -> Octree:
        """Return the pruned tree of the states of the leaves, as the minimum or maximum log-odds of ``config``.

        Source: octomap's OccupancyOcTreeBase::toMaxLikelihood.
        """
        occupied = self.values >= config.log_odds_occupied
        states = np.where(occupied, config.log_odds_max, config.log_odds_min).astype(np.float32)
        return Octree(self.resolution, states, self.masks).pruned()

    @property
    def n_nodes(self) -> int:
        """Number of nodes of the tree, including inner ones."""
        return len(self.masks)

    @property
    def n_leaves(self) -> int:
        """Number of leaves of the tree."""
        return int((self.masks == 0).sum())

    def leaves(self) -> tuple[Int64Array, UInt8Array, Float32Array]:
        """Return for each leaf the key (n, 3) of its first voxel, its depth (n,) and its log-odds (n,).

        A leaf of depth d is a cube of 2^(16 − d) voxels.
        """
        codes, depths, values = self._leaf_codes()
        keys = np.empty((len(codes), 3), dtype=np.int64)
        morton_keys(codes, keys)
        return keys, depths, values

    def _leaf_codes(self) -> tuple[Int64Array, UInt8Array, Float32Array]:
        codes, depths = np.empty(self.n_nodes, dtype=np.int64), np.empty(self.n_nodes, dtype=np.uint8)
        place_nodes(self.masks, codes, depths)
        leaf = self.masks == 0
        return codes[leaf], depths[leaf], self.values[leaf]

    def check_size(self, limits: Limits = DEFAULT_LIMITS) -> None:
        """Raise :class:`LimitError` for a tree whose leaves have more voxels than the limits allow."""
        blocks = _blocks_of(self._leaf_codes()[1]).astype(np.float64)
        if blocks.sum() > limits.max_blocks + len(blocks):
            raise LimitError(
                "volume.tree_too_large",
                f"The leaves of the tree are {blocks.sum() * _VOXELS:.3g} voxels of {self.resolution:g} m, "
                f"more than {limits.max_blocks * _VOXELS:,}.",
            )

    def volume(self, config: VolumeConfig, limits: Limits = DEFAULT_LIMITS) -> OccupancyVolume:
        """Return a map with the values of the leaves. The resolution of ``config`` must be that of the tree.

        Raises :class:`LimitError` for a tree that needs more blocks than the limits allow.
        """
        volume = OccupancyVolume(config, limits)
        if not self.n_nodes:
            return volume
        codes, depths, values = self._leaf_codes()
        self.check_size(limits)
        counts = _blocks_of(depths)
        first = np.repeat(codes >> 9, counts)
        blocks = np.unique(first + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts))
        if len(blocks) > limits.max_blocks:
            raise LimitError(
                "volume.tree_too_large",
                f"The tree has {len(blocks):,} blocks of 8 × 8 × 8 voxels, more than {limits.max_blocks:,}.",
            )
        filled = np.full((len(blocks), _VOXELS), np.nan, dtype=np.float32)
        fill_leaves(codes, depths, values, blocks, filled)
        ordered = np.empty_like(filled)
        ordered[:, _voxels_in_morton_order()] = filled
        corners = np.empty((len(blocks), 3), dtype=np.int64)
        morton_keys(blocks << 9, corners)
        names = corners // BLOCK @ np.array([1, 1 << 13, 1 << 26])
        volume.set_blocks(names, ordered.reshape(-1, BLOCK, BLOCK, BLOCK))
        return volume


def _blocks_of(depths: UInt8Array) -> Int64Array:
    """Return the number of blocks covered by leaves of these depths (n,), at least one each."""
    return np.asarray(np.int64(1) << 3 * np.maximum(_BLOCK_DEPTH - depths.astype(np.int64), 0))
