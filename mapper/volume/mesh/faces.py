"""Visible faces of a map's occupied voxels as rectangles, in chunks of 32³ voxels."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float64Array, Int32Array, Int64Array, UInt8Array, UInt32Array
from mapper.core.errors import WorkCancelledError
from mapper.volume.blocks import BLOCK, KEYS
from mapper.volume.kernels.faces import CHUNK, COVERED, fill_chunk, merge_faces
from mapper.volume.kernels.rays import CENTRE
from mapper.volume.kernels.types import FaceRule
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.mesh.voxel_classes import ChunkKey, Painted
from mapper.volume.occupancy.volume import OccupancyVolume

__all__ = ["CENTRE", "CHUNK", "ChunkKey", "FaceRule", "VoxelFaces", "face_rule", "triangles_of"]

NONE_PAINTED = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.uint8))
_ROOM = 4096  #: initial capacity in rectangles
#: For a rectangle's corners, counter-clockwise from outside: whether they are at its far end along its two axes.
_CORNERS = {False: ((0, 0), (0, 1), (1, 1), (1, 0)), True: ((0, 0), (1, 0), (1, 1), (0, 1))}


def face_rule(
    volume: OccupancyVolume, low: ArrayLike, high: ArrayLike, *, base: float, band: float, colours: int,
    by_belief: bool = False, seen_only: bool = False,
) -> FaceRule:  # fmt: skip
    """Return a rule that draws the occupied voxels with centres in a box from ``low`` to ``high`` (3,), metres.

    A single number is a height. Their colours are 1 to ``colours``: one for each ``band`` metres of height from
    ``base`` or, if ``by_belief``, equal steps of the log-odds. With ``seen_only``, faces towards unknown voxels, which
    no sensor has seen, are omitted.
    """
    config = volume.config
    resolution = config.resolution
    corners = [end if np.ndim(end) else (side, side, end) for side, end in ((-np.inf, low), (np.inf, high))]
    first, last = np.clip(np.array(corners, dtype=np.float64) / resolution, -KEYS, KEYS)
    return FaceRule(
        float(config.log_odds_occupied),
        float(config.log_odds_max),
        _key_of(np.ceil(first - 0.5)),
        _key_of(np.floor(last - 0.5)),
        int(np.floor(np.clip(base / resolution, -KEYS, KEYS))) + CENTRE,
        max(1, round(band / resolution)),
        colours,
        by_belief,
        seen_only,
    )


def _key_of(voxel: Float64Array) -> tuple[int, int, int]:
    x, y, z = (int(index) + CENTRE for index in voxel)
    return x, y, z


class VoxelFaces:
    """The rectangles of a map; ``chunks`` has an array (n, 7) uint8 for each non-empty chunk, see :func:`merge_faces`.

    The array of a changed chunk is replaced; otherwise it is the same object. ``voxels`` is the number of drawn voxels
    of each of these chunks.
    """

    def __init__(self) -> None:
        self.chunks: dict[ChunkKey, UInt8Array] = {}
        self.voxels: dict[ChunkKey, int] = {}
        self._colours = np.empty((CHUNK + 2,) * 3, dtype=np.uint8)
        self._mask = np.empty((CHUNK, CHUNK), dtype=np.uint8)
        self._out = np.empty((_ROOM, 7), dtype=np.uint8)

    def update(
        self,
        volume: OccupancyVolume,
        rule: FaceRule,
        chunks: Iterable[ChunkKey],
        may_continue: Callable[[], bool] = lambda: True,
        painted: Painted | None = None,
    ) -> list[ChunkKey]:
        """Recompute the rectangles of ``chunks`` and return the chunks in which they changed.

        ``painted`` replaces the rule's colours; voxels that it does not cover have colour 1. Raises
        :class:`WorkCancelledError` between two chunks unless ``may_continue``; the chunks before are then complete.
        """
        changed = []
        for key in chunks:
            if not may_continue():
                raise WorkCancelledError("volume.cancelled", "Drawing the voxels was cancelled.")
            if self._update_one(volume, rule, key, painted):
                changed.append(key)
        return changed

    def _update_one(self, volume: OccupancyVolume, rule: FaceRule, key: ChunkKey, painted: Painted | None) -> bool:
        x, y, z = (CHUNK * k for k in key)
        count = fill_chunk(volume.belief, x, y, z, rule, self._colours)
        if painted is not None and count:
            self._paint(*painted.get(key, NONE_PAINTED))
        n = merge_faces(self._colours, self._mask, self._out) if count else 0
        if n > len(self._out):
            self._out = np.empty((n, 7), dtype=np.uint8)
            merge_faces(self._colours, self._mask, self._out)
        old = self.chunks.get(key)
        if n == 0:
            self.voxels.pop(key, None)
            return self.chunks.pop(key, None) is not None
        self.voxels[key] = count
        new = self._out[:n]
        if old is not None and np.array_equal(old, new):
            return False
        self.chunks[key] = new.copy()
        return True

    def _paint(self, voxels: Int64Array, colours: UInt8Array) -> None:
        """Replace the colours of the chunk's drawn voxels."""
        inner = self._colours[1:-1, 1:-1, 1:-1]
        values = np.ones(inner.size, dtype=np.uint8)
        values[voxels] = colours
        drawn = (inner != 0) & (inner != COVERED)
        inner[drawn] = values.reshape(inner.shape)[drawn]

    def clear(self) -> None:
        """Remove all chunks."""
        self.chunks.clear()
        self.voxels.clear()


