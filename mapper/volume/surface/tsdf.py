"""Truncated signed distance field: depth images and clouds fused in the voxels near the surfaces.

Source: Curless & Levoy, A volumetric method for building complex models from range images, SIGGRAPH 1996; Newcombe et
al., KinectFusion: real-time dense surface mapping and tracking, ISMAR 2011. Blocks as in Nießner et al., 2013.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.parallel import cores, in_parallel, scratch, shares
from mapper.sensors.camera import Intrinsics
from mapper.sensors.point_cloud import check_pose
from mapper.volume.blocks import BLOCK, KEYS, BlockHash
from mapper.volume.kernels.tsdf import TILE, beam_blocks, depth_span, fuse_beams, fuse_depth, mark_surface
from mapper.volume.kernels.types import Box, DepthView, Fusion
from mapper.volume.surface.parameters import TsdfConfig

CENTRE = KEYS // 2
_SHARE = 64  # blocks above which a second thread is worthwhile
_FIRST_ROOM = 8192  # initial capacity in blocks; unused memory is only reserved
_FOUND = 1 << 18  # blocks of beams processed at a time, with repetitions


@dataclass(frozen=True, slots=True)
class Fused:
    """Result of a fusion: ``slots`` (n,) of the changed blocks, ascending, and the number of ``used`` pixels or
    points.
    """

    slots: Int32Array
    used: int


class TsdfVolume:
    """Signed distances to the nearest surface, positive in front of it, and weights, of the voxels near surfaces.

    The lattice is that of :class:`mapper.volume.occupancy.volume.OccupancyVolume`. A voxel of weight 0 is unknown. A
    block is in the map once it has a voxel within the truncation of a surface. The map does not depend on the number of
    threads.
    """

    def __init__(self, config: TsdfConfig | None = None, limits: Limits = DEFAULT_LIMITS) -> None:
        self.config = TsdfConfig() if config is None else config
        self.blocks = BlockHash(limits)
        self._distances = np.zeros((0, BLOCK**3), dtype=np.float32)
        self._weights = np.zeros((0, BLOCK**3), dtype=np.float32)

    @property
    def _most_blocks(self) -> int:
        return self.blocks.limits.max_blocks // 2  # a voxel has twice the bytes of one of an OccupancyVolume

    @property
    def distances(self) -> Float32Array:
        """The distances (n, 8, 8, 8), z y x, metres, of the blocks in slot order."""
        return self._distances[: self.blocks.count].reshape(-1, BLOCK, BLOCK, BLOCK)

    @property
    def weights(self) -> Float32Array:
        """The weights (n, 8, 8, 8), z y x, of the blocks in slot order; 0 for unknown."""
        return self._weights[: self.blocks.count].reshape(-1, BLOCK, BLOCK, BLOCK)

    @property
    def n_bytes(self) -> int:
        """Memory of the map in bytes: blocks and hash."""
        blocks = self.blocks.count * (2 * 4 * BLOCK**3 + 8)
        return blocks + self.blocks.table.codes.nbytes + self.blocks.table.slots.nbytes

    @property
    def _fusion(self) -> Fusion:
        config = self.config
        band = config.band
        near = np.float32(min(config.resolution, 0.5 * float(band))) if config.drop_off else band
        return Fusion(
            band, near, np.float32(config.max_weight), config.far, config.weighting == "inverse_square", config.carve
        )

    def fuse_depth(self, depth: ArrayLike, camera: Intrinsics, pose: ArrayLike) -> Fused:
        """Update the map by a depth image (height, width), metres along the optical axis; NaN and 0 are no depth.

        ``pose`` (4, 4) is ``T_map_camera`` of the camera's optical frame. Each voxel gets the depth of the pixel of its
        centre minus its own depth. Raises :class:`ConfigError` for an image of another size than the camera's and for
        an invalid pose, and :class:`LimitError` for an image that needs more memory than the limits allow; the map is
        then unchanged.
        """
        image = np.ascontiguousarray(depth, dtype=np.float32)
        place = np.asarray(pose, dtype=np.float64)
        if image.ndim != 2:
            raise ConfigError("tsdf.depth", f"A depth image must have rows and columns, not the shape {image.shape}.")
        camera.check_size(image, "intrinsics")
        check_pose(place, "The camera’s pose")
        fusion, resolution = self._fusion, self.config.resolution
        used, deepest = depth_span(image.reshape(-1), fusion.far)
        if not used:
            return Fused(np.empty(0, dtype=np.int32), 0)
        matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
        origin = place[:3, 3] / resolution + CENTRE - 0.5
        rays = place[:3, :3] @ np.linalg.inv(matrix) / resolution
        view = DepthView(image.reshape(-1), camera.width, camera.height, rays, origin)
        far = float(deepest) + float(fusion.truncation)
        blocks = self.blocks.find(codes := self._surface_blocks(view, fusion, far))
        new = np.flatnonzero(blocks < 0)
        first = self.blocks.count
        self._reserve(first + len(new))
        slots = blocks.copy()
        slots[new] = first + np.arange(len(new), dtype=np.int32)
        corners = _corners(codes)
        if fusion.carve:
            more = self._blocks_in_front(blocks, view, far)
            corners, slots = np.concatenate([corners, self.blocks.corners[more]]), np.concatenate([slots, more])
        project = matrix @ place[:3, :3].T
        x, y, z = ((corners - CENTRE + 0.5) * resolution - place[:3, 3]).T
        bases = np.stack([a * x + b * y + c * z for a, b, c in project.tolist()], axis=1).astype(np.float32)
        offsets = voxel_offsets(project, resolution)
        touched = np.zeros(len(slots), dtype=np.uint8)
        parts = shares(len(slots), min(cores(), 1 + len(slots) // _SHARE))
        arrays = self._distances, self._weights
        in_parallel(
            [
                partial(fuse_depth, view, fusion, bases[a:b], offsets, slots[a:b], *arrays, touched[a:b])
                for a, b in parts
            ]
        )
        complete = new[touched[new] == 3]
        touched[new] = touched[new] == 3
        self._keep(codes[complete], slots[complete], first, len(new))
        slots[complete] = first + np.arange(len(complete), dtype=np.int32)
        return Fused(np.sort(slots[touched > 0]), used)

    def fuse_points(self, points: ArrayLike, origin: ArrayLike) -> Fused:
        """Update the map by the points (n, 3) measured by a sensor at ``origin`` (3,), metres in the map's frame.

        A voxel gets the distance along each beam that passes it, in the order of the points. Points that are not finite
        or whose beam leaves the lattice are ignored. Raises :class:`ConfigError` for other shapes and for an origin
        outside the lattice, and :class:`LimitError`; the map is then unchanged.
        """
        ends, start = np.asarray(points, dtype=np.float64), np.asarray(origin, dtype=np.float64)
        if ends.ndim != 2 or ends.shape[1] != 3 or start.shape != (3,):
            raise ConfigError(
                "tsdf.shape", f"A scan is points (n, 3) and an origin (3,), not {ends.shape} and {start.shape}."
            )
        fusion, resolution = self._fusion, self.config.resolution
        start = start / resolution + CENTRE - 0.5
        if not (np.isfinite(start).all() and start.min() >= 0.0 and start.max() < KEYS - 1):
            raise ConfigError(
                "tsdf.origin",
                f"The sensor’s place must be finite and within {CENTRE * resolution:g} m of 0 along each axis.",
            )
        ends = ends / resolution + CENTRE - 0.5
        margin = float(fusion.truncation) / resolution + 1.0
        ends = np.ascontiguousarray(ends[((ends >= margin) & (ends < KEYS - 1 - margin)).all(axis=1)])
        lengths = np.linalg.norm(ends - start, axis=1) * resolution
        used = int(np.count_nonzero((lengths > 0.0) & (lengths <= fusion.far)))
        if not used:
            return Fused(np.empty(0, dtype=np.int32), 0)
        codes = self._beam_blocks(start, ends, fusion)
        new = codes[self.blocks.find(codes) < 0]
        self._reserve(self.blocks.count + len(new))
        self.blocks.add(new)
        touched = np.zeros(self.blocks.count, dtype=np.bool_)
        fuse_beams(self.blocks.table, start, ends, resolution, fusion, self._distances, self._weights, touched)
        return Fused(np.flatnonzero(touched).astype(np.int32), used)

    def set_blocks(self, codes: Int64Array, distances: Float32Array, weights: Float32Array) -> None:
        """Set the distances and weights of the voxels (n, 8, 8, 8) of blocks; the codes (n,) must be distinct."""
        self._reserve(self.blocks.count + len(codes))
        slots = self.blocks.add(codes)
        self._distances[slots], self._weights[slots] = distances.reshape(-1, BLOCK**3), weights.reshape(-1, BLOCK**3)

    def _surface_blocks(self, view: DepthView, fusion: Fusion, far: float) -> Int64Array:
        """Return the codes of the blocks that may contain a depth image's surface, and some of their neighbours."""
        resolution = self.config.resolution
        u, v = np.meshgrid([-1.0, view.width], [-1.0, view.height])
        edges = view.rays @ np.stack([u.ravel(), v.ravel(), np.ones(4)]) * far
        places = np.concatenate([view.origin[:, None], view.origin[:, None] + edges], axis=1)
        low = np.clip(np.floor(places.min(axis=1)), 0, KEYS).astype(np.int64) // BLOCK * BLOCK
        high = np.clip(np.ceil(places.max(axis=1)) + 1, 0, KEYS).astype(np.int64)
        nx, ny, nz = ((high - low + BLOCK - 1) // BLOCK).tolist()
        if min(nx, ny, nz) <= 0:
            return np.empty(0, dtype=np.int64)
        if nx * ny * nz > self.blocks.limits.max_scan_box // BLOCK**3:
            raise LimitError(
                "tsdf.frame_too_large",
                f"A depth image that sees {far:.0f} m far is too large for voxels of {resolution:g} m; choose a "
                "coarser resolution or a shorter longest range.",
            )
        box = Box(int(low[0]), int(low[1]), int(low[2]), nx * BLOCK, ny * BLOCK, nz * BLOCK)
        n = nx * ny * nz
        tiles = -(-view.height // TILE)
        with scratch(n // 8 + 1) as memory:
            marks = memory.view(np.bool_)[:n]
            in_parallel(
                [partial(mark_surface, view, fusion, resolution, box, a, b, marks) for a, b in shares(tiles, cores())]
            )
            marked = np.flatnonzero(marks)
            marks[marked] = False
        x, y, z = marked % nx + box.x // BLOCK, marked // nx % ny + box.y // BLOCK, marked // (nx * ny) + box.z // BLOCK
        codes: Int64Array = z << 26 | y << 13 | x
        return codes

    def _blocks_in_front(self, blocks: Int32Array, view: DepthView, far: float) -> Int32Array:
        """Return the slots of the map's blocks that the camera may see, except ``blocks``, those at the surface."""
        others = np.ones(self.blocks.count, dtype=np.bool_)
        others[blocks[blocks >= 0]] = False
        slots: Int32Array = np.flatnonzero(others).astype(np.int32)
        away = self.blocks.corners[slots] + 0.5 * (BLOCK - 1) - view.origin
        project = np.linalg.inv(view.rays)
        u, v, z = project @ away.T
        # All points of a block are within this many voxels of its centre.
        reach = 0.5 * BLOCK * math.sqrt(3.0)
        wide, tall = reach * np.linalg.norm(project[:2], axis=1)
        deep = reach * self.config.resolution
        last = z + deep
        seen = (last > 0.0) & (z - deep <= far)
        seen &= (u + wide > -0.5 * last) & (u - wide < view.width * last)
        seen &= (v + tall > -0.5 * last) & (v - tall < view.height * last)
        return np.compress(seen, slots)

    def _beam_blocks(self, start: Float64Array, ends: Float64Array, fusion: Fusion) -> Int64Array:
        """Return the codes of the blocks that the truncation bands of beams pass, ascending."""
        resolution = self.config.resolution
        of_a_beam = 3 * (math.ceil(2.0 * float(fusion.truncation) / resolution / BLOCK) + 3)
        codes = np.empty(0, dtype=np.int64)
        at_once = max(1, min(len(ends), _FOUND // of_a_beam))
        out = np.empty(at_once * of_a_beam, dtype=np.int64)
        for a in range(0, len(ends), at_once):
            n = beam_blocks(start, ends[a : a + at_once], resolution, fusion, out)
            codes = np.union1d(codes, out[:n])
            self._check_count(len(codes))
        return codes

    def _reserve(self, count: int) -> None:
        """Reserve room for ``count`` blocks; those not in the map are 0. Raises :class:`LimitError`."""
        self._check_count(count)
        if count > len(self._distances):
            n = min(max(count, 2 * len(self._distances), _FIRST_ROOM), self._most_blocks)
            distances, weights = np.zeros((n, BLOCK**3), np.float32), np.zeros((n, BLOCK**3), np.float32)
            held = self.blocks.count
            distances[:held], weights[:held] = self._distances[:held], self._weights[:held]
            self._distances, self._weights = distances, weights

    def _check_count(self, count: int) -> None:
        if count > self._most_blocks:
            raise LimitError(
                "volume.too_large",
                f"The map would need {count:,} blocks of 8 × 8 × 8 voxels, more than {self._most_blocks:,}; choose a "
                "coarser resolution, a shorter truncation or a shorter longest range.",
            )

    def _keep(self, codes: Int64Array, rows: Int32Array, first: int, n_new: int) -> None:
        """Add the blocks whose voxels are in ``rows`` from ``first`` on, and reset the others of these ``n_new`` to
        0.
        """
        n = len(codes)
        moved = rows != first + np.arange(n)
        to = first + np.flatnonzero(moved)
        for array in (self._distances, self._weights):
            array[to] = array[rows[moved]]
            array[first + n : first + n_new] = 0.0
        self.blocks.add(codes)


def voxel_offsets(project: Float64Array, resolution: float) -> Float32Array:
    """Return u z, v z and z (3, 512) of the voxels of a block, z y x, relative to its first voxel, in float32.

    ``project`` (3, 3) maps metres along the map's axes to u z, v z and z, pixels and metres.
    """
    z, y, x = np.indices((BLOCK, BLOCK, BLOCK)).reshape(3, -1)
    return (project @ np.stack([x, y, z]) * resolution).astype(np.float32)


def _corners(codes: Int64Array) -> Int64Array:
    """Return the keys (n, 3), x y z, of the first voxels of the blocks with these codes."""
    return np.stack([codes & 0x1FFF, codes >> 13 & 0x1FFF, codes >> 26], axis=1) * BLOCK
