"""Map of occupied, free and unknown voxels from point clouds with known sensor positions.

The log-odds of blocks of 8³ voxels are kept only for those parts of 2 × 2 × 8 voxels in which some are known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import BoolArray, Float32Array, Int32Array, Int64Array, UInt16Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.parallel import cores, in_parallel, scratch, shares
from mapper.volume.blocks import BLOCK, BlockHash
from mapper.volume.kernels.rays import CENTRE, distinct_voxels, key_bounds, mark_ends, mark_rays, pack_keys, voxel_keys
from mapper.volume.kernels.types import Belief, Box, StopMasks, Updates
from mapper.volume.kernels.update import add_parts, apply_marks, decay_blocks, marked_blocks, summarise_blocks
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.occupancy.stop_masks import StopMaskCache

PARTS = 16  #: of a block
_SHAPE = (2, 2, BLOCK)  # of a part, z y x


class BlockParts:
    """Storage of the voxels' log-odds: ``numbers`` (slots, 16) are the indices of a block's parts in ``values``.

    ``values`` (parts, 2, 2, 8) are float32, z y x, NaN if unknown. Part (z, y) of a block, four along each axis, is
    entry 4 z + y of its row. Part 0 is all unknown and stands for missing parts. Both arrays have room for more than
    ``count`` parts and the owner's blocks.
    """

    def __init__(self) -> None:
        self.numbers = np.empty((0, PARTS), dtype=np.int32)
        self.values = np.full((1, *_SHAPE), np.nan, dtype=np.float32)
        self.count = 1

    @property
    def known_values(self) -> Float32Array:
        """The log-odds (n, 2, 2, 8) of all allocated parts."""
        return self.values[1 : self.count]

    def n_bytes(self, blocks: int) -> int:
        """Bytes of the log-odds of this number of blocks, and of their part indices."""
        return self.count * self.values[:1].nbytes + blocks * self.numbers.itemsize * PARTS

    def reserve(self, capacity: int, used: int) -> None:
        """Make room for ``capacity`` blocks; the first ``used`` keep their parts and the others have none."""
        numbers = np.zeros((capacity, PARTS), dtype=np.int32)
        numbers[:used] = self.numbers[:used]
        self.numbers = numbers

    def add(self, slots: Int32Array, part_bits: UInt16Array) -> None:
        """Give blocks the parts that are bits of ``part_bits`` (n,), new ones unknown; ``slots`` (n,) all differ."""
        before = self.count
        self.count += add_parts(self.numbers, slots, part_bits, before)
        if self.count > len(self.values):
            more = np.empty((max(self.count, len(self.values) * 3 // 2), *_SHAPE), dtype=np.float32)
            more[:before] = self.values[:before]
            self.values = more
        self.values[before : self.count] = np.nan

    def blocks(self, slots: Int32Array | Int64Array | slice) -> Float32Array:
        """Return a copy of the log-odds (n, 8, 8, 8), z y x, of blocks by slot."""
        rows = self.values[self.numbers[slots]].reshape(-1, 4, 4, *_SHAPE)
        return rows.transpose(0, 1, 3, 2, 4, 5).reshape(-1, BLOCK, BLOCK, BLOCK)

    def set_blocks(self, slots: Int32Array, values: Float32Array) -> None:
        """Set the log-odds of the voxels (n, 8, 8, 8) of blocks; ``slots`` (n,) are distinct."""
        rows = values.reshape(-1, 4, 2, 4, 2, BLOCK).transpose(0, 1, 3, 2, 4, 5).reshape(-1, PARTS, *_SHAPE)
        known = ~np.isnan(rows).all(axis=(2, 3, 4))
        self.add(slots, (known * (1 << np.arange(PARTS))).sum(axis=1).astype(np.uint16))
        numbers = self.numbers[slots]
        there = numbers > 0
        self.values[numbers[there]] = rows[there]


FORGET_BELOW = 0.1  #: log-odds nearer to 0 than this are removed by a decay
_TILE_VOXELS = 1 << 27  # marks processed at a time, bytes
# Ray steps and blocks of a scan's box per thread. Two threads write the same marks near the sensor, so a small scan
# takes longer with two threads than with one.
STEPS_A_THREAD, BLOCKS_A_THREAD = 1 << 20, 512


@dataclass(frozen=True, slots=True)
class Inserted:
    """Result of an insertion: ``beams`` were traced, and ``left_out`` points were not finite or outside the volume.

    ``slots`` (n,) are those of the touched blocks.
    """

    beams: int
    left_out: int
    slots: Int32Array


class OccupancyVolume:
    """Log-odds of the voxels of a lattice with 2¹⁶ voxels along each axis, centred at 0.

    The value of a voxel equals OctoMap's after the same scans, to the last bit and for any number of threads.
    """

    def __init__(self, config: VolumeConfig | None = None, limits: Limits = DEFAULT_LIMITS) -> None:
        self.config = VolumeConfig() if config is None else config
        self.blocks = BlockHash(limits)
        self._parts = BlockParts()
        self._maxima = np.empty(0, dtype=np.float32)
        self._known = np.empty(0, dtype=np.int32)
        self._stops = StopMaskCache()

    @property
    def values(self) -> Float32Array:
        """A copy of the log-odds (n, 8, 8, 8), z y x, of the blocks in slot order; NaN if unknown."""
        return self._parts.blocks(slice(0, self.blocks.count))

    def values_of(self, slots: Int32Array | Int64Array) -> Float32Array:
        """Return a copy of the log-odds (n, 8, 8, 8), z y x, of blocks by slot (n,)."""
        return self._parts.blocks(slots)

    @property
    def belief(self) -> Belief:
        """The map in the form that the kernels use."""
        return Belief(self.blocks.table, self._parts.numbers, self._parts.values, self._maxima, self._known)

    @property
    def n_known(self) -> int:
        """Number of known voxels."""
        return int(self._known[: self.blocks.count].sum())

    def count_states(self) -> tuple[int, int]:
        """Return the number of occupied and of free voxels."""
        occupied = int((self._parts.known_values >= self.config.log_odds_occupied).sum())
        return occupied, self.n_known - occupied

    @property
    def n_bytes(self) -> int:
        """Memory of the map in bytes: blocks and hash."""
        blocks = self.blocks.count * 16 + self._parts.n_bytes(self.blocks.count) + self._stops.n_bytes
        return blocks + self.blocks.table.codes.nbytes + self.blocks.table.slots.nbytes

    @property
    def reach(self) -> float:
        """Extent of the lattice from 0 along each axis, metres."""
        return CENTRE * self.config.resolution

    def insert_scan(self, points: ArrayLike, origin: ArrayLike | None) -> Inserted:
        """Update the map by the points (n, 3) measured by a sensor at ``origin`` (3,), metres in the map's frame.

        If the sensor position is unknown, None, the points' voxels become occupied and none becomes free. Points that
        are not finite or outside the lattice are ignored. Raises :class:`ConfigError` for other shapes and for an
        origin outside the lattice, :class:`LimitError` for a scan that needs more memory than the limits allow; the map
        may then contain a part of it.
        """
        config, limits = self.config, self.blocks.limits
        ends = np.ascontiguousarray(points, dtype=np.float32)
        start = np.zeros(3, np.float32) if origin is None else np.ascontiguousarray(origin, dtype=np.float32)
        if ends.ndim != 2 or ends.shape[1] != 3 or start.shape != (3,):
            raise ConfigError(
                "volume.shape", f"A scan is points (n, 3) and an origin (3,), not {ends.shape} and {start.shape}."
            )
        first, inside = keys_of(start[None], config.resolution)
        if not inside[0]:
            raise ConfigError(
                "volume.origin",
                f"The sensor’s place {start.tolist()} must be finite and within {self.reach:g} m of 0 along each axis.",
            )
        rays, keys, hits, left_out = self.rays_of(ends, start)
        if origin is None:
            rays, keys, first = rays[:0], keys[:0], hits[:1]
        if not len(first):
            return Inserted(0, left_out, np.empty(0, dtype=np.int32))
        low, high = _bounds(first[0], keys, hits)
        if math.prod((high - low).tolist()) > limits.max_scan_box:
            size = " × ".join(f"{side * config.resolution:.0f}" for side in (high - low).tolist())
            raise LimitError(
                "volume.scan_too_large",
                f"A scan of {size} m at {config.resolution:g} m a voxel is too large; choose a coarser resolution or a "
                "shorter longest beam.",
            )
        touched = [self._insert_tile(box, start, rays, first[0], keys, hits) for box in _tiles(low, high)]
        return Inserted(len(rays), left_out, np.concatenate(touched))

    def rays_of(self, ends: Float32Array, start: Float32Array) -> tuple[Float32Array, Int64Array, Int64Array, int]:
        """Return the ends of a scan's beams, the keys of their voxels, the occupied keys, and the number of ignored
        points.

        ``ends`` (n, 3) are the scan's points and ``start`` (3,) its origin, float32.
        """
        resolution, reach = self.config.resolution, self.config.range_max
        keys, inside = keys_of(ends, resolution)
        all_inside = bool(inside.all())
        if self.config.discretise:
            packed = pack_keys(keys) if all_inside else pack_keys(keys[inside])
            packed.sort()
            keys = np.empty((len(packed), 3), dtype=np.int64)
            rays = np.empty((len(packed), 3), dtype=np.float32)
            n = distinct_voxels(packed, resolution, keys, rays)
            keys, rays = keys[:n], rays[:n]
        elif all_inside:
            rays = ends
        else:
            keys, rays = keys[inside], ends[inside]
        left_out = len(ends) - int(inside.sum())
        if reach == 0.0:
            return rays, keys, keys, left_out
        away = rays - start
        x, y, z = away.T
        ranges = np.sqrt((x * x + y * y + z * z).astype(np.float64))
        short = ranges <= reach
        hits = keys[short]
        cut = ~short
        rays = rays.copy()
        rays[cut] = start + away[cut] / ranges[cut, None].astype(np.float32) * np.float32(reach)
        keys, inside = keys_of(rays, resolution)
        return rays[inside], keys[inside], hits, left_out

    def _insert_tile(
        self, box: Box, start: Float32Array, rays: Float32Array, first: Int64Array, keys: Int64Array, hits: Int64Array
    ) -> Int32Array:
        size = box.nx * box.ny * box.nz
        resolution = self.config.resolution
        with scratch(size // 8) as memory:
            words = memory[: size // 8]
            marks = words.view(np.uint8)
            in_parallel(
                [
                    partial(mark_rays, start, rays[a:b], first, keys[a:b], resolution, box, marks)
                    for a, b in shares(len(rays), _ray_threads(first, keys))
                ]
            )
            mark_ends(hits, box, marks)
            n = min(cores(), 1 + size // (BLOCK**3 * BLOCKS_A_THREAD))
            shares_of = [_blocks_within(words, box, z0, z1) for z0, z1 in shares(box.nz // BLOCK, n)]
            codes, corners, parts = (np.concatenate(some) for some in zip(*shares_of, strict=True))
            try:
                slots = self._add(codes)
            except LimitError:
                words[:] = 0
                raise
            self._parts.add(slots, parts)
            config, belief = self.config, self.belief
            updates = Updates(config.log_odds_miss, config.log_odds_hit, config.log_odds_min, config.log_odds_max)
            in_parallel(
                [
                    partial(apply_marks, marks, words, box, corners[a:b], slots[a:b], updates, belief)
                    for a, b in shares(len(slots), n)
                ]
            )
        self._stops.mark_stale(slots)
        return slots

    def _add(self, codes: Int64Array) -> Int32Array:
        """Return the slots of blocks, adding missing ones as unknown."""
        before = self.blocks.count
        slots = self.blocks.add(codes)
        if self.blocks.capacity > len(self._known):
            maxima, known, n = self._maxima, self._known, self.blocks.capacity
            self._parts.reserve(n, before)
            self._maxima, self._known = np.empty(n, dtype=np.float32), np.empty(n, dtype=np.int32)
            self._maxima[:before], self._known[:before] = maxima[:before], known[:before]
        new = slice(before, self.blocks.count)
        self._maxima[new], self._known[new] = -np.inf, 0
        return slots

    def set_blocks(self, codes: Int64Array, values: Float32Array) -> None:
        """Set the log-odds of the voxels (n, 8, 8, 8) of blocks; the codes (n,) must be distinct."""
        slots = self._add(codes)
        self._parts.set_blocks(slots, values)
        self._summarise()

    def decay(self, elapsed: float) -> None:
        """Halve the log-odds for each half-life in ``elapsed`` seconds, and remove small ones.

        Without decay, an object that is gone stays in the map where no later beam passes, because nothing is seen
        behind it (OctoMap's issues 183 and 314).
        """
        if self.config.half_life == 0.0:
            return
        factor = np.float32(0.5 ** (elapsed / self.config.half_life))
        decay_blocks(self._parts.known_values, factor, np.float32(FORGET_BELOW))
        self._summarise()

    def _summarise(self) -> None:
        summarise_blocks(self.belief, self.blocks.count)
        self._stops.mark_stale(slice(None))

    def stop_masks(self) -> StopMasks:
        """Return which voxels end a cast ray, for the blocks in slot order."""
        return self._stops.masks_of(self.belief, self.blocks.codes, float(self.config.log_odds_occupied))

    def log_odds_of(self, keys: Int64Array, where: BoolArray | None = None) -> Float32Array:
        """Return the log-odds (n,) of voxels by key (n, 3), NaN if unknown or ``where`` (n,) is false."""
        x, y, z = keys.T
        slots = self.blocks.find(z // BLOCK << 26 | y // BLOCK << 13 | x // BLOCK)
        there = slots >= 0 if where is None else where & (slots >= 0)
        out = np.full(len(keys), np.nan, dtype=np.float32)
        x, y, z = x[there], y[there], z[there]
        parts = self._parts.numbers[slots[there], z // 2 % 4 * 4 + y // 2 % 4]
        out[there] = self._parts.values[parts, z % 2, y % 2, x % BLOCK]
        return out

    def voxels(self, least: float = -np.inf) -> tuple[Int64Array, Float32Array]:
        """Return the keys (n, 3) and the log-odds (n,) of the known voxels with log-odds of at least ``least``."""
        values = self.values
        slot, z, y, x = np.nonzero(values >= least)
        return self.blocks.corners[slot] + np.stack([x, y, z], axis=1), values[slot, z, y, x]


def keys_of(points: Float32Array, resolution: float) -> tuple[Int64Array, BoolArray]:
    """Return the keys (n, 3) of the voxels that contain points (n, 3), and which points are finite and in the
    lattice.
    """
    keys, inside = np.empty((len(points), 3), dtype=np.int64), np.empty(len(points), dtype=np.bool_)
    voxel_keys(points, resolution, keys, inside)
    return keys, inside


def centres_of(keys: Int64Array, resolution: float) -> Float32Array:
    """Return the centres (n, 3) of voxels, metres."""
    return ((keys - CENTRE + 0.5) * resolution).astype(np.float32)


def _bounds(first: Int64Array, *keys: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Return the corners (3,) of the box of whole blocks around keys (3,), (n, 3), with a margin of one voxel for
    rounding.
    """
    low, high = first.copy(), first.copy()
    for some in keys:
        key_bounds(some, low, high)
    return (low - 1) // BLOCK * BLOCK, ((high + 1) // BLOCK + 1) * BLOCK


def _ray_threads(first: Int64Array, keys: Int64Array) -> int:
    """Return the number of threads for rays from the voxel ``first`` (3,) to ``keys`` (n, 3), from every 64th of
    them.
    """
    some = keys[::64]
    steps = float(np.abs(some - first).sum()) * len(keys) / max(len(some), 1)
    return min(cores(), 1 + int(steps / STEPS_A_THREAD))


def _tiles(low: Int64Array, high: Int64Array) -> list[Box]:
    """Split a box into boxes of whole blocks whose marks fit into memory."""
    boxes = [(low.tolist(), high.tolist())]
    while math.prod(b - a for a, b in zip(*boxes[0], strict=True)) > _TILE_VOXELS:
        halves = []
        for a, b in boxes:
            axis = max(range(3), key=lambda k: b[k] - a[k])
            middle = (a[axis] + b[axis]) // (2 * BLOCK) * BLOCK
            halves += [(a, [*b[:axis], middle, *b[axis + 1 :]]), ([*a[:axis], middle, *a[axis + 1 :]], b)]
        boxes = sorted(halves, key=lambda box: -math.prod(b - a for a, b in zip(*box, strict=True)))
    return [Box(*a, *(high - low for low, high in zip(a, b, strict=True))) for a, b in boxes]


def _blocks_within(words: Int64Array, box: Box, z0: int, z1: int) -> tuple[Int64Array, Int64Array, UInt16Array]:
    most = (z1 - z0) * (box.ny // BLOCK) * (box.nx // BLOCK)
    codes, corners = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    parts = np.empty(most, dtype=np.uint16)
    n = marked_blocks(words, box, z0, z1, codes, corners, parts)
    return codes[:n], corners[:n], parts[:n]