def chunks_of(volume: OccupancyVolume, slots: Int32Array | None = None) -> list[ChunkKey]:
    """Return the chunks whose faces depend on the blocks ``slots`` (n,), or on any block of the map."""
    corners = volume.blocks.corners if slots is None else volume.blocks.corners[slots]
    if not len(corners):
        return []
    # The visibility of a face depends on the adjacent voxel, which may be in the next chunk.
    low, high = (corners - 1) // CHUNK, (corners + BLOCK) // CHUNK
    ends = np.stack([low, high])
    numbers = np.arange(8)
    picked = [ends[numbers >> axis & 1, :, axis] for axis in range(3)]
    keys = np.unique(np.stack(picked, axis=-1).reshape(-1, 3), axis=0)
    keys = keys[((keys >= 0) & (keys < KEYS // CHUNK)).all(axis=1)]
    return [(int(x), int(y), int(z)) for x, y, z in keys]


def triangles_of(quads: UInt8Array) -> tuple[UInt8Array, UInt32Array]:
    """Return the corners (4 n, 3) of rectangles (n, 7), in voxels from the chunk's corner, and their triangles (2 n,
    3).

    The triangles are counter-clockwise seen from outside.
    """
    n = len(quads)
    corners = np.empty((n, 4, 3), dtype=np.uint8)
    for side in range(6):
        some = np.flatnonzero(quads[:, 0] == side)
        axis, is_far = side // 2, bool(side % 2)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        ones = quads[some]
        for number, (far_u, far_v) in enumerate(_CORNERS[is_far]):
            place = ones[:, 1:4].copy()
            place[:, axis] += is_far
            place[:, u] += ones[:, 4] * np.uint8(far_u)
            place[:, v] += ones[:, 5] * np.uint8(far_v)
            corners[some, number] = place
    faces = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32) + 4 * np.arange(n, dtype=np.uint32)[:, None, None]
    return corners.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32)


def first_face(
    volume: OccupancyVolume, rule: FaceRule, origin: ArrayLike, direction: ArrayLike
) -> tuple[int, int, int] | None:
    """Return the key of the voxel whose drawn face a ray from ``origin`` (3,) along ``direction`` (3,) hits first.

    Metres; None if there is none. Faces omitted by the rule do not stop the ray.
    """
    corners = volume.blocks.corners
    away = np.asarray(direction, dtype=np.float64)
    start = np.asarray(origin, dtype=np.float64) / volume.config.resolution + CENTRE  # in voxels
    if not len(corners) or not np.isfinite(start).all() or not np.isfinite(away).all() or not away.any():
        return None
    low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + BLOCK + 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([(low - start) / away, (high - start) / away]), axis=0)
    ends = np.where(away == 0.0, np.where((start >= low) & (start <= high), [[-np.inf], [np.inf]], np.nan), ends)
    begin, end = max(float(ends[0].max()), 0.0), float(ends[1].min())
    if not begin < end:
        return None
    # The ray's positions halfway between two voxel borders, each in a different voxel.
    borders = [np.array([begin, end])]
    for axis in range(3):
        if away[axis] != 0.0:
            a, b = sorted((start[axis] + begin * away[axis], start[axis] + end * away[axis]))
            borders.append((np.arange(np.ceil(a), np.floor(b) + 1.0) - start[axis]) / away[axis])
    places = np.sort(np.concatenate(borders))
    middles = 0.5 * (places[1:] + places[:-1])
    keys = np.floor(start + middles[:, None] * away).astype(np.int64)
    keys = keys[((keys >= 0) & (keys < KEYS)).all(axis=1)]
    values = volume.log_odds_of(keys)
    shown = ((keys >= rule.first) & (keys <= rule.last)).all(axis=1)
    drawn = shown & (values >= rule.occupied)
    is_open = ~drawn & (~shown | ~np.isnan(values) | (not rule.seen_only))
    met = np.flatnonzero(drawn & np.append(True, is_open[:-1])) if len(keys) else drawn
    if not len(met):
        return None
    x, y, z = keys[met[0]].tolist()
    return x, y, z


_NORMALS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]], dtype=np.float32)


def voxel_mesh(volume: OccupancyVolume) -> Mesh:
    """Return the faces between occupied and other voxels, merged into rectangles of two triangles each.

    Each rectangle has four vertices of its own with the normal of its side.
    """
    rule = face_rule(volume, -np.inf, np.inf, base=0.0, band=1e9, colours=1)
    faces = VoxelFaces()
    faces.update(volume, rule, chunks_of(volume))
    vertices, normals = [np.empty((0, 3), np.float32)], [np.empty((0, 3), np.float32)]
    triangles, n = [np.empty((0, 3), np.int32)], 0
    for key, quads in faces.chunks.items():
        corners, indices = triangles_of(quads)
        place = (corners + (np.array(key) * CHUNK - CENTRE)) * volume.config.resolution
        vertices.append(place.astype(np.float32))
        normals.append(np.repeat(_NORMALS[quads[:, 0]], 4, axis=0))
        triangles.append(indices.astype(np.int32) + n)
        n += len(corners)
    return Mesh(np.concatenate(vertices), np.concatenate(normals), np.concatenate(triangles))
