"""Truncated signed distances as in the papers: all voxels at once for an image, one by one along a beam.

Voxels are identified by keys as in :mod:`mapper.volume.occupancy.textbook`. Image computations are in float32, as in
the kernel, so that voxels project to the same pixels.

Source: Curless & Levoy, A volumetric method for building complex models from range images, SIGGRAPH 1996, section 3;
Newcombe et al., KinectFusion, ISMAR 2011, section 3.3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.sensors.camera import Intrinsics
from mapper.volume.occupancy.textbook import CENTRE, Key
from mapper.volume.surface.parameters import TsdfConfig

Surface = dict[Key, tuple[np.float32, np.float32]]  #: distance, metres, and weight of known voxels


def pixels_of(
    keys: Int64Array, camera: Intrinsics, pose: Float64Array, resolution: float
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """Return the columns, rows and depths (n,) of voxels' centres in an image.

    The first voxel of a block of 8³ is computed in float64, the others relative to it in float32, as in the kernel.
    """
    project = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]) @ pose[:3, :3].T
    first = keys // 8 * 8
    place = ((first - CENTRE + 0.5) * resolution - pose[:3, 3]) @ project.T
    beside = (keys - first) @ project.T * resolution
    u, v, z = (place.astype(np.float32) + beside.astype(np.float32)).T
    inverse = np.float32(1.0) / z
    return u * inverse, v * inverse, z


def fuse_depth(
    keys: Int64Array, distances: Float32Array, weights: Float32Array, depth: Float32Array, camera: Intrinsics,
    pose: Float64Array, config: TsdfConfig,
) -> None:  # fmt: skip
    """Update the distances (n,) and weights (n,) of voxels by a depth image (height, width), metres.

    ``pose`` (4, 4) is ``T_map_camera``. A voxel's distance is the depth of the pixel of its centre minus its own depth.
    If it is greater than the truncation, the voxel is updated as free if ``config.carve`` is set and its block of 8³
    has a voxel within the truncation of this surface or a known one.
    """
    band = config.band
    with np.errstate(all="ignore"):
        u, v, z = pixels_of(keys, camera, pose, config.resolution)
        seen = (z > 0) & (u >= -0.5) & (u < camera.width - 0.5) & (v >= -0.5) & (v < camera.height - 0.5)
        col, row = (np.where(seen, place, 0).astype(np.float32) + np.float32(0.5) for place in (u, v))
        d = depth[row.astype(int), col.astype(int)]
        distance = d - z
        update = seen & (d > 0) & (d <= config.far) & (distance > -band)
        near = update & (distance <= band)
        blocks = keys // 8 @ np.array([1, 1 << 13, 1 << 26])
        update = near | (update & config.carve & np.isin(blocks, blocks[near | (weights > 0)]))
        weight = weight_of(distance, np.float32(1.0) / z, config)
        mean = (weights * distances + weight * np.minimum(distance, band)) / (weights + weight)
    distances[update] = mean[update]
    weights[update] = np.minimum(weights + weight, np.float32(config.max_weight))[update]


def weight_of(distance: Float32Array, inverse_depth: Float32Array, config: TsdfConfig) -> Float32Array:
    """Return the weight (n,) of measurements at signed distances (n,), metres, at 1 / depth (n,)."""
    band, unit = config.band, np.float32(1.0)
    weight = inverse_depth * inverse_depth if config.weighting == "inverse_square" else np.ones_like(inverse_depth)
    if not config.drop_off:
        return weight
    near = np.float32(min(config.resolution, 0.5 * float(band)))
    return np.where(distance < -near, weight * ((band + distance) * (unit / (band - near))), weight)


def fuse_points(surface: Surface, points: Float64Array, origin: Float64Array, config: TsdfConfig) -> None:
    """Update a map by the points (n, 3) measured by a sensor at ``origin`` (3,), metres, beam by beam.

    A voxel passed by a beam gets its distance to the beam's end along the beam; beyond the truncation as in
    :func:`fuse_depth`, with the blocks of all these beams.
    """
    blocks = {(x // 8, y // 8, z // 8) for x, y, z in surface}
    for is_update in (False, True):  # the blocks come first
        for key, distance, length in passed_voxels(points, origin, config):
            block = key[0] // 8, key[1] // 8, key[2] // 8
            if not is_update:
                blocks |= {block} if distance <= config.band else set()
            elif distance <= config.band or (config.carve and block in blocks):
                update(surface, key, distance, length, config)


def update(surface: Surface, key: Key, distance: float, length: float, config: TsdfConfig) -> None:
    """Update a voxel by one measurement at a signed distance, for a beam of a length, metres."""
    band = float(config.band)
    old, sure = surface.get(key, (np.float32(0.0), np.float32(0.0)))
    base = 1.0 / (length * length) if config.weighting == "inverse_square" else 1.0
    near = float(np.float32(min(config.resolution, 0.5 * band)))
    weight = base * (band + distance) / (band - near) if config.drop_off and distance < -near else base
    mean = (float(sure) * float(old) + weight * min(distance, band)) / (float(sure) + weight)
    surface[key] = np.float32(mean), np.float32(min(float(sure) + weight, config.max_weight))


def passed_voxels(points: Float64Array, origin: Float64Array, config: TsdfConfig) -> Iterator[tuple[Key, float, float]]:
    """Yield the voxels that beams pass, with their signed distance and the beam's length, metres.

    They start at the sensor if ``config.carve``, else before the end, and stop behind the end at the truncation.
    """
    band, resolution = float(config.band), config.resolution
    start = origin / resolution + CENTRE - 0.5  # in keys: the centre of the voxel of key k is at k
    for point in points:
        end = point / resolution + CENTRE - 0.5
        along = end - start
        length = math.sqrt(dot(along, along)) * resolution
        if not 0.0 < length <= config.far:
            continue
        first, last = 0.0 if config.carve else max(1.0 - band / length, 0.0), 1.0 + band / length
        for key in voxels_along(start + first * along, (last - first) * along):
            distance = dot(end - np.array(key), along) * resolution * resolution / length
            if distance > -band:
                yield key, distance, length


def dot(a: Float64Array, b: Float64Array) -> float:
    """Return the scalar product of two vectors (3,), summed in order."""
    return float(a[0]) * float(b[0]) + float(a[1]) * float(b[1]) + float(a[2]) * float(b[2])


def voxels_along(start: Float64Array, line: Float64Array) -> list[Key]:
    """Return the voxels passed by ``line`` (3,) from ``start`` (3,), in keys, in order.

    Source: Amanatides & Woo, A fast voxel traversal algorithm for ray tracing, 1987.
    """
    key = [math.floor(c + 0.5) for c in start]
    steps, first, apart = [0, 0, 0], [math.inf] * 3, [math.inf] * 3
    for axis in range(3):
        along = float(line[axis])
        if along != 0.0:
            steps[axis] = 1 if along > 0.0 else -1
            first[axis] = (key[axis] + 0.5 * steps[axis] - float(start[axis])) / along
            apart[axis] = abs(1.0 / along)
    voxels = []
    while True:
        voxels.append((key[0], key[1], key[2]))
        axis = min(range(3), key=lambda k: first[k])
        if first[axis] > 1.0:
            return voxels
        key[axis] += steps[axis]
        first[axis] += apart[axis]
