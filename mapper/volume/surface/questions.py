"""Updates of one voxel of a surface by each scan, and the surface hit by a line of sight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.errors import WorkCancelledError
from mapper.volume.blocks import BLOCK, KEYS
from mapper.volume.occupancy.volume import centres_of
from mapper.volume.surface.parameters import TsdfConfig
from mapper.volume.surface.replayed import MeasuredScans, ReplayedSurface
from mapper.volume.surface.tsdf import CENTRE, TsdfVolume

_AROUND = 2  # pixels around the one in which the voxel is seen that are fused with it
_SAMPLES = 1 << 16  # along a line of sight


@dataclass(frozen=True, slots=True)
class SurfaceUpdate:
    """Update of a voxel of a surface by scan ``scan``, counted from 0.

    The scan ``measured`` this signed distance, metres, truncated, with ``added`` weight. The voxel had the mean
    ``before``, None if it was unknown, and has ``after`` with the weight ``weight``. ``origin`` (3,) is the position of
    the sensor, metres.
    """

    scan: int
    measured: float
    added: float
    before: float | None
    after: float
    weight: float
    origin: Float64Array


def why_surface(
    now: ReplayedSurface, key: Int64Array, may_continue: Callable[[], bool] = lambda: True
) -> list[SurfaceUpdate]:
    """Return the updates of the voxel with ``key`` (3,) by the scans of a surface, omitting scans that did not measure
    it.

    The last distance and weight are those of the surface. Raises :class:`WorkCancelledError` between two scans unless
    ``may_continue``.
    """
    code, at = _place(key)
    slot = int(now.volume.blocks.find(np.array([code]))[0])
    if slot < 0:
        return []
    first = next(k for k, count in enumerate(now.counts) if count > slot)
    # A block of distances without weight: each scan measures as if it were the first.
    empty = np.zeros((1, BLOCK, BLOCK, BLOCK), dtype=np.float32)
    distance, weight = np.float32(0.0), np.float32(0.0)
    updates = []
    for scan in range(first, now.index):
        if not may_continue():
            raise WorkCancelledError("tsdf.cancelled", "Asking why a voxel is so was cancelled.")
        near = _near_voxel(now.source, now.config, scan, key)
        if near is None:
            continue
        part, origin = near
        measured, added = _fused(now.config, code, at, empty, empty, part)
        if added == 0.0:
            continue
        held, sure = empty.copy(), empty.copy()
        held[0][at], sure[0][at] = distance, weight
        before = float(distance) if weight > 0.0 else None
        distance, weight = _fused(now.config, code, at, held, sure, part)
        updates.append(
            SurfaceUpdate(scan, float(measured), float(added), before, float(distance), float(weight), origin)
        )
    return updates


def _place(key: Int64Array) -> tuple[int, tuple[int, int, int]]:
    """Return the code of a voxel's block and its position in the block, z y x."""
    x, y, z = (int(k) for k in key // BLOCK)
    i, j, k = (int(index) for index in key % BLOCK)
    return z << 26 | y << 13 | x, (k, j, i)


Part = Callable[[TsdfVolume], object]


def _near_voxel(
    source: MeasuredScans, config: TsdfConfig, scan: int, key: Int64Array
) -> tuple[Part, Float64Array] | None:
    """Return a function that fuses the part of a scan that may measure a voxel, and the sensor position (3,).

    None if no part does.
    """
    place = centres_of(key[None], config.resolution)[0].astype(np.float64)
    image = source.depth_image(scan)
    if image is None:
        placed = source.scan(scan)
        points, origin = placed.points, np.asarray(placed.origin)
        away = points - origin
        share = np.maximum((place - origin) @ away.T / np.maximum((away * away).sum(axis=1), 1e-12), 0.0)
        # A voxel's corners are 0.87 of its side from its centre.
        near = np.linalg.norm(share[:, None] * away - (place - origin), axis=1) <= 0.9 * config.resolution
        return (lambda volume: volume.fuse_points(points[near], origin), origin) if near.any() else None
    pose, camera = image.pose, image.camera
    x, y, z = pose[:3, :3].T @ (place - pose[:3, 3])
    if z <= 0.0:
        return None
    col, row = round(camera.fx * x / z + camera.cx), round(camera.fy * y / z + camera.cy)
    rows = slice(max(row - _AROUND, 0), max(row + _AROUND + 1, 0))
    cols = slice(max(col - _AROUND, 0), max(col + _AROUND + 1, 0))
    part = np.zeros_like(image.depth)
    part[rows, cols] = image.depth[rows, cols]
    return (lambda volume: volume.fuse_depth(part, camera, pose), pose[:3, 3]) if part.any() else None


def _fused(
    config: TsdfConfig, code: int, at: tuple[int, int, int], distances: Float32Array, weights: Float32Array, part: Part
) -> tuple[np.float32, np.float32]:
    """Return the distance and weight of a voxel of the block ``code`` after ``part`` of a scan."""
    volume = TsdfVolume(config)
    volume.set_blocks(np.array([code]), distances, weights)
    part(volume)
    return volume.distances[0][at], volume.weights[0][at]


def first_surface(volume: TsdfVolume, origin: ArrayLike, direction: ArrayLike) -> Float64Array | None:
    """Return the point at which a line of sight (3,) from ``origin`` (3,), metres, hits a surface from outside, or
    None.

    The distances are sampled at every half voxel, and the zero is interpolated linearly between two samples.
    """
    start, along = np.asarray(origin, dtype=np.float64), np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(along))
    if not volume.blocks.count or not (np.isfinite(start).all() and np.isfinite(along).all() and length > 0.0):
        return None
    along = along / length
    resolution, corners = volume.config.resolution, volume.blocks.corners
    low, high = ((corners.min(axis=0) - CENTRE) * resolution, (corners.max(axis=0) + BLOCK - CENTRE) * resolution)
    with np.errstate(divide="ignore", invalid="ignore"):
        borders = np.sort(np.stack([(low - start) / along, (high - start) / along]), axis=0)
    first, last = max(float(np.nanmax(borders[0])), 0.0), float(np.nanmin(borders[1]))
    if last <= first:
        return None
    t = np.linspace(first, last, int(min(np.ceil((last - first) / (0.5 * resolution)) + 1, _SAMPLES)))
    keys = np.clip(np.floor((start + t[:, None] * along) / resolution).astype(np.int64) + CENTRE, 0, KEYS - 1)
    blocks = keys // BLOCK
    slots = volume.blocks.find(blocks[:, 2] << 26 | blocks[:, 1] << 13 | blocks[:, 0])
    x, y, z = (keys % BLOCK).T
    known = (slots >= 0) & (volume.weights[slots, z, y, x] > 0.0)
    values = np.where(known, volume.distances[slots, z, y, x], np.nan)
    crossings = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    if not len(crossings):
        return None
    k = int(crossings[0])
    share = values[k] / (values[k] - values[k + 1])
    place: Float64Array = start + (t[k] + share * (t[k + 1] - t[k])) * along
    return place
